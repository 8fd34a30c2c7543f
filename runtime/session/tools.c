/* Hands events to the console, and what it wishes to the game. */
#include "session/tools.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

/* ---- what the game says ---- */

void tools_printed(void *user, const char *text, size_t size)
{
    console_print(&((session *)user)->console, text, size);
}

void tools_answered(void *user, const char *line, const char *answer, bool good)
{
    session *s = user;
    if (game_is_replaying(s->play)) { /* nobody has typed it here */
        char typed[STATEMENT_SIZE + 2];
        snprintf(typed, sizeof typed, "> %s", line);
        console_say(&s->console, CONSOLE_TYPED, typed);
    }
    console_say(&s->console, good ? CONSOLE_VALUE : CONSOLE_ERROR, answer);
}

/* ---- the console ---- */

static void run_line(session *s)
{
    char typed[EDIT_SIZE + 2];
    console *c = &s->console;
    snprintf(typed, sizeof typed, "> %s", c->line);
    console_say(c, CONSOLE_TYPED, typed);
    if (console_command(c, c->line) || game_run_line(s->play, c->line)) return;
    console_say(c, CONSOLE_ERROR,
                s->play->failed              ? "The game has stopped: close the console, and R starts it again."
                : game_is_replaying(s->play) ? "A recording plays, whose game a line would change: wait for its end."
                                             : "The line is too long, or too many wait.");
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

/* The program's own keys work while it is open. */
static bool is_program_key(const input_event *event)
{
    const char *name = input_key_name(event->key);
    return event->kind == INPUT_KEY && name && name[0] == 'f' && name[1];
}

static bool take_console(session *s, const input_event *event)
{
    console *c = &s->console;
    if (is_program_key(event)) return false;
    const uint64_t now = s->def->screen->now_ns(s->def->screen);
    if (event->kind == INPUT_KEY) fulfil(s, console_key(c, event->key, event->down, now));
    if (event->kind == INPUT_TEXT) console_type(c, event->key);
    if (event->kind == INPUT_WHEEL) console_wheel(c, event->y);
    return true;
}

/* ---- events ---- */

static void toggle_console(session *s)
{
    if (s->def->screen->headless || s->pause.open) return;
    console_show(&s->console, !s->console.open);
    input_push_release_all(&s->play->keys);
}

bool tools_take(session *s, const platform_event *event)
{
    if (event->kind == PLATFORM_CONSOLE) toggle_console(s);
    if (event->kind != PLATFORM_INPUT) return event->kind == PLATFORM_CONSOLE;
    return s->console.open && take_console(s, &event->input);
}

void tools_turn(session *s)
{
    if (s->console.open) fulfil(s, console_repeat(&s->console, s->def->screen->now_ns(s->def->screen)));
}

bool tools_want_mouse(const session *s) { return s->console.open; }

void tools_draw(session *s)
{
    if (!s->console.open) return;
    const canvas over = canvas_over(s->picture);
    console_draw(&s->console, &over, s->def->face);
}
