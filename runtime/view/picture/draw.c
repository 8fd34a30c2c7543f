/* Pictures and channels. */
#include "view/picture/draw.h"

#include <math.h>
#include <stdlib.h>

typedef struct rgb {
    uint8_t r, g, b;
} rgb;

/* ---- arrays ---- */

static bool allocate(pixel_channels *c, int width, int height, daft_error *error)
{
    if (c->width == width && c->height == height) return true;
    draw_free(c);
    size_t pixels = (size_t)width * (size_t)height;
    daft_aov *a = &c->arrays;
    a->depth = malloc(pixels * sizeof *a->depth);
    a->normal = malloc(pixels * sizeof *a->normal);
    a->entity = malloc(pixels * sizeof *a->entity);
    a->triangle = malloc(pixels * sizeof *a->triangle);
    a->motion = malloc(pixels * sizeof *a->motion);
    a->cost = malloc(pixels * sizeof *a->cost);
    if (!a->depth || !a->normal || !a->entity || !a->triangle || !a->motion || !a->cost) {
        draw_free(c);
        return fail(error, DAFT_ERROR_MEMORY, "out of memory for the channels of %d x %d pixels", width, height);
    }
    c->width = width, c->height = height;
    return true;
}

void draw_free(pixel_channels *c)
{
    free(c->arrays.depth);
    free(c->arrays.normal);
    free(c->arrays.entity);
    free(c->arrays.triangle);
    free(c->arrays.motion);
    free(c->arrays.cost);
    *c = (pixel_channels){.history = c->history};
}

/* ---- colours ---- */

static const rgb SKY = {24, 27, 34};

static uint8_t byte_of(double x) { return (uint8_t)(fmax(0, fmin(1, x)) * 255 + 0.5); }

/* The range of depths that are seen, so that its ends are white and black. */
static void depth_range(const pixel_channels *c, float *low, float *high)
{
    size_t count = (size_t)c->width * (size_t)c->height;
    *low = INFINITY, *high = 0;
    for (size_t i = 0; i < count; i++) {
        float d = c->arrays.depth[i];
        if (!isfinite(d) || !(d > 0)) continue;
        *low = fminf(*low, d), *high = fmaxf(*high, d);
    }
}

/* By the logarithm, since what is near is what one wants to tell apart. */
static rgb depth_color(float depth, float low, float high)
{
    if (!isfinite(depth)) return SKY;
    double range = log((double)high / (double)low), t = depth > low ? log((double)depth / (double)low) : 0;
    uint8_t grey = byte_of(1 - 0.85 * (range > 0 ? t / range : 0));
    return (rgb){grey, grey, grey};
}

static rgb normal_color(daft_vec3 n)
{
    if (n.x == 0 && n.y == 0 && n.z == 0) return SKY;
    return (rgb){byte_of(0.5 + 0.5 * (double)n.x), byte_of(0.5 + 0.5 * (double)n.y), byte_of(0.5 + 0.5 * (double)n.z)};
}

/* Numbers next to each other get colours far apart. */
static rgb number_color(uint32_t a, uint32_t b)
{
    uint32_t numbers[2] = {a, b};
    uint64_t hash = daft_hash(numbers, sizeof numbers, 0);
    return (rgb){(uint8_t)(64 + (hash >> 40 & 0xff) * 3 / 4), (uint8_t)(64 + (hash >> 24 & 0xff) * 3 / 4),
                 (uint8_t)(64 + (hash >> 8 & 0xff) * 3 / 4)};
}

/* Grey where nothing moves; right and down are red and green, and 24 pixels the brightest. */
static rgb motion_color(daft_vec2 motion)
{
    return (rgb){byte_of(0.5 + (double)motion.x / 48), byte_of(0.5 + (double)motion.y / 48), 128};
}

/* From blue over red and yellow to white, by the logarithm: one ray is blue, 64 are white. */
static rgb cost_color(uint32_t rays)
{
    const double t = log2(fmax(1, rays)) / 6 * 3;
    return (rgb){byte_of(t), byte_of(t - 1), byte_of(t < 1 ? 0.5 - t / 2 : t - 2)};
}

static rgb channel_color(const pixel_channels *c, view_channel channel, size_t i, float low, float high)
{
    uint32_t entity = c->arrays.entity[i].id;
    switch (channel) {
    case VIEW_DEPTH: return depth_color(c->arrays.depth[i], low, high);
    case VIEW_NORMAL: return normal_color(c->arrays.normal[i]);
    case VIEW_ENTITY: return entity ? number_color(entity, 0) : SKY;
    case VIEW_TRIANGLE: return entity ? number_color(entity, c->arrays.triangle[i] + 1) : SKY;
    case VIEW_MOTION: return motion_color(c->arrays.motion[i]);
    case VIEW_COST: return cost_color(c->arrays.cost[i]);
    case VIEW_PICTURE:
    case VIEW_ALBEDO: break;
    }
    return SKY;
}

