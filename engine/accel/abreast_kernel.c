/* Rays of a packet that go their own ways, from the upper level on: each step of one is followed by a step of another.
 *
 * A ray alone waits: for the boxes of one node before it knows the next, and, since nobody foresees which boxes it meets, for
 * wrong guesses to be taken back, which is a third of its time and more. So rays that are left alone take turns, and what a
 * step finds is no branch: the children met go onto the ray's stack by one compression and a network that sorts four of them,
 * where none is met what was on the stack is on top. After each round the rays are sorted by what is next, a node, a leaf,
 * the way into an instance or out of it, so each loop has one kind of step alone. What is next is kept as bits in
 * registers: written to memory it would have to come back before the next round. (Many rays at once, sorted by the kind of
 * step, is how GPUs are kept busy: Laine, Karras, Aila, "Megakernels Considered Harmful", 2013.)
 *
 * This takes a compression and registers that hold sixteen numbers or eight items of a stack: without AVX-512, where fewer rays
 * travel together, too, each would be slower than alone, so there is none of it.
 *
 * What a ray hits is what it hits by itself, bit for bit: see "Order" in ray_test.h. */
#include "accel/enter.h"
#include "accel/packet.h"

#ifdef DAFT_ISA_avx512

/* Where a ray is, as boxes see it: the origin for near and for far planes, one over the direction and minus the same widened,
 * so that entry is the largest product of the first kind and minus exit that of the second; and where it begins. A line of
 * the cache, read at once. */
typedef struct slab_line {
    float origin[2][3], scale[2][3], begin, none[3];
} __attribute__((aligned(64))) slab_line;

/* A ray on its way, in frame space, or in that of a mesh. */
typedef struct solo {
    slab_line upper, own;
    const slab_line *line;          /* the one of both that it is in */
    const size_t *rows, *upper_rows; /* see slab_way */
    const daft_node *nodes;
    uint64_t *top; /* behind its stack's last item; see ray_stack */
    float limit, square, off; /* of boxes; for spheres: the direction's square, and what they may be off by at least */
    uint32_t spheres;         /* bits of children that may be told by their spheres: all, or none where numbers may overflow */
    v4 origin, direction;
    daft_nearest hit;
    /* the mesh that it is in, and what was known before */
    const daft_bvh *bvh;
    daft_mesh_ray ray;
    uint32_t index, mark, triangle;
    float t;
} solo;

enum { FAR_APART = 20000 /* instances, more than caches near the core hold */ };
enum { ITEMS = 2 * (1 + DAFT_STACK + DAFT_WIDTH) + DAFT_WIDTH };

typedef struct crowd {
    solo solos[DAFT_VL];
    convoy *rays;
    vbits going, inside; /* on their way; of those, in a mesh */
    uint64_t items[DAFT_VL][ITEMS];
} crowd;

/* What is next: lanes whose next child is no node, and those where it is none. */
typedef struct schedule {
    vbits ends, none;
} schedule;

DAFT_INLINE void note(schedule *next, const crowd *w, uint32_t lane)
{
    uint32_t child = (uint32_t)w->solos[lane].top[-1];
    next->ends |= child >> 31 << lane, next->none |= (uint32_t)(child == DAFT_CHILD_NONE) << lane;
}

DAFT_INLINE float near_of(uint64_t item)
{
    union {
        uint32_t bits;
        float t;
    } near = {(uint32_t)(item >> 32)};
    return near.t;
}

/* ---- nodes ---- */

DAFT_INLINE void sort_items(uint64_t *items, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint64_t item = items[i];
        uint32_t k = i;
        for (; k > 0 && items[k - 1] < item; k--) items[k] = items[k - 1];
        items[k] = item;
    }
}

/* The children in bits, the nearest last; where any hit is asked for, as they come. Up to eight items from `top` on may be
 * written. */
DAFT_INLINE __m512i exchange(__m512i items, __m512i others, __mmask8 less)
{
    return _mm512_mask_min_epu64(_mm512_max_epu64(items, others), less, items, others);
}

DAFT_INLINE uint64_t *push(uint64_t *top, const daft_node *node, uint32_t bits, v8 near, bool any)
{
    uint32_t count = (uint32_t)__builtin_popcount(bits);
    __m512i child = _mm512_cvtepu32_epi64(_mm256_loadu_si256((const __m256i *)node->child));
    __m512i items = _mm512_or_si512(_mm512_slli_epi64(_mm512_cvtepu32_epi64((__m256i)near), 32), child);
    items = _mm512_maskz_compress_epi64((__mmask8)bits, items);
    if (!any) {
        items = exchange(items, _mm512_shuffle_epi32(items, 0x4e), 0xaa);
        items = exchange(items, _mm512_permutex_epi64(items, 0x4e), 0xcc);
        items = exchange(items, _mm512_permutex_epi64(items, 0xd8), 0x44);
    }
    _mm512_storeu_si512(top, items);
    if (!any && __builtin_expect(count > 4, 0)) sort_items(top, count);
    return top + count;
}

