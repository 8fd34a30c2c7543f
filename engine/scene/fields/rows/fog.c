/* Fog: the same names in C, .scene files and Lua. */
#include "scene/fields/fields.h"

#define ROW(m, ...) DAFT_ROW(daft_fog, m, .lua = #m, __VA_ARGS__)

static const daft_field ROWS[] = {
    DAFT_COLOR_ROW(daft_fog, color, ZERO_OR_MORE, .initial = {0.7, 0.7, 0.7}, .lua = "color",
                   .doc = "Its own colour in linear light"),
    ROW(density, .unit = "1/m", FROM(0, 1e3), .doc = "At base: exp(-density * metres) is left of light; 0: no fog"),
    ROW(height, .unit = "m", FROM(0, 1e6), .scene = "height",
        .doc = "In which it thins to 1/e; 0: it is equally dense everywhere, and hides all of the sky"),
    ROW(base, .unit = "m", FROM(-1e6, 1e6), .scene = "base", .doc = "Height in the world at which it has its density"),
    ROW(glow, FROM(0, 1), .scene = "glow", .doc = "How much of the first sun's colour it has towards that"),
};

const daft_field_list daft_fog_fields = DAFT_FIELD_LIST(daft_fog, ROWS);
