/* The opacity of a surface at one place, for rays that ask on their way. The same arithmetic, in the same order, as
 * texture_kernel.c's of the finest level and vary_kernel.c's of opacity; scalar, so one code serves every instruction
 * set. */
#include "shade/shade.h"

#include <math.h>

enum { MOST_TEXELS = 1 << 20 };

/* Beyond 2^23 there is no fraction. */
static float fraction(float a) { return fabsf(a) < 8388608.0f ? a - floorf(a) : 0; }

static float clamp(float a, float most) { return a > 0 ? a < most ? a : most : 0; }

static float wrapped(float a, uint32_t wrap)
{
    if (wrap == DAFT_WRAP_REPEAT) return fraction(a);
    if (wrap == DAFT_WRAP_CLAMP) return clamp(a, 1);
    const float half = fraction(a * 0.5f) * 2;
    return half > 1 ? 2 - half : half;
}

/* The two texels of an axis that a place lies between, and the weight of the second. */
typedef struct taps {
    int first, second;
    float weight;
} taps;

static taps taps_at(float at, int size, bool edges, bool nearest)
{
    float x = at * (float)size - 0.5f;
    if (edges) x = clamp(x, (float)(size - 1));
    const int below = (int)(x + 1) - 1; /* the floor: x is over -1 */
    const float weight = x - (float)below;
    return (taps){below < 0 ? size - 1 : below, below + 1 < size ? below + 1 : 0,
                  nearest ? (weight < 0.5f ? 0 : 1) : weight};
}

static float mix(float a, float b, float weight) { return a + (b - a) * weight; }

static float alpha_at(const daft_surface *m, const daft_texture_data *t, daft_vec2 uv, bool nearest)
{
    const float u = wrapped(uv.x * m->map_scale.x + m->map_offset.x, m->wrap),
                v = wrapped(uv.y * m->map_scale.y + m->map_offset.y, m->wrap);
    const bool edges = m->wrap != DAFT_WRAP_REPEAT;
    const taps x = taps_at(u, t->width[0], edges, nearest), y = taps_at(1 - v, t->height[0], edges, nearest);
    const uint8_t *texels = t->texels[0] + m->alpha_channel;
    float row[2];
    for (int k = 0; k < 2; k++) {
        const size_t begin = (size_t)(k ? y.second : y.first) * (size_t)t->width[0];
        row[k] = mix((float)texels[4 * (begin + (size_t)x.first)] * (1.0f / 255),
                     (float)texels[4 * (begin + (size_t)x.second)] * (1.0f / 255), x.weight);
    }
    return mix(row[0], row[1], y.weight);
}

/* The squared difference of a texel's alpha to those beside and below it, 0 where the outline is not between them. */
static float step2_at(const uint8_t *texel, size_t beside, size_t below, float cutoff)
{
    const float here = (float)*texel, right = (float)texel[beside], under = (float)texel[below];
    const bool inside = here >= cutoff;
    if ((right >= cutoff) == inside && (under >= cutoff) == inside) return 0;
    return (right - here) * (right - here) + (under - here) * (under - here);
}

float daft_mask_steepness(const daft_surface *m, const daft_texture_data *textures)
{
    const uint32_t map = m->maps[DAFT_MAP_ALPHA];
    if (!(m->cutoff > 0) || !(m->opacity > m->cutoff) || map == DAFT_NO_TEXTURE) return 0;
    const daft_texture_data *t = &textures[map];
    const size_t width = (size_t)t->width[0], height = (size_t)t->height[0];
    const size_t stride = 1 + width * height / MOST_TEXELS;
    const float cutoff = 255 * m->cutoff / m->opacity;
    double sum = 0;
    size_t count = 0;
    for (size_t y = 0; y + 1 < height; y += stride)
        for (size_t x = 0; x + 1 < width; x++) {
            const float step2 = step2_at(t->texels[0] + 4 * (y * width + x) + m->alpha_channel, 4, 4 * width, cutoff);
            if (step2 > 0) sum += (double)sqrtf(step2) / 255, count++;
        }
    const float texels = sqrtf((float)width * (float)height * fabsf(m->map_scale.x * m->map_scale.y));
    return count ? (float)(sum / (double)count) * texels : 0;
}

float daft_surface_opacity(const daft_surface *m, const daft_texture_data *textures, daft_vec2 uv, float own,
                           daft_texture_filter filter)
{
    const uint32_t map = m->maps[DAFT_MAP_ALPHA];
    const float alpha = map == DAFT_NO_TEXTURE ? 1 : alpha_at(m, &textures[map], uv, filter == DAFT_TEXTURE_NEAREST);
    const float opacity = clamp(alpha * own * m->opacity, 1);
    if (!(m->cutoff > 0)) return opacity;
    return opacity < m->cutoff ? 0 : 1;
}
