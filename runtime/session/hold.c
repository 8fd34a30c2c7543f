/* Time that the player holds: F5 goes back, F6 forward, Space goes on from there. Held down, each moves as fast as the
 * game runs, and faster after a while. The game hears nothing meanwhile. */
#include "session/state.h"

#include "common/util.h"
#include "hud/screens.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double HELD_SECONDS = 0.35; /* a key that is down for less was tapped */

bool session_holds_time(const session *s) { return s->time.catches_up || (s->time.line && s->time.line->held); }

/* ---- holding and going on ---- */

/* The first time, and after live reloads: the game is to be played again from its start. */
static void begin_catching_up(session *s)
{
    daft_error error;
    const timeline *line = s->time.line;
    const bool held = line && line->held;
    game_state *fresh = s->play == s->games ? &s->games[1] : s->games;
    s->time.catches_up = timeline_open(held ? &line->live : &s->play->def, held ? line->present : s->play->ticks, fresh,
                                       &s->past, &error);
    if (!s->time.catches_up) session_tell(s, error.message);
}

static void hold(session *s)
{
    daft_error error;
    time_hold *t = &s->time;
    t->hands = s->play->keys;
    input_begin_tick(&t->hands);
    input_apply_queue(&t->hands);
    t->way = 0, s->redraws = true;
    if (t->line && !timeline_hold(t->line, &error)) session_tell(s, error.message);
    if (!t->line) begin_catching_up(s);
}

/* What the player's hands have changed while the game heard nothing. */
static void tell_hands(session *s)
{
    const input *now = &s->time.hands, *then = &s->play->keys;
    s->play->keys.queued = 0;
    for (int key = 0; key < INPUT_KEYS; key++)
        if (now->down[key] != then->down[key])
            input_push(&s->play->keys, &(input_event){.kind = INPUT_KEY, .key = key, .down = now->down[key]});
    for (int i = 0; i < INPUT_STICKS; i++)
        if (now->stick[i] < then->stick[i] || now->stick[i] > then->stick[i])
            input_push(&s->play->keys, &(input_event){.kind = INPUT_STICK, .key = i, .x = now->stick[i]});
    input_push(&s->play->keys, &(input_event){.kind = INPUT_MOVE, .x = now->mouse_x, .y = now->mouse_y});
}

static bool release_line(session *s)
{
    daft_error error;
    if (!timeline_release(s->time.line, &error)) {
        session_tell(s, error.message);
        return false;
    }
    if (s->agreed.state > 0 && s->play->ticks < s->time.line->present) s->agreed = (agreement){.told = s->agreed.told};
    tell_hands(s);
    return true;
}

static void stop_catching_up(session *s)
{
    timeline_close(s->time.catches_up);
    s->time.catches_up = NULL;
}

void session_release_time(session *s)
{
    if (s->time.catches_up) {
        stop_catching_up(s);
        tell_hands(s);
    }
    if (s->time.line && s->time.line->held) release_line(s);
    s->time.way = 0;
}

void session_close_time(session *s)
{
    timeline_close(s->time.catches_up);
    timeline_close(s->time.line);
}

/* ---- going through time ---- */

static bool go(session *s, uint64_t tick, daft_error *error)
{
    const bool good = timeline_go(s->time.line, tick, error);
    s->history = s->play->def.history;
    s->redraws = true, s->reported = false;
    return good || s->play->failed;
}

/* The present moves on by one tick, with what the player holds. */
static bool step_present(session *s, daft_error *error)
{
    if (s->play->failed || !release_line(s)) return true;
    const uint64_t before = s->play->ticks;
    game_tick(s->play);
    s->redraws = true;
    if (s->play->ticks > before && !s->play->failed && !session_after_tick(s, error)) return false;
    return timeline_hold(s->time.line, error);
}

/* By so many ticks, forward or back. */
static bool move(session *s, int64_t ticks, daft_error *error)
{
    timeline *line = s->time.line;
    const uint64_t now = s->play->ticks, back = (uint64_t)(ticks < 0 ? -ticks : 0);
    /* A game that has failed stands in the tick that failed: the one before it is the last that is whole. */
    const uint64_t before = s->play->failed ? now : now - back;
    const uint64_t wanted = ticks > 0 ? now + (uint64_t)ticks : now - line->first < back ? line->first : before;
    if (ticks < 0 && !timeline_reaches(line, wanted)) {
        s->time.wanted = wanted;
        begin_catching_up(s);
        return true;
    }
    if (wanted <= line->present && !(s->play->failed && ticks > 0)) return go(s, wanted, error);
    if (now < line->present && !go(s, line->present, error)) return false;
    return step_present(s, error);
}

/* How many ticks F5 or F6 have moved on since the last turn. */
static int64_t ticks_moved(time_hold *t, uint64_t now)
{
    const double down = (double)(now - t->since_ns) / 1e9, elapsed = (double)(now - t->moved_ns) / 1e9;
    t->moved_ns = now;
    if (t->way == 0 || down < HELD_SECONDS) return 0;
    const double speed = down < 2 ? 1 : down < 4 ? 4 : 16;
    t->owed += speed * (elapsed < 0.25 ? elapsed : 0.25) * LOOP_RATE;
    const int64_t ticks = (int64_t)t->owed;
    t->owed -= (double)ticks;
    return t->way * ticks;
}

