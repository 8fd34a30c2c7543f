/* The trail of what was done, and doing it again. */
#include "game/relive.h"

#include "common/util.h"
#include "files/saves.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the trail ---- */

static bool grow(void **items, size_t *capacity, size_t count, size_t size)
{
    if (count < *capacity) return true;
    const size_t more = *capacity ? 2 * *capacity : 256;
    void *grown = realloc(*items, more * size);
    if (!grown) return false;
    *items = grown, *capacity = more;
    return true;
}

void trail_add(trail *self, uint64_t tick, const input_event *events, size_t count)
{
    for (size_t i = 0; i < count && !self->lost; i++) {
        void *items = self->made.items;
        self->lost = self->made.count == TRAIL_EVENTS ||
                     !grow(&items, &self->capacity, self->made.count, sizeof *self->made.items);
        self->made.items = items;
        if (!self->lost) self->made.items[self->made.count++] = (recording_item){tick, events[i]};
    }
}

void trail_line(trail *self, uint64_t tick, const char *text)
{
    if (!self->lost) self->lost = !recording_add_line(&self->made, tick, text);
}

void trail_saved(trail *self, const char *name, const char *text)
{
    void *items = self->made.saved;
    const size_t length = strlen(name) + 1, more = text ? strlen(text) + 1 : 0;
    char *copy = malloc(length + more);
    if (!copy || !grow(&items, &self->saved_capacity, self->made.saved_count, sizeof *self->made.saved)) {
        free(copy);
        self->lost = true;
        return;
    }
    memcpy(copy, name, length);
    if (text) memcpy(copy + length, text, more);
    self->made.saved = items;
    self->made.saved[self->made.saved_count++] = (recording_save){copy, text ? copy + length : NULL};
}

void trail_restart(trail *self, uint64_t tick, const input *keys, const saves *kept)
{
    daft_error error;
    trail_free(self);
    self->first = tick, self->keys = *keys, self->kept = saves_copy(kept, &error);
    self->lost = !self->kept;
}

void trail_free(trail *self)
{
    recording_free(&self->made);
    saves_close(self->kept);
    free(self->handed);
    *self = (trail){0};
}

static size_t first_line_at(const trail *self, uint64_t tick)
{
    size_t i = self->made.line_count;
    while (i > 0 && self->made.lines[i - 1].tick >= tick) i--;
    return i;
}

