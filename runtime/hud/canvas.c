/* Draws rectangles over a finished picture. */
#include "hud/canvas.h"

#include <math.h>

canvas canvas_over(daft_image *image)
{
    int height = daft_image_height(image);
    return (canvas){.pixels = daft_image_pixels(image),
                    .width = daft_image_width(image),
                    .height = height,
                    .unit = (float)height / CANVAS_HEIGHT};
}

bool canvas_stops(const canvas *target) { return target->stops && target->stops(target->user); }

float canvas_hud_width(const canvas *target) { return (float)target->width / target->unit; }

/* Clamps; NaN becomes `low`. */
static float clamp(float value, float low, float high)
{
    if (!(value > low)) return low;
    return value < high ? value : high;
}

static uint8_t blend(uint8_t under, uint8_t over, uint32_t alpha)
{
    return (uint8_t)((under * (255 - alpha) + over * alpha + 127) / 255);
}

static float overlap(float low, float high, int pixel)
{
    return fminf(high, (float)pixel + 1) - fmaxf(low, (float)pixel);
}

/* Pixels on the border blend by their coverage. */
void canvas_rect(const canvas *target, float x, float y, float width, float height, canvas_color color)
{
    float w = (float)target->width, h = (float)target->height, unit = target->unit;
    if (!(width > 0) || !(height > 0) || !isfinite(x) || !isfinite(y)) return;
    float left = clamp(x * unit, 0, w), right = clamp((x + width) * unit, 0, w);
    float top = clamp(y * unit, 0, h), bottom = clamp((y + height) * unit, 0, h);
    for (int row = (int)top; row < target->height && (float)row < bottom; row++) {
        float across = overlap(top, bottom, row);
        uint8_t *pixel = target->pixels + 4 * ((size_t)row * (size_t)target->width + (size_t)left);
        for (int column = (int)left; column < target->width && (float)column < right; column++, pixel += 4) {
            uint32_t alpha = (uint32_t)(across * overlap(left, right, column) * (float)color.a + 0.5f);
            pixel[0] = blend(pixel[0], color.r, alpha);
            pixel[1] = blend(pixel[1], color.g, alpha);
            pixel[2] = blend(pixel[2], color.b, alpha);
        }
    }
}
