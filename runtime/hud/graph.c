/* The figures of the last frames, and their bars. */
#include "hud/graph.h"

#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {170, 180, 195, 255}, GROUND = {10, 14, 24, 190},
                          UPDATE = {255, 190, 80, 255}, PICTURE = {95, 165, 255, 255}, REST = {95, 104, 122, 255},
                          TARGET = {110, 225, 130, 220}, WORST = {255, 105, 90, 255};

/* ---- keeping ---- */

void graph_add_update(frame_graph *self, double ms) { self->now.update += (float)ms; }

void graph_add_picture(frame_graph *self, double ms, const daft_counters *counters)
{
    self->now.picture += (float)ms;
    self->now.scene += (float)counters->frame_ms;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) {
        self->names[i] = counters->effects[i].name;
        if (counters->effects[i].ran) self->now.effects[i] += (float)counters->effects[i].ms;
    }
}

void graph_end_frame(frame_graph *self, double total)
{
    if (total > 0) {
        self->now.total = (float)total;
        self->frames[self->next] = self->now;
        self->next = (self->next + 1) % GRAPH_FRAMES;
        if (self->count < GRAPH_FRAMES) self->count++;
    }
    self->now = (graph_frame){0};
}

/* The i-th of those that are kept, the oldest first. */
static const graph_frame *frame_at(const frame_graph *self, uint32_t i)
{
    return &self->frames[(self->next + GRAPH_FRAMES - self->count + i) % GRAPH_FRAMES];
}

static uint32_t find_worst(const frame_graph *self)
{
    uint32_t worst = 0;
    for (uint32_t i = 1; i < self->count; i++)
        if (frame_at(self, i)->total > frame_at(self, worst)->total) worst = i;
    return worst;
}

const graph_frame *graph_worst(const frame_graph *self)
{
    return self->count > 0 ? frame_at(self, find_worst(self)) : NULL;
}

/* ---- what took the time ---- */

typedef struct part {
    const char *name;
    float ms;
} part;

static void put_part(part *largest, size_t count, part next)
{
    for (size_t i = 0; i < count; i++) {
        if (!(next.ms > largest[i].ms)) continue;
        const part smaller = largest[i];
        largest[i] = next, next = smaller;
    }
}

const char *graph_describe(const frame_graph *self, const graph_frame *frame, char out[GRAPH_TEXT])
{
    part largest[3] = {{0}};
    put_part(largest, COUNT_OF(largest), (part){"updates", frame->update});
    put_part(largest, COUNT_OF(largest), (part){"waiting", frame->total - frame->update - frame->picture});
    put_part(largest, COUNT_OF(largest), (part){"texts and panels", frame->picture - frame->scene});
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++)
        if (self->names[i]) put_part(largest, COUNT_OF(largest), (part){self->names[i], frame->effects[i]});
    out[0] = 0;
    for (size_t i = 0; i < COUNT_OF(largest) && largest[i].ms >= 0.05f; i++) {
        const size_t used = strlen(out);
        snprintf(out + used, GRAPH_TEXT - used, "%s%s %.1f", i > 0 ? ", " : "", largest[i].name, (double)largest[i].ms);
    }
    return out;
}

/* ---- drawing ---- */

static const float MARGIN = 12, TOP = 58, BAR = 2; /* HUD units; BAR: from one bar to the next */
static const float BARS = GRAPH_HEIGHT - 58 - 12;  /* the height of the longest */

/* Milliseconds that the whole height stands for: a single long frame must not flatten the others. */
static float range_of(float worst, float target) { return fminf(fmaxf(1.1f * worst, 1.5f * target), 4 * target); }

/* From `from` to `to` milliseconds. Returns `to`. */
static float draw_part(const canvas *target, float x, float from, float to, float range, canvas_color color)
{
    const float a = BARS * fminf(from / range, 1), b = BARS * fminf(to / range, 1);
    if (b > a) canvas_rect(target, x, TOP + BARS - b, BAR, b - a, color);
    return fmaxf(from, to);
}

static void draw_bars(const canvas *target, const frame_graph *self, float range)
{
    for (uint32_t i = 0; i < self->count; i++) {
        const graph_frame *f = frame_at(self, i);
        const float x = MARGIN + BAR * (float)(GRAPH_FRAMES - self->count + i);
        float done = draw_part(target, x, 0, f->update, range, UPDATE);
        done = draw_part(target, x, done, done + f->picture, range, PICTURE);
        draw_part(target, x, done, f->total, range, REST);
    }
}

static void draw_worst(const canvas *target, font *face, const frame_graph *self, float range)
{
    const uint32_t at = find_worst(self);
    const graph_frame *worst = frame_at(self, at);
    const float x = MARGIN + BAR * (float)(GRAPH_FRAMES - self->count + at), y = BARS * fminf(worst->total / range, 1);
    const canvas_point mark[3] = {{x + 1, TOP + BARS - y}, {x - 4, TOP + BARS - y - 7}, {x + 6, TOP + BARS - y - 7}};
    char text[64], parts[GRAPH_TEXT];
    canvas_polygon(target, mark, COUNT_OF(mark), WORST);
    text_style style = {17, WORST, TEXT_LEFT, false};
    snprintf(text, sizeof text, "worst %.1f ms: ", (double)worst->total);
    text_draw(target, face, text, MARGIN, 28, &style);
    const float after = MARGIN + text_width(face, text, style.size);
    style.color = WHITE;
    text_draw(target, face, graph_describe(self, worst, parts), after, 28, &style);
}

/* The names of the colours, from the right. */
static void draw_legend(const canvas *target, font *face)
{
    static const struct {
        const char *name;
        const canvas_color *color;
    } NAMES[] = {{"rest", &REST}, {"picture", &PICTURE}, {"updates", &UPDATE}};
    float x = GRAPH_WIDTH - MARGIN;
    for (size_t i = 0; i < COUNT_OF(NAMES); i++) {
        const text_style style = {17, GREY, TEXT_RIGHT, false};
        text_draw(target, face, NAMES[i].name, x, 7, &style);
        x -= text_width(face, NAMES[i].name, style.size) + 15;
        canvas_rect(target, x, 12, 10, 10, *NAMES[i].color);
        x -= 12;
    }
}

void graph_draw(const canvas *target, font *face, const frame_graph *self, double target_ms)
{
    if (self->count == 0) return;
    const float goal = (float)target_ms, range = range_of(graph_worst(self)->total, goal);
    char text[64];
    text_style style = {17, GREY, TEXT_LEFT, false};
    canvas_rect(target, 0, 0, GRAPH_WIDTH, GRAPH_HEIGHT, GROUND);
    snprintf(text, sizeof text, "%u frames, line at %.1f ms", (unsigned)self->count, target_ms);
    text_draw(target, face, text, MARGIN, 7, &style);
    draw_legend(target, face);
    draw_bars(target, self, range);
    canvas_rect(target, MARGIN, TOP + BARS * (1 - goal / range), GRAPH_WIDTH - 2 * MARGIN, 1, TARGET);
    draw_worst(target, face, self, range);
}
