/* Which command runs; daft help and daft version. */
#include "cli/commands.h"

#include "lua/api.h"
#include "common/stop.h"
#include "common/util.h"
#include "stub/format.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int command_help(int argc, char **argv);
static int command_version(int argc, char **argv);

static const struct {
    const char *name, *summary;
    int (*run)(int argc, char **argv);
} COMMANDS[] = {
    {"play", "play a game, or choose one from a menu", command_play},
    {"render", "render a scene to a picture", command_render},
    {"view", "look at a scene, a mesh or a picture in a window", command_view},
    {"video", "film a scene or a game", command_video},
    {"scan", "measure a scene with a laser scanner", command_scan},
    {"cost", "measure what accuracy costs in a scene or a game", command_cost},
    {"check", "check scenes, meshes, pictures and games for errors", command_check},
    {"new", "begin a game from a template", command_new},
    {"test-game", "run the tests of a game", command_test_game},
    {"pack", "pack a game into one file", command_pack},
    {"bench", "run the benchmarks", command_bench},
    {"help", "print this text; 'help COMMAND': its options; 'help lua [NAME]', 'help fields': the API", command_help},
    {"version", "print the version", command_version}};

static void print_usage(FILE *out)
{
    fprintf(out, "usage: daft COMMAND [...]\n\nDAFT, a 3D engine that needs no GPU.\n\n");
    for (size_t i = 0; i < COUNT_OF(COMMANDS); i++) fprintf(out, "  %-9s  %s\n", COMMANDS[i].name, COMMANDS[i].summary);
    fprintf(out, "\n'daft COMMAND --help' lists the options. Exit status: 0 done, 1 bad input, 2 wrong usage.\n");
}

static int command_version(int argc, char **argv)
{
    (void)argc, (void)argv;
    printf("daft %d.%d.%d\n", DAFT_VERSION_MAJOR, DAFT_VERSION_MINOR, DAFT_VERSION_PATCH);
    return STATUS_DONE;
}

static int unknown_command(const char *name)
{
    const char *names[COUNT_OF(COMMANDS)];
    for (size_t i = 0; i < COUNT_OF(COMMANDS); i++) names[i] = COMMANDS[i].name;
    char hint[HINT_SIZE];
    fprintf(stderr, "daft: there is no command '%s'%s\nTry 'daft help'.\n", name,
            did_you_mean(hint, "", name, names, COUNT_OF(names)));
    return STATUS_BAD_USAGE;
}

static int run_command(const char *name, int argc, char **argv)
{
    for (size_t i = 0; i < COUNT_OF(COMMANDS); i++)
        if (strcmp(name, COMMANDS[i].name) == 0) return COMMANDS[i].run(argc, argv);
    return unknown_command(name);
}

static int help_lua(const char *name)
{
    const char *near;
    if (api_print_reference(name, &near)) return STATUS_DONE;
    fprintf(stderr, "daft help lua: there is no '%s'", name);
    fprintf(stderr, near ? ": did you mean '%s'?\n" : "\nTry 'daft help lua'.\n", near);
    return STATUS_BAD_USAGE;
}

static int command_help(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "lua") == 0) return help_lua(argc > 2 ? argv[2] : NULL);
    if (argc > 1 && strcmp(argv[1], "annotations") == 0) {
        api_print_annotations();
        return STATUS_DONE;
    }
    if (argc > 1 && strcmp(argv[1], "fields") == 0) return command_fields(argc - 1, argv + 1);
    if (argc > 1 && argv[1][0] != '-' && strcmp(argv[1], "help") != 0 && strcmp(argv[1], "version") != 0) {
        char help[] = "--help", *arguments[] = {argv[1], help, NULL};
        return run_command(argv[1], 2, arguments);
    }
    print_usage(stdout);
    return STATUS_DONE;
}

static int choose_command(int argc, char **argv)
{
    if (argc < 2) {
        print_usage(stderr);
        return STATUS_BAD_USAGE;
    }
    const char *name = argv[1];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) name = "help";
    if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0) name = "version";
    return run_command(name, argc - 1, argv + 1);
}

/* What a full disk or a closed descriptor did not take is lost: no status but "bad" tells of it. */
static int finish_output(int status)
{
    errno = 0;
    bool flushed = fflush(stdout) == 0;
    if (flushed && !ferror(stdout)) return status;
    fprintf(stderr, "daft: standard output cannot be written%s%s\n", errno ? ": " : "", errno ? strerror(errno) : "");
    return status == STATUS_DONE ? STATUS_BAD_INPUT : status;
}

/* A game's own program finds its libraries by a variable, which is not for what it starts itself. */
static void restore_library_path(void)
{
    const char *before = getenv(STUB_LIBRARY_PATH);
    if (!before) return;
    if (before[0])
        setenv("LD_LIBRARY_PATH", before, 1);
    else
        unsetenv("LD_LIBRARY_PATH");
    unsetenv(STUB_LIBRARY_PATH);
}

int run_program(int argc, char **argv)
{
    restore_library_path();
    stop_open();
    return finish_output(choose_command(argc, argv));
}
