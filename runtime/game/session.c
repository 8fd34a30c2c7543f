/* Plays one game on a platform. */
#include "game/session.h"

#include "files/content.h"
#include "files/saves.h"
#include "files/watch.h"
#include "game/agree.h"
#include "game/costs.h"
#include "game/governor.h"
#include "game/loop.h"
#include "game/pause.h"
#include "game/relive.h"
#include "game/xray.h"
#include "hud/screens.h"
#include "common/stop.h"
#include "common/util.h"
#include "platform/audio.h"
#include "sound/tape.h"

#include <inttypes.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { HASH_TICKS = 60 };

typedef struct session {
    const session_def *def;
    session_def now; /* with the size of the scene's picture as the governor wants it */
    const game_info *info;
    const game_source *source;
    governor pace;
    bool governs;
    double drawn_ms;            /* of the frame at work, and its updates */
    bool reused;                /* parts of the picture were as before, so it says little about its quality */
    game_state games[2], *play; /* the one that runs, and room for what takes its place */
    trail past;
    watch files;
    char notice[HOST_MESSAGE]; /* of a change of the files, over the picture; or empty */
    uint64_t notice_ns;        /* until when; 0: until it is right */
    recording replay;
    agreement agreed;
    recorder *record;
    tape sounds;
    saves *kept, *own; /* the game's; the program's */
    player_settings settings;
    pause_menu pause;
    key_map keys;                /* the player's */
    window_wish granted;         /* the last; its icon is only compared */
    bool redraws;                /* while it pauses: the picture is to change */
    bool paced;                  /* the player has set something in this session */
    daft_image *picture, *small; /* the window's; the scene's, where it has fewer pixels */
    daft_history *history;
    loop clock;
    uint64_t last_ns, began_ns;
    bool left, closed, overlay, xray, reported;
    bool wants_reload, wants_shot, grabbed;
    frame_times times;
    double update_ms, frame_ms, turn_ms;      /* smoothed, for the overlay */
    uint64_t hashed, drawn, shot_done, turns; /* ticks */
    progress_bar bar;
    _Atomic uint64_t polled_ns; /* when events were last taken */
    atomic_bool leaving;        /* set by the watchdog's thread: Esc or the close button waits in the queue */
} session;

/* ---- the picture ---- */

void session_picture_size(const session_def *def, int *width, int *height)
{
    def->screen->get_size(def->screen, width, height);
    if (def->fixed_size) return;
    double scale = def->scale;
    if ((double)*width * scale > 1920) scale = 1920.0 / (double)*width;
    if ((double)*height * scale > 1080) scale = 1080.0 / (double)*height;
    *width = (int)((double)*width * scale + 0.5);
    *height = (int)((double)*height * scale + 0.5);
    if (*width < 16) *width = 16;
    if (*height < 16) *height = 16;
}

bool session_fit_picture(const session_def *def, daft_image **picture, daft_error *error)
{
    int width, height;
    session_picture_size(def, &width, &height);
    if (*picture && daft_image_width(*picture) == width && daft_image_height(*picture) == height) return true;
    daft_image *fresh = daft_image_create(def->engine, width, height, error);
    if (!fresh) return false;
    daft_image_destroy(*picture);
    *picture = fresh;
    return true;
}

void session_scale_mouse(platform *screen, input_event *event)
{
    if (event->kind != INPUT_MOVE && event->kind != INPUT_MOTION) return;
    int width, height;
    screen->get_size(screen, &width, &height);
    event->x *= (float)CANVAS_HEIGHT * (float)width / (float)height;
    event->y *= CANVAS_HEIGHT;
}

/* Puts the panel where it covers least of the game's text, as far left as may be. */
static void place_overlay(const session *s, canvas *over)
{
    enum { WIDTH = 312, HEIGHT = 640, STEPS = 8 };
    int fewest = MARK_ROWS * MARK_COLUMNS;
    for (int i = 0; i <= STEPS; i++) {
        const float x = (canvas_hud_width(over) - WIDTH) * (float)i / STEPS;
        const int marks = canvas_count_marks(&s->play->scripts.texts, x, 0, WIDTH, HEIGHT);
        if (marks < fewest) fewest = marks, over->origin_x = x * over->unit;
    }
}

