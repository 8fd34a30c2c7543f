/* Temporal reuse: what the picture before found of sampled light is carried along (Schied and others, "Spatiotemporal
 * Variance-Guided Filtering", HPG 2017, section 4.1). Each pixel looks where the picture before saw its point: among
 * the four pixels around that place those count that saw the same instance as far away. Their mean becomes part of the
 * pixel's own, the more the longer it has been gathered; a point that was hidden or out of the picture begins anew. */
#include "render/denoise.h"

#include <math.h>

/* How far the inverse depth of the picture before may be off, as a part of it; and where a mirrored image moves along a
 * surface, too. */
#define SAME_PLACE   0.03f
#define SAME_SURFACE 0.1f

bool daft_past_prepare(daft_past *past, const daft_allocator *allocator, const daft_snapshot *s, const daft_grid *grid,
                       daft_error *error)
{
    const int step = grid->step, width = (s->width + step - 1) / step, height = (s->height + step - 1) / step;
    const size_t pixels = (size_t)width * (size_t)height;
    if (past->width != width || past->height != height || past->step != step) past->some = false;
    past->width = width, past->height = height, past->step = step;
    past->x[!past->now] = grid->x, past->y[!past->now] = grid->y;
    for (int i = 0; i < 2; i++)
        if (!daft_grow(allocator, &past->pixels[i], &past->capacity[i], pixels,
                       past->some && i == past->now ? pixels : 0, sizeof *past->pixels[i]))
            return daft_fail_memory(error, "the picture before");
    return true;
}

/* Where the picture before saw a point of an instance: column, row, and the inverse of the depth. */
typedef struct place {
    float x, y, inverse;
} place;

static bool place_before(const daft_snapshot *s, daft_vec3 ray, uint32_t instance, float inverse, place *out)
{
    const float depth = 1 / ((inverse > 0 ? inverse : 1) * s->focal);
    const daft_vec3 p = daft_add(daft_add(daft_scale(s->right, ray.x * depth), daft_scale(s->up, ray.y * depth)),
                                 daft_scale(s->forward, ray.z * depth));
    const daft_affine *before = &s->before[instance];
    const daft_vec3 then = inverse > 0 ? daft_affine_point(before, p) : daft_affine_vector(before, p);
    if (!(then.z > 0)) return false;
    out->inverse = 1 / then.z;
    out->x = then.x * out->inverse * s->before_focal + (float)s->width * 0.5f - 0.5f;
    out->y = (float)s->height * 0.5f - 0.5f - then.y * out->inverse * s->before_focal;
    return out->x > -1 && out->x < (float)s->width && out->y > -1 && out->y < (float)s->height;
}

/* The mean of the four pixels around, of those that saw the same; its weight. */
static float gather(const daft_past *past, const place *at, uint32_t entity, float slack, daft_past_pixel *mean)
{
    const daft_past_pixel *old = past->pixels[past->now];
    const float per_step = 1 / (float)past->step, column = (at->x - (float)past->x[past->now]) * per_step,
                row = (at->y - (float)past->y[past->now]) * per_step;
    const int x0 = (int)floorf(column), y0 = (int)floorf(row);
    const float fx = column - (float)x0, fy = row - (float)y0;
    float sum = 0;
    *mean = (daft_past_pixel){0};
    for (int k = 0; k < 4; k++) {
        const int x = x0 + (k & 1), y = y0 + (k >> 1);
        if (x < 0 || y < 0 || x >= past->width || y >= past->height) continue;
        const daft_past_pixel *p = &old[(size_t)y * (size_t)past->width + (size_t)x];
        const float weight = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy);
        if (p->entity != entity || !(fabsf(p->inverse - at->inverse) < slack * at->inverse)) continue;
        for (int c = 0; c < 3; c++) mean->ratio[c] += p->ratio[c] * weight;
        mean->length += p->length * weight, sum += weight;
    }
    return sum;
}

/* Where the picture before showed what the pixel shows, with the inverse depth of the surface that shows it. */
static bool place_shown(const daft_snapshot *s, const daft_seen_pixel *seen, place *out)
{
    place surface;
    if (!place_before(s, seen->ray, seen->instance, seen->inverse, &surface)) return false;
    *out = surface;
    if (seen->shown == seen->inverse) return true;
    if (!place_before(s, seen->ray, seen->instance, seen->shown, out)) return false;
    out->inverse = surface.inverse;
    return true;
}

float daft_past_pixel_reuse(daft_past *past, const daft_snapshot *s, const daft_seen_pixel *seen, float ratio[3])
{
    daft_past_pixel mean, *out = &past->pixels[!past->now][(size_t)seen->y * (size_t)past->width + (size_t)seen->x];
    place at;
    float length = 1;
    if (past->some && s->before && place_shown(s, seen, &at)) {
        const float slack = seen->shown == seen->inverse ? SAME_PLACE : SAME_SURFACE;
        const float weight = gather(past, &at, s->instances[seen->instance].entity, slack, &mean);
        if (weight > 0.01f) {
            length = fminf(mean.length / weight + 1, (float)DAFT_LONGEST_PAST);
            for (int c = 0; c < 3; c++)
                ratio[c] = mean.ratio[c] / weight + (ratio[c] - mean.ratio[c] / weight) / length;
        }
    }
    *out =
        (daft_past_pixel){{ratio[0], ratio[1], ratio[2]}, seen->inverse, length, s->instances[seen->instance].entity};
    return length;
}

void daft_past_pixel_clear(daft_past *past, int x, int y)
{
    past->pixels[!past->now][(size_t)y * (size_t)past->width + (size_t)x] = (daft_past_pixel){0};
}

void daft_past_turn(daft_past *past) { past->now = !past->now, past->some = true; }

void daft_past_free(daft_past *past, const daft_allocator *allocator)
{
    for (int i = 0; i < 2; i++) daft_release(allocator, past->pixels[i]);
    *past = (daft_past){0};
}