/* Bits of the children that the ray meets. */
DAFT_INLINE uint32_t boxes_met(const char *node, const solo *s, v8 *near)
{
#define BOTH(a, b) \
    _mm512_permutexvar_ps(_mm512_setr_epi32(a, a, a, a, a, a, a, a, b, b, b, b, b, b, b, b), line)
#define SLABS(k) \
    _mm512_mul_ps(_mm512_sub_ps(_mm512_insertf32x8(_mm512_castps256_ps512((__m256)planes(node, s->rows[k])), \
                                                   (__m256)planes(node, s->rows[3 + (k)]), 1), \
                                BOTH(k, 3 + (k))), BOTH(6 + (k), 9 + (k)))
    __m512 line = _mm512_load_ps(s->line->origin[0]);
    __m512 ends = _mm512_mask_mov_ps(BOTH(12, 12), 0xff00, _mm512_set1_ps(-s->limit));
    __m512 both = _mm512_max_ps(_mm512_max_ps(SLABS(0), SLABS(1)), _mm512_max_ps(SLABS(2), ends));
#undef SLABS
#undef BOTH
    *near = (v8)_mm512_castps512_ps256(both);
    return v8_le_bits(*near, -(v8)_mm512_extractf32x8_ps(both, 1));
}

DAFT_INLINE sphere_view solo_spheres(const solo *s)
{
    v4 o = s->origin + s->origin, d = s->direction;
    return (sphere_view){v8_set(o[0]), v8_set(o[1]), v8_set(o[2]), v8_set(d[0]), v8_set(d[1]), v8_set(d[2]),
                         v8_set(s->square), v8_set(s->off), 0, true};
}

DAFT_INLINE void node_step(solo *s, bool any)
{
    uint64_t *top = s->top - 1;
    const daft_node *node = &s->nodes[(uint32_t)*top];
    v8 near;
    uint32_t bits = boxes_met((const char *)node, s, &near);
    if (bits & node->spheres & s->spheres) {
        sphere_view view = solo_spheres(s);
        sphere_sight sight = spheres_seen(node, &view);
        bits = spheres_met(node, bits, &sight, &view);
    }
    s->top = push(top, node, bits, near, any);
}

/* ---- leaves and instances: what is asked for any hit says whether there is one ---- */

DAFT_INLINE bool leaf_step(solo *s, bool any)
{
    uint64_t item = *--s->top;
    if (any) return leaf_stops(s->bvh->blocks, (uint32_t)item, &s->ray, s->limit, &s->hit);
    if (near_of(item) <= s->limit && leaf_closest(s->bvh->blocks, (uint32_t)item, &s->ray, s->limit, &s->hit))
        s->limit = limit_of(s->hit.t, true);
    return false;
}

/* By itself: into what is no mesh with a tree along its own axes, or with numbers that are not plain there. */
static __attribute__((noinline)) bool enter_alone(const crowd *w, uint32_t lane, solo *s, uint32_t index, bool any)
{
    const daft_tlas *tlas = w->rays->tlas;
    const daft_instance *instance = &tlas->instances[index];
    const daft_ray ray = lane_ray(w->rays, (int)lane);
    if (any && !instance->mesh) return sphere_distance(instance, &ray, ray.tmin, ray.tmax) >= 0;
    if (any) return DAFT_KERNEL(daft_instance_occluded)(tlas, index, &ray);
    if (instance->mesh) {
        DAFT_KERNEL(daft_instance_closest)(tlas, index, &ray, &s->hit);
    } else {
        float t = sphere_distance(instance, &ray, ray.tmin, s->hit.t);
        if (t < 0 || (t == s->hit.t && index > s->hit.instance)) return false;
        s->hit = (daft_nearest){.t = t, .instance = index};
    }
    s->limit = limit_of(s->hit.t, true);
    return false;
}

