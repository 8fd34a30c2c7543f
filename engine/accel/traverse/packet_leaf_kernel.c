/* What a packet hits: the triangles of leaves, spheres, and the hit records that callers get.
 *
 * A leaf's triangles are first tested by their boxes against the whole packet, as nodes' children are; of ten, three or
 * four remain. These are tested ray by ray or triangle by triangle, whichever are fewer: the filter takes as long for
 * one ray and all triangles as for one triangle and all rays. */
#include "accel/traverse/packet.h"

/* ---- triangles ---- */

/* The triangles of some blocks, for the filter; lanes are triangles. */
typedef struct facets {
    float corner[3][DAFT_VL], a[3][DAFT_VL], b[3][DAFT_VL], normal[3][DAFT_VL], sizes[DAFT_VL], area[DAFT_VL];
} __attribute__((aligned(64))) facets;

DAFT_INLINE void rows_store(float rows[3][DAFT_VL], vf3 v)
{
    vf_store(rows[0], v.x), vf_store(rows[1], v.y), vf_store(rows[2], v.z);
}

DAFT_INLINE void facets_store(facets *to, const daft_facet *f)
{
    rows_store(to->corner, f->corner), rows_store(to->a, f->a), rows_store(to->b, f->b),
        rows_store(to->normal, f->normal);
    vf_store(to->sizes, f->sizes), vf_store(to->area, f->area);
}

DAFT_INLINE vf3 rows_of(const float rows[3][DAFT_VL], uint32_t i)
{
    return (vf3){vf_set(rows[0][i]), vf_set(rows[1][i]), vf_set(rows[2][i])};
}

/* The rays that may hit triangle i; how surely. */
DAFT_INLINE vbits lanes_filter(const facets *f, uint32_t i, const mesh_packet *m, vf past, daft_edge_tests *sides)
{
    daft_facet one = {rows_of(f->corner, i), rows_of(f->a, i),    rows_of(f->b, i),
                      rows_of(f->normal, i), vf_set(f->sizes[i]), vf_set(f->area[i])};
    return daft_filter_pass(&one, m->o, m->d, m->scale, m->floor, vf_max(past, vf_set(0)), sides);
}

/* The triangles with these corners whose box some ray may meet: interval_test of packet_kernel.c. */
DAFT_INLINE vbits boxes_met(const vf3 c[3], const packet_slabs *g)
{
    vf low[3] = {vf_min3(c[0].x, c[1].x, c[2].x), vf_min3(c[0].y, c[1].y, c[2].y), vf_min3(c[0].z, c[1].z, c[2].z)};
    vf high[3] = {vf_max3(c[0].x, c[1].x, c[2].x), vf_max3(c[0].y, c[1].y, c[2].y), vf_max3(c[0].z, c[1].z, c[2].z)};
    vf enter = vf_set(g->near_end[3]), leave = vf_set(g->most);
    for (int k = 0; k < 3; k++) {
        bool back = g->near_row[k] > g->far_row[k];
        vf a = (back ? high[k] : low[k]) - vf_set(g->near_end[k]),
           b = (back ? low[k] : high[k]) - vf_set(g->far_end[k]);
        enter = vf_max(vf_min(a * vf_set(g->inverse_ends[0][k]), a * vf_set(g->inverse_ends[1][k])), enter);
        leave = vf_min(vf_max(b * vf_set(g->wide_ends[0][k]), b * vf_set(g->wide_ends[1][k])), leave);
    }
    return vbits_from_mask(vf_le(enter, leave));
}

