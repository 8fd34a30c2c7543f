/* Spheres and capsules: against each other and against boxes, by the closest points of their cores. What they share
 * with other convex pairs, and boxes whose inside a core reaches, are left to manifold_poly.c, which gives points the
 * same numbers. */
#include "sim/collide/manifold_round.h"

/* A core: centre, and half of the segment, 0 for spheres; a's frame. */
typedef struct core {
    daft_vec3 centre, half;
    float radius;
} core;

static core core_of(const daft_sim_shape *s)
{
    float half = s->type == DAFT_GEOMETRY_CAPSULE ? s->half_height : 0;
    return (core){daft_v3(0, 0, 0), daft_v3(0, half, 0), s->radius};
}
/* Of b, near to a in double. */
static core posed_core(const daft_sim_shape *s, const daft_relpose *pose)
{
    float half = s->type == DAFT_GEOMETRY_CAPSULE ? s->half_height : 0;
    daft_vec3 axis = daft_v3(pose->r[1], pose->r[4], pose->r[7]);
    return (core){daft_to_float(pose->p), daft_scale(axis, half), s->radius};
}
/* t: -1 to 1. */
static daft_vec3 on_core(const core *c, float t) { return daft_add(c->centre, daft_scale(c->half, t)); }
static bool is_long(const core *c) { return !(c->half.x == 0 && c->half.y == 0 && c->half.z == 0); }

/* ---- against each other ---- */

static daft_vec3 across(daft_vec3 d)
{
    daft_vec3 axis = fabsf(d.x) <= fabsf(d.y) && fabsf(d.x) <= fabsf(d.z) ? daft_v3(1, 0, 0)
                     : fabsf(d.y) <= fabsf(d.z)                           ? daft_v3(0, 1, 0)
                                                                          : daft_v3(0, 0, 1);
    return daft_normalize(daft_cross(d, axis));
}

static daft_manifold_point round_point(const core *a, const core *b, daft_vec3 on_a, daft_vec3 on_b, daft_vec3 n,
                                       uint32_t id)
{
    float apart = daft_dot(n, daft_sub(on_b, on_a));
    daft_vec3 p = daft_add(on_a, daft_scale(n, a->radius)), q = daft_sub(on_b, daft_scale(n, b->radius));
    return (daft_manifold_point){daft_scale(daft_add(p, q), 0.5f), apart - (a->radius + b->radius), id};
}

/* Where two capsules lie side by side: both ends of the stretch they share. */
static uint32_t side_by_side(const core *a, const core *b, daft_vec3 n, float margin, daft_manifold *out)
{
    float square = daft_dot(a->half, a->half), along = daft_dot(a->half, b->half);
    daft_vec3 turn = daft_cross(a->half, b->half);
    if (daft_dot(turn, turn) > DAFT_ROUND_PARALLEL * DAFT_ROUND_PARALLEL * square * daft_dot(b->half, b->half))
        return 0;
    float middle = daft_dot(daft_sub(b->centre, a->centre), a->half) / square, slope = along / square;
    float low = fmaxf(-1, middle - fabsf(slope)), high = fminf(1, middle + fabsf(slope));
    if (!(high - low > DAFT_ROUND_SHARED * fminf(1, fabsf(slope)))) return 0;
    for (uint32_t i = 0; i < 2; i++) {
        float t = i ? high : low;
        daft_manifold_point p = round_point(a, b, on_core(a, t), on_core(b, (t - middle) / slope), n, i);
        if (p.separation <= margin) out->points[out->count++] = p;
    }
    return out->count > 0;
}

/* One through the other: out sideways, for spheres upwards. */
static daft_vec3 direction_out(const core *a, const core *b)
{
    daft_vec3 c = daft_cross(a->half, b->half);
    if (daft_dot(c, c) > 1e-6f * daft_dot(a->half, a->half) * daft_dot(b->half, b->half)) return daft_normalize(c);
    return is_long(a) ? across(a->half) : is_long(b) ? across(b->half) : daft_v3(0, -1, 0);
}

uint32_t daft_collide_rounds(const daft_sim_shape *shape_a, const daft_sim_shape *shape_b, const daft_relpose *pose,
                             float margin, daft_manifold *out, daft_pair_cache *cache)
{
    core a = core_of(shape_a), b = posed_core(shape_b, pose);
    float s, t;
    daft_segments_closest(on_core(&a, -1), on_core(&a, 1), on_core(&b, -1), on_core(&b, 1), &s, &t);
    daft_vec3 on_a = on_core(&a, 2 * s - 1), on_b = on_core(&b, 2 * t - 1), gap = daft_sub(on_b, on_a);
    float distance = daft_length(gap), rounding = a.radius + b.radius;
    if (cache) *cache = (daft_pair_cache){.clearance = fmaxf(distance - rounding, 0)};
    if (distance - rounding > margin) return 0;
    daft_vec3 n = distance > 1e-6f * rounding ? daft_scale(gap, 1 / distance) : direction_out(&a, &b);
    out->normal = n;
    out->count = 0;
    out->feature_a = out->feature_b = DAFT_FEATURE_VERTEX;
    out->face_b = daft_neg(n);
    if (is_long(&a) && is_long(&b) && side_by_side(&a, &b, n, margin, out)) return 1;
    out->count = 1;
    out->points[0] = round_point(&a, &b, on_a, on_b, n, 2);
    return 1;
}