static void draw_overlay(session *s)
{
    overlay_figures figures = {.frames_per_second = s->turn_ms > 0 ? 1000 / s->turn_ms : 0,
                               .frame_ms = s->frame_ms,
                               .update_ms = s->update_ms,
                               .dropped = s->clock.dropped,
                               .counters = daft_scene_counters(s->play->scene),
                               .simulation = daft_scene_sim_counters(s->play->scene),
                               .memory = daft_engine_memory(s->def->engine)};
    canvas over = canvas_over(s->picture);
    char quality[160];
    if (s->governs) {
        const governor *g = &s->pace;
        snprintf(quality, sizeof quality, "%s for %.1f ms: %s", governor_rung_at(g->rung)->name, g->target_ms, g->why);
        figures.quality = quality, figures.slow_ms = governor_slow_ms(g);
    }
    place_overlay(s, &over);
    screen_overlay(&over, s->def->face, &figures);
}

static double smooth(double before, double now) { return before > 0 ? before * 0.95 + now * 0.05 : now; }

/* The scene, perhaps with fewer pixels than the window has; the panel; and over it what the game draws, which the panel
 * must not cover. */
static bool draw_game(session *s, float alpha, daft_error *error)
{
    const bool fewer = s->now.scale < s->def->scale;
    if (fewer && !session_fit_picture(&s->now, &s->small, error)) return false;
    if (!game_render(s->play, fewer ? s->small : s->picture, alpha)) return false;
    if (fewer) canvas_stretch(s->small, s->picture);
    if (s->xray) {
        const canvas over = canvas_over(s->picture);
        const daft_camera camera = daft_scene_camera(s->play->scene, alpha);
        xray_draw(&over, s->play->scene, &camera);
    }
    if (s->overlay) draw_overlay(s);
    return game_draw_over(s->play, s->picture);
}

static bool can_edit(const session *s) { return s->def->editor && s->play->scripts.failure.file[0]; }

static void draw_failure(session *s)
{
    const failure *why = &s->play->scripts.failure;
    canvas over = canvas_over(s->picture);
    error_report shown = {s->info->title,
                          why->message,
                          why->source,
                          why->trace,
                          why->values,
                          can_edit(s) ? "R  try again      C  copy      E  edit      Esc  leave"
                                      : "R  try again      C  copy      Esc  leave"};
    if (s->notice[0] && s->notice_ns) shown.keys = s->notice;
    screen_error(&over, s->def->face, &shown);
}

/* Draws the game, or the error that stopped it. */
static bool has_kept_tiles(const daft_counters *c)
{
    const uint64_t columns = ((uint64_t)c->width + 31) / 32, rows = ((uint64_t)c->height + 31) / 32;
    return c->tiles_drawn < columns * rows;
}

static bool draw(session *s, float alpha, daft_error *error)
{
    if (!session_fit_picture(s->def, &s->picture, error)) return false;
    s->drawn = s->play->ticks;
    uint64_t began = clock_now_ns();
    const bool drawn = draw_game(s, alpha, error);
    if (!drawn && !s->play->failed) return false;
    if (drawn) {
        double ms = (double)(clock_now_ns() - began) / 1e6;
        s->frame_ms = smooth(s->frame_ms, ms), s->drawn_ms += ms;
        s->reused = has_kept_tiles(daft_scene_counters(s->play->scene));
        if (s->def->stats) frame_times_add(&s->times, ms, daft_scene_counters(s->play->scene));
    } else {
        draw_failure(s);
    }
    if (s->notice[0] && !(s->play->failed && s->notice_ns)) {
        canvas over = canvas_over(s->picture);
        screen_notice(&over, s->def->face, s->notice, s->notice_ns == 0);
    }
    return true;
}