/* Lanes that touch triangle i at t, weights u and v, where that is nearer than what they have. */
static void store_lanes(packet *c, vbits bits, const daft_block *b, uint32_t i, uint32_t place,
                        const daft_lane_hits *touch)
{
    packet_hits *f = &c->hit;
    vf t = vf_load(f->t);
    vbits nearer = bits & vbits_from_mask(vf_lt(touch->t, t)),
          level = bits & ~nearer & vbits_from_mask(vf_le(touch->t, t));
    for (; level; level &= level - 1) {
        int lane = first_lane(level);
        if (b->triangle[i] < f->triangle[lane]) nearer |= (vbits)1 << lane;
    }
    if (!nearer) return;
    vm won = vm_from_bits(nearer);
    vf_store(f->t, vf_if_then_else(won, touch->t, t));
    vf_store(f->u, vf_if_then_else(won, vf_clamp01(touch->v), vf_load(f->u)));
    vf_store(f->v, vf_if_then_else(won, vf_clamp01(touch->w), vf_load(f->v)));
    vi_store(f->triangle, vi_if_then_else(won, vi_set((int32_t)b->triangle[i]), vi_load(f->triangle)));
    vi_store(f->place, vi_if_then_else(won, vi_set((int32_t)place), vi_load(f->place)));
}

/* The same of one lane. */
static void store_lane(packet *c, int lane, const daft_block *b, uint32_t i, uint32_t place, const daft_exact_hit *e)
{
    packet_hits *f = &c->hit;
    if (!(e->t < f->t[lane] || (e->t == f->t[lane] && b->triangle[i] < f->triangle[lane]))) return;
    f->t[lane] = e->t, f->u[lane] = daft_unit_clamped(e->v), f->v[lane] = daft_unit_clamped(e->w);
    f->triangle[lane] = b->triangle[i], f->place[lane] = place;
}

typedef struct vd3 {
    vd x, y, z;
} vd3;

