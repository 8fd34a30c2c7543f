/* Hands events to the console and the inspector, and what they wish to the game. */
#include "tools/tools.h"

#include "common/util.h"
#include "game/xray.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what the game says ---- */

void tools_printed(tools *self, const char *text, size_t size) { console_print(&self->console, text, size); }

static void tell_typed(tools *self, const char *line)
{
    char typed[EDIT_SIZE + 2];
    snprintf(typed, sizeof typed, "> %s", line);
    console_say(&self->console, CONSOLE_TYPED, typed);
}

void tools_answered(tools *self, const char *line, const char *answer, bool good, bool foreign)
{
    if (foreign) tell_typed(self, line);
    console_say(&self->console, good ? CONSOLE_VALUE : CONSOLE_ERROR, answer);
    inspector_answered(&self->inspector, line, answer, good);
}

/* Why the game does not take the line; NULL: it does. */
static const char *give_line(const tools_scene *now, const char *line)
{
    if (game_run_line(now->play, line)) return NULL;
    if (now->play->failed) return "The game has stopped: R starts it again.";
    if (now->time_held) return "Time is held: close the console, and Space lets it go on.";
    if (game_is_replaying(now->play)) return "A recording plays, whose game a line would change: wait for its end.";
    return "The line is too long, or too many wait.";
}

/* ---- the chosen entity as `it` ---- */

static bool is_letter(char c) { return isalnum((unsigned char)c) || c == '_'; }

/* Past a string. */
static const char *skip_string(const char *at)
{
    const char quote = *at++;
    while (*at && *at != quote) at += at[0] == '\\' && at[1] ? 2 : 1;
    return *at ? at + 1 : at;
}

/* Whether the word `it` stands there and is used, not made: it:position(), f(it). */
static bool is_it(const char *line, const char *at)
{
    if (strncmp(at, "it", 2) != 0 || is_letter(at[2])) return false;
    if (at > line && (is_letter(at[-1]) || at[-1] == '.' || at[-1] == ':')) return false;
    const char *next = at + 2 + strspn(at + 2, " ");
    return !*next || strchr(".:[,)}", *next) || (strchr("=~", next[0]) && next[1] == '=');
}

/* The entity's number goes into the line, so that what is recorded does not hang on what was chosen. */
static void name_it(const tools *self, const char *line, char out[EDIT_SIZE])
{
    size_t used = 0;
    for (const char *at = line; *at && used + 24 < EDIT_SIZE;) {
        const bool it = self->inspector.chosen.id && is_it(line, at);
        const char *end = it ? at + 2 : *at == '"' || *at == '\'' ? skip_string(at) : at + 1;
        if (it)
            used += (size_t)snprintf(out + used, EDIT_SIZE - used, "entity_%" PRIu32, self->inspector.chosen.id);
        else
            used += (size_t)snprintf(out + used, EDIT_SIZE - used, "%.*s", (int)(end - at), at);
        if (used >= EDIT_SIZE) used = EDIT_SIZE - 1;
        at = end;
    }
    out[used] = 0;
}

/* ---- the console ---- */

static void run_line(tools *self, const tools_scene *now)
{
    char line[EDIT_SIZE];
    console *c = &self->console;
    tell_typed(self, c->line);
    if (console_command(c, c->line)) return;
    name_it(self, c->line, line);
    const char *refused = give_line(now, line);
    if (refused) console_say(c, CONSOLE_ERROR, refused);
}

static void complete(tools *self, const tools_scene *now)
{
    char before[EDIT_SIZE];
    completions found;
    if (!now->play->scripts.L) return;
    snprintf(before, sizeof before, "%.*s", (int)self->console.edit.cursor, self->console.edit.text);
    host_complete(&now->play->scripts, before, &found);
    console_complete(&self->console, &found);
}

static void fulfil(tools *self, const tools_scene *now, console_wish wish)
{
    char text[EDIT_SIZE];
    platform *screen = now->screen;
    switch (wish) {
    case CONSOLE_STAY: break;
    case CONSOLE_CLOSE: console_show(&self->console, false); break;
    case CONSOLE_RUN: run_line(self, now); break;
    case CONSOLE_COMPLETE: complete(self, now); break;
    case CONSOLE_PASTE:
        if (screen->paste && screen->paste(screen, text, sizeof text)) edit_insert(&self->console.edit, text);
        break;
    case CONSOLE_COPY:
        if (screen->copy) screen->copy(screen, self->console.edit.text);
        break;
    }
}

