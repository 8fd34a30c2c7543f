/* Single rays through the two levels.
 *
 * Boxes: slab test of eight children at once. A direction component too small to invert counts as 1e-18, so no 0·inf
 * arises; the far distance is widened by 2·gamma(3) (Ize, "Robust BVH Ray Traversal", 2013), so rounding never misses a box.
 *
 * Triangles: corners relative to the ray's origin, edge planes (a - b) × (a + b) = 2·a × b. Exchanging a and b negates every
 * bit of it, so the two triangles at an edge see opposite values of one number and no ray passes between them (Davidovič
 * et al., "3D rasterization", 2012; Woop et al., "Watertight Ray/Triangle Intersection", 2013). */
#include "accel/bvh.h"
#include "accel/traverse.h"
#include "math/isa.h"
#include "math/simd.h"

#define WIDEN (1.0f + 6 * 0x1p-24f)

typedef struct slab_ray {
    v8 ox, oy, oz, ix, iy, iz; /* origin, inverse direction */
    int near_x, near_y, near_z; /* which of bounds[] the ray enters by */
} slab_ray;

typedef struct entry {
    uint32_t child;
    float near;
} entry;

DAFT_INLINE float safe_inverse(float d)
{
    const float least = 1e-18f;
    if (!(fabsf(d) >= least)) d = copysignf(least, d);
    return 1 / d;
}

DAFT_INLINE slab_ray slab_setup(daft_vec3 o, daft_vec3 d)
{
    float x = safe_inverse(d.x), y = safe_inverse(d.y), z = safe_inverse(d.z);
    return (slab_ray){v8_set(o.x), v8_set(o.y), v8_set(o.z), v8_set(x), v8_set(y), v8_set(z),
                      x < 0 ? 3 : 0,   y < 0 ? 4 : 1,   z < 0 ? 5 : 2};
}

/* Bits of the children the ray meets in tmin..tmax; their entry distances in near. */
DAFT_INLINE uint32_t slab_test(const daft_node *node, const slab_ray *r, float tmin, float tmax, v8 *near)
{
    v8 x0 = (v8_load(node->bounds[r->near_x]) - r->ox) * r->ix;
    v8 y0 = (v8_load(node->bounds[r->near_y]) - r->oy) * r->iy;
    v8 z0 = (v8_load(node->bounds[r->near_z]) - r->oz) * r->iz;
    v8 x1 = (v8_load(node->bounds[3 - r->near_x]) - r->ox) * r->ix;
    v8 y1 = (v8_load(node->bounds[5 - r->near_y]) - r->oy) * r->iy;
    v8 z1 = (v8_load(node->bounds[7 - r->near_z]) - r->oz) * r->iz;
    *near = v8_max(v8_max(x0, y0), v8_max(z0, v8_set(tmin)));
    v8 far = v8_min(v8_min(x1, y1), v8_min(z1, v8_set(tmax)));
    return v8_le_bits(*near, far * v8_set(WIDEN));
}

/* Pushes the children nearest last. */
DAFT_INLINE int push_sorted(entry *stack, int top, const daft_node *node, uint32_t bits, v8 near)
{
    int first = top;
    while (bits) {
        int i = __builtin_ctz(bits);
        bits &= bits - 1;
        entry fresh = {node->child[i], near[i]};
        int place = top++;
        while (place > first && stack[place - 1].near < fresh.near) stack[place] = stack[place - 1], place--;
        stack[place] = fresh;
    }
    return top;
}

DAFT_INLINE int push_any(entry *stack, int top, const daft_node *node, uint32_t bits)
{
    while (bits) {
        int i = __builtin_ctz(bits);
        bits &= bits - 1;
        stack[top++].child = node->child[i];
    }
    return top;
}

typedef struct v43 {
    v4 x, y, z;
} v43;

