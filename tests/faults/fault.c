/* A library to preload: it makes one call into the C library fail on purpose.
 *
 *   DAFT_FAULT=KIND:N     the N-th call of that kind fails (from 1)
 *   DAFT_FAULT=KIND:N+    it and all that follow
 *   DAFT_FAULT_FD=FD      one byte is written there when the first fault strikes
 *
 * Kinds: malloc (calloc, realloc, posix_memalign, aligned_alloc and strdup too), open, read, write, rename, fsync,
 * mmap, thread, clock (the monotonic clock jumps an hour ahead), back (an hour back). Calls count from main() on, and
 * not while a library is loaded, as libraries end the process where their constructors find no memory or files. Calls
 * that the C library makes within itself are not seen. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

typedef enum kind { MALLOC, OPEN, READ, WRITE, RENAME, FSYNC, MMAP, THREAD, CLOCK, BACK, KINDS } kind;
static const char *const NAMES[KINDS] = {"malloc", "open", "read",   "write", "rename",
                                         "fsync",  "mmap", "thread", "clock", "back"};

static kind wanted = KINDS;
static long strike_at;
static bool go_on;
static int report_to = -1;
static atomic_long calls;
static atomic_bool struck;
static _Thread_local bool loading; /* a library */

static void report(void)
{
    if (!atomic_exchange(&struck, true) && report_to >= 0) syscall(SYS_write, report_to, "!", 1);
}

/* Whether this call is to fail. */
static bool strikes(kind which)
{
    if (which != wanted || loading) return false;
    long number = atomic_fetch_add(&calls, 1) + 1;
    if (number < strike_at || (number > strike_at && !go_on)) return false;
    report();
    return true;
}

static int fails(int number)
{
    errno = number;
    return -1;
}

/* ---- from main() on ---- */

static void arm(void)
{
    const char *fault = getenv("DAFT_FAULT"), *descriptor = getenv("DAFT_FAULT_FD");
    const char *colon = fault ? strchr(fault, ':') : NULL;
    if (!colon) return;
    char *end;
    strike_at = strtol(colon + 1, &end, 10);
    go_on = *end == '+';
    if (descriptor) report_to = atoi(descriptor);
    for (int i = 0; i < KINDS; i++)
        if (strncmp(fault, NAMES[i], (size_t)(colon - fault)) == 0 && !NAMES[i][colon - fault]) wanted = (kind)i;
}

typedef int main_function(int, char **, char **);
static main_function *program;

static int armed_main(int argc, char **argv, char **environment)
{
    arm();
    return program(argc, argv, environment);
}

static void *next(const char *name)
{
    void *found = dlsym(RTLD_NEXT, name);
    if (!found) abort();
    return found;
}

typedef int start_function(main_function *, int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
int __libc_start_main(main_function *, int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
int __libc_start_main(main_function *start, int argc, char **argv, void (*before)(void), void (*after)(void),
                      void (*loader)(void), void *stack)
{
    program = start;
    return ((start_function *)next("__libc_start_main"))(armed_main, argc, argv, before, after, loader, stack);
}

/* ---- libraries ---- */

void *dlopen(const char *file, int mode)
{
    const bool before = loading;
    loading = true;
    void *library = ((void *(*)(const char *, int))next("dlopen"))(file, mode);
    loading = before;
    return library;
}

/* ---- memory ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *pointer, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static void *no_memory(void)
{
    errno = ENOMEM;
    return NULL;
}

void *malloc(size_t size) { return strikes(MALLOC) ? no_memory() : __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return strikes(MALLOC) ? no_memory() : __libc_calloc(count, size); }
void *aligned_alloc(size_t alignment, size_t size)
{
    return strikes(MALLOC) ? no_memory() : __libc_memalign(alignment, size);
}

void *realloc(void *pointer, size_t size)
{
    return size > 0 && strikes(MALLOC) ? no_memory() : __libc_realloc(pointer, size);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    void *memory = strikes(MALLOC) ? NULL : __libc_memalign(alignment, size);
    if (!memory) return ENOMEM;
    *out = memory;
    return 0;
}

char *strdup(const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, text, size) : NULL;
}

/* ---- files ---- */

static int open_mode(int flags, va_list arguments)
{
    return flags & (O_CREAT | O_TMPFILE) ? va_arg(arguments, int) : 0;
}

#define OPEN_BODY(folder, path, flags)                                                                                 \
    va_list arguments;                                                                                                 \
    va_start(arguments, flags);                                                                                        \
    int mode = open_mode(flags, arguments);                                                                            \
    va_end(arguments);                                                                                                 \
    return strikes(OPEN) ? fails(EMFILE) : (int)syscall(SYS_openat, folder, path, flags, mode)

int open(const char *path, int flags, ...) { OPEN_BODY(AT_FDCWD, path, flags); }
int open64(const char *path, int flags, ...) { OPEN_BODY(AT_FDCWD, path, flags); }
int openat(int folder, const char *path, int flags, ...) { OPEN_BODY(folder, path, flags); }
int openat64(int folder, const char *path, int flags, ...) { OPEN_BODY(folder, path, flags); }

FILE *fopen(const char *path, const char *mode)
{
    typedef FILE *function(const char *, const char *);
    if (!strikes(OPEN)) return ((function *)next("fopen"))(path, mode);
    errno = EMFILE;
    return NULL;
}

ssize_t read(int file, void *bytes, size_t size)
{
    return strikes(READ) ? fails(EIO) : syscall(SYS_read, file, bytes, size);
}

ssize_t pread(int file, void *bytes, size_t size, off_t offset)
{
    return strikes(READ) ? fails(EIO) : syscall(SYS_pread64, file, bytes, size, offset);
}

ssize_t write(int file, const void *bytes, size_t size)
{
    return strikes(WRITE) ? fails(ENOSPC) : syscall(SYS_write, file, bytes, size);
}

ssize_t pwrite(int file, const void *bytes, size_t size, off_t offset)
{
    return strikes(WRITE) ? fails(ENOSPC) : syscall(SYS_pwrite64, file, bytes, size, offset);
}

int rename(const char *from, const char *to)
{
    return strikes(RENAME) ? fails(EIO) : (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int renameat(int from_folder, const char *from, int to_folder, const char *to)
{
    return strikes(RENAME) ? fails(EIO) : (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, 0);
}

int fsync(int file) { return strikes(FSYNC) ? fails(EIO) : (int)syscall(SYS_fsync, file); }

void *mmap(void *where, size_t size, int protection, int flags, int file, off_t offset)
{
    if (!strikes(MMAP)) return (void *)syscall(SYS_mmap, where, size, protection, flags, file, offset);
    errno = ENOMEM;
    return MAP_FAILED;
}

/* ---- threads and time ---- */

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument)
{
    typedef int function(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    if (strikes(THREAD)) return EAGAIN;
    return ((function *)next("pthread_create"))(thread, attributes, start, argument);
}

int clock_gettime(clockid_t which, struct timespec *now)
{
    typedef int function(clockid_t, struct timespec *);
    static _Atomic(function *) real;
    if (!real) real = (function *)next("clock_gettime");
    int status = real(which, now);
    if (which != CLOCK_MONOTONIC || (wanted != CLOCK && wanted != BACK)) return status;
    if (atomic_fetch_add(&calls, 1) + 1 < strike_at) return status;
    report();
    now->tv_sec += wanted == CLOCK ? 3600 : now->tv_sec > 3600 ? -3600 : -now->tv_sec;
    return status;
}
