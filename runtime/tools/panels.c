/* Tries places along the upper and the lower edge, and below other panels. */
#include "tools/panels.h"

#include <math.h>

enum { STEPS = 8 };

static float overlap(float a, float a_size, float b, float b_size)
{
    return fmaxf(0, fminf(a + a_size, b + b_size) - fmaxf(a, b));
}

/* Squares of text that it would cover; what it covers of other panels counts more than any text. */
static float cost_of(const panels *self, const panel_box *box)
{
    float cost = (float)canvas_count_marks(self->marks, box->x, box->y, box->width, box->height);
    for (size_t i = 0; i < self->count; i++) {
        const panel_box *other = &self->taken[i];
        cost +=
            overlap(box->x, box->width, other->x, other->width) * overlap(box->y, box->height, other->y, other->height);
    }
    return cost;
}

static void try_place(const panels *self, panel_box box, panel_box *best, float *least)
{
    const float cost = cost_of(self, &box);
    if (cost < *least) *least = cost, *best = box;
}

void panels_take(panels *self, panel_box box)
{
    if (self->count < PANELS) self->taken[self->count++] = box;
}

/* All places of a row. */
static void try_row(const panels *self, panel_box box, float right, panel_box *best, float *least)
{
    for (int i = 0; i <= STEPS; i++) {
        box.x = right * (float)i / STEPS;
        try_place(self, box, best, least);
        for (size_t k = 0; k < self->count && i == 0; k++) { /* beside another */
            box.x = fminf(self->taken[k].x + self->taken[k].width, right);
            try_place(self, box, best, least);
        }
    }
}

void panels_place(panels *self, canvas *over, float width, float height)
{
    const float right = fmaxf(canvas_hud_width(over) - width, 0), low = CANVAS_HEIGHT - height;
    panel_box best = {0, 0, width, height};
    float least = INFINITY;
    try_row(self, best, right, &best, &least);
    try_row(self, (panel_box){0, low, width, height}, right, &best, &least);
    for (size_t k = 0; k < self->count; k++) { /* below another */
        const float y = self->taken[k].y + self->taken[k].height;
        if (y < low) try_row(self, (panel_box){0, y, width, height}, right, &best, &least);
    }
    panels_take(self, best);
    over->origin_x = best.x * over->unit, over->origin_y = best.y * over->unit;
}
