/* Rays that travel together: what packet_kernel.c, which leads them through the nodes of trees, and packet_leaf_kernel.c, which
 * finds what they hit, share. A lane is a ray. */
#ifndef DAFT_PACKET_H
#define DAFT_PACKET_H

#include "accel/ray_test.h"
#include "accel/traverse/traverse.h"

/* What the rays found: daft_nearest, lane by lane. `place` is block · DAFT_BLOCK + triangle. */
typedef struct found {
    float t[DAFT_VL], u[DAFT_VL], v[DAFT_VL];
    uint32_t instance[DAFT_VL], triangle[DAFT_VL], place[DAFT_VL];
} found;

/* Rays on their way, in frame space. Those with tmin < 0 go alone. */
typedef struct convoy {
    const daft_tlas *tlas;
    const daft_ray_packet *rays;
    uint32_t first; /* lane 0's number among the sixteen */
    vf3 o, d;
    vf inverse[3]; /* one over the direction */
    vf tmin;
    uint32_t ignore;
    bool any;      /* whether they are stopped is all that is asked */
    vbits stopped; /* the answer */
    found hit;
    vf limit; /* of boxes; -inf for lanes that ask nothing more */
    vf inner_low, inner_high; /* daft_inner */
    vf dd, off;               /* directions' squares, and what spheres may be off by at least; for sphere_test */
} convoy;

/* The rays as boxes see them. */
typedef struct group {
    vf near[3], far[3], inverse[3], wide[3], low; /* the origin for near and for far planes; see single_kernel.c */
    size_t near_row[3], far_row[3];               /* in bytes from a node's bounds */
    /* the ends of their interval, by axis; near_end's last is low's */
    v4 near_end, far_end, inverse_ends[2], wide_ends[2];
    bool mixed; /* their directions' signs differ: no planes in common, and no interval */
    bool tight; /* the interval says something */
    float most; /* not less than any of their limits */
    /* what they go through: leaf number i, shifted so far, begins so many bytes from `leaves` */
    const convoy *rays;
    const daft_node *nodes;
    const void *leaves;
    size_t leaf_size;
    int leaf_shift;
} group;

typedef struct mesh_convoy {
    const daft_instance *instance;
    vf3 o, d; /* in object space */
    vf inverse[3];
    vf scale, floor; /* daft_filter */
} mesh_convoy;

DAFT_INLINE int first_lane(vbits bits) { return __builtin_ctz(bits); }

DAFT_INLINE void stop(convoy *c, vbits bits)
{
    c->stopped |= bits;
    c->limit = vf_if_then_else(vm_from_bits(bits), vf_set(-INFINITY), c->limit);
}

/* In the order of daft_affine_point and daft_affine_vector. */
DAFT_INLINE vf rows(const float *m, vf3 p) { return vf_set(m[0]) * p.x + vf_set(m[1]) * p.y + vf_set(m[2]) * p.z; }

DAFT_INLINE vf past_lanes(vf t) /* daft_past */
{
    return vf_if_then_else(vf_lt(vf_set(0), t), t * vf_set(1 + 0x1p-17f), t * vf_set(1 - 0x1p-17f));
}

/* ---- lanes for what works on single rays ---- */

DAFT_INLINE daft_ray lane_ray(const convoy *c, int lane)
{
    const daft_ray_packet *p = c->rays;
    uint32_t i = c->first + (uint32_t)lane;
    return (daft_ray){{p->origin[0][i], p->origin[1][i], p->origin[2][i]}, p->tmin[i],
                      {p->direction[0][i], p->direction[1][i], p->direction[2][i]}, p->tmax[i]};
}

DAFT_INLINE daft_nearest lane_nearest(const convoy *c, int i)
{
    const found *f = &c->hit;
    daft_nearest n = {f->t[i], f->u[i], f->v[i], f->instance[i], f->triangle[i], NULL, 0};
    const daft_instance *instance = n.instance == UINT32_MAX ? NULL : &c->tlas->instances[n.instance];
    if (!instance || !instance->mesh || instance->kdtree) return n;
    n.block = &instance->bvh->blocks[f->place[i] / DAFT_BLOCK], n.place = f->place[i] % DAFT_BLOCK;
    return n;
}

DAFT_INLINE void lane_take(convoy *c, int i, const daft_nearest *n, const daft_bvh *bvh)
{
    found *f = &c->hit;
    f->t[i] = n->t, f->u[i] = n->u, f->v[i] = n->v, f->instance[i] = n->instance, f->triangle[i] = n->triangle;
    if (bvh && n->block) f->place[i] = (uint32_t)(n->block - bvh->blocks) * DAFT_BLOCK + n->place;
    c->limit[i] = daft_past(n->t);
}

/* ---- kernels ---- */

/* Against a leaf's triangles; child is its code. g: what led the rays here, or NULL. True: some limit has changed. */
bool DAFT_KERNEL(daft_leaf_touch)(convoy *c, const mesh_convoy *m, const group *g, uint32_t child, vbits bits);
/* Against the instance with this number, a sphere. */
void DAFT_KERNEL(daft_sphere_touch)(convoy *c, uint32_t index, vbits bits);
/* Fills the hits of the active lanes; gives those that hit. */
vbits DAFT_KERNEL(daft_convoy_finish)(const convoy *c, vbits active, daft_hit *hits);

#endif
