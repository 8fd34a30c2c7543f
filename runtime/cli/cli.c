/* Parses the command line by a table of options, and prints --help from it. */
#include "cli/cli.h"

#include "common/quality.h"
#include "common/util.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *const ISAS[] = {"plain", "sse2", "avx2", "avx512"};
static const char *const ACCELS[] = {"bvh", "kdtree"};
static const char *const INTERSECTIONS[] = {"exact", "watertight", "fast"};
static const char *const QUALITIES[] = {"draft", "game", "high", "reference"};

int cli_refuse(const char *command, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "daft %s: ", command);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "\nTry 'daft %s --help'.\n", command);
    va_end(arguments);
    return STATUS_BAD_USAGE;
}

/* Finds `text` among the words an option accepts; the message lists them. */
static bool parse_word(const char *command, const cli_option *option, const char *text, const char *const *words,
                       size_t count, size_t *out)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(text, words[i]) != 0) continue;
        *out = i;
        return true;
    }
    char list[128] = "", hint[HINT_SIZE];
    for (size_t i = 0; i < count; i++) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", words[i]);
    }
    cli_refuse(command, "--%s: one of %s expected, got '%s'%s", option->name, list, text,
               did_you_mean(hint, "", text, words, count));
    return false;
}

static bool parse_count(const char *text, char end, long min, long max, long *out, const char **rest)
{
    if (!isdigit((unsigned char)text[0]) && !(text[0] == '-' && isdigit((unsigned char)text[1]))) return false;
    char *after;
    errno = 0;
    *out = strtol(text, &after, 10);
    if (errno || *after != end || *out < min || *out > max) return false;
    if (rest) *rest = after + (end != 0);
    return true;
}

static bool parse_size(const cli_option *option, const char *text, cli_size *out)
{
    long width, height;
    const char *rest;
    if (!parse_count(text, 'x', option->min, option->max, &width, &rest)) return false;
    if (!parse_count(rest, 0, option->min, option->max, &height, NULL)) return false;
    *out = (cli_size){(int)width, (int)height};
    return true;
}

static bool parse_number(const cli_option *option, const char *text, double *out)
{
    char *after;
    *out = strtod(text, &after);
    return after != text && *after == 0 && isfinite(*out) && *out >= (double)option->min && *out <= (double)option->max;
}