/* Written as it is read: what is written in pieces cannot be read at once before it has left for the cache. */
DAFT_INLINE void own_line(slab_line *line, v4 o, v4 inverse, float begin)
{
    v4 wide = inverse * v4_set(DAFT_WIDEN);
    const __m512i from = _mm512_setr_epi32(0, 1, 2, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 12, 12, 12);
    __m512 all = _mm512_castps128_ps512((__m128)o);
    all = _mm512_insertf32x4(all, (__m128)-inverse, 1);
    all = _mm512_insertf32x4(all, (__m128)wide, 2);
    all = _mm512_insertf32x4(all, (__m128)v4_set(begin), 3);
    _mm512_store_ps(line->origin[0], _mm512_permutexvar_ps(from, all));
}

DAFT_INLINE bool enter(crowd *w, uint32_t lane, solo *s, uint32_t index, bool any)
{
    const convoy *c = w->rays;
    const daft_instance *instance = &c->tlas->instances[index];
    if (index == c->ignore || (any && !(instance->flags & DAFT_INSTANCE_CASTS_SHADOW))) return false;
    if (!instance->mesh || instance->kdtree) return enter_alone(w, lane, s, index, any);
    lined_ray frame = {.origin = s->origin, .direction = s->direction}, own;
    bool finite;
    if (daft_is_shift(&instance->to_object)) {
        own.origin = s->origin + shift_of(&instance->to_object), own.direction = s->direction;
        own.way = slab_way_of(own.direction, minus_inverse(own.direction));
        finite = finite_lanes(own.origin, own.origin);
    } else {
        finite = turn(&instance->to_object, &frame, &own);
    }
    if (!finite) return false;
    if (!own.way.plain) return enter_alone(w, lane, s, index, any);
    own_line(&s->own, own.origin, minus_inverse(own.direction), s->upper.begin);
    s->line = &s->own, s->rows = own.way.rows, s->bvh = instance->bvh, s->nodes = s->bvh->nodes.items;
    daft_vec3 o = {own.origin[0], own.origin[1], own.origin[2]}, d = {own.direction[0], own.direction[1], own.direction[2]};
    s->ray = daft_mesh_ray_of(o, d, c->tmin[lane], s->hit.t, c->tlas->intersection);
    s->index = index, s->t = s->hit.t, s->triangle = s->hit.triangle;
    s->hit.triangle = s->mark = index < s->hit.instance ? DAFT_NO_TRIANGLE : 0; /* a tie goes to the lower instance */
    w->inside |= (vbits)1 << lane;
    s->top[0] = STACK_END, s->top[1] = first_child(s->bvh, 0), s->top += 2;
    return false;
}

DAFT_INLINE bool enter_step(crowd *w, uint32_t lane, bool any)
{
    solo *s = &w->solos[lane];
    uint64_t item = *--s->top;
    return near_of(item) <= s->limit && enter(w, lane, s, (uint32_t)item & ~DAFT_CHILD_LEAF, any);
}

DAFT_INLINE void leave(crowd *w, uint32_t lane)
{
    solo *s = &w->solos[lane];
    bool changed = s->hit.t < s->t || s->hit.triangle != s->mark;
    s->hit.instance = changed ? s->index : s->hit.instance;
    s->hit.triangle = changed ? s->hit.triangle : s->triangle;
    s->line = &s->upper, s->rows = s->upper_rows, s->nodes = w->rays->tlas->nodes.items;
    w->inside &= ~((vbits)1 << lane), s->top--;
}

DAFT_INLINE void stopped(crowd *w, uint32_t lane)
{
    stop(w->rays, (vbits)1 << lane);
    w->going &= ~((vbits)1 << lane);
}

/* ---- all of them ---- */

typedef struct lane_list {
    uint32_t lanes[DAFT_VL], count;
} lane_list;

DAFT_INLINE void list_lanes(lane_list *list, vbits lanes)
{
    _mm512_storeu_si512(list->lanes, _mm512_maskz_compress_epi32((__mmask16)lanes, (__m512i)vi_iota()));
    list->count = (uint32_t)__builtin_popcount(lanes);
}

/* Where there are so many instances that they come from far, what is next among them is on its way while others take steps. */
DAFT_INLINE void instance_fetch(const crowd *w, uint32_t lane)
{
    const daft_tlas *tlas = w->rays->tlas;
    uint32_t child = (uint32_t)w->solos[lane].top[-1 - (int)(w->inside >> lane & 1)], number = child & ~DAFT_CHILD_LEAF;
    if (child == DAFT_CHILD_NONE) return;
    const char *at = child & DAFT_CHILD_LEAF ? (const char *)&tlas->instances[number] : (const char *)&tlas->nodes.items[number];
    for (size_t i = 0; i < sizeof(daft_instance); i += 64) __builtin_prefetch(at + i);
}

