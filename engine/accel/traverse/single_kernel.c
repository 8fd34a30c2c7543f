/* Single rays through both levels, and from any node or instance downwards for packets that fall apart into single
 * rays. A mesh that is only translated keeps the ray's direction and its inverse. */
#include "accel/traverse/instance_ray.h"
#include "accel/kdtree.h"

/* A leaf; `child` is its code. Called, so that nodes keep their registers. */
DAFT_INLINE bool leaf_intersect(const daft_block *blocks, uint32_t child, const daft_mesh_ray *r, float past,
                                daft_nearest *hit, bool any)
{
    const daft_block *b = &blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    int count = (int)(child & 3) + 1;
    bool found = false;
    if ((int)DAFT_FOURS == (int)DAFT_MAX_LEAF_BLOCKS) return daft_blocks_intersect(b, count, r, past, hit, any);
    for (; count > 0 && !(any && found); b += DAFT_FOURS, count -= DAFT_FOURS)
        found |= daft_blocks_intersect(b, daft_min_i(count, DAFT_FOURS), r, past, hit, any);
    return found;
}

bool DAFT_KERNEL(daft_leaf_closest)(const daft_block *blocks, uint32_t child, const daft_mesh_ray *r, float past,
                                    daft_nearest *hit)
{
    return leaf_intersect(blocks, child, r, past, hit, false);
}

bool DAFT_KERNEL(daft_leaf_stops)(const daft_block *blocks, uint32_t child, const daft_mesh_ray *r, float past,
                                  daft_nearest *hit)
{
    return leaf_intersect(blocks, child, r, past, hit, true);
}

DAFT_INLINE daft_vec3 v4_point(v4 a) { return (daft_vec3){a[0], a[1], a[2]}; }

/* ---- the lower level: in object space ---- */

/* slabs: of the direction d. */
static __attribute__((noinline)) void mesh_closest(const daft_bvh *bvh, uint32_t child, v4 o, v4 d,
                                                   const slab_direction *slabs, float tmin, daft_intersection how,
                                                   daft_nearest *hit)
{
    daft_mesh_ray r = daft_mesh_ray_of(v4_point(o), v4_point(d), tmin, hit->t, how);
    slab_origin at = slab_origin_of(o);
    child = first_child(bvh, child);
    if (child & DAFT_CHILD_LEAF)
        DAFT_KERNEL(daft_leaf_closest)(bvh->blocks, child, &r, daft_forward(daft_past(hit->t)), hit);
    else if (tmin >= 0 && slabs->plain)
        mesh_traverse(bvh, child, slabs, &r, &at, true, hit);
    else
        mesh_traverse(bvh, child, slabs, &r, &at, false, hit);
}

static __attribute__((noinline)) bool mesh_occluded(const daft_bvh *bvh, uint32_t child, v4 o, v4 d,
                                                    const slab_direction *slabs, float tmin, float tmax,
                                                    daft_intersection how)
{
    daft_nearest hit = {.t = tmax, .triangle = DAFT_NO_TRIANGLE};
    daft_mesh_ray r = daft_mesh_ray_of(v4_point(o), v4_point(d), tmin, tmax, how);
    slab_origin at = slab_origin_of(o);
    child = first_child(bvh, child);
    if (child & DAFT_CHILD_LEAF)
        return DAFT_KERNEL(daft_leaf_stops)(bvh->blocks, child, &r, daft_forward(daft_past(tmax)), &hit);
    if (tmin >= 0 && slabs->plain) return mesh_any_hit(bvh, child, slabs, &r, &at, true, &hit);
    return mesh_any_hit(bvh, child, slabs, &r, &at, false, &hit);
}

