/* Boxes of a tree's nodes, seen from a pencil's apex; for both sample sets. A node's box becomes an interval of each
 * axis of view space, and one of slopes when those of x and y are divided by that of z: wide where x and z vary
 * together, tight where x is small beside z. So the map is chosen to make x and y small near what asks: a grid's has
 * its axis through the corner of the tile, a light's through the middle of the points. */
#ifndef DAFT_BOXES_H
#define DAFT_BOXES_H

#include "raster/triangles.h"

/* A map from the space of a tree's bounds. */
typedef struct node_map {
    float m[9];
    float low_t[3], high_t[3]; /* the translation, less and more a pad over the error of a moved vertex */
    int low_at[9], high_at[9]; /* which of a node's bounds makes m's product least, and most */
} node_map;

DAFT_INLINE void node_map_make(node_map *out, const float m[9], const float t[3], const float pad[3])
{
    for (int k = 0; k < 3; k++) {
        out->low_t[k] = t[k] - pad[k], out->high_t[k] = t[k] + pad[k];
        for (int i = 0; i < 3; i++) {
            bool down = m[3 * k + i] < 0;
            out->m[3 * k + i] = m[3 * k + i];
            out->low_at[3 * k + i] = DAFT_WIDTH * (down ? i + 3 : i);
            out->high_at[3 * k + i] = DAFT_WIDTH * (down ? i : i + 3);
        }
    }
}

/* Nodes whose children fill a register, or one that is looked at by parts. */
typedef struct node_pair {
    const daft_node *first, *second;
    int part;
} node_pair;

/* at: in floats from the first bound of all. */
DAFT_INLINE vf bounds_load(const node_pair *n, int at)
{
    const float *first = (const float *)(const void *)n->first->bounds,
                *second = (const float *)(const void *)n->second->bounds;
    return vf_load_eights(first + at, second + at, n->part);
}

typedef struct vf_range {
    vf low, high;
} vf_range;

/* The least and the largest value of one axis over boxes. */
DAFT_INLINE vf_range node_axis(const node_map *w, int k, const node_pair *n)
{
    const float *m = &w->m[3 * k];
    const int *a = &w->low_at[3 * k], *b = &w->high_at[3 * k];
    vf x = vf_set(m[0]), y = vf_set(m[1]), z = vf_set(m[2]);
    return (vf_range){
        x * bounds_load(n, a[0]) + y * bounds_load(n, a[1]) + z * bounds_load(n, a[2]) + vf_set(w->low_t[k]),
        x * bounds_load(n, b[0]) + y * bounds_load(n, b[1]) + z * bounds_load(n, b[2]) + vf_set(w->high_t[k])};
}

/* Distances of boxes from the apex. */
typedef struct node_depths {
    vf near, far, inverse_near, inverse_far;
    vm front; /* all of the box is before the apex */
} node_depths;

DAFT_INLINE node_depths node_depths_of(vf near, vf far)
{
    return (node_depths){near, far, vf_set(1) / near, vf_set(1) / far, vf_lt(vf_set(0), near)};
}

/* The slopes of boxes that are before the apex. */
DAFT_INLINE vf_range node_slopes(vf_range at, const node_depths *z)
{
    vf zero = vf_set(0);
    return (vf_range){at.low * vf_if_then_else(vf_lt(at.low, zero), z->inverse_near, z->inverse_far),
                      at.high * vf_if_then_else(vf_lt(at.high, zero), z->inverse_far, z->inverse_near)};
}

/* The boxes of which all that is before the apex has lower slopes than low <= 0, or higher ones than high >= 0. It
 * holds for boxes that reach behind it, too; a NaN, from an overflow, leaves a box in. */
DAFT_INLINE vbits node_beside(vf_range at, const node_depths *z, float low, float high)
{
    return vbits_from_mask(vf_lt(at.high, z->far * vf_set(low))) |
           vbits_from_mask(vf_lt(z->far * vf_set(high), at.low));
}

#endif
