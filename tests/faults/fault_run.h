/* What the tests with faults and with kill share: a folder with a small scene and a small game, a run of the program in
 * it under a deadline, and a look at what it left behind. */
#ifndef DAFT_TEST_FAULT_RUN_H
#define DAFT_TEST_FAULT_RUN_H

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* What stands in a file before the program writes it. */
#define OLD "the old file, which stays until the new one is whole\n"

enum { DEADLINE = 60 /* seconds: what takes longer hangs */, OUTPUT = 1 << 14 };

static uint64_t random_bits = 88172645463325252u;

static inline uint64_t random_next(void)
{
    random_bits ^= random_bits << 13, random_bits ^= random_bits >> 7, random_bits ^= random_bits << 17;
    return random_bits >> 11;
}

typedef struct outcome {
    int status; /* exit status; 128 + signal; -1: it hung */
    bool struck;
    char output[OUTPUT];
} outcome;

/* ---- files ---- */

static inline void give_up(const char *what)
{
    printf("cannot %s: %s\n", what, strerror(errno));
    exit(1);
}

static inline void write_bytes(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) give_up(path);
}

static inline void write_text(const char *path, const char *text) { write_bytes(path, text, strlen(text)); }

/* NULL: there is no such file. Freed with free. */
static inline char *read_bytes(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    char *bytes = malloc(1 << 20);
    *size = fread(bytes, 1, (1 << 20) - 1, file);
    bytes[*size] = 0;
    fclose(file);
    return bytes;
}

/* ---- the folder ---- */

static char folder[64];

static const char SCENE[] = "camera 0 1 4\nambient 0.2 0.2 0.2\nlight 2 4 3 1 1 1\nskybox sky.ppm.png\n"
                            "mesh a.obj 0 0 0\nsphere 1 0.5 0 0.5 a.mtl#mirror\ninclude more.scene\n";
static const char MORE[] = "sphere -1 0.5 0 0.5 a.mtl#red\n";
static const char OBJ[] = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                          "usemtl red\nf 1/1 2/2 3/3 4/4\n";
static const char MTL[] = "newmtl red\nKd 0.8 0.1 0.1\nmap_Kd tile.png\nnewmtl mirror\nKs 0.9 0.9 0.9\nillum 3\n";
static const char GAME[] =
    "local words = require 'words'\nlocal ball\n"
    "function daft.load()\n"
    "  daft.light.sun { direction = {-1, -2, -0.5}, color = {1, 1, 1} }\n"
    "  daft.entity { box = {20, 1, 20}, position = {0, -0.5, 0}, body = 'static' }\n"
    "  ball = daft.entity { sphere = 0.5, position = {0, 4, 0}, material = { mirror = 0.5 }, body = 'dynamic' }\n"
    "  daft.camera.look { from = {-8, 4, 0}, at = ball }\n"
    "end\n"
    "function daft.update(dt) words.say(dt) end\n"
    "function daft.draw() daft.text('ball', 16, 16) end\n";

static inline void write_picture(const char *path, int side)
{
    char command[512];
    snprintf(command, sizeof command,
             "printf 'camera 0 0 3\\nlight 1 1 2 1 1 1\\nsphere 0 0 0 1 b.mtl\\n' >p.scene && "
             "printf 'newmtl b\\n' >b.mtl && '%s' render p.scene -o %s --size %dx%d >/dev/null 2>&1",
             DAFT_PROGRAM, path, side, side);
    if (system(command) != 0) give_up("write a picture");
}

static inline outcome run_with(const char *fault, const char *arguments);

static inline void set_up(const char *self)
{
    const char *seed = getenv("DAFT_TEST_SEED");
    if (seed) random_bits ^= strtoull(seed, NULL, 0) * 0x9e3779b97f4a7c15u;
    if (!random_bits) random_bits = 1;
    printf("%s: seed %s\n", self, seed ? seed : "0");
    snprintf(folder, sizeof folder, "/tmp/daft-faults-XXXXXX");
    if (!mkdtemp(folder) || chdir(folder) != 0) give_up("make a folder");
    setenv("DAFT_HOME", DAFT_ROOT, 1);
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    write_picture("tile.png", 16);
    write_picture("sky.ppm.png", 24);
    write_text("a.scene", SCENE), write_text("more.scene", MORE), write_text("a.obj", OBJ), write_text("a.mtl", MTL);
    if (mkdir("game", 0777) != 0) give_up("make a folder");
    write_text("game/main.lua", GAME);
    write_text("game/words.lua", "local M = {}\nfunction M.say(x) M.last = tostring(x) end\nreturn M\n");
    write_picture("a.png", 8);
    outcome first = run_with("none:1", "play game --headless --ticks 20 --record old.rec");
    if (first.status == 0) first = run_with("none:1", "pack game -o old.daft");
    if (first.status != 0) printf("%s\n", first.output), exit(1);
}

