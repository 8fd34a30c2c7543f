/* Box against box in lanes, many pairs side by side: the fifteen axes of two boxes (Gottschalk, Lin and Manocha,
 * "OBBTree", 1996), then what one face and the rectangle of the other share, at most four points, or one point where
 * two edges cross; and their positions in the world.
 *
 * A box much larger than the other is cut down to what is near the other before anything else, in double: what was 500
 * m of lever times a rounding error is gone, and every float below is of the size of the smaller box. */
#include "math/simd/ops.h"
#include "sim/collide/manifold_box.h"

typedef struct pair {
    vf ha[3], hb[3]; /* half edges */
    vf r[3][3];      /* b's axes are the columns, in a */
    vf p[3], q[3];   /* b's centre in a; a's centre in b */
    vf shift[3];     /* of a's centre, by cutting down */
    vf margin;
    vm large_b; /* it was cut down */
} pair;

DAFT_INLINE vf at(const float lanes[DAFT_PAIR_LANES], int lane) { return vf_load(lanes + lane); }
DAFT_INLINE vf dot3(vf a0, vf b0, vf a1, vf b1, vf a2, vf b2) { return (a0 * b0 + a1 * b1) + a2 * b2; }

/* ---- where b is, in double ---- */

typedef struct half_pair {
    vd r[9], p[3], q[3], ha[3], hb[3], ball_a, ball_b;
} half_pair;

DAFT_INLINE vd length_of(const vd h[3]) { return vd_sqrt((h[0] * h[0] + h[1] * h[1]) + h[2] * h[2]); }

/* As daft_relpose_make, but for a's centre in b where that is given. */
DAFT_INLINE half_pair relate(const daft_box_batch *batch, const pair *s, int lane, int half)
{
    half_pair out;
    vd a[12], b[12], d[3];
    int first = lane + half * (DAFT_VL / 2);
    for (int i = 0; i < 12; i++) a[i] = vd_load(batch->a[i] + first), b[i] = vd_load(batch->b[i] + first);
    const vd *m = a + 3, *n = b + 3;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out.r[3 * i + j] = (m[i] * n[j] + m[3 + i] * n[3 + j]) + m[6 + i] * n[6 + j];
    for (int k = 0; k < 3; k++) d[k] = b[k] - a[k];
    for (int k = 0; k < 3; k++) out.p[k] = (m[k] * d[0] + m[3 + k] * d[1]) + m[6 + k] * d[2];
    for (int k = 0; k < 3; k++) d[k] = a[k] - b[k];
    for (int k = 0; k < 3; k++)
        out.q[k] = batch->posed ? vd_load(batch->q[k] + first) : (n[k] * d[0] + n[3 + k] * d[1]) + n[6 + k] * d[2];
    for (int k = 0; k < 3; k++)
        out.ha[k] = vd_promote_half(s->ha[k], half), out.hb[k] = vd_promote_half(s->hb[k], half);
    out.ball_a = length_of(out.ha), out.ball_b = length_of(out.hb);
    return out;
}

/* ---- cut down, in double ---- */

/* Farther than `depth` from all faces: rounding does not matter there, the direction out does. */
DAFT_INLINE vl deep(const vd p[3], const vd h[3], vd depth)
{
    vl out = vd_abs(p[0]) <= h[0] - depth;
    for (int k = 1; k < 3; k++) out &= vd_abs(p[k]) <= h[k] - depth;
    return out;
}

/* Cuts box h, seen from whose centre the other's is at c, down to what is within reach of c, where `large` says so.
 * Moves the centre by shift; 0 elsewhere. */
DAFT_INLINE void cut_down(vd h[3], vd c[3], vd reach, vl large, vd shift[3])
{
    for (int k = 0; k < 3; k++) {
        vd low = vd_max(-h[k], c[k] - reach), high = -vd_max(-h[k], -(c[k] + reach));
        h[k] = vd_if_then_else(large, (high - low) / 2, h[k]);
        shift[k] = vd_if_then_else(large, (high + low) / 2, vd_set(0));
        c[k] -= shift[k];
    }
}

/* Of the boxes that are large beside the other, as the lanes of `large` say, those that the other is not deep in. */
typedef struct cut {
    vf large_a, large_b; /* 1 or 0 */
    vd shift[2][3];
    vd b[2]; /* b was cut: 1, else 0 */
} cut;

