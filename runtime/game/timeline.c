/* A game in a heap, and images of it. */
#include "game/timeline.h"

#include "common/util.h"
#include "files/saves.h"

#include <stdlib.h>
#include <string.h>

/* Ticks that take so long get an image: to go back by one more needs most of them again. */
static const uint64_t IMAGE_NS = 50000000;

struct moment {
    uint64_t tick;
    heap_image *image;
    saves *kept;
    bool fine; /* within a second that was gone through: it goes when another one is */
    game_state state;
};

/* ---- fonts ---- */

/* They are not in the heap, since they never change; so handles in images must not lose them. */
static void keep_font(void *user, font *face)
{
    timeline *self = user;
    if (self->font_count == self->font_capacity) {
        const size_t more = self->font_capacity ? 2 * self->font_capacity : 8;
        font **grown = realloc(self->fonts, more * sizeof *grown);
        if (!grown) return; /* it stays open until the program ends */
        self->fonts = grown, self->font_capacity = more;
    }
    self->fonts[self->font_count++] = face;
}

/* ---- moments ---- */

static void drop_moment(timeline *self, size_t i)
{
    heap_image_free(self->memory, self->moments[i]->image);
    saves_close(self->moments[i]->kept);
    free(self->moments[i]);
    memmove(self->moments + i, self->moments + i + 1, (--self->count - i) * sizeof(moment *));
}

/* Where there are too many bytes every other one of the older half goes, so that those far back lie farther apart. */
static void thin_out(timeline *self)
{
    const uint64_t bytes = heap_image_bytes(self->memory) + self->count * sizeof(moment);
    if (bytes <= (uint64_t)TIMELINE_BYTES) return;
    for (size_t i = self->count / 2; i-- > 1;)
        if (i % 2 == 1) drop_moment(self, i);
}

/* The last one at or before this tick; count: there is none. */
static size_t moment_before(const timeline *self, uint64_t tick)
{
    for (size_t i = self->count; i-- > 0;)
        if (self->moments[i]->tick <= tick) return i;
    return self->count;
}

static bool make_room(timeline *self)
{
    if (self->count < self->capacity) return true;
    const size_t more = self->capacity ? 2 * self->capacity : 64;
    moment **grown = realloc(self->moments, more * sizeof(moment *));
    if (grown) self->moments = grown, self->capacity = more;
    return grown != NULL;
}

/* Without memory there is just no image of it. */
static void keep_moment(timeline *self, const saves *kept, bool fine)
{
    daft_error error;
    const uint64_t tick = self->play->ticks;
    const size_t before = moment_before(self, tick), at = before == self->count ? 0 : before + 1;
    if ((before < self->count && self->moments[before]->tick == tick) || !make_room(self)) return;
    moment *fresh = malloc(sizeof *fresh);
    if (!fresh) return;
    *fresh = (moment){.tick = tick, .fine = fine, .kept = saves_clone(kept, &error)};
    if (before < self->count) heap_liken(self->memory, self->moments[before]->image);
    fresh->image = fresh->kept ? heap_keep(self->memory) : NULL;
    if (!fresh->image) {
        saves_close(fresh->kept);
        free(fresh);
        return;
    }
    memcpy(&fresh->state, self->play, sizeof *self->play);
    fresh->state.line_count = 0; /* those that wait are not of this tick */
    memmove(self->moments + at + 1, self->moments + at, (self->count++ - at) * sizeof(moment *));
    self->moments[at] = fresh;
    thin_out(self);
}

/* Those from `tick` on, but for one at it. */
static void forget_later(timeline *self, uint64_t tick)
{
    while (self->count > 0 && self->moments[self->count - 1]->tick > tick) drop_moment(self, self->count - 1);
}

static void forget_all(timeline *self)
{
    while (self->count > 0) drop_moment(self, self->count - 1);
}

static void forget_fine(timeline *self, uint64_t from, uint64_t to)
{
    for (size_t i = self->count; i-- > 0;) {
        const moment *m = self->moments[i];
        if (m->fine && (m->tick < from || m->tick > to)) drop_moment(self, i);
    }
}

/* ---- the game that plays again ---- */

