/* Single rays through the two levels.
 *
 * Boxes: slab test of eight children at once. A zero component's inverse is infinite: planes then lie at plus or minus
 * infinity, and the NaN of a ray within a plane loses every comparison, so that plane says nothing, which is right. The far
 * distance is widened (Ize, "Robust BVH Ray Traversal", 2013), so rounding never misses a box: with u = 2^-24, a difference,
 * an inverse and a product move each distance by 3u, and the product that widens by u: 7u to first order, and 8u is taken. */
#include "accel/block_test.h"
#include "accel/kdtree.h"
#include "accel/traverse.h"
#include "math/isa.h"

#define WIDEN (1.0f + 8 * 0x1p-24f)
#define NARROW (1.0f - 8 * 0x1p-24f) /* widens where distances are negative */

DAFT_INLINE float widened(float far) { return far > 0 ? far * WIDEN : far * NARROW; }

typedef struct slab_ray {
    v8 nx, ny, nz, fx, fy, fz, ix, iy, iz; /* origin as the near and as the far planes see it, inverse direction */
    int near_x, near_y, near_z; /* which of bounds[] the ray enters by */
} slab_ray;

typedef struct entry {
    uint32_t child;
    float near;
} entry;

/* All boxes are grown by `pad` on each side. */
DAFT_INLINE slab_ray slab_setup(daft_vec3 o, daft_vec3 d, float pad)
{
    float x = 1 / d.x, y = 1 / d.y, z = 1 / d.z;
    float px = x < 0 ? -pad : pad, py = y < 0 ? -pad : pad, pz = z < 0 ? -pad : pad;
    return (slab_ray){v8_set(o.x + px), v8_set(o.y + py), v8_set(o.z + pz), v8_set(o.x - px), v8_set(o.y - py), v8_set(o.z - pz),
                      v8_set(x),        v8_set(y),        v8_set(z),        x < 0 ? 3 : 0,    y < 0 ? 4 : 1,    z < 0 ? 5 : 2};
}

/* The rays of the upper level. An instance's own ray, moved into its space and seen from outside again, is off by 5u of the
 * magnitudes of the origin and of the instance's place, |R|·|R^-1| being at most 1 by entry for a rotation and a scale; and
 * by 8u of the way, which is no longer than both. The instance's bounds are wide enough for its place; this is for the rest. */
DAFT_INLINE slab_ray slab_setup_upper(const daft_ray *ray)
{
    daft_vec3 o = ray->origin;
    return slab_setup(o, ray->direction, (fabsf(o.x) + fabsf(o.y) + fabsf(o.z)) * 0x1p-20f);
}