/* ---- events ---- */

static void push_restart(session *s)
{
    input_event event = {.kind = INPUT_KEY, .key = input_key_find(INPUT_RESTART), .down = true};
    input_push(&s->play->keys, &event);
    event.down = false;
    input_push(&s->play->keys, &event);
}

static void apply_settings(session *s)
{
    platform *screen = s->def->screen;
    audio_volume(s->settings.volume / 10.0);
    if (screen->full_screen) screen->full_screen(screen, s->settings.full_screen);
}

/* The player's, unless this session was started with one and the player has set nothing since. */
static quality_wish quality_of_session(const session *s)
{
    const quality_wish *asked = &s->def->quality;
    const bool own = s->def->pauses && (s->paced || asked->preset == QUALITY_OF_SCENE);
    return own ? pause_quality(&s->settings, asked) : *asked;
}

/* The name of this game's keys among the program's own saves. */
static const char *name_of_keys(const session *s, char out[32])
{
    snprintf(out, 32, "keys_%016" PRIx64, daft_hash(s->info->name, strlen(s->info->name), 0));
    return out;
}

static void load_keys(session *s)
{
    char name[32];
    const char *text = NULL;
    daft_error error;
    key_map_reset(&s->keys);
    if (s->def->pauses && saves_get(s->own, name_of_keys(s, name), &text, &error) && text) key_map_read(&s->keys, text);
}

static void save_keys(session *s)
{
    char name[32], text[KEY_MAP_TEXT];
    daft_error error;
    key_map_write(&s->keys, text);
    if (!saves_put(s->own, name_of_keys(s, name), text, &error)) report(&error);
}

static void open_pause(session *s)
{
    platform *screen = s->def->screen;
    if (screen->full_screen) s->settings.full_screen = screen->full_screen(screen, -1);
    s->pause.actions = &s->play->scripts.actions, s->pause.keys = &s->keys;
    pause_open(&s->pause);
    input_push_release_all(&s->play->keys);
    s->redraws = true;
}

static void take_pause(session *s, const input_event *event)
{
    const pause_menu before = s->pause;
    const pause_wish wish = pause_take(&s->pause, event);
    s->redraws |= wish != PAUSE_STAY || s->pause.chosen != before.chosen || s->pause.controls != before.controls ||
                  s->pause.waits != before.waits;
    if (wish == PAUSE_LEAVE) s->left = true;
    if (wish == PAUSE_RESTART) push_restart(s);
    if (wish == PAUSE_KEYS) save_keys(s);
    if (wish != PAUSE_SET) return;
    s->paced = true;
    apply_settings(s);
    s->play->def.quality = quality_of_session(s);
    settings_save(s->own, &s->settings);
}

/* Esc and the gamepad's start. */
static bool is_pause(const session *s, const input_event *event)
{
    const char *name = event->kind == INPUT_KEY && event->down ? input_key_name(event->key) : "";
    return s->def->pauses && !s->play->failed && (strcmp(name, "escape") == 0 || strcmp(name, "pad start") == 0);
}

static void tell(session *s, const char *text)
{
    snprintf(s->notice, sizeof s->notice, "%s", text);
    s->notice_ns = s->def->screen->now_ns(s->def->screen) + 2000000000u;
}

static void copy_failure(session *s)
{
    char text[FAILURE_TEXT];
    platform *screen = s->def->screen;
    const bool good = screen->copy && screen->copy(screen, failure_text(&s->play->scripts.failure, text, sizeof text));
    tell(s, good ? "copied" : "there is no clipboard");
}

static void edit_failure(session *s)
{
    const failure *why = &s->play->scripts.failure;
    if (!s->def->editor)
        tell(s, "E opens the editor that $VISUAL or $EDITOR names: neither is set");
    else if (can_edit(s))
        tell(s, editor_open(s->def->editor, why->file, why->line) ? "opened in your editor" : "the editor is gone");
}

