/* Batches and materials in lanes: what the kernel sources of shade share. */
#ifndef DAFT_BATCH_LANES_H
#define DAFT_BATCH_LANES_H

#include "math/simd/dispatch.h"
#include "math/simd/elementary.h"
#include "shade/material_lanes.h"

bool DAFT_KERNEL(daft_albedo)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                              daft_texture_filter filter);
/* What a map of the materials says at the DAFT_VL points from i on, as linear light or as bytes, 0..1, and then alpha,
 * too; points without one keep what is there. And the slopes of heights, per texel. */
void DAFT_KERNEL(daft_map_color)(const daft_batch *batch, const daft_surface *materials,
                                 const daft_texture_data *textures, daft_texture_filter filter, uint32_t map,
                                 bool linear, uint32_t i, vf3 *color, vf *alpha);
/* What the reflection map shows in unit directions; points without one keep what is there. */
void DAFT_KERNEL(daft_map_around)(const daft_batch *batch, const daft_surface *materials,
                                  const daft_texture_data *textures, daft_texture_filter filter, uint32_t i,
                                  vf3 direction, vf3 *color);
void DAFT_KERNEL(daft_map_slopes)(const daft_batch *batch, const daft_surface *materials,
                                  const daft_texture_data *textures, daft_texture_filter filter, uint32_t i,
                                  vf *along_u, vf *along_v);
/* The same of anisotropic filters, which these pass on (along_kernel.c). */
bool DAFT_KERNEL(daft_albedo_along)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                                    daft_texture_filter filter);
void DAFT_KERNEL(daft_map_color_along)(const daft_batch *batch, const daft_surface *materials,
                                       const daft_texture_data *textures, daft_texture_filter filter, uint32_t map,
                                       bool linear, uint32_t i, vf3 *color, vf *alpha);
void DAFT_KERNEL(daft_map_slopes_along)(const daft_batch *batch, const daft_surface *materials,
                                        const daft_texture_data *textures, daft_texture_filter filter, uint32_t i,
                                        vf *along_u, vf *along_v);
void DAFT_KERNEL(daft_vary)(daft_batch *batch, const daft_surface *materials, const daft_texture_data *textures,
                            daft_texture_filter filter, const daft_vary_def *def);
/* Of an area light, at the DAFT_VL points from i on: its form factor; and the fraction of a lobe around the mirrored
 * view that it fills, a cosine lobe stretched to this width, squared. */
void DAFT_KERNEL(daft_area_form)(const daft_batch *batch, uint32_t i, const daft_light_source *source, vf *form);
void DAFT_KERNEL(daft_area_gleam)(const daft_batch *batch, uint32_t i, const daft_light_source *source,
                                  const vf *width2, vf *form);
void DAFT_KERNEL(daft_sky_color)(const daft_sky *sky, const daft_lanes3 *direction, uint32_t count, daft_lanes3 *color);
void DAFT_KERNEL(daft_fog_way)(const daft_air *air, const daft_lanes3 *origin, const daft_lanes3 *direction,
                               const float *length, uint32_t first, uint32_t count, float *through, daft_lanes3 *own);
void DAFT_KERNEL(daft_fade)(daft_lanes3 *light, uint32_t first, uint32_t count, const daft_lanes3 *loss);
void DAFT_KERNEL(daft_tone_light)(const daft_tone *tone, const float *const light[3], uint32_t count,
                                  float *const out[3]);
void DAFT_KERNEL(daft_encode)(const float *r, const float *g, const float *b, uint32_t count, uint8_t *rgba);
void DAFT_KERNEL(daft_decode)(const uint8_t *rgba, uint32_t count, float *r, float *g, float *b);

DAFT_INLINE vf3 lanes_load(const daft_lanes3 *a, uint32_t i)
{
    return (vf3){vf_load(&a->x[i]), vf_load(&a->y[i]), vf_load(&a->z[i])};
}
DAFT_INLINE void lanes_store(daft_lanes3 *a, uint32_t i, vf3 v)
{
    vf_store(&a->x[i], v.x), vf_store(&a->y[i], v.y), vf_store(&a->z[i], v.z);
}

/* a times the points' albedo: 1 unless some point of the batch has a texture or a colour of its own. */
DAFT_INLINE vf3 times_albedo(const daft_batch *batch, uint32_t i, vf3 a)
{
    if (!(batch->traits & (DAFT_TRAIT_TEXTURE | DAFT_TRAIT_COLORS))) return a;
    vf3 albedo = lanes_load(&batch->albedo, i);
    return (vf3){a.x * albedo.x, a.y * albedo.y, a.z * albedo.z};
}

/* The bits of DAFT_VL points from point i on; i is a multiple of DAFT_VL. */
DAFT_INLINE vbits bits_at(const uint32_t *bits, uint32_t i) { return bits[i / 32] >> (i % 32) & DAFT_ALL_LANES; }

#endif
