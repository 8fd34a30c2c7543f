/* Reads and writes recordings. */
#include "game/recording.h"

#include "game/loop.h"
#include "common/util.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- reading ---- */

typedef struct reader {
    const char *path;
    char *line; /* the line being read, ended by a zero byte */
    char *at;   /* in it */
    int number; /* of the line */
    daft_error *error;
} reader;

static bool bad(reader *in, const char *message, const char *detail)
{
    return fail_at(in->error, in->path, in->number, (int)(in->at - in->line) + 1, "%s%s%s%s", message,
                   detail ? " '" : "", detail ? detail : "", detail ? "'" : "");
}

static void skip_blanks(reader *in)
{
    while (*in->at == ' ' || *in->at == '\t') in->at++;
}

/* Consumes `word` when it stands next as a whole word. */
static bool take_word(reader *in, const char *word)
{
    size_t length = strlen(word);
    if (strncmp(in->at, word, length) != 0 || (in->at[length] && !isblank((unsigned char)in->at[length]))) return false;
    in->at += length;
    skip_blanks(in);
    return true;
}

static bool take_count(reader *in, uint64_t *out, const char *what)
{
    if (!isdigit((unsigned char)*in->at)) return bad(in, what, NULL);
    char *end;
    errno = 0;
    *out = strtoull(in->at, &end, 10);
    if (errno || (*end && !isblank((unsigned char)*end))) return bad(in, what, NULL);
    in->at = end;
    skip_blanks(in);
    return true;
}

static bool take_float(reader *in, float *out)
{
    char *end;
    *out = strtof(in->at, &end);
    if (end == in->at || (*end && !isblank((unsigned char)*end)) || !isfinite(*out))
        return bad(in, "a number expected", NULL);
    in->at = end;
    skip_blanks(in);
    return true;
}

static bool line_ends(reader *in)
{
    return *in->at == 0 || bad(in, "unexpected text", in->at);
}

static bool read_key(reader *in, input_event *event)
{
    event->kind = INPUT_KEY;
    event->down = *in->at == '+';
    in->at++;
    event->key = input_key_find(in->at);
    if (event->key >= 0) return true;
    size_t count;
    const char *const *names = input_key_names(&count);
    char hint[HINT_SIZE];
    did_you_mean(hint, "", in->at, names, count);
    return fail_at(in->error, in->path, in->number, (int)(in->at - in->line) + 1, "there is no key '%.80s'%s", in->at,
                   hint);
}

static bool read_pair(reader *in, input_kind kind, input_event *event)
{
    event->kind = kind;
    return take_float(in, &event->x) && take_float(in, &event->y) && line_ends(in);
}

static bool read_event(reader *in, recording *out, size_t *capacity)
{
    recording_item item = {0};
    if (!take_count(in, &item.tick, "a tick, 'game', 'seed' or 'end' expected")) return false;
    if (out->count > 0 && item.tick < out->items[out->count - 1].tick)
        return bad(in, "the ticks must not go back", NULL);
    bool good;
    if (*in->at == '+' || *in->at == '-') {
        good = read_key(in, &item.event);
    } else if (take_word(in, "mouse")) {
        good = read_pair(in, INPUT_MOVE, &item.event);
    } else if (take_word(in, "motion")) {
        good = read_pair(in, INPUT_MOTION, &item.event);
    } else if (take_word(in, "wheel")) {
        good = read_pair(in, INPUT_WHEEL, &item.event);
    } else {
        good = bad(in, "+key, -key, mouse, motion or wheel expected", NULL);
    }
    if (!good) return false;
    if (out->count == *capacity) {
        size_t more = *capacity ? *capacity * 2 : 256;
        recording_item *items = realloc(out->items, more * sizeof *items);
        if (!items) return fail(in->error, DAFT_ERROR_MEMORY, "out of memory for a recording");
        out->items = items;
        *capacity = more;
    }
    out->items[out->count++] = item;
    return true;
}

