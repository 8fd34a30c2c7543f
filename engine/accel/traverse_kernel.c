/* Single rays through the two levels. How they meet boxes and triangles is in ray_test.h; here it is in which order.
 *
 * What costs most in rays that go every way is not arithmetic but branches that cannot be predicted: how many children a ray
 * meets, and which is nearest. So where lanes can be sorted there are none: the eight entry distances, with the lanes'
 * numbers in their lowest bits, go through a sorting network, and all eight are written on top of the stack, furthest
 * first; those that were missed stand above its new top. (Ordered traversal and the stack's distances are those of Wald et
 * al., "Embree: A Kernel Framework for Efficient CPU Ray Tracing", 2014.) The blocks of a leaf go through the filter
 * together, as many as there are lanes for. */
#include "accel/kdtree.h"
#include "accel/ray_test.h"
#include "accel/traverse.h"

#define WIDEN (1 + 8 * DAFT_ULP)
enum { ROW = sizeof(((daft_node *)0)->bounds[0]) };

typedef struct slab_ray {
    /* the origin as the near and as the far planes see it, one over the direction, and the same widened */
    v8 nx, ny, nz, fx, fy, fz, ix, iy, iz, wx, wy, wz;
    size_t near_x, near_y, near_z, far_x, far_y, far_z; /* where in bounds, in bytes, the planes stand that it enters and leaves by */
    bool behind;                     /* distances may be negative */
} slab_ray;

/* Children to visit and their entry distances, nearest on top; room for a node's children above the deepest. */
typedef struct ray_stack {
    float near[DAFT_STACK + DAFT_WIDTH];
    uint32_t child[DAFT_STACK + DAFT_WIDTH];
} ray_stack;