/* Through an instance's mesh. A mesh that is only shifted keeps the direction. */
DAFT_INLINE void instance_mesh_closest(const daft_instance *instance, uint32_t child, const simd_ray *frame, float tmin,
                                       daft_intersection how, daft_nearest *hit)
{
    simd_ray local;
    if (daft_is_translation(&instance->to_object)) {
        v4 o = frame->origin + translation_of(&instance->to_object);
        if (finite_lanes(o, o)) mesh_closest(instance->bvh, child, o, frame->direction, &frame->slabs, tmin, how, hit);
    } else if (to_object_space(&instance->to_object, frame, &local)) {
        mesh_closest(instance->bvh, child, local.origin, local.direction, &local.slabs, tmin, how, hit);
    }
}

DAFT_INLINE bool instance_mesh_occluded(const daft_instance *instance, uint32_t child, const simd_ray *frame,
                                        float tmin, float tmax, daft_intersection how)
{
    simd_ray local;
    if (daft_is_translation(&instance->to_object)) {
        v4 o = frame->origin + translation_of(&instance->to_object);
        return finite_lanes(o, o) &&
               mesh_occluded(instance->bvh, child, o, frame->direction, &frame->slabs, tmin, tmax, how);
    }
    return to_object_space(&instance->to_object, frame, &local) &&
           mesh_occluded(instance->bvh, child, local.origin, local.direction, &local.slabs, tmin, tmax, how);
}

void DAFT_KERNEL(daft_mesh_closest)(const daft_instance *instance, uint32_t child, const daft_ray *ray,
                                    daft_intersection how, daft_nearest *hit)
{
    simd_ray frame = simd_ray_of(ray);
    instance_mesh_closest(instance, child, &frame, ray->tmin, how, hit);
}

bool DAFT_KERNEL(daft_mesh_occluded)(const daft_instance *instance, uint32_t child, const daft_ray *ray,
                                     daft_intersection how)
{
    simd_ray frame = simd_ray_of(ray);
    return instance_mesh_occluded(instance, child, &frame, ray->tmin, ray->tmax, how);
}

/* ---- the upper level ---- */

static void kd_closest(const daft_instance *instance, const daft_ray *ray, daft_intersection how, daft_nearest *hit)
{
    DAFT_KERNEL(daft_kd_closest)
    (instance->kdtree, daft_affine_point(&instance->to_object, ray->origin),
     daft_affine_vector(&instance->to_object, ray->direction), ray->tmin, how, hit);
}

/* `frame`: the ray. */
DAFT_INLINE void instance_closest(const daft_tlas *tlas, uint32_t index, const daft_ray *ray, const simd_ray *frame,
                                  daft_nearest *hit)
{
    const daft_instance *instance = &tlas->instances[index];
    if (instance->mesh) {
        uint32_t triangle = hit->triangle;
        hit->triangle = index < hit->instance ? DAFT_NO_TRIANGLE : 0; /* a tie goes to the lower instance */
        uint32_t before = hit->triangle;
        float t = hit->t;
        if (instance->kdtree)
            kd_closest(instance, ray, tlas->intersection, hit);
        else
            instance_mesh_closest(instance, 0, frame, ray->tmin, tlas->intersection, hit);
        if (hit->t < t || hit->triangle != before)
            hit->instance = index;
        else
            hit->triangle = triangle;
        return;
    }
    float t = sphere_distance(instance, ray, ray->tmin, hit->t);
    if (t < 0 || (t == hit->t && index > hit->instance)) return;
    *hit = (daft_nearest){.t = t, .instance = index};
}

DAFT_INLINE bool instance_occluded(const daft_tlas *tlas, uint32_t index, const daft_ray *ray, const simd_ray *frame)
{
    const daft_instance *instance = &tlas->instances[index];
    if (!(instance->flags & DAFT_INSTANCE_CASTS_SHADOW)) return false;
    if (!instance->mesh) return sphere_distance(instance, ray, ray->tmin, ray->tmax) >= 0;
    if (instance->mesh->triangle_count == 0) return false;
    if (instance->kdtree)
        return DAFT_KERNEL(daft_kd_occluded)(instance->kdtree, daft_affine_point(&instance->to_object, ray->origin),
                                             daft_affine_vector(&instance->to_object, ray->direction), ray->tmin,
                                             ray->tmax, tlas->intersection);
    return instance_mesh_occluded(instance, 0, frame, ray->tmin, ray->tmax, tlas->intersection);
}

