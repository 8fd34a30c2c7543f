/* Plays one game on a platform. */
#include "session/state.h"

#include "common/stop.h"
#include "common/util.h"
#include "session/costs.h"
#include "session/hot.h"
#include "platform/audio.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- the early end ---- */

/* On the watchdog's thread. Esc must answer within 100 ms: where nobody has looked at the events for a while, and
 * nothing came to its end, it looks. With a pause menu Esc leaves only where the game is stuck: it waits longer, and
 * for a picture longer still. Where a file is yet to be written, or the menu is to come back, the game has more time to
 * end well. */
static int asked(void *user)
{
    enum { OLD_NS = 20000000, STUCK_NS = 50000000, PICTURE_NS = 300000000, SHORT_MS = 30, LONG_MS = 1500 };
    session *s = user;
    platform *screen = s->def->screen;
    const uint64_t now = clock_now_ns(), polled = atomic_load(&s->polled_ns), alive = atomic_load(&s->play->alive_ns);
    const uint64_t least = !s->def->pauses ? OLD_NS : atomic_load(&s->play->rendering) ? PICTURE_NS : STUCK_NS;
    if (!screen->leave_waits || now - (polled > alive ? polled : alive) < least) return 0;
    if (!screen->leave_waits(screen)) return 0;
    atomic_store(&s->leaving, true);
    return s->def->stays || s->def->shot || s->def->stats || s->def->hash ? LONG_MS : SHORT_MS;
}

/* Before an early end of the program, on another thread. The window goes first: a disk may be slow. */
static void end_early(void *user)
{
    daft_error error;
    session *s = user;
    if (atomic_load(&s->leaving)) s->def->screen->hide(s->def->screen);
    if (!recorder_finish(s->record, &error)) report(&error);
    if (!trace_finish(s->spans, &error)) report(&error);
}

/* ---- the loop ---- */

static bool is_over(const session *s)
{
    return s->left || s->closed || atomic_load(&s->leaving) || s->play->over ||
           s->play->ticks >= session_last_tick(s) || (s->play->failed && s->def->screen->headless);
}

static bool run_updates(session *s, int updates, daft_error *error)
{
    uint64_t began = clock_now_ns();
    for (int i = 0; i < updates && !is_over(s); i++) {
        uint64_t before = s->play->ticks;
        game_tick(s->play);
        if (s->play->ticks > before && !s->play->failed && !session_after_tick(s, error)) return false;
    }
    const double ms = (double)(clock_now_ns() - began) / 1e6;
    if (updates > 0 && !s->play->failed) s->update_ms = session_smooth(s->update_ms, ms), s->drawn_ms += ms;
    graph_add_update(&s->graph, ms);
    return true;
}

/* As many updates as a frame has time for. */
static bool run_at_full_speed(session *s, daft_error *error)
{
    const uint64_t end = clock_now_ns() + 1000000000u / LOOP_RATE;
    bool good = true;
    do good = run_updates(s, 1, error);
    while (good && isinf(session_speed(s)) && !is_over(s) && clock_now_ns() < end);
    return good;
}

/* The time that a frame may take: the player's word goes first, then the game's. In a window a picture is wanted 60
 * times a second. */
static double target_of(const session *s)
{
    const double set = pause_target_ms(&s->settings), game = s->play->scripts.target_ms;
    const double player = set >= 0 && (s->paced || s->def->target_ms < 0) ? set : s->def->target_ms;
    if (s->def->screen->headless) return 0;
    return player >= 0 ? player : game >= 0 ? game : 1000.0 / 60;
}

/* Between two frames. `elapsed`: since the one before. */
static void govern(session *s, double elapsed)
{
    const double target = target_of(s), spent = s->drawn_ms;
    s->drawn_ms = 0;
    if (target != (s->governs ? s->pace.target_ms : 0)) {
        governor_costs costs = s->pace.known;
        const bool known = s->governs || costs_load(s->def->costs, s->info->name, &costs);
        governor_begin(&s->pace, target, known ? &costs : NULL);
        s->governs = target > 0;
    } else if (s->governs && spent > 0 && !s->play->failed && !(s->reused && spent < target)) {
        governor_frame(&s->pace, spent, elapsed);
    }
    s->play->def.governor = s->governs ? &s->pace : NULL;
}

/* The game holds the mouse while it asks for it; the error screen releases it. */
static void grab_mouse(session *s, bool grab)
{
    if (grab != s->grabbed) s->def->screen->grab_mouse(s->def->screen, grab);
    s->grabbed = grab;
}