/* Keys of the error screen. */
static void handle_failure_key(session *s, const char *name)
{
    if (strcmp(name, "r") == 0) s->wants_reload = true;
    if (strcmp(name, "c") == 0) copy_failure(s);
    if (strcmp(name, "e") == 0) edit_failure(s);
}

static void handle_session_key(session *s, int key)
{
    const char *name = input_key_name(key);
    if (strcmp(name, "escape") == 0) s->left = true;
    if (strcmp(name, "f1") == 0) s->overlay = !s->overlay;
    if (strcmp(name, "f3") == 0) s->xray = !s->xray;
    if (strcmp(name, "f12") == 0) s->wants_shot = true;
    if (s->play->failed) handle_failure_key(s, name);
}

/* What the player does, by the game's keys. */
static void push_translated(session *s, input_event event)
{
    if (event.kind == INPUT_TEXT && !s->play->scripts.text) return;
    if (event.kind == INPUT_KEY) event.key = s->keys.to[event.key];
    if (event.kind != INPUT_KEY || event.key != KEY_MAP_NONE) input_push(&s->play->keys, &event);
}

static void take_input(session *s, const input_event *event)
{
    if (s->pause.open) {
        take_pause(s, event);
    } else if (is_pause(s, event)) {
        open_pause(s);
    } else {
        if (event->kind == INPUT_KEY && event->down) handle_session_key(s, event->key);
        push_translated(s, *event);
    }
}

static void take_events(session *s)
{
    platform *screen = s->def->screen;
    for (platform_event event; screen->poll(screen, &event);) {
        switch (event.kind) {
        case PLATFORM_CLOSE: s->closed = true; break;
        case PLATFORM_FOCUS_LOST: input_push_release_all(&s->play->keys); break;
        case PLATFORM_DROP: break;
        case PLATFORM_INPUT:
            session_scale_mouse(screen, &event.input);
            take_input(s, &event.input);
            break;
        }
    }
    atomic_store(&s->polled_ns, clock_now_ns());
}

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
}

/* ---- hashes, shots, statistics ---- */

static bool print_hash(session *s, daft_error *error)
{
    if (!draw(s, 1, error)) return false;
    if (s->play->failed) return true;
    size_t size = 4 * (size_t)daft_image_width(s->picture) * (size_t)daft_image_height(s->picture);
    printf("tick %" PRIu64 " state 0x%016" PRIx64 " frame 0x%016" PRIx64 "\n", s->play->ticks, game_hash(s->play),
           daft_hash(daft_image_pixels(s->picture), size, 0));
    fflush(stdout);
    s->hashed = s->play->ticks;
    return true;
}

static bool take_shot(session *s, const char *path, daft_error *error)
{
    if (!draw(s, 1, error)) return false;
    return s->play->failed || daft_image_write(s->picture, path, error);
}

/* Whether the replay still does what was recorded. */
static bool compare_replay(session *s, daft_error *error)
{
    char message[AGREE_TEXT];
    if (!s->def->replay || s->replay.state_count == 0 || s->play->ticks > s->replay.end) return true;
    if (agree(&s->agreed, &s->replay, s->play->ticks, game_hash(s->play), s->play->scene, message)) return true;
    if (s->def->strict) return fail_at(error, s->def->replay, 0, 0, "%s", message);
    progress_end(&s->bar);
    fprintf(stderr, "daft: %s: %s\n", s->def->replay, message);
    snprintf(s->notice, sizeof s->notice, "%s", message);
    s->notice_ns = s->def->screen->now_ns(s->def->screen) + 8000000000u;
    return true;
}

static bool after_tick(session *s, daft_error *error)
{
    uint64_t tick = s->play->ticks;
    if (!compare_replay(s, error)) return false;
    if (s->def->hash && tick % HASH_TICKS == 0 && !print_hash(s, error)) return false;
    if (s->def->shot && s->def->shot_tick == tick) {
        s->shot_done = tick;
        if (!take_shot(s, s->def->shot, error)) return false;
    }
    return true;
}

