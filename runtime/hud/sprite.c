/* Pictures over the picture: scaled, turned, tinted, a part of them, or as nine patches. For each pixel the place in
 * the source is computed, and taken from the four texels around it, or from more where the source is much finer. */
#include "hud/canvas.h"

#include <math.h>

enum { MOST_TAPS = 8 };

canvas_sprite canvas_default_sprite(const daft_image *image)
{
    const float width = (float)daft_image_width(image), height = (float)daft_image_height(image);
    return (canvas_sprite){.source_width = width,
                           .source_height = height,
                           .width = width,
                           .height = height,
                           .scale = 1,
                           .tint = {255, 255, 255, 255},
                           .smooth = true};
}

/* How one axis of the drawn picture goes to the source's. */
typedef struct axis {
    float size;          /* of what is drawn, pixels */
    float from, to;      /* source, texels */
    float border, patch; /* texels at both ends that are not stretched; pixels that they take */
    float middle;        /* texels a pixel between them */
    int taps;            /* samples along this axis for a pixel */
} axis;

static axis make_axis(float size, float from, float length, float border, float pixels_a_texel)
{
    axis a = {.size = size, .from = from, .to = from + length};
    a.border = fminf(border, length / 2), a.patch = a.border * pixels_a_texel;
    if (a.patch > size / 2) a.patch = size / 2;
    const float rest = size - 2 * a.patch;
    a.middle = rest > 0 ? (length - 2 * a.border) / rest : 0;
    const float taps = ceilf(a.middle);
    a.taps = taps > 1 ? taps < MOST_TAPS ? (int)taps : MOST_TAPS : 1;
    return a;
}

static float source_of(const axis *a, float place)
{
    if (a->patch > 0 && place < a->patch) return a->from + place / a->patch * a->border;
    if (a->patch > 0 && place > a->size - a->patch) return a->to - (a->size - place) / a->patch * a->border;
    return a->from + a->border + (place - a->patch) * a->middle;
}

typedef struct texels {
    const uint8_t *pixels;
    size_t width;
} texels;

/* Sums of colour times alpha, and of alpha, 0 to 255. */
typedef struct sum {
    float r, g, b, a;
} sum;

/* The texel in the source that is nearest. */
static size_t limit(float value, float low, float high)
{
    if (!(value > low)) return (size_t)low;
    return (size_t)(value > high - 1 ? high - 1 : value);
}

static void add_texel(const texels *from, const axis *h, const axis *v, float x, float y, float weight, sum *out)
{
    const size_t column = limit(x, h->from, h->to), row = limit(y, v->from, v->to);
    const uint8_t *texel = from->pixels + 4 * (row * from->width + column);
    const float alpha = weight * (float)texel[3];
    out->r += alpha * (float)texel[0], out->g += alpha * (float)texel[1], out->b += alpha * (float)texel[2];
    out->a += alpha;
}

static void add_sample(const texels *from, const axis *h, const axis *v, float x, float y, bool smooth, sum *out)
{
    if (!smooth) {
        add_texel(from, h, v, floorf(x), floorf(y), 1, out);
        return;
    }
    const float left = floorf(x - 0.5f), top = floorf(y - 0.5f), fx = x - 0.5f - left, fy = y - 0.5f - top;
    add_texel(from, h, v, left, top, (1 - fx) * (1 - fy), out);
    add_texel(from, h, v, left + 1, top, fx * (1 - fy), out);
    add_texel(from, h, v, left, top + 1, (1 - fx) * fy, out);
    add_texel(from, h, v, left + 1, top + 1, fx * fy, out);
}

/* A place in what is drawn, pixels from its top left. */
static sum sample(const canvas_sprite *s, const texels *from, const axis *h, const axis *v, float x, float y)
{
    sum out = {0, 0, 0, 0};
    const bool smooth = s->smooth && h->taps == 1 && v->taps == 1; /* the mean of many is smooth as it is */
    for (int j = 0; j < v->taps; j++)
        for (int i = 0; i < h->taps; i++) {
            const float px = x + ((float)i + 0.5f) / (float)h->taps - 0.5f;
            const float py = y + ((float)j + 0.5f) / (float)v->taps - 0.5f;
            add_sample(from, h, v, source_of(h, px), source_of(v, py), smooth, &out);
        }
    return out;
}

static uint8_t tinted(float total, float alpha, uint8_t tint)
{
    return (uint8_t)(total / alpha * (float)tint / 255 + 0.5f);
}

static float inside(float place, float size) { return fminf(fminf(place + 0.5f, size - place + 0.5f), 1); }

void canvas_draw_sprite(const canvas *target, const daft_image *image, float x, float y, const canvas_sprite *s)
{
    const float unit = target->unit, w = s->width * unit, h = s->height * unit;
    const float cosine = (float)daft_cos((double)s->rotation), sine = (float)daft_sin((double)s->rotation);
    const float px = x * unit + target->origin_x, py = y * unit + target->origin_y;
    if (!(w > 0) || !(h > 0) || !(w < 1e5f) || !(h < 1e5f) || !(fabsf(px) < 1e6f) || !(fabsf(py) < 1e6f)) return;
    const axis across = make_axis(w, s->source_x, s->source_width, s->border, s->scale * unit),
               down = make_axis(h, s->source_y, s->source_height, s->border, s->scale * unit);
    const texels from = {daft_image_pixels((daft_image *)(uintptr_t)image), (size_t)daft_image_width(image)};
    /* The box around its corners. */
    canvas_box box = canvas_bounds(target);
    float left = 1e9f, top = 1e9f, right = -1e9f, bottom = -1e9f;
    for (int i = 0; i < 4; i++) {
        const float cx = ((float)(i & 1) - s->origin_x) * w, cy = ((float)(i >> 1) - s->origin_y) * h;
        const float at_x = px + cx * cosine - cy * sine, at_y = py + cx * sine + cy * cosine;
        left = fminf(left, at_x), right = fmaxf(right, at_x), top = fminf(top, at_y), bottom = fmaxf(bottom, at_y);
    }
    if ((float)box.left < left - 1) box.left = (int)fminf(left - 1, (float)box.right);
    if ((float)box.top < top - 1) box.top = (int)fminf(top - 1, (float)box.bottom);
    for (int row = box.top; row < box.bottom && (float)row < bottom + 1 && !canvas_stops(target); row++) {
        for (int column = box.left; column < box.right && (float)column < right + 1; column++) {
            const float dx = (float)column + 0.5f - px, dy = (float)row + 0.5f - py;
            const float u = dx * cosine + dy * sine + s->origin_x * w, v = dy * cosine - dx * sine + s->origin_y * h;
            const float covered = inside(u, w) * inside(v, h);
            if (!(inside(u, w) > 0) || !(inside(v, h) > 0)) continue;
            const sum c = sample(s, &from, &across, &down, u, v);
            if (c.a <= 0) continue;
            const float taps = (float)(across.taps * down.taps);
            const canvas_color color = {tinted(c.r, c.a, s->tint.r), tinted(c.g, c.a, s->tint.g),
                                        tinted(c.b, c.a, s->tint.b),
                                        (uint8_t)(c.a / taps * (float)s->tint.a / 255 + 0.5f)};
            canvas_blend(target, column, row, color, covered);
        }
    }
}
