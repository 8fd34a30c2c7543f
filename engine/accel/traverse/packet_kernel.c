/* Packet traversal of both levels. Callers bring up to sixteen rays. They are cut into packets of DAFT_VL
 * rays, and these by the signs of their directions, so that all rays of a packet enter boxes by the same planes.
 * A lane is a ray.
 *
 * A node's eight boxes are tested against the whole packet first, as an interval of origins and of inverse directions
 * (Boulos et al., "Geometric and Arithmetic Culling Methods for Entire Ray Packets", 2006). Rounding is monotonic, so
 * the interval's ends, computed as for one ray, bound every ray's own result. The children that remain are tested ray
 * by ray, with the arithmetic of single rays. When few rays of the packet remain, each continues as a single ray
 * (Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC
 * Architecture", 2012). Hits do not depend on any of this: see "Order" in ray_test.h. */
#include "accel/traverse/packet.h"

#define WIDEN (1 + 8 * DAFT_ULP)
/* So many rays of a packet, or fewer, continue as single rays: among instances, and in a mesh, where leaves are cheap.
 */
enum { SINGLE_RAYS = DAFT_VL / 4 + 1, SINGLE_IN_MESH = 1, ROW = sizeof(((daft_node *)0)->bounds[0]) };

typedef struct packet_stack {
    vf near[DAFT_STACK]; /* NaN: not met */
    uint32_t child[DAFT_STACK];
} packet_stack;

DAFT_INLINE int count_lanes(vbits bits) { return __builtin_popcount(bits); }

DAFT_INLINE float max_limit(vf limit, vbits bits)
{
    return vf_reduce_max(vf_if_then_else(vm_from_bits(bits), limit, vf_set(-INFINITY)));
}

/* The least lanes of four, of those in m. */
DAFT_INLINE v4 min_lanes(vm m, vf a, vf b, vf c, vf d)
{
    vf none = vf_set(INFINITY);
    return v4_reduce_min4(vf_if_then_else(m, a, none), vf_if_then_else(m, b, none), vf_if_then_else(m, c, none),
                          vf_if_then_else(m, d, none));
}

/* inverse: one over the direction. */
static void slabs_setup(packet_slabs *g, vf3 o, const vf inverse[3], vf pad, vf tmin)
{
    const vf from[3] = {o.x, o.y, o.z};
    for (int k = 0; k < 3; k++) {
        vf outwards = (vf)((vi)pad | ((vi)inverse[k] & vi_set(INT32_MIN)));
        g->inverse[k] = inverse[k], g->wide[k] = inverse[k] * vf_set(WIDEN);
        g->near[k] = from[k] + outwards, g->far[k] = from[k] - outwards;
    }
    g->low = tmin * vf_set(1 - 0x1p-17f); /* daft_before, of no negative number */
    g->mixed = true, g->tight = false;
}

/* All rays have the signs of the first of `bits`: they enter and leave boxes by the same planes. */
static void slabs_rows(packet_slabs *g, vbits bits)
{
    for (int k = 0; k < 3; k++) {
        bool back = signbit(g->inverse[k][first_lane(bits)]);
        g->near_row[k] = (size_t)(back ? 3 + k : k) * ROW, g->far_row[k] = (size_t)(back ? k : 3 + k) * ROW;
    }
    g->mixed = false;
}

/* The interval that holds all rays in `bits`; it pays from a few boxes on. */
static void slabs_interval(packet_slabs *g, vf limit, vbits bits)
{
    vi minus[3];
    v4i sign;
    vm m = vm_from_bits(bits);
    for (int k = 0; k < 3; k++) sign[k] = g->near_row[k] > g->far_row[k] ? INT32_MIN : 0, minus[k] = vi_set(sign[k]);
    sign[3] = INT32_MIN;
    /* along the way, the largest of near and the least of far */
    v4 most = min_lanes(m, vf_xor(-g->near[0], minus[0]), vf_xor(-g->near[1], minus[1]), vf_xor(-g->near[2], minus[2]),
                        g->low);
    v4 least =
        min_lanes(m, vf_xor(g->far[0], minus[0]), vf_xor(g->far[1], minus[1]), vf_xor(g->far[2], minus[2]), g->low);
    g->near_end = -(v4)((v4i)most ^ sign), g->far_end = (v4)((v4i)least ^ sign);
    g->inverse_ends[0] = min_lanes(m, g->inverse[0], g->inverse[1], g->inverse[2], g->low);
    g->inverse_ends[1] = -min_lanes(m, -g->inverse[0], -g->inverse[1], -g->inverse[2], g->low);
    for (int e = 0; e < 2; e++) g->wide_ends[e] = g->inverse_ends[e] * v4_set(WIDEN);
    v4 none = (g->wide_ends[0] - g->wide_ends[0]) + (g->wide_ends[1] - g->wide_ends[1]);
    g->tight = (v4_bits_from_mask(none == v4_set(0)) & 7) == 7;
    g->most = max_limit(limit, bits);
}