static bool at_end(session *s, daft_error *error)
{
    if (s->play->failed) return true;
    if (s->def->hash && (s->hashed != s->play->ticks || s->play->ticks == 0) && !print_hash(s, error)) return false;
    if (s->def->shot && s->def->shot_tick == 0 && !take_shot(s, s->def->shot, error)) return false;
    if (s->def->shot && s->def->shot_tick > 0 && s->shot_done == 0)
        return fail(error, DAFT_ERROR_ARGUMENT, "--shot-tick %" PRIu64 ": the game ended at tick %" PRIu64,
                    s->def->shot_tick, s->play->ticks);
    /* Without a window few pictures are drawn: a broken daft.draw is not to go unseen. */
    if (s->def->screen->headless && s->play->ticks > 0 && s->drawn != s->play->ticks && !draw(s, 1, error))
        return false;
    if (!s->def->stats) return true;
    if (s->times.count == 0 && !draw(s, 1, error)) return false;
    s->times.memory = daft_engine_memory(s->def->engine);
    s->times.simulation = daft_scene_sim_counters(s->play->scene);
    return s->play->failed || stats_write(s->def->stats, daft_scene_counters(s->play->scene), &s->times, error);
}

/* Writes a picture to the current folder, named by the time. */
static void write_user_shot(session *s)
{
    char name[64];
    time_t now = time(NULL);
    struct tm parts;
    localtime_r(&now, &parts);
    strftime(name, sizeof name, "daft-%Y%m%d-%H%M%S.png", &parts);
    daft_error error;
    if (s->picture && daft_image_write(s->picture, name, &error))
        fprintf(stderr, "daft: wrote %s\n", name);
    else if (s->picture)
        report(&error);
}

static void report_script(session *s)
{
    if (!s->play->failed || s->reported || s->play->scripts.asked) return;
    progress_end(&s->bar);
    fflush(stdout);
    char text[FAILURE_TEXT];
    fprintf(stderr, "daft: %s", failure_text(&s->play->scripts.failure, text, sizeof text));
    s->reported = true;
}

/* ---- the loop ---- */

static uint64_t last_tick(const session *s)
{
    if (s->def->ticks) return s->def->ticks;
    return s->def->replay && s->def->screen->headless ? s->replay.end : UINT64_MAX;
}

static bool is_over(const session *s)
{
    return s->left || s->closed || atomic_load(&s->leaving) || s->play->over || s->play->ticks >= last_tick(s) ||
           (s->play->failed && s->def->screen->headless);
}

static bool run_updates(session *s, int updates, daft_error *error)
{
    uint64_t began = clock_now_ns();
    for (int i = 0; i < updates && !is_over(s); i++) {
        uint64_t before = s->play->ticks;
        game_tick(s->play);
        if (s->play->ticks > before && !s->play->failed && !after_tick(s, error)) return false;
    }
    const double ms = (double)(clock_now_ns() - began) / 1e6;
    if (updates > 0 && !s->play->failed) s->update_ms = smooth(s->update_ms, ms), s->drawn_ms += ms;
    return true;
}

/* ---- speed ---- */

static double speed_of(const session *s) { return s->def->speed > 0 && game_is_replaying(s->play) ? s->def->speed : 1; }

/* Updates that are due after so many nanoseconds. */
static int updates_due(session *s, uint64_t elapsed)
{
    const double speed = speed_of(s);
    if (speed == 1 || s->def->screen->headless || isinf(speed)) return loop_advance(&s->clock, elapsed);
    const int parts = 1 + (int)(speed / 2); /* none so long that updates are dropped, unless frames are slow */
    int updates = 0;
    for (int i = 0; i < parts; i++) updates += loop_advance(&s->clock, (uint64_t)((double)elapsed * speed / parts));
    return updates;
}

