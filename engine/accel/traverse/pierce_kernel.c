/* All hits of a ray, not the nearest alone: of shadow rays on their way through surfaces with alpha, where each hit
 * says what passes, or through bodies that transmit, where each leads into another medium. Nodes, blocks and triangles
 * are tested as for any other ray (ray_test.h); leaves are taken whole, in the order of the tree, so that the order of
 * hits is the same on every instruction set. Only single rays, and always by the BVH: what comes of a hit takes longer
 * than finding it. */
#include "accel/traverse/instance_ray.h"

/* A ray on its way. */
typedef struct piercing {
    const daft_tlas *tlas;
    const daft_ray *ray;
    daft_pierced_at *at;
    void *user;
    uint32_t instance;
    const uint8_t *opacity; /* the instance's; NULL: no triangle is left out */
    daft_pierced_leaf *last;
    uint32_t flag, ignore;
} piercing;

static bool tell(const piercing *p, uint32_t triangle, float t, float u, float v)
{
    const daft_pierced hit = {p->instance, triangle, t, daft_unit_clamped(u), daft_unit_clamped(v)};
    return p->at(p->user, &hit);
}

static bool is_clear(const piercing *p, const daft_block *block, uint32_t i)
{
    const uint32_t triangle = block->triangle[i];
    return triangle == DAFT_NO_TRIANGLE || (p->opacity && p->opacity[triangle] == DAFT_OPACITY_CLEAR);
}

static bool blocks_pierce_floats(const piercing *p, const daft_block *b, const vf3 c[3], vbits real,
                                 const daft_mesh_ray *r, float tmax)
{
    daft_lane_hits touch;
    vbits bits = real & daft_intersect_floats(c, vf3_set(r->origin), vf3_set(r->direction), vf_set(r->tmin),
                                              vf_set(tmax), r->how == DAFT_INTERSECT_FAST, &touch);
    for (; bits; bits &= bits - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(bits), i = lane % DAFT_BLOCK;
        const daft_block *block = b + lane / DAFT_BLOCK;
        if (is_clear(p, block, i)) continue;
        if (!tell(p, block->triangle[i], touch.t[lane], touch.v[lane], touch.w[lane])) return false;
    }
    return true;
}

static bool blocks_pierce(const piercing *p, const daft_block *b, int count, const daft_mesh_ray *r, float tmax)
{
    const vbits real = (1u << count * DAFT_BLOCK) - 1; /* what is loaded again answers again */
    vf3 c[3];
    daft_edge_tests sides;
    daft_blocks_load(b, count, c);
    if (r->how != DAFT_INTERSECT_EXACT) return blocks_pierce_floats(p, b, c, real, r, tmax);
    const daft_facet facet = daft_facet_of(c);
    vbits maybe = real & daft_filter_pass(&facet, vf3_set(r->origin), vf3_set(r->direction), vf_set(r->filter.scale),
                                          vf_set(r->filter.floor), vf_set(daft_forward(daft_past(tmax))), &sides);
    if (!maybe) return true;
    const vbits plain = daft_filter_plain(&sides);
    for (; maybe; maybe &= maybe - 1) {
        const uint32_t lane = (uint32_t)__builtin_ctz(maybe), i = lane % DAFT_BLOCK;
        const daft_block *block = b + lane / DAFT_BLOCK;
        daft_exact_hit e;
        if (is_clear(p, block, i)) continue;
        if (plain >> lane & 1 ? !daft_intersect_plain(block, i, r->origin, r->direction, r->tmin, tmax, &e)
                              : !daft_intersect_exact(block, i, r->origin, r->direction, r->tmin, tmax, &e))
            continue;
        if (!tell(p, block->triangle[i], e.t, e.v, e.w)) return false;
    }
    return true;
}

static bool leaf_pierce(const piercing *p, const daft_block *blocks, uint32_t child, const daft_mesh_ray *r, float tmax)
{
    const daft_block *b = &blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    for (int count = (int)(child & 3) + 1; count > 0; b += DAFT_FOURS, count -= DAFT_FOURS)
        if (!blocks_pierce(p, b, daft_min_i(count, DAFT_FOURS), r, tmax)) return false;
    return true;
}

static daft_mesh_ray mesh_ray(const piercing *p, const simd_ray *local)
{
    const v4 o = local->origin, d = local->direction;
    return daft_mesh_ray_of(daft_v3(o[0], o[1], o[2]), daft_v3(d[0], d[1], d[2]), p->ray->tmin, p->ray->tmax,
                            p->tlas->intersection);
}