/* Bits of the children that some ray may meet; their smallest entry distances in *near. */
DAFT_INLINE uint32_t interval_test(const daft_node *node, const packet_slabs *g, v8 *near)
{
    const char *at = (const char *)node->bounds;
    v8 enter = v8_set(g->near_end[3]), leave = v8_set(g->most);
    for (int k = 0; k < 3; k++) {
        v8 a = v8_load((const float *)(at + g->near_row[k])) - v8_set(g->near_end[k]);
        v8 b = v8_load((const float *)(at + g->far_row[k])) - v8_set(g->far_end[k]);
        enter = v8_max(v8_min(a * v8_set(g->inverse_ends[0][k]), a * v8_set(g->inverse_ends[1][k])), enter);
        leave = v8_min(v8_max(b * v8_set(g->wide_ends[0][k]), b * v8_set(g->wide_ends[1][k])), leave);
    }
    *near = enter;
    return v8_le_bits(enter, leave);
}

DAFT_INLINE uint32_t children_of(const daft_node *node)
{
    v8i child;
    memcpy(&child, node->child, sizeof child);
    return v8_bits_from_mask(child != (int32_t)DAFT_CHILD_NONE);
}

/* The rays that meet one child. */
DAFT_INLINE vm child_test(const daft_node *node, uint32_t child, const packet_slabs *g, vf limit, vf *near)
{
    const char *at = (const char *)&node->bounds[0][child];
    vf enter = g->low, leave = limit;
    if (g->mixed) {
        for (int k = 2; k >= 0; k--) {
            vf low = vf_set(node->bounds[k][child]), high = vf_set(node->bounds[3 + k][child]);
            vm back = vi_lt((vi)g->inverse[k], vi_set(0));
            enter = vf_max((vf_if_then_else(back, high, low) - g->near[k]) * g->inverse[k], enter);
            leave = vf_min((vf_if_then_else(back, low, high) - g->far[k]) * g->wide[k], leave);
        }
        *near = enter;
        return vf_le(enter, leave);
    }
    for (int k = 2; k >= 0; k--) { /* vf_max and vf_min give their second argument when the first is NaN */
        enter = vf_max((vf_set(*(const float *)(at + g->near_row[k])) - g->near[k]) * g->inverse[k], enter);
        leave = vf_min((vf_set(*(const float *)(at + g->far_row[k])) - g->far[k]) * g->wide[k], leave);
    }
    *near = enter;
    return vf_le(enter, leave);
}

/* What sphere_test needs of the rays. Where numbers may overflow, all spheres are met. */
DAFT_INLINE void sphere_view(packet *c)
{
    vf size = vf3_magnitude(c->d), far = vf3_magnitude(c->o) * vf_set(2);
    vm usual = vm_and(vm_and(vf_lt(vf_set(0x1p-26f), size), vf_lt(size, vf_set(0x1p26f))),
                      vf_lt(far, vf_set(DAFT_SPHERE_FAR)));
    c->dd = vf3_dot(c->d, c->d), c->off = vf_if_then_else(usual, far * vf_set(DAFT_SPHERE_OFF), vf_set(INFINITY));
}

/* The rays that may hit one child, a sphere: spheres_met of single_kernel.c in lanes. */
DAFT_INLINE vbits sphere_test(const daft_node *node, uint32_t child, const packet *c)
{
    float low = node->bounds[0][child], high = node->bounds[3][child], r = high - low;
    vf x = vf_set(low + high) - (c->o.x + c->o.x),
       y = vf_set(node->bounds[1][child] + node->bounds[4][child]) - (c->o.y + c->o.y),
       z = vf_set(node->bounds[2][child] + node->bounds[5][child]) - (c->o.z + c->o.z);
    vf3 to = {x, y, z}, aside = vf3_cross(to, c->d);
    vf reach = vf_set(r) + (vf3_magnitude(to) + vf_set(r)) * vf_set(DAFT_SPHERE_OFF) + c->off, square = reach * reach,
       tiny = vf_set(DAFT_TINY);
    vm beside = vf_lt(square * c->dd + tiny, vf3_dot(aside, aside));
    vm behind = vm_and(vf_lt(vf3_dot(to, c->d), vf_set(0)), vf_lt(square + tiny, vf3_dot(to, to)));
    return ~vbits_from_mask(vm_or(beside, behind));
}