/* As many updates as a frame has time for. */
static bool run_at_full_speed(session *s, daft_error *error)
{
    const uint64_t end = clock_now_ns() + 1000000000u / LOOP_RATE;
    bool good = true;
    do good = run_updates(s, 1, error);
    while (good && isinf(speed_of(s)) && !is_over(s) && clock_now_ns() < end);
    return good;
}

/* Without a window no clock but this one holds a replay back. */
static void keep_pace(session *s)
{
    if (!s->def->screen->headless || s->def->speed <= 0 || isinf(s->def->speed)) return;
    const uint64_t due = s->began_ns + (uint64_t)((double)s->play->ticks * 1e9 / LOOP_RATE / s->def->speed);
    const uint64_t now = clock_now_ns();
    if (due <= now) return;
    const struct timespec rest = {(time_t)((due - now) / 1000000000u), (long)((due - now) % 1000000000u)};
    nanosleep(&rest, NULL);
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

/* What changed on the disk is what is played from here on. */
static bool take_changes(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    const uint64_t now = screen->now_ns(screen);
    if (s->notice_ns && now > s->notice_ns) s->notice[0] = 0, s->notice_ns = 0;
    if (!s->def->watches || !watch_changed(&s->files, now)) return true;
    game_state *fresh = s->play == s->games ? &s->games[1] : s->games;
    daft_error why;
    switch (relive(s->play, fresh, &s->past, s->notice, &why)) {
    case RELIVE_DONE:
        s->play = fresh, s->reported = false;
        snprintf(s->notice, sizeof s->notice, "Reloaded");
        s->notice_ns = now + 1500000000u;
        daft_history_destroy(s->history);
        s->history = daft_history_create(s->def->engine, error);
        s->play->def.history = s->history;
        break;
    case RELIVE_LONG:
        if (s->play->failed)
            s->wants_reload = true;
        else
            push_restart(s);
        snprintf(s->notice, sizeof s->notice, "Reloaded, from the start: it has been played for too long");
        s->notice_ns = now + 4000000000u;
        break;
    case RELIVE_FAILED:
        fprintf(stderr, "daft: %s\n", s->notice);
        s->notice_ns = 0;
        break;
    }
    s->last_ns += screen->now_ns(screen) - now; /* the time it took is not the game's */
    return s->history != NULL;
}

/* Between two frames. `elapsed`: since the one before. */
static void govern(session *s, double elapsed)
{
    const double target = target_of(s), spent = s->drawn_ms;
    s->drawn_ms = 0;
    if (target != (s->governs ? s->pace.target_ms : 0)) {
        double costs[GOVERNOR_RUNGS];
        const bool known = costs_load(s->def->costs, s->info->name, costs);
        governor_begin(&s->pace, target, s->governs ? s->pace.cost : known ? costs : NULL);
        s->governs = target > 0;
    } else if (s->governs && spent > 0 && !s->play->failed && !(s->reused && spent < target)) {
        governor_frame(&s->pace, spent, elapsed);
    }
    s->play->def.governor = s->governs ? &s->pace : NULL;
    s->now.scale = s->governs ? s->def->scale * governor_rung_at(s->pace.rung)->scale : s->def->scale;
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
    grab_mouse(s, false);
    if (s->redraws) {
        if (!draw(s, loop_alpha(&s->clock), error)) return false;
        canvas over = canvas_over(s->picture);
        if (!s->play->failed) pause_draw(&s->pause, &over, s->def->face, s->info->title);
        s->redraws = false, s->drawn_ms = 0;
    }
    if (screen->wants_frame(screen) && !screen->present(screen, s->picture, error)) return false;
    screen->end_frame(screen);
    return true;
}

static bool turn(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    take_events(s);
    if (s->pause.open) return turn_paused(s, error);
    if (s->wants_reload) {
        s->wants_reload = s->reported = false;
        s->granted.changes = 0;
        if (!game_reload(s->play, error)) return false;
    }
    if (!take_changes(s, error)) return false;
    grab_mouse(s, s->play->scripts.grab && !s->play->failed);
    uint64_t now = screen->now_ns(screen);
    uint64_t elapsed = now - s->last_ns;
    s->last_ns = now;
    if (s->turns++ > 1) s->turn_ms = smooth(s->turn_ms, (double)elapsed / 1e6); /* the first turns have no interval */
    govern(s, (double)elapsed / 1e6);
    const bool full_speed = isinf(speed_of(s)) && !s->def->screen->headless;
    if (!(full_speed ? run_at_full_speed(s, error) : run_updates(s, updates_due(s, elapsed), error))) return false;
    keep_pace(s);
    grant_window(s);
    rumble(s);
    if (!atomic_load(&s->leaving) && (s->def->every_frame || screen->wants_frame(screen))) {
        if (!draw(s, loop_alpha(&s->clock), error) || !screen->present(screen, s->picture, error)) return false;
    }
    report_script(s);
    if (s->wants_shot) write_user_shot(s);
    s->wants_shot = false;
    if (s->def->progress && last_tick(s) != UINT64_MAX)
        progress_show(&s->bar, (double)s->play->ticks / (double)last_tick(s));
    screen->end_frame(screen);
    return true;
}

static double limit_seconds(const session *s) { return s->def->seconds > 0 ? s->def->seconds : WATCHDOG_SECONDS; }

/* What is different from when it was recorded; empty: nothing that is known. */
static const char *find_changes(session *s, const char *content, char *out, size_t size)
{
    const recording *r = &s->replay;
    const uint64_t memory = daft_engine_memory(s->def->engine).limit;
    out[0] = 0;
    if (r->content[0] ? strcmp(r->content, content) != 0 : r->pack[0] && strcmp(r->pack, s->source->hash) != 0)
        snprintf(out, size, "it was recorded with another version of the game, SHA-256 %s",
                 r->content[0] ? r->content : r->pack);
    else if (r->memory && r->memory != memory)
        snprintf(out, size, "it was recorded with --memory-limit %" PRIu64 ", not %" PRIu64, r->memory, memory);
    else if (r->memory && (float)r->seconds != (float)limit_seconds(s))
        snprintf(out, size, "it was recorded with --time-limit %g, not %g", r->seconds, limit_seconds(s));
    return out;
}

static bool open_replay(session *s, const char *content, daft_error *error)
{
    const session_def *def = s->def;
    char changes[300], name[PATH_SIZE];
    if (s->replay.game[0] && strcmp(s->replay.game, s->info->name) != 0)
        return fail_at(error, def->replay, 0, 0, "this is a recording of the game '%s', not of '%s'", s->replay.game,
                       s->info->name);
    daft_escape(def->replay, name, sizeof name);
    if (find_changes(s, content, changes, sizeof changes)[0] && def->strict)
        return fail_at(error, def->replay, 0, 0, "%s", changes);
    if (changes[0]) fprintf(stderr, "daft: %s: %s: it may play differently\n", name, changes);
    if (def->strict && s->replay.end > 0 && s->replay.state_count == 0)
        return fail_at(error, def->replay, 0, 0, "it holds no states to compare with: record it anew for --strict");
    if (s->replay.cut)
        fprintf(stderr, "daft: %s was cut short: it plays up to tick %" PRIu64 "\n", name, s->replay.end);
    return true;
}

static bool open_files(session *s, daft_error *error)
{
    const session_def *def = s->def;
    char content[SHA256_TEXT] = "";
    if (def->replay && !recording_load(&s->replay, def->replay_inside ? s->source->files : NULL, def->replay, error))
        return false;
    if ((def->record || s->replay.content[0]) && !content_hash(s->source, s->info, content, error)) return false;
    if (def->replay && !open_replay(s, content, error)) return false;
    if (!def->record) return true;
    const recording_head head = {.game = s->info->name,
                                 .pack = s->source->hash,
                                 .content = content,
                                 .seed = def->replay ? s->replay.seed : def->seed,
                                 .memory = daft_engine_memory(def->engine).limit,
                                 .seconds = limit_seconds(s)};
    s->record = recorder_open(def->record, &head, error);
    return s->record != NULL;
}

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
    if (s->def->pauses) apply_settings(s);
    load_keys(s);
    for (size_t i = 0; s->kept && i < s->replay.saved_count; i++)
        if (!saves_expect(s->kept, s->replay.saved[i].name, s->replay.saved[i].text, error)) return false;
    return s->kept != NULL;
}

