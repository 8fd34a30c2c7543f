/* How single rays enter instances: the ray in a mesh's object space, and spheres. For single_kernel.c. */
#ifndef DAFT_INSTANCE_RAY_H
#define DAFT_INSTANCE_RAY_H

#include "accel/traverse/mesh_traversal.h"

DAFT_INLINE v4 v4_clear_w(v4 a) { return (v4)((v4i)a & (v4i){-1, -1, -1, 0}); }

/* A ray in some space; lanes 3 are 0. */
typedef struct simd_ray {
    v4 origin, direction;
    slab_direction slabs;
} simd_ray;

DAFT_INLINE simd_ray simd_ray_of(const daft_ray *ray)
{
    v4 d = v4_clear_w(v4_load((const float *)ray + 4));
    return (simd_ray){v4_clear_w(v4_load((const float *)ray)), d, slab_direction_of(d, minus_inverse(d))};
}

/* A map as rows: whole registers are loaded across the end of its matrix. */
typedef struct affine_rows {
    v4 x, y, z, t; /* rows; lane 3: anything. t: the translation, lane 3: 0 */
} affine_rows;

DAFT_INLINE affine_rows affine_rows_of(const daft_affine *map)
{
    _Static_assert(sizeof *map == 12 * sizeof(float), "nothing between the matrix and the translation");
    const float *row = (const float *)(const void *)map; /* of all of the struct, not of m[9] */
    return (affine_rows){v4_load(row), v4_load(row + 3), v4_load(row + 6),
                         __builtin_shufflevector(v4_load(row + 8), v4_set(0), 1, 2, 3, 4)};
}

DAFT_INLINE v4 translation_of(const daft_affine *map) { return affine_rows_of(map).t; }

DAFT_INLINE bool finite_lanes(v4 a, v4 b) { return v4_bits_from_mask((a - a) + (b - b) == v4_set(0)) == 15; }

/* daft_affine_point and daft_affine_vector side by side. False: it overflows. */
DAFT_INLINE bool to_object_space(const daft_affine *map, const simd_ray *frame, simd_ray *local)
{
    v4 o = frame->origin, d = frame->direction, x, y, z;
    affine_rows rows = affine_rows_of(map);
    v4_transpose3(rows.x, rows.y, rows.z, &x, &y, &z);
    local->origin = v4_clear_w(((x * v4_set(o[0]) + y * v4_set(o[1])) + z * v4_set(o[2])) + rows.t);
    local->direction = v4_clear_w((x * v4_set(d[0]) + y * v4_set(d[1])) + z * v4_set(d[2]));
    local->slabs = slab_direction_of(local->direction, minus_inverse(local->direction));
    return finite_lanes(local->origin, local->direction);
}

/* Where to begin: the box of a single leaf is the mesh's. */
DAFT_INLINE uint32_t first_child(const daft_bvh *bvh, uint32_t child)
{
    const daft_node *root = bvh->nodes.items;
    return child == 0 && root->child[1] == DAFT_CHILD_NONE ? root->child[0] : child;
}

/* ---- spheres ---- */

/* The distance to a sphere, or a negative number for a miss; in double, since a tree holds few of them and tangents
 * need it. See daft_pencil_sphere for the method. */
static __attribute__((unused)) float sphere_distance(const daft_instance *s, const daft_ray *ray, float tmin,
                                                     float tmax)
{
    const float *at = s->to_frame.t;
    daft_dvec3 d = daft_to_double(ray->direction);
    daft_dvec3 centre = daft_dsub(daft_dv3((double)at[0], (double)at[1], (double)at[2]), daft_to_double(ray->origin));
    double dd = daft_ddot(d, d), forward = daft_ddot(centre, d), r = (double)s->radius;
    if (forward < 0 && tmin >= 0 && daft_ddot(centre, centre) > r * r * DAFT_SPHERE_OUTSIDE) return -1;
    double along = forward / dd;
    daft_dvec3 aside = daft_dsub(centre, daft_dscale(d, along));
    double discriminant = r * r - daft_ddot(aside, aside);
    if (!(discriminant >= 0) || !(r > 0)) return -1;
    double half = sqrt(discriminant / dd);
    float near = (float)(along - half), far = (float)(along + half);
    if (near >= tmin && near <= tmax) return near;
    return far >= tmin && far <= tmax ? far : -1;
}