/* A ray with nothing on its stack leaves the mesh or is done. */
DAFT_INLINE void rounds(crowd *w, schedule next, bool any)
{
    const bool far = w->rays->tlas->instance_count > FAR_APART;
    while (w->going) {
        lane_list nodes, leaves, outs, ins;
        vbits in = w->inside, ends = next.ends & ~next.none;
        w->going &= in | ~next.none;
        list_lanes(&nodes, w->going & ~next.ends), list_lanes(&leaves, w->going & ends & in);
        list_lanes(&outs, w->going & next.none), list_lanes(&ins, w->going & ends & ~in);
        next = (schedule){0, 0};
        for (uint32_t k = 0; far && k < outs.count; k++) instance_fetch(w, outs.lanes[k]);
        for (uint32_t k = 0; far && k < ins.count; k++) instance_fetch(w, ins.lanes[k]);
        for (uint32_t k = 0; k < nodes.count; k++) {
            node_step(&w->solos[nodes.lanes[k]], any);
            note(&next, w, nodes.lanes[k]);
        }
        for (uint32_t k = 0; k < leaves.count; k++) {
            if (leaf_step(&w->solos[leaves.lanes[k]], any)) stopped(w, leaves.lanes[k]);
            note(&next, w, leaves.lanes[k]);
        }
        for (uint32_t k = 0; k < outs.count; k++) {
            leave(w, outs.lanes[k]);
            note(&next, w, outs.lanes[k]);
        }
        for (uint32_t k = 0; k < ins.count; k++) {
            if (enter_step(w, ins.lanes[k], any)) stopped(w, ins.lanes[k]);
            note(&next, w, ins.lanes[k]);
        }
    }
}

/* The rays in frame space, from `child` on. */
static void begin(crowd *w, convoy *c, uint32_t child, vbits bits)
{
    const vf o[3] = {c->o.x, c->o.y, c->o.z}, d[3] = {c->d.x, c->d.y, c->d.z};
    vf near[3], far[3], size = vf3_magnitude(c->d), way = vf3_magnitude(c->o), pad = way * vf_set(0x1p-20f); /* slab_upper_origins */
    vf square = vf3_dot(c->d, c->d), off = way * vf_set(2 * DAFT_SPHERE_OFF);
    vbits usual = vbits_from_mask(vm_and(vm_and(vf_lt(vf_set(0x1p-26f), size), vf_lt(size, vf_set(0x1p26f))),
                                 vf_lt(way, vf_set(DAFT_SPHERE_FAR / 2))));
    for (int k = 0; k < 3; k++) {
        vf outwards = (vf)((vi)pad | ((vi)d[k] & vi_set(INT32_MIN)));
        near[k] = o[k] + outwards, far[k] = o[k] - outwards;
    }
    w->rays = c, w->going = bits, w->inside = 0;
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        solo *s = &w->solos[i];
        s->upper.begin = c->tmin[i] * (1 - 0x1p-17f);
        s->origin = (v4){o[0][i], o[1][i], o[2][i], 0}, s->direction = (v4){d[0][i], d[1][i], d[2][i], 0};
        for (int k = 0; k < 3; k++) {
            s->upper.origin[0][k] = near[k][i], s->upper.origin[1][k] = far[k][i];
            s->upper.scale[0][k] = c->inverse[k][i], s->upper.scale[1][k] = -c->inverse[k][i] * DAFT_WIDEN;
        }
        s->line = &s->upper, s->rows = s->upper_rows = slab_way_of(s->direction, s->direction).rows;
        s->nodes = c->tlas->nodes.items;
        s->square = square[i], s->off = off[i], s->spheres = usual >> i & 1 ? 0xff : 0;
        s->hit = lane_nearest(c, i), s->limit = limit_of(s->hit.t, true);
        w->items[i][0] = STACK_END, w->items[i][1] = child, s->top = &w->items[i][2];
    }
}

void DAFT_KERNEL(daft_abreast)(convoy *c, uint32_t child, vbits bits)
{
    crowd w;
    schedule next = {child & DAFT_CHILD_LEAF ? bits : 0, 0};
    begin(&w, c, child, bits);
    if (c->any) {
        rounds(&w, next, true);
        return;
    }
    rounds(&w, next, false);
    for (; bits; bits &= bits - 1) {
        int i = first_lane(bits);
        const daft_nearest *n = &w.solos[i].hit;
        lane_take(c, i, n, n->instance == UINT32_MAX ? NULL : c->tlas->instances[n->instance].bvh);
    }
}
#endif