static void heard(void *user, const int16_t *frames)
{
    session *s = user;
    if (s->sounds.writer) tape_put(&s->sounds, frames, SOUND_TICK);
    if (s->def->speaks && speed_of(s) == 1) audio_play(frames, SOUND_TICK);
}

static bool run(session *s, daft_error *error)
{
    if (!open_files(s, error) || !open_saves(s, error)) return false;
    if (s->def->sound && !tape_begin(&s->sounds, s->def->sound, error)) return false;
    stop_set_act(end_early, s);
    const session_def *def = s->def;
    s->history = daft_history_create(def->engine, error);
    if (!s->history) return false;
    game_def play = {.where = def->where,
                     .info = s->info,
                     .source = s->source,
                     .engine = def->engine,
                     .face = def->face,
                     .quality = quality_of_session(s),
                     .seed = def->replay ? s->replay.seed : def->seed,
                     .replay = def->replay ? &s->replay : NULL,
                     .record = s->record,
                     .trail = s->def->watches ? &s->past : NULL,
                     .history = s->history,
                     .saves = s->kept,
                     .map = &s->keys,
                     .seconds = def->seconds,
                     .asked = asked,
                     .heard = s->sounds.writer || s->def->speaks ? heard : NULL,
                     .user = s};
    watch_begin(&s->files, s->def->watches && !s->info->packed ? s->info->folder : NULL);
    if (!game_open(s->play, &play, error)) return false;
    progress_begin(&s->bar, s->info->title);
    s->last_ns = def->screen->now_ns(def->screen), s->began_ns = clock_now_ns();
    bool good = true;
    while (good && !is_over(s)) good = turn(s, error);
    if (atomic_load(&s->leaving)) take_events(s);
    grab_mouse(s, false);
    progress_end(&s->bar);
    report_script(s);
    good = good && at_end(s, error);
    report_script(s);
    return good;
}

