/* The presets: how much work a picture may be. Each row is a whole daft_quality; what is not named is 0: rasterized,
 * exact, trilinear, bilinear. Nothing else in the engine switches on a preset's name. */
#include "render/render.h"

/* Half a step of 8-bit sRGB is 1/3300 of white. */
static const daft_quality PRESETS[] = {
    [DAFT_PRESET_DRAFT] =
        {.scale = 1, .samples = 1, .edge_contrast = 1, .refraction_depth = 6, .min_weight = 1.0f / 256},
    [DAFT_PRESET_GAME] = {.scale = 1,
                          .samples = 1,
                          .edge_samples = 4,
                          .edge_contrast = 1,
                          .shadows = true,
                          .shadow_samples = 1,
                          .occlusion_samples = 1,
                          .mirror_depth = 2,
                          .refraction_depth = 12,
                          .min_weight = 1.0f / 2048,
                          .glossy_samples = 1,
                          .denoise = true,
                          .half_light = true},
    [DAFT_PRESET_HIGH] = {.scale = 1,
                          .samples = 1,
                          .edge_samples = 16,
                          .edge_contrast = 0.5f,
                          .shadows = true,
                          .shadow_samples = 8,
                          .occlusion_samples = 8,
                          .mirror_depth = 6,
                          .refraction_depth = 16,
                          .min_weight = 1.0f / 2048,
                          .glossy_samples = 4,
                          .texture_filter = DAFT_TEXTURE_ANISOTROPIC4,
                          .denoise = true},
    [DAFT_PRESET_REFERENCE] = {.scale = 1,
                               .tree = DAFT_TREE_BVH,
                               .samples = 16,
                               .edge_contrast = 1,
                               .shadows = true,
                               .shadow_samples = 16,
                               .occlusion_samples = 16,
                               .mirror_depth = 10,
                               .refraction_depth = 24,
                               .min_weight = 1.0f / 4096,
                               .glossy_samples = 8,
                               .texture_filter = DAFT_TEXTURE_ANISOTROPIC16},
};

daft_quality daft_preset_quality(daft_preset preset)
{
    return PRESETS[(unsigned)preset < DAFT_COUNT_OF(PRESETS) ? preset : DAFT_PRESET_GAME];
}