/* By the trail, unheard, without leaving anything. Pictures are as they are wanted now. */
static void hold_game(timeline *self)
{
    game_state *play = self->play;
    play->def = self->live;
    play->def.replay = &self->past->made, play->def.record = NULL, play->def.trail = NULL, play->def.heard = NULL;
    play->def.answered = NULL;
    play->def.saves = self->kept;
    play->scripts.def.profile = NULL; /* what is done again is not what the game takes */
    play->scripts.def.saves = self->kept, play->scripts.replaying = play->scripts.def.quiet = true;
    self->past->made.end = self->present;
    trail_seek(self->past, play->ticks);
    self->held = true;
}

/* A heap, an engine in it, and what the game had kept at its start. */
static bool prepare(timeline *self, const game_def *live, daft_error *error)
{
    const uint64_t limit = daft_engine_memory(live->engine).limit;
    /* Blocks are up to a quarter larger than what is asked for, and those that were released wait for their like. */
    const uint64_t addresses = limit ? 4 * limit + ((uint64_t)1 << 30) : (uint64_t)64 << 30;
    daft_engine_def def = daft_default_engine_def();
    if (self->past->lost) return fail(error, DAFT_ERROR_MEMORY, "there was too much input to keep");
    self->kept = trail_saves(self->past, live->info->name, error);
    self->memory = self->kept ? heap_open(addresses, error) : NULL;
    if (!self->memory) return false;
    def.threads = daft_engine_threads(live->engine), def.isa = daft_engine_isa(live->engine);
    def.memory_limit = limit, def.allocator = *heap_allocator(self->memory);
    self->engine = daft_engine_create(&def, error);
    self->live = *live;
    self->live.engine = self->engine, self->live.memory = heap_allocator(self->memory);
    self->live.keep_font = keep_font, self->live.keeper = self, self->live.history = NULL;
    return self->engine != NULL;
}

timeline *timeline_open(const game_def *live, uint64_t present, game_state *fresh, trail *past, daft_error *error)
{
    timeline *self = calloc(1, sizeof *self);
    if (!self) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a game's past");
        return NULL;
    }
    *self = (timeline){.past = past, .first = past->first, .present = present};
    if (prepare(self, live, error)) {
        game_def again = self->live;
        past->made.end = present;
        trail_seek(past, past->first);
        again.replay = &past->made, again.record = NULL, again.trail = NULL, again.heard = NULL;
        again.quiet = true, again.answered = NULL, again.profile = NULL;
        again.saves = self->kept, again.handed = past->handed;
        if (game_open(fresh, &again, error)) self->play = fresh;
    }
    if (!self->play) {
        timeline_close(self);
        return NULL;
    }
    fresh->ticks = self->first, fresh->keys = past->keys;
    hold_game(self);
    if (!fresh->failed) keep_moment(self, self->kept, false);
    return self;
}

/* Images cost time too: those of long ago are no closer than it takes to play from one to the next. */
bool timeline_catch_up(timeline *self, uint64_t until_ns)
{
    game_state *play = self->play;
    for (uint64_t now = clock_now_ns(); play->ticks < self->present && !play->failed && now < until_ns;) {
        const uint64_t began = now;
        game_tick(play);
        now = clock_now_ns();
        self->spent_ns += now - began;
        const bool recent = self->present - play->ticks < 10 * TIMELINE_STEP && play->ticks % TIMELINE_STEP == 0;
        if (play->failed || (!recent && self->spent_ns < IMAGE_NS)) continue;
        keep_moment(self, self->kept, false);
        self->spent_ns = 0;
    }
    return play->ticks >= self->present;
}

bool timeline_take_over(timeline *self, game_state *old, daft_error *error)
{
    game_close(old);
    return daft_engine_set_files(self->engine, self->live.source->files, error);
}

void timeline_close(timeline *self)
{
    if (!self) return;
    forget_all(self);
    free(self->moments);
    if (self->play && (self->play->scene || self->play->scripts.L)) game_close(self->play);
    saves_close(self->kept);
    for (size_t i = 0; i < self->font_count; i++) {
        font_uncount(self->fonts[i]);
        font_close(self->fonts[i]);
    }
    free(self->fonts);
    daft_engine_destroy(self->engine);
    heap_close(self->memory);
    free(self);
}

