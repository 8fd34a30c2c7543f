/* The process that opens the user's editor. */
#include "platform/editor.h"

#include "common/util.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

struct editor {
    int line; /* to the process */
    pid_t process;
};

typedef struct wish {
    int line;
    char path[PATH_SIZE];
} wish;

/* ---- in the process ---- */

static const char *wanted_editor(void)
{
    const char *const names[] = {"VISUAL", "EDITOR"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        const char *value = getenv(names[i]);
        if (value && value[0]) return value;
    }
    return NULL;
}

/* Those that take FILE:LINE; the others take +LINE FILE, as vi did first. */
static const char *joined_form(const char *command)
{
    static const struct {
        const char *name, *option;
    } forms[] = {{"code", "-g"}, {"codium", "-g"}, {"subl", NULL}, {"zed", NULL}, {"hx", NULL}};
    char name[64];
    path_base_name(command, name, sizeof name);
    name[strcspn(name, " ")] = 0;
    for (size_t i = 0; i < COUNT_OF(forms); i++)
        if (strcmp(name, forms[i].name) == 0) return forms[i].option ? forms[i].option : "";
    return NULL;
}

/* The shell splits the variable into words, as git has it. Does not return. */
static void run_editor(const char *command, const wish *what)
{
    char script[PATH_SIZE], place[PATH_SIZE + 16];
    const char *option = joined_form(command);
    if (snprintf(script, sizeof script, "exec %s \"$@\"", command) >= (int)sizeof script) _exit(1);
    if (!option) {
        snprintf(place, sizeof place, "+%d", what->line);
        execl("/bin/sh", "sh", "-c", script, "sh", place, what->path, (char *)NULL);
    } else {
        snprintf(place, sizeof place, "%s:%d", what->path, what->line);
        if (option[0]) execl("/bin/sh", "sh", "-c", script, "sh", option, place, (char *)NULL);
        execl("/bin/sh", "sh", "-c", script, "sh", place, (char *)NULL);
    }
    _exit(1);
}

static bool is_within(const char *folder, wish *what)
{
    char path[PATH_MAX];
    const size_t length = strlen(folder);
    what->path[PATH_SIZE - 1] = 0;
    if (what->line < 1 || !realpath(what->path, path)) return false;
    if (strncmp(path, folder, length) != 0 || path[length] != '/') return false;
    return snprintf(what->path, sizeof what->path, "%s", path) < (int)sizeof what->path;
}

static void serve(int from, const char *folder, const char *command)
{
    wish what;
    signal(SIGCHLD, SIG_IGN);
    for (;;) {
        const ssize_t size = read(from, &what, sizeof what);
        if (size < 0 && errno == EINTR) continue;
        if (size != (ssize_t)sizeof what) _exit(0);
        if (is_within(folder, &what) && fork() == 0) run_editor(command, &what);
    }
}

/* ---- in the program ---- */

editor *editor_start(const char *folder)
{
    const char *command = wanted_editor();
    char real[PATH_MAX];
    int ends[2];
    if (!command || !realpath(folder, real) || socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) != 0) return NULL;
    for (int i = 0; i < 2; i++) fcntl(ends[i], F_SETFD, FD_CLOEXEC);
    const pid_t process = fork();
    if (process == 0) {
        sigset_t none;
        sigemptyset(&none);
        sigprocmask(SIG_SETMASK, &none, NULL);
        close(ends[1]);
        serve(ends[0], real, command);
    }
    close(ends[0]);
    editor *self = process > 0 ? malloc(sizeof *self) : NULL;
    if (!self) {
        close(ends[1]);
        return NULL;
    }
    *self = (editor){ends[1], process};
    return self;
}

bool editor_open(editor *self, const char *file, int line)
{
    wish what = {.line = line};
    if (snprintf(what.path, sizeof what.path, "%s", file) >= (int)sizeof what.path) return false;
    return send(self->line, &what, sizeof what, MSG_NOSIGNAL) == (ssize_t)sizeof what;
}

void editor_close(editor *self)
{
    if (!self) return;
    close(self->line);
    waitpid(self->process, NULL, 0);
    free(self);
}