DAFT_INLINE void cut_half(half_pair *p, const pair *s, cut *c, int half)
{
    vd none[3] = {vd_set(0), vd_set(0), vd_set(0)}, zero = vd_set(0), many = vd_set(DAFT_BOX_LARGE), r[3][3];
    vl b = (vd_promote_half(c->large_b, half) > zero) & ~deep(p->q, p->hb, 2 * p->ball_a);
    vl a = (vd_promote_half(c->large_a, half) > zero) & ~deep(p->p, p->ha, 2 * p->ball_b);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) r[i][j] = vd_promote_half(s->r[i][j], half);
    cut_down(p->hb, p->q, many * p->ball_a + vd_promote_half(s->margin, half), b, none);
    cut_down(p->ha, p->p, many * p->ball_b + vd_promote_half(s->margin, half), a, c->shift[half]);
    vd from_q[3], from_p[3];
    for (int k = 0; k < 3; k++) {
        from_q[k] = -((r[k][0] * p->q[0] + r[k][1] * p->q[1]) + r[k][2] * p->q[2]);
        from_p[k] = -((r[0][k] * p->p[0] + r[1][k] * p->p[1]) + r[2][k] * p->p[2]);
    }
    for (int k = 0; k < 3; k++)
        p->p[k] = vd_if_then_else(b, from_q[k], p->p[k]), p->q[k] = vd_if_then_else(a, from_p[k], p->q[k]);
    c->b[half] = vd_if_then_else(b, zero + 1, zero);
}

DAFT_INLINE vf largest(const vf h[3]) { return vf_max(h[2], vf_max(h[0], h[1])); }

DAFT_INLINE void cut_large(pair *s, half_pair *low, half_pair *high)
{
    vf la = largest(s->ha), lb = largest(s->hb), times = vf_set(DAFT_BOX_LARGE), zero = vf_set(0), one = vf_set(1);
    vm large_a = vf_lt(times * lb, la), large_b = vf_lt(times * la, lb);
    for (int k = 0; k < 3; k++) s->shift[k] = zero;
    s->large_b = vf_lt(zero, zero);
    if (!vbits_from_mask(vm_or(large_a, large_b))) return;
    cut c = {.large_a = vf_if_then_else(large_a, one, zero), .large_b = vf_if_then_else(large_b, one, zero)};
    cut_half(low, s, &c, 0);
    cut_half(high, s, &c, 1);
    for (int k = 0; k < 3; k++) {
        s->ha[k] = vf_demote2(low->ha[k], high->ha[k]), s->hb[k] = vf_demote2(low->hb[k], high->hb[k]);
        s->shift[k] = vf_demote2(c.shift[0][k], c.shift[1][k]);
    }
    s->large_b = vf_lt(zero, vf_demote2(c.b[0], c.b[1]));
}

DAFT_INLINE void load_pair(const daft_box_batch *batch, int lane, pair *s)
{
    for (int k = 0; k < 3; k++) s->ha[k] = at(batch->half_a[k], lane), s->hb[k] = at(batch->half_b[k], lane);
    s->margin = at(batch->margin, lane);
    half_pair low = relate(batch, s, lane, 0), high = relate(batch, s, lane, 1);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) s->r[i][j] = vf_demote2(low.r[3 * i + j], high.r[3 * i + j]);
    cut_large(s, &low, &high);
    for (int k = 0; k < 3; k++) s->p[k] = vf_demote2(low.p[k], high.p[k]), s->q[k] = vf_demote2(low.q[k], high.q[k]);
}

/* ---- the axes ---- */

typedef struct best_axis {
    vf separation;
    vi number;
} best_axis;

DAFT_INLINE void try_axis(best_axis *best, vf separation, int number)
{
    vm better = vf_lt(best->separation, separation);
    best->separation = vf_if_then_else(better, separation, best->separation);
    best->number = vi_if_then_else(better, vi_set(number), best->number);
}

DAFT_INLINE best_axis faces_a(const pair *s, const vf m[3][3])
{
    best_axis best;
    for (int i = 0; i < 3; i++) {
        vf reach = dot3(m[i][0], s->hb[0], m[i][1], s->hb[1], m[i][2], s->hb[2]);
        vf separation = (vf_abs(s->p[i]) - s->ha[i]) - reach;
        if (i == 0)
            best = (best_axis){separation, vi_set(0)};
        else
            try_axis(&best, separation, i);
    }
    return best;
}

DAFT_INLINE best_axis faces_b(const pair *s, const vf m[3][3])
{
    best_axis best;
    for (int j = 0; j < 3; j++) {
        vf reach = dot3(m[0][j], s->ha[0], m[1][j], s->ha[1], m[2][j], s->ha[2]);
        vf separation = (vf_abs(s->q[j]) - s->hb[j]) - reach;
        if (j == 0)
            best = (best_axis){separation, vi_set(0)};
        else
            try_axis(&best, separation, j);
    }
    return best;
}

