/* A packet of rays; a lane is a ray. Shared by packet_kernel.c, which takes packets through the nodes of trees, and
 * packet_leaf_kernel.c, which intersects them with triangles and spheres. */
#ifndef DAFT_PACKET_H
#define DAFT_PACKET_H

#include "accel/ray_test.h"
#include "accel/traverse/traverse.h"

/* The nearest hits so far: daft_nearest in lanes. `place` is block · DAFT_BLOCK + the triangle's lane. */
typedef struct packet_hits {
    float t[DAFT_VL], u[DAFT_VL], v[DAFT_VL];
    uint32_t instance[DAFT_VL], triangle[DAFT_VL], place[DAFT_VL];
} packet_hits;

/* Rays in frame space. Those with tmin < 0 are traced as single rays. */
typedef struct packet {
    const daft_tlas *tlas;
    const daft_ray_packet *rays;
    uint32_t first; /* lane 0's number among the sixteen */
    vf3 o, d;
    vf inverse[3]; /* one over the direction */
    vf tmin;
    uint32_t ignore;
    bool any;       /* any-hit query: only `occluded` is wanted */
    vbits occluded; /* the answer */
    packet_hits hit;
    vf limit;                 /* of boxes; -inf for lanes that are done */
    vf inner_low, inner_high; /* daft_inner */
    vf dd, off;               /* directions' squares, and what spheres may be off by at least; for sphere_test */
} packet;

/* The packet for slab tests, in the space of the tree that it traverses. */
typedef struct packet_slabs {
    vf near[3], far[3], inverse[3], wide[3], low; /* the origin for near and for far planes; see single_kernel.c */
    size_t near_row[3], far_row[3];               /* in bytes from a node's bounds */
    /* the ends of their interval, by axis; near_end's last is low's */
    v4 near_end, far_end, inverse_ends[2], wide_ends[2];
    bool mixed; /* the signs of the directions differ: no common planes, no interval */
    bool tight; /* the interval is finite */
    float most; /* not less than any of their limits */
    /* what they go through: leaf number i, shifted so far, begins so many bytes from `leaves` */
    const packet *rays;
    const daft_node *nodes;
    const void *leaves;
    size_t leaf_size;
    int leaf_shift;
} packet_slabs;

typedef struct mesh_packet {
    const daft_instance *instance;
    vf3 o, d; /* in object space */
    vf inverse[3];
    vf scale, floor; /* daft_filter */
} mesh_packet;

DAFT_INLINE int first_lane(vbits bits) { return __builtin_ctz(bits); }

DAFT_INLINE void mark_occluded(packet *c, vbits bits)
{
    c->occluded |= bits;
    c->limit = vf_if_then_else(vm_from_bits(bits), vf_set(-INFINITY), c->limit);
}

/* In the order of daft_affine_point and daft_affine_vector. */
DAFT_INLINE vf rows(const float *m, vf3 p) { return vf_set(m[0]) * p.x + vf_set(m[1]) * p.y + vf_set(m[2]) * p.z; }

DAFT_INLINE vf past_lanes(vf t) /* daft_past */
{
    return vf_if_then_else(vf_lt(vf_set(0), t), t * vf_set(1 + 0x1p-17f), t * vf_set(1 - 0x1p-17f));
}

/* ---- lanes as single rays ---- */

DAFT_INLINE daft_ray lane_ray(const packet *c, int lane)
{
    const daft_ray_packet *p = c->rays;
    uint32_t i = c->first + (uint32_t)lane;
    return (daft_ray){{p->origin[0][i], p->origin[1][i], p->origin[2][i]},
                      p->tmin[i],
                      {p->direction[0][i], p->direction[1][i], p->direction[2][i]},
                      p->tmax[i]};
}

DAFT_INLINE daft_nearest lane_nearest(const packet *c, int i)
{
    const packet_hits *f = &c->hit;
    daft_nearest n = {f->t[i], f->u[i], f->v[i], f->instance[i], f->triangle[i], NULL, 0};
    const daft_instance *instance = n.instance == UINT32_MAX ? NULL : &c->tlas->instances[n.instance];
    if (!instance || !instance->mesh || instance->kdtree) return n;
    n.block = &instance->bvh->blocks[f->place[i] / DAFT_BLOCK], n.place = f->place[i] % DAFT_BLOCK;
    return n;
}

DAFT_INLINE void lane_store(packet *c, int i, const daft_nearest *n, const daft_bvh *bvh)
{
    packet_hits *f = &c->hit;
    f->t[i] = n->t, f->u[i] = n->u, f->v[i] = n->v, f->instance[i] = n->instance, f->triangle[i] = n->triangle;
    if (bvh && n->block) f->place[i] = (uint32_t)(n->block - bvh->blocks) * DAFT_BLOCK + n->place;
    c->limit[i] = daft_past(n->t);
}

/* ---- kernels ---- */

/* Intersects a leaf's triangles; `child` is its code. g: for the test of triangles' boxes, or NULL. True: some limit
 * has changed. */
bool DAFT_KERNEL(daft_packet_leaf)(packet *c, const mesh_packet *m, const packet_slabs *g, uint32_t child, vbits bits);
/* Intersects the instance with this number, a sphere. */
void DAFT_KERNEL(daft_packet_sphere)(packet *c, uint32_t index, vbits bits);
/* Fills the hits of the active lanes; gives those that hit. */
vbits DAFT_KERNEL(daft_packet_finish)(const packet *c, vbits active, daft_hit *hits);

#endif