/* Prefetches a child that is pushed. */
DAFT_INLINE void fetch(const packet_slabs *g, uint32_t child)
{
    size_t leaf = (child & ~DAFT_CHILD_LEAF) >> g->leaf_shift;
    const char *at =
        child & DAFT_CHILD_LEAF ? (const char *)g->leaves + leaf * g->leaf_size : (const char *)&g->nodes[child];
    for (size_t i = 0; i < sizeof(daft_node); i += 64) __builtin_prefetch(at + i);
}

/* Of a node's children that rays meet the nearest, or none, and *here the rays; the others go on the stack, the nearest
 * on top. */
static uint32_t descend(packet_stack *stack, int *top, const packet_slabs *g, uint32_t number, vf limit, vbits bits,
                        vbits *here)
{
    const daft_node *node = &g->nodes[number];
    float at[DAFT_WIDTH], order[DAFT_WIDTH], nearest = 0;
    uint32_t children = children_of(node), first = DAFT_CHILD_NONE;
    vf first_near = limit;
    if (g->tight) {
        v8 near;
        children &= interval_test(node, g, &near);
        v8_store(at, near);
    }
    for (int base = *top; children; children &= children - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(children), child = node->child[i];
        vf near;
        vbits met = vbits_from_mask(child_test(node, i, g, limit, &near)) & bits;
        if (met && node->spheres >> i & 1) met &= sphere_test(node, i, g->rays);
        if (!met) continue;
        float distance = g->tight ? at[i] : near[first_lane(met)];
        near = vf_if_then_else(vm_from_bits(met), near, vf_set(NAN));
        if (first == DAFT_CHILD_NONE) {
            first = child, nearest = distance, first_near = near, *here = met;
            continue;
        }
        if (distance < nearest) {
            vf far = first_near;
            float further = nearest;
            uint32_t other = first;
            first = child, nearest = distance, first_near = near, *here = met;
            child = other, distance = further, near = far;
        }
        int place = (*top)++;
        for (; place > base && order[place - base - 1] < distance; place--) {
            order[place - base] = order[place - base - 1];
            stack->near[place] = stack->near[place - 1], stack->child[place] = stack->child[place - 1];
        }
        order[place - base] = distance;
        stack->near[place] = near, stack->child[place] = child;
        fetch(g, child);
    }
    return first;
}

/* The next child that some of the rays in `bits` still ask for. False: there is none. */
DAFT_INLINE bool next_child(const packet_stack *stack, int *top, vf limit, vbits bits, uint32_t *child, vbits *here)
{
    while (--*top >= 0) {
        *here = vbits_from_mask(vf_le(stack->near[*top], limit)) & bits;
        *child = stack->child[*top];
        if (*here) return true;
    }
    return false;
}

/* x - x is 0 for finite x and NaN for others. */
DAFT_INLINE vm finite_lanes(vf3 o, vf3 d)
{
    vf sum = (o.x - o.x) + (o.y - o.y) + (o.z - o.z) + (d.x - d.x) + (d.y - d.y) + (d.z - d.z);
    return vf_le(sum, vf_set(0));
}

/* ---- the lower level ---- */

/* daft_filter_of */
static void mesh_packet_setup(mesh_packet *m, const packet *c)
{
    vf size = vf3_magnitude(m->d), zero = vf_set(0);
    vm usual = vm_and(vf_lt(vf_set(0x1p-26f), size), vf_lt(size, vf_set(0x1p26f)));
    m->scale = vf_if_then_else(usual, size * vf_set(22 * DAFT_ULP), vf_set(INFINITY));
    m->floor = vf_if_then_else(vf_le(zero, c->tmin), vf_set(-DAFT_TINY), vf_set(-INFINITY));
}

