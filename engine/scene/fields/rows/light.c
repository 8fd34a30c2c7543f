#include "scene/fields/fields.h"

#define ROW(m, ...) DAFT_ROW(daft_light_def, m, __VA_ARGS__)

static const char *const KINDS[] = {"point", "sun", "spot", "rectangle"};
enum {
    POINT = 1 << DAFT_LIGHT_POINT,
    SUN = 1 << DAFT_LIGHT_SUN,
    SPOT = 1 << DAFT_LIGHT_SPOT,
    RECTANGLE = 1 << DAFT_LIGHT_RECTANGLE
};

static const daft_field ROWS[] = {
    DAFT_COOKIE_ROW(daft_light_def),
    DAFT_CHOICE_ROW(
        daft_light_def, kind, KINDS, .flags = DAFT_FIELD_HASHED,
        .doc = "A point, the sun, a spot: a point light that shines into a cone, or a rectangle that shines to one "
               "side"),
    ROW(position, .unit = "m", .kinds = POINT | SPOT | RECTANGLE, .lua = "position", .flags = DAFT_FIELD_HASHED,
        .doc = "Where it is; the middle of a rectangle"),
    DAFT_DIRECTION_ROW(daft_light_def, direction, .initial = {0, -1, 0}, .kinds = SUN | SPOT | RECTANGLE,
                       .lua = "direction", .flags = DAFT_FIELD_HASHED,
                       .doc =
                           "Where its light travels to: a spot's axis, straight off a rectangle; any length but zero"),
    DAFT_COLOR_ROW(daft_light_def, color, ZERO_OR_MORE, .initial = {1, 1, 1}, .lua = "color",
                   .flags = DAFT_FIELD_HASHED,
                   .doc = "Its colour in linear light; values over 1 are brighter; a rectangle's radiance"),
    ROW(casts_shadow, .initial = {true}, .lua = "shadow", .scene = "shadow", .flags = DAFT_FIELD_HASHED,
        .doc = "Whether entities cast shadows in it"),
    ROW(inner_angle, .unit = "rad", FROM(0, DAFT_PI_FLOAT), .initial = {DAFT_PI / 8}, .kinds = SPOT, .lua = "inner",
        .flags = DAFT_FIELD_HASHED_USED,
        .doc = "All of its light is within this angle of the direction; at most outer_angle"),
    ROW(outer_angle, .unit = "rad", FROM(DAFT_ABOVE_ZERO, DAFT_PI_FLOAT), .initial = {DAFT_PI / 6}, .kinds = SPOT,
        .lua = "angle", .flags = DAFT_FIELD_HASHED_USED,
        .doc = "None of its light is beyond this angle of the direction"),
    ROW(radius, .unit = "m", FROM(0, 1e6), .kinds = POINT | SPOT, .lua = "radius", .scene = "radius",
        .doc = "Of the ball that glows, for soft shadows; 0: a point, whose shadows are sharp"),
    ROW(disc, .unit = "rad", FROM(0, DAFT_PI_FLOAT / 4), .kinds = SUN, .lua = "disc", .scene = "disc",
        .doc = "Half the angle that its disc spans, for soft shadows; 0: they are sharp"),
    ROW(range, .unit = "m", FROM(0, 1e6), .kinds = POINT | SPOT | RECTANGLE, .lua = "range", .scene = "range",
        .doc =
            "Where its light ends, having faded all the way; 0: nowhere; points and spots are then equally bright at "
            "any distance"),
    ROW(inverse_square, .kinds = POINT | SPOT, .lua = "inverse_square", .scene = "inverse_square",
        .doc = "Its light falls with the square of the distance: its colour is what it has at a metre"),
    ROW(visible, .kinds = SUN, .lua = "visible", .scene = "visible",
        .doc = "Whether its disc is seen in the sky, of 16 times its colour at most"),
    ROW(size, .unit = "m", FROM((double)1e-6f, 1e6), .initial = {1, 1}, .kinds = RECTANGLE, .lua = "size",
        .doc = "Of a rectangle: the level side, and the other"),
    ROW(turn, .unit = "rad", DAFT_ANGLES, .kinds = RECTANGLE, .lua = "turn", .scene = "turn",
        .doc = "How far a rectangle is turned about its direction, from the level side to the other"),
};

const daft_field_list daft_light_fields = DAFT_FIELD_LIST(daft_light_def, ROWS);
