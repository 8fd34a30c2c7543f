/* What the files that find inner balls share: caps.c closes the mesh, inside.c finds the cells of a grid that are inside,
 * inner.c chooses balls. */
#ifndef DAFT_FIND_INNER_H
#define DAFT_FIND_INNER_H

#include "accel/inner.h"

enum { DAFT_GRID = 64 }; /* cells along an axis, at most */

typedef struct daft_inner_search {
    const daft_allocator *allocator;
    const daft_trimesh *mesh;
    const daft_bvh *bvh;
    double pad; /* that balls keep clear of triangles by */
    daft_inner *out;
    /* the grid: cell (i, j, k) has the number (k·size[1] + j)·size[0] + i */
    uint32_t size[3], cell_count;
    double low[3], cell;
    uint16_t *depth; /* of each cell: 0, not inside; or how far inside, in thirds of a cell, about */
} daft_inner_search;

/* Puts the mesh's holes under caps. False: there are too many, or memory is out. */
bool daft_inner_close(daft_inner_search *search);
/* Fills the grid. False: no cell is inside, or memory is out. */
bool daft_inner_fill(daft_inner_search *search);

void daft_inner_drop(daft_bvh *bvh);

static inline daft_dvec3 daft_cell_middle(const daft_inner_search *s, uint32_t cell)
{
    uint32_t i = cell % s->size[0], j = cell / s->size[0] % s->size[1], k = cell / s->size[0] / s->size[1];
    return daft_dv3(s->low[0] + (i + 0.5) * s->cell, s->low[1] + (j + 0.5) * s->cell, s->low[2] + (k + 0.5) * s->cell);
}

#endif
