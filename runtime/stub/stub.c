/* A game's own program: finds the archive behind itself, unpacks it into the user's cache and becomes the program that
 * lies there. Where the cache cannot be written or is full, it unpacks into a temporary folder, and removes that when
 * the game is over. */
#include "stub/format.h"

#include "common/util.h"
#include "files/home.h"
#include "files/pack.h"
#include "stub/unpack.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct packed {
    const uint8_t *bytes; /* of the file, mapped */
    size_t size;
    char hash[SHA256_TEXT]; /* as the file says */
    pack *files;
    bool checked;
    char **arguments; /* argv */
    int count;
} packed;

/* ---- the archive ---- */

/* Systems without /proc tell by which name this program was started. */
static int open_file(void)
{
    const char *name = (const char *)getauxval(AT_EXECFN);
    const int file = open("/proc/self/exe", O_RDONLY | O_CLOEXEC);
    return file < 0 && name ? open(name, O_RDONLY | O_CLOEXEC) : file;
}

/* A program that runs cannot be written to, so its bytes stay. */
static bool map_self(packed *self, daft_error *error)
{
    struct stat status;
    const int file = open_file();
    bool good = file >= 0 && fstat(file, &status) == 0;
    void *bytes = good ? mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_PRIVATE, file, 0) : MAP_FAILED;
    good = bytes != MAP_FAILED || fail(error, DAFT_ERROR_IO, "cannot read itself: %s", strerror(errno));
    if (good) self->bytes = bytes, self->size = (size_t)status.st_size;
    if (file >= 0) close(file);
    return good;
}

static bool open_self(packed *self, daft_error *error)
{
    if (!map_self(self, error)) return false;
    const uint8_t *comment = self->size > STUB_COMMENT ? self->bytes + self->size - STUB_COMMENT : NULL;
    if (!comment || memcmp(comment, STUB_MARK, strlen(STUB_MARK)) != 0)
        return fail(error, DAFT_ERROR_SYNTAX, "this file is not whole: get it once more");
    memcpy(self->hash, comment + strlen(STUB_MARK), STUB_DIGITS);
    if (strspn(self->hash, "0123456789abcdef") != STUB_DIGITS)
        return fail(error, DAFT_ERROR_SYNTAX, "this file is damaged: get it once more");
    self->files = pack_open(self->bytes, self->size, self->arguments[0], error);
    return self->files != NULL;
}

/* Before anything is unpacked. */
static bool check(packed *self, daft_error *error)
{
    enum { END = 22 }; /* the archive's end record without its comment */
    char found[SHA256_TEXT];
    sha256 hash;
    if (self->checked) return true;
    sha256_begin(&hash);
    sha256_add(&hash, self->bytes, self->size - STUB_COMMENT - END);
    sha256_end(&hash, found);
    self->checked = strcmp(found, self->hash) == 0;
    return self->checked || fail(error, DAFT_ERROR_SYNTAX, "this file is damaged: get it once more");
}

static const char *find_game(const packed *self)
{
    for (size_t i = 0; i < pack_count(self->files); i++) {
        const pack_file file = pack_file_at(self->files, i);
        if (strncmp(file.name, STUB_GAMES, strlen(STUB_GAMES)) == 0) return file.name;
    }
    return STUB_GAMES;
}

/* ---- the program ---- */

static void set_environment(const char *folder)
{
    char libraries[4 * PATH_SIZE];
    const char *before = getenv("LD_LIBRARY_PATH");
    const bool some = before && before[0];
    snprintf(libraries, sizeof libraries, "%s/" STUB_LIBRARIES "%s%s", folder, some ? ":" : "", some ? before : "");
    setenv(STUB_LIBRARY_PATH, before ? before : "", 1); /* for what the program starts itself */
    setenv("LD_LIBRARY_PATH", libraries, 1);
    setenv(STUB_HOME, folder, 1);
}