static void paint_channel(const pixel_channels *c, view_channel channel, daft_image *target)
{
    float low, high;
    uint8_t *pixels = daft_image_pixels(target);
    size_t count = (size_t)c->width * (size_t)c->height;
    depth_range(c, &low, &high);
    for (size_t i = 0; i < count; i++) {
        rgb color = channel_color(c, channel, i, low, high);
        pixels[4 * i] = color.r, pixels[4 * i + 1] = color.g, pixels[4 * i + 2] = color.b, pixels[4 * i + 3] = 255;
    }
}

/* ---- edges ---- */

static bool same_triangle(const pixel_channels *c, size_t a, size_t b)
{
    return c->arrays.entity[a].id == c->arrays.entity[b].id && c->arrays.triangle[a] == c->arrays.triangle[b];
}

/* A pixel lies on an edge where the next one to the right or below sees another triangle. */
static void paint_edges(const pixel_channels *c, daft_image *target)
{
    uint8_t *pixels = daft_image_pixels(target);
    for (int y = 0; y + 1 < c->height; y++) {
        for (int x = 0; x + 1 < c->width; x++) {
            size_t i = (size_t)y * (size_t)c->width + (size_t)x;
            if (same_triangle(c, i, i + 1) && same_triangle(c, i, i + (size_t)c->width)) continue;
            for (size_t k = 0; k < 3; k++) pixels[4 * i + k] = (uint8_t)(pixels[4 * i + k] / 4 + (k == 2 ? 40 : 16));
        }
    }
}

/* ---- scenes ---- */

void draw_set_view(const view_look *look, const daft_scene *scene, daft_view *view)
{
    view->camera = look->camera;
    view->quality = quality_choose(&look->quality, scene);
    view->without = look->channel == VIEW_ALBEDO ? DAFT_WITHOUT_SHADING : look->without & DAFT_WITHOUT_ALL;
    if (look->without & VIEW_WITHOUT_SHADOWS) view->quality.shadows = 0;
    if (look->without & VIEW_WITHOUT_MIRRORS) view->quality.mirror_depth = 0;
}

bool draw_scene(daft_scene *scene, const view_look *look, pixel_channels *channels, daft_image *target,
                daft_error *error)
{
    daft_view view = daft_default_view();
    bool shaded = look->channel == VIEW_PICTURE || look->channel == VIEW_ALBEDO, wanted = !shaded || look->wires;
    draw_set_view(look, scene, &view);
    if (wanted && !allocate(channels, daft_image_width(target), daft_image_height(target), error)) return false;
    if (wanted) view.aov = channels->arrays, view.quality.scale = 1;
    view.history = channels->history;
    if (!shaded && look->channel != VIEW_COST)
        view.quality = daft_preset_quality(DAFT_PRESET_DRAFT), view.without = DAFT_WITHOUT_SHADING; /* only channels are
                                                                                                       looked at */
    if (!daft_render(scene, &view, target, error)) return false;
    if (!shaded) paint_channel(channels, look->channel, target);
    if (look->wires) paint_edges(channels, target);
    return true;
}

/* ---- pictures ---- */

picture_place draw_fit(const daft_image *picture, int width, int height)
{
    double across = (double)width / daft_image_width(picture), down = (double)height / daft_image_height(picture);
    return (picture_place){fmin(1, fmin(across, down)), 0.5, 0.5};
}

/* Squares behind what is transparent. */
static uint8_t backdrop(int x, int y) { return (x / 12 + y / 12) % 2 ? 96 : 72; }

/* The mean of the picture's pixels from (x, y) on that fall on one of the window's. */
static void average(const daft_image *picture, double x, double y, double side, uint8_t under, uint8_t out[4])
{
    const uint8_t *pixels = daft_image_pixels((daft_image *)(uintptr_t)picture);
    int width = daft_image_width(picture), height = daft_image_height(picture);
    int x0 = (int)floor(x), y0 = (int)floor(y), x1 = (int)fmax(x0 + 1, ceil(x + side - 0.5));
    int y1 = (int)fmax(y0 + 1, ceil(y + side - 0.5)), sum[4] = {0}, count = 0;
    for (int row = y0; row < y1 && row < height; row++)
        for (int column = x0; column < x1 && column < width; column++, count++)
            for (size_t k = 0; k < 4; k++) sum[k] += pixels[4 * ((size_t)row * (size_t)width + (size_t)column) + k];
    int alpha = count ? sum[3] / count : 0;
    for (size_t k = 0; k < 3; k++)
        out[k] = (uint8_t)((count ? sum[k] / count : 0) * alpha / 255 + under * (255 - alpha) / 255);
    out[3] = 255;
}

void draw_picture(const daft_image *picture, const picture_place *place, daft_image *target)
{
    int width = daft_image_width(target), height = daft_image_height(target);
    double across = daft_image_width(picture), down = daft_image_height(picture), side = 1 / place->zoom;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            double u = place->x * across + (x - width / 2.0) * side, v = place->y * down + (y - height / 2.0) * side;
            uint8_t *out = daft_image_pixels(target) + 4 * ((size_t)y * (size_t)width + (size_t)x);
            out[0] = SKY.r, out[1] = SKY.g, out[2] = SKY.b, out[3] = 255;
            if (u >= 0 && v >= 0 && u < across && v < down) average(picture, u, v, side, backdrop(x, y), out);
        }
    }
}