/* All boxes are grown by `pad` on each side. No branches: the directions' signs cannot be predicted. */
DAFT_INLINE slab_ray slab_setup(daft_vec3 o, daft_vec3 d, float pad, bool behind)
{
    v4 origin = {o.x, o.y, o.z, 0}, inverse = v4_set(1) / (v4){d.x, d.y, d.z, 1}, wide = inverse * v4_set(WIDEN);
    v4i sign = (v4i)inverse & (v4i){INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    v4 outwards = (v4)((v4i)v4_set(pad) | sign), near = origin + outwards, far = origin - outwards;
    uint32_t minus = v4_bits(sign);
    size_t near_x = (minus & 1) * 3 * ROW, near_y = (minus >> 1 & 1) * 3 * ROW, near_z = (minus >> 2 & 1) * 3 * ROW;
    return (slab_ray){.nx = v8_set(near[0]), .ny = v8_set(near[1]), .nz = v8_set(near[2]),
                      .fx = v8_set(far[0]), .fy = v8_set(far[1]), .fz = v8_set(far[2]),
                      .ix = v8_set(inverse[0]), .iy = v8_set(inverse[1]), .iz = v8_set(inverse[2]),
                      .wx = v8_set(wide[0]), .wy = v8_set(wide[1]), .wz = v8_set(wide[2]),
                      .near_x = near_x, .near_y = ROW + near_y, .near_z = 2 * ROW + near_z,
                      .far_x = 3 * ROW - near_x, .far_y = 4 * ROW - near_y, .far_z = 5 * ROW - near_z, .behind = behind};
}

/* The rays of the upper level. An instance's own ray, moved into its space and seen from outside again, is off by 5u of the
 * magnitudes of the origin and of the instance's place, |R|·|R^-1| being at most 1 by entry for a rotation and a scale; and
 * by 8u of the way, which is no longer than both. The instance's bounds are wide enough for its place; this is for the rest. */
DAFT_INLINE slab_ray slab_setup_upper(const daft_ray *ray)
{
    daft_vec3 o = ray->origin;
    return slab_setup(o, ray->direction, (fabsf(o.x) + fabsf(o.y) + fabsf(o.z)) * 0x1p-20f, ray->tmin < 0);
}

/* Bits of the children the ray meets in tmin..tmax; their entry distances in near. `padded`: the setup's pad is not 0. */
DAFT_INLINE uint32_t slab_test(const daft_node *node, const slab_ray *r, bool padded, v8 tmin, v8 tmax, v8 *near)
{
    const char *at = (const char *)node->bounds;
    v8 x0 = (v8_load((const float *)(at + r->near_x)) - r->nx) * r->ix, x1 = (v8_load((const float *)(at + r->far_x)) - (padded ? r->fx : r->nx)) * r->wx;
    v8 y0 = (v8_load((const float *)(at + r->near_y)) - r->ny) * r->iy, y1 = (v8_load((const float *)(at + r->far_y)) - (padded ? r->fy : r->ny)) * r->wy;
    v8 z0 = (v8_load((const float *)(at + r->near_z)) - r->nz) * r->iz, z1 = (v8_load((const float *)(at + r->far_z)) - (padded ? r->fz : r->nz)) * r->wz;
    /* v8_max and v8_min give their second argument when the first is NaN */
    *near = v8_max(x0, v8_max(y0, v8_max(z0, tmin)));
    v8 far = v8_min(x1, v8_min(y1, v8_min(z1, tmax)));
    if (r->behind) far = v8_max(far, far * v8_set(1 - 24 * DAFT_ULP)); /* there widening goes the other way */
    return v8_le_bits(*near, far);
}

/* Of the children in bits, 1 or more: the nearest is the answer, the others are pushed, nearest last. */
DAFT_INLINE uint32_t step(const daft_node *node, uint32_t bits, v8 near, ray_stack *stack, int *top)
{
    float at[DAFT_WIDTH] __attribute__((aligned(32)));
    uint32_t i = (uint32_t)__builtin_ctz(bits), first = node->child[i];
    bits &= bits - 1;
    if (!bits) return first;
    memcpy(at, &near, sizeof at);
    float nearest = at[i];
    int base = *top, end = base;
    do {
        i = (uint32_t)__builtin_ctz(bits);
        bits &= bits - 1;
        uint32_t child = node->child[i];
        float t = at[i];
        bool swap = t < nearest;
        uint32_t further = swap ? first : child;
        float furthest = swap ? nearest : t;
        first = swap ? child : first, nearest = swap ? t : nearest;
        int place = end++;
        for (; place > base && stack->near[place - 1] < furthest; place--)
            stack->near[place] = stack->near[place - 1], stack->child[place] = stack->child[place - 1];
        stack->near[place] = furthest, stack->child[place] = further;
    } while (bits);
    *top = end;
    return first;
}

/* ---- triangles ---- */

/* A ray in the space of a mesh. */
typedef struct mesh_ray {
    daft_vec3 origin, direction;
    float tmin;
    daft_intersection how;
    /* The filter's frame: the direction's largest axis is last. */
    int axis[3];
    vf o[3], shear_x, shear_y, ahead, per_length, least;
} mesh_ray;

static const int NEXT[3] = {1, 2, 0};

DAFT_INLINE mesh_ray mesh_ray_setup(const daft_trimesh *mesh, daft_vec3 o, daft_vec3 d, float tmin, daft_intersection how)
{
    const float from[3] = {o.x, o.y, o.z}, way[3] = {d.x, d.y, d.z};
    float x = fabsf(d.x), y = fabsf(d.y), z = fabsf(d.z), xy = x > y ? x : y;
    int k = z > xy ? 2 : y > x, i = NEXT[k], j = NEXT[i];
    daft_filter filter = daft_filter_of(daft_reach_of(mesh, o));
    return (mesh_ray){.origin = o, .direction = d, .tmin = tmin, .how = how, .axis = {i, j, k},
                      .o = {vf_set(from[i]), vf_set(from[j]), vf_set(from[k])},
                      .shear_x = vf_set(way[i] / way[k]), .shear_y = vf_set(way[j] / way[k]),
                      .ahead = vf_set(tmin >= 0 ? copysignf(1, way[k]) : NAN), .per_length = vf_set(filter.per_length), .least = vf_set(filter.least)};
}

enum { FOURS = DAFT_VL / DAFT_BLOCK, PAIR = FOURS > 1 ? 2 : 1, BLOCK_FLOATS = sizeof(daft_block) / sizeof(float) };

/* The triangles of `count` blocks, at most `width`, that may be hit. Where there are fewer, the last is loaded again: a
 * branch would cost more. */
DAFT_INLINE vbits blocks_filter(const daft_block *b, int count, int width, const mesh_ray *r)
{
    vf x[3], y[3], z[3];
    size_t at[3];
    for (int k = 0; k < width - 1; k++) at[k] = (size_t)(k + 1 < count ? k + 1 : count - 1) * BLOCK_FLOATS;
    for (int k = 0; k < 3; k++) {
        z[k] = vf_load_spread(b->corner[k][r->axis[2]], at, width) - r->o[2];
        x[k] = vf_load_spread(b->corner[k][r->axis[0]], at, width) - r->o[0] - r->shear_x * z[k];
        y[k] = vf_load_spread(b->corner[k][r->axis[1]], at, width) - r->o[1] - r->shear_y * z[k];
    }
    return daft_filter_pass(x, y, z, r->ahead, r->per_length, r->least) & ((1u << count * DAFT_BLOCK) - 1);
}

/* The blocks b[0..count), count at most `width`. */
DAFT_INLINE bool blocks_touch(const daft_block *b, int count, int width, const mesh_ray *r, daft_nearest *hit)
{
    vbits maybe = r->how == DAFT_INTERSECT_EXACT ? blocks_filter(b, count, width, r) : (1u << count * DAFT_BLOCK) - 1;
    bool any = false;
    for (; maybe; b++, maybe >>= DAFT_BLOCK)
        if (maybe & 15) any |= daft_block_touch(b, maybe & 15, r->origin, r->direction, r->tmin, r->how, hit);
    return any;
}

/* A leaf; `child` is its code. */
DAFT_INLINE bool leaf_touch(const daft_bvh *bvh, uint32_t child, const mesh_ray *r, daft_nearest *hit)
{
    const daft_block *b = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    int count = (int)(child & 3) + 1;
    bool any = false;
    if (FOURS == 4 && count > 2) return blocks_touch(b, count, FOURS, r, hit);
    for (; count > 0; b += PAIR, count -= PAIR) any |= blocks_touch(b, daft_min_i(count, PAIR), PAIR, r, hit);
    return any;
}

/* ---- the lower level: in object space ---- */

/* Below `child`. hit->t limits the search and hit->triangle breaks ties, so the order of traversal does not matter. */
void DAFT_KERNEL(daft_mesh_closest)(const daft_instance *instance, uint32_t child, const daft_ray *ray, daft_intersection how,
                                    daft_nearest *hit)
{
    const daft_bvh *bvh = instance->bvh;
    daft_vec3 o = daft_affine_point(&instance->to_object, ray->origin);
    daft_vec3 d = daft_affine_vector(&instance->to_object, ray->direction);
    if (!daft_finite_lines(o, d)) return;
    ray_stack stack;
    slab_ray slab = slab_setup(o, d, 0, ray->tmin < 0);
    mesh_ray r = mesh_ray_setup(instance->mesh, o, d, ray->tmin, how);
    float limit = daft_past(hit->t);
    v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(limit), near;
    for (int top = 0;;) {
        if (child & DAFT_CHILD_LEAF) {
            if (leaf_touch(bvh, child, &r, hit)) limit = daft_past(hit->t), high = v8_set(limit);
        } else {
            const daft_node *node = &bvh->nodes.items[child];
            uint32_t bits = slab_test(node, &slab, false, low, high, &near);
            if (bits) {
                child = step(node, bits, near, &stack, &top);
                continue;
            }
        }
        do
            if (--top < 0) return;
        while (stack.near[top] > limit);
        child = stack.child[top];
    }
}

bool DAFT_KERNEL(daft_mesh_occluded)(const daft_instance *instance, uint32_t child, const daft_ray *ray, daft_intersection how)
{
    const daft_bvh *bvh = instance->bvh;
    daft_vec3 o = daft_affine_point(&instance->to_object, ray->origin);
    daft_vec3 d = daft_affine_vector(&instance->to_object, ray->direction);
    if (!daft_finite_lines(o, d)) return false;
    ray_stack stack;
    slab_ray slab = slab_setup(o, d, 0, ray->tmin < 0);
    mesh_ray r = mesh_ray_setup(instance->mesh, o, d, ray->tmin, how);
    daft_nearest hit = {.t = ray->tmax, .triangle = DAFT_NO_TRIANGLE};
    v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(daft_past(ray->tmax)), near;
    for (int top = 0;;) {
        if (child & DAFT_CHILD_LEAF) {
            if (leaf_touch(bvh, child, &r, &hit)) return true;
        } else {
            const daft_node *node = &bvh->nodes.items[child];
            uint32_t bits = slab_test(node, &slab, false, low, high, &near);
            if (bits) {
                child = step(node, bits, near, &stack, &top);
                continue;
            }
        }
        if (--top < 0) return false;
        child = stack.child[top];
    }
}

/* ---- the upper level ---- */

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

static void kd_closest(const daft_instance *instance, const daft_ray *ray, daft_intersection how, daft_nearest *hit)
{
    DAFT_KERNEL(daft_kd_closest)(instance->kdtree, daft_affine_point(&instance->to_object, ray->origin),
                                 daft_affine_vector(&instance->to_object, ray->direction), ray->tmin, how, hit);
}

void DAFT_KERNEL(daft_instance_closest)(const daft_tlas *tlas, uint32_t index, const daft_ray *ray, daft_nearest *hit)
{
    const daft_instance *instance = &tlas->instances[index];
    if (instance->mesh) {
        uint32_t triangle = hit->triangle;
        hit->triangle = index < hit->instance ? DAFT_NO_TRIANGLE : 0; /* a tie goes to the lower instance */
        uint32_t before = hit->triangle;
        float t = hit->t;
        if (instance->kdtree) kd_closest(instance, ray, tlas->intersection, hit);
        else DAFT_KERNEL(daft_mesh_closest)(instance, 0, ray, tlas->intersection, hit);
        if (hit->t < t || hit->triangle != before) hit->instance = index;
        else hit->triangle = triangle;
        return;
    }
    float t = sphere_distance(instance, ray, ray->tmin, hit->t);
    if (t < 0 || (t == hit->t && index > hit->instance)) return;
    *hit = (daft_nearest){.t = t, .instance = index};
}

bool DAFT_KERNEL(daft_instance_occluded)(const daft_tlas *tlas, uint32_t index, const daft_ray *ray)
{
    const daft_instance *instance = &tlas->instances[index];
    if (!(instance->flags & DAFT_INSTANCE_CASTS_SHADOW)) return false;
    if (!instance->mesh) return sphere_distance(instance, ray, ray->tmin, ray->tmax) >= 0;
    if (instance->mesh->triangle_count == 0) return false;
    if (instance->kdtree)
        return DAFT_KERNEL(daft_kd_occluded)(instance->kdtree, daft_affine_point(&instance->to_object, ray->origin),
                                             daft_affine_vector(&instance->to_object, ray->direction), ray->tmin, ray->tmax,
                                             tlas->intersection);
    return DAFT_KERNEL(daft_mesh_occluded)(instance, 0, ray, tlas->intersection);
}

static daft_vec3 triangle_normal(const daft_instance *instance, const daft_nearest *hit)
{
    daft_vec3 p[3];
    for (int k = 0; k < 3; k++) {
        uint32_t v = hit->block ? 0 : instance->mesh->indices[3 * (size_t)hit->triangle + (size_t)k];
        daft_vec3 corner = hit->block ? daft_block_corner(hit->block, k, hit->place)
                                      : daft_v3(instance->mesh->x[v], instance->mesh->y[v], instance->mesh->z[v]);
        p[k] = daft_affine_point(&instance->to_frame, corner);
    }
    return daft_cross(daft_sub(p[1], p[0]), daft_sub(p[2], p[0]));
}

bool DAFT_KERNEL(daft_finish_hit)(const daft_tlas *tlas, const daft_ray *ray, const daft_nearest *nearest, daft_hit *hit)
{
    if (nearest->instance == UINT32_MAX) {
        *hit = (daft_hit){.t = ray->tmax, .instance = UINT32_MAX};
        return false;
    }
    const daft_instance *instance = &tlas->instances[nearest->instance];
    *hit = (daft_hit){nearest->t, nearest->u, nearest->v, nearest->instance, nearest->triangle, {0, 0, 0}};
    if (instance->mesh) {
        hit->normal = triangle_normal(instance, nearest);
    } else {
        daft_vec3 centre = daft_v3(instance->to_frame.t[0], instance->to_frame.t[1], instance->to_frame.t[2]);
        hit->normal = daft_sub(daft_add(ray->origin, daft_scale(ray->direction, hit->t)), centre);
    }
    return true;
}

void DAFT_KERNEL(daft_upper_closest)(const daft_tlas *tlas, uint32_t child, const daft_ray *ray, uint32_t ignore,
                                     daft_nearest *hit)
{
    ray_stack stack;
    slab_ray slab = slab_setup_upper(ray);
    v8 low = v8_set(daft_before(ray->tmin)), near;
    for (int top = 0;;) {
        if (child & DAFT_CHILD_LEAF) {
            uint32_t index = child & ~DAFT_CHILD_LEAF;
            if (index != ignore) DAFT_KERNEL(daft_instance_closest)(tlas, index, ray, hit);
        } else {
            const daft_node *node = &tlas->nodes.items[child];
            uint32_t bits = slab_test(node, &slab, true, low, v8_set(daft_past(hit->t)), &near);
            if (bits) {
                child = step(node, bits, near, &stack, &top);
                continue;
            }
        }
        do
            if (--top < 0) return;
        while (stack.near[top] > daft_past(hit->t));
        child = stack.child[top];
    }
}

static bool closest(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_hit *hit)
{
    daft_nearest nearest = {.t = ray->tmax, .instance = UINT32_MAX};
    if (tlas->nodes.count && daft_ray_usable(ray)) DAFT_KERNEL(daft_upper_closest)(tlas, 0, ray, ignore, &nearest);
    return DAFT_KERNEL(daft_finish_hit)(tlas, ray, &nearest, hit);
}

bool DAFT_KERNEL(daft_upper_occluded)(const daft_tlas *tlas, uint32_t child, const daft_ray *ray)
{
    ray_stack stack;
    slab_ray slab = slab_setup_upper(ray);
    v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(daft_past(ray->tmax)), near;
    for (int top = 0;;) {
        if (child & DAFT_CHILD_LEAF) {
            if (DAFT_KERNEL(daft_instance_occluded)(tlas, child & ~DAFT_CHILD_LEAF, ray)) return true;
        } else {
            const daft_node *node = &tlas->nodes.items[child];
            uint32_t bits = slab_test(node, &slab, true, low, high, &near);
            if (bits) {
                child = step(node, bits, near, &stack, &top);
                continue;
            }
        }
        if (--top < 0) return false;
        child = stack.child[top];
    }
}

static bool occluded(const daft_tlas *tlas, const daft_ray *ray)
{
    return tlas->nodes.count && daft_ray_usable(ray) && DAFT_KERNEL(daft_upper_occluded)(tlas, 0, ray);
}

static uint32_t boxes(const daft_node *node, const daft_ray *ray)
{
    slab_ray r = slab_setup(ray->origin, ray->direction, 0, ray->tmin < 0);
    v8 near;
    if (!daft_ray_usable(ray)) return 0;
    uint32_t real = 0xff;
    for (int k = 0; k < 3; k++) real &= v8_le_bits(v8_load(node->bounds[k]), v8_load(node->bounds[k + 3]));
    return real & slab_test(node, &r, false, v8_set(ray->tmin), v8_set(ray->tmax), &near);
}

const daft_accel_kernels DAFT_KERNEL(daft_accel) = {closest,
                                                    occluded,
                                                    DAFT_KERNEL(daft_closest_packet),
                                                    DAFT_KERNEL(daft_occluded_packet),
                                                    DAFT_KERNEL(daft_closest_stream),
                                                    DAFT_KERNEL(daft_occluded_stream),
                                                    boxes};
