/* Spheres and capsules in lanes: up to two points by the closest points of their cores, in world axes from the centre
 * of the round part (the first of two). Where these branch, all branches are taken and one is chosen. */
#include "math/simd/ops.h"
#include "sim/collide/manifold_round.h"

DAFT_INLINE vf3 add(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vf3 sub(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 scale(vf3 a, vf s) { return (vf3){a.x * s, a.y * s, a.z * s}; }
DAFT_INLINE vf3 select3(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_if_then_else(m, a.x, b.x), vf_if_then_else(m, a.y, b.y), vf_if_then_else(m, a.z, b.z)};
}
DAFT_INLINE vf3 load3(const daft_round_lanes *p, int lane)
{
    return (vf3){vf_load(p[0] + lane), vf_load(p[1] + lane), vf_load(p[2] + lane)};
}
DAFT_INLINE void store3(float p[3][DAFT_PAIR_LANES], int lane, vf3 v)
{
    vf_store(p[0] + lane, v.x);
    vf_store(p[1] + lane, v.y);
    vf_store(p[2] + lane, v.z);
}
DAFT_INLINE vf clamp1(vf x) { return vf_min(vf_max(x, vf_set(-1)), vf_set(1)); }
DAFT_INLINE vf over(vm good, vf a, vf b) { return a / vf_if_then_else(good, b, vf_set(1)); }

typedef struct outline {
    vf3 half, move;
    vf swing, radius;
} outline;

DAFT_INLINE outline load_outline(const daft_outline *all, const int32_t *index)
{
    vf row[8];
    int32_t at[DAFT_VL];
    for (int i = 0; i < DAFT_VL; i++) at[i] = 2 * index[i];
    vf_gather_rows8(&all->half.x, at, row);
    return (outline){{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, row[6], row[7]};
}

/* Bound of their displacement against each other within the step. */
DAFT_INLINE vf approach_of(const outline *a, const outline *b)
{
    vf3 d = sub(a->move, b->move);
    return vf_sqrt(vf3_dot(d, d)) + (a->swing + b->swing);
}

/* One or two points of a lane. */
typedef struct found {
    vf3 normal, point[DAFT_ROUND_POINTS];
    vf separation[DAFT_ROUND_POINTS];
    vi id[DAFT_ROUND_POINTS], count;
} found;

DAFT_INLINE void store_found(daft_found_lanes *to, int lane, const found *f)
{
    vi_store(to->count + lane, f->count);
    store3(to->normal, lane, f->normal);
    for (int i = 0; i < DAFT_ROUND_POINTS; i++) {
        store3(to->point[i], lane, f->point[i]);
        vf_store(to->separation[i] + lane, f->separation[i]);
        vi_store(to->id[i] + lane, f->id[i]);
    }
}

/* How near a lane's pair is looked at. What is fast is met where it is near already; what will be on its way is asked
 * apart. */
typedef struct looks {
    vf most;
    vm out; /* if not that near, it is asked */
} looks;

DAFT_INLINE looks looks_of(const daft_round_batch *batch, int lane, const outline *a, const outline *b)
{
    vf approach = approach_of(a, b), zero = vf_set(0);
    vm fast = vf_lt(vf_set(DAFT_ROUND_FAST) * vf_load(batch->reach + lane), approach);
    return (looks){vf_load(batch->margin + lane) + vf_if_then_else(fast, zero, approach),
                   vm_and(fast, vf_lt(zero, vf_load(batch->watched + lane)))};
}

DAFT_INLINE vm ask_of(vm near, vm unclear, vm out) { return vm_or(vm_and(near, unclear), vm_and(out, vm_not(near))); }

DAFT_INLINE bool store_state(daft_round_batch *batch, int lane, vm near, vm ask, vbits used)
{
    vi state = vi_if_then_else(near, vi_set(DAFT_ROUND_MET), vi_set(DAFT_ROUND_APART));
    vi_store(batch->state + lane, vi_if_then_else(ask, vi_set(DAFT_ROUND_ASK), state));
    return (vbits_from_mask(near) & ~vbits_from_mask(ask) & used) != 0;
}

/* Two points, of which those beyond `most` do not count. */
DAFT_INLINE void set_points(found *f, const vf3 point[2], const vf separation[2], const vi id[2], vm both, vf most)
{
    vm first = vf_le(separation[0], most), second = vm_and(both, vf_le(separation[1], most));
    vi one = vi_set(1), none = vi_set(0);
    f->count = vi_if_then_else(first, one, none) + vi_if_then_else(second, one, none);
    f->point[0] = select3(first, point[0], point[1]), f->point[1] = point[1];
    f->separation[0] = vf_if_then_else(first, separation[0], separation[1]), f->separation[1] = separation[1];
    f->id[0] = vi_if_then_else(first, id[0], id[1]), f->id[1] = id[1];
}

/* ---- against each other ---- */

typedef struct cores {
    outline a, b;
    vf3 toward;                               /* from a's centre to b's */
    vf square_a, square_b, along, at_a, at_b; /* half·half of a, of b, of both; toward·half of a, of b */
    vm long_a, long_b;
} cores;

DAFT_INLINE cores load_cores(const daft_outline *all, const daft_round_batch *batch, int lane)
{
    cores c = {.a = load_outline(all, batch->a + lane), .b = load_outline(all, batch->b + lane)};
    c.toward = load3(batch->toward, lane);
    c.square_a = vf3_dot(c.a.half, c.a.half), c.square_b = vf3_dot(c.b.half, c.b.half);
    c.along = vf3_dot(c.a.half, c.b.half);
    c.at_a = vf3_dot(c.toward, c.a.half), c.at_b = vf3_dot(c.toward, c.b.half);
    c.long_a = vf_lt(vf_set(0), c.square_a), c.long_b = vf_lt(vf_set(0), c.square_b);
    return c;
}

/* Closest points, -1 to 1 on each core, as in daft_segments_closest. */
DAFT_INLINE void closest(const cores *c, vf *s, vf *t)
{
    vf zero = vf_set(0), one = vf_set(1), product = c->square_a * c->square_b,
       determinant = product - c->along * c->along;
    vm crossing = vf_lt(vf_set(1e-6f) * product, determinant);
    vf cross = clamp1(over(crossing, c->at_a * c->square_b - c->along * c->at_b, determinant));
    vf middle = clamp1(over(c->long_a, c->at_a, c->square_a));
    *s = vf_if_then_else(crossing, cross, vf_if_then_else(vm_or(c->long_b, vm_not(c->long_a)), zero, middle));
    vf on_b = vf_if_then_else(c->long_b, over(c->long_b, c->along * *s - c->at_b, c->square_b), zero);
    vf end = clamp1(on_b);
    vm beyond = vf_lt(one, vf_abs(on_b));
    vf back = vf_if_then_else(c->long_a, clamp1(over(c->long_a, end * c->along + c->at_a, c->square_a)), zero);
    *s = vf_if_then_else(beyond, back, *s), *t = end;
}

/* Midway between both surfaces, at a place on each core. */
DAFT_INLINE vf3 between(const cores *c, vf3 on_a, vf3 on_b, vf3 n, vf *separation)
{
    *separation = vf3_dot(n, sub(on_b, on_a)) - (c->a.radius + c->b.radius);
    vf3 p = add(on_a, scale(n, c->a.radius)), q = sub(on_b, scale(n, c->b.radius));
    return scale(add(p, q), vf_set(0.5f));
}

/* Where two capsules lie side by side: both ends of the stretch they share. */
DAFT_INLINE vm side_by_side(const cores *c, vf3 n, vf most, found *f)
{
    vf one = vf_set(1), minus = vf_set(-1);
    vf3 h = c->a.half, g = c->b.half;
    vf3 turn = {h.y * g.z - h.z * g.y, h.z * g.x - h.x * g.z, h.x * g.y - h.y * g.x};
    vf limit = vf_set(DAFT_ROUND_PARALLEL * DAFT_ROUND_PARALLEL) * c->square_a * c->square_b;
    vm along = vm_and(vm_and(c->long_a, c->long_b), vf_le(vf3_dot(turn, turn), limit));
    vf slope = over(along, c->along, c->square_a), middle = over(along, c->at_a, c->square_a), wide = vf_abs(slope);
    vf end[2] = {vf_max(minus, middle - wide), vf_min(one, middle + wide)}, separation[2];
    along = vm_and(along, vf_lt(vf_set(DAFT_ROUND_SHARED) * vf_min(one, wide), end[1] - end[0]));
    vf3 point[2];
    for (int i = 0; i < 2; i++) {
        vf3 on_b = add(c->toward, scale(c->b.half, over(along, end[i] - middle, slope)));
        point[i] = between(c, scale(c->a.half, end[i]), on_b, n, &separation[i]);
    }
    set_points(f, point, separation, (vi[2]){vi_set(0), vi_set(1)}, along, most);
    return vm_and(along, vi_lt(vi_set(0), f->count));
}

DAFT_INLINE void one_point(const cores *c, vf s, vf t, vm alone, found *f)
{
    vf separation;
    vf3 on_b = add(c->toward, scale(c->b.half, t));
    f->point[0] = select3(alone, between(c, scale(c->a.half, s), on_b, f->normal, &separation), f->point[0]);
    f->separation[0] = vf_if_then_else(alone, separation, f->separation[0]);
    f->id[0] = vi_if_then_else(alone, vi_set(2), f->id[0]);
    f->count = vi_if_then_else(alone, vi_set(1), f->count);
}

static void rounds_lanes(const daft_outline *all, daft_round_batch *batch, int lane, vbits used)
{
    cores c = load_cores(all, batch, lane);
    vf s, t, rounding = c.a.radius + c.b.radius;
    looks l = looks_of(batch, lane, &c.a, &c.b);
    closest(&c, &s, &t);
    vf3 gap = sub(add(c.toward, scale(c.b.half, t)), scale(c.a.half, s));
    vf distance = vf_sqrt(vf3_dot(gap, gap)), one_place = vf_set(DAFT_ROUND_ONE_PLACE) * vf_load(batch->reach + lane);
    vm near = vf_le(distance - rounding, l.most);
    vm blurred = vm_or(vf_le(distance, vf_set(DAFT_ROUND_NEAR) * rounding),
                       vf_lt(vf3_dot(c.toward, c.toward), one_place * one_place));
    if (!store_state(batch, lane, near, ask_of(near, blurred, l.out), used)) return;
    found f;
    f.normal = scale(gap, over(vm_not(blurred), vf_set(1), distance));
    vm two = side_by_side(&c, f.normal, l.most, &f);
    one_point(&c, s, t, vm_not(two), &f);
    store_found(&batch->found, lane, &f);
}

/* ---- against boxes ---- */

/* A core along each axis of a box: how far its centre is beyond the high and the low face; and its half segment. */
typedef struct beside {
    vf high[3], low[3], d[3];
} beside;

/* From the box to the core's point at t, along one axis. */
DAFT_INLINE vf gap_along(const beside *s, int k, vf t)
{
    vf zero = vf_set(0), high = s->high[k] + t * s->d[k], low = s->low[k] - t * s->d[k];
    return vf_if_then_else(vf_lt(zero, high), high, vf_if_then_else(vf_lt(zero, low), -low, zero));
}
/* Half the slope of the squared distance there: it rises with t, in straight pieces. */
DAFT_INLINE vf slope_at(const beside *s, vf t)
{
    return s->d[0] * gap_along(s, 0, t) + s->d[1] * gap_along(s, 1, t) + s->d[2] * gap_along(s, 2, t);
}

/* Where on the core, -1 to 1, it is closest to the box: the slope's zero, between the places where it bends. */
DAFT_INLINE vf closest_to_box(const beside *s)
{
    vf zero = vf_set(0), first = vf_set(-1), last = vf_set(1), a = first, b = last;
    vf slope_a = slope_at(s, a), slope_b = slope_at(s, b);
    vm at_first = vf_le(zero, slope_a), at_last = vf_le(slope_b, zero);
    for (int i = 0; i < 6; i++) {
        int k = i / 2;
        vm there = vm_not(vf_le(vf_abs(s->d[k]), zero));
        vf t = over(there, i & 1 ? s->low[k] : -s->high[k], s->d[k]);
        vm within = vm_and(there, vm_and(vf_lt(a, t), vf_lt(t, b)));
        vf slope = slope_at(s, t);
        vm falls = vm_and(within, vf_lt(slope, zero)), rises = vm_and(within, vm_not(vf_lt(slope, zero)));
        a = vf_if_then_else(falls, t, a), slope_a = vf_if_then_else(falls, slope, slope_a);
        b = vf_if_then_else(rises, t, b), slope_b = vf_if_then_else(rises, slope, slope_b);
    }
    vf rise = slope_b - slope_a;
    vf between = a - over(vf_lt(zero, rise), slope_a * (b - a), rise);
    return vf_if_then_else(at_first, first, vf_if_then_else(at_last, last, between));
}

typedef struct meeting {
    beside s;
    outline round;
    vf3 turn[3]; /* the box's axes */
    vf gap[3];   /* from the box to the core's closest point, in the box's axes */
    vf distance, t, box_first;
    vf farthest; /* the greatest gap: along this axis: */
    vm axis[3];
    vm beside_face; /* beyond more than one face */
    vm beside_corner;
} meeting;

DAFT_INLINE void load_beside(const daft_round_batch *batch, int lane, meeting *m)
{
    for (int k = 0; k < 3; k++) {
        m->s.high[k] = vf_load(batch->high[k] + lane), m->s.low[k] = vf_load(batch->low[k] + lane);
        m->turn[k] = (vf3){vf_load(batch->turn[k] + lane), vf_load(batch->turn[3 + k] + lane),
                           vf_load(batch->turn[6 + k] + lane)};
        m->s.d[k] = vf3_dot(m->turn[k], m->round.half);
    }
    m->box_first = vf_load(batch->first + lane);
}

DAFT_INLINE void set_gap(meeting *m)
{
    vf zero = vf_set(0), square = zero, most = zero;
    vm none = vf_lt(zero, zero), some = none, several = none, all = vm_not(none);
    for (int k = 0; k < 3; k++) {
        m->gap[k] = gap_along(&m->s, k, m->t);
        vf size = vf_abs(m->gap[k]);
        square = square + m->gap[k] * m->gap[k];
        vm beyond = vf_lt(zero, size), larger = vf_lt(most, size);
        several = vm_or(several, vm_and(some, beyond)), some = vm_or(some, beyond), all = vm_and(all, beyond);
        for (int i = 0; i < k; i++) m->axis[i] = vm_and(m->axis[i], vm_not(larger));
        m->axis[k] = larger;
        most = vf_if_then_else(larger, size, most);
    }
    m->farthest = most, m->distance = vf_sqrt(square);
    m->beside_face = several, m->beside_corner = all;
}

/* The stretch of the core that is over the face along the meeting's axis. */
typedef struct stretch {
    vf from, to;
    vm some;
} stretch;

DAFT_INLINE stretch stretch_over(const meeting *m, vm capsule)
{
    vf zero = vf_set(0), one = vf_set(1), over_rim = vf_set(DAFT_ROUND_OVERHANG) * m->round.radius;
    stretch out = {vf_if_then_else(capsule, vf_set(-1), zero), vf_if_then_else(capsule, one, zero),
                   vm_not(vf_lt(one, zero))};
    for (int k = 0; k < 3; k++) {
        vf d = m->s.d[k], high = over_rim - m->s.high[k], low = m->s.low[k] - over_rim;
        vm across = vf_lt(zero, vf_abs(d)), over_it = vm_and(vf_le(zero, high), vf_le(low, zero));
        vf a = over(across, high, d), b = over(across, low, d);
        vm cuts = vm_and(across, vm_not(m->axis[k]));
        out.from = vf_if_then_else(cuts, vf_max(vf_min(a, b), out.from), out.from);
        out.to = vf_if_then_else(cuts, vf_min(vf_max(a, b), out.to), out.to);
        out.some = vm_and(out.some, vm_or(vm_or(across, over_it), m->axis[k]));
    }
    out.some = vm_and(out.some, vf_le(out.from, out.to));
    return out;
}

/* Over one face: both ends of the stretch that is. */
DAFT_INLINE void over_face(const meeting *m, const stretch *over_it, vm capsule, vf most, found *f)
{
    vf zero = vf_set(0), half = vf_set(0.5f);
    vf3 face = {zero, zero, zero}, point[2];
    vf separation[2];
    for (int k = 0; k < 3; k++) {
        vf3 out = scale(m->turn[k], vf_if_then_else(vf_lt(m->gap[k], zero), vf_set(-1), vf_set(1)));
        face = select3(m->axis[k], out, face);
    }
    for (int i = 0; i < 2; i++) {
        vf t = i ? over_it->to : over_it->from, high = zero;
        for (int k = 0; k < 3; k++) {
            vf move = t * m->s.d[k];
            vf above = vf_if_then_else(vf_lt(zero, m->gap[k]), m->s.high[k] + move, m->s.low[k] - move);
            high = vf_if_then_else(m->axis[k], above, high);
        }
        point[i] = sub(scale(m->round.half, t), scale(face, half * (high + m->round.radius)));
        separation[i] = high - m->round.radius;
    }
    f->normal = scale(face, m->box_first);
    vi low = vi_if_then_else(vf_lt(zero, m->box_first), vi_set(0), vi_set(1 << 30));
    set_points(f, point, separation, (vi[2]){low, low + vi_set(1)}, capsule, most);
}

/* Beside an edge or a corner. */
DAFT_INLINE void beside_edge(const meeting *m, vm here, vm capsule, found *f)
{
    vf zero = vf_set(0), inverse = over(vf_lt(zero, m->distance), vf_set(1), m->distance);
    vf3 away = {zero, zero, zero};
    for (int k = 0; k < 3; k++) away = add(away, scale(m->turn[k], m->gap[k] * inverse));
    vm inside = vm_and(capsule, vf_lt(vf_abs(m->t), vf_set(1)));
    vf3 at = sub(scale(m->round.half, m->t), scale(away, vf_set(0.5f) * (m->distance + m->round.radius)));
    vi id = vi_set(5 << 28) | vi_if_then_else(inside, vi_set(1), vi_set(0));
    f->normal = select3(here, scale(away, m->box_first), f->normal);
    f->point[0] = select3(here, at, f->point[0]);
    f->separation[0] = vf_if_then_else(here, m->distance - m->round.radius, f->separation[0]);
    f->id[0] = vi_if_then_else(here, id, f->id[0]);
    f->count = vi_if_then_else(here, vi_set(1), f->count);
}

static void boxes_lanes(const daft_outline *all, daft_round_batch *batch, int lane, vbits used)
{
    outline box = load_outline(all, batch->b + lane);
    meeting m = {.round = load_outline(all, batch->a + lane)};
    vf zero = vf_set(0);
    load_beside(batch, lane, &m);
    m.t = closest_to_box(&m.s);
    set_gap(&m);
    looks l = looks_of(batch, lane, &m.round, &box);
    vm near = vf_le(m.distance - m.round.radius, l.most);
    vf blur = vf_set(DAFT_ROUND_NEAR) * m.round.radius + vf_set(1e-6f) * vf_sqrt(vf3_dot(box.half, box.half));
    if (!store_state(batch, lane, near, ask_of(near, vf_le(m.distance, blur), l.out), used)) return;
    found f;
    vm capsule = vf_lt(zero, vf3_dot(m.round.half, m.round.half));
    vm nearly_over = vf_lt(vf_set(DAFT_ROUND_ALONG_FACE) * m.distance, m.farthest);
    stretch over_it = stretch_over(&m, capsule);
    over_face(&m, &over_it, capsule, l.most, &f);
    beside_edge(&m, vm_not(vm_and(over_it.some, vm_or(nearly_over, vm_not(m.beside_face)))), capsule, &f);
    vf3 toward = load3(batch->toward, lane), none = {zero, zero, zero};
    toward = select3(vf_lt(zero, m.box_first), toward, none);
    for (int i = 0; i < DAFT_ROUND_POINTS; i++) f.point[i] = add(f.point[i], toward);
    store_found(&batch->found, lane, &f);
}

static void rounds(const daft_outline *all, daft_round_batch *batch, int count)
{
    for (int lane = 0; lane < count; lane += DAFT_VL) rounds_lanes(all, batch, lane, vbits_first_n(count - lane));
}

static void boxes(const daft_outline *all, daft_round_batch *batch, int count)
{
    for (int lane = 0; lane < count; lane += DAFT_VL) boxes_lanes(all, batch, lane, vbits_first_n(count - lane));
}

const daft_round_kernels DAFT_KERNEL(daft_round) = {rounds, boxes};
