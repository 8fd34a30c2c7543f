/* Running the daft program in tests: its output, standard error among it, and its exit status. */
#ifndef TEST_RUNTIME_PROGRAM_H
#define TEST_RUNTIME_PROGRAM_H

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

enum { OUTPUT_SIZE = 1 << 16 };

/* Runs "daft ARGUMENTS" in the shell, in the checkout. Returns the exit status, or -1 when a signal ended it. */
static inline int run_daft(char *output, const char *format, ...)
{
    char arguments[2048], command[4096];
    va_list list;
    va_start(list, format);
    vsnprintf(arguments, sizeof arguments, format, list);
    va_end(list);
    snprintf(command, sizeof command, "cd '%s' && exec '%s' %s 2>&1 </dev/null", DAFT_ROOT, DAFT_PROGRAM, arguments);
    output[0] = 0;
    FILE *pipe = popen(command, "r");
    if (!pipe) return -1;
    size_t used = fread(output, 1, OUTPUT_SIZE - 1, pipe);
    output[used] = 0;
    char rest[4096];
    while (fread(rest, 1, sizeof rest, pipe) > 0) {
    }
    int status = pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* Fails the test, and shows what the program said. */
#define assert_says(output, wanted)                                                                                    \
    do {                                                                                                               \
        if (!strstr(output, wanted)) fail_msg("'%s' is not in:\n%s", wanted, output);                                  \
    } while (0)
#define assert_status(status, wanted, output)                                                                          \
    do {                                                                                                               \
        if ((status) != (wanted)) fail_msg("exit status %d, not %d:\n%s", status, wanted, output);                     \
    } while (0)

#endif
