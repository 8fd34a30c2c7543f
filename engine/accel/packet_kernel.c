/* Rays together through the two levels: a lane is a ray. Sixteen rays are sorted into groups that enter boxes by the same
 * planes; as many as there are lanes travel together.
 *
 * A node's eight boxes are first met by all rays at once, as an interval of origins and of inverse directions (Boulos et
 * al., "Geometric and Arithmetic Culling Methods for Entire Ray Packets", 2006): rounding is monotonic, so the interval's
 * ends, computed like a ray's, hold every ray's own result. Children that are left are met by each ray, with the
 * arithmetic of single rays. Where few rays are left, they go on alone (Benthin et al., "Combining Single and Packet-Ray
 * Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", 2012). What a ray hits does not depend on any of
 * this: see "Order" in ray_test.h. */
#include "accel/ray_test.h"
#include "accel/traverse.h"

#define WIDEN (1 + 8 * DAFT_ULP)
enum { ROW = sizeof(((daft_node *)0)->bounds[0]), FEW = DAFT_VL / 8 + 1 };

/* What the rays found: daft_nearest, lane by lane. `place` is block · DAFT_BLOCK + triangle. */
typedef struct found {
    float t[DAFT_VL], u[DAFT_VL], v[DAFT_VL];
    uint32_t instance[DAFT_VL], triangle[DAFT_VL], place[DAFT_VL];
} found;

/* Rays on their way, in frame space. */
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
} convoy;

/* The rays as boxes see them. */
typedef struct group {
    vf near[3], far[3], inverse[3], wide[3], low; /* the origin for near and for far planes; see traverse_kernel.c */
    size_t near_row[3], far_row[3];               /* in bytes from a node's bounds */
    /* the ends of their interval, by axis; near_end's last is low's */
    v4 near_end, far_end, inverse_ends[2], wide_ends[2];
    bool tight; /* the interval says something */
} group;

typedef struct packet_stack {
    vf near[DAFT_STACK]; /* NaN: not met */
    uint32_t child[DAFT_STACK];
} packet_stack;

static int first_lane(vbits bits) { return __builtin_ctz(bits); }

/* The least lanes of four, of those in m. */
DAFT_INLINE v4 least_of(vm m, vf a, vf b, vf c, vf d)
{
    vf none = vf_set(INFINITY);
    return vf_least4(vf_select(m, a, none), vf_select(m, b, none), vf_select(m, c, none), vf_select(m, d, none));
}

/* Of the rays in `bits`, whose directions have the same signs. inverse: one over the direction. */
static void group_setup(group *g, vf3 o, const vf inverse[3], vf pad, vf tmin, vbits bits)
{
    const vf from[3] = {o.x, o.y, o.z};
    vi minus[3];
    v4i sign;
    vm m = vm_from_bits(bits);
    for (int k = 0; k < 3; k++) {
        bool back = signbit(inverse[k][first_lane(bits)]);
        sign[k] = back ? INT32_MIN : 0, minus[k] = vi_set(sign[k]);
        vf outwards = (vf)((vi)pad | minus[k]);
        g->inverse[k] = inverse[k], g->wide[k] = inverse[k] * vf_set(WIDEN);
        g->near[k] = from[k] + outwards, g->far[k] = from[k] - outwards;
        g->near_row[k] = (size_t)(back ? 3 + k : k) * ROW, g->far_row[k] = (size_t)(back ? k : 3 + k) * ROW;
    }
    g->low = tmin * vf_set(1 - 0x1p-17f); /* daft_before, of no negative number */
    sign[3] = INT32_MIN;
    /* along the way, the largest of near and the least of far */
    v4 most = least_of(m, vf_xor_sign(-g->near[0], minus[0]), vf_xor_sign(-g->near[1], minus[1]), vf_xor_sign(-g->near[2], minus[2]), g->low);
    v4 least = least_of(m, vf_xor_sign(g->far[0], minus[0]), vf_xor_sign(g->far[1], minus[1]), vf_xor_sign(g->far[2], minus[2]), g->low);
    g->near_end = -(v4)((v4i)most ^ sign), g->far_end = (v4)((v4i)least ^ sign);
    g->inverse_ends[0] = least_of(m, inverse[0], inverse[1], inverse[2], g->low);
    g->inverse_ends[1] = -least_of(m, -inverse[0], -inverse[1], -inverse[2], g->low);
    for (int e = 0; e < 2; e++) g->wide_ends[e] = g->inverse_ends[e] * v4_set(WIDEN);
    v4 none = (g->wide_ends[0] - g->wide_ends[0]) + (g->wide_ends[1] - g->wide_ends[1]);
    g->tight = (v4_bits(none == v4_set(0)) & 7) == 7;
}

