/* The quality presets, and the names of qualities, intersections and accelerators. */
#include "render/render.h"

/* Half a step of 8-bit sRGB is 1/3300 of white. */
static const daft_preset PRESETS[] = {
    [DAFT_QUALITY_DRAFT] = {.name = "draft", .samples = 1, .refraction_depth = 6, .min_weight = 1.0f / 256},
    [DAFT_QUALITY_GAME] = {.name = "game",
                           .samples = 1,
                           .edge_samples = 4,
                           .mirror_depth = 2,
                           .refraction_depth = 12,
                           .shadow_samples = 1,
                           .occlusion_samples = 1,
                           .glossy_samples = 1,
                           .min_weight = 1.0f / 2048,
                           .denoise = true,
                           .shadows = true},
    [DAFT_QUALITY_HIGH] = {.name = "high",
                           .samples = 4,
                           .mirror_depth = 6,
                           .refraction_depth = 16,
                           .shadow_samples = 4,
                           .occlusion_samples = 4,
                           .glossy_samples = 2,
                           .min_weight = 1.0f / 2048,
                           .denoise = true,
                           .shadows = true},
    [DAFT_QUALITY_REFERENCE] = {.name = "reference",
                                .samples = 16,
                                .mirror_depth = 10,
                                .refraction_depth = 24,
                                .shadow_samples = 16,
                                .occlusion_samples = 16,
                                .glossy_samples = 8,
                                .min_weight = 1.0f / 4096,
                                .shadows = true,
                                .reference = true},
};

const daft_preset *daft_quality_preset(daft_quality quality)
{
    return (unsigned)quality < DAFT_COUNT_OF(PRESETS) ? &PRESETS[quality] : NULL;
}
