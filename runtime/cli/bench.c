/* daft bench: replaces this process by tests/daft_bench beside it, a program of its own because it links the peers. */
#include "cli/commands.h"

#include "common/stop.h"
#include "common/util.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

int command_bench(int argc, char **argv)
{
    (void)argc;
    char folder[PATH_SIZE], program[PATH_SIZE];
    if (!home_program_folder(folder, sizeof folder) ||
        !path_join(program, sizeof program, folder, "tests/daft_bench")) {
        fprintf(stderr, "daft bench: the program cannot find its own folder\n");
        return STATUS_BAD_INPUT;
    }
    argv[0] = program;
    stop_before_exec();
    execv(program, argv);
    fprintf(stderr, "daft bench: %s: %s\n", program, strerror(errno));
    fprintf(stderr, "The benchmarks are built with the tests: './daft test' in the checkout builds them.\n");
    return STATUS_BAD_INPUT;
}
