/* cli: one file for each command of the program, and the command line as data. A command is a name, its operands, its
 * options and what they do; parsing, --help and messages come from that table.
 * Public headers: commands.h Inner headers: cli.h
 * Forms: --name VALUE, --name=VALUE, -o VALUE; options and operands in any order; -- ends the options. */
#ifndef RUNTIME_CLI_CLI_H
#define RUNTIME_CLI_CLI_H

#include "daft.h"

typedef enum cli_kind {
    CLI_FLAG,      /* bool */
    CLI_TEXT,      /* const char * */
    CLI_COUNT,     /* long, min..max */
    CLI_NUMBER,    /* double, min..max */
    CLI_BYTES,     /* uint64_t, at least min: 500000, 500kB, 64MB, 1.5GB */
    CLI_SIZE,      /* cli_size: WIDTHxHEIGHT, each min..max */
    CLI_QUALITY,   /* daft_preset */
    CLI_KNOBS,     /* const char *: what quality_parse reads */
    CLI_INTERSECT, /* daft_intersection */
    CLI_ISA,       /* const char *: plain, sse2, avx2, avx512 */
    CLI_ACCEL      /* daft_accel: bvh, kdtree */
} cli_kind;

typedef struct cli_size {
    int width, height;
} cli_size;

typedef struct cli_option {
    const char *name; /* without the dashes */
    char letter;      /* or 0 */
    cli_kind kind;
    const char *value; /* the name of the value in --help; NULL for flags */
    void *target;      /* points to the type that `kind` names */
    long min, max;
    const char *help;
} cli_option;

typedef struct cli_command {
    const char *name;
    const char *operands; /* as --help prints them */
    const char *summary;  /* one line */
    const char *details;  /* further lines of --help, or NULL */
    size_t min_operands, max_operands;
} cli_command;

typedef enum cli_outcome {
    CLI_READY,
    CLI_HELPED, /* --help is printed: exit with STATUS_DONE */
    CLI_REFUSED /* the message is on stderr: exit with STATUS_BAD_USAGE */
} cli_outcome;

enum { CLI_OPERANDS = 64 };

/* Reads argv[1..argc-1] into the options' targets; operands go to out_operands, their number to *out_count. */
cli_outcome cli_parse(const cli_command *command, const cli_option *options, size_t option_count, int argc, char **argv,
                      const char **out_operands, size_t *out_count);
/* Prints "daft COMMAND: message" and a pointer to --help on stderr. Returns STATUS_BAD_USAGE. */
int cli_refuse(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