DAFT_INLINE v43 v43_sub(v43 a, v43 b) { return (v43){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE v43 v43_add(v43 a, v43 b) { return (v43){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE v43 v43_cross(v43 a, v43 b)
{
    return (v43){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE v4 v43_dot(v43 a, v43 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DAFT_INLINE v43 v43_set(daft_vec3 a) { return (v43){v4_set(a.x), v4_set(a.y), v4_set(a.z)}; }
DAFT_INLINE v43 block_corner(const daft_block *b, int k, v43 origin)
{
    v43 corner = {v4_load(b->corner[k][0]), v4_load(b->corner[k][1]), v4_load(b->corner[k][2])};
    return v43_sub(corner, origin);
}

/* Bits of the triangles hit in tmin..tmax; *t the distances, *v and *w the weights of corners 1 and 2. */
DAFT_INLINE uint32_t block_test(const daft_block *b, v43 o, v43 d, float tmin, float tmax, v4 *t, v4 *v, v4 *w)
{
    v43 p0 = block_corner(b, 0, o), p1 = block_corner(b, 1, o), p2 = block_corner(b, 2, o);
    v43 e0 = v43_sub(p2, p0), e1 = v43_sub(p0, p1), e2 = v43_sub(p1, p2);
    v4 side1 = v43_dot(v43_cross(e0, v43_add(p2, p0)), d);
    v4 side2 = v43_dot(v43_cross(e1, v43_add(p0, p1)), d);
    v4 side0 = v43_dot(v43_cross(e2, v43_add(p1, p2)), d);
    v4 least = v4_min(v4_min(side0, side1), side2), most = v4_max(v4_max(side0, side1), side2);
    v43 normal = v43_cross(e1, e0);
    v4 slope = v43_dot(normal, d), sum = side0 + side1 + side2;
    *t = v43_dot(normal, p0) / slope;
    *v = side1 / sum;
    *w = side2 / sum;
    v4i one_side = (v4i)(least >= v4_set(0)) | (v4i)(most <= v4_set(0));
    v4i within = (v4i)(*t >= v4_set(tmin)) & (v4i)(*t <= v4_set(tmax)) & (v4i)(slope != v4_set(0)) & (v4i)(sum != v4_set(0));
    return v4_bits(one_side & within);
}

DAFT_INLINE float unit(float s) { return s > 0 ? (s < 1 ? s : 1) : 0; }

static void take_hits(const daft_block *b, uint32_t bits, v4 t, v4 v, v4 w, daft_hit *hit)
{
    while (bits) {
        int i = __builtin_ctz(bits);
        bits &= bits - 1;
        bool nearer = t[i] < hit->t || (t[i] == hit->t && b->triangle[i] < hit->triangle);
        if (!nearer) continue;
        hit->t = t[i], hit->u = unit(v[i]), hit->v = unit(w[i]), hit->triangle = b->triangle[i];
    }
}

/* In object space; hit->t limits the search and hit->triangle breaks ties, so the order of traversal does not matter. */
static bool mesh_closest(const daft_bvh *bvh, daft_vec3 o, daft_vec3 d, float tmin, daft_hit *hit)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup(o, d);
    v43 origin = v43_set(o), direction = v43_set(d);
    uint32_t before = hit->triangle;
    float before_t = hit->t;
    int top = 0;
    stack[top++] = (entry){0, tmin};
    while (top > 0) {
        entry e = stack[--top];
        if (e.near > hit->t * WIDEN) continue;
        if (e.child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(e.child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (e.child & 3); k++) {
                v4 t, v, w;
                uint32_t bits = block_test(&block[k], origin, direction, tmin, hit->t, &t, &v, &w);
                if (bits) take_hits(&block[k], bits, t, v, w, hit);
            }
        } else {
            v8 near;
            const daft_node *node = &bvh->nodes.items[e.child];
            uint32_t bits = slab_test(node, &r, tmin, hit->t, &near);
            top = push_sorted(stack, top, node, bits, near);
        }
    }
    return hit->t < before_t || hit->triangle != before;
}

static bool mesh_occluded(const daft_bvh *bvh, daft_vec3 o, daft_vec3 d, float tmin, float tmax)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup(o, d);
    v43 origin = v43_set(o), direction = v43_set(d);
    int top = 0;
    stack[top++].child = 0;
    while (top > 0) {
        uint32_t child = stack[--top].child;
        if (child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (child & 3); k++) {
                v4 t, v, w;
                if (block_test(&block[k], origin, direction, tmin, tmax, &t, &v, &w)) return true;
            }
        } else {
            v8 near;
            const daft_node *node = &bvh->nodes.items[child];
            uint32_t bits = slab_test(node, &r, tmin, tmax, &near);
            top = push_any(stack, top, node, bits);
        }
    }
    return false;
}

/* The distance to a sphere, or a negative number for a miss. See daft_pencil_sphere for the method. */
static float sphere_distance(const daft_instance *s, const daft_ray *ray, float tmin, float tmax)
{
    daft_vec3 centre = daft_sub(daft_v3(s->to_frame.t[0], s->to_frame.t[1], s->to_frame.t[2]), ray->origin);
    float dd = daft_dot(ray->direction, ray->direction), along = daft_dot(centre, ray->direction) / dd;
    daft_vec3 aside = daft_sub(centre, daft_scale(ray->direction, along));
    float discriminant = s->radius * s->radius - daft_dot(aside, aside);
    if (!(discriminant >= 0)) return -1;
    float half = sqrtf(discriminant / dd), near = along - half, far = along + half;
    if (near >= tmin && near <= tmax) return near;
    return far >= tmin && far <= tmax ? far : -1;
}

static daft_vec3 triangle_normal(const daft_instance *instance, uint32_t triangle)
{
    const daft_trimesh *mesh = instance->mesh;
    const uint32_t *c = &mesh->indices[3 * (size_t)triangle];
    daft_vec3 p[3];
    for (int k = 0; k < 3; k++)
        p[k] = daft_affine_point(&instance->to_frame, daft_v3(mesh->x[c[k]], mesh->y[c[k]], mesh->z[c[k]]));
    return daft_cross(daft_sub(p[1], p[0]), daft_sub(p[2], p[0]));
}

static void instance_closest(const daft_tlas *tlas, uint32_t index, const daft_ray *ray, daft_hit *hit)
{
    const daft_instance *instance = &tlas->instances[index];
    if (instance->mesh) {
        daft_vec3 o = daft_affine_point(&instance->to_object, ray->origin);
        daft_vec3 d = daft_affine_vector(&instance->to_object, ray->direction);
        daft_hit local = *hit;
        local.triangle = index < hit->instance ? DAFT_NO_TRIANGLE : 0; /* a tie goes to the lower instance */
        if (!mesh_closest(instance->bvh, o, d, ray->tmin, &local)) return;
        *hit = local;
        hit->instance = index;
        return;
    }
    float t = sphere_distance(instance, ray, ray->tmin, hit->t);
    if (t < 0 || (t == hit->t && index > hit->instance)) return;
    *hit = (daft_hit){.t = t, .instance = index};
}

static void finish_hit(const daft_tlas *tlas, const daft_ray *ray, daft_hit *hit)
{
    const daft_instance *instance = &tlas->instances[hit->instance];
    if (instance->mesh) {
        hit->normal = triangle_normal(instance, hit->triangle);
        return;
    }
    daft_vec3 centre = daft_v3(instance->to_frame.t[0], instance->to_frame.t[1], instance->to_frame.t[2]);
    hit->normal = daft_sub(daft_add(ray->origin, daft_scale(ray->direction, hit->t)), centre);
}

static bool closest(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_hit *hit)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup(ray->origin, ray->direction);
    *hit = (daft_hit){.t = ray->tmax, .instance = UINT32_MAX};
    if (tlas->nodes.count == 0 || !(ray->tmin <= ray->tmax)) return false;
    int top = 0;
    stack[top++] = (entry){0, ray->tmin};
    while (top > 0) {
        entry e = stack[--top];
        if (e.near > hit->t * WIDEN) continue;
        if (e.child & DAFT_CHILD_LEAF) {
            uint32_t index = e.child & ~DAFT_CHILD_LEAF;
            if (index != ignore) instance_closest(tlas, index, ray, hit);
        } else {
            v8 near;
            const daft_node *node = &tlas->nodes.items[e.child];
            uint32_t bits = slab_test(node, &r, ray->tmin, hit->t, &near);
            top = push_sorted(stack, top, node, bits, near);
        }
    }
    if (hit->instance == UINT32_MAX) return false;
    finish_hit(tlas, ray, hit);
    return true;
}

static bool instance_occluded(const daft_instance *instance, const daft_ray *ray)
{
    if (!(instance->flags & DAFT_INSTANCE_CASTS_SHADOW)) return false;
    if (!instance->mesh) return sphere_distance(instance, ray, ray->tmin, ray->tmax) >= 0;
    if (instance->mesh->triangle_count == 0) return false;
    daft_vec3 o = daft_affine_point(&instance->to_object, ray->origin);
    daft_vec3 d = daft_affine_vector(&instance->to_object, ray->direction);
    return mesh_occluded(instance->bvh, o, d, ray->tmin, ray->tmax);
}

static bool occluded(const daft_tlas *tlas, const daft_ray *ray)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup(ray->origin, ray->direction);
    if (tlas->nodes.count == 0) return false;
    int top = 0;
    stack[top++].child = 0;
    while (top > 0) {
        uint32_t child = stack[--top].child;
        if (child & DAFT_CHILD_LEAF) {
            if (instance_occluded(&tlas->instances[child & ~DAFT_CHILD_LEAF], ray)) return true;
        } else {
            v8 near;
            const daft_node *node = &tlas->nodes.items[child];
            uint32_t bits = slab_test(node, &r, ray->tmin, ray->tmax, &near);
            top = push_any(stack, top, node, bits);
        }
    }
    return false;
}

const daft_accel_kernels DAFT_KERNEL(daft_accel) = {closest, occluded, instance_occluded};