/* Puts the recording in place and the window out of sight, before memory is freed, which may take long. */
static bool leave(session *s, daft_error *error)
{
    stop_set_act(NULL, NULL);
    bool good = recorder_finish(s->record, error);
    good = tape_commit(&s->sounds, good ? error : NULL) && good;
    if ((s->left || s->closed) && !s->def->stays) s->def->screen->hide(s->def->screen);
    return good;
}

session_end session_play(const session_def *def, const game_info *info, daft_error *error)
{
    session s = {.def = def, .now = *def, .info = info, .granted.full_screen = -1};
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
    if (s.governs && s.pace.changes) costs_save(def->costs, info->name, s.pace.cost);
    bool failed = s.play->failed && (def->screen->headless || s.play->over);
    if (s.play->scene || s.play->scripts.L) game_close(s.play);
    daft_history_destroy(s.history);
    daft_engine_set_files(def->engine, NULL, NULL);
    source_close(&own);
    saves_close(s.kept);
    saves_close(s.own);
    recorder_free(s.record);
    recording_free(&s.replay);
    daft_image_destroy(s.picture);
    daft_image_destroy(s.small);
    frame_times_free(&s.times);
    trail_free(&s.past);
    if (!good || failed) return SESSION_FAILED;
    return s.closed ? SESSION_CLOSED : s.left ? SESSION_LEFT : SESSION_DONE;
}