DAFT_INLINE daft_vec3 lane_of(const vf3 *v, int lane) { return (daft_vec3){v->x[lane], v->y[lane], v->z[lane]}; }
DAFT_INLINE vd3 vd3_half(vf3 a, int half)
{
    return (vd3){vd_promote_half(a.x, half), vd_promote_half(a.y, half), vd_promote_half(a.z, half)};
}
DAFT_INLINE vd vd3_dot(daft_dvec3 a, vd3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* daft_intersect_plain of triangle i and all rays; of those in `which`, the ones that touch in time. */
static __attribute__((noinline)) vbits lanes_measure(const packet *c, const mesh_packet *m, const daft_block *b,
                                                     uint32_t i, vbits which, daft_lane_hits *out)
{
    daft_dvec3 p = daft_to_double(daft_block_corner(b, 0, i)),
               e = daft_dsub(p, daft_to_double(daft_block_corner(b, 1, i)));
    daft_dvec3 f = daft_dsub(daft_to_double(daft_block_corner(b, 2, i)), p), normal = daft_dcross(f, e);
    vd t[2], v[2], w[2];
    for (int half = 0; half < 2; half++) {
        vd3 o = vd3_half(m->o, half), ray = vd3_half(m->d, half), s = {p.x - o.x, p.y - o.y, p.z - o.z};
        vd3 r = {s.y * ray.z - s.z * ray.y, s.z * ray.x - s.x * ray.z, s.x * ray.y - s.y * ray.x};
        vd inverse = 1 / vd3_dot(normal, ray);
        t[half] = vd3_dot(normal, s) * inverse, v[half] = vd3_dot(f, r) * inverse, w[half] = vd3_dot(e, r) * inverse;
    }
    *out = (daft_lane_hits){vf_demote2(t[0], t[1]), vf_demote2(v[0], v[1]), vf_demote2(w[0], w[1])};
    /* distances may round to -0, which is not behind; rays with tmin < 0 come here alone */
    vbits ahead = ~vbits_from_mask(vi_lt((vi)out->t, vi_set(0)));
    return which & ahead & vbits_from_mask(daft_hits_within(out, c->tmin, vf_load(c->hit.t)));
}

DAFT_INLINE vd vd3_sum(vd3 a) { return vd_abs(a.x) + vd_abs(a.y) + vd_abs(a.z); }

/* daft_is_behind of triangle i and all rays. */
static __attribute__((noinline)) vbits lanes_behind(const mesh_packet *m, const daft_block *b, uint32_t i)
{
    daft_dvec3 p = daft_to_double(daft_block_corner(b, 0, i)),
               e = daft_dsub(p, daft_to_double(daft_block_corner(b, 1, i)));
    daft_dvec3 f = daft_dsub(daft_to_double(daft_block_corner(b, 2, i)), p), normal = daft_dcross(f, e);
    const double area = (fabs(e.x) + fabs(e.y) + fabs(e.z)) * (fabs(f.x) + fabs(f.y) + fabs(f.z)) * DAFT_BEHIND_OFF;
    vd side[2];
    for (int half = 0; half < 2; half++) {
        vd3 o = vd3_half(m->o, half), ray = vd3_half(m->d, half), s = {p.x - o.x, p.y - o.y, p.z - o.z};
        vd sum = vd3_dot(normal, ray), along = vd3_dot(normal, s), off = area * vd3_sum(s), steep = area * vd3_sum(ray);
        const vl behind = ((sum > steep) & (along < -off)) | ((sum < -steep) & (along > off));
        side[half] = vd_if_then_else(behind, vd_set(-1), vd_set(1));
    }
    return vbits_from_mask(vf_lt(vf_demote2(side[0], side[1]), vf_set(0)));
}

DAFT_INLINE uint32_t place_of(const mesh_packet *m, const daft_block *b, uint32_t i)
{
    return (uint32_t)(b - m->instance->bvh->blocks) * DAFT_BLOCK + i;
}

/* The rays in `maybe` against triangle i; gives those that touch. */
static vbits lanes_exact(packet *c, const mesh_packet *m, const daft_block *b, uint32_t i, vbits maybe,
                         const daft_edge_tests *sides)
{
    vbits plain = daft_filter_plain(sides) & maybe, bits = 0;
    if (c->any) {
        bits = plain & daft_filter_within(sides, c->inner_low, c->inner_high);
        plain &= ~bits, maybe &= ~bits;
    }
    daft_lane_hits touch = {vf_set(0), vf_set(0), vf_set(0)};
    if (plain) bits |= lanes_measure(c, m, b, i, plain, &touch);
    vbits left = maybe & ~plain;
    if (left) left &= ~lanes_behind(m, b, i); /* packets count no negative distances */
    for (; left; left &= left - 1) {
        int lane = first_lane(left);
        daft_exact_hit e;
        if (!daft_intersect_exact(b, i, lane_of(&m->o, lane), lane_of(&m->d, lane), c->tmin[lane], c->hit.t[lane], &e))
            continue;
        touch.t[lane] = e.t, touch.v[lane] = e.v, touch.w[lane] = e.w;
        bits |= (vbits)1 << lane;
    }
    if (bits && !c->any) store_lanes(c, bits, b, i, place_of(m, b, i), &touch);
    return bits;
}

/* The same by the floats' word alone. */
static __attribute__((noinline)) vbits lanes_floats(packet *c, const mesh_packet *m, const daft_block *b, uint32_t i,
                                                    vbits which)
{
    vf3 corner[3];
    for (int k = 0; k < 3; k++)
        corner[k] = (vf3){vf_set(b->corner[k][0][i]), vf_set(b->corner[k][1][i]), vf_set(b->corner[k][2][i])};
    daft_lane_hits touch;
    bool fast = c->tlas->intersection == DAFT_INTERSECT_FAST;
    vbits bits = daft_intersect_floats(corner, m->o, m->d, c->tmin, vf_load(c->hit.t), fast, &touch) & which;
    if (bits && !c->any) store_lanes(c, bits, b, i, place_of(m, b, i), &touch);
    return bits;
}

/* One ray and the triangles in `which`; whether it touches any. */
static bool ray_intersect(packet *c, const mesh_packet *m, const daft_facet *f, const daft_block *b, vbits which,
                          int lane)
{
    const daft_vec3 o = lane_of(&m->o, lane), d = lane_of(&m->d, lane);
    const float tmin = c->tmin[lane], past = c->limit[lane];
    daft_edge_tests sides;
    bool touches = false;
    vbits maybe = which & daft_filter_pass(f, vf3_set(o), vf3_set(d), vf_set(m->scale[lane]), vf_set(m->floor[lane]),
                                           vf_set(past > 0 ? past : 0), &sides);
    if (!maybe) return false;
    vbits plain = daft_filter_plain(&sides) & maybe;
    if (c->any && plain & daft_filter_within(&sides, vf_set(c->inner_low[lane]), vf_set(c->inner_high[lane])))
        return true;
    for (; maybe; maybe &= maybe - 1) {
        uint32_t at = (uint32_t)__builtin_ctz(maybe), i = at % DAFT_BLOCK;
        const daft_block *block = b + at / DAFT_BLOCK;
        daft_exact_hit e;
        if (block->triangle[i] == DAFT_NO_TRIANGLE) continue;
        if (plain >> at & 1 ? !daft_intersect_plain(block, i, o, d, tmin, c->hit.t[lane], &e)
                            : !daft_intersect_exact(block, i, o, d, tmin, c->hit.t[lane], &e))
            continue;
        if (c->any) return true;
        store_lane(c, lane, block, i, place_of(m, block, i), &e);
        touches = true;
    }
    return touches;
}

/* One triangle after the other, of those in `which`. */
static vbits triangles_intersect(packet *c, const mesh_packet *m, const daft_facet *f, const daft_block *b, vbits which,
                                 vbits bits)
{
    facets each;
    vbits hits = 0;
    facets_store(&each, f);
    for (; which && bits; which &= which - 1) {
        uint32_t at = (uint32_t)__builtin_ctz(which), i = at % DAFT_BLOCK;
        const daft_block *block = b + at / DAFT_BLOCK;
        daft_edge_tests sides;
        if (block->triangle[i] == DAFT_NO_TRIANGLE) continue;
        vbits maybe = lanes_filter(&each, at, m, c->limit, &sides) & bits;
        if (!maybe) continue;
        vbits hit_now = lanes_exact(c, m, block, i, maybe, &sides);
        hits |= hit_now;
        if (c->any) bits &= ~hit_now;
    }
    return hits;
}

/* Blocks, at most DAFT_FOURS; gives the lanes that touch. */
static vbits blocks_intersect(packet *c, const mesh_packet *m, const packet_slabs *g, const daft_block *b, int count,
                              vbits bits)
{
    vf3 corner[3];
    vbits which = (1u << count * DAFT_BLOCK) - 1, hits = 0;
    daft_blocks_load(b, count, corner);
    if (g && g->tight) which &= boxes_met(corner, g);
    if (!which) return 0;
    daft_facet f = daft_facet_of(corner);
    if (__builtin_popcount(bits) >= __builtin_popcount(which)) return triangles_intersect(c, m, &f, b, which, bits);
    for (; bits; bits &= bits - 1)
        hits |= (vbits)ray_intersect(c, m, &f, b, which, first_lane(bits)) << first_lane(bits);
    return hits;
}

static vbits blocks_intersect_floats(packet *c, const mesh_packet *m, const daft_block *b, const daft_block *end,
                                     vbits bits)
{
    vbits hits = 0;
    for (; b < end && bits; b++) {
        for (uint32_t i = 0; i < DAFT_BLOCK && b->triangle[i] != DAFT_NO_TRIANGLE; i++) {
            vbits hit_now = lanes_floats(c, m, b, i, bits);
            hits |= hit_now;
            if (c->any) bits &= ~hit_now;
        }
    }
    return hits;
}

bool DAFT_KERNEL(daft_packet_leaf)(packet *c, const mesh_packet *m, const packet_slabs *g, uint32_t child, vbits bits)
{
    const daft_block *b = &m->instance->bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], *end = b + (child & 3) + 1;
    vbits hits = 0, now = bits;
    if (c->tlas->intersection != DAFT_INTERSECT_EXACT) {
        hits = blocks_intersect_floats(c, m, b, end, bits);
    } else {
        for (int left = (int)(end - b); left > 0 && now; b += DAFT_FOURS, left -= DAFT_FOURS) {
            hits |= blocks_intersect(c, m, g, b, daft_min_i(left, DAFT_FOURS), now);
            if (c->any) now = bits & ~hits;
        }
    }
    if (!hits) return false;
    if (c->any)
        mark_occluded(c, hits);
    else
        c->limit = vf_if_then_else(vm_from_bits(hits), past_lanes(vf_load(c->hit.t)), c->limit);
    return true;
}