/* The rays in `bits` continue from `child` as single rays. */
static void mesh_single(packet *c, const mesh_packet *m, uint32_t child, vbits bits)
{
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        daft_ray ray = lane_ray(c, i);
        if (c->any) {
            if (DAFT_KERNEL(daft_mesh_occluded)(m->instance, child, &ray, c->tlas->intersection))
                mark_occluded(c, (vbits)1 << i);
            continue;
        }
        daft_nearest n = {.t = c->hit.t[i],
                          .triangle = c->hit.triangle[i],
                          .instance = c->hit.instance[i],
                          .u = c->hit.u[i],
                          .v = c->hit.v[i]};
        DAFT_KERNEL(daft_mesh_closest)(m->instance, child, &ray, c->tlas->intersection, &n);
        lane_store(c, i, &n, m->instance->bvh);
    }
}

static void mesh_traverse(packet *c, const mesh_packet *m, packet_slabs *g, vbits bits)
{
    packet_stack stack;
    int top = 0;
    vbits here = bits;
    const daft_bvh *bvh = m->instance->bvh;
    g->rays = c, g->nodes = bvh->nodes.items, g->leaves = bvh->blocks, g->leaf_size = sizeof *bvh->blocks,
    g->leaf_shift = 2;
    uint32_t child = 0;
    do {
        while (!(child & DAFT_CHILD_LEAF) && count_lanes(here) > SINGLE_IN_MESH)
            child = descend(&stack, &top, g, child, c->limit, here, &here);
        if (child == DAFT_CHILD_NONE) continue;
        if (count_lanes(here) <= SINGLE_IN_MESH)
            mesh_single(c, m, child, here);
        else if (DAFT_KERNEL(daft_packet_leaf)(c, m, g, child, here))
            g->most = max_limit(c->limit, bits);
    } while (next_child(&stack, &top, c->limit, bits, &child, &here));
}

/* ---- the upper level ---- */

/* The lanes of `bits` whose directions have the signs of the first of them. */
static vbits same_octant(vf3 d, vbits bits)
{
    vi sign = vi_set(INT32_MIN);
    vi octant =
        ((vi)d.x & sign) ^ (((vi)d.y & sign) >> 1 & vi_set(0x40000000)) ^ (((vi)d.z & sign) >> 2 & vi_set(0x20000000));
    return bits & vbits_from_mask(vi_eq(octant, vi_set(octant[first_lane(bits)])));
}

static void instance_single(packet *c, uint32_t index, vbits bits)
{
    const daft_instance *instance = &c->tlas->instances[index];
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        daft_ray ray = lane_ray(c, i);
        if (c->any) {
            if (DAFT_KERNEL(daft_instance_occluded)(c->tlas, index, &ray)) mark_occluded(c, (vbits)1 << i);
            continue;
        }
        daft_nearest n = lane_nearest(c, i);
        DAFT_KERNEL(daft_instance_closest)(c->tlas, index, &ray, &n);
        if (n.instance == index) lane_store(c, i, &n, instance->bvh);
    }
}

/* The rays in the mesh's space. A mesh that is only shifted keeps the directions. */
static void mesh_packet_move(mesh_packet *m, const packet *c, const daft_affine *map)
{
    if (daft_is_translation(map)) {
        m->o = (vf3){c->o.x + vf_set(map->t[0]), c->o.y + vf_set(map->t[1]), c->o.z + vf_set(map->t[2])};
        m->d = c->d;
        for (int k = 0; k < 3; k++) m->inverse[k] = c->inverse[k];
        return;
    }
    m->d = (vf3){rows(map->m, c->d), rows(map->m + 3, c->d), rows(map->m + 6, c->d)};
    m->o = (vf3){rows(map->m, c->o) + vf_set(map->t[0]), rows(map->m + 3, c->o) + vf_set(map->t[1]),
                 rows(map->m + 6, c->o) + vf_set(map->t[2])};
    m->inverse[0] = vf_set(1) / m->d.x, m->inverse[1] = vf_set(1) / m->d.y, m->inverse[2] = vf_set(1) / m->d.z;
}

DAFT_INLINE bool is_leaf(const daft_bvh *bvh)
{
    const daft_node *root = bvh->nodes.items;
    return root->child[1] == DAFT_CHILD_NONE && root->child[0] & DAFT_CHILD_LEAF;
}