/* Children that some ray may meet; the least distances in *near. */
DAFT_INLINE uint32_t interval_test(const daft_node *node, const group *g, v8 limit, v8 *near)
{
    const char *at = (const char *)node->bounds;
    v8 enter = v8_set(g->near_end[3]), leave = limit;
    for (int k = 0; k < 3; k++) {
        v8 a = v8_load((const float *)(at + g->near_row[k])) - v8_set(g->near_end[k]);
        v8 b = v8_load((const float *)(at + g->far_row[k])) - v8_set(g->far_end[k]);
        enter = v8_max(v8_min(a * v8_set(g->inverse_ends[0][k]), a * v8_set(g->inverse_ends[1][k])), enter);
        leave = v8_min(v8_max(b * v8_set(g->wide_ends[0][k]), b * v8_set(g->wide_ends[1][k])), leave);
    }
    *near = enter;
    return v8_le_bits(enter, leave);
}

/* The rays that meet one child. */
DAFT_INLINE vm child_test(const daft_node *node, uint32_t child, const group *g, vf limit, vf *near)
{
    const char *at = (const char *)&node->bounds[0][child];
    vf enter = g->low, leave = limit;
    for (int k = 2; k >= 0; k--) { /* vf_max and vf_min give their second argument when the first is NaN */
        enter = vf_max((vf_set(*(const float *)(at + g->near_row[k])) - g->near[k]) * g->inverse[k], enter);
        leave = vf_min((vf_set(*(const float *)(at + g->far_row[k])) - g->far[k]) * g->wide[k], leave);
    }
    *near = enter;
    return vf_le(enter, leave);
}

/* Puts the children that rays meet on the stack, the nearest on top; gives its new top. */
static int push(packet_stack *stack, int top, const daft_node *node, const group *g, vf limit, vbits bits)
{
    float order[DAFT_WIDTH];
    v8 near = v8_set(g->near_end[3]);
    uint32_t children = 0xff;
    if (g->tight) {
        float most = vf_most(vf_select(vm_from_bits(bits), limit, vf_set(-INFINITY)));
        children = interval_test(node, g, v8_set(most), &near);
    }
    float at[DAFT_WIDTH];
    memcpy(at, &near, sizeof at);
    for (int base = top; children; children &= children - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(children);
        vf lanes;
        vm met = vm_and(child_test(node, i, g, limit, &lanes), vm_from_bits(bits));
        if (node->child[i] == DAFT_CHILD_NONE || !vm_bits(met)) continue;
        float distance = g->tight ? at[i] : lanes[first_lane(vm_bits(met))];
        int place = top++;
        for (; place > base && order[place - base - 1] < distance; place--) {
            order[place - base] = order[place - base - 1];
            stack->near[place] = stack->near[place - 1], stack->child[place] = stack->child[place - 1];
        }
        order[place - base] = distance;
        stack->near[place] = vf_select(met, lanes, vf_set(NAN)), stack->child[place] = node->child[i];
    }
    return top;
}

DAFT_INLINE vm finite_lanes(vf3 o, vf3 d) /* daft_finite_lines */
{
    vf sum = (o.x - o.x) + (o.y - o.y) + (o.z - o.z) + (d.x - d.x) + (d.y - d.y) + (d.z - d.z);
    return vf_le(sum, vf_set(0));
}

/* ---- lanes for what works on single rays ---- */

static daft_ray lane_ray(const convoy *c, int lane)
{
    const daft_ray_packet *p = c->rays;
    uint32_t i = c->first + (uint32_t)lane;
    return (daft_ray){{p->origin[0][i], p->origin[1][i], p->origin[2][i]}, p->tmin[i],
                      {p->direction[0][i], p->direction[1][i], p->direction[2][i]}, p->tmax[i]};
}