/* Comes back only where it fails. */
static void become(const packed *self, const char *folder, daft_error *error)
{
    char program[2 * PATH_SIZE], game[2 * PATH_SIZE], play[] = "play";
    char **arguments = calloc((size_t)self->count + 3, sizeof *arguments);
    path_join(program, sizeof program, folder, STUB_PROGRAM);
    path_join(game, sizeof game, folder, find_game(self));
    if (arguments) {
        arguments[0] = self->arguments[0], arguments[1] = play, arguments[2] = game;
        for (int i = 1; i < self->count; i++) arguments[i + 2] = self->arguments[i];
        set_environment(folder);
        execv(program, arguments);
    }
    fail(error, DAFT_ERROR_IO, "%s: cannot be started: %s", program, strerror(errno));
    free(arguments);
}

static bool run_from_cache(packed *self, daft_error *error)
{
    char top[PATH_SIZE], folder[2 * PATH_SIZE];
    if (!home_user_folder("XDG_CACHE_HOME", ".cache", top, sizeof top))
        return fail(error, DAFT_ERROR_IO, "there is no folder for a cache: set XDG_CACHE_HOME or HOME");
    const bool there = unpack_is_there(self->files, top, self->hash);
    if (!there && (!check(self, error) || !unpack_once(self->files, top, self->hash, error))) return false;
    path_join(folder, sizeof folder, top, self->hash);
    become(self, folder, error);
    return false;
}

/* ---- without a cache ---- */

static volatile sig_atomic_t child;

static void pass_on(int number)
{
    if (child > 0) kill((pid_t)child, number);
}

/* The exit status of the game; what stops this process stops the game. */
static int wait_for(pid_t process)
{
    static const int PASSED[] = {SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2};
    struct sigaction action = {.sa_handler = pass_on};
    int status = 0;
    child = process;
    signal(SIGINT, SIG_IGN); /* the terminal tells both */
    for (size_t i = 0; i < COUNT_OF(PASSED); i++) sigaction(PASSED[i], &action, NULL);
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static bool run_from(packed *self, const char *top, int *status, daft_error *error)
{
    char folder[PATH_SIZE];
    if (top[0] != '/' || !path_join(folder, sizeof folder, top, "daft-XXXXXX") || !mkdtemp(folder))
        return fail(error, DAFT_ERROR_IO, "%s: %s", top, strerror(errno));
    bool good = unpack_into(self->files, folder, error);
    const pid_t process = good ? fork() : -1;
    if (process == 0) {
        become(self, folder, error);
        fprintf(stderr, "%s: %s\n", self->arguments[0], error->message);
        _exit(STATUS_BAD_INPUT);
    }
    if (good && process < 0) good = fail(error, DAFT_ERROR_IO, "no process can be started: %s", strerror(errno));
    if (good) *status = wait_for(process);
    unpack_remove(folder);
    return good;
}

/* `error`: why the cache did not do; it stays if nothing does. */
static bool run_from_temporary(packed *self, int *status, daft_error *error)
{
    const char *const tops[] = {getenv("XDG_RUNTIME_DIR"), getenv("TMPDIR"), "/tmp", "/var/tmp", "/dev/shm"};
    daft_error ignored;
    if (!check(self, error)) return false;
    for (size_t i = 0; i < COUNT_OF(tops); i++)
        if (tops[i] && run_from(self, tops[i], status, &ignored)) return true;
    return false;
}

int main(int argc, char **argv)
{
    char none[] = "game", *nothing[] = {none, NULL};
    daft_error error;
    packed self = {.arguments = argc > 0 ? argv : nothing, .count = argc > 0 ? argc : 1};
    int status = STATUS_BAD_INPUT;
    const bool good =
        open_self(&self, &error) && (run_from_cache(&self, &error) || run_from_temporary(&self, &status, &error));
    if (!good) fprintf(stderr, "%s: %s\n", self.arguments[0], error.message);
    pack_close(self.files);
    return status;
}