void DAFT_KERNEL(daft_instance_closest)(const daft_tlas *tlas, uint32_t index, const daft_ray *ray, daft_nearest *hit)
{
    simd_ray frame = simd_ray_of(ray);
    instance_closest(tlas, index, ray, &frame, hit);
}

bool DAFT_KERNEL(daft_instance_occluded)(const daft_tlas *tlas, uint32_t index, const daft_ray *ray)
{
    simd_ray frame = simd_ray_of(ray);
    return instance_occluded(tlas, index, ray, &frame);
}

static daft_vec3 triangle_normal(const daft_instance *instance, const daft_nearest *hit)
{
    const daft_affine *map = &instance->to_frame;
    bool shift = daft_is_translation(map);
    daft_vec3 p[3];
    for (int k = 0; k < 3; k++) {
        uint32_t v = hit->block ? 0 : instance->mesh->indices[3 * (size_t)hit->triangle + (size_t)k];
        daft_vec3 corner = hit->block ? daft_block_corner(hit->block, k, hit->place)
                                      : daft_v3(instance->mesh->x[v], instance->mesh->y[v], instance->mesh->z[v]);
        p[k] = shift ? daft_add(corner, daft_v3(map->t[0], map->t[1], map->t[2])) : daft_affine_point(map, corner);
    }
    return daft_cross(daft_sub(p[1], p[0]), daft_sub(p[2], p[0]));
}

/* From the nearest hit to what callers get. */
static bool finish_hit(const daft_tlas *tlas, const daft_ray *ray, const daft_nearest *nearest, daft_hit *hit)
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

DAFT_INLINE void upper_closest(const daft_tlas *tlas, uint32_t child, const daft_ray *ray, uint32_t ignore,
                               daft_nearest *hit)
{
    ray_stack stack;
    uint64_t *top = stack.items;
    *top++ = STACK_END;
    simd_ray frame = simd_ray_of(ray);
    const tree_place tree = {tlas->nodes.items, tlas->instances, sizeof *tlas->instances, 0};
    slab_origin from, until;
    slab_upper_origins(frame.origin, frame.direction, &from, &until);
    bool plain = ray->tmin >= 0 && frame.slabs.plain;
    const sphere_view view = sphere_view_of(frame.origin, frame.direction, plain);
    const uint32_t spheres = view.usual ? 0xff : 0;
    float limit = daft_past(hit->t);
    v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(limit), near;
    for (;;) {
        if (child & DAFT_CHILD_LEAF) {
            if (child == DAFT_CHILD_NONE) return;
            uint32_t index = child & ~DAFT_CHILD_LEAF;
            if (index != ignore) {
                instance_closest(tlas, index, ray, &frame, hit);
                limit = daft_past(hit->t), high = v8_set(limit);
            }
        } else {
            const daft_node *node = &tlas->nodes.items[child];
            uint32_t bits = slab_test((const char *)node, &frame.slabs, &from, &until, plain, low, high, &near);
            if (node->spheres & spheres) { /* asked of the node alone: it is known before the bits are */
                node_spheres sight = node_spheres_of(node, &view);
                bits = spheres_met(node, bits, &sight, &view);
            }
            if (bits) {
                child = push_sorted(&tree, node, bits, near, &top);
                continue;
            }
        }
        child = pop(&top, limit);
    }
}

void DAFT_KERNEL(daft_upper_closest)(const daft_tlas *tlas, uint32_t child, const daft_ray *ray, uint32_t ignore,
                                     daft_nearest *hit)
{
    upper_closest(tlas, child, ray, ignore, hit);
}

/* ---- a top level of one node: up to eight instances ---- */

/* The nearest or the furthest of the instances in bits, 1 or more; clears its bit. Of the first two it is chosen by a
 * branch, not a look-up: a predicted branch starts on the mesh before the boxes are tested. */