static daft_nearest lane_nearest(const convoy *c, int i)
{
    const found *f = &c->hit;
    daft_nearest n = {f->t[i], f->u[i], f->v[i], f->instance[i], f->triangle[i], NULL, 0};
    const daft_instance *instance = n.instance == UINT32_MAX ? NULL : &c->tlas->instances[n.instance];
    if (!instance || !instance->mesh || instance->kdtree) return n;
    n.block = &instance->bvh->blocks[f->place[i] / DAFT_BLOCK], n.place = f->place[i] % DAFT_BLOCK;
    return n;
}

static void lane_take(convoy *c, int i, const daft_nearest *n, const daft_bvh *bvh)
{
    found *f = &c->hit;
    f->t[i] = n->t, f->u[i] = n->u, f->v[i] = n->v, f->instance[i] = n->instance, f->triangle[i] = n->triangle;
    if (bvh && n->block) f->place[i] = (uint32_t)(n->block - bvh->blocks) * DAFT_BLOCK + n->place;
    c->limit[i] = daft_past(n->t);
}

static void stop(convoy *c, vbits bits)
{
    c->stopped |= bits;
    c->limit = vf_select(vm_from_bits(bits), vf_set(-INFINITY), c->limit);
}

/* ---- the lower level ---- */

typedef struct mesh_convoy {
    const daft_instance *instance;
    vf3 o, d; /* in object space */
    vf inverse[3];
    vf scale, floor; /* daft_filter */
} mesh_convoy;

/* daft_filter_of */
static void mesh_convoy_setup(mesh_convoy *m, const convoy *c)
{
    vf size = vf3_magnitude(m->d), zero = vf_set(0);
    vm usual = vm_and(vf_lt(vf_set(0x1p-26f), size), vf_lt(size, vf_set(0x1p26f)));
    m->scale = vf_select(usual, size * vf_set(22 * DAFT_ULP), vf_set(INFINITY));
    m->floor = vf_select(vf_le(zero, c->tmin), vf_set(-DAFT_TINY), vf_set(-INFINITY));
}

/* The triangles of a block, for the filter; lanes are triangles. */
typedef struct facets {
    v4 corner[3], a[3], b[3], normal[3], sizes, area;
} facets;

DAFT_INLINE v4 size_of(const v4 a[3]) { return v4_max(v4_max(v4_abs(a[0]), v4_abs(a[1])), v4_abs(a[2])) + v4_set(DAFT_FILTER_SIZE); }

DAFT_INLINE facets facets_of(const daft_block *block)
{
    facets f;
    for (int k = 0; k < 3; k++) {
        f.corner[k] = v4_load(block->corner[0][k]);
        f.a[k] = f.corner[k] - v4_load(block->corner[1][k]), f.b[k] = v4_load(block->corner[2][k]) - f.corner[k];
    }
    for (int k = 0; k < 3; k++) f.normal[k] = f.b[(k + 1) % 3] * f.a[(k + 2) % 3] - f.b[(k + 2) % 3] * f.a[(k + 1) % 3];
    v4 along = size_of(f.a), across = size_of(f.b);
    f.sizes = along + across, f.area = along * across;
    return f;
}

/* The rays that may hit triangle i of the block; how surely. */
DAFT_INLINE vbits lanes_filter(const facets *f, uint32_t i, const mesh_convoy *m, vf past, daft_sides *sides)
{
    daft_facet one = {{vf_set(f->corner[0][i]), vf_set(f->corner[1][i]), vf_set(f->corner[2][i])},
                      {vf_set(f->a[0][i]), vf_set(f->a[1][i]), vf_set(f->a[2][i])},
                      {vf_set(f->b[0][i]), vf_set(f->b[1][i]), vf_set(f->b[2][i])},
                      {vf_set(f->normal[0][i]), vf_set(f->normal[1][i]), vf_set(f->normal[2][i])},
                      vf_set(f->sizes[i]), vf_set(f->area[i])};
    return daft_filter_pass(&one, m->o, m->d, m->scale, m->floor, vf_max(past, vf_set(0)), sides);
}

