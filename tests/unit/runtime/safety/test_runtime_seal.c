/* runtime/platform/seal: a process that is sealed tries what a game must not do. Each test seals a child of its own. */
#include "fixtures.h"

#include "platform/seal.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[64], inside[100], outside[100], written[100];

static void put(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("text", file);
    fclose(file);
}

static int begin(void **unused)
{
    (void)unused;
    seal_ability has = seal_look();
    if (has.obstacle || !has.landlock || !has.seccomp) {
        print_message("skipped: %s\n", has.obstacle ? has.obstacle : "this system has no Landlock or no seccomp");
        return -1;
    }
    snprintf(folder, sizeof folder, "/tmp/daft-seal-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(inside, sizeof inside, "%s/game", folder);
    snprintf(written, sizeof written, "%s/out", folder);
    snprintf(outside, sizeof outside, "%s/secret", folder);
    mkdir(inside, 0777);
    mkdir(written, 0777);
    put(outside);
    char file[160];
    snprintf(file, sizeof file, "%s/main.lua", inside);
    put(file);
    snprintf(file, sizeof file, "%s/old", written);
    put(file);
    return 0;
}

static int end(void **unused)
{
    (void)unused;
    char command[100];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

/* Runs `what` sealed, in a child; it returns the line that failed, or 0. */
static void run_sealed(int (*what)(void))
{
    pid_t child = fork();
    if (child == 0) {
        daft_error error;
        seal_def def = {.readable = {inside, "/no/such/folder"}, .writable = {written}};
        if (!seal_process(&def, &error)) _exit(1);
        int line = what();
        if (line) fprintf(stderr, "%s:%d: not so; errno %d, %s\n", __FILE__, line, errno, strerror(errno));
        _exit(line ? 2 : 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

#define EXPECT(condition)                                                                                              \
    if (!(condition)) return __LINE__
#define REFUSED(call) EXPECT((call) < 0 && (errno == EPERM || errno == EACCES))

static int open_in(const char *in, const char *name, int flags)
{
    char path[200];
    snprintf(path, sizeof path, "%s/%s", in, name);
    return open(path, flags, 0666);
}

static int try_files(void)
{
    REFUSED(open(outside, O_RDONLY));
    REFUSED(open("/etc/passwd", O_RDONLY));
    REFUSED(open("/", O_RDONLY | O_DIRECTORY));
    REFUSED(open("/proc/self/mem", O_RDWR));
    REFUSED(open(outside, O_WRONLY | O_TRUNC));
    REFUSED(truncate(outside, 0));
    REFUSED(unlink(outside));
    REFUSED(open_in(inside, "main.lua", O_WRONLY));
    REFUSED(open_in(inside, "new", O_WRONLY | O_CREAT));
    REFUSED(open_in(written, "old", O_RDONLY));
    REFUSED(mkdir("/tmp/daft-no", 0777));
    REFUSED(symlink("/etc", "/tmp/daft-no"));
    EXPECT(open_in(inside, "main.lua", O_RDONLY) >= 0);
    return 0;
}

static int try_writing(void)
{
    char path[200];
    daft_error error;
    snprintf(path, sizeof path, "%s/old", written);
    EXPECT(daft_write_file(path, "newer", 5, &error));
    snprintf(path, sizeof path, "%s/fresh", written);
    EXPECT(daft_write_file(path, "fresh", 5, &error));
    snprintf(path, sizeof path, "%s/fresh", inside);
    EXPECT(!daft_write_file(path, "fresh", 5, &error));
    return 0;
}

static int try_network(void)
{
    REFUSED(socket(AF_INET, SOCK_STREAM, 0));
    REFUSED(socket(AF_INET6, SOCK_DGRAM, 0));
    REFUSED(socket(AF_UNIX, SOCK_STREAM, 0));
    return 0;
}

static int try_processes(void)
{
    char *const arguments[] = {"/bin/true", NULL};
    REFUSED(execv("/bin/true", arguments));
    REFUSED(fork());
    REFUSED(vfork());
    REFUSED(kill(getppid(), 0));
    REFUSED(kill(-1, 0));
    REFUSED(ptrace(PTRACE_TRACEME, 0, NULL, NULL));
    REFUSED(ioctl(0, TIOCSTI, "x"));
    REFUSED(chroot("/"));
    EXPECT(kill(getpid(), 0) == 0);
    return 0;
}

static void *return_it(void *it) { return it; }
static void *open_outside(void *unused)
{
    (void)unused;
    return open(outside, O_RDONLY) < 0 && socket(AF_UNIX, SOCK_STREAM, 0) < 0 ? outside : NULL;
}

/* What the engine needs: memory, threads, signals to them, the clock. */
static int try_what_games_need(void)
{
    pthread_t thread;
    void *result;
    EXPECT(pthread_create(&thread, NULL, return_it, outside) == 0);
    pthread_kill(thread, 0);
    EXPECT(pthread_join(thread, &result) == 0 && result == outside);
    EXPECT(pthread_create(&thread, NULL, open_outside, NULL) == 0);
    EXPECT(pthread_join(thread, &result) == 0 && result == outside);
    EXPECT(mmap(NULL, 1 << 24, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED);
    EXPECT(raise(0) == 0);
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 3;
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_scene *scene = engine ? daft_scene_create(engine, &error) : NULL;
    daft_image *picture = scene ? daft_image_create(engine, 64, 36, &error) : NULL;
    EXPECT(picture);
    daft_view view = daft_default_view();
    EXPECT(daft_render(scene, &view, picture, &error));
    return 0;
}

static void files_are_sealed(void **unused) { (void)unused, run_sealed(try_files); }
static void writing_goes_where_it_may(void **unused) { (void)unused, run_sealed(try_writing); }
static void there_is_no_network(void **unused) { (void)unused, run_sealed(try_network); }
static void there_are_no_other_processes(void **unused) { (void)unused, run_sealed(try_processes); }
static void games_have_what_they_need(void **unused) { (void)unused, run_sealed(try_what_games_need); }

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(files_are_sealed), cmocka_unit_test(writing_goes_where_it_may),
                                       cmocka_unit_test(there_is_no_network),
                                       cmocka_unit_test(there_are_no_other_processes),
                                       cmocka_unit_test(games_have_what_they_need)};
    void *none = NULL;
    if (begin(&none) != 0) return 77;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    end(&none);
    return failed;
}
