/* Runs one game, tick by tick. */
#include "game/game.h"

#include "files/saves.h"

#include "game/ear.h"
#include "game/loop.h"
#include "game/relive.h"
#include "common/util.h"
#include "lua/statement.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool stop(game_state *state)
{
    state->failed = true;
    return false;
}

/* Turns an engine error outside a script into the game's message. */
static bool stop_with(game_state *state, const char *what, const daft_error *error)
{
    char text[1100];
    failure *now = &state->scripts.failure;
    failure_clear(now);
    snprintf(now->message, sizeof now->message, "%s: %.900s", what, daft_error_text(error, text, sizeof text));
    return stop(state);
}

bool game_is_replaying(const game_state *state) { return state->def.replay && state->ticks < state->def.replay->end; }

static bool start(game_state *state, daft_error *error)
{
    state->failed = state->over = false;
    state->scene = daft_scene_create(state->def.engine, error);
    if (!state->scene) return false;
    host_def def = {.files = state->def.source->files,
                    .scripts = state->def.where->scripts,
                    .folder = state->def.info->folder,
                    .name = state->def.info->name,
                    .engine = state->def.engine,
                    .memory = state->def.memory,
                    .sounds = state->def.sounds,
                    .keep_font = state->def.keep_font,
                    .keeper = state->def.keeper,
                    .scene = state->scene,
                    .keys = &state->keys,
                    .map = state->def.map,
                    .keyboard = state->def.keyboard,
                    .face = state->def.face,
                    .saves = state->def.saves,
                    .spans = state->def.spans,
                    .profile = state->def.profile,
                    .seed = state->def.seed,
                    .seconds = state->def.seconds,
                    .required = state->def.required,
                    .asked = state->def.asked,
                    .printed = state->def.printed,
                    .quiet = state->def.quiet,
                    .user = state->def.user};
    bool good = host_open(&state->scripts, &def);
    state->scripts.replaying = game_is_replaying(state);
    state->failed =
        !good || !host_load(&state->scripts) || (state->def.handed && !host_reload(&state->scripts, state->def.handed));
    return true;
}

static void end(game_state *state)
{
    state->def.handed = NULL;
    while (state->line_count > 0) free(state->lines[--state->line_count]);
    host_close(&state->scripts);
    daft_scene_destroy(state->scene);
    state->scene = NULL;
}

bool game_open(game_state *state, const game_def *def, daft_error *error)
{
    *state = (game_state){.def = *def, .keys.width = CANVAS_HEIGHT * 16.0f / 9.0f};
    if (!def->source && !source_open(&state->own, def->where, def->info, error)) return false;
    if (!def->source) state->def.source = &state->own;
    if (!def->saves) state->def.saves = state->own_saves = saves_open(&(saves_def){.game = def->info->name}, error);
    if (!state->def.saves) {
        source_close(&state->own);
        return false;
    }
    if (daft_engine_set_files(def->engine, state->def.source->files, error) && start(state, error)) return true;
    game_close(state);
    return false;
}

void game_close(game_state *state)
{
    end(state);
    daft_engine_set_files(state->def.engine, NULL, NULL);
    source_close(&state->own);
    saves_close(state->own_saves);
    state->own_saves = NULL;
}

bool game_reload(game_state *state, daft_error *error)
{
    end(state);
    if (state->def.trail) trail_restart(state->def.trail, state->ticks, &state->keys, state->def.saves);
    return start(state, error);
}

static void take_input(game_state *state)
{
    input *keys = &state->keys;
    input_begin_tick(keys);
    bool replaying = game_is_replaying(state);
    if (replaying) {
        input_drop_queue(keys);
        recording_play(state->def.replay, state->ticks, keys);
    } else {
        if (state->scripts.replaying) input_push_release_all(keys); /* the recording has just ended */
        input_apply_queue(keys);
    }
    state->scripts.replaying = replaying;
    if (state->def.trail) trail_add(state->def.trail, state->ticks, keys->applied, keys->applied_count);
    if (state->def.record) recorder_tick(state->def.record, state->ticks, keys->applied, keys->applied_count);
}