/* Lanes that touch triangle i at t, weights u and v, where that is nearer than what they have. */
static void take_lanes(convoy *c, vbits bits, const daft_block *b, uint32_t i, uint32_t place, const daft_touch *touch)
{
    found *f = &c->hit;
    vf t = vf_load(f->t);
    vbits nearer = bits & vm_bits(vf_lt(touch->t, t)), level = bits & ~nearer & vm_bits(vf_le(touch->t, t));
    for (; level; level &= level - 1) {
        int lane = first_lane(level);
        if (b->triangle[i] < f->triangle[lane]) nearer |= (vbits)1 << lane;
    }
    if (!nearer) return;
    vm won = vm_from_bits(nearer);
    vf_store(f->t, vf_select(won, touch->t, t));
    vf_store(f->u, vf_select(won, vf_clamp01(touch->v), vf_load(f->u)));
    vf_store(f->v, vf_select(won, vf_clamp01(touch->w), vf_load(f->v)));
    vi_store(f->triangle, vi_select(won, vi_set((int32_t)b->triangle[i]), vi_load(f->triangle)));
    vi_store(f->place, vi_select(won, vi_set((int32_t)place), vi_load(f->place)));
}

typedef struct vd3 {
    vd x, y, z;
} vd3;

DAFT_INLINE vd3 vd3_half(vf3 a, int half) { return (vd3){vf_half(a.x, half), vf_half(a.y, half), vf_half(a.z, half)}; }
DAFT_INLINE vd vd3_dot(daft_dvec3 a, vd3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* daft_touch_plain of triangle i and all rays; of those in `which`, the ones that touch in time. */
static __attribute__((noinline)) vbits lanes_measure(const convoy *c, const mesh_convoy *m, const daft_block *b, uint32_t i,
                                                     vbits which, daft_touch *out)
{
    daft_dvec3 p = daft_to_double(daft_block_corner(b, 0, i)), e = daft_dsub(p, daft_to_double(daft_block_corner(b, 1, i)));
    daft_dvec3 f = daft_dsub(daft_to_double(daft_block_corner(b, 2, i)), p), normal = daft_dcross(f, e);
    vd t[2], v[2], w[2];
    for (int half = 0; half < 2; half++) {
        vd3 o = vd3_half(m->o, half), ray = vd3_half(m->d, half), s = {p.x - o.x, p.y - o.y, p.z - o.z};
        vd3 r = {s.y * ray.z - s.z * ray.y, s.z * ray.x - s.x * ray.z, s.x * ray.y - s.y * ray.x};
        vd inverse = 1 / vd3_dot(normal, ray);
        t[half] = vd3_dot(normal, s) * inverse, v[half] = vd3_dot(f, r) * inverse, w[half] = vd3_dot(e, r) * inverse;
    }
    *out = (daft_touch){vf_join(t[0], t[1]), vf_join(v[0], v[1]), vf_join(w[0], w[1])};
    /* distances may round to -0, which is not behind; rays with tmin < 0 come here alone */
    vbits ahead = ~vm_bits(vi_lt((vi)out->t, vi_set(0)));
    return which & ahead & vm_bits(daft_touch_within(out, c->tmin, vf_load(c->hit.t)));
}

/* The rays in `maybe` against triangle i; gives those that touch. */
static vbits lanes_exact(convoy *c, const mesh_convoy *m, const daft_block *b, uint32_t i, vbits maybe, const daft_sides *sides)
{
    vbits plain = daft_filter_plain(sides) & maybe, bits = 0;
    if (c->any) {
        bits = plain & daft_filter_within(sides, c->inner_low, c->inner_high);
        plain &= ~bits, maybe &= ~bits;
    }
    daft_touch touch = {vf_set(0), vf_set(0), vf_set(0)};
    if (plain) bits |= lanes_measure(c, m, b, i, plain, &touch);
    for (vbits left = maybe & ~plain; left; left &= left - 1) {
        int lane = first_lane(left);
        daft_exact_touch e;
        daft_vec3 o = {m->o.x[lane], m->o.y[lane], m->o.z[lane]}, d = {m->d.x[lane], m->d.y[lane], m->d.z[lane]};
        if (!daft_touch_exact(b, i, o, d, c->tmin[lane], c->hit.t[lane], &e)) continue;
        touch.t[lane] = e.t, touch.v[lane] = e.v, touch.w[lane] = e.w;
        bits |= (vbits)1 << lane;
    }
    if (bits && !c->any) take_lanes(c, bits, b, i, (uint32_t)(b - m->instance->bvh->blocks) * DAFT_BLOCK + i, &touch);
    return bits;
}

/* The same by the floats' word alone. */
static __attribute__((noinline)) vbits lanes_floats(convoy *c, const mesh_convoy *m, const daft_block *b, uint32_t i, vbits which)
{
    vf3 corner[3];
    for (int k = 0; k < 3; k++)
        corner[k] = (vf3){vf_set(b->corner[k][0][i]), vf_set(b->corner[k][1][i]), vf_set(b->corner[k][2][i])};
    daft_touch touch;
    bool fast = c->tlas->intersection == DAFT_INTERSECT_FAST;
    vbits bits = daft_touch_floats(corner, m->o, m->d, c->tmin, vf_load(c->hit.t), fast, &touch) & which;
    if (bits && !c->any) take_lanes(c, bits, b, i, (uint32_t)(b - m->instance->bvh->blocks) * DAFT_BLOCK + i, &touch);
    return bits;
}

static void leaf_touch(convoy *c, const mesh_convoy *m, uint32_t child, vbits bits)
{
    const daft_block *b = &m->instance->bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], *end = b + (child & 3) + 1;
    bool exact = c->tlas->intersection == DAFT_INTERSECT_EXACT;
    vbits hits = 0;
    for (; b < end && bits; b++) {
        facets f = facets_of(b);
        for (uint32_t i = 0; i < DAFT_BLOCK && b->triangle[i] != DAFT_NO_TRIANGLE; i++) {
            vbits touched;
            if (exact) {
                daft_sides sides;
                vbits maybe = lanes_filter(&f, i, m, c->limit, &sides) & bits;
                if (!maybe) continue;
                touched = lanes_exact(c, m, b, i, maybe, &sides);
            } else {
                touched = lanes_floats(c, m, b, i, bits);
            }
            hits |= touched;
            if (c->any) bits &= ~touched;
        }
    }
    if (c->any) {
        if (hits) stop(c, hits);
        return;
    }
    for (; hits; hits &= hits - 1) c->limit[first_lane(hits)] = daft_past(c->hit.t[first_lane(hits)]);
}