static bool parse_bytes(const cli_option *option, const char *text, uint64_t *out)
{
    static const struct {
        const char *name;
        double bytes;
    } units[] = {{"", 1}, {"B", 1}, {"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}};
    char *after;
    double value = strtod(text, &after);
    if (after == text || !isdigit((unsigned char)text[0])) return false;
    for (size_t i = 0; i < COUNT_OF(units); i++) {
        if (strcasecmp(after, units[i].name) != 0) continue;
        value = floor(value * units[i].bytes);
        if (!(value >= (double)option->min) || value > 1e15) return false;
        *out = (uint64_t)value;
        return true;
    }
    return false;
}

static bool parse_knobs(const char *command, const cli_option *option, const char *text)
{
    daft_quality any = daft_preset_quality(DAFT_PRESET_GAME);
    daft_error error;
    if (quality_parse(text, &any, &error)) {
        *(const char **)option->target = text;
        return true;
    }
    cli_refuse(command, "--%s: %s", option->name, error.message);
    return false;
}

static bool parse_value(const char *command, const cli_option *option, const char *text)
{
    const char *name = option->name;
    size_t word;
    switch (option->kind) {
    case CLI_FLAG: break;
    case CLI_TEXT:
        if (text[0]) {
            *(const char **)option->target = text;
            return true;
        }
        cli_refuse(command, "--%s: %s expected, got nothing", name, option->value);
        return false;
    case CLI_COUNT:
        if (parse_count(text, 0, option->min, option->max, option->target, NULL)) return true;
        cli_refuse(command, "--%s: a whole number from %ld to %ld expected, got '%s'", name, option->min, option->max,
                   text);
        return false;
    case CLI_NUMBER:
        if (parse_number(option, text, option->target)) return true;
        cli_refuse(command, "--%s: a number from %ld to %ld expected, got '%s'", name, option->min, option->max, text);
        return false;
    case CLI_BYTES:
        if (parse_bytes(option, text, option->target)) return true;
        cli_refuse(command, "--%s: a number of bytes expected, such as 500000, 64MB or 1.5GB, at least %ld, got '%s'",
                   name, option->min, text);
        return false;
    case CLI_SIZE:
        if (parse_size(option, text, option->target)) return true;
        cli_refuse(command, "--%s: WIDTHxHEIGHT expected, such as 1280x720, each from %ld to %ld, got '%s'", name,
                   option->min, option->max, text);
        return false;
    case CLI_QUALITY:
        if (!parse_word(command, option, text, QUALITIES, COUNT_OF(QUALITIES), &word)) return false;
        return daft_preset_parse(QUALITIES[word], option->target);
    case CLI_KNOBS: return parse_knobs(command, option, text);
    case CLI_INTERSECT:
        if (!parse_word(command, option, text, INTERSECTIONS, COUNT_OF(INTERSECTIONS), &word)) return false;
        return daft_intersection_parse(INTERSECTIONS[word], option->target);
    case CLI_ISA:
        if (!parse_word(command, option, text, ISAS, COUNT_OF(ISAS), &word)) return false;
        *(const char **)option->target = ISAS[word];
        return true;
    case CLI_ACCEL:
        if (!parse_word(command, option, text, ACCELS, COUNT_OF(ACCELS), &word)) return false;
        return daft_accel_parse(ACCELS[word], option->target);
    }
    return false;
}

static const cli_option *find_option(const char *command, const cli_option *options, size_t count, const char *text)
{
    size_t length = strcspn(text, "=");
    if (text[0] == '-' && text[1] != '-') {
        for (size_t i = 0; i < count; i++)
            if (options[i].letter && options[i].letter == text[1] && text[2] == 0) return &options[i];
    } else {
        for (size_t i = 0; i < count; i++)
            if (strlen(options[i].name) + 2 == length && strncmp(options[i].name, text + 2, length - 2) == 0)
                return &options[i];
    }
    const char *names[64];
    size_t known = 0;
    names[known++] = "help";
    for (size_t i = 0; i < count && known < COUNT_OF(names); i++) names[known++] = options[i].name;
    char word[64], hint[HINT_SIZE];
    snprintf(word, sizeof word, "%.*s", (int)length, text + strspn(text, "-"));
    cli_refuse(command, "there is no option '%.*s'%s", (int)length, text, did_you_mean(hint, "--", word, names, known));
    return NULL;
}

/* Takes the option at argv[*index] and its value, which may be the next argument. */
static bool take_option(const char *command, const cli_option *options, size_t count, int argc, char **argv, int *index)
{
    const char *text = argv[*index];
    const cli_option *option = find_option(command, options, count, text);
    if (!option) return false;
    const char *value = text[1] == '-' ? strchr(text, '=') : NULL;
    if (option->kind == CLI_FLAG) {
        if (value) {
            cli_refuse(command, "--%s takes no value", option->name);
            return false;
        }
        *(bool *)option->target = true;
        return true;
    }
    if (value) return parse_value(command, option, value + 1);
    /* A following option is not a value; a lone - or a negative number is. */
    const char *next = *index + 1 < argc ? argv[*index + 1] : NULL;
    if (!next || (next[0] == '-' && next[1] && !isdigit((unsigned char)next[1]))) {
        cli_refuse(command, "--%s: %s is missing", option->name, option->value);
        return false;
    }
    ++*index;
    return parse_value(command, option, next);
}

static void print_help(const cli_command *command, const cli_option *options, size_t option_count)
{
    printf("usage: daft %s%s%s%s\n\n%s\n", command->name, command->operands[0] ? " " : "", command->operands,
           option_count ? " [options]" : "", command->summary);
    if (command->details) printf("%s\n", command->details);
    printf("\noptions:\n");
    for (size_t i = 0; i < option_count; i++) {
        const cli_option *option = &options[i];
        char form[64], letter[8] = "    ";
        if (option->letter) snprintf(letter, sizeof letter, "-%c, ", option->letter);
        snprintf(form, sizeof form, "%s--%s%s%s", letter, option->name, option->value ? " " : "",
                 option->value ? option->value : "");
        printf("  %-26s %s\n", form, option->help);
    }
    printf("  -h, --help                 print this text\n");
}

cli_outcome cli_parse(const cli_command *command, const cli_option *options, size_t option_count, int argc, char **argv,
                      const char **out_operands, size_t *out_count)
{
    *out_count = 0;
    bool options_end = false;
    for (int i = 1; i < argc; i++) {
        const char *text = argv[i];
        if (!options_end && strcmp(text, "--") == 0) {
            options_end = true;
        } else if (!options_end && (strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0)) {
            print_help(command, options, option_count);
            return CLI_HELPED;
        } else if (!options_end && text[0] == '-' && text[1]) {
            if (!take_option(command->name, options, option_count, argc, argv, &i)) return CLI_REFUSED;
        } else if (*out_count == command->max_operands || *out_count == CLI_OPERANDS) {
            cli_refuse(command->name, "'%s' is one operand too many", text);
            return CLI_REFUSED;
        } else {
            out_operands[(*out_count)++] = text;
        }
    }
    if (*out_count < command->min_operands) {
        cli_refuse(command->name, "%s is missing", command->operands);
        return CLI_REFUSED;
    }
    return CLI_READY;
}
