#include "scene/fields/fields.h"

#define ROW(m, ...) DAFT_ROW(daft_character_def, m, __VA_ARGS__)

static const daft_field ROWS[] = {
    DAFT_COOKIE_ROW(daft_character_def),
    ROW(position, .unit = "m", .lua = "position", .doc = "Of the capsule's centre"),
    ROW(radius, .unit = "m", FROM((double)1e-3f, 1000), .initial = {0.3}, .lua = "radius", .doc = "Of the capsule"),
    ROW(height, .unit = "m", FROM((double)1e-3f, 10000), .initial = {1.8}, .lua = "height",
        .doc = "Of the capsule, from end to end; at least twice the radius"),
    ROW(step_height, .unit = "m", FROM(0, 5000), .initial = {0.35}, .lua = "step",
        .doc = "What it climbs without a jump; at most half its height"),
    ROW(max_slope, .unit = "rad", FROM(0, 1.5), .initial = {0.8727}, .lua = "slope",
        .doc = "From level; it slides down ground that is steeper"),
    ROW(acceleration, .unit = "m/s²", FROM(0, 1e6), .initial = {60}, .lua = "acceleration",
        .doc = "With which it takes up the speed it is asked for, on the ground"),
    ROW(air_acceleration, .unit = "m/s²", FROM(0, 1e6), .initial = {12}, .lua = "air_acceleration",
        .doc = "The same in the air"),
    ROW(gravity_scale, FROM(0, 1000), .initial = {1}, .lua = "gravity",
        .doc = "The fraction of gravity that acts on it"),
    ROW(mass, .unit = "kg", FROM(0, 1e9), .initial = {80}, .lua = "mass", .doc = "What weighs on what it stands on"),
    ROW(push_force, .unit = "N", FROM(0, 1e9), .initial = {400}, .lua = "force",
        .doc = "The most it pushes bodies with"),
    ROW(layers, .initial = {1}, .lua = "layer", .doc = "The layers that it is in"),
    ROW(mask, .initial = {UINT32_MAX}, .lua = "hits", .doc = "The layers that it meets"),
    ROW(entity, .lua = "entity",
        .doc = "One that goes where the character goes, or none; its own body is not in the way"),
};

const daft_field_list daft_character_fields = DAFT_FIELD_LIST(daft_character_def, ROWS);