/* ---- against boxes ---- */

/* A core along each axis of a box: how far its centre is beyond the high and the low face, in float where they are
 * near; and its half segment. */
typedef struct beside {
    float high[3], low[3], d[3];
} beside;

static beside beside_box(const daft_sim_shape *round, const daft_sim_shape *box, const daft_relpose *pose,
                         bool box_first)
{
    const double *centre = box_first ? &pose->p.x : &pose->q.x;
    const float h[3] = {box->half.x, box->half.y, box->half.z}, *r = pose->r;
    float half = round->type == DAFT_GEOMETRY_CAPSULE ? round->half_height : 0;
    beside out;
    for (int k = 0; k < 3; k++) {
        out.high[k] = (float)(centre[k] - (double)h[k]);
        out.low[k] = (float)(-centre[k] - (double)h[k]);
        out.d[k] = half * (box_first ? r[3 * k + 1] : r[3 + k]); /* the core's axis in the box */
    }
    return out;
}

/* From the box to the core's point at t, along one axis. */
static float gap_along(const beside *s, int k, float t)
{
    float high = s->high[k] + t * s->d[k], low = s->low[k] - t * s->d[k];
    return high > 0 ? high : low > 0 ? -low : 0;
}
/* Half the slope of the squared distance there: it rises with t, in straight pieces. */
static float slope_at(const beside *s, float t)
{
    return s->d[0] * gap_along(s, 0, t) + s->d[1] * gap_along(s, 1, t) + s->d[2] * gap_along(s, 2, t);
}

/* Where on the core, -1 to 1, it is closest to the box: the slope's zero, between the places where it bends. */
static float closest_to_box(const beside *s)
{
    float a = -1, b = 1, slope_a = slope_at(s, a), slope_b;
    if (slope_a >= 0) return a;
    slope_b = slope_at(s, b);
    if (slope_b <= 0) return b;
    for (int i = 0; i < 6; i++) {
        int k = i / 2;
        if (s->d[k] == 0) continue;
        float t = i & 1 ? s->low[k] / s->d[k] : -s->high[k] / s->d[k];
        if (!(t > a && t < b)) continue;
        float slope = slope_at(s, t);
        if (slope < 0)
            a = t, slope_a = slope;
        else
            b = t, slope_b = slope;
    }
    return a - slope_a * (b - a) / (slope_b - slope_a);
}

/* No less than this far apart: their extents along the axes. */
static float extents_apart(const beside *s)
{
    float square = 0;
    for (int k = 0; k < 3; k++) {
        float reach = fabsf(s->d[k]), apart = fmaxf(fmaxf(s->high[k], s->low[k]) - reach, 0);
        square += apart * apart;
    }
    return sqrtf(square);
}

/* A vector in the box's axes, in a's frame. */
static daft_vec3 from_box(const daft_relpose *pose, bool box_first, const float v[3])
{
    if (box_first) return daft_v3(v[0], v[1], v[2]);
    const float *r = pose->r;
    return daft_v3((r[0] * v[0] + r[1] * v[1]) + r[2] * v[2], (r[3] * v[0] + r[4] * v[1]) + r[5] * v[2],
                   (r[6] * v[0] + r[7] * v[1]) + r[8] * v[2]);
}

typedef struct meeting {
    beside s;
    core c;
    float gap[3]; /* from the box to the core's closest point, in the box's axes */
    float distance, t;
    int outside, axis; /* how many axes the closest point is beyond; the one it is farthest beyond */
    bool box_first;
    daft_vec3 face; /* the outward normal of the box's face along that axis; a's frame */
} meeting;

/* The stretch of the core that is over the face along the meeting's axis. False: none is. */
static bool stretch_over(const meeting *m, float *from, float *to)
{
    const beside *s = &m->s;
    float over = DAFT_ROUND_OVERHANG * m->c.radius;
    *from = is_long(&m->c) ? -1 : 0, *to = is_long(&m->c) ? 1 : 0;
    for (int k = 0; k < 3; k++) {
        if (k == m->axis) continue;
        float high = over - s->high[k], low = s->low[k] - over;
        if (s->d[k] == 0) {
            if (high < 0 || low > 0) *to = -INFINITY;
            continue;
        }
        float a = high / s->d[k], b = low / s->d[k];
        *from = fmaxf(fminf(a, b), *from), *to = fminf(fmaxf(a, b), *to);
    }
    return *from <= *to;
}

