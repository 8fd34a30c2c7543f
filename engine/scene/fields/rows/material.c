#include "scene/fields/fields.h"

#define ROW(m, ...)   DAFT_ROW(daft_material_def, m, __VA_ARGS__)
#define COLOR(m, ...) DAFT_COLOR_ROW(daft_material_def, m, __VA_ARGS__)

#define CHOICE(m, names, ...) DAFT_CHOICE_ROW(daft_material_def, m, names, __VA_ARGS__)

static const char *const SHADINGS[] = {"phong", "physical"};
static const char *const ALPHA_MODES[] = {"opaque", "mask", "blend"};
static const char *const WRAPS[] = {"repeat", "clamp", "mirror"};

static const daft_field ROWS[] = {
    DAFT_COOKIE_ROW(daft_material_def),
    COLOR(ambient, ZERO_OR_MORE, .initial = {0.8, 0.8, 0.8}, .lua = "ambient", .scene = "ambient",
          .flags = DAFT_FIELD_UNIFORM, .doc = "The fraction of the ambient light that it reflects (Ka)"),
    COLOR(diffuse, ZERO_OR_MORE, .initial = {0.8, 0.8, 0.8}, .lua = "color", .scene = "color",
          .doc = "Lambert's reflection (Kd), times the texture"),
    COLOR(specular, ZERO_OR_MORE, .initial = {0.2, 0.2, 0.2}, .lua = "specular", .scene = "specular",
          .flags = DAFT_FIELD_UNIFORM, .doc = "Phong's highlight (Ks)"),
    ROW(shininess, FROM(0, 1000), .initial = {30}, .lua = "shininess", .scene = "shininess",
        .doc = "Phong's exponent (Ns): higher is smaller"),
    ROW(mirror, FROM(0, 1), .lua = "mirror", .scene = "mirror", .doc = "The weight of the mirrored ray's light"),
    COLOR(mirror_tint, ZERO_OR_MORE, .initial = {1, 1, 1}, .lua = "mirror_tint", .scene = "mirror_tint",
          .doc = "The mirrored light is multiplied by it"),
    ROW(roughness, FROM(0, 1), .lua = "roughness", .scene = "roughness",
        .doc = "How rough it is where it mirrors or lets light through: 0 is smooth (Pr)"),
    COLOR(emission, ZERO_OR_MORE, .lua = "emission", .scene = "emission", .flags = DAFT_FIELD_UNIFORM,
          .doc = "Light that it gives off by itself; it lights nothing else but from entities with lights"),
    ROW(transmission, FROM(0, 1), .lua = "transmission", .scene = "transmission",
        .doc = "The fraction of the light that passes through; the rest is left to color and ambient"),
    COLOR(transmission_tint, FROM(0, 1), .initial = {1, 1, 1}, .lua = "transmission_tint", .scene = "transmission_tint",
          .doc = "The light that passes is multiplied by it at each surface; with a tint_distance, along its way"),
    ROW(tint_distance, ZERO_OR_MORE, .unit = "m", .lua = "tint_distance", .scene = "tint_distance",
        .doc = "The length in which light within the body takes on transmission_tint: twice as far, the square of it; "
               "0: each surface tints"),
    ROW(medium_priority, FROM(0, 255), .lua = "medium_priority", .scene = "medium_priority",
        .doc = "Where bodies that let light through overlap, the one with the higher number is there alone, so that "
               "wine touches glass; 0: what lies around it counts as air"),
    ROW(refractive_index, FROM((double)0.001f, 10), .initial = {1.5}, .lua = "refractive_index",
        .scene = "refractive_index",
        .doc = "How strongly light is bent, and so mirrored: water 1.33, glass 1.5, diamond 2.42; 1: not at all"),
    ROW(diffuse_map, .lua = "texture", .scene = "texture", .doc = "The image that diffuse is multiplied by"),
    ROW(map_scale, .initial = {1, 1}, .lua = "texture_scale", .scene = "texture_scale", .flags = DAFT_FIELD_UNIFORM,
        .doc = "Repeats of the texture over one unit of u and of v; on boxes one unit is a metre"),
    ROW(map_offset, .lua = "texture_offset", .scene = "texture_offset", .doc = "Added to u and v once they are scaled"),
    CHOICE(map_wrap, WRAPS, .lua = "texture_wrap", .scene = "texture_wrap",
           .doc = "What lies beyond the textures' edges"),
    CHOICE(shading, SHADINGS, .lua = "shading", .scene = "shading",
           .doc = "By Lambert and Phong, or physically: color is the base colour, of which metallic and roughness say "
                  "the rest, as in glTF"),
    ROW(metallic, FROM(0, 1), .lua = "metallic", .scene = "metallic",
        .doc = "How much of it is metal; physical shading alone"),
    ROW(ambient_map, .lua = "ambient_texture", .scene = "ambient_texture",
        .doc = "The image that ambient is multiplied by; none: texture"),
    ROW(specular_map, .lua = "specular_texture", .scene = "specular_texture",
        .doc = "The image that specular and mirror are multiplied by"),
    ROW(emission_map, .lua = "emission_texture", .scene = "emission_texture",
        .doc = "The image that emission is multiplied by"),
    ROW(shininess_map, .lua = "shininess_texture", .scene = "shininess_texture",
        .doc = "The image whose green shininess is multiplied by"),
    ROW(roughness_map, .lua = "roughness_texture", .scene = "roughness_texture",
        .doc = "The image whose green roughness is multiplied by"),
    ROW(metallic_map, .lua = "metallic_texture", .scene = "metallic_texture",
        .doc = "The image whose blue metallic is multiplied by"),
    ROW(normal_map, .lua = "normal_texture", .scene = "normal_texture",
        .doc = "Normals in tangent space: red along u, green along v, blue outwards"),
    ROW(normal_strength, FROM(-100, 100), .initial = {1}, .lua = "normal_strength", .scene = "normal_strength",
        .doc = "Its slopes are multiplied by it"),
    ROW(bump_map, .lua = "bump_texture", .scene = "bump_texture", .doc = "Heights, in green"),
    ROW(bump_strength, FROM(-1000, 1000), .initial = {1}, .lua = "bump_strength", .scene = "bump_strength",
        .doc = "The slope between a black texel and a white one beside it"),
    ROW(occlusion_map, .lua = "occlusion_texture", .scene = "occlusion_texture",
        .doc = "By the image's red the ambient light is multiplied, as in glTF; other lights are not"),
    ROW(occlusion_strength, FROM(0, 1), .initial = {1}, .lua = "occlusion_strength", .scene = "occlusion_strength",
        .doc = "How much of the light that it keeps away is kept away"),
    CHOICE(alpha_mode, ALPHA_MODES, .lua = "alpha", .scene = "alpha",
           .doc = "mask: a hole where alpha is below alpha_cutoff; blend: what lies behind shows as much as alpha is "
                  "below 1"),
    ROW(opacity, FROM(0, 1), .initial = {1}, .lua = "opacity", .scene = "opacity",
        .doc = "What alpha is multiplied by"),
    ROW(alpha_cutoff, FROM(0, 1), .initial = {0.5}, .lua = "alpha_cutoff", .scene = "alpha_cutoff",
        .doc = "Where a mask has holes"),
    ROW(alpha_map, .lua = "alpha_texture", .scene = "alpha_texture",
        .doc = "Its alpha or, where it has none, its green is the alpha; none: the alpha of texture"),
    ROW(reflection_map, .lua = "reflection_texture", .scene = "reflection_texture",
        .doc = "What it mirrors in place of its surroundings: an image all around, as of a sky; phong shading alone"),
};

const daft_field_list daft_material_fields = DAFT_FIELD_LIST(daft_material_def, ROWS);
