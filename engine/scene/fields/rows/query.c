/* What queries of bodies are asked with. */
#include "scene/fields/fields.h"

#define FILTER(m, ...) DAFT_ROW(daft_query_filter, m, __VA_ARGS__)
#define VOLUME(m, ...) DAFT_ROW(daft_volume, m, __VA_ARGS__)

static const daft_field FILTER_ROWS[] = {
    DAFT_COOKIE_ROW(daft_query_filter),
    FILTER(statics, .initial = {true}, .lua = "static", .doc = "Whether static bodies are met"),
    FILTER(kinematics, .initial = {true}, .lua = "kinematic", .doc = "Whether kinematic bodies are met"),
    FILTER(dynamics, .initial = {true}, .lua = "dynamic", .doc = "Whether dynamic bodies are met"),
    FILTER(sensors, .lua = "sensors", .doc = "Whether sensors are met as well"),
    FILTER(layers, .initial = {UINT32_MAX}, .lua = "layer", .doc = "The layers that the query is in"),
    FILTER(mask, .initial = {UINT32_MAX}, .lua = "hits", .doc = "The layers that it meets, as between two bodies"),
    FILTER(ignore, .lua = "ignore", .doc = "An entity that it passes through, or none"),
};

const daft_field_list daft_query_filter_fields = DAFT_FIELD_LIST(daft_query_filter, FILTER_ROWS);

static const daft_field VOLUME_ROWS[] = {
    DAFT_COOKIE_ROW(daft_volume),
    VOLUME(size, .unit = "m", .initial = {1, 1, 1}, .lua = "box",
           .doc = "The edge lengths of a box, where the radius is 0"),
    VOLUME(radius, .unit = "m", .lua = "sphere", .doc = "Of a sphere, or of a capsule where there is a height too"),
    VOLUME(height, .unit = "m", .doc = "Of a capsule along y, from end to end"),
    VOLUME(rotation, .initial = {0, 0, 0, 1}, .lua = "rotation", .doc = "How it is turned"),
};

const daft_field_list daft_volume_fields = DAFT_FIELD_LIST(daft_volume, VOLUME_ROWS);