static bool call_key_handlers(game_state *state)
{
    const input *keys = &state->keys;
    const int restart = input_key_find(INPUT_RESTART);
    for (size_t i = 0; i < keys->applied_count; i++) {
        const input_event *event = &keys->applied[i];
        if (event->kind == INPUT_KEY && event->key == restart) {
            state->scripts.restart |= event->down;
            continue;
        }
        if (event->kind == INPUT_TEXT && !host_typed(&state->scripts, event->key)) return false;
        if (event->kind == INPUT_KEY && !host_key(&state->scripts, event->key, event->down)) return false;
    }
    return true;
}

/* ---- lines of Lua ---- */

bool game_run_line(game_state *state, const char *text)
{
    char line[STATEMENT_SIZE];
    if (state->failed || state->line_count == GAME_LINES || game_is_replaying(state)) return false;
    if (!recording_clean_line(text, line, sizeof line)) return false;
    char *copy = strdup(line);
    if (copy) state->lines[state->line_count++] = copy;
    return copy != NULL;
}

static bool run_line(game_state *state, const char *text)
{
    char answer[STATEMENT_ANSWER];
    if (state->def.trail) trail_line(state->def.trail, state->ticks, text);
    if (state->def.record) recorder_line(state->def.record, state->ticks, text);
    const statement_end ended = host_run_statement(&state->scripts, text, answer);
    if (state->def.answered) state->def.answered(state->def.user, text, answer, ended == STATEMENT_DONE);
    return ended != STATEMENT_STOPPED;
}

static bool run_lines(game_state *state)
{
    bool good = true;
    if (game_is_replaying(state))
        for (const char *text; good && (text = recording_line_at(state->def.replay, state->ticks));)
            good = run_line(state, text);
    for (size_t i = 0; i < state->line_count; i++) {
        if (good && !game_is_replaying(state)) good = run_line(state, state->lines[i]);
        free(state->lines[i]);
    }
    state->line_count = 0;
    return good;
}

/* Ends the watchdog's section `what`; false where it took too long. */
static bool in_time(game_state *state, const char *what)
{
    watchdog_state ended = watchdog_end(state->scripts.dog);
    if (ended == WATCHDOG_ASKED) state->scripts.asked = true;
    if (ended == WATCHDOG_RUNNING) return true;
    failure *now = &state->scripts.failure;
    failure_clear(now);
    snprintf(now->message, sizeof now->message, ended == WATCHDOG_LATE ? "%s took longer than %g s" : "%s was stopped",
             what, watchdog_limit(state->scripts.dog));
    return stop(state);
}

static bool step(game_state *state)
{
    static const char name[] = "the simulation of one tick";
    daft_error error;
    const float dt = (float)state->scripts.scale / LOOP_RATE;
    if (dt == 0) return true;
    const uint64_t began = trace_begin(state->def.spans);
    watchdog_begin(state->scripts.dog, name, 1);
    bool good = daft_scene_step(state->scene, dt, &error);
    trace_step(state->def.spans, state->scene, began);
    return in_time(state, name) && (good || stop_with(state, "simulation", &error));
}

static void sound_on(game_state *state)
{
    int16_t frames[2 * SOUND_TICK];
    mixer *m = &state->scripts.mixer;
    if (!state->def.heard) {
        mixer_tick(m, NULL);
        return;
    }
    const uint64_t began = trace_begin(state->def.spans);
    ear_listen(m, state->scene);
    mixer_tick(m, frames);
    trace_end(state->def.spans, "sound", began);
    state->def.heard(state->def.user, frames);
}