/* ---- spheres ---- */

/* The rays in `bits` that a sphere stops in time, and where: sphere_distance of single_kernel.c in lanes. */
static vbits sphere_lanes(const packet *c, const daft_instance *s, vbits bits, vf *t)
{
    vd near[2], far[2], forward[2], excess[2];
    vd3 d[2], centre[2];
    const double r = (double)s->radius,
                 at[3] = {(double)s->to_frame.t[0], (double)s->to_frame.t[1], (double)s->to_frame.t[2]};
    for (int half = 0; half < 2; half++) {
        vd3 o = vd3_half(c->o, half), ray = vd3_half(c->d, half), to = {at[0] - o.x, at[1] - o.y, at[2] - o.z};
        forward[half] = to.x * ray.x + to.y * ray.y + to.z * ray.z;
        excess[half] = r * r * DAFT_SPHERE_OUTSIDE - (to.x * to.x + to.y * to.y + to.z * to.z);
        d[half] = ray, centre[half] = to;
    }
    vf zero = vf_set(0);
    bits &= ~vbits_from_mask(
        vm_and(vf_lt(vf_demote2(forward[0], forward[1]), zero), vf_lt(vf_demote2(excess[0], excess[1]), zero)));
    if (!bits || !(r > 0)) return 0;
    for (int half = 0; half < 2; half++) {
        vd3 ray = d[half], to = centre[half];
        vd dd = ray.x * ray.x + ray.y * ray.y + ray.z * ray.z, along = forward[half] / dd;
        vd3 aside = {to.x - ray.x * along, to.y - ray.y * along, to.z - ray.z * along};
        vd discriminant = r * r - (aside.x * aside.x + aside.y * aside.y + aside.z * aside.z);
        vd length = vd_sqrt(discriminant / dd);
        near[half] = along - length, far[half] = along + length; /* NaN: beside it */
    }
    vf first = vf_demote2(near[0], near[1]), second = vf_demote2(far[0], far[1]), tmax = vf_load(c->hit.t);
    vm outside = vm_and(vf_le(c->tmin, first), vf_le(first, tmax));
    vm inside = vm_and(vf_le(c->tmin, second), vf_le(second, tmax));
    *t = vf_if_then_else(outside, first, second);
    return bits & vbits_from_mask(vm_or(outside, inside));
}

