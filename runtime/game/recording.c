/* Reads recordings, and plays them; recorder.c writes them. */
#include "game/recording.h"

#include "game/loop.h"
#include "common/util.h"
#include "files/saves.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static bool line_ends(reader *in) { return *in->at == 0 || bad(in, "unexpected text", in->at); }

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

static bool read_width(reader *in, input_event *event)
{
    event->kind = INPUT_WIDTH;
    return take_float(in, &event->x) && line_ends(in);
}

static bool read_stick(reader *in, input_event *event)
{
    size_t count;
    const char *const *names = input_stick_names(&count);
    event->kind = INPUT_STICK;
    if (!take_float(in, &event->x)) return false;
    event->key = input_stick_find(in->at);
    char hint[HINT_SIZE];
    if (event->key < 0) bad(in, "there is no stick of that name", did_you_mean(hint, "", in->at, names, count));
    return event->key >= 0;
}

static bool read_typed(reader *in, input_event *event)
{
    const size_t digits = strspn(in->at, "0123456789abcdef");
    event->kind = INPUT_TEXT;
    event->key = digits > 0 && digits <= 6 ? (int)strtol(in->at, NULL, 16) : 0;
    if (!input_is_text(event->key)) return bad(in, "the code point of a letter expected", NULL);
    in->at += digits;
    return line_ends(in);
}

/* The tick of the last event or line; 0: there is none. */
static uint64_t last_tick(const recording *out)
{
    const uint64_t item = out->count > 0 ? out->items[out->count - 1].tick : 0;
    const uint64_t line = out->line_count > 0 ? out->lines[out->line_count - 1].tick : 0;
    return item > line ? item : line;
}

static bool is_empty(const recording *out) { return out->count == 0 && out->line_count == 0; }

static bool read_lua(reader *in, uint64_t tick, recording *out)
{
    if (!*in->at) return bad(in, "a line of Lua expected", NULL);
    return recording_add_line(out, tick, in->at) || fail(in->error, DAFT_ERROR_MEMORY, "out of memory for a recording");
}

