/* The error screen and the overlay with frame times. */
#include "hud/screens.h"

#include "common/util.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {170, 180, 195, 255}, RED = {255, 120, 105, 255};

void screen_error(const canvas *target, font *face, const char *game, const char *message, const char *trace)
{
    float width = canvas_hud_width(target), margin = 48, inner = width - 2 * margin;
    canvas_rect(target, 0, 0, width, CANVAS_HEIGHT, (canvas_color){18, 22, 32, 238});
    canvas_rect(target, 0, 0, width, 6, RED);
    text_style style = {34, RED, TEXT_LEFT, false};
    char title[200];
    snprintf(title, sizeof title, "%.150s has stopped", game);
    text_draw(target, face, title, margin, 36, &style);
    style.size = 26, style.color = WHITE;
    float y = 96;
    y += text_draw_wrapped(target, face, message, margin, y, inner, &style) + 22;
    style.size = 18, style.color = GREY;
    /* As much of the trace as fits above the last line. */
    char line[400];
    while (trace && *trace && y < CANVAS_HEIGHT - 90) {
        const char *end = strchr(trace, '\n');
        snprintf(line, sizeof line, "%.*s", (int)(end ? end - trace : (long)strlen(trace)), trace);
        const char *text = line + strspn(line, "\t");
        y += text_draw_wrapped(target, face, text, margin + (text > line ? 24 : 0), y, inner - 24, &style);
        trace = end ? end + 1 : NULL;
    }
    style.size = 24, style.color = WHITE;
    canvas_rect(target, margin, CANVAS_HEIGHT - 66, inner, 1, (canvas_color){255, 255, 255, 60});
    text_draw(target, face, "R  reload          Esc  leave", margin, CANVAS_HEIGHT - 52, &style);
}

void screen_notice(const canvas *target, font *face, const char *text, bool wrong)
{
    const float width = canvas_hud_width(target), inner = width - 96;
    const text_style style = {22, WHITE, TEXT_LEFT, false};
    const float height = fminf(text_draw_wrapped(NULL, face, text, 0, 0, inner, &style), CANVAS_HEIGHT - 40) + 24;
    const float top = CANVAS_HEIGHT - height;
    canvas_rect(target, 0, top, width, height,
                wrong ? (canvas_color){92, 18, 14, 230} : (canvas_color){10, 14, 24, 190});
    text_draw_wrapped(target, face, text, 48, top + 12, inner, &style);
}

static void overlay_line(const canvas *target, font *face, float *y, const char *label, const char *value)
{
    text_style style = {17, GREY, TEXT_LEFT, false};
    text_draw(target, face, label, 22, *y, &style);
    style.color = WHITE, style.align = TEXT_RIGHT;
    text_draw(target, face, value, 288, *y, &style);
    *y += 21;
}

void screen_overlay(const canvas *target, font *face, const overlay_figures *figures)
{
    const daft_counters *c = figures->counters;
    size_t lines = figures->quality ? 15 : 11;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) lines += c->effects[i].name != NULL;
    canvas_rect(target, 12, 12, 288, 16 + 21 * (float)lines, (canvas_color){10, 14, 24, 190});
    float y = 20;
    char value[64];
    snprintf(value, sizeof value, "%.0f", figures->frames_per_second);
    overlay_line(target, face, &y, "frames a second", value);
    snprintf(value, sizeof value, "%.2f ms", figures->update_ms);
    overlay_line(target, face, &y, "updates", value);
    snprintf(value, sizeof value, "%.2f ms", figures->frame_ms);
    overlay_line(target, face, &y, "picture", value);
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++) {
        if (!c->effects[i].name) continue;
        char label[64];
        snprintf(label, sizeof label, "    %s", c->effects[i].name);
        snprintf(value, sizeof value, c->effects[i].ran ? "%.2f ms" : "-", c->effects[i].ms);
        overlay_line(target, face, &y, label, value);
    }
    const struct {
        const char *name;
        uint64_t rays;
    } rays[] = {
        {"camera rays", c->camera_rays}, {"shadow rays", c->shadow_rays}, {"reflection rays", c->reflection_rays}};
    for (size_t i = 0; i < COUNT_OF(rays); i++) {
        snprintf(value, sizeof value, "%" PRIu64, rays[i].rays);
        overlay_line(target, face, &y, rays[i].name, value);
    }
    const daft_sim_counters *sim = &figures->simulation;
    snprintf(value, sizeof value, "%" PRIu32 " of %" PRIu32, sim->awake, sim->bodies);
    overlay_line(target, face, &y, "bodies awake", value);
    snprintf(value, sizeof value, "%" PRIu32, sim->substeps);
    overlay_line(target, face, &y, "substeps", value);
    snprintf(value, sizeof value, "%d x %d", c->width, c->height);
    overlay_line(target, face, &y, "size", value);
    snprintf(value, sizeof value, "%" PRIu64, figures->dropped);
    overlay_line(target, face, &y, "updates dropped", value);
    const daft_memory *memory = &figures->memory;
    snprintf(value, sizeof value, memory->limit ? "%.1f of %.0f MB" : "%.1f MB", (double)memory->used / 1e6,
             (double)memory->limit / 1e6);
    overlay_line(target, face, &y, "memory", value);
    if (!figures->quality) return;
    snprintf(value, sizeof value, "%.2f ms", figures->slow_ms);
    overlay_line(target, face, &y, "95 % of frames within", value);
    const text_style style = {17, GREY, TEXT_LEFT, false};
    text_draw_wrapped(target, face, figures->quality, 22, y, 266, &style);
}