/* The window as the game wishes it, where that is something new: what the player has changed since stays. */
static void grant_window(session *s)
{
    const window_wish *wish = &s->play->scripts.window, before = s->granted;
    platform *screen = s->def->screen;
    if (wish->changes == 0 || (wish->changes == before.changes && wish->icon == before.icon)) return;
    s->granted = *wish;
    if (wish->title[0] && strcmp(wish->title, before.title) != 0) screen->set_title(screen, wish->title);
    if (screen->set_size && wish->width > 0 && (wish->width != before.width || wish->height != before.height))
        screen->set_size(screen, wish->width, wish->height);
    if (screen->full_screen && wish->full_screen >= 0 && wish->full_screen != before.full_screen)
        screen->full_screen(screen, wish->full_screen);
    if (screen->set_icon && wish->icon) screen->set_icon(screen, wish->icon);
}

/* What gamepads are to do, once for each wish. */
static void rumble(session *s)
{
    host *scripts = &s->play->scripts;
    platform *screen = s->def->screen;
    if (scripts->rumble_seconds > 0 && screen->rumble) screen->rumble(screen, scripts->rumble, scripts->rumble_seconds);
    scripts->rumble_seconds = 0;
}

/* The game's last picture with the menu over it. No time passes. */
static bool turn_paused(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    int width, height;
    session_picture_size(s->def, &width, &height);
    s->redraws |= !s->picture || width != daft_image_width(s->picture) || height != daft_image_height(s->picture);
    s->last_ns = screen->now_ns(screen);
    graph_end_frame(&s->graph, 0);
    grab_mouse(s, false);
    if (s->redraws) {
        if (!session_draw(s, loop_alpha(&s->clock), error)) return false;
        canvas over = canvas_over(s->picture);
        if (!s->play->failed) pause_draw(&s->pause, &over, s->def->face, s->info->title);
        s->redraws = false, s->drawn_ms = 0;
    }
    session_survey(s, loop_alpha(&s->clock));
    if (screen->wants_frame(screen) && !screen->present(screen, s->picture, error)) return false;
    screen->end_frame(screen);
    return true;
}

static bool turn(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    session_take_events(s);
    if (s->pause.open) return turn_paused(s, error);
    if (session_holds_time(s)) {
        grab_mouse(s, false);
        return session_turn_held(s, error);
    }
    if (s->wants_reload) {
        s->wants_reload = s->reported = false;
        s->granted.changes = 0;
        if (!game_reload(s->play, error)) return false;
    }
    if (!session_take_changes(s, error)) return false;
    grab_mouse(s, s->play->scripts.grab && !s->play->failed && !tools_want_mouse(&s->tools));
    uint64_t now = screen->now_ns(screen);
    uint64_t elapsed = now - s->last_ns;
    s->last_ns = now;
    if (s->turns++ > 1)
        s->turn_ms = session_smooth(s->turn_ms, (double)elapsed / 1e6); /* the first turns have no interval */
    graph_end_frame(&s->graph, s->turns > 2 ? (double)elapsed / 1e6 : 0);
    govern(s, (double)elapsed / 1e6);
    const bool full_speed = isinf(session_speed(s)) && !s->def->screen->headless;
    if (!(full_speed ? run_at_full_speed(s, error) : run_updates(s, session_updates_due(s, elapsed), error)))
        return false;
    session_keep_pace(s);
    grant_window(s);
    rumble(s);
    if (!atomic_load(&s->leaving) && (s->def->every_frame || screen->wants_frame(screen))) {
        if (!session_draw(s, loop_alpha(&s->clock), error)) return false;
        const uint64_t began = trace_begin(s->spans);
        const bool good = screen->present(screen, s->picture, error);
        trace_end(s->spans, "present", began);
        if (!good) return false;
    }
    session_report(s);
    if (s->wants_shot) session_user_shot(s);
    s->wants_shot = false;
    if (s->def->progress && session_last_tick(s) != UINT64_MAX)
        progress_show(&s->bar, (double)s->play->ticks / (double)session_last_tick(s));
    const uint64_t idle = trace_begin(s->spans);
    screen->end_frame(screen);
    trace_end(s->spans, "wait", idle);
    return true;
}

/* ---- from begin to end ---- */

static void record_saved(void *user, const char *name, const char *text)
{
    session *s = user;
    recorder_saved(s->record, name, text);
    trail_saved(&s->past, name, text);
}

/* A replay is given what its recording was, and writes nothing. */
static bool open_saves(session *s, daft_error *error)
{
    const saves_def def = {
        .folder = s->def->replay ? NULL : s->def->saves, .game = s->info->name, .told = record_saved, .user = s};
    s->kept = saves_open(&def, error);
    s->own = saves_open(&(saves_def){.folder = s->def->settings, .game = "DAFT"}, error);
    if (!s->own) return false;
    s->settings = settings_load(s->own), s->pause.settings = &s->settings;
    if (s->def->pauses) session_apply(s);
    session_load_keys(s);
    for (size_t i = 0; s->kept && i < s->replay.saved_count; i++)
        if (!saves_expect(s->kept, s->replay.saved[i].name, s->replay.saved[i].text, error)) return false;
    return s->kept != NULL;
}