/* Of rays in `bits` of one octant. */
DAFT_INLINE void slabs_begin(packet_slabs *g, vf3 o, const vf inverse[3], vf pad, const packet *c, vbits bits)
{
    slabs_setup(g, o, inverse, pad, c->tmin);
    slabs_rows(g, bits);
    slabs_interval(g, c->limit, bits);
}

static void mesh_traverse_octants(packet *c, mesh_packet *m, vbits bits)
{
    mesh_packet_setup(m, c);
    if (is_leaf(m->instance->bvh)) { /* whose box is the mesh's */
        DAFT_KERNEL(daft_packet_leaf)(c, m, NULL, m->instance->bvh->nodes.items->child[0], bits);
        return;
    }
    while (bits) {
        packet_slabs g;
        vbits same = same_octant(m->d, bits);
        bits &= ~same;
        if (count_lanes(same) <= SINGLE_IN_MESH) {
            mesh_single(c, m, 0, same);
            continue;
        }
        slabs_begin(&g, m->o, m->inverse, vf_set(0), c, same);
        mesh_traverse(c, m, &g, same);
    }
}

static void instance_packet(packet *c, uint32_t index, vbits bits)
{
    const daft_instance *instance = &c->tlas->instances[index];
    mesh_packet m = {.instance = instance};
    mesh_packet_move(&m, c, &instance->to_object);
    bits &= vbits_from_mask(finite_lanes(m.o, m.d));
    if (c->any) {
        mesh_traverse_octants(c, &m, bits);
        return;
    }
    vf t = vf_load(c->hit.t);
    vi before = vi_load(c->hit.instance), triangle = vi_load(c->hit.triangle), self = vi_set((int32_t)index);
    /* a tie goes to the lower instance; none is the largest number */
    vi mark = vi_if_then_else(vm_or(vi_lt(self, before), vi_lt(before, vi_set(0))), vi_set((int32_t)DAFT_NO_TRIANGLE),
                              vi_set(0));
    vi_store(c->hit.triangle, mark);
    mesh_traverse_octants(c, &m, bits);
    vm taken = vm_or(vf_lt(vf_load(c->hit.t), t), vm_not(vi_eq(vi_load(c->hit.triangle), mark)));
    vi_store(c->hit.instance, vi_if_then_else(taken, self, before));
    vi_store(c->hit.triangle, vi_if_then_else(taken, vi_load(c->hit.triangle), triangle));
}

static void instance_intersect(packet *c, uint32_t index, vbits bits)
{
    const daft_instance *instance = &c->tlas->instances[index];
    if (index == c->ignore || (c->any && !(instance->flags & DAFT_INSTANCE_CASTS_SHADOW))) return;
    if (!instance->mesh)
        DAFT_KERNEL(daft_packet_sphere)(c, index, bits);
    else if (instance->kdtree || instance->bvh->nodes.count == 0)
        instance_single(c, index, bits);
    else if (count_lanes(bits) <= SINGLE_RAYS && !is_leaf(instance->bvh))
        instance_single(c, index, bits);
    else
        instance_packet(c, index, bits);
}

static void upper_single(packet *c, uint32_t child, vbits bits)
{
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        daft_ray ray = lane_ray(c, i);
        if (c->any) {
            if (DAFT_KERNEL(daft_upper_occluded)(c->tlas, child, &ray)) mark_occluded(c, (vbits)1 << i);
            continue;
        }
        daft_nearest n = lane_nearest(c, i);
        DAFT_KERNEL(daft_upper_closest)(c->tlas, child, &ray, c->ignore, &n);
        lane_store(c, i, &n, n.instance == UINT32_MAX ? NULL : c->tlas->instances[n.instance].bvh);
    }
}

/* mixed: the signs of their directions differ. */
static void upper_traverse(packet *c, vbits bits, bool mixed)
{
    packet_stack stack;
    packet_slabs g;
    int top = 0;
    vbits here = bits;
    g.rays = c, g.nodes = c->tlas->nodes.items, g.leaves = c->tlas->instances, g.leaf_size = sizeof(daft_instance),
    g.leaf_shift = 0;
    vf pad = vf3_magnitude(c->o) * vf_set(0x1p-20f); /* as for single rays: single_kernel.c */
    slabs_setup(&g, c->o, c->inverse, pad, c->tmin);
    sphere_view(c);
    if (!mixed) slabs_rows(&g, bits), slabs_interval(&g, c->limit, bits);
    uint32_t child = 0;
    do {
        while (!(child & DAFT_CHILD_LEAF) && count_lanes(here) > SINGLE_RAYS)
            child = descend(&stack, &top, &g, child, c->limit, here, &here);
        if (child == DAFT_CHILD_NONE) continue;
        if (!(child & DAFT_CHILD_LEAF))
            upper_single(c, child, here);
        else
            instance_intersect(c, child & ~DAFT_CHILD_LEAF, here);
        if (g.tight) g.most = max_limit(c->limit, bits);
    } while (next_child(&stack, &top, c->limit, bits, &child, &here));
}

