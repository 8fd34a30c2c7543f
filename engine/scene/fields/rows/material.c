#include "scene/fields/fields.h"

#define ROW(m, ...)   DAFT_ROW(daft_material_def, m, __VA_ARGS__)
#define COLOR(m, ...) DAFT_COLOR_ROW(daft_material_def, m, __VA_ARGS__)

static const daft_field ROWS[] = {
    DAFT_COOKIE_ROW(daft_material_def),
    COLOR(ambient, ZERO_OR_MORE, .initial = {0.8, 0.8, 0.8}, .lua = "ambient", .flags = DAFT_FIELD_UNIFORM,
          .doc = "The fraction of the ambient light that it reflects (Ka)"),
    COLOR(diffuse, ZERO_OR_MORE, .initial = {0.8, 0.8, 0.8}, .lua = "color",
          .doc = "Lambert's reflection (Kd), times the texture"),
    COLOR(specular, ZERO_OR_MORE, .initial = {0.2, 0.2, 0.2}, .lua = "specular", .flags = DAFT_FIELD_UNIFORM,
          .doc = "Phong's highlight (Ks)"),
    ROW(shininess, FROM(0, 1000), .initial = {30}, .lua = "shininess",
        .doc = "Phong's exponent (Ns): higher is smaller"),
    ROW(mirror, FROM(0, 1), .lua = "mirror", .doc = "The weight of the mirrored ray's light"),
    COLOR(mirror_tint, ZERO_OR_MORE, .initial = {1, 1, 1}, .lua = "mirror_tint",
          .doc = "The mirrored light is multiplied by it"),
    ROW(roughness, FROM(0, 1), .lua = "roughness",
        .doc = "How rough it is where it mirrors or lets light through: 0 is smooth (Pr)"),
    COLOR(emission, ZERO_OR_MORE, .lua = "emission", .flags = DAFT_FIELD_UNIFORM,
          .doc = "Light that it gives off by itself; it lights nothing else"),
    ROW(transmission, FROM(0, 1), .lua = "transmission",
        .doc = "The fraction of the light that passes through; the rest is left to color and ambient"),
    COLOR(transmission_tint, FROM(0, 1), .initial = {1, 1, 1}, .lua = "transmission_tint",
          .doc = "The light that passes is multiplied by it at each surface"),
    ROW(refractive_index, FROM((double)0.001f, 10), .initial = {1.5}, .lua = "refractive_index",
        .doc = "How strongly light is bent, and so mirrored: water 1.33, glass 1.5, diamond 2.42; 1: not at all"),
    ROW(diffuse_map, .lua = "texture", .doc = "The image that diffuse is multiplied by"),
    ROW(map_scale, .initial = {1, 1}, .lua = "texture_scale", .flags = DAFT_FIELD_UNIFORM,
        .doc = "Repeats of the texture over one unit of u and of v; on boxes one unit is a metre"),
};

const daft_field_list daft_material_fields = DAFT_FIELD_LIST(daft_material_def, ROWS);