DAFT_INLINE best_axis edges(const pair *s, const vf m[3][3])
{
    best_axis best = {vf_set(-INFINITY), vi_set(0)};
    vf one = vf_set(1);
    for (int i = 0; i < 3; i++) {
        int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; j++) {
            int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            vf distance = vf_abs(s->p[i2] * s->r[i1][j] - s->p[i1] * s->r[i2][j]);
            vf reach_a = s->ha[i1] * m[i2][j] + s->ha[i2] * m[i1][j];
            vf square = one - s->r[i][j] * s->r[i][j], reach_b = s->hb[j1] * m[i][j2] + s->hb[j2] * m[i][j1];
            vm crossing = vf_lt(vf_set(DAFT_BOX_PARALLEL), square);
            vf length = vf_sqrt(vf_if_then_else(crossing, square, one));
            vf separation = ((distance - reach_a) - reach_b) / length;
            try_axis(&best, vf_if_then_else(crossing, separation, vf_set(-INFINITY)), 3 * i + j);
        }
    }
    return best;
}

/* ---- choice ---- */

typedef struct choice {
    vm meet; /* no axis is over the margin; else no manifold */
    vi kind;
    vi number; /* of the axis */
    vf separation;
} choice;

DAFT_INLINE vi choose(best_axis a, best_axis b, best_axis e, vf even, vi before, vm large_b)
{
    vf zero = vf_set(0), face = vf_max(a.separation, b.separation);
    vf beyond = vf_if_then_else(vf_lt(face, zero), vf_set(1 - DAFT_EDGE_FRACTION) * face, face);
    vm none = vi_eq(before, vi_set(DAFT_AXIS_NONE)), crossed = vi_eq(before, vi_set(DAFT_AXIS_EDGES));
    vf more = vf_if_then_else(none, even, vf_if_then_else(crossed, -even, vf_set(2) * even));
    vm crosses = vm_and(vf_lt(beyond + more, e.separation), vm_or(vm_not(crossed), vf_lt(face, zero)));
    /* The larger box's face is the more exact one. */
    vm rather_b = vm_and(large_b, vm_not(vi_eq(before, vi_set(DAFT_AXIS_FACE_A))));
    rather_b = vm_or(rather_b, vi_eq(before, vi_set(DAFT_AXIS_FACE_B)));
    vm by_b = vf_lt(a.separation + vf_if_then_else(rather_b, -even, even), b.separation);
    vi kind = vi_if_then_else(by_b, vi_set(DAFT_AXIS_FACE_B), vi_set(DAFT_AXIS_FACE_A));
    return vi_if_then_else(crosses, vi_set(DAFT_AXIS_EDGES), kind);
}