void DAFT_KERNEL(daft_packet_sphere)(packet *c, uint32_t index, vbits bits)
{
    vf t;
    bits = sphere_lanes(c, &c->tlas->instances[index], bits, &t);
    if (c->any) {
        mark_occluded(c, bits);
        return;
    }
    packet_hits *f = &c->hit;
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        if (t[i] == f->t[i] && index > f->instance[i]) continue;
        f->t[i] = t[i], f->u[i] = f->v[i] = 0, f->instance[i] = index, f->triangle[i] = f->place[i] = 0;
        c->limit[i] = daft_past(t[i]);
    }
}

/* ---- what callers get: finish_hit of single_kernel.c in lanes ---- */

/* The corners that the lanes hit, side by side; nothing is known of the others' lanes. */
typedef struct corner_lanes {
    float at[3][3][DAFT_VL];
} corner_lanes;

static void corners_gather(corner_lanes *out, const packet_hits *f, const daft_instance *instance, vbits bits)
{
    for (; bits; bits &= bits - 1) {
        int lane = first_lane(bits);
        if (instance->kdtree) {
            for (int k = 0; k < 3; k++) {
                uint32_t v = instance->mesh->indices[3 * (size_t)f->triangle[lane] + (size_t)k];
                out->at[k][0][lane] = instance->mesh->x[v], out->at[k][1][lane] = instance->mesh->y[v];
                out->at[k][2][lane] = instance->mesh->z[v];
            }
            continue;
        }
        const float *from =
            &instance->bvh->blocks[f->place[lane] / DAFT_BLOCK].corner[0][0][f->place[lane] % DAFT_BLOCK];
        for (int i = 0; i < 9; i++) out->at[i / 3][i % 3][lane] = from[i * DAFT_BLOCK];
    }
}

