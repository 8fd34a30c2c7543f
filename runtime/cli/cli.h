/* cli: the command line as data. A command is a name, what it does, its operands and its options; parsing, --help,
 * messages and "did you mean" follow from that.
 * Forms: --name VALUE, --name=VALUE, -o VALUE; options and operands in any order; -- ends the options. */
#ifndef RUNTIME_CLI_CLI_H
#define RUNTIME_CLI_CLI_H

#include "daft.h"

typedef enum cli_kind {
    CLI_FLAG,      /* bool */
    CLI_TEXT,      /* const char * */
    CLI_COUNT,     /* long, low..high */
    CLI_NUMBER,    /* double, low..high */
    CLI_SIZE,      /* cli_size: WIDTHxHEIGHT, each low..high */
    CLI_QUALITY,   /* daft_quality */
    CLI_INTERSECT, /* daft_intersection */
    CLI_ISA,       /* const char *: sse2, avx2, avx512 */
    CLI_ACCEL      /* daft_accel: bvh, kdtree */
} cli_kind;

typedef struct cli_size {
    int width, height;
} cli_size;

typedef struct cli_option {
    const char *name; /* without the dashes */
    char letter;      /* or 0 */
    cli_kind kind;
    const char *value; /* what --help calls it; NULL for flags */
    void *target;      /* what `kind` says */
    long low, high;
    const char *help;
} cli_option;

typedef struct cli_command {
    const char *name;
    const char *operands; /* as --help shows them */
    const char *summary;  /* one line */
    const char *details;  /* more lines for --help, or NULL */
    size_t least, most;   /* operands */
} cli_command;

typedef enum cli_outcome {
    CLI_READY,
    CLI_HELPED, /* --help was asked for and printed: leave with STATUS_DONE */
    CLI_REFUSED /* the message is on stderr: leave with STATUS_BAD_USAGE */
} cli_outcome;

enum { CLI_OPERANDS = 64 };

/* argv[0] is the command's name. Operands go to out_operands, their number to *out_count. */
cli_outcome cli_parse(const cli_command *command, const cli_option *options, size_t option_count, int argc, char **argv,
                      const char **out_operands, size_t *out_count);
void cli_print_help(const cli_command *command, const cli_option *options, size_t option_count);
/* "daft COMMAND: message" and where to look further, on stderr. Returns STATUS_BAD_USAGE. */
int cli_refuse(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
