/* console: what somebody types to a game that runs, what came of it, and what the game prints. It knows no game: who
 * has one runs the lines that it wishes to run. Promises: while it is closed it keeps the last CONSOLE_LINES lines and
 * draws nothing. */
#ifndef RUNTIME_TOOLS_CONSOLE_H
#define RUNTIME_TOOLS_CONSOLE_H

#include "hud/canvas.h"
#include "lua/statement.h"
#include "tools/edit.h"

enum { CONSOLE_LINES = 400, CONSOLE_HISTORY = 100, CONSOLE_PRINTED = 1000 };

typedef enum console_kind { CONSOLE_TYPED, CONSOLE_VALUE, CONSOLE_PRINT, CONSOLE_ERROR, CONSOLE_HELP } console_kind;

typedef enum console_wish {
    CONSOLE_STAY,
    CONSOLE_CLOSE,
    CONSOLE_RUN,      /* `line` */
    CONSOLE_COMPLETE, /* the name before the cursor: console_complete */
    CONSOLE_PASTE,    /* edit_insert what the clipboard holds */
    CONSOLE_COPY      /* `edit.text` to the clipboard */
} console_wish;

typedef struct console_line {
    char *text; /* its own */
    console_kind kind;
} console_line;

typedef struct console {
    bool open, ctrl;
    line_edit edit;
    key_repeat held;
    char line[EDIT_SIZE]; /* to run */
    console_line lines[CONSOLE_LINES];
    size_t first, count; /* of the ring: the oldest; lines in it */
    size_t scroll;       /* lines below the lower edge */
    char *history[CONSOLE_HISTORY];
    size_t history_count, history_at; /* at == count: what is being typed, */
    char draft[EDIT_SIZE];            /* which waits here meanwhile */
    char printed[CONSOLE_PRINTED];    /* the line that the game is printing */
    size_t printed_size;
} console;

void console_free(console *self);
/* A text of lines, each of which becomes one. */
void console_say(console *self, console_kind kind, const char *text);
/* A piece of what the game prints. */
void console_print(console *self, const char *text, size_t size);

void console_show(console *self, bool open);
/* A key; CONSOLE_RUN: `line` has been told and kept already. */
console_wish console_key(console *self, int key, bool down, uint64_t now_ns);
/* A held key, again. */
console_wish console_repeat(console *self, uint64_t now_ns);
void console_type(console *self, int code);
/* Notches, up positive. */
void console_wheel(console *self, float notches);
void console_complete(console *self, const completions *found);

/* Answers lines that are the console's own: help, help NAME, clear. False: the line is Lua. */
bool console_command(console *self, const char *line);

/* ---- console_draw.c ---- */

/* Over the upper half. */
void console_draw(const console *self, const canvas *target, font *face);
/* A line being typed, with its cursor, in a box of this width; the cursor stays in sight. */
void edit_draw(const line_edit *edit, const canvas *target, font *face, float x, float y, float width,
               const text_style *style);

#endif
