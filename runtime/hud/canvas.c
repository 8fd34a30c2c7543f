/* Draws rectangles over a finished picture. */
#include "hud/canvas.h"

#include <math.h>
#include <string.h>

canvas canvas_over(daft_image *image)
{
    int height = daft_image_height(image);
    return (canvas){.pixels = daft_image_pixels(image),
                    .width = daft_image_width(image),
                    .height = height,
                    .unit = (float)height / CANVAS_HEIGHT};
}

bool canvas_stops(const canvas *target) { return target->stops && target->stops(target->user); }

float canvas_hud_width(const canvas *target) { return (float)target->width * CANVAS_HEIGHT / (float)target->height; }

/* Clamps; NaN becomes `low`. */
static float clamp(float value, float low, float high)
{
    if (!(value > low)) return low;
    return value < high ? value : high;
}

/* ---- where it is drawn ---- */

canvas_box canvas_bounds(const canvas *target)
{
    return target->clipped ? target->clip : (canvas_box){0, 0, target->width, target->height};
}

void canvas_clip(canvas *target, float x, float y, float width, float height)
{
    const float w = (float)target->width, h = (float)target->height, unit = target->unit;
    const float left = target->origin_x + x * unit, top = target->origin_y + y * unit;
    target->clipped = true;
    target->clip.left = (int)(clamp(left, 0, w) + 0.5f), target->clip.top = (int)(clamp(top, 0, h) + 0.5f);
    target->clip.right = (int)(clamp(left + width * unit, 0, w) + 0.5f);
    target->clip.bottom = (int)(clamp(top + height * unit, 0, h) + 0.5f);
}

void canvas_unclip(canvas *target) { target->clipped = false; }

void canvas_fit(canvas *target, float width, float height)
{
    const float across = (float)target->width / width, down = (float)target->height / height;
    target->unit = fminf(across, down);
    target->origin_x = ((float)target->width - width * target->unit) / 2;
    target->origin_y = ((float)target->height - height * target->unit) / 2;
}

void canvas_reset(canvas *target)
{
    target->unit = (float)target->height / CANVAS_HEIGHT;
    target->origin_x = target->origin_y = 0;
}

static int mark_of(float place, int most) { return (int)clamp(place / MARK_UNITS, 0, (float)most - 1); }

void canvas_mark(const canvas *target, float left, float top, float right, float bottom)
{
    const float unit = (float)target->height / CANVAS_HEIGHT;
    if (!target->marks || !(right > 0) || !(bottom > 0) || !(left < (float)target->width) ||
        !(top < (float)target->height))
        return;
    for (int row = mark_of(top / unit, MARK_ROWS); row <= mark_of(bottom / unit, MARK_ROWS); row++)
        for (int i = mark_of(left / unit, MARK_COLUMNS); i <= mark_of(right / unit, MARK_COLUMNS); i++)
            target->marks->at[row][i] = true;
}

int canvas_count_marks(const canvas_marks *marks, float x, float y, float width, float height)
{
    int count = 0;
    for (int row = mark_of(y, MARK_ROWS); row <= mark_of(y + height, MARK_ROWS); row++)
        for (int i = mark_of(x, MARK_COLUMNS); i <= mark_of(x + width, MARK_COLUMNS); i++) count += marks->at[row][i];
    return count;
}

/* ---- rectangles ---- */

static uint8_t blend(uint8_t under, uint8_t over, uint32_t alpha)
{
    return (uint8_t)((under * (255 - alpha) + over * alpha + 127) / 255);
}

void canvas_blend(const canvas *target, int x, int y, canvas_color color, float covered)
{
    uint8_t *pixel = target->pixels + 4 * ((size_t)y * (size_t)target->width + (size_t)x);
    const uint32_t alpha = (uint32_t)(covered * (float)color.a + 0.5f);
    pixel[0] = blend(pixel[0], color.r, alpha);
    pixel[1] = blend(pixel[1], color.g, alpha);
    pixel[2] = blend(pixel[2], color.b, alpha);
}

static float overlap(float low, float high, int pixel)
{
    return fminf(high, (float)pixel + 1) - fmaxf(low, (float)pixel);
}

/* A row of pixels, all by the same alpha, sixteen bytes at a time: products of bytes fit in 16 bits, and so does this
 * division by 255, which is exact below 65,535. */
static void blend_row(uint8_t *pixels, int count, canvas_color color, uint32_t alpha)
{
    enum { STEP = 16 };
    const uint32_t over[4] = {color.r * alpha, color.g * alpha, color.b * alpha, 0};
    uint16_t keep[STEP], add[STEP];
    for (int i = 0; i < STEP; i++) {
        keep[i] = (uint16_t)(i % 4 == 3 ? 255 : 255 - alpha); /* the picture's own alpha stays */
        add[i] = (uint16_t)(over[i % 4] + 127);
    }
    for (int left = 4 * count; left > 0; left -= STEP, pixels += STEP) {
        uint8_t bytes[STEP];
        const size_t some = (size_t)(left < STEP ? left : STEP);
        if (some < STEP) memset(bytes, 0, sizeof bytes);
        memcpy(bytes, pixels, some);
        for (int i = 0; i < STEP; i++) {
            const uint16_t sum = (uint16_t)(bytes[i] * keep[i] + add[i]);
            bytes[i] = (uint8_t)((uint16_t)(sum + 1 + (sum >> 8)) >> 8);
        }
        memcpy(pixels, bytes, some);
    }
}

/* Pixels on the border blend by their coverage. */
void canvas_rect(const canvas *target, float x, float y, float width, float height, canvas_color color)
{
    const canvas_box clip = canvas_bounds(target);
    const float w0 = (float)clip.left, w1 = (float)clip.right, h0 = (float)clip.top, h1 = (float)clip.bottom;
    const float unit = target->unit;
    if (!(width > 0) || !(height > 0) || !isfinite(x) || !isfinite(y)) return;
    const float left = clamp(target->origin_x + x * unit, w0, w1),
                right = clamp(target->origin_x + (x + width) * unit, w0, w1),
                top = clamp(target->origin_y + y * unit, h0, h1),
                bottom = clamp(target->origin_y + (y + height) * unit, h0, h1);
    for (int row = (int)top; row < clip.bottom && (float)row < bottom; row++) {
        const float across = overlap(top, bottom, row);
        int column = (int)left;
        if (column >= clip.right || (float)column >= right) return;
        const int whole = (int)right - column - 1; /* columns that it covers from side to side, after the first */
        canvas_blend(target, column, row, color, across * overlap(left, right, column));
        column++;
        if (whole > 0) {
            uint8_t *from = target->pixels + 4 * ((size_t)row * (size_t)target->width + (size_t)column);
            blend_row(from, whole, color, (uint32_t)(across * (float)color.a + 0.5f));
            column += whole;
        }
        for (; column < clip.right && (float)column < right; column++)
            canvas_blend(target, column, row, color, across * overlap(left, right, column));
    }
}
