/* What every input is held to, whatever it is: it takes seconds and no longer, and opens nothing outside its folder.
 *
 * The program's open(), openat(), fopen() and syscall() stand before the system's, for it and for the libraries it
 * loads. What was really opened is asked of /proc, so neither links nor ".." hide it; on other systems nothing is
 * checked. */
#include "fuzz.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static bool sealed;
static char roots[3][PATH_MAX];

#ifdef __linux__
static bool is_below(const char *path, const char *folder)
{
    size_t length = strlen(folder);
    return length > 0 && strncmp(path, folder, length) == 0 && (path[length] == '/' || path[length] == 0);
}

/* What libFuzzer writes about an input, after it has broken something. */
static bool is_report(const char *path)
{
    return strstr(path, "/crash-") || strstr(path, "/timeout-") || strstr(path, "/leak-") || strstr(path, "/oom-");
}

static void check_opened(int file)
{
    char link[64], path[PATH_MAX];
    if (!sealed || file < 0) return;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0) return;
    path[length] = 0;
    for (size_t i = 0; i < sizeof roots / sizeof roots[0]; i++)
        if (is_below(path, roots[i]) || is_report(path)) return;
    fprintf(stderr, "opened outside its folder: %s\n", path);
    abort();
}

static int open_checked(int folder, const char *path, int flags, va_list arguments)
{
    bool makes = (flags & O_CREAT) || (flags & O_TMPFILE) == O_TMPFILE;
    mode_t mode = makes ? va_arg(arguments, mode_t) : 0;
    int file = (int)syscall(SYS_openat, folder, path, flags, mode);
    check_opened(file);
    return file;
}

#define OPEN(name)                                                                                                     \
    __attribute__((visibility("default"))) int name(const char *path, int flags, ...)                                  \
    {                                                                                                                  \
        va_list arguments;                                                                                             \
        va_start(arguments, flags);                                                                                    \
        int file = open_checked(AT_FDCWD, path, flags, arguments);                                                     \
        va_end(arguments);                                                                                             \
        return file;                                                                                                   \
    }
#define OPEN_AT(name)                                                                                                  \
    __attribute__((visibility("default"))) int name(int folder, const char *path, int flags, ...)                      \
    {                                                                                                                  \
        va_list arguments;                                                                                             \
        va_start(arguments, flags);                                                                                    \
        int file = open_checked(folder, path, flags, arguments);                                                       \
        va_end(arguments);                                                                                             \
        return file;                                                                                                   \
    }
#define OPEN_STREAM(name)                                                                                              \
    __attribute__((visibility("default"))) FILE *name(const char *path, const char *mode)                              \
    {                                                                                                                  \
        FILE *(*real)(const char *, const char *);                                                                     \
        void *symbol = dlsym(RTLD_NEXT, #name);                                                                        \
        memcpy(&real, &symbol, sizeof real);                                                                           \
        FILE *file = real(path, mode);                                                                                 \
        if (file) check_opened(fileno(file));                                                                          \
        return file;                                                                                                   \
    }
/* The loader asks the kernel for openat2 by its number. All six arguments are handed on, whether or not they were
 * given, which sanitizers would not let pass. */
__attribute__((visibility("default"), no_sanitize("address", "undefined"))) long syscall(long number, ...)
{
    long a[6], (*real)(long, ...);
    va_list arguments;
    va_start(arguments, number);
    for (int i = 0; i < 6; i++) a[i] = va_arg(arguments, long);
    va_end(arguments);
    void *symbol = dlsym(RTLD_NEXT, "syscall");
    memcpy(&real, &symbol, sizeof real);
    long result = real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
#ifdef SYS_openat2
    if (number == SYS_openat2) check_opened((int)result);
#endif
    return result;
}

OPEN(open)
OPEN(open64)
OPEN_AT(openat)
OPEN_AT(openat64)
OPEN_STREAM(fopen)
OPEN_STREAM(fopen64)

#endif

static void find_roots(void)
{
    char path[PATH_MAX];
    if (roots[0][0]) return;
    FUZZ_CHECK(realpath(fuzz_folder(), roots[0]));
    snprintf(path, sizeof path, "%s/assets", fuzz_root());
    FUZZ_CHECK(realpath(path, roots[1]));
    snprintf(path, sizeof path, "%s/scripts", fuzz_root());
    FUZZ_CHECK(realpath(path, roots[2]));
}

static double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int fuzz_run(const fuzz_target *target, const uint8_t *data, size_t size)
{
    find_roots();
    sealed = target->sealed;
    double begun = cpu_seconds();
    int result = target->input(data, size);
    sealed = false;
    double took = cpu_seconds() - begun;
    if (took > target->seconds) {
        fprintf(stderr, "%s: an input of %zu bytes takes %.1f s of the processor; the limit is %g\n", target->name,
                size, took, target->seconds);
        abort();
    }
    return result;
}