DAFT_INLINE choice find_axis(const pair *s, vi before)
{
    vf m[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[i][j] = vf_abs(s->r[i][j]);
    best_axis a = faces_a(s, m), b = faces_b(s, m), e = edges(s, m);
    vf least = vf_min(largest(s->ha), largest(s->hb));
    vi kind = choose(a, b, e, vf_set(DAFT_BOX_EVEN) * least, before, s->large_b);
    vm by_a = vf_lt(s->margin, a.separation), by_b = vf_lt(s->margin, b.separation);
    vm by_e = vf_lt(s->margin, e.separation), over = vm_or(vm_or(by_a, by_b), by_e);
    vi axis = vi_if_then_else(by_a, vi_set(DAFT_AXIS_FACE_A),
                              vi_if_then_else(by_b, vi_set(DAFT_AXIS_FACE_B), vi_set(DAFT_AXIS_EDGES)));
    kind = vi_if_then_else(over, axis, kind);
    vm is_b = vi_eq(kind, vi_set(DAFT_AXIS_FACE_B)), is_e = vi_eq(kind, vi_set(DAFT_AXIS_EDGES));
    best_axis best = {vf_if_then_else(is_e, e.separation, vf_if_then_else(is_b, b.separation, a.separation)),
                      vi_if_then_else(is_e, e.number, vi_if_then_else(is_b, b.number, a.number))};
    return (choice){.meet = vm_not(over), .kind = kind, .number = best.number, .separation = best.separation};
}

/* ---- a face ---- */

/* Numbers that go round with an axis: the one of the axis first. */
typedef struct turn {
    vm one, two; /* the axis is 1, is 2 */
} turn;

DAFT_INLINE turn turn_to(vi axis) { return (turn){vi_eq(axis, vi_set(1)), vi_eq(axis, vi_set(2))}; }
DAFT_INLINE void turn_round(turn t, const vf x[3], vf out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = vf_if_then_else(t.two, x[(k + 2) % 3], vf_if_then_else(t.one, x[(k + 1) % 3], x[k]));
}
DAFT_INLINE void turn_back(turn t, const vf x[3], vf out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = vf_if_then_else(t.two, x[(k + 1) % 3], vf_if_then_else(t.one, x[(k + 2) % 3], x[k]));
}

/* One box's face, and the other box as seen from the first. All from the axis on: 0 along it, 1 and 2 in the plane. */
typedef struct reference {
    vm of_b;
    turn axis;
    vf half[3], other[3], centre[3], m[3][3], sign;
} reference;

/* The incident face as seen from the reference: u and v in its plane, w above it. Corners are base ± a ± b. */
typedef struct outline {
    vf base[3], a[3], b[3]; /* u, v, w */
} outline;

typedef struct overlap {
    float u[DAFT_BOX_FARTHEST + 1][DAFT_VL] __attribute__((aligned(64)));
    float v[DAFT_BOX_FARTHEST + 1][DAFT_VL] __attribute__((aligned(64)));
    float w[DAFT_BOX_FARTHEST + 1][DAFT_VL] __attribute__((aligned(64)));
    vm there[DAFT_BOX_FARTHEST];
} overlap;

DAFT_INLINE void set_reference(const pair *s, const choice *c, reference *f)
{
    vm of_b = vi_eq(c->kind, vi_set(DAFT_AXIS_FACE_B));
    vf half[3], centre[3], m[3][3];
    f->of_b = of_b;
    f->axis = turn_to(c->number);
    for (int i = 0; i < 3; i++) {
        half[i] = vf_if_then_else(of_b, s->hb[i], s->ha[i]);
        f->other[i] = vf_if_then_else(of_b, s->ha[i], s->hb[i]);
        centre[i] = vf_if_then_else(of_b, s->q[i], s->p[i]);
    }
    for (int j = 0; j < 3; j++) {
        vf column[3], turned[3];
        for (int i = 0; i < 3; i++) column[i] = vf_if_then_else(of_b, s->r[j][i], s->r[i][j]);
        turn_round(f->axis, column, turned);
        for (int i = 0; i < 3; i++) m[i][j] = turned[i];
    }
    memcpy(f->m, m, sizeof m);
    turn_round(f->axis, half, f->half);
    turn_round(f->axis, centre, f->centre);
    f->sign = vf_if_then_else(vf_lt(f->centre[0], vf_set(0)), vf_set(-1), vf_set(1));
}

/* Gives features of the ids: the axis of the face and of the incident one, with signs. */
DAFT_INLINE vi set_outline(const reference *f, vi axis, outline *o)
{
    vf row[3] = {vf_abs(f->m[0][0]), vf_abs(f->m[0][1]), vf_abs(f->m[0][2])}, zero = vf_set(0);
    vm one = vf_lt(row[0], row[1]), two = vf_lt(vf_if_then_else(one, row[1], row[0]), row[2]);
    turn to = {vm_and(one, vm_not(two)), two};
    vf other[3], m[3][3];
    turn_round(to, f->other, other);
    for (int k = 0; k < 3; k++) turn_round(to, f->m[k], m[k]);
    vm inward = vf_lt(zero, f->sign * m[0][0]);
    vf out = vf_if_then_else(inward, vf_set(-1), vf_set(1)) * other[0];
    for (int n = 0; n < 3; n++) {
        int k = (n + 1) % 3;
        o->base[n] = f->centre[k] + out * m[k][0];
        o->a[n] = other[1] * m[k][1], o->b[n] = other[2] * m[k][2];
    }
    o->base[2] = f->sign * o->base[2] - f->half[0];
    o->a[2] = f->sign * o->a[2], o->b[2] = f->sign * o->b[2];
    vi none = vi_set(0), j = vi_if_then_else(to.two, vi_set(2), vi_if_then_else(to.one, vi_set(1), none));
    vi low = vi_if_then_else(vf_lt(f->sign, zero), vi_set(1), none), in = vi_if_then_else(inward, vi_set(1), none);
    return vi_if_then_else(f->of_b, vi_set(1 << 30), none) | (axis + axis + low) << 27 | (j + j + in) << 24;
}

DAFT_INLINE void put(overlap *p, int i, vf u, vf v, vf w, vm there)
{
    vf_store(p->u[i], u);
    vf_store(p->v[i], v);
    vf_store(p->w[i], w);
    p->there[i] = there;
}

/* Cuts the stretch of from + t·along, t from *in to *out, down to what is within ±limit. */
DAFT_INLINE void cut_stretch(vf from, vf along, vf limit, vf *in, vf *out)
{
    vf infinite = vf_set(INFINITY);
    vm flat = vf_le(vf_abs(along), vf_set(DAFT_BOX_FLAT)), inside = vf_le(vf_abs(from), limit);
    vf inverse = vf_set(1) / vf_if_then_else(flat, vf_set(1), along);
    vf low = (-limit - from) * inverse, high = (limit - from) * inverse;
    vf first = vf_if_then_else(flat, vf_if_then_else(inside, -infinite, infinite), vf_min(low, high));
    vf last = vf_if_then_else(flat, vf_if_then_else(inside, infinite, -infinite), vf_max(low, high));
    *in = vf_max(first, *in), *out = vf_min(last, *out);
}

DAFT_INLINE void put_edge(const vf c[3], const vf along[3], const vf limit[2], vm inside, vm next, int i, overlap *p)
{
    vf zero = vf_set(0), one = vf_set(1), in = vf_set(-INFINITY), out = vf_set(INFINITY);
    cut_stretch(c[0], along[0], limit[0], &in, &out);
    cut_stretch(c[1], along[1], limit[1], &in, &out);
    vm crosses = vf_lt(vf_max(in, zero), vf_min(out, one));
    in = vf_min(vf_max(in, zero), one), out = vf_min(vf_max(out, zero), one);
    put(p, DAFT_BOX_ENTER + i, c[0] + in * along[0], c[1] + in * along[1], c[2] + in * along[2],
        vm_and(vm_not(inside), vm_or(next, crosses)));
    put(p, DAFT_BOX_LEAVE + i, c[0] + out * along[0], c[1] + out * along[1], c[2] + out * along[2],
        vm_and(vm_not(next), vm_or(inside, crosses)));
}

/* Corners of the incident face, and its edges where they cross the sides (Liang and Barsky 1984). Whether a corner is
 * inside decides alone whether an edge comes in or goes out: rounding moves points but loses none. */
DAFT_INLINE void put_edges(const outline *o, const vf limit[2], overlap *p)
{
    vf corner[4][3];
    vm inside[4];
    for (int n = 0; n < 3; n++) {
        vf more = o->base[n] + o->a[n], less = o->base[n] - o->a[n];
        corner[0][n] = more + o->b[n], corner[1][n] = less + o->b[n];
        corner[2][n] = less - o->b[n], corner[3][n] = more - o->b[n];
    }
    for (int i = 0; i < 4; i++) {
        inside[i] = vm_and(vf_le(vf_abs(corner[i][0]), limit[0]), vf_le(vf_abs(corner[i][1]), limit[1]));
        put(p, i, corner[i][0], corner[i][1], corner[i][2], inside[i]);
    }
    for (int i = 0; i < 4; i++) {
        const vf *side = i % 2 ? o->b : o->a, sign = vf_set(i < 2 ? -2.0f : 2.0f);
        vf along[3] = {sign * side[0], sign * side[1], sign * side[2]};
        put_edge(corner[i], along, limit, inside[i], inside[(i + 1) % 4], i, p);
    }
}

/* Corners of the reference face under the incident one: by Cramer's rule in base + (x·a + y·b) / det. */
DAFT_INLINE void put_under(const outline *o, const vf limit[2], overlap *p)
{
    vf det = o->a[0] * o->b[1] - o->a[1] * o->b[0], zero = vf_set(0), one = vf_set(1);
    vf most = vf_abs(det) * vf_set(1 + DAFT_BOX_SEAM);
    vf inverse = one / vf_if_then_else(vm_and(vf_le(zero, det), vf_le(det, zero)), one, det);
    for (int i = 0; i < 4; i++) {
        vf u = i == 1 || i == 2 ? -limit[0] : limit[0], v = i < 2 ? limit[1] : -limit[1];
        vf du = u - o->base[0], dv = v - o->base[1];
        vf x = du * o->b[1] - dv * o->b[0], y = o->a[0] * dv - o->a[1] * du;
        vf w = o->base[2] + (x * o->a[2] + y * o->b[2]) * inverse;
        vm under = vm_and(vf_le(vf_abs(x), most), vf_le(vf_abs(y), most));
        put(p, DAFT_BOX_UNDER + i, u, v, w, vm_and(under, vf_lt(zero, most)));
    }
}

/* ---- at most four points ---- */

DAFT_INLINE vi bit(int i) { return vi_set(1 << i); }

typedef struct rim {
    vi first;
    vf u, v;
} rim;

DAFT_INLINE rim rim_point(const overlap *p, vf even)
{
    vf deepest = vf_set(INFINITY), most = vf_set(-INFINITY);
    for (int i = 0; i < DAFT_BOX_FARTHEST; i++)
        deepest = vf_if_then_else(p->there[i], vf_min(vf_load(p->w[i]), deepest), deepest);
    rim out = {bit(0), vf_load(p->u[0]), vf_load(p->v[0])};
    for (int i = 0; i < DAFT_BOX_FARTHEST; i++) {
        vf u = vf_load(p->u[i]), v = vf_load(p->v[i]), along = u + vf_set(DAFT_BOX_SLANT) * v;
        vm deep = vm_and(p->there[i], vf_le(vf_load(p->w[i]), deepest + even));
        vm better = vm_and(deep, vf_lt(most, along));
        most = vf_if_then_else(better, along, most);
        out = (rim){vi_if_then_else(better, bit(i), out.first), vf_if_then_else(better, u, out.u),
                    vf_if_then_else(better, v, out.v)};
    }
    return out;
}

/* At most four, as daft_clip_reduce chooses them. */
DAFT_INLINE vi reduce(const overlap *p, vf even)
{
    rim first = rim_point(p, even), second = first;
    vf zero = vf_set(0), farthest = zero, most = zero, least = zero;
    for (int i = 0; i < DAFT_BOX_FARTHEST; i++) {
        vf u = vf_load(p->u[i]) - first.u, v = vf_load(p->v[i]) - first.v, square = u * u + v * v;
        vm better = vm_and(p->there[i], vf_lt(farthest, square));
        farthest = vf_if_then_else(better, square, farthest);
        second =
            (rim){vi_if_then_else(better, bit(i), second.first), vf_if_then_else(better, vf_load(p->u[i]), second.u),
                  vf_if_then_else(better, vf_load(p->v[i]), second.v)};
    }
    vf along_u = second.u - first.u, along_v = second.v - first.v;
    vi left = vi_set(0), right = vi_set(0);
    for (int i = 0; i < DAFT_BOX_FARTHEST; i++) {
        vf side = along_u * (vf_load(p->v[i]) - first.v) - along_v * (vf_load(p->u[i]) - first.u);
        vm more = vm_and(p->there[i], vf_lt(most, side)), less = vm_and(p->there[i], vf_lt(side, least));
        most = vf_if_then_else(more, side, most), least = vf_if_then_else(less, side, least);
        left = vi_if_then_else(more, bit(i), left), right = vi_if_then_else(less, bit(i), right);
    }
    return first.first | second.first | left | right;
}

/* Bits of the points that stay; none: they are beyond the margin. */
DAFT_INLINE vi keep(const pair *s, overlap *p, vf even)
{
    vi all = vi_set(0), count = vi_set(0), one = vi_set(1), none = vi_set(0);
    for (int i = 0; i < DAFT_BOX_FARTHEST; i++) {
        p->there[i] = vm_and(p->there[i], vf_le(vf_load(p->w[i]), s->margin));
        all |= vi_if_then_else(p->there[i], bit(i), none);
        count += vi_if_then_else(p->there[i], one, none);
    }
    vm many = vi_lt(vi_set(DAFT_MANIFOLD_POINTS), count);
    return vbits_from_mask(many) ? vi_if_then_else(many, reduce(p, even), all) : all;
}

/* Gives the corner's number. */
DAFT_INLINE vi put_farthest(const reference *f, overlap *p)
{
    vf x[3] = {f->centre[0], f->centre[1], f->centre[2]};
    vi corner = vi_set(0);
    for (int j = 0; j < 3; j++) {
        vm low = vf_lt(vf_set(0), f->sign * f->m[0][j]);
        vf out = vf_if_then_else(low, -f->other[j], f->other[j]);
        for (int k = 0; k < 3; k++) x[k] = x[k] + out * f->m[k][j];
        corner |= vi_if_then_else(low, bit(j), vi_set(0));
    }
    vf_store(p->u[DAFT_BOX_FARTHEST], x[1]);
    vf_store(p->v[DAFT_BOX_FARTHEST], x[2]);
    vf_store(p->w[DAFT_BOX_FARTHEST], f->sign * x[0] - f->half[0]);
    return corner;
}

/* ---- manifolds ---- */

typedef struct manifold {
    vi count;
    vf normal[3], point[DAFT_MANIFOLD_POINTS][3], separation[DAFT_MANIFOLD_POINTS];
    vi id[DAFT_MANIFOLD_POINTS];
} manifold;

/* From the reference to a's frame. */
DAFT_INLINE void out_of(const pair *s, const reference *f, const vf x[3], vf out[3])
{
    vf y[3];
    turn_back(f->axis, x, y);
    for (int i = 0; i < 3; i++) {
        vf from_b = (s->p[i] + s->shift[i]) + dot3(s->r[i][0], y[0], s->r[i][1], y[1], s->r[i][2], y[2]);
        out[i] = vf_if_then_else(f->of_b, from_b, y[i] + s->shift[i]);
    }
}

/* The number of a bit, up to 23: the exponent of it as a float. */
DAFT_INLINE vi number_of(vi one_bit) { return ((vi)vf_convert_to(one_bit) >> 23) - vi_set(127); }

DAFT_INLINE void put_points(const pair *s, const reference *f, const overlap *p, vi kept, vi features, vi corner,
                            manifold *out)
{
    out->count = vi_set(0);
    for (int k = 0; k < DAFT_MANIFOLD_POINTS; k++) {
        vi low = kept & -kept, none = vi_set(0);
        vm there = vi_lt(none, low);
        vi i = vi_if_then_else(there, number_of(low), none), from = i * vi_set(DAFT_VL) + vi_iota();
        vf w = vf_gather_index(p->w[0], from);
        vf x[3] = {f->sign * (f->half[0] + vf_set(0.5f) * w), vf_gather_index(p->u[0], from),
                   vf_gather_index(p->v[0], from)};
        out_of(s, f, x, out->point[k]);
        out->separation[k] = w;
        out->id[k] = features | i | vi_if_then_else(vi_eq(i, vi_set(DAFT_BOX_FARTHEST)), corner, none);
        out->count += vi_if_then_else(there, vi_set(1), none);
        kept ^= low;
    }
}

DAFT_INLINE void face_contact(const pair *s, const choice *c, manifold *out)
{
    reference f;
    outline o;
    overlap p;
    vf zero = vf_set(0);
    set_reference(s, c, &f);
    vi features = set_outline(&f, c->number, &o);
    const vf limit[2] = {f.half[1] * vf_set(1 + DAFT_BOX_OVERHANG), f.half[2] * vf_set(1 + DAFT_BOX_OVERHANG)};
    put_edges(&o, limit, &p);
    put_under(&o, limit, &p);
    vi kept = keep(s, &p, vf_set(DAFT_BOX_EVEN) * f.half[1]), corner = put_farthest(&f, &p);
    vm deep = vm_and(vi_eq(kept, vi_set(0)), vf_le(c->separation, zero));
    kept = vi_if_then_else(deep, bit(DAFT_BOX_FARTHEST), kept);
    put_points(s, &f, &p, kept, features, corner, out);
    vf along[3] = {vf_if_then_else(f.of_b, -f.sign, f.sign), zero, zero}, axis[3];
    turn_back(f.axis, along, axis);
    for (int i = 0; i < 3; i++) {
        vf of_b = vf_if_then_else(f.axis.two, s->r[i][2], vf_if_then_else(f.axis.one, s->r[i][1], s->r[i][0]));
        out->normal[i] = vf_if_then_else(f.of_b, along[0] * of_b, axis[i]);
    }
}

/* ---- two edges ---- */

DAFT_INLINE vf clamp_to(vf x, vf limit)
{
    return vf_if_then_else(vf_lt(limit, x), limit, vf_if_then_else(vf_lt(x, -limit), -limit, x));
}
DAFT_INLINE vf dot_of(const vf a[3], const vf b[3]) { return dot3(a[0], b[0], a[1], b[1], a[2], b[2]); }
DAFT_INLINE vf pick(turn t, const vf x[3]) { return vf_if_then_else(t.two, x[2], vf_if_then_else(t.one, x[1], x[0])); }

typedef struct edge_pair {
    turn i, j;
    vf along_a[3], along_b[3], n[3], from[3], to[3];
    vi corners;
} edge_pair;

DAFT_INLINE void set_edge_normal(const pair *s, edge_pair *e)
{
    const vf *a = e->along_a, *b = e->along_b;
    vf n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    vf length = vf_sqrt(dot_of(n, n)), zero = vf_set(0);
    vm some = vf_lt(zero, length);
    vf scale = vf_if_then_else(some, vf_set(1) / vf_if_then_else(some, length, vf_set(1)), vf_set(1));
    for (int k = 0; k < 3; k++) n[k] = n[k] * scale;
    vm back = vf_lt(dot_of(n, s->p), zero);
    for (int k = 0; k < 3; k++) e->n[k] = vf_if_then_else(back, -n[k], n[k]);
}

DAFT_INLINE vm is_axis(turn t, int k) { return k == 2 ? t.two : k == 1 ? t.one : vm_not(vm_or(t.one, t.two)); }

/* Middles of the two edges. */
DAFT_INLINE void set_edge_places(const pair *s, edge_pair *e)
{
    vf zero = vf_set(0);
    vi none = vi_set(0);
    e->corners = none;
    for (int k = 0; k < 3; k++) e->to[k] = s->p[k];
    for (int k = 0; k < 3; k++) {
        vm mine = is_axis(e->i, k), theirs = is_axis(e->j, k), low = vf_lt(e->n[k], zero);
        e->from[k] = vf_if_then_else(mine, zero, vf_if_then_else(low, -s->ha[k], s->ha[k]));
        e->corners |= vi_if_then_else(vm_and(low, vm_not(mine)), bit(3 + k), none);
        const vf axis[3] = {s->r[0][k], s->r[1][k], s->r[2][k]};
        low = vf_lt(zero, dot_of(axis, e->n));
        vf out = vf_if_then_else(low, -s->hb[k], s->hb[k]);
        for (int x = 0; x < 3; x++) e->to[x] = vf_if_then_else(theirs, e->to[x], e->to[x] + axis[x] * out);
        e->corners |= vi_if_then_else(vm_and(low, vm_not(theirs)), bit(k), none);
    }
}

DAFT_INLINE void edge_contact(const pair *s, const choice *c, vm here, manifold *out)
{
    vi three = vi_set(3), none = vi_set(0), second = vi_if_then_else(vi_lt(vi_set(2), c->number), vi_set(1), none);
    vi i = second + vi_if_then_else(vi_lt(vi_set(5), c->number), vi_set(1), none), j = c->number - i * three;
    edge_pair e = {.i = turn_to(i), .j = turn_to(j)};
    vf one = vf_set(1), zero = vf_set(0), half = vf_set(0.5f), w[3];
    for (int k = 0; k < 3; k++) {
        e.along_a[k] = vf_if_then_else(is_axis(e.i, k), one, zero);
        e.along_b[k] = pick(e.j, s->r[k]);
    }
    set_edge_normal(s, &e);
    set_edge_places(s, &e);
    for (int k = 0; k < 3; k++) w[k] = e.to[k] - e.from[k];
    vf d = dot_of(e.along_a, e.along_b), wa = dot_of(w, e.along_a), wb = dot_of(w, e.along_b);
    vf t = clamp_to((wa * d - wb) / (one - d * d), pick(e.j, s->hb)), u = clamp_to(wa + t * d, pick(e.i, s->ha));
    for (int k = 0; k < 3; k++) {
        vf on_a = e.from[k] + e.along_a[k] * u, on_b = e.to[k] + e.along_b[k] * t;
        out->normal[k] = vf_if_then_else(here, e.n[k], out->normal[k]);
        out->point[0][k] = vf_if_then_else(here, (on_a + on_b) * half + s->shift[k], out->point[0][k]);
    }
    vi id = vi_set((int32_t)(3u << 30)) | i << 8 | j << 6 | e.corners;
    out->separation[0] = vf_if_then_else(here, c->separation, out->separation[0]);
    out->id[0] = vi_if_then_else(here, id, out->id[0]);
    out->count = vi_if_then_else(here, vi_set(1), out->count);
}

/* ---- to the world ---- */

/* As a vector in world axes, through double. */
DAFT_INLINE void to_world(const daft_box_batch *batch, int lane, vf v[3])
{
    vd out[2][3];
    for (int half = 0; half < 2; half++) {
        vd x[3] = {vd_promote_half(v[0], half), vd_promote_half(v[1], half), vd_promote_half(v[2], half)}, m[9];
        for (int i = 0; i < 9; i++) m[i] = vd_load(batch->a[3 + i] + lane + half * (DAFT_VL / 2));
        for (int k = 0; k < 3; k++) out[half][k] = (m[3 * k] * x[0] + m[3 * k + 1] * x[1]) + m[3 * k + 2] * x[2];
    }
    for (int k = 0; k < 3; k++) v[k] = vf_demote2(out[0][k], out[1][k]);
}

DAFT_INLINE void store_manifold(daft_box_batch *batch, int lane, manifold *m, int points)
{
    to_world(batch, lane, m->normal);
    vf length = vf_sqrt(dot_of(m->normal, m->normal)), one = vf_set(1);
    vm some = vf_lt(vf_set(0), length);
    vf scale = one / vf_if_then_else(some, length, one);
    daft_found_lanes *f = &batch->found;
    for (int k = 0; k < 3; k++) vf_store(f->normal[k] + lane, m->normal[k] * scale);
    for (int i = 0; i < points; i++) {
        to_world(batch, lane, m->point[i]);
        for (int k = 0; k < 3; k++) vf_store(f->point[i][k] + lane, m->point[i][k]);
        vf_store(f->separation[i] + lane, m->separation[i]);
        vi_store(f->id[i] + lane, m->id[i]);
    }
}

static void collide_lanes(daft_box_batch *batch, int lane, vbits used)
{
    pair s;
    manifold m;
    load_pair(batch, lane, &s);
    choice c = find_axis(&s, vi_load(batch->kind + lane));
    vi_store(batch->kind + lane, c.kind);
    vi_store(batch->found.count + lane, vi_set(0));
    vbits meet = vbits_from_mask(c.meet) & used;
    vm crossed = vi_eq(c.kind, vi_set(DAFT_AXIS_EDGES));
    if (!meet) return;
    bool some_faces = meet & ~vbits_from_mask(crossed), some_edges = meet & vbits_from_mask(crossed);
    if (some_faces)
        face_contact(&s, &c, &m);
    else
        memset(&m, 0, sizeof m);
    if (some_edges) edge_contact(&s, &c, crossed, &m);
    vi_store(batch->found.count + lane, vi_if_then_else(c.meet, m.count, vi_set(0)));
    store_manifold(batch, lane, &m, some_faces ? DAFT_MANIFOLD_POINTS : 1);
}

static void collide(daft_box_batch *batch, int count)
{
    for (int lane = 0; lane < count; lane += DAFT_VL) collide_lanes(batch, lane, vbits_first_n(count - lane));
}

const daft_box_kernels DAFT_KERNEL(daft_box) = {collide};