static size_t first_at(const trail *self, uint64_t tick)
{
    size_t low = 0, high = self->made.count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (self->made.items[middle].tick < tick)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

void trail_seek(trail *self, uint64_t tick)
{
    self->made.next = first_at(self, tick), self->made.next_line = first_line_at(self, tick);
}

void trail_cut(trail *self, uint64_t tick)
{
    self->made.count = first_at(self, tick);
    for (const size_t lines = first_line_at(self, tick); self->made.line_count > lines;)
        free(self->made.lines[--self->made.line_count].text);
}

/* What is saved on the way has been saved before. */
saves *trail_saves(const trail *self, const char *game, daft_error *error)
{
    saves *s = self->kept ? saves_copy(self->kept, error) : saves_open(&(saves_def){.game = game}, error);
    for (size_t i = 0; s && i < self->made.saved_count; i++) {
        if (saves_expect(s, self->made.saved[i].name, self->made.saved[i].text, error)) continue;
        saves_close(s);
        return NULL;
    }
    return s;
}

/* ---- again ---- */

/* False: too long. */
static bool catch_up(game_state *fresh, uint64_t ticks)
{
    const uint64_t began = clock_now_ns();
    while (fresh->ticks < ticks && !fresh->failed) {
        if (clock_now_ns() - began > (uint64_t)TRAIL_SECONDS * 1000000000u) return false;
        game_tick(fresh);
    }
    return true;
}

/* The rest of the old one's life is the new one's. */
static void take_over(game_state *old, game_state *fresh)
{
    memcpy(fresh->keys.queue, old->keys.queue, sizeof fresh->keys.queue);
    fresh->keys.queued = old->keys.queued;
    memcpy(fresh->lines, old->lines, sizeof fresh->lines);
    fresh->line_count = old->line_count, old->line_count = 0;
    fresh->def = old->def;
    fresh->scripts.def.saves = old->def.saves, fresh->scripts.def.printed = old->def.printed;
    fresh->scripts.replaying = old->scripts.replaying;
}

/* The game that is there begins with this tick, and with what it was handed. */
static void restart_trail(trail *self, const game_state *fresh, saves *kept, char *handed)
{
    trail_free(self);
    self->first = fresh->ticks, self->keys = fresh->keys, self->kept = kept, self->handed = handed;
    self->lost = !kept;
}

/* What was to be said of the one that failed. */
static relive_end refuse(game_state *fresh, const game_state *old, char message[HOST_MESSAGE])
{
    daft_error ignored;
    snprintf(message, HOST_MESSAGE, "%s", fresh->scripts.failure.message);
    game_close(fresh);
    daft_engine_set_files(old->def.engine, old->def.source->files, &ignored);
    return RELIVE_FAILED;
}

/* RELIVE_LONG: it has no daft.reload, so that the input must do. */
static relive_end hand_over(game_state *old, game_state *fresh, trail *from, char message[HOST_MESSAGE],
                            daft_error *error)
{
    if (!host_hand_over(&old->scripts)) {
        snprintf(message, HOST_MESSAGE, "%s", old->scripts.failure.message);
        return RELIVE_FAILED;
    }
    game_def def = old->def;
    char *handed = old->scripts.handed;
    saves *kept = saves_copy(old->def.saves, error);
    old->scripts.handed = NULL;
    def.record = NULL, def.trail = NULL, def.heard = NULL, def.handed = handed;
    def.sounds = old->scripts.cache;
    if (!kept || !game_open(fresh, &def, error)) {
        char text[1100];
        snprintf(message, HOST_MESSAGE, "%.900s", daft_error_text(error, text, sizeof text));
        saves_close(kept), free(handed);
        return RELIVE_FAILED;
    }
    const bool can = fresh->failed || host_has(&fresh->scripts, "reload");
    if (fresh->failed || !can) {
        saves_close(kept), free(handed);
        refuse(fresh, old, message);
        return can ? RELIVE_FAILED : RELIVE_LONG;
    }
    fresh->ticks = old->ticks, fresh->keys = old->keys;
    take_over(old, fresh);
    game_close(old);
    restart_trail(from, fresh, kept, handed);
    daft_engine_set_files(def.engine, def.source->files, error); /* the one that was closed let go of them */
    return RELIVE_HANDED;
}

relive_end relive(game_state *old, game_state *fresh, trail *from, char message[HOST_MESSAGE], daft_error *error)
{
    const failure shown = old->scripts.failure; /* calls into it forget why it has stopped */
    const relive_end handed =
        host_has(&old->scripts, "reload") ? hand_over(old, fresh, from, message, error) : RELIVE_LONG;
    if (handed == RELIVE_HANDED) return handed;
    old->scripts.failure = shown;
    if (handed == RELIVE_FAILED) return handed;
    if (from->lost) return RELIVE_LONG;
    saves *kept = trail_saves(from, old->def.info->name, error);
    game_def def = old->def;
    from->made.next = from->made.next_line = 0, from->made.end = old->ticks;
    def.replay = &from->made, def.record = NULL, def.trail = NULL, def.heard = NULL, def.printed = NULL,
    def.answered = NULL, def.saves = kept;
    def.handed = from->handed, def.sounds = old->scripts.cache;
    bool good = kept && game_open(fresh, &def, error);
    const bool opened = good;
    if (good) fresh->ticks = from->first, fresh->keys = from->keys;
    bool in_time = good && catch_up(fresh, old->ticks);
    if (good && in_time && !fresh->failed) {
        take_over(old, fresh);
        game_close(old);
    } else if (opened) {
        snprintf(message, HOST_MESSAGE, "%s", fresh->scripts.failure.message);
        good = in_time && !fresh->failed;
        game_close(fresh);
    } else {
        char text[1100];
        snprintf(message, HOST_MESSAGE, "%.900s", daft_error_text(error, text, sizeof text));
    }
    saves_close(kept);
    daft_engine_set_files(def.engine, def.source->files, error); /* the one that was closed let go of them */
    return good ? RELIVE_DONE : opened && !in_time ? RELIVE_LONG : RELIVE_FAILED;
}
