/* The inspector's panel. */
#include "tools/inspector.h"

#include <math.h>

static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {150, 162, 178, 255}, ACCENT = {255, 205, 90, 255},
                          RED = {255, 130, 115, 255};
static const float MARGIN = 12, LABEL = 150, SIZE = 16; /* HUD units */

static void place(inspector *self, const canvas *target, panels *placed)
{
    canvas over = *target;
    const float width = canvas_hud_width(target);
    if (self->box.width > 0 && self->hud_width == width) return; /* it stays where somebody is about to click */
    panels_place(placed, &over, INSPECTOR_WIDTH + 24, CANVAS_HEIGHT - 40);
    self->box = (panel_box){over.origin_x / over.unit + 12, 28, INSPECTOR_WIDTH, CANVAS_HEIGHT - 56};
    self->hud_width = width;
}

/* From linear light, near enough for a square of it. */
static uint8_t encode(float value) { return (uint8_t)(255 * powf(fmaxf(0, fminf(value, 1)), 1 / 2.2f) + 0.5f); }

static void draw_color(const inspector *self, const canvas *target, daft_vec3 c, float y)
{
    const float x = self->box.x + self->box.width - MARGIN - 26;
    canvas_rect(target, x, y + 1, 26, 14, (canvas_color){encode(c.x), encode(c.y), encode(c.z), 255});
}

static void draw_value(const inspector *self, const canvas *target, font *face, const inspector_row *row, float y)
{
    const float x = self->box.x + LABEL, room = self->box.width - LABEL - MARGIN;
    text_style style = {SIZE, row->form == FORM_FIXED ? GREY : WHITE, TEXT_LEFT, false};
    canvas part = *target;
    if (self->edits && row == &self->rows[self->at]) {
        canvas_rect(target, x - 5, y - 2, room + 8, INSPECTOR_ROW - 2, (canvas_color){4, 6, 12, 255});
        edit_draw(&self->edit, target, face, x, y, room, &style);
        return;
    }
    canvas_clip(&part, x, y - 4, room, INSPECTOR_ROW + 4);
    text_draw(&part, face, row->value[0] ? row->value : "-", x, y, &style);
    if (row->is_color) draw_color(self, target, row->color, y);
}

static void draw_rows(const inspector *self, const canvas *target, font *face)
{
    const size_t visible = inspector_visible(self);
    for (size_t i = self->first; i < self->count && i < self->first + visible; i++) {
        const float y = self->box.y + INSPECTOR_HEAD + INSPECTOR_ROW * (float)(i - self->first) + 3;
        const text_style style = {SIZE, i == self->at ? ACCENT : GREY, TEXT_LEFT, false};
        if (i == self->at)
            canvas_rect(target, self->box.x, y - 3, self->box.width, INSPECTOR_ROW, (canvas_color){255, 205, 90, 34});
        text_draw(target, face, self->rows[i].label, self->box.x + MARGIN, y, &style);
        draw_value(self, target, face, &self->rows[i], y);
    }
}

/* What went wrong, else what one may press. */
static void draw_foot(const inspector *self, const canvas *target, font *face, float rows)
{
    const char *text = self->told[0] ? self->told
                       : self->edits ? "Enter: set    Esc: leave it"
                       : self->count ? "Click or Enter: change    Up, Down: choose    Esc: close"
                                     : "Esc: close";
    const text_style style = {14, self->told[0] ? RED : GREY, TEXT_LEFT, false};
    text_draw_wrapped(target, face, text, self->box.x + MARGIN, self->box.y + INSPECTOR_HEAD + rows + 10,
                      self->box.width - 2 * MARGIN, &style);
}

void inspector_draw(inspector *self, const canvas *target, font *face, panels *placed)
{
    place(self, target, placed);
    const size_t visible = inspector_visible(self), shown = self->count < visible ? self->count : visible;
    const float rows = INSPECTOR_ROW * (float)shown;
    const text_style title = {20, ACCENT, TEXT_LEFT, false};
    const text_style foot = {14, RED, TEXT_LEFT, false};
    const float told =
        self->told[0] ? text_draw_wrapped(NULL, face, self->told, 0, 0, self->box.width - 2 * MARGIN, &foot) : 0;
    canvas_rect(target, self->box.x, self->box.y, self->box.width,
                fminf(INSPECTOR_HEAD + rows + fmaxf(told, 18) + 20, CANVAS_HEIGHT - self->box.y),
                (canvas_color){8, 11, 20, 218});
    text_draw(target, face, self->title, self->box.x + MARGIN, self->box.y + 9, &title);
    draw_rows(self, target, face);
    draw_foot(self, target, face, rows);
}