static bool read_event(reader *in, recording *out, size_t *capacity)
{
    recording_item item = {0};
    if (!take_count(in, &item.tick, "a tick, 'game', 'seed' or 'end' expected")) return false;
    if (item.tick < last_tick(out)) return bad(in, "the ticks must not go back", NULL);
    if (take_word(in, "lua")) return read_lua(in, item.tick, out);
    bool good;
    if (*in->at == '+' || *in->at == '-') {
        good = read_key(in, &item.event);
    } else if (take_word(in, "mouse")) {
        good = read_pair(in, INPUT_MOVE, &item.event);
    } else if (take_word(in, "motion")) {
        good = read_pair(in, INPUT_MOTION, &item.event);
    } else if (take_word(in, "wheel")) {
        good = read_pair(in, INPUT_WHEEL, &item.event);
    } else if (take_word(in, "stick")) {
        good = read_stick(in, &item.event);
    } else if (take_word(in, "width")) {
        good = read_width(in, &item.event);
    } else if (take_word(in, "text")) {
        good = read_typed(in, &item.event);
    } else {
        good = bad(in, "+key, -key, mouse, motion, wheel, stick, width, text or lua expected", NULL);
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

/* How far a recording reaches is known by these, should its end be missing. */
static bool read_mark(reader *in, recording *out)
{
    uint64_t ticks;
    if (!take_count(in, &ticks, "a number of ticks expected") || !line_ends(in)) return false;
    if (ticks < out->end || (!is_empty(out) && last_tick(out) >= ticks))
        return bad(in, "the ticks must not go back", NULL);
    out->end = ticks;
    return true;
}

static const char HEX[] = "0123456789abcdef";

static bool read_sha256(reader *in, char out[65])
{
    if (strlen(in->at) != 64 || strspn(in->at, HEX) != 64) return bad(in, "a SHA-256 expected", NULL);
    strcpy(out, in->at);
    return true;
}

static bool read_limits(reader *in, recording *out)
{
    float seconds;
    if (!take_count(in, &out->memory, "a number of bytes expected") || !take_float(in, &seconds)) return false;
    out->seconds = (double)seconds;
    return line_ends(in);
}

/* Exactly so many hexadecimal digits. */
static bool take_hex(reader *in, size_t digits, uint64_t *out)
{
    char text[17];
    if (strspn(in->at, HEX) < digits) return bad(in, "hexadecimal digits expected", NULL);
    snprintf(text, sizeof text, "%.*s", (int)digits, in->at);
    *out = strtoull(text, NULL, 16);
    in->at += digits;
    return true;
}

/* Room for one more. */
static void *grow_list(reader *in, void *items, size_t *capacity, size_t count, size_t size)
{
    if (count < *capacity) return items;
    const size_t more = *capacity ? 2 * *capacity : 64;
    void *grown = realloc(items, more * size);
    if (grown)
        *capacity = more;
    else
        fail(in->error, DAFT_ERROR_MEMORY, "out of memory for a recording");
    return grown;
}

static bool read_state(reader *in, recording *out)
{
    recording_state state = {0};
    uint64_t low = 0;
    if (!take_count(in, &state.tick, "a number of ticks expected") || !take_hex(in, 16, &state.hash)) return false;
    if (out->state_count > 0 && state.tick <= out->states[out->state_count - 1].tick)
        return bad(in, "the ticks must go on", NULL);
    skip_blanks(in);
    while (*in->at && state.count < RECORDING_SECOND && state.count < state.tick) {
        if (!take_hex(in, 4, &low)) return false;
        state.ticks[state.count++] = (uint16_t)low;
    }
    if (!line_ends(in)) return false;
    recording_state *grown = grow_list(in, out->states, &out->state_capacity, out->state_count, sizeof state);
    if (!grown) return false;
    out->states = grown;
    out->states[out->state_count++] = state;
    return true;
}

static bool read_mark_of(reader *in, uint64_t tick, recording *out)
{
    char *end;
    recording_mark mark = {.tick = tick};
    if (!isxdigit((unsigned char)*in->at)) return bad(in, "an entity's number expected", NULL);
    mark.entity = (uint32_t)strtoul(in->at, &end, 16);
    if (end - in->at > 8 || *end != ':') return bad(in, "an entity's number expected", NULL);
    in->at = end + 1;
    uint64_t print = 0;
    mark.gone = *in->at == '-';
    if (mark.gone)
        in->at++;
    else if (!take_hex(in, 8, &print))
        return false;
    mark.print = (uint32_t)print;
    skip_blanks(in);
    recording_mark *grown = grow_list(in, out->marks, &out->mark_capacity, out->mark_count, sizeof mark);
    if (!grown) return false;
    out->marks = grown;
    out->marks[out->mark_count++] = mark;
    return true;
}

static bool read_marks(reader *in, recording *out)
{
    uint64_t tick;
    if (!take_count(in, &tick, "a number of ticks expected")) return false;
    if (out->mark_count > 0 && tick <= out->marks[out->mark_count - 1].tick)
        return bad(in, "the ticks must go on", NULL);
    while (*in->at)
        if (!read_mark_of(in, tick, out)) return false;
    return true;
}

static bool read_saved(reader *in, recording *out)
{
    char *name = in->at, *end = name + strcspn(name, " \t");
    char *text = end + strspn(end, " \t");
    if (!*text) text = NULL;
    *(*end ? end : name + strlen(name)) = 0;
    if (!saves_is_name(name)) return bad(in, "the name of what a game saved expected", NULL);
    if (out->saved_count == SAVES_COUNT) return bad(in, "a game saves less", NULL);
    recording_save *more = realloc(out->saved, (out->saved_count + 1) * sizeof *more);
    if (more) out->saved = more;
    const size_t first = strlen(name) + 1, second = text ? strlen(text) + 1 : 0;
    char *copy = more ? malloc(first + second) : NULL;
    if (!copy) return fail(in->error, DAFT_ERROR_MEMORY, "out of memory for a recording");
    memcpy(copy, name, first);
    if (text) memcpy(copy + first, text, second);
    more[out->saved_count++] = (recording_save){copy, text ? copy + first : NULL};
    return true;
}

static bool read_script(reader *in, recording *out)
{
    recording_script script = {0};
    const size_t length = strcspn(in->at, " \t");
    if (length == 0 || length >= sizeof script.name) return bad(in, "the name of a script expected", NULL);
    memcpy(script.name, in->at, length);
    in->at += length;
    skip_blanks(in);
    if (!read_sha256(in, script.content)) return false;
    if (out->script_count == RECORDING_SCRIPTS) return bad(in, "a game requires less", NULL);
    recording_script *grown = realloc(out->scripts, (out->script_count + 1) * sizeof *grown);
    if (!grown) return fail(in->error, DAFT_ERROR_MEMORY, "out of memory for a recording");
    out->scripts = grown;
    out->scripts[out->script_count++] = script;
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
    if (take_word(in, "saved")) return read_saved(in, out);
    if (take_word(in, "script")) return read_script(in, out);
    if (take_word(in, "pack")) return read_sha256(in, out->pack);
    if (take_word(in, "content")) return read_sha256(in, out->content);
    if (take_word(in, "limits")) return read_limits(in, out);
    if (take_word(in, "state")) return read_state(in, out);
    if (take_word(in, "entities")) return read_marks(in, out);
    if (take_word(in, "tick")) return read_mark(in, out);
    if (take_word(in, "rate")) {
        uint64_t rate;
        if (!take_count(in, &rate, "a number of ticks a second expected")) return false;
        return rate == LOOP_RATE ? line_ends(in) : bad(in, "only recordings of 60 ticks a second can be played", NULL);
    }
    if (take_word(in, "seed")) return take_count(in, &out->seed, "a whole number expected") && line_ends(in);
    if (!take_word(in, "end")) return read_event(in, out, capacity);
    uint64_t marked = out->end;
    if (!take_count(in, &out->end, "a number of ticks expected")) return false;
    if (out->end < marked) return bad(in, "the recording ends before its last tick", NULL);
    if (!is_empty(out) && last_tick(out) >= out->end) return bad(in, "the recording ends before its last event", NULL);
    *ended = true;
    return line_ends(in);
}

/* The game was killed: what came after the last mark is not whole, and is left out. */
static bool end_cut(reader *in, recording *out)
{
    if (out->end == 0)
        return fail_at(in->error, in->path, in->number, 1, "the 'end' line is missing: the file was cut short");
    while (out->count > 0 && out->items[out->count - 1].tick >= out->end) out->count--;
    while (out->line_count > 0 && out->lines[out->line_count - 1].tick >= out->end)
        free(out->lines[--out->line_count].text);
    while (out->state_count > 0 && out->states[out->state_count - 1].tick > out->end) out->state_count--;
    while (out->mark_count > 0 && out->marks[out->mark_count - 1].tick > out->end) out->mark_count--;
    out->cut = true;
    return true;
}

/* Whether the line is the file's last and without an end of its own: its writer was stopped in the middle of it. */
static bool is_half(const char *line, const char *next) { return !next && *line; }

static bool read_lines(reader *in, char *text, recording *out)
{
    size_t capacity = 0;
    bool ended = false;
    for (char *line = text; line; in->number++) {
        char *next = strchr(line, '\n');
        if (next) *next++ = 0;
        if (is_half(line, next) && out->end > 0 && !ended) break;
        size_t length = strlen(line);
        while (length > 0 && isspace((unsigned char)line[length - 1])) line[--length] = 0;
        in->line = in->at = line;
        line = next;
        skip_blanks(in);
        if (in->number == 1) {
            if (take_word(in, "daft-recording") && in->at[0] >= '1' && in->at[0] <= '6' && !in->at[1]) continue;
            return bad(in, "'daft-recording 1' expected: this is not a recording of this version", NULL);
        }
        if (*in->at == 0 || *in->at == '#') continue;
        if (!read_line(in, out, &capacity, &ended)) return false;
    }
    return ended || end_cut(in, out);
}

bool recording_load(recording *out, const daft_files *files, const char *path, daft_error *error)
{
    size_t size;
    char *text = daft_read_file(files, path, &size, error);
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
    for (size_t i = 0; i < record->saved_count; i++) free(record->saved[i].name);
    for (size_t i = 0; i < record->line_count; i++) free(record->lines[i].text);
    free(record->lines);
    free(record->saved);
    free(record->items);
    free(record->scripts);
    free(record->states);
    free(record->marks);
    *record = (recording){0};
}

void recording_play(recording *record, uint64_t tick, input *state)
{
    while (record->next < record->count && record->items[record->next].tick <= tick)
        input_apply(state, &record->items[record->next++].event);
}

const char *recording_line_at(recording *record, uint64_t tick)
{
    if (record->next_line == record->line_count || record->lines[record->next_line].tick > tick) return NULL;
    return record->lines[record->next_line++].text;
}

bool recording_add_line(recording *record, uint64_t tick, const char *text)
{
    if (record->line_count == record->line_capacity) {
        const size_t more = record->line_capacity ? 2 * record->line_capacity : 16;
        recording_line *grown = realloc(record->lines, more * sizeof *grown);
        if (!grown) return false;
        record->lines = grown, record->line_capacity = more;
    }
    char *copy = strdup(text);
    if (copy) record->lines[record->line_count++] = (recording_line){tick, copy};
    return copy != NULL;
}

bool recording_clean_line(const char *typed, char *out, size_t size)
{
    size_t length = 0;
    for (; *typed && length + 1 < size; typed++) {
        const bool blank = (unsigned char)*typed <= ' ' || *typed == 0x7F;
        if (!blank || length > 0) out[length++] = blank ? ' ' : *typed;
    }
    while (length > 0 && out[length - 1] == ' ') length--;
    out[length] = 0;
    return length > 0 && !*typed;
}