/* Rays that are left alone go on from here by themselves. */
static void mesh_alone(convoy *c, const mesh_convoy *m, uint32_t child, vbits bits)
{
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        daft_ray ray = lane_ray(c, i);
        if (c->any) {
            if (DAFT_KERNEL(daft_mesh_occluded)(m->instance, child, &ray, c->tlas->intersection)) stop(c, (vbits)1 << i);
            continue;
        }
        daft_nearest n = {.t = c->hit.t[i], .triangle = c->hit.triangle[i], .instance = c->hit.instance[i], .u = c->hit.u[i],
                          .v = c->hit.v[i]};
        DAFT_KERNEL(daft_mesh_closest)(m->instance, child, &ray, c->tlas->intersection, &n);
        lane_take(c, i, &n, m->instance->bvh);
    }
}

static void mesh_walk(convoy *c, const mesh_convoy *m, vbits bits)
{
    packet_stack stack;
    group g;
    const daft_bvh *bvh = m->instance->bvh;
    group_setup(&g, m->o, m->inverse, vf_set(0), c->tmin, bits);
    int top = push(&stack, 0, bvh->nodes.items, &g, c->limit, bits);
    while (--top >= 0) {
        uint32_t child = stack.child[top];
        vbits here = vm_bits(vf_le(stack.near[top], c->limit)) & bits;
        if (!here) continue;
        if (__builtin_popcount(here) <= FEW) mesh_alone(c, m, child, here);
        else if (child & DAFT_CHILD_LEAF) leaf_touch(c, m, child, here);
        else top = push(&stack, top, &bvh->nodes.items[child], &g, c->limit, here);
    }
}

/* ---- the upper level ---- */

/* In the order of daft_affine_point and daft_affine_vector. */
DAFT_INLINE vf rows(const float *m, vf3 p) { return vf_set(m[0]) * p.x + vf_set(m[1]) * p.y + vf_set(m[2]) * p.z; }

/* The lanes of `bits` that go the way the first of them goes: the same signs. */
static vbits alike(vf3 d, vbits bits)
{
    vi sign = vi_set(INT32_MIN);
    vi way = ((vi)d.x & sign) ^ (((vi)d.y & sign) >> 1 & vi_set(0x40000000)) ^ (((vi)d.z & sign) >> 2 & vi_set(0x20000000));
    return bits & vm_bits(vi_eq(way, vi_set(way[first_lane(bits)])));
}

