/* The console over the picture. */
#include "tools/console.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const canvas_color COLORS[] = {[CONSOLE_TYPED] = {140, 200, 255, 255},
                                      [CONSOLE_VALUE] = {245, 247, 250, 255},
                                      [CONSOLE_PRINT] = {196, 204, 216, 255},
                                      [CONSOLE_ERROR] = {255, 130, 115, 255},
                                      [CONSOLE_HELP] = {160, 172, 188, 255}};
static const float HEIGHT = 380, MARGIN = 16, SIZE = 18; /* HUD units */

void edit_draw(const line_edit *edit, const canvas *target, font *face, float x, float y, float width,
               const text_style *style)
{
    char before[EDIT_SIZE];
    snprintf(before, sizeof before, "%.*s", (int)edit->cursor, edit->text);
    const float cursor = text_width(face, before, style->size), shift = fmaxf(0, cursor - (width - 4));
    canvas part = *target;
    canvas_clip(&part, x, y - 4, width, style->size + 10);
    text_draw(&part, face, edit->text, x - shift, y, style);
    canvas_rect(&part, x + cursor - shift, y - 1, 2, style->size + 4, style->color);
}

/* The newest at the bottom. */
static void draw_lines(const console *self, const canvas *target, font *face, float bottom, float width)
{
    canvas part = *target;
    canvas_clip(&part, 0, 0, width, bottom);
    float y = bottom;
    for (size_t i = self->count - self->scroll; i-- > 0 && y > 0;) {
        const console_line *line = &self->lines[(self->first + i) % CONSOLE_LINES];
        const text_style style = {SIZE, COLORS[line->kind], TEXT_LEFT, false};
        const float inner = width - 2 * MARGIN;
        const float height = text_draw_wrapped(NULL, face, line->text[0] ? line->text : " ", 0, 0, inner, &style);
        y -= height;
        text_draw_wrapped(&part, face, line->text, MARGIN, y, inner, &style);
    }
}

void console_draw(const console *self, const canvas *target, font *face)
{
    const float width = canvas_hud_width(target), prompt = HEIGHT - 34;
    text_style style = {SIZE, COLORS[CONSOLE_TYPED], TEXT_LEFT, false};
    canvas_rect(target, 0, 0, width, HEIGHT, (canvas_color){8, 11, 20, 224});
    canvas_rect(target, 0, HEIGHT, width, 2, (canvas_color){140, 200, 255, 160});
    draw_lines(self, target, face, prompt - 6, width);
    text_draw(target, face, ">", MARGIN, prompt, &style);
    if (self->scroll > 0) {
        char below[40];
        snprintf(below, sizeof below, "%zu more below", self->scroll);
        text_style note = {15, COLORS[CONSOLE_HELP], TEXT_RIGHT, false};
        text_draw(target, face, below, width - MARGIN, prompt + 1, &note);
    }
    if (!self->edit.text[0]) {
        const text_style hint = {SIZE, {120, 132, 150, 255}, TEXT_LEFT, false};
        text_draw(target, face, "Lua; Tab completes, help tells more, Esc closes", MARGIN + 26, prompt, &hint);
    }
    style.color = COLORS[CONSOLE_VALUE];
    edit_draw(&self->edit, target, face, MARGIN + 18, prompt, width - 2 * MARGIN - 160, &style);
}