static bool read_line(reader *in, recording *out, size_t *capacity, bool *ended)
{
    if (*ended) return bad(in, "text after the 'end' line", NULL);
    if (take_word(in, "game")) {
        if (!*in->at) return bad(in, "a game's name expected", NULL);
        if (strlen(in->at) >= sizeof out->game) return bad(in, "the game's name is too long", NULL);
        strcpy(out->game, in->at);
        return true;
    }
    if (take_word(in, "rate")) {
        uint64_t rate;
        if (!take_count(in, &rate, "a number of ticks a second expected")) return false;
        return rate == LOOP_RATE ? line_ends(in) : bad(in, "only recordings of 60 ticks a second can be played", NULL);
    }
    if (take_word(in, "seed")) return take_count(in, &out->seed, "a whole number expected") && line_ends(in);
    if (!take_word(in, "end")) return read_event(in, out, capacity);
    if (!take_count(in, &out->end, "a number of ticks expected")) return false;
    if (out->count > 0 && out->items[out->count - 1].tick >= out->end)
        return bad(in, "the recording ends before its last event", NULL);
    *ended = true;
    return line_ends(in);
}

static bool read_lines(reader *in, char *text, recording *out)
{
    size_t capacity = 0;
    bool ended = false;
    for (char *line = text; line; in->number++) {
        char *next = strchr(line, '\n');
        if (next) *next++ = 0;
        size_t length = strlen(line);
        while (length > 0 && isspace((unsigned char)line[length - 1])) line[--length] = 0;
        in->line = in->at = line;
        line = next;
        skip_blanks(in);
        if (in->number == 1) {
            if (take_word(in, "daft-recording") && strcmp(in->at, "1") == 0) continue;
            return bad(in, "'daft-recording 1' expected: this is not a recording of this version", NULL);
        }
        if (*in->at == 0 || *in->at == '#') continue;
        if (!read_line(in, out, &capacity, &ended)) return false;
    }
    return ended || fail_at(in->error, in->path, in->number, 1, "the 'end' line is missing: the file was cut short");
}

bool recording_load(recording *out, const char *path, daft_error *error)
{
    size_t size;
    char *text = read_whole_file(path, &size, error);
    if (!text) return false;
    recording record = {.seed = 1};
    reader in = {.path = path, .number = 1, .error = error};
    bool good = memchr(text, 0, size) ? fail_at(error, path, 1, 1, "not a text file") : read_lines(&in, text, &record);
    free(text);
    if (good)
        *out = record;
    else
        recording_free(&record);
    return good;
}

void recording_free(recording *record)
{
    free(record->items);
    *record = (recording){0};
}

void recording_play(recording *record, uint64_t tick, input *state)
{
    while (record->next < record->count && record->items[record->next].tick <= tick)
        input_apply(state, &record->items[record->next++].event);
}

/* ---- writing ---- */

struct recorder {
    FILE *file;
    char path[PATH_SIZE];
};

recorder *recorder_open(const char *path, const char *game, uint64_t seed, daft_error *error)
{
    recorder *writer = calloc(1, sizeof *writer);
    if (!writer) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a recording");
        return NULL;
    }
    snprintf(writer->path, sizeof writer->path, "%s", path);
    writer->file = open_to_write(path, error);
    if (!writer->file) {
        free(writer);
        return NULL;
    }
    fprintf(writer->file, "daft-recording 1\ngame %s\nrate %d\nseed %" PRIu64 "\n", game, LOOP_RATE, seed);
    return writer;
}

void recorder_add(recorder *writer, uint64_t tick, const input_event *event)
{
    static const char *const names[] = {[INPUT_MOVE] = "mouse", [INPUT_MOTION] = "motion", [INPUT_WHEEL] = "wheel"};
    fprintf(writer->file, "%" PRIu64 " ", tick);
    if (event->kind == INPUT_KEY)
        fprintf(writer->file, "%c%s\n", event->down ? '+' : '-', input_key_name(event->key));
    else /* nine digits bring a float back to the bit */
        fprintf(writer->file, "%s %.9g %.9g\n", names[event->kind], (double)event->x, (double)event->y);
}

bool recorder_close(recorder *writer, uint64_t end, daft_error *error)
{
    if (!writer) return true;
    fprintf(writer->file, "end %" PRIu64 "\n", end);
    bool good = close_written(writer->file, writer->path, error);
    free(writer);
    return good;
}