/* ---- sixteen rays ---- */

/* The rays from `first` on; gives those of the active that can hit anything: see daft_ray_usable. */
static vbits packet_setup(packet *c, const daft_ray_packet *rays, uint32_t first, uint32_t active)
{
    vf tmax = vf_load(rays->tmax + first), zero = vf_set(0);
    c->rays = rays, c->first = first;
    c->o = (vf3){vf_load(rays->origin[0] + first), vf_load(rays->origin[1] + first), vf_load(rays->origin[2] + first)};
    c->d = (vf3){vf_load(rays->direction[0] + first), vf_load(rays->direction[1] + first),
                 vf_load(rays->direction[2] + first)};
    c->tmin = vf_load(rays->tmin + first);
    c->inverse[0] = vf_set(1) / c->d.x, c->inverse[1] = vf_set(1) / c->d.y, c->inverse[2] = vf_set(1) / c->d.z;
    vm usable = vm_and(finite_lanes(c->o, c->d), vm_and(vf_le(c->tmin, tmax), vf_lt(zero, vf3_magnitude(c->d))));
    vbits bits = c->tlas->nodes.count ? active >> first & vbits_from_mask(usable) : 0;
    c->limit = vf_if_then_else(vm_from_bits(bits), past_lanes(tmax), vf_set(-INFINITY));
    c->inner_low = c->tmin * vf_set(1 + 0x1p-17f), c->inner_high = tmax * vf_set(1 - 0x1p-17f); /* of tmin >= 0 */
    vf_store(c->hit.t, tmax), vf_store(c->hit.u, zero), vf_store(c->hit.v, zero);
    vi_store(c->hit.instance, vi_set(-1)), vi_store(c->hit.triangle, vi_set(0)), vi_store(c->hit.place, vi_set(0));
    return bits;
}

/* So few boxes that finding the interval takes longer. */
DAFT_INLINE bool is_small(const daft_tlas *tlas)
{
    return tlas->nodes.count == 1 && tlas->nodes.items->child[3] == DAFT_CHILD_NONE;
}

static void packet_trace(packet *c, vbits bits)
{
    vbits backwards = bits & ~vbits_from_mask(vf_le(vf_set(0), c->tmin)); /* their far planes are widened in another way
                                                                           */
    upper_single(c, 0, backwards);
    if (is_small(c->tlas) && bits & ~backwards) {
        upper_traverse(c, bits & ~backwards, true);
        return;
    }
    vbits alone = 0;
    for (bits &= ~backwards; bits;) {
        vbits same = same_octant(c->d, bits);
        bits &= ~same;
        if (count_lanes(same) <= SINGLE_RAYS)
            alone |= same;
        else
            upper_traverse(c, same, false);
    }
    upper_single(c, 0, alone);
}

uint32_t DAFT_KERNEL(daft_closest_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active,
                                          uint32_t ignore, daft_hit hits[DAFT_PACKET])
{
    uint32_t bits = 0;
    for (uint32_t first = 0; first < DAFT_PACKET; first += DAFT_VL) {
        packet c;
        c.tlas = tlas, c.ignore = ignore, c.any = false, c.occluded = 0;
        packet_trace(&c, packet_setup(&c, rays, first, active));
        bits |= DAFT_KERNEL(daft_packet_finish)(&c, active >> first & DAFT_ALL_LANES, hits + first) << first;
    }
    return bits;
}

uint32_t DAFT_KERNEL(daft_occluded_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active)
{
    uint32_t bits = 0;
    for (uint32_t first = 0; first < DAFT_PACKET; first += DAFT_VL) {
        packet c;
        c.tlas = tlas, c.ignore = UINT32_MAX, c.any = true, c.occluded = 0;
        packet_trace(&c, packet_setup(&c, rays, first, active));
        bits |= c.occluded << first;
    }
    return bits;
}