void timeline_forget(timeline *self, game_state *play)
{
    forget_all(self);
    self->play = play, self->first = self->past->first;
}

/* A game that has begun again does not go back to before that. */
void timeline_keep(timeline *self)
{
    if (self->held) return;
    const bool begun = self->past->first != self->first;
    if (begun) forget_all(self);
    self->first = self->past->first;
    if (begun || self->play->ticks % TIMELINE_STEP == 0) keep_moment(self, self->play->def.saves, false);
}

/* ---- time that is held ---- */

bool timeline_hold(timeline *self, daft_error *error)
{
    saves *kept = saves_clone(self->play->def.saves, error);
    if (!kept) return false;
    saves_close(self->kept);
    self->kept = kept, self->live = self->play->def, self->present = self->play->ticks;
    if (!self->play->failed) keep_moment(self, kept, true);
    hold_game(self);
    return true;
}

bool timeline_reaches(const timeline *self, uint64_t tick) { return moment_before(self, tick) < self->count; }

/* How pictures are wanted may have changed while time is held. */
static void take_wishes(timeline *self)
{
    const game_def *now = &self->play->def;
    self->live.quality = now->quality, self->live.governor = now->governor, self->live.history = now->history;
}

/* Pictures' histories of then tell of a picture that is not on the screen now. */
static bool put_back(timeline *self, const moment *m, daft_error *error)
{
    game_state *play = self->play;
    saves *kept = saves_clone(m->kept, error);
    if (!kept) return false;
    take_wishes(self);
    saves_close(self->kept);
    self->kept = kept;
    const bool draws = self->live.history != NULL;
    while (play->line_count > 0) free(play->lines[--play->line_count]);
    heap_put_back(self->memory, m->image);
    memcpy(play, &m->state, sizeof *play);
    play->keys.queued = 0;
    daft_history_destroy(play->def.history);
    self->live.history = draws ? daft_history_create(self->engine, error) : NULL;
    hold_game(self);
    atomic_store(&play->alive_ns, clock_now_ns());
    return !draws || self->live.history;
}

bool timeline_go(timeline *self, uint64_t tick, daft_error *error)
{
    game_state *play = self->play;
    const size_t nearest = moment_before(self, tick);
    error->code = DAFT_OK;
    if (nearest == self->count)
        return fail(error, DAFT_ERROR_ARGUMENT, "nothing is known of tick %llu", (unsigned long long)tick);
    const uint64_t from = self->moments[nearest]->tick;
    if (play->failed || play->ticks > tick || play->ticks < from) {
        if (!put_back(self, self->moments[nearest], error)) return false;
        forget_fine(self, from > TIMELINE_STEP ? from - TIMELINE_STEP : 0, tick + TIMELINE_STEP);
    }
    for (uint64_t kept_ns = clock_now_ns(); play->ticks < tick && !play->failed;) {
        game_tick(play);
        if (play->failed || play->ticks == tick || clock_now_ns() - kept_ns < IMAGE_NS) continue;
        keep_moment(self, self->kept, true);
        kept_ns = clock_now_ns();
    }
    return !play->failed;
}

static void seek(recording *r, uint64_t tick)
{
    for (r->next = 0; r->next < r->count && r->items[r->next].tick < tick;) r->next++;
    for (r->next_line = 0; r->next_line < r->line_count && r->lines[r->next_line].tick < tick;) r->next_line++;
}

bool timeline_release(timeline *self, daft_error *error)
{
    game_state *play = self->play;
    take_wishes(self);
    if (!saves_take(self->live.saves, self->kept, error)) return false;
    if (!recorder_cut(self->live.record, play->ticks, game_hash(play), error)) return false;
    play->def = self->live;
    play->scripts.def.saves = self->live.saves, play->scripts.def.profile = self->live.profile;
    play->scripts.replaying = game_is_replaying(play), play->scripts.def.quiet = false;
    if (play->def.replay) seek(play->def.replay, play->ticks);
    trail_cut(self->past, play->ticks);
    forget_later(self, play->ticks);
    self->held = false;
    return true;
}