static inline void tear_down(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    if (chdir("/") != 0 || system(command) != 0) give_up("remove the folder");
}

/* ---- running ---- */

/* Arguments are separated by single spaces. */
static inline pid_t start(const char *fault, const char *arguments, int report, int output)
{
    pid_t child = fork();
    if (child != 0) return child;
    char words[1024], descriptor[16], *list[64] = {words};
    int count = 0;
    snprintf(words, sizeof words, DAFT_PROGRAM " %s", arguments);
    for (char *word = strtok(words, " "); word && count < 63; word = strtok(NULL, " ")) list[count++] = word;
    snprintf(descriptor, sizeof descriptor, "%d", report);
    if (fault) {
        setenv("DAFT_FAULT", fault, 1);
        setenv("DAFT_FAULT_FD", descriptor, 1);
        setenv("LD_PRELOAD", DAFT_FAULT_LIBRARY, 1);
    }
    dup2(output, 1), dup2(output, 2);
    dup2(open("/dev/null", O_RDONLY), 0);
    execv(list[0], list);
    _exit(99);
}

static inline double now_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static inline int wait_for(pid_t child, double seconds)
{
    double until = now_seconds() + seconds;
    int status;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (now_seconds() > until) {
            kill(child, SIGKILL);
            waitpid(child, &status, 0);
            return -1;
        }
        nanosleep(&(struct timespec){0, 1000000}, NULL);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static inline outcome run_with(const char *fault, const char *arguments)
{
    outcome end = {0};
    int report[2], output = open(".", O_TMPFILE | O_RDWR, 0600);
    if (pipe(report) != 0 || output < 0) give_up("run");
    pid_t child = start(fault, arguments, report[1], output);
    close(report[1]);
    end.status = wait_for(child, DEADLINE);
    char byte;
    end.struck = read(report[0], &byte, 1) == 1;
    ssize_t size = pread(output, end.output, sizeof end.output - 1, 0);
    end.output[size > 0 ? size : 0] = 0;
    close(report[0]), close(output);
    return end;
}

/* ---- looking ---- */

static inline bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcmp(text + length - tail, end) == 0;
}

/* Whether a file is whole, by its kind. */
static inline bool is_whole(const char *path, const char *bytes, size_t size)
{
    if (ends_with(path, ".png"))
        return size > 20 && memcmp(bytes, "\x89PNG", 4) == 0 && memcmp(bytes + size - 8, "IEND", 4) == 0;
    if (ends_with(path, ".ppm")) return size == 3 * 40 * 30 + strlen("P6\n40 30\n255\n");
    if (ends_with(path, ".pfm")) return size > 4 * 40 * 30;
    if (ends_with(path, ".json")) return bytes[0] == '{' && ends_with(bytes, "}\n");
    if (ends_with(path, ".daft"))
        return size > 22 && memcmp(bytes, "PK\3\4", 4) == 0 && memcmp(bytes + size - 22, "PK\5\6", 4) == 0;
    if (ends_with(path, ".mp4")) return size > 100 && memcmp(bytes + 4, "ftyp", 4) == 0;
    return size > 0;
}

static inline bool look_at_file(const char *path, bool done, char *why, size_t room)
{
    size_t size = 0;
    char *bytes = read_bytes(path, &size);
    bool old = bytes && strcmp(bytes, OLD) == 0, good = bytes && (old ? !done : is_whole(path, bytes, size));
    if (!good)
        snprintf(why, room, "%s is %s", path,
                 !bytes ? "gone"
                 : old  ? "the old one, in spite of status 0"
                        : "half a file");
    free(bytes);
    return good;
}

static inline bool look_for_temporaries(char *why, size_t room)
{
    DIR *list = opendir(".");
    bool good = true;
    for (struct dirent *entry; list && (entry = readdir(list));)
        if (ends_with(entry->d_name, ".tmp") || ends_with(entry->d_name, ".part")) {
            snprintf(why, room, "%s is left", entry->d_name);
            unlink(entry->d_name);
            good = false;
        }
    closedir(list);
    return good;
}

/* Lines that begin with "daft". */
static inline int count_messages(const char *output)
{
    int count = 0;
    for (const char *line = output; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL)
        count += strncmp(line, "daft", 4) == 0;
    return count;
}

static inline bool look_at(const outcome *end, const char *const *written, char *why, size_t room)
{
    if (end->status == -1) return snprintf(why, room, "it hangs"), false;
    if (end->status > 1) return snprintf(why, room, "exit status %d", end->status), false;
    if (end->status == 1 && (end->output[0] == 0 || count_messages(end->output) > 1))
        return snprintf(why, room, "status 1 with %d messages", count_messages(end->output)), false;
    for (int i = 0; i < 4 && written && written[i]; i++)
        if (!look_at_file(written[i], end->status == 0, why, room)) return false;
    return look_for_temporaries(why, room);
}

#endif