/* A ray as a node's spheres see it: twice its origin, its direction, the square and, as the sum of the axes, no less
 * than the length of that, and the least that sizes are off by. */
typedef struct sphere_view {
    v8 x2, y2, z2, dx, dy, dz, dd, pad;
    float length;
    bool usual; /* nothing below under- or overflows unseen */
} sphere_view;

DAFT_INLINE sphere_view sphere_view_of(v4 o, v4 d, bool plain)
{
    v4 twice = o + o;
    float size = fabsf(d[0]) + fabsf(d[1]) + fabsf(d[2]), far = fabsf(twice[0]) + fabsf(twice[1]) + fabsf(twice[2]);
    bool usual = plain && size > 0x1p-26f && size < 0x1p26f && far < DAFT_SPHERE_FAR;
    v8 dd = v8_set((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]), pad = v8_set(far * DAFT_SPHERE_OFF);
    return (sphere_view){v8_set(twice[0]),
                         v8_set(twice[1]),
                         v8_set(twice[2]),
                         v8_set(d[0]),
                         v8_set(d[1]),
                         v8_set(d[2]),
                         dd,
                         pad,
                         size,
                         usual};
}

/* A node's spheres, in lanes: sizes and what they are off by, how far their centres lie along the ray and beside it,
 * times the direction's length, and from its origin. All is twice as large, squares four times. */
typedef struct node_spheres {
    v8 size, off, along, beside_square, way_square;
} node_spheres;

/* A sphere stands in the middle of its bounds. */
DAFT_INLINE node_spheres node_spheres_of(const daft_node *node, const sphere_view *s)
{
    v8 low = v8_load(node->bounds[0]), high = v8_load(node->bounds[3]), r = high - low;
    v8 x = low + high - s->x2, y = v8_load(node->bounds[1]) + v8_load(node->bounds[4]) - s->y2,
       z = v8_load(node->bounds[2]) + v8_load(node->bounds[5]) - s->z2;
    v8 i = y * s->dz - z * s->dy, j = z * s->dx - x * s->dz, k = x * s->dy - y * s->dx;
    v8 off = (v8_max(x, -x) + v8_max(y, -y) + v8_max(z, -z) + r) * v8_set(DAFT_SPHERE_OFF) + s->pad;
    return (node_spheres){r, off, x * s->dx + y * s->dy + z * s->dz, i * i + j * j + k * k, x * x + y * y + z * z};
}

/* Of a node's children in `bits`, those but for the spheres that the ray is sure to pass by or to leave behind. */
DAFT_INLINE uint32_t spheres_met(const daft_node *node, uint32_t bits, const node_spheres *at, const sphere_view *s)
{
    v8 reach = at->size + at->off, square = reach * reach;
    uint32_t beside = v8_le_bits(square * s->dd + v8_set(DAFT_TINY), at->beside_square);
    uint32_t behind = v8_le_bits(at->along, v8_set(0)) & v8_le_bits(square + v8_set(DAFT_TINY), at->way_square);
    return bits & ~(node->spheres & (beside | behind));
}

/* The spheres that the ray is sure to meet, and to leave, or to reach the middle of, within tmin..tmax: their
 * distances, by whatever formula, are no question then. Bounds are wider than their spheres, by 12u of |o| + |c| + r;
 * so twice what is off is taken. */
DAFT_INLINE uint32_t spheres_pierced(const daft_node *node, const node_spheres *at, const sphere_view *s, float tmin,
                                     float tmax)
{
    v8 twice = at->off + at->off, least = v8_max(at->size - twice, v8_set(0)), length = v8_set(s->length),
       dd = s->dd + s->dd;
    uint32_t through = v8_le_bits(at->beside_square + v8_set(DAFT_TINY), least * least * s->dd);
    uint32_t after = v8_le_bits(dd * v8_set(tmin * (1 + 0x1p-17f)), at->along - at->off * length);
    uint32_t before = v8_le_bits(at->along + (at->size + twice) * length, dd * v8_set(tmax * (1 - 0x1p-17f)));
    return node->spheres & through & after & before;
}

#endif