/* ---- keys ---- */

static void take_way(session *s, int way)
{
    daft_error error;
    time_hold *t = &s->time;
    const bool held = session_holds_time(s);
    if (!held) hold(s);
    t->way = way, t->owed = 0;
    t->since_ns = t->moved_ns = s->def->screen->now_ns(s->def->screen);
    if (t->catches_up) {
        if (held) t->wanted -= way < 0 && t->wanted > s->past.first;
        if (!held) t->wanted = s->play->ticks - (way < 0 && !s->play->failed && s->play->ticks > s->past.first);
    } else if (t->line && t->line->held && (held || way < 0) && !move(s, way, &error)) {
        session_tell(s, error.message);
    }
}

bool session_take_time_key(session *s, const input_event *event)
{
    const char *name = event->kind == INPUT_KEY ? input_key_name(event->key) : "";
    const int way = strcmp(name, "f5") == 0 ? -1 : strcmp(name, "f6") == 0 ? 1 : 0;
    if (!s->def->watches) return false; /* there is no trail */
    if (way) {
        if (event->down && s->time.way != way) take_way(s, way);
        if (!event->down && s->time.way == way) s->time.way = 0;
        return true;
    }
    if (!session_holds_time(s)) return false;
    if (event->down && (strcmp(name, "space") == 0 || strcmp(name, "return") == 0)) {
        session_release_time(s);
        return true;
    }
    return false;
}

/* ---- a turn ---- */

/* The game that has caught up takes the place of the one that ran. */
static bool take_over(session *s, daft_error *error)
{
    time_hold *t = &s->time;
    timeline *caught_up = t->catches_up;
    daft_history_destroy(s->history);
    s->history = NULL, s->play->def.history = NULL;
    const bool good = timeline_take_over(caught_up, s->play, error);
    s->play = caught_up->play, s->reported = false;
    timeline_close(t->line);
    t->line = caught_up, t->catches_up = NULL;
    s->history = s->play->def.history = good ? daft_history_create(s->play->def.engine, error) : NULL;
    return s->history && go(s, t->wanted, error);
}

static bool catch_up(session *s, daft_error *error)
{
    enum { CHUNK_NS = 30000000 };
    timeline *fresh = s->time.catches_up;
    const bool there = timeline_catch_up(fresh, clock_now_ns() + CHUNK_NS);
    s->redraws = true;
    if (!fresh->play->failed) return !there || take_over(s, error);
    char text[HOST_MESSAGE];
    snprintf(text, sizeof text, "The game does not play again as it did: %.300s", fresh->play->scripts.failure.message);
    stop_catching_up(s);
    session_tell(s, text);
    return true;
}

static void draw_line(session *s)
{
    char text[200];
    const timeline *fresh = s->time.catches_up, *line = s->time.line;
    const double now = (double)s->play->ticks;
    if (fresh)
        snprintf(text, sizeof text, "Looking back: %.0f %%      Space  go on",
                 100.0 * (double)(fresh->play->ticks - fresh->first) / (double)(fresh->present - fresh->first + 1));
    else
        snprintf(text, sizeof text,
                 "Held at %.2f s, tick %.0f of %" PRIu64 "      F5  back      F6  forward      Space  go on from here",
                 now / LOOP_RATE, now, line->present);
    canvas over = canvas_over(s->picture);
    screen_notice(&over, s->def->face, text, false);
}

static bool present(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    int width, height;
    session_picture_size(s->def, &width, &height);
    s->redraws |= !s->picture || width != daft_image_width(s->picture) || height != daft_image_height(s->picture);
    if (s->redraws && screen->wants_frame(screen)) {
        if (!session_draw(s, 1, error)) return false;
        if (session_holds_time(s) && !s->play->failed && !(s->notice[0] && s->notice_ns)) draw_line(s);
        s->redraws = false, s->drawn_ms = 0;
    }
    return !screen->wants_frame(screen) || screen->present(screen, s->picture, error);
}

bool session_turn_held(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    s->last_ns = screen->now_ns(screen); /* no time passes */
    graph_end_frame(&s->graph, 0);
    if (s->notice[0] && s->notice_ns && s->last_ns > s->notice_ns) {
        s->notice[0] = 0, s->notice_ns = 0, s->redraws = true;
    }
    s->redraws |= tools_want_mouse(&s->tools); /* the console and the inspector change by themselves */
    if (s->wants_reload) {
        session_release_time(s);
        return true; /* the next turn does it */
    }
    if (s->time.catches_up) {
        if (!catch_up(s, error)) return false;
    } else {
        const int64_t ticks = ticks_moved(&s->time, s->last_ns);
        if (ticks != 0 && !move(s, ticks, error)) return false;
    }
    if (!present(s, error)) return false;
    session_report(s);
    if (s->wants_shot) session_user_shot(s);
    s->wants_shot = false;
    screen->end_frame(screen);
    return true;
}
