/* Texts over the picture. */
#include "view/screen.h"

#include "view/keys.h"

#include <string.h>

static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {176, 188, 206, 255}, DARK = {10, 14, 24, 190},
                          RED = {255, 120, 105, 255}, GOLD = {255, 205, 90, 255};

enum { MARGIN = 12, TEXT = 18, LINE = 24 };

/* A line of text in a box of its own; align says which end stands at x. */
static void label(const canvas *target, font *face, const char *text, float x, float y, text_align align,
                  canvas_color color)
{
    if (!text || !text[0]) return;
    text_style style = {TEXT, color, TEXT_LEFT, false};
    float width = text_width(face, text, TEXT) + 20, left = align == TEXT_LEFT ? x : x - width;
    if (align == TEXT_CENTER) left = x - width / 2;
    canvas_rect(target, left, y, width, LINE + 6, DARK);
    text_draw(target, face, text, left + 10, y + 4, &style);
}

static void draw_found(const canvas *target, font *face, const char *text)
{
    if (!text || !text[0]) return;
    text_style style = {TEXT, WHITE, TEXT_LEFT, false};
    float lines = 1, width = text_width(face, text, TEXT) + 24;
    for (const char *at = text; (at = strchr(at, '\n')); at++) lines++;
    float height = lines * text_line_height(TEXT) + 16, top = CANVAS_HEIGHT - MARGIN - height;
    canvas_rect(target, MARGIN, top, width, height, DARK);
    text_draw(target, face, text, MARGIN + 12, top + 8, &style);
}

static void draw_cross(const canvas *target, float x, float y)
{
    if (x < 0 || y < 0) return;
    float at_x = x * canvas_hud_width(target), at_y = y * CANVAS_HEIGHT;
    const canvas_color dark = {0, 0, 0, 160};
    canvas_rect(target, at_x - 11, at_y - 2, 22, 4, dark);
    canvas_rect(target, at_x - 2, at_y - 11, 4, 22, dark);
    canvas_rect(target, at_x - 10, at_y - 1, 20, 2, GOLD);
    canvas_rect(target, at_x - 1, at_y - 10, 2, 20, GOLD);
}

void screen_camera(const canvas *target, font *face, float x, float y, const char *text)
{
    float at_x = x * canvas_hud_width(target), at_y = y * CANVAS_HEIGHT;
    text_style style = {16, GOLD, TEXT_LEFT, true};
    canvas_rect(target, at_x - 15, at_y - 9, 22, 18, DARK);
    canvas_rect(target, at_x - 13, at_y - 7, 18, 14, GOLD);
    canvas_rect(target, at_x + 5, at_y - 3, 4, 6, GOLD);
    canvas_rect(target, at_x + 9, at_y - 6, 3, 12, GOLD);
    text_draw(target, face, text, at_x + 17, at_y - 10, &style);
}

/* A bar at the lower edge, with the text above it. */
static void draw_work(const canvas *target, font *face, const char *text, float done)
{
    if (!text || !text[0]) return;
    text_style style = {TEXT, WHITE, TEXT_LEFT, false};
    const float width = 520, height = 62, left = (canvas_hud_width(target) - width) / 2;
    const float top = CANVAS_HEIGHT - MARGIN - height, bar = width - 2 * MARGIN;
    canvas_rect(target, left, top, width, height, (canvas_color){10, 14, 24, 225});
    text_draw(target, face, text, left + MARGIN, top + 8, &style);
    canvas_rect(target, left + MARGIN, top + 40, bar, 10, (canvas_color){60, 68, 84, 255});
    canvas_rect(target, left + MARGIN, top + 40, bar * done, 10, GOLD);
}

/* Two columns in the middle. */
static void draw_keys(const canvas *target, font *face)
{
    size_t count;
    const view_key *keys = view_keys(&count);
    const float row = 31, size = 19, gap = 24, wide = canvas_hud_width(target);
    size_t rows = (count + 1) / 2;
    float first = 0, second = 0, name = 0;
    for (size_t i = 0; i < count; i++) {
        float here = text_width(face, keys[i].does, size), shown = text_width(face, keys[i].shown, size);
        if (here > (i < rows ? first : second)) *(i < rows ? &first : &second) = here;
        if (shown > name) name = shown;
    }
    float width = 2 * name + first + second + 5 * gap, height = (float)rows * row + 92;
    float left = (wide - width) / 2, top = (CANVAS_HEIGHT - height) / 2;
    canvas_rect(target, left, top, width, height, (canvas_color){10, 14, 24, 225});
    text_style title = {28, WHITE, TEXT_LEFT, false};
    text_draw(target, face, "Keys", left + gap, top + 18, &title);
    for (size_t i = 0; i < count; i++) {
        float x = left + gap + (i < rows ? 0 : name + first + 2 * gap), y = top + 66 + (float)(i % rows) * row;
        text_style style = {size, GOLD, TEXT_LEFT, false};
        text_draw(target, face, keys[i].shown, x, y, &style);
        style.color = WHITE;
        text_draw(target, face, keys[i].does, x + name + gap / 2, y, &style);
    }
}

void screen_draw(const canvas *target, font *face, const screen_state *s)
{
    float wide = canvas_hud_width(target);
    draw_cross(target, s->cross_x, s->cross_y);
    draw_found(target, face, s->found);
    label(target, face, s->title, wide - MARGIN, MARGIN, TEXT_RIGHT, WHITE);
    label(target, face, s->switches, wide - MARGIN, MARGIN + LINE + 10, TEXT_RIGHT, GOLD);
    label(target, face, s->corner, wide - MARGIN, CANVAS_HEIGHT - MARGIN - LINE - 6, TEXT_RIGHT, GREY);
    draw_work(target, face, s->work, s->done);
    if (s->keys) draw_keys(target, face);
    if (!s->notice || !s->notice[0]) return;
    text_style style = {20, s->bad ? RED : WHITE, TEXT_LEFT, false};
    float most = wide * 0.7f, height = text_draw_wrapped(NULL, face, s->notice, 0, 0, most, &style);
    float width = text_width(face, s->notice, 20), left;
    if (width > most) width = most;
    left = (wide - width) / 2;
    canvas_rect(target, left - 16, 84, width + 32, height + 20, (canvas_color){10, 14, 24, 225});
    text_draw_wrapped(target, face, s->notice, left, 94, width + 1, &style);
}