/* Over one face: both ends of the stretch that is. */
static void over_face(const meeting *m, float from, float to, float margin, daft_manifold *out)
{
    const beside *s = &m->s;
    int ends = is_long(&m->c) ? 2 : 1, k = m->axis;
    out->count = 0;
    for (int i = 0; i < ends; i++) {
        float t = i ? to : from, high = m->gap[k] > 0 ? s->high[k] + t * s->d[k] : s->low[k] - t * s->d[k];
        if (high - m->c.radius > margin) continue;
        daft_vec3 at = daft_sub(on_core(&m->c, t), daft_scale(m->face, 0.5f * (high + m->c.radius)));
        uint32_t id = (uint32_t)i | (m->box_first ? 0 : 1u << 30);
        out->points[out->count++] = (daft_manifold_point){at, high - m->c.radius, id};
    }
    daft_feature_kind kind = out->count == 1 ? DAFT_FEATURE_VERTEX : DAFT_FEATURE_EDGE;
    out->feature_a = m->box_first ? DAFT_FEATURE_FACE : kind;
    out->feature_b = m->box_first ? kind : DAFT_FEATURE_FACE;
    out->normal = m->box_first ? m->face : daft_neg(m->face);
    out->face_b = daft_neg(out->normal);
}

/* Beside an edge or a corner. */
static void beside_edge(const meeting *m, const daft_relpose *pose, daft_manifold *out)
{
    const float scale = 1 / m->distance, unit[3] = {m->gap[0] * scale, m->gap[1] * scale, m->gap[2] * scale};
    daft_vec3 away = from_box(pose, m->box_first, unit);
    bool inside = m->t > -1 && m->t < 1 && is_long(&m->c);
    daft_feature_kind mine = inside ? DAFT_FEATURE_EDGE : DAFT_FEATURE_VERTEX;
    daft_feature_kind theirs = m->outside == 3 ? DAFT_FEATURE_VERTEX : DAFT_FEATURE_EDGE;
    out->count = 1;
    out->points[0] =
        (daft_manifold_point){daft_sub(on_core(&m->c, m->t), daft_scale(away, 0.5f * (m->distance + m->c.radius))),
                              m->distance - m->c.radius, 5u << 28 | (uint32_t)inside};
    out->feature_a = m->box_first ? theirs : mine;
    out->feature_b = m->box_first ? mine : theirs;
    out->normal = m->box_first ? away : daft_neg(away);
    out->face_b = m->box_first ? daft_neg(away) : m->face;
}

static void set_gap(meeting *m, const daft_relpose *pose)
{
    float square = 0, unit[3] = {0, 0, 0};
    m->outside = m->axis = 0;
    for (int k = 0; k < 3; k++) {
        m->gap[k] = gap_along(&m->s, k, m->t);
        square += m->gap[k] * m->gap[k];
        m->outside += m->gap[k] != 0;
        if (fabsf(m->gap[k]) > fabsf(m->gap[m->axis])) m->axis = k;
    }
    m->distance = sqrtf(square);
    unit[m->axis] = m->gap[m->axis] < 0 ? -1.0f : 1.0f;
    m->face = from_box(pose, m->box_first, unit);
}

bool daft_collide_round_box(const daft_sim_shape *round, const daft_sim_shape *box, const daft_relpose *pose,
                            bool box_first, float margin, daft_manifold *out, daft_pair_cache *cache, uint32_t *count)
{
    meeting m = {.s = beside_box(round, box, pose, box_first), .box_first = box_first};
    float radius = round->radius, apart = extents_apart(&m.s);
    *count = 0;
    if (apart - radius > margin) {
        if (cache) *cache = (daft_pair_cache){.clearance = apart - radius};
        return true;
    }
    m.c = box_first ? posed_core(round, pose) : core_of(round);
    m.t = closest_to_box(&m.s);
    set_gap(&m, pose);
    /* Nearer than this rounding blurs the direction. */
    if (!(m.distance > DAFT_ROUND_NEAR * radius + 1e-6f * daft_length(box->half))) return false;
    if (m.distance - radius <= margin) {
        float from, to;
        bool nearly = m.outside == 1 || fabsf(m.gap[m.axis]) > DAFT_ROUND_ALONG_FACE * m.distance;
        if (nearly && stretch_over(&m, &from, &to))
            over_face(&m, from, to, margin, out);
        else
            beside_edge(&m, pose, out);
        *count = out->count > 0;
    }
    if (cache) *cache = (daft_pair_cache){.clearance = fmaxf(m.distance - radius, 0)};
    return true;
}