DAFT_INLINE uint32_t next_instance(const daft_node *node, uint32_t *bits, const float near[DAFT_WIDTH], bool furthest)
{
    uint32_t at = (uint32_t)__builtin_ctz(*bits), child;
    for (uint32_t left = *bits & (*bits - 1); left; left &= left - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(left);
        if (furthest ? near[i] > near[at] : near[i] < near[at]) at = i;
    }
    *bits &= ~(1u << at);
    if (at > 1) return node->child[at] & ~DAFT_CHILD_LEAF;
    if (at == 0)
        child = node->child[0];
    else
        child = node->child[1];
    __asm__("" : "+r"(child)); /* or the compiler makes a look-up of it again */
    return child & ~DAFT_CHILD_LEAF;
}

/* The instances whose boxes the ray meets, and where it enters them. */
DAFT_INLINE uint32_t root_children(const daft_tlas *tlas, const daft_ray *ray, const simd_ray *frame,
                                   float near[DAFT_WIDTH])
{
    slab_origin from, until;
    slab_upper_origins(frame->origin, frame->direction, &from, &until);
    v8 enter;
    uint32_t bits =
        slab_test((const char *)tlas->nodes.items, &frame->slabs, &from, &until, ray->tmin >= 0 && frame->slabs.plain,
                  v8_set(daft_before(ray->tmin)), v8_set(daft_past(ray->tmax)), &enter);
    v8_store(near, enter);
    /* origins so large that they overflow meet even boxes that are empty */
    return bits & v8_le_bits(v8_load(tlas->nodes.items->bounds[0]), v8_load(tlas->nodes.items->bounds[3]));
}

DAFT_INLINE void root_closest(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_nearest *hit)
{
    simd_ray frame = simd_ray_of(ray);
    float near[DAFT_WIDTH] __attribute__((aligned(32)));
    uint32_t bits = root_children(tlas, ray, &frame, near);
    while (bits) {
        uint32_t before = bits, index = next_instance(tlas->nodes.items, &bits, near, false);
        if (near[__builtin_ctz(before ^ bits)] > daft_past(hit->t)) return;
        if (index != ignore) instance_closest(tlas, index, ray, &frame, hit);
    }
}

/* The furthest first: what a ray leaves it seldom meets again, and ground below stops it soon. */
DAFT_INLINE bool root_occluded(const daft_tlas *tlas, const daft_ray *ray)
{
    simd_ray frame = simd_ray_of(ray);
    float near[DAFT_WIDTH] __attribute__((aligned(32)));
    uint32_t bits = root_children(tlas, ray, &frame, near);
    while (bits)
        if (instance_occluded(tlas, next_instance(tlas->nodes.items, &bits, near, true), ray, &frame)) return true;
    return false;
}

static bool closest(const daft_tlas *tlas, const daft_ray *ray, uint32_t ignore, daft_hit *hit)
{
    daft_nearest nearest = {.t = ray->tmax, .instance = UINT32_MAX};
    if (tlas->nodes.count && daft_ray_usable(ray)) {
        if (tlas->nodes.count == 1)
            root_closest(tlas, ray, ignore, &nearest);
        else
            upper_closest(tlas, 0, ray, ignore, &nearest);
    }
    return finish_hit(tlas, ray, &nearest, hit);
}

enum { FAR_APART = 20000 /* instances, more than caches near the core hold */ };

DAFT_INLINE bool any_casts_shadow(const daft_tlas *tlas, const daft_node *node, uint32_t bits)
{
    for (; bits; bits &= bits - 1)
        if (tlas->instances[node->child[__builtin_ctz(bits)] & ~DAFT_CHILD_LEAF].flags & DAFT_INSTANCE_CASTS_SHADOW)
            return true;
    return false;
}

/* In the order of the tree, where what is low, as ground is, stands first. Sorting would take more time than it saves,
 * and the nearest are the last to stop a ray that leaves one of them. far_apart: what is put aside is fetched at once.
 */