/* Bits of the children the ray meets in tmin..tmax; their entry distances in near. */
DAFT_INLINE uint32_t slab_test(const daft_node *node, const slab_ray *r, float tmin, float tmax, v8 *near)
{
    v8 x0 = (v8_load(node->bounds[r->near_x]) - r->nx) * r->ix;
    v8 y0 = (v8_load(node->bounds[r->near_y]) - r->ny) * r->iy;
    v8 z0 = (v8_load(node->bounds[r->near_z]) - r->nz) * r->iz;
    v8 x1 = (v8_load(node->bounds[3 - r->near_x]) - r->fx) * r->ix;
    v8 y1 = (v8_load(node->bounds[5 - r->near_y]) - r->fy) * r->iy;
    v8 z1 = (v8_load(node->bounds[7 - r->near_z]) - r->fz) * r->iz;
    /* v8_max and v8_min give their second argument when the first is NaN */
    *near = v8_max(x0, v8_max(y0, v8_max(z0, v8_set(tmin))));
    v8 far = v8_min(x1, v8_min(y1, v8_min(z1, v8_set(tmax))));
    return v8_le_bits(*near, v8_max(far * v8_set(WIDEN), far * v8_set(NARROW)));
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

/* In object space; hit->t limits the search and hit->triangle breaks ties, so the order of traversal does not matter. */
static bool mesh_closest(const daft_bvh *bvh, daft_vec3 o, daft_vec3 d, float tmin, daft_intersection how, daft_hit *hit)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup(o, d, 0);
    uint32_t before = hit->triangle;
    float before_t = hit->t;
    int top = 0;
    stack[top++] = (entry){0, tmin};
    while (top > 0) {
        entry e = stack[--top];
        if (e.near > widened(hit->t)) continue;
        if (e.child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(e.child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (e.child & 3); k++) {
                block_hits hits;
                uint32_t bits = block_test(&block[k], o, d, tmin, hit->t, how, &hits);
                if (bits) take_hits(&block[k], bits, &hits, hit);
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

static bool mesh_occluded(const daft_bvh *bvh, daft_vec3 o, daft_vec3 d, float tmin, float tmax, daft_intersection how)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup(o, d, 0);
    int top = 0;
    stack[top++].child = 0;
    while (top > 0) {
        uint32_t child = stack[--top].child;
        if (child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (child & 3); k++) {
                block_hits hits;
                if (block_test(&block[k], o, d, tmin, tmax, how, &hits)) return true;
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

/* The distance to a sphere, or a negative number for a miss; in double, since a tree holds few of them and tangents need
 * it. See daft_pencil_sphere for the method. */
static float sphere_distance(const daft_instance *s, const daft_ray *ray, float tmin, float tmax)
{
    const float *at = s->to_frame.t;
    daft_dvec3 d = daft_to_double(ray->direction);
    daft_dvec3 centre = daft_dsub(daft_dv3((double)at[0], (double)at[1], (double)at[2]), daft_to_double(ray->origin));
    double dd = daft_ddot(d, d), along = daft_ddot(centre, d) / dd, r = (double)s->radius;
    daft_dvec3 aside = daft_dsub(centre, daft_dscale(d, along));
    double discriminant = r * r - daft_ddot(aside, aside);
    if (!(discriminant >= 0) || !(r > 0)) return -1;
    double half = sqrt(discriminant / dd);
    float near = (float)(along - half), far = (float)(along + half);
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
        if (!(instance->kdtree ? DAFT_KERNEL(daft_kd_closest)(instance->kdtree, o, d, ray->tmin, tlas->intersection, &local)
                               : mesh_closest(instance->bvh, o, d, ray->tmin, tlas->intersection, &local)))
            return;
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

/* A ray that is not finite, goes nowhere or ends before it begins hits nothing. */
static bool usable(const daft_ray *ray)
{
    daft_vec3 d = ray->direction;
    return ray->tmin <= ray->tmax && daft_finite3(ray->origin) && daft_finite3(d) && (d.x != 0 || d.y != 0 || d.z != 0);
}

static bool closest(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_hit *hit)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup_upper(ray);
    *hit = (daft_hit){.t = ray->tmax, .instance = UINT32_MAX};
    if (tlas->nodes.count == 0 || !usable(ray)) return false;
    int top = 0;
    stack[top++] = (entry){0, ray->tmin};
    while (top > 0) {
        entry e = stack[--top];
        if (e.near > widened(hit->t)) continue;
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

static bool instance_occluded(const daft_instance *instance, const daft_ray *ray, daft_intersection how)
{
    if (!instance->mesh) return sphere_distance(instance, ray, ray->tmin, ray->tmax) >= 0;
    if (instance->mesh->triangle_count == 0) return false;
    daft_vec3 o = daft_affine_point(&instance->to_object, ray->origin);
    daft_vec3 d = daft_affine_vector(&instance->to_object, ray->direction);
    return instance->kdtree ? DAFT_KERNEL(daft_kd_occluded)(instance->kdtree, o, d, ray->tmin, ray->tmax, how)
                            : mesh_occluded(instance->bvh, o, d, ray->tmin, ray->tmax, how);
}

static bool occluded(const daft_tlas *tlas, const daft_ray *ray)
{
    entry stack[DAFT_STACK];
    slab_ray r = slab_setup_upper(ray);
    if (tlas->nodes.count == 0 || !usable(ray)) return false;
    int top = 0;
    stack[top++].child = 0;
    while (top > 0) {
        uint32_t child = stack[--top].child;
        if (child & DAFT_CHILD_LEAF) {
            const daft_instance *instance = &tlas->instances[child & ~DAFT_CHILD_LEAF];
            if (!(instance->flags & DAFT_INSTANCE_CASTS_SHADOW)) continue;
            if (instance_occluded(instance, ray, tlas->intersection)) return true;
        } else {
            v8 near;
            const daft_node *node = &tlas->nodes.items[child];
            uint32_t bits = slab_test(node, &r, ray->tmin, ray->tmax, &near);
            top = push_any(stack, top, node, bits);
        }
    }
    return false;
}

static uint32_t boxes(const daft_node *node, const daft_ray *ray)
{
    slab_ray r = slab_setup(ray->origin, ray->direction, 0);
    v8 near;
    if (!usable(ray)) return 0;
    uint32_t real = 0xff;
    for (int k = 0; k < 3; k++) real &= v8_le_bits(v8_load(node->bounds[k]), v8_load(node->bounds[k + 3]));
    return real & slab_test(node, &r, ray->tmin, ray->tmax, &near);
}

const daft_accel_kernels DAFT_KERNEL(daft_accel) = {closest, occluded, boxes};
