/* How a clip is played. */
#include "scene/fields/fields.h"

#define ROW(m, ...) DAFT_ROW(daft_play_def, m, __VA_ARGS__)

static const daft_field ROWS[] = {
    DAFT_COOKIE_ROW(daft_play_def),
    ROW(clip, .doc = "Number of one of the mesh's clips"),
    ROW(speed, FROM(-1000, 1000), .initial = {1}, .lua = "speed",
        .doc = "1 plays it as it was made; below 0: backwards, from its end"),
    ROW(blend, .unit = "s", FROM(0, 1000), .lua = "blend",
        .doc = "In which the clip that plays passes over into it; 0, or where none plays: at once"),
    ROW(start, .unit = "s", FROM(0, 1e6), .lua = "start", .doc = "Into the clip, from the end where speed is below 0"),
    ROW(loop, .initial = {1}, .lua = "loop", .doc = "Begins anew at its end, or stays there"),
    ROW(restart, .lua = "restart", .doc = "A clip that plays already begins anew; else it goes on, with this speed"),
};

const daft_field_list daft_play_fields = DAFT_FIELD_LIST(daft_play_def, ROWS);