static void instance_alone(convoy *c, uint32_t index, vbits bits)
{
    const daft_instance *instance = &c->tlas->instances[index];
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        daft_ray ray = lane_ray(c, i);
        if (c->any) {
            if (DAFT_KERNEL(daft_instance_occluded)(c->tlas, index, &ray)) stop(c, (vbits)1 << i);
            continue;
        }
        daft_nearest n = lane_nearest(c, i);
        DAFT_KERNEL(daft_instance_closest)(c->tlas, index, &ray, &n);
        if (n.instance == index) lane_take(c, i, &n, instance->bvh);
    }
}

/* The rays in the mesh's space. A mesh that is only shifted keeps the directions. */
static void mesh_convoy_turn(mesh_convoy *m, const convoy *c, const daft_affine *map)
{
    static const float UNTURNED[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (memcmp(map->m, UNTURNED, sizeof UNTURNED) == 0) {
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

static void mesh_walks(convoy *c, mesh_convoy *m, vbits bits)
{
    mesh_convoy_setup(m, c);
    while (bits) {
        vbits same = alike(m->d, bits);
        bits &= ~same;
        mesh_walk(c, m, same);
    }
}

static void instance_together(convoy *c, uint32_t index, vbits bits)
{
    const daft_instance *instance = &c->tlas->instances[index];
    mesh_convoy m = {.instance = instance};
    mesh_convoy_turn(&m, c, &instance->to_object);
    bits &= vm_bits(finite_lanes(m.o, m.d));
    if (c->any) {
        mesh_walks(c, &m, bits);
        return;
    }
    vf t = vf_load(c->hit.t);
    vi before = vi_load(c->hit.instance), triangle = vi_load(c->hit.triangle), self = vi_set((int32_t)index);
    /* a tie goes to the lower instance; none is the largest number */
    vi mark = vi_select(vm_or(vi_lt(self, before), vi_lt(before, vi_set(0))), vi_set((int32_t)DAFT_NO_TRIANGLE), vi_set(0));
    vi_store(c->hit.triangle, mark);
    mesh_walks(c, &m, bits);
    vm taken = vm_or(vf_lt(vf_load(c->hit.t), t), vm_not(vi_eq(vi_load(c->hit.triangle), mark)));
    vi_store(c->hit.instance, vi_select(taken, self, before));
    vi_store(c->hit.triangle, vi_select(taken, vi_load(c->hit.triangle), triangle));
}

static void instance_touch(convoy *c, uint32_t index, vbits bits)
{
    const daft_instance *instance = &c->tlas->instances[index];
    if (index == c->ignore || (c->any && !(instance->flags & DAFT_INSTANCE_CASTS_SHADOW))) return;
    if (!instance->mesh || instance->kdtree || instance->bvh->nodes.count == 0 || __builtin_popcount(bits) <= FEW) instance_alone(c, index, bits);
    else instance_together(c, index, bits);
}

static void upper_alone(convoy *c, uint32_t child, vbits bits)
{
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        daft_ray ray = lane_ray(c, i);
        if (c->any) {
            if (DAFT_KERNEL(daft_upper_occluded)(c->tlas, child, &ray)) stop(c, (vbits)1 << i);
            continue;
        }
        daft_nearest n = lane_nearest(c, i);
        DAFT_KERNEL(daft_upper_closest)(c->tlas, child, &ray, c->ignore, &n);
        lane_take(c, i, &n, n.instance == UINT32_MAX ? NULL : c->tlas->instances[n.instance].bvh);
    }
}

static void upper_walk(convoy *c, vbits bits)
{
    packet_stack stack;
    group g;
    vf pad = vf3_magnitude(c->o) * vf_set(0x1p-20f); /* as for single rays: traverse_kernel.c */
    group_setup(&g, c->o, c->inverse, pad, c->tmin, bits);
    int top = push(&stack, 0, c->tlas->nodes.items, &g, c->limit, bits);
    while (--top >= 0) {
        uint32_t child = stack.child[top];
        vbits here = vm_bits(vf_le(stack.near[top], c->limit)) & bits;
        if (!here) continue;
        if (child & DAFT_CHILD_LEAF) instance_touch(c, child & ~DAFT_CHILD_LEAF, here);
        else if (__builtin_popcount(here) <= FEW) upper_alone(c, child, here);
        else top = push(&stack, top, &c->tlas->nodes.items[child], &g, c->limit, here);
    }
}

/* ---- sixteen rays ---- */

/* The rays from `first` on; gives those of the active that can hit anything: see daft_ray_usable. */
static vbits convoy_setup(convoy *c, const daft_ray_packet *rays, uint32_t first, uint32_t active)
{
    vf tmax = vf_load(rays->tmax + first), zero = vf_set(0);
    c->rays = rays, c->first = first;
    c->o = (vf3){vf_load(rays->origin[0] + first), vf_load(rays->origin[1] + first), vf_load(rays->origin[2] + first)};
    c->d = (vf3){vf_load(rays->direction[0] + first), vf_load(rays->direction[1] + first), vf_load(rays->direction[2] + first)};
    c->tmin = vf_load(rays->tmin + first);
    c->inverse[0] = vf_set(1) / c->d.x, c->inverse[1] = vf_set(1) / c->d.y, c->inverse[2] = vf_set(1) / c->d.z;
    vm usable = vm_and(finite_lanes(c->o, c->d), vm_and(vf_le(c->tmin, tmax), vf_lt(zero, vf3_magnitude(c->d))));
    vbits bits = c->tlas->nodes.count ? active >> first & vm_bits(usable) : 0;
    vf past = vf_select(vf_lt(zero, tmax), tmax * vf_set(1 + 0x1p-17f), tmax * vf_set(1 - 0x1p-17f)); /* daft_past */
    c->limit = vf_select(vm_from_bits(bits), past, vf_set(-INFINITY));
    c->inner_low = c->tmin * vf_set(1 + 0x1p-17f), c->inner_high = tmax * vf_set(1 - 0x1p-17f); /* of tmin >= 0 */
    vf_store(c->hit.t, tmax), vf_store(c->hit.u, zero), vf_store(c->hit.v, zero);
    vi_store(c->hit.instance, vi_set(-1)), vi_store(c->hit.triangle, vi_set(0)), vi_store(c->hit.place, vi_set(0));
    return bits;
}

static void convoy_run(convoy *c, vbits bits)
{
    vbits backwards = bits & ~vm_bits(vf_le(vf_set(0), c->tmin)); /* their far planes are widened in another way */
    upper_alone(c, 0, backwards);
    for (bits &= ~backwards; bits;) {
        vbits same = alike(c->d, bits);
        bits &= ~same;
        if (__builtin_popcount(same) <= FEW) upper_alone(c, 0, same);
        else upper_walk(c, same);
    }
}

uint32_t DAFT_KERNEL(daft_closest_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active,
                                          uint32_t ignore, daft_hit hits[DAFT_PACKET])
{
    uint32_t bits = 0;
    for (uint32_t first = 0; first < DAFT_PACKET; first += DAFT_VL) {
        convoy c;
        c.tlas = tlas, c.ignore = ignore, c.any = false, c.stopped = 0;
        convoy_run(&c, convoy_setup(&c, rays, first, active));
        for (vbits left = active >> first & DAFT_ALL_LANES; left; left &= left - 1) {
            uint32_t i = (uint32_t)first_lane(left);
            if (c.hit.instance[i] == UINT32_MAX) {
                hits[first + i] = (daft_hit){.t = rays->tmax[first + i], .instance = UINT32_MAX};
                continue;
            }
            daft_nearest n = lane_nearest(&c, (int)i);
            daft_ray ray = lane_ray(&c, (int)i);
            bits |= (uint32_t)DAFT_KERNEL(daft_finish_hit)(tlas, &ray, &n, &hits[first + i]) << (first + i);
        }
    }
    return bits;
}

uint32_t DAFT_KERNEL(daft_occluded_packet)(const daft_tlas *tlas, const daft_ray_packet *rays, uint32_t active)
{
    uint32_t bits = 0;
    for (uint32_t first = 0; first < DAFT_PACKET; first += DAFT_VL) {
        convoy c;
        c.tlas = tlas, c.ignore = UINT32_MAX, c.any = true, c.stopped = 0;
        convoy_run(&c, convoy_setup(&c, rays, first, active));
        bits |= c.stopped << first;
    }
    return bits;
}
