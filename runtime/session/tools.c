/* Hands events to the console and the inspector, and what they wish to the game. */
#include "session/tools.h"

#include "common/util.h"
#include "game/xray.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what the game says ---- */

void tools_printed(void *user, const char *text, size_t size)
{
    console_print(&((session *)user)->console, text, size);
}

static void tell_typed(session *s, const char *line)
{
    char typed[EDIT_SIZE + 2];
    snprintf(typed, sizeof typed, "> %s", line);
    console_say(&s->console, CONSOLE_TYPED, typed);
}

void tools_answered(void *user, const char *line, const char *answer, bool good)
{
    session *s = user;
    if (game_is_replaying(s->play)) tell_typed(s, line); /* nobody has typed it here */
    console_say(&s->console, good ? CONSOLE_VALUE : CONSOLE_ERROR, answer);
    inspector_answered(&s->inspector, line, answer, good);
}

/* Why the game does not take the line; NULL: it does. */
static const char *give_line(session *s, const char *line)
{
    if (game_run_line(s->play, line)) return NULL;
    if (s->play->failed) return "The game has stopped: R starts it again.";
    if (session_holds_time(s)) return "Time is held: close the console, and Space lets it go on.";
    if (game_is_replaying(s->play)) return "A recording plays, whose game a line would change: wait for its end.";
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
static void name_it(const session *s, const char *line, char out[EDIT_SIZE])
{
    size_t used = 0;
    for (const char *at = line; *at && used + 24 < EDIT_SIZE;) {
        const bool it = s->inspector.chosen.id && is_it(line, at);
        const char *end = it ? at + 2 : *at == '"' || *at == '\'' ? skip_string(at) : at + 1;
        if (it)
            used += (size_t)snprintf(out + used, EDIT_SIZE - used, "entity_%" PRIu32, s->inspector.chosen.id);
        else
            used += (size_t)snprintf(out + used, EDIT_SIZE - used, "%.*s", (int)(end - at), at);
        if (used >= EDIT_SIZE) used = EDIT_SIZE - 1;
        at = end;
    }
    out[used] = 0;
}

/* ---- the console ---- */

static void run_line(session *s)
{
    char line[EDIT_SIZE];
    console *c = &s->console;
    tell_typed(s, c->line);
    if (console_command(c, c->line)) return;
    name_it(s, c->line, line);
    const char *refused = give_line(s, line);
    if (refused) console_say(c, CONSOLE_ERROR, refused);
}

static void complete(session *s)
{
    char before[EDIT_SIZE];
    completions found;
    if (!s->play->scripts.L) return;
    snprintf(before, sizeof before, "%.*s", (int)s->console.edit.cursor, s->console.edit.text);
    host_complete(&s->play->scripts, before, &found);
    console_complete(&s->console, &found);
}

static void fulfil(session *s, console_wish wish)
{
    char text[EDIT_SIZE];
    platform *screen = s->def->screen;
    switch (wish) {
    case CONSOLE_STAY: break;
    case CONSOLE_CLOSE: console_show(&s->console, false); break;
    case CONSOLE_RUN: run_line(s); break;
    case CONSOLE_COMPLETE: complete(s); break;
    case CONSOLE_PASTE:
        if (screen->paste && screen->paste(screen, text, sizeof text)) edit_insert(&s->console.edit, text);
        break;
    case CONSOLE_COPY:
        if (screen->copy) screen->copy(screen, s->console.edit.text);
        break;
    }
}

static bool take_console(session *s, const input_event *event)
{
    console *c = &s->console;
    const uint64_t now = s->def->screen->now_ns(s->def->screen);
    if (event->kind == INPUT_KEY) fulfil(s, console_key(c, input_letter(event), event->down, now));
    if (event->kind == INPUT_TEXT) console_type(c, event->key);
    if (event->kind == INPUT_WHEEL) console_wheel(c, event->y);
    return true;
}

static void toggle_console(session *s)
{
    if (s->def->screen->headless || s->pause.open) return;
    console_show(&s->console, !s->console.open);
    input_push_release_all(&s->play->keys);
}

/* ---- the inspector ---- */

void tools_toggle_inspector(session *s)
{
    if (s->def->screen->headless) return;
    inspector_show(&s->inspector, !s->inspector.open);
    input_push_release_all(&s->play->keys);
}

static void pick(session *s)
{
    daft_ray_hit hit;
    int width, height;
    if (!s->play->scene) return;
    s->def->screen->get_size(s->def->screen, &width, &height);
    const double aspect = (double)height / (double)width;
    const daft_camera camera = daft_scene_camera(s->play->scene, loop_alpha(&s->clock));
    const daft_vec3 ray = daft_camera_ray(&camera, (double)s->inspector.mouse_x * aspect / CANVAS_HEIGHT,
                                          (double)s->inspector.mouse_y / CANVAS_HEIGHT, aspect);
    const bool found =
        daft_scene_cast_ray(s->play->scene, camera.position, ray, INFINITY, (daft_entity){0}, &hit, NULL);
    inspector_choose(&s->inspector, found ? hit.entity : (daft_entity){0});
}

static bool take_inspector(session *s, const input_event *event)
{
    inspector *self = &s->inspector;
    const char *refused;
    switch (inspector_take(self, event, s->def->screen->now_ns(s->def->screen))) {
    case INSPECTOR_PASS: return false;
    case INSPECTOR_KEEP: break;
    case INSPECTOR_PICK: pick(s); break;
    case INSPECTOR_CLOSE: inspector_show(self, false); break;
    case INSPECTOR_RUN:
        refused = give_line(s, self->line);
        if (refused)
            snprintf(self->told, sizeof self->told, "%s", refused);
        else
            tell_typed(s, self->line);
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

bool tools_take(session *s, const platform_event *event)
{
    if (event->kind == PLATFORM_CONSOLE) toggle_console(s);
    if (event->kind != PLATFORM_INPUT) return event->kind == PLATFORM_CONSOLE;
    if (s->pause.open || is_program_key(&event->input)) return false;
    if (s->console.open) return take_console(s, &event->input);
    return s->inspector.open && take_inspector(s, &event->input);
}

void tools_turn(session *s)
{
    const uint64_t now = s->def->screen->now_ns(s->def->screen);
    if (s->console.open)
        fulfil(s, console_repeat(&s->console, now));
    else if (s->inspector.open)
        inspector_repeat(&s->inspector, now);
}

bool tools_want_mouse(const session *s) { return s->console.open || s->inspector.open; }

void tools_draw(session *s, float alpha)
{
    const canvas over = canvas_over(s->picture);
    if (s->inspector.open && s->play->scene && s->play->scripts.L) {
        const daft_camera camera = daft_scene_camera(s->play->scene, alpha);
        if (s->inspector.chosen.id && !s->play->failed)
            xray_outline(&over, s->play->scene, &camera, s->inspector.chosen);
        inspector_read(&s->inspector, s->play->scene, &s->play->scripts);
        inspector_draw(&s->inspector, &over, s->def->face, &s->placed);
    }
    if (s->console.open) console_draw(&s->console, &over, s->def->face);
}
