/* Texture sampling: trilinear, repeating, filtered in linear light. The mip level is the log2 of the footprint's side
 * in texels (Williams, "Pyramidal Parametrics", 1983). Coordinates and levels are computed in lanes, texels are fetched
 * point by point. */
#include "shade/batch_lanes.h"

#include "shade/srgb_table.h"

/* Repeats i of -1..size. */
DAFT_INLINE int wrap(int i, int size) { return i < 0 ? size - 1 : i < size ? i : 0; }

/* Floor, for x > -1. */
DAFT_INLINE int floor_small(float x) { return (int)(x + 1) - 1; }

/* u, v in 0..1. The top row has v = 1. */
static void bilinear(const daft_texture_data *t, int level, float u, float v, float weight, float color[3])
{
    int width = t->width[level], height = t->height[level];
    float x = u * (float)width - 0.5f, y = (1 - v) * (float)height - 0.5f;
    int x0 = floor_small(x), y0 = floor_small(y);
    float fx = x - (float)x0, fy = y - (float)y0;
    int xa = wrap(x0, width), xb = wrap(x0 + 1, width);
    const uint8_t *above = t->texels[level] + 4 * (size_t)wrap(y0, height) * (size_t)width;
    const uint8_t *below = t->texels[level] + 4 * (size_t)wrap(y0 + 1, height) * (size_t)width;
    for (int k = 0; k < 3; k++) {
        float a = SRGB_TO_LINEAR[above[4 * xa + k]], b = SRGB_TO_LINEAR[above[4 * xb + k]];
        float c = SRGB_TO_LINEAR[below[4 * xa + k]], d = SRGB_TO_LINEAR[below[4 * xb + k]];
        float top = a + (b - a) * fx, bottom = c + (d - c) * fx;
        color[k] += weight * (top + (bottom - top) * fy);
    }
}

static void sample(const daft_texture_data *t, float u, float v, float level, float color[3])
{
    color[0] = color[1] = color[2] = 0;
    float last = (float)(t->levels - 1);
    level = level > 0 ? (level < last ? level : last) : 0;
    int fine = (int)level;
    /* Two levels blend in the middle half of the interval between them; in the outer quarters one level serves, which
     * halves the fetches and is not seen. */
    float blend = (level - (float)fine) * 2 - 0.5f;
    if (blend >= 1) fine++, blend = 0;
    bilinear(t, fine, u, v, blend > 0 ? 1 - blend : 1, color);
    if (blend > 0) bilinear(t, fine + 1, u, v, blend, color);
}

DAFT_INLINE vf fraction(vf a)
{
    vf bounded = vf_if_then_else(vf_lt(vf_abs(a), vf_set(8388608.0f)), a, vf_set(0)); /* beyond 2^23 there is no
                                                                                         fraction */
    return bounded - vf_floor(bounded);
}

/* The side of each point's texture in texels, 0 without a texture. False: no point has one. */
static bool texture_sizes(const daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                          uint32_t i, uint32_t used, float size[DAFT_VL])
{
    bool any = false;
    for (uint32_t k = 0; k < DAFT_VL; k++) {
        uint32_t texture = k < used ? materials[batch->material[i + k]].texture : DAFT_NO_TEXTURE;
        size[k] = 0;
        if (texture == DAFT_NO_TEXTURE) continue;
        size[k] = sqrtf((float)textures[texture].width[0] * (float)textures[texture].height[0]);
        any = true;
    }
    return any;
}

static bool sample_lanes(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                         uint32_t i, uint32_t used)
{
    float size[DAFT_VL], u[DAFT_VL], v[DAFT_VL], level[DAFT_VL];
    if (!texture_sizes(batch, materials, textures, i, used, size)) return false;
    material_reader m = read_materials(batch, materials, i);
    vf su = MATERIAL_WORD(&m, map_scale.x), sv = MATERIAL_WORD(&m, map_scale.y);
    vf texels = vf_load(&batch->footprint[i]) * vf_sqrt(vf_abs(su * sv)) * vf_load(size);
    vf_store(u, fraction(vf_load(&batch->u[i]) * su));
    vf_store(v, fraction(vf_load(&batch->v[i]) * sv));
    vf_store(level, vf_log2(vf_max(texels, vf_set(1e-20f))));
    for (uint32_t k = 0; k < used; k++) {
        if (size[k] == 0) continue;
        float color[3];
        sample(&textures[materials[batch->material[i + k]].texture], u[k], v[k], level[k], color);
        batch->albedo.x[i + k] = color[0], batch->albedo.y[i + k] = color[1], batch->albedo.z[i + k] = color[2];
    }
    return true;
}

bool DAFT_KERNEL(daft_albedo)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures)
{
    bool any = false;
    vf one = vf_set(1);
    for (uint32_t i = 0; i < batch->count; i += DAFT_VL) {
        uint32_t left = batch->count - i, used = left < DAFT_VL ? left : DAFT_VL;
        lanes_store(&batch->albedo, i, (vf3){one, one, one});
        any |= sample_lanes(batch, materials, textures, i, used);
    }
    return any;
}
