/* The table of knobs. */
#include "accuracy/knobs.h"

#include "common/quality.h"
#include "common/util.h"

#include <string.h>

static const knob_row TABLE[KNOBS] = {
    {"scale",
     "sides of the drawn picture, relative to the shown one, and how it is enlarged",
     {"scale=0.5,upscale=bilinear", "scale=0.5,upscale=bicubic", "scale=0.75,upscale=nearest",
      "scale=0.75,upscale=bilinear", "scale=0.75,upscale=bicubic", "scale=1"}},
    {"visibility", "how rays and triangles meet", {"visibility=fast", "visibility=watertight", "visibility=exact"}},
    {"tree", "what camera rays are found by; the picture is the same", {"tree=raster", "tree=bvh", "tree=kdtree"}},
    {"antialiasing",
     "samples of each pixel, or more only where neighbours differ, by much or by less",
     {"samples=1,edge_samples=0", "samples=1,edge_samples=4", "samples=1,edge_samples=16,edge_contrast=2",
      "samples=1,edge_samples=16,edge_contrast=1", "samples=1,edge_samples=16,edge_contrast=0.5",
      "samples=4,edge_samples=0", "samples=8,edge_samples=0", "samples=16,edge_samples=0"}},
    {"shadows", "whether lights cast any", {"shadows=off", "shadows=on"}},
    {"shadow_samples",
     "rays to a light that has a size; 0: sharp shadows",
     {"shadow_samples=0", "shadow_samples=1", "shadow_samples=4", "shadow_samples=16"}},
    {"occlusion_samples",
     "rays around a point, where the scene has ambient occlusion",
     {"occlusion_samples=0", "occlusion_samples=1", "occlusion_samples=4", "occlusion_samples=16"}},
    {"glossy_samples",
     "rays that a rough surface sends on; 0: none is rough",
     {"glossy_samples=0", "glossy_samples=1", "glossy_samples=4", "glossy_samples=16"}},
    {"mirror_depth",
     "mirror bounces followed",
     {"mirror_depth=0", "mirror_depth=1", "mirror_depth=2", "mirror_depth=4", "mirror_depth=8"}},
    {"refraction_depth",
     "surfaces that a path through transparent ones may meet",
     {"refraction_depth=0", "refraction_depth=2", "refraction_depth=6", "refraction_depth=12", "refraction_depth=24"}},
    {"min_weight",
     "mirrored and refracted rays below it are not cast",
     {"min_weight=1/16", "min_weight=1/64", "min_weight=1/256", "min_weight=1/2048"}},
    {"texture_filter",
     "what a texture's colour is made of",
     {"texture_filter=nearest", "texture_filter=bilinear", "texture_filter=mipmap", "texture_filter=trilinear",
      "texture_filter=anisotropic4", "texture_filter=anisotropic16"}},
    {"denoise", "whether what is sampled is filtered", {"denoise=off", "denoise=on"}},
    {"half_light", "sampled shadows and occlusion for one pixel in four", {"half_light=on", "half_light=off"}},
};

const knob_row *knob_at(size_t index) { return &TABLE[index]; }

const knob_row *knob_named(const char *name)
{
    for (size_t k = 0; k < KNOBS; k++)
        if (strcmp(TABLE[k].name, name) == 0) return &TABLE[k];
    return NULL;
}

size_t knob_count(const knob_row *knob)
{
    size_t count = 0;
    while (count < KNOB_SETTINGS && knob->settings[count]) count++;
    return count;
}

bool knob_own(char *text, knob_row *out, daft_error *error)
{
    size_t count = 0;
    *out = (knob_row){.name = "own", .doc = "the settings that were asked for"};
    for (char *at = text, *end; at; at = end) {
        daft_quality quality = daft_preset_quality(DAFT_PRESET_GAME);
        end = strchr(at, ';');
        if (end) *end++ = 0;
        if (count == KNOB_SETTINGS) return fail(error, DAFT_ERROR_ARGUMENT, "at most %d settings", KNOB_SETTINGS);
        if (!*at) return fail(error, DAFT_ERROR_ARGUMENT, "a setting is empty");
        if (!quality_parse(at, &quality, error)) return false;
        out->settings[count++] = at;
    }
    return true;
}

bool knob_is_by_rays(const char *setting) { return strstr(setting, "tree=bvh") || strstr(setting, "tree=kdtree"); }