static bool take_console(tools *self, const tools_scene *now, const input_event *event)
{
    console *c = &self->console;
    const uint64_t ns = now->screen->now_ns(now->screen);
    if (event->kind == INPUT_KEY) fulfil(self, now, console_key(c, input_letter(event), event->down, ns));
    if (event->kind == INPUT_TEXT) console_type(c, event->key);
    if (event->kind == INPUT_WHEEL) console_wheel(c, event->y);
    return true;
}

static void toggle_console(tools *self, const tools_scene *now)
{
    if (now->screen->headless || now->paused) return;
    console_show(&self->console, !self->console.open);
    input_push_release_all(&now->play->keys);
}

/* ---- the inspector ---- */

void tools_toggle_inspector(tools *self, const tools_scene *now)
{
    if (now->screen->headless) return;
    inspector_show(&self->inspector, !self->inspector.open);
    input_push_release_all(&now->play->keys);
}

static void pick(tools *self, const tools_scene *now)
{
    daft_ray_hit hit;
    int width, height;
    if (!now->play->scene) return;
    now->screen->get_size(now->screen, &width, &height);
    const double aspect = (double)height / (double)width;
    const daft_camera camera = daft_scene_camera(now->play->scene, now->alpha);
    const daft_vec3 ray = daft_camera_ray(&camera, (double)self->inspector.mouse_x * aspect / CANVAS_HEIGHT,
                                          (double)self->inspector.mouse_y / CANVAS_HEIGHT, aspect);
    const bool found =
        daft_scene_cast_ray(now->play->scene, camera.position, ray, INFINITY, (daft_entity){0}, &hit, NULL);
    inspector_choose(&self->inspector, found ? hit.entity : (daft_entity){0});
}

static bool take_inspector(tools *self, const tools_scene *now, const input_event *event)
{
    inspector *look = &self->inspector;
    const char *refused;
    switch (inspector_take(look, event, now->screen->now_ns(now->screen))) {
    case INSPECTOR_PASS: return false;
    case INSPECTOR_KEEP: break;
    case INSPECTOR_PICK: pick(self, now); break;
    case INSPECTOR_CLOSE: inspector_show(look, false); break;
    case INSPECTOR_RUN:
        refused = give_line(now, look->line);
        if (refused)
            snprintf(look->told, sizeof look->told, "%s", refused);
        else
            tell_typed(self, look->line);
        break;
    }
    return true;
}

/* ---- events ---- */

/* F1 to F12, which work while the tools are open. */
static bool is_program_key(const input_event *event)
{
    const char *name = event->kind == INPUT_KEY ? input_key_name(event->key) : NULL;
    return name && name[0] == 'f' && name[1];
}

bool tools_take(tools *self, const tools_scene *now, const platform_event *event)
{
    if (event->kind == PLATFORM_CONSOLE) toggle_console(self, now);
    if (event->kind != PLATFORM_INPUT) return event->kind == PLATFORM_CONSOLE;
    if (now->paused || is_program_key(&event->input)) return false;
    if (self->console.open) return take_console(self, now, &event->input);
    return self->inspector.open && take_inspector(self, now, &event->input);
}

void tools_turn(tools *self, const tools_scene *now)
{
    const uint64_t ns = now->screen->now_ns(now->screen);
    if (self->console.open)
        fulfil(self, now, console_repeat(&self->console, ns));
    else if (self->inspector.open)
        inspector_repeat(&self->inspector, ns);
}

bool tools_want_mouse(const tools *self) { return self->console.open || self->inspector.open; }

void tools_draw(tools *self, const tools_scene *now, daft_image *picture, font *face, panels *placed)
{
    const canvas over = canvas_over(picture);
    game_state *play = now->play;
    if (self->inspector.open && play->scene && play->scripts.L) {
        const daft_camera camera = daft_scene_camera(play->scene, now->alpha);
        if (self->inspector.chosen.id && !play->failed)
            xray_outline(&over, play->scene, &camera, self->inspector.chosen);
        inspector_read(&self->inspector, play->scene, &play->scripts);
        inspector_draw(&self->inspector, &over, face, placed);
    }
    if (self->console.open) console_draw(&self->console, &over, face);
}

void tools_free(tools *self) { console_free(&self->console); }
