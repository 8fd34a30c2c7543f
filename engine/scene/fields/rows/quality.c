/* The knobs of a picture. Defaults are those of the preset game (test_fields holds the two together). */
#include "scene/fields/fields.h"

#define KNOB(m, ...)          DAFT_ROW(daft_quality, m, .lua = #m, .scene = #m, __VA_ARGS__)
#define CHOICE(m, names, ...) DAFT_CHOICE_ROW(daft_quality, m, names, .lua = #m, .scene = #m, __VA_ARGS__)
#define ONE_OF(list)          .values = (list), .value_count = DAFT_COUNT_OF(list)

static const char *const UPSCALES[] = {"bilinear", "bicubic", "nearest"};
static const char *const INTERSECTIONS[] = {"exact", "watertight", "fast"};
static const char *const TREES[] = {"raster", "bvh", "kdtree"};
static const char *const FILTERS[] = {"trilinear", "mipmap", "bilinear", "nearest", "anisotropic4", "anisotropic16"};
static const double SAMPLES[] = {1, 4, 8, 16};
static const double EDGE_SAMPLES[] = {0, 4, 16};

static const daft_field QUALITY_ROWS[] = {
    KNOB(scale, FROM(0.1, 1), .initial = {1}, .doc = "Sides of the drawn picture, relative to the shown one"),
    CHOICE(upscale, UPSCALES, .doc = "How a picture that is drawn smaller is enlarged"),
    CHOICE(visibility, INTERSECTIONS, .doc = "How rays and triangles meet"),
    CHOICE(tree, TREES, .doc = "What camera rays are found by; the picture is the same"),
    KNOB(samples, FROM(1, 16), ONE_OF(SAMPLES), .initial = {1}, .doc = "Samples of a pixel"),
    KNOB(edge_samples, FROM(0, 16), ONE_OF(EDGE_SAMPLES), .initial = {4},
         .doc = "More samples where neighbours differ: 4, the corners, at outlines and creases; 16 at edges of shadows "
                "and in mirrors, too, and trilinear textures become anisotropic4"),
    KNOB(edge_contrast, FROM(0.25, 4), .initial = {1},
         .doc = "Times the usual contrast from which pixels get these; below 1 fainter edges get some, and strong "
                "ones more of the 16"),
    KNOB(shadows, .initial = {1}, .doc = "Whether lights cast shadows"),
    KNOB(shadow_samples, FROM(0, 64), .initial = {1},
         .doc = "Rays of a point to each light that has a size or, of more than six, to those that are drawn "
                "for it; 0: shadows are sharp"),
    KNOB(occlusion_samples, FROM(0, 64), .initial = {1},
         .doc = "Rays around a point, where the scene has ambient occlusion; 0: none"),
    KNOB(mirror_depth, FROM(0, 32), .initial = {2}, .doc = "Mirror bounces followed"),
    KNOB(refraction_depth, FROM(0, 32), .initial = {12},
         .doc = "Surfaces that a path which passes through some may meet"),
    KNOB(min_weight, FROM(0, 1), .initial = {1.0 / 2048},
         .doc = "Mirrored and refracted rays that weigh less in all colours are not cast"),
    KNOB(glossy_samples, FROM(0, 64), .initial = {1}, .doc = "Rays that a rough surface sends on; 0: none is rough"),
    CHOICE(texture_filter, FILTERS, .doc = "What a texture's colour at a point is made of"),
    KNOB(denoise, .initial = {1}, .doc = "Whether what is sampled is filtered"),
    KNOB(half_light, .initial = {1},
         .doc = "Whether sampled shadows and occlusion that are filtered are found for one pixel in four"),
};

const daft_field_list daft_quality_fields = DAFT_FIELD_LIST(daft_quality, QUALITY_ROWS);
