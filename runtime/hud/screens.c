/* The error screen and the overlay with frame times. */
#include "hud/screens.h"

#include "common/util.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {170, 180, 195, 255}, RED = {255, 120, 105, 255};

enum { ERROR_FOOT = CANVAS_HEIGHT - 66 }; /* of the keys */

/* Copies the next line, without its tabs, and is how many of these there were; -1: the text has ended. */
static int take_line(const char **text, char *out, size_t size)
{
    const char *at = *text;
    if (!at || !*at) return -1;
    const size_t tabs = strspn(at, "\t"), length = strcspn(at + tabs, "\n");
    snprintf(out, size, "%.*s", (int)length, at + tabs);
    at += tabs + length;
    *text = *at ? at + 1 : at;
    return (int)tabs;
}

/* The lines of the script, in a box. Returns its height. */
static float draw_source(const canvas *target, font *face, const char *source, float x, float y, float width)
{
    const float line_height = 23, inset = 10;
    char line[300];
    int count = 0;
    for (const char *at = source; take_line(&at, line, sizeof line) >= 0;) count++;
    if (count == 0) return 0;
    const float height = line_height * (float)count + 2 * inset;
    canvas_rect(target, x, y, width, height, (canvas_color){8, 11, 18, 255});
    float top = y + inset;
    for (const char *at = source; take_line(&at, line, sizeof line) >= 0; top += line_height) {
        const bool failed = line[0] == '>';
        const char *bar = strchr(line, '|');
        if (!bar) continue;
        if (failed) canvas_rect(target, x, top - 1, width, line_height, (canvas_color){120, 34, 28, 255});
        char number[16];
        snprintf(number, sizeof number, "%d", atoi(line + 1));
        text_style style = {18, failed ? WHITE : GREY, TEXT_RIGHT, false};
        text_draw(target, face, number, x + 54, top, &style);
        style.align = TEXT_LEFT;
        const char *code = bar + 1 + (bar[1] == ' ');
        const float indent = text_width(face, "n", 18) * (float)strspn(code, " "); /* blanks are narrow */
        text_draw(target, face, code + strspn(code, " "), x + 74 + indent, top, &style);
    }
    return height;
}

/* As many lines as fit above the keys. */
static void draw_column(const canvas *target, font *face, const char *text, float x, float y, float width)
{
    text_style style = {17, GREY, TEXT_LEFT, false};
    char line[400];
    for (int tabs; (tabs = take_line(&text, line, sizeof line)) >= 0;) {
        const float indent = tabs > 0 ? 20 : 0;
        style.color = tabs > 0 ? GREY : WHITE;
        if (y + text_draw_wrapped(NULL, face, line, 0, 0, width - indent, &style) > ERROR_FOOT - 8) return;
        y += text_draw_wrapped(target, face, line, x + indent, y, width - indent, &style);
    }
}

void screen_error(const canvas *target, font *face, const error_report *report)
{
    const float width = canvas_hud_width(target), margin = 48, inner = width - 2 * margin;
    canvas_rect(target, 0, 0, width, CANVAS_HEIGHT, (canvas_color){18, 22, 32, 244});
    canvas_rect(target, 0, 0, width, 6, RED);
    text_style style = {30, RED, TEXT_LEFT, false};
    char title[200];
    snprintf(title, sizeof title, "%.150s has stopped", report->game);
    text_draw(target, face, title, margin, 30, &style);
    style.size = 24, style.color = WHITE;
    float y = 80;
    y += text_draw_wrapped(target, face, report->message, margin, y, inner, &style) + 14;
    y += draw_source(target, face, report->source, margin, y, inner) + 16;
    const bool both = report->values[0] && report->trace[0];
    const float column = both ? (inner - 32) / 2 : inner;
    draw_column(target, face, report->trace, margin, y, column);
    draw_column(target, face, report->values, both ? margin + column + 32 : margin, y, column);
    style.size = 22, style.color = WHITE;
    canvas_rect(target, margin, ERROR_FOOT, inner, 1, (canvas_color){255, 255, 255, 60});
    text_draw(target, face, report->keys, margin, ERROR_FOOT + 16, &style);
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
