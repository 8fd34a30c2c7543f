/* Maps of MTL files, as mtl.c reads them. */
#ifndef DAFT_MTL_MAP_H
#define DAFT_MTL_MAP_H

#include "geometry/mesh.h"
#include "geometry/formats/text.h"

/* What a map's options say. */
typedef struct daft_mtl_settings {
    daft_mtl_change change;
    daft_vec2 scale, offset;
    float bump;
    bool places, clamps; /* it has -s, -o or -clamp on */
    int side;            /* -type: of a cube, 1 to 6; -1: a type that is none; 0: a sphere's */
} daft_mtl_settings;

/* What -type says of them, by their numbers less 1. */
extern const char *const daft_mtl_cube_sides[6];

/* Reads what stands behind the keyword `word` of a map, from `p` to the end of the line: its options, and its file as a
 * path and a place in the text. False with an error at the place: an option lacks its value, or there is no file name
 * or one that cannot be; then `out` is as it was. `error` may be NULL. */
bool daft_mtl_map_read(daft_text *text, const daft_files *files, const char *word, const char *p,
                       daft_mtl_settings *settings, daft_mtl_map *out, daft_error *error);

#endif