static vf3 mesh_normals(const corner_lanes *corners, const daft_affine *map)
{
    bool shift = daft_is_translation(map);
    vf3 p[3];
    for (int k = 0; k < 3; k++) {
        vf3 c = {vf_load(corners->at[k][0]), vf_load(corners->at[k][1]), vf_load(corners->at[k][2])};
        if (!shift) c = (vf3){rows(map->m, c), rows(map->m + 3, c), rows(map->m + 6, c)};
        p[k] = (vf3){c.x + vf_set(map->t[0]), c.y + vf_set(map->t[1]), c.z + vf_set(map->t[2])};
    }
    return vf3_cross(vf3_sub(p[1], p[0]), vf3_sub(p[2], p[0]));
}

static vf3 normals_of(const packet *c, vbits hit)
{
    vf zero = vf_set(0);
    vf3 normal = {zero, zero, zero};
    corner_lanes corners;
    for (int i = 0; i < 9; i++) vf_store(corners.at[i / 3][i % 3], zero);
    while (hit) {
        uint32_t index = c->hit.instance[first_lane(hit)];
        const daft_instance *instance = &c->tlas->instances[index];
        vbits same = hit & vbits_from_mask(vi_eq(vi_load(c->hit.instance), vi_set((int32_t)index)));
        vf3 n;
        if (instance->mesh) {
            corners_gather(&corners, &c->hit, instance, same);
            n = mesh_normals(&corners, &instance->to_frame);
        } else {
            const float *centre = instance->to_frame.t;
            vf t = vf_load(c->hit.t);
            n = (vf3){c->o.x + c->d.x * t - vf_set(centre[0]), c->o.y + c->d.y * t - vf_set(centre[1]),
                      c->o.z + c->d.z * t - vf_set(centre[2])};
        }
        vm m = vm_from_bits(same);
        normal = (vf3){vf_if_then_else(m, n.x, normal.x), vf_if_then_else(m, n.y, normal.y),
                       vf_if_then_else(m, n.z, normal.z)};
        hit &= ~same;
    }
    return normal;
}

/* Eight numbers of each lane to where the active lanes' hits stand. */
static void hits_store(const vf numbers[8], vbits active, daft_hit *hits)
{
    _Static_assert(sizeof(daft_hit) == 8 * sizeof(float), "a hit is eight numbers");
    daft_hit aside[DAFT_VL] __attribute__((aligned(64)));
    bool all = active == DAFT_ALL_LANES && (uintptr_t)hits % 16 == 0;
    vf_store_interleaved8((float *)(all ? hits : aside), 8, numbers);
    if (all) return;
    for (; active; active &= active - 1) hits[first_lane(active)] = aside[first_lane(active)];
}

vbits DAFT_KERNEL(daft_packet_finish)(const packet *c, vbits active, daft_hit *hits)
{
    vi instance = vi_load(c->hit.instance);
    vbits hit = active & ~vbits_from_mask(vi_eq(instance, vi_set(-1)));
    vf3 n = {vf_set(0), vf_set(0), vf_set(0)};
    if (hit) n = normals_of(c, hit);
    vf numbers[8] = {vf_load(c->hit.t),
                     vf_load(c->hit.u),
                     vf_load(c->hit.v),
                     (vf)instance,
                     (vf)vi_load(c->hit.triangle),
                     n.x,
                     n.y,
                     n.z};
    hits_store(numbers, active, hits);
    return hit;
}