DAFT_INLINE bool upper_any_hit(const daft_tlas *tlas, uint32_t child, const daft_ray *ray, bool far_apart)
{
    code_stack stack;
    uint32_t *top = stack.items;
    *top++ = DAFT_CHILD_NONE;
    simd_ray frame = simd_ray_of(ray);
    const tree_place tree = {tlas->nodes.items, tlas->instances, sizeof *tlas->instances, 0};
    slab_origin from, until;
    slab_upper_origins(frame.origin, frame.direction, &from, &until);
    bool plain = ray->tmin >= 0 && frame.slabs.plain;
    const sphere_view view = sphere_view_of(frame.origin, frame.direction, plain);
    const uint32_t spheres = view.usual ? 0xff : 0;
    v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(daft_past(ray->tmax)), near;
    for (;;) {
        while (!(child & DAFT_CHILD_LEAF)) {
            const daft_node *node = &tlas->nodes.items[child];
            uint32_t bits = slab_test((const char *)node, &frame.slabs, &from, &until, plain, low, high, &near);
            if (node->spheres & spheres) {
                node_spheres sight = node_spheres_of(node, &view);
                if (any_casts_shadow(tlas, node, spheres_pierced(node, &sight, &view, ray->tmin, ray->tmax)))
                    return true;
                bits = spheres_met(node, bits, &sight, &view);
            }
            uint32_t *base = top;
            child = bits ? push_unsorted(node, bits, false, &top) : *--top;
            for (; far_apart && base < top; base++) fetch(&tree, *base);
        }
        if (child == DAFT_CHILD_NONE) return false;
        if (instance_occluded(tlas, child & ~DAFT_CHILD_LEAF, ray, &frame)) return true;
        child = *--top;
    }
}

static __attribute__((noinline)) bool far_occluded(const daft_tlas *tlas, uint32_t child, const daft_ray *ray)
{
    return upper_any_hit(tlas, child, ray, true);
}

DAFT_INLINE bool upper_occluded(const daft_tlas *tlas, uint32_t child, const daft_ray *ray)
{
    return tlas->instance_count > FAR_APART ? far_occluded(tlas, child, ray) : upper_any_hit(tlas, child, ray, false);
}

bool DAFT_KERNEL(daft_upper_occluded)(const daft_tlas *tlas, uint32_t child, const daft_ray *ray)
{
    return upper_occluded(tlas, child, ray);
}

static bool occluded(const daft_tlas *tlas, const daft_ray *ray)
{
    if (tlas->nodes.count == 0 || !daft_ray_usable(ray)) return false;
    return tlas->nodes.count == 1 ? root_occluded(tlas, ray) : upper_occluded(tlas, 0, ray);
}

static uint32_t boxes(const daft_node *node, const daft_ray *ray)
{
    if (!daft_ray_usable(ray)) return 0;
    simd_ray line = simd_ray_of(ray);
    slab_origin o = slab_origin_of(line.origin);
    v8 near;
    uint32_t real = 0xff;
    for (int k = 0; k < 3; k++) real &= v8_le_bits(v8_load(node->bounds[k]), v8_load(node->bounds[k + 3]));
    return real &
           slab_test((const char *)node, &line.slabs, &o, &o, false, v8_set(ray->tmin), v8_set(ray->tmax), &near);
}

const daft_accel_kernels DAFT_KERNEL(daft_accel) = {closest,
                                                    occluded,
                                                    DAFT_KERNEL(daft_closest_packet),
                                                    DAFT_KERNEL(daft_occluded_packet),
                                                    DAFT_KERNEL(daft_closest_stream),
                                                    DAFT_KERNEL(daft_closest_arrays),
                                                    DAFT_KERNEL(daft_occluded_stream),
                                                    DAFT_KERNEL(daft_pierce),
                                                    DAFT_KERNEL(daft_pierce_leaf),
                                                    boxes,
                                                    DAFT_KERNEL(daft_bound_all)};
