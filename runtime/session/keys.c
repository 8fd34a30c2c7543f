/* What the player does: the program's own keys, the pause menu, and what is left for the game. */
#include "session/state.h"

#include "common/util.h"
#include "session/hot.h"
#include "platform/audio.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

void session_scale_mouse(platform *screen, input_event *event)
{
    if (event->kind != INPUT_MOVE && event->kind != INPUT_MOTION) return;
    int width, height;
    screen->get_size(screen, &width, &height);
    event->x *= (float)CANVAS_HEIGHT * (float)width / (float)height;
    event->y *= CANVAS_HEIGHT;
}

void session_restart(session *s)
{
    input_event event = {.kind = INPUT_KEY, .key = input_key_find(INPUT_RESTART), .down = true};
    input_push(&s->play->keys, &event);
    event.down = false;
    input_push(&s->play->keys, &event);
}

/* ---- settings and the player's keys ---- */

void session_apply(session *s)
{
    platform *screen = s->def->screen;
    audio_volume(s->settings.volume / 10.0);
    if (screen->full_screen) screen->full_screen(screen, s->settings.full_screen);
}

/* The player's, unless this session was started with one and the player has set nothing since. */
quality_wish session_quality(const session *s)
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

void session_load_keys(session *s)
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

/* The game hears that nothing is held any longer. */
static void let_go(session *s)
{
    s->held = (held_inputs){.stick = {0}};
    memset(s->time.hands.down, 0, sizeof s->time.hands.down);
    memset(s->time.hands.stick, 0, sizeof s->time.hands.stick);
    input_push_release_all(&s->play->keys);
}

/* ---- the pause menu ---- */

static void open_pause(session *s)
{
    platform *screen = s->def->screen;
    if (screen->full_screen) s->settings.full_screen = screen->full_screen(screen, -1);
    s->pause.actions = &s->play->scripts.actions, s->pause.keys = &s->keys, s->pause.keyboard = screen;
    pause_open(&s->pause);
    let_go(s);
    s->redraws = true;
}

static void take_pause(session *s, const input_event *event)
{
    const pause_menu before = s->pause;
    const pause_wish wish = pause_take(&s->pause, event);
    s->redraws |= wish != PAUSE_STAY || s->pause.chosen != before.chosen || s->pause.controls != before.controls ||
                  s->pause.waits != before.waits;
    if (wish == PAUSE_LEAVE) s->left = true;
    if (wish == PAUSE_RESTART) session_release_time(s), session_restart(s);
    if (wish == PAUSE_KEYS) save_keys(s);
    if (wish != PAUSE_SET) return;
    s->paced = true;
    session_apply(s);
    s->play->def.quality = session_quality(s);
    settings_save(s->own, &s->settings);
}

/* Esc and the gamepad's start. */
static bool is_pause(const session *s, const input_event *event)
{
    const char *name = event->kind == INPUT_KEY && event->down ? input_key_name(event->key) : "";
    return s->def->pauses && !s->play->failed && (strcmp(name, "escape") == 0 || strcmp(name, "pad start") == 0);
}

/* ---- keys of the program ---- */

void session_tell(session *s, const char *text)
{
    snprintf(s->notice, sizeof s->notice, "%s", text);
    s->notice_ns = s->def->screen->now_ns(s->def->screen) + 2000000000u;
}

static void copy_failure(session *s)
{
    char text[FAILURE_TEXT];
    platform *screen = s->def->screen;
    const bool good = screen->copy && screen->copy(screen, failure_text(&s->play->scripts.failure, text, sizeof text));
    session_tell(s, good ? "copied" : "there is no clipboard");
}

static void edit_failure(session *s)
{
    const failure *why = &s->play->scripts.failure;
    if (!s->def->editor)
        session_tell(s, "E opens the editor that $VISUAL or $EDITOR names: neither is set");
    else if (session_can_edit(s))
        session_tell(s, editor_open(s->def->editor, why->file, why->line) ? "opened in your editor"
                                                                          : "the editor is gone");
}

/* Keys of the error screen. */
static void handle_failure_key(session *s, const char *name)
{
    if (strcmp(name, "r") == 0) s->wants_reload = true;
    if (strcmp(name, "c") == 0) copy_failure(s);
    if (strcmp(name, "e") == 0) edit_failure(s);
}

tools_scene session_tools_scene(session *s, float alpha)
{
    return (tools_scene){.screen = s->def->screen,
                         .play = s->play,
                         .alpha = alpha,
                         .paused = s->pause.open,
                         .time_held = session_holds_time(s)};
}

static void toggle_inspector(session *s)
{
    const tools_scene now = session_tools_scene(s, 0);
    tools_toggle_inspector(&s->tools, &now);
}

static void handle_session_key(session *s, const input_event *event)
{
    const char *name = input_key_name(event->key);
    if (strcmp(name, "escape") == 0) s->left = true;
    if (strcmp(name, "f1") == 0) s->overlay = !s->overlay, hot_switch(s);
    if (strcmp(name, "f2") == 0) session_toggle_prices(s);
    if (strcmp(name, "f3") == 0) s->xray = !s->xray;
    if (strcmp(name, "f4") == 0) toggle_inspector(s);
    if (strcmp(name, "f12") == 0) s->wants_shot = true;
    if (s->play->failed) handle_failure_key(s, input_key_name(input_letter(event)));
    s->redraws = true;
}

/* ---- events ---- */

/* What the player does, by the game's keys and sticks. */
static void push_translated(session *s, const input_event *event)
{
    if (event->kind == INPUT_TEXT && !s->play->scripts.text) return;
    input_event asked[KEY_MAP_EVENTS];
    const int count = key_map_translate(&s->keys, &s->held, event, asked);
    const bool held = session_holds_time(s);
    for (int i = 0; i < count && held; i++) input_apply(&s->time.hands, &asked[i]);
    for (int i = 0; i < count && !held; i++) input_push(&s->play->keys, &asked[i]);
}

static void take_input(session *s, const input_event *event)
{
    if (s->pause.open) {
        take_pause(s, event);
    } else if (is_pause(s, event)) {
        open_pause(s);
    } else if (!session_take_time_key(s, event)) {
        if (event->kind == INPUT_KEY && event->down) handle_session_key(s, event);
        push_translated(s, event);
    }
}

void session_take_events(session *s)
{
    platform *screen = s->def->screen;
    for (platform_event event; screen->poll(screen, &event);) {
        if (event.kind == PLATFORM_INPUT) session_scale_mouse(screen, &event.input);
        const tools_scene now = session_tools_scene(s, loop_alpha(&s->clock));
        if (tools_take(&s->tools, &now, &event)) continue;
        switch (event.kind) {
        case PLATFORM_CLOSE: s->closed = true; break;
        case PLATFORM_FOCUS_LOST: let_go(s); break;
        case PLATFORM_CONSOLE:
        case PLATFORM_DROP: break;
        case PLATFORM_INPUT: take_input(s, &event.input); break;
        }
    }
    const tools_scene now = session_tools_scene(s, loop_alpha(&s->clock));
    tools_turn(&s->tools, &now);
    atomic_store(&s->polled_ns, clock_now_ns());
}