/* `plain`: as slab_test has it. */
DAFT_INLINE bool tree_pierce(const piercing *p, const daft_bvh *bvh, const simd_ray *local, bool plain)
{
    const daft_ray *ray = p->ray;
    const daft_mesh_ray r = mesh_ray(p, local);
    const slab_origin at = slab_origin_of(local->origin);
    const v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(daft_past(ray->tmax));
    code_stack stack;
    uint32_t *top = stack.items, child = first_child(bvh, 0);
    for (*top++ = DAFT_CHILD_NONE; child != DAFT_CHILD_NONE;) {
        v8 near;
        if (child & DAFT_CHILD_LEAF) {
            if (!leaf_pierce(p, bvh->blocks, child, &r, ray->tmax)) {
                if (p->last) *p->last = (daft_pierced_leaf){p->instance, child};
                return false;
            }
            child = *--top;
            continue;
        }
        const daft_node *node = &bvh->nodes.items[child];
        const uint32_t bits = slab_test((const char *)node, &local->slabs, &at, &at, plain, low, high, &near);
        child = bits ? push_unsorted(node, bits, false, &top) : *--top;
    }
    return true;
}

static __attribute__((noinline)) bool mesh_pierce(const piercing *p, const daft_bvh *bvh, const simd_ray *local)
{
    return p->ray->tmin >= 0 && local->slabs.plain ? tree_pierce(p, bvh, local, true)
                                                   : tree_pierce(p, bvh, local, false);
}

/* Where it comes in and where it goes out. */
static bool sphere_pierce(const piercing *p, const daft_instance *s)
{
    const daft_ray *ray = p->ray;
    const float near = sphere_distance(s, ray, ray->tmin, ray->tmax);
    if (near < 0) return true;
    if (!tell(p, 0, near, 0, 0)) return false;
    const float after = nextafterf(near, INFINITY), far = sphere_distance(s, ray, after, ray->tmax);
    return far < after || tell(p, 0, far, 0, 0);
}

/* The ray in the instance's space. False: it has none there. */
static bool move_ray(const daft_instance *instance, const simd_ray *frame, simd_ray *local)
{
    if (!daft_is_translation(&instance->to_object)) return to_object_space(&instance->to_object, frame, local);
    *local = *frame;
    local->origin = frame->origin + translation_of(&instance->to_object);
    return finite_lanes(local->origin, local->origin);
}

static bool instance_pierce(piercing *p, uint32_t index, const simd_ray *frame)
{
    const daft_instance *instance = &p->tlas->instances[index];
    if (!(instance->flags & p->flag) || index == p->ignore) return true;
    p->instance = index, p->opacity = p->flag == DAFT_INSTANCE_FILTERS_SHADOW ? instance->opacity : NULL;
    if (!instance->mesh) return sphere_pierce(p, instance);
    if (instance->mesh->triangle_count == 0) return true;
    simd_ray local = *frame;
    return !move_ray(instance, frame, &local) || mesh_pierce(p, instance->bvh, &local);
}

bool DAFT_KERNEL(daft_pierce_leaf)(const daft_tlas *tlas, const daft_ray *ray, const daft_pierced_leaf *leaf,
                                   daft_pierced_at *at, void *user)
{
    if (leaf->instance == DAFT_NO_LEAF || !daft_ray_usable(ray)) return false;
    const daft_instance *instance = &tlas->instances[leaf->instance];
    const piercing p = {
        .tlas = tlas, .ray = ray, .at = at, .user = user, .instance = leaf->instance, .opacity = instance->opacity};
    const simd_ray frame = simd_ray_of(ray);
    simd_ray local = frame;
    if (!move_ray(instance, &frame, &local)) return false;
    const daft_mesh_ray r = mesh_ray(&p, &local);
    return !leaf_pierce(&p, instance->bvh->blocks, leaf->child, &r, ray->tmax);
}

void DAFT_KERNEL(daft_pierce)(const daft_tlas *tlas, const daft_ray *ray, uint32_t flag, uint32_t ignore,
                              daft_pierced_at *at, void *user, daft_pierced_leaf *last)
{
    if (tlas->nodes.count == 0 || !daft_ray_usable(ray)) return;
    piercing p = {.tlas = tlas, .ray = ray, .at = at, .user = user, .last = last, .flag = flag, .ignore = ignore};
    const simd_ray frame = simd_ray_of(ray);
    slab_origin from, until;
    slab_upper_origins(frame.origin, frame.direction, &from, &until);
    const v8 low = v8_set(daft_before(ray->tmin)), high = v8_set(daft_past(ray->tmax));
    code_stack stack;
    uint32_t *top = stack.items, child = 0;
    for (*top++ = DAFT_CHILD_NONE; child != DAFT_CHILD_NONE;) {
        v8 near;
        if (child & DAFT_CHILD_LEAF) {
            if (!instance_pierce(&p, child & ~DAFT_CHILD_LEAF, &frame)) return;
            child = *--top;
            continue;
        }
        const daft_node *node = &tlas->nodes.items[child];
        const uint32_t bits = slab_test((const char *)node, &frame.slabs, &from, &until, false, low, high, &near);
        child = bits ? push_unsorted(node, bits, false, &top) : *--top;
    }
}
