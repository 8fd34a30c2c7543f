/* inspector: what the entity under the mouse is, field by field, to be changed in place (F4). A change is a line of
 * Lua, as one typed in the console: the same setters check it, and recordings hold it. It reads the scene and changes
 * nothing by itself. */
#ifndef RUNTIME_TOOLS_INSPECTOR_H
#define RUNTIME_TOOLS_INSPECTOR_H

#include "hud/canvas.h"
#include "lua/statement.h"
#include "platform/input.h"
#include "tools/console.h"
#include "tools/panels.h"

enum { INSPECTOR_ROWS = 48, INSPECTOR_VALUE = 160, INSPECTOR_MESSAGE = 300 };
static const float INSPECTOR_WIDTH = 380, INSPECTOR_ROW = 23, INSPECTOR_HEAD = 40; /* HUD units */

typedef enum inspector_form {
    FORM_FIXED, /* cannot be changed while the game runs */
    FORM_VALUE, /* an expression of Lua: "1, 2, 3" */
    FORM_TEXT,  /* a string */
    FORM_NAMES, /* strings with commas between them */
    FORM_PAINT, /* a texture's name or a colour, or an expression in braces */
    FORM_FLAG   /* true or false */
} inspector_form;

typedef struct inspector_row {
    const char *label;
    inspector_form form;
    const char *change;          /* Lua behind the entity's name; $ stands for what was typed */
    char value[INSPECTOR_VALUE]; /* as shown */
    bool is_color;
    daft_vec3 color;             /* linear light */
    char exact[INSPECTOR_VALUE]; /* as it is typed, to the bit; empty: the value is */
} inspector_row;

typedef enum inspector_wish {
    INSPECTOR_PASS, /* the event is not its */
    INSPECTOR_KEEP,
    INSPECTOR_PICK, /* what lies under `mouse_x`, `mouse_y` */
    INSPECTOR_RUN,  /* `line` */
    INSPECTOR_CLOSE
} inspector_wish;

typedef struct inspector {
    bool open, edits, ctrl;
    daft_entity chosen; /* none: nothing yet */
    inspector_row rows[INSPECTOR_ROWS];
    size_t count, at, first; /* rows; the one that is selected; the first shown */
    line_edit edit;
    key_repeat held;
    float mouse_x, mouse_y;       /* HUD units */
    panel_box box;                /* where it is drawn; width 0: nowhere yet */
    float hud_width;              /* of the picture that the box was placed in */
    char line[STATEMENT_SIZE];    /* to run, or that runs */
    char told[INSPECTOR_MESSAGE]; /* why the last change failed; or empty */
    char title[INSPECTOR_VALUE];
} inspector;

void inspector_show(inspector *self, bool open);
void inspector_choose(inspector *self, daft_entity entity);
inspector_wish inspector_take(inspector *self, const input_event *event, uint64_t now_ns);
void inspector_repeat(inspector *self, uint64_t now_ns);
/* A line has run: its own, or another's. */
void inspector_answered(inspector *self, const char *line, const char *answer, bool good);
/* Reads the chosen entity into the rows. */
void inspector_read(inspector *self, daft_scene *scene, host *scripts);

/* How many rows fit into the box. */
size_t inspector_visible(const inspector *self);

/* ---- inspector_draw.c ---- */

void inspector_draw(inspector *self, const canvas *target, font *face, panels *placed);

#endif