static bool tick(game_state *state)
{
    daft_scene_begin_tick(state->scene);
    take_input(state);
    host_begin_tick(&state->scripts);
    if (!host_collect(&state->scripts) || !run_lines(state) || !call_key_handlers(state) ||
        !host_update(&state->scripts, 1.0 / LOOP_RATE))
        return stop(state);
    if (!step(state)) return false;
    sound_on(state);
    daft_error error;
    state->ticks++;
    host_end_tick(&state->scripts);
    atomic_store(&state->alive_ns, clock_now_ns());
    state->over = state->scripts.quit;
    if (state->scripts.restart && !state->over && !game_reload(state, &error))
        return stop_with(state, "restart", &error);
    if (state->def.record) recorder_state(state->def.record, state->ticks, game_hash(state), state->scene);
    return !state->failed;
}

bool game_tick(game_state *state)
{
    if (state->failed) return false;
    const uint64_t began = trace_begin(state->def.spans);
    const bool good = tick(state);
    trace_end(state->def.spans, "tick", began);
    return good;
}

static bool keep_drawing(void *user, float unused)
{
    (void)unused;
    return watchdog_look(user) <= WATCHDOG_RUNNING;
}

static daft_view view_of(const game_state *state, float alpha)
{
    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(state->scene, alpha);
    view.alpha = alpha;
    view.quality = quality_choose(&state->def.quality, state->scene);
    view.history = state->def.history;
    governor_apply(state->def.governor, &view);
    view.progress = keep_drawing;
    view.progress_user = state->scripts.dog;
    return view;
}

typedef bool look_function(void *user, daft_scene *scene, const daft_view *view, daft_error *error);

/* With what is shown in pictures alone, and under the watchdog. */
static bool show(game_state *state, float alpha, look_function *look, void *user, daft_error *error)
{
    static const char name[] = "drawing one picture";
    const daft_view view = view_of(state, alpha);
    /* Pictures of many samples are for files: they may take so many times as long. */
    const double factor = view.quality.samples > 1 ? 12 : 1;
    watchdog_begin(state->scripts.dog, name, factor);
    atomic_store(&state->rendering, true);
    host_show_particles(&state->scripts, &view.camera, ((double)alpha - 1) * state->scripts.scale / LOOP_RATE);
    const bool good = look(user, state->scene, &view, error);
    host_hide_particles(&state->scripts);
    atomic_store(&state->alive_ns, clock_now_ns());
    atomic_store(&state->rendering, false);
    return in_time(state, name) && good;
}

typedef struct drawn_to {
    daft_image *picture;
    tracer *spans;
} drawn_to;

static bool draw_to(void *user, daft_scene *scene, const daft_view *view, daft_error *error)
{
    const drawn_to *to = user;
    const uint64_t began = trace_begin(to->spans);
    const bool good = daft_render(scene, view, to->picture, error);
    trace_picture(to->spans, scene, began);
    return good;
}

bool game_draw(game_state *state, daft_image *picture, float alpha)
{
    return game_render(state, picture, alpha) && game_draw_over(state, picture);
}

bool game_render(game_state *state, daft_image *picture, float alpha)
{
    daft_error error;
    if (state->failed) return false;
    if (show(state, alpha, draw_to, &(drawn_to){picture, state->def.spans}, &error)) return true;
    return state->failed ? false : stop_with(state, "drawing", &error);
}

bool game_show(game_state *state, float alpha, look_function *look, void *user, daft_error *error)
{
    *error = (daft_error){0};
    return !state->failed && show(state, alpha, look, user, error);
}

bool game_draw_over(game_state *state, daft_image *picture)
{
    if (state->failed) return false;
    canvas over = canvas_over(picture);
    const float width = canvas_hud_width(&over);
    if (width != state->keys.width) input_push(&state->keys, &(input_event){.kind = INPUT_WIDTH, .x = width});
    return host_draw(&state->scripts, &over) || stop(state);
}

uint64_t game_hash(const game_state *state)
{
    if (!state->scene) return 0; /* a reload ran out of memory */
    return daft_hash(&state->scripts.random, sizeof state->scripts.random, daft_scene_hash(state->scene));
}