static void heard(void *user, const int16_t *frames)
{
    session *s = user;
    if (s->sounds.writer) tape_put(&s->sounds, frames, SOUND_TICK);
    if (s->def->speaks && session_speed(s) == 1) audio_play(frames, SOUND_TICK);
}

static void printed(void *user, const char *text, size_t size) { tools_printed(&((session *)user)->tools, text, size); }

static void answered(void *user, const char *line, const char *answer, bool good)
{
    session *s = user;
    tools_answered(&s->tools, line, answer, good, game_is_replaying(s->play));
}

static bool run(session *s, daft_error *error)
{
    if (!session_open_replay(s, error) || !open_saves(s, error)) return false;
    if (s->def->sound && !tape_begin(&s->sounds, s->def->sound, error)) return false;
    if (s->def->trace && !(s->spans = trace_open(s->def->trace, TRACE_EVENTS, error))) return false;
    stop_set_act(end_early, s);
    const session_def *def = s->def;
    s->history = daft_history_create(def->engine, error);
    if (!s->history) return false;
    game_def play = {.where = def->where,
                     .info = s->info,
                     .source = s->source,
                     .engine = def->engine,
                     .face = def->face,
                     .quality = session_quality(s),
                     .seed = def->replay ? s->replay.seed : def->seed,
                     .replay = def->replay ? &s->replay : NULL,
                     .record = s->record,
                     .spans = s->spans,
                     .trail = s->def->watches ? &s->past : NULL,
                     .history = s->history,
                     .saves = s->kept,
                     .map = &s->keys,
                     .keyboard = def->screen,
                     .profile = &s->profile,
                     .seconds = def->seconds,
                     .required = def->record || s->replay.script_count ? session_required : NULL,
                     .asked = asked,
                     .printed = def->screen->headless ? NULL : printed,
                     .answered = def->screen->headless ? NULL : answered,
                     .heard = s->sounds.writer || s->def->speaks ? heard : NULL,
                     .user = s};
    hot_switch(s);
    watch_begin(&s->files, s->def->watches && !s->info->packed ? s->info->folder : NULL);
    if (!game_open(s->play, &play, error) || !session_compare_scripts(s, error)) return false;
    progress_begin(&s->bar, s->info->title);
    s->last_ns = def->screen->now_ns(def->screen), s->began_ns = clock_now_ns();
    bool good = true;
    while (good && !is_over(s)) {
        const uint64_t began = trace_begin(s->spans);
        good = turn(s, error);
        trace_end(s->spans, "frame", began);
    }
    if (atomic_load(&s->leaving)) session_take_events(s);
    grab_mouse(s, false);
    progress_end(&s->bar);
    session_report(s);
    good = good && session_at_end(s, error) && hot_write(s, error);
    session_report(s);
    return good;
}

/* Puts the recording in place and the window out of sight, before memory is freed, which may take long. */
static bool leave(session *s, daft_error *error)
{
    stop_set_act(NULL, NULL);
    bool good = recorder_finish(s->record, error);
    good = tape_commit(&s->sounds, good ? error : NULL) && good;
    good = trace_finish(s->spans, good ? error : NULL) && good;
    if ((s->left || s->closed) && !s->def->stays) s->def->screen->hide(s->def->screen);
    return good;
}

session_end session_play(const session_def *def, const game_info *info, daft_error *error)
{
    session s = {.def = def, .info = info, .granted.full_screen = -1};
    s.play = &s.games[0];
    char title[160];
    snprintf(title, sizeof title, "%s - DAFT", info->title);
    def->screen->set_title(def->screen, title);
    *error = (daft_error){0};
    game_source own = {0};
    bool good = def->source || source_open(&own, def->where, info, error);
    s.source = def->source ? def->source : &own;
    good = good && run(&s, error);
    if (!leave(&s, good ? error : NULL)) good = false;
    if (s.governs && (s.pace.changes || governor_is_surveyed(&s.pace)))
        costs_save(def->costs, info->name, &s.pace.known);
    bool failed = s.play->failed && (def->screen->headless || s.play->over);
    if (s.play->scene || s.play->scripts.L) game_close(s.play);
    daft_history_destroy(s.history);
    session_close_time(&s);
    daft_engine_set_files(def->engine, NULL, NULL);
    source_close(&own);
    saves_close(s.kept);
    saves_close(s.own);
    recorder_free(s.record);
    recording_free(&s.replay);
    daft_image_destroy(s.picture);
    probe_end(&s.prices);
    daft_image_destroy(s.survey.whole);
    daft_image_destroy(s.survey.reference);
    frame_times_free(&s.times);
    trail_free(&s.past);
    trace_free(s.spans);
    profile_free(&s.profile);
    tools_free(&s.tools);
    if (!good || failed) return SESSION_FAILED;
    return s.closed ? SESSION_CLOSED : s.left ? SESSION_LEFT : SESSION_DONE;
}
