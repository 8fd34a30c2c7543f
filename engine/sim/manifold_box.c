/* Box against box: the fifteen axes of two boxes (Gottschalk, Lin and Manocha, "OBBTree", 1996) four lanes at a time,
 * then clipping of one face by a rectangle, or one point where two edges cross.
 *
 * A box much larger than the other is cut down to what is near the other before anything else, in double: what was 500
 * m of lever times a rounding error is gone, and every float below is of the size of the smaller box. */
#include "math/simd.h"
#include "sim/manifold_parts.h"

/* A box over this many times as large as the other is cut down, to this many times. */
#define LARGE 4.0f
/* Axes within this share of the smaller box's size count as equally good: the first kind, or the cached one, wins. */
#define EVEN 1e-3f
/* The reference face reaches this share of its width farther when it clips: of boxes of one size that stand on each
 * other the corners are points, whatever the last bits say. */
#define OVERHANG 1e-3f
/* Edges whose angle's square sine is less are parallel: a face has their axis. */
#define PARALLEL 1e-5f

typedef struct pair {
    float ha[3], hb[3]; /* half edges, cut down */
    float r[3][3];      /* b's axes are the columns, in a */
    float p[3], q[3];   /* b's centre in a; a's centre in b */
    float shift[3];     /* of a's centre, by cutting down */
    float margin;
    bool large_a, large_b;
} pair;

typedef struct best_axis {
    float separation;
    int number;
} best_axis;

static float largest(const float h[3])
{
    float m = h[0] > h[1] ? h[0] : h[1];
    return h[2] > m ? h[2] : m;
}

/* Cuts box h, seen from whose centre the other's is at c, down to what is within reach of c. Moves the centre by
 * *shift. */
static void cut_down(float h[3], double c[3], double reach, double shift[3])
{
    for (int k = 0; k < 3; k++) {
        double low = fmax(-(double)h[k], c[k] - reach), high = fmin((double)h[k], c[k] + reach);
        h[k] = (float)((high - low) / 2);
        shift[k] = (high + low) / 2;
        c[k] -= shift[k];
    }
}

static double length_of(const float h[3])
{
    return sqrt((double)h[0] * (double)h[0] + (double)h[1] * (double)h[1] + (double)h[2] * (double)h[2]);
}

/* How far a face is clear of the other's ball, at most. */
static double clearance(const double p[3], const float h[3], double ball)
{
    double most = -INFINITY;
    for (int k = 0; k < 3; k++) {
        double gap = fabs(p[k]) - (double)h[k];
        most = gap > most ? gap : most;
    }
    return most - ball;
}

/* Farther than `depth` from all faces: rounding does not matter there, which way is out does. */
static bool deep(const double p[3], const float h[3], double depth)
{
    for (int k = 0; k < 3; k++)
        if (fabs(p[k]) > (double)h[k] - depth) return false;
    return true;
}

/* False where balls and faces are clear of each other by more than the margin: by *gap. */
static bool pair_set(pair *s, daft_vec3 half_a, daft_vec3 half_b, const daft_relpose *pose, float margin, double *gap)
{
    *s = (pair){.ha = {half_a.x, half_a.y, half_a.z}, .hb = {half_b.x, half_b.y, half_b.z}, .margin = margin};
    double p[3] = {pose->p.x, pose->p.y, pose->p.z}, q[3] = {pose->q.x, pose->q.y, pose->q.z};
    memcpy(s->r, pose->r, sizeof s->r);
    double ball_a = length_of(s->ha), ball_b = length_of(s->hb), shift[3] = {0, 0, 0}, unused[3];
    double gap_b = clearance(q, s->hb, ball_a), gap_a = clearance(p, s->ha, ball_b);
    *gap = gap_a > gap_b ? gap_a : gap_b;
    if (*gap > (double)margin) return false;
    float la = largest(s->ha), lb = largest(s->hb);
    s->large_b = lb > LARGE * la && !deep(q, s->hb, 2 * ball_a);
    s->large_a = la > LARGE * lb && !deep(p, s->ha, 2 * ball_b);
    if (s->large_b) {
        cut_down(s->hb, q, (double)LARGE * ball_a + (double)margin, unused);
        for (int k = 0; k < 3; k++)
            p[k] = -((double)s->r[k][0] * q[0] + (double)s->r[k][1] * q[1] + (double)s->r[k][2] * q[2]);
    } else if (s->large_a) {
        cut_down(s->ha, p, (double)LARGE * ball_b + (double)margin, shift);
        for (int k = 0; k < 3; k++)
            q[k] = -((double)s->r[0][k] * p[0] + (double)s->r[1][k] * p[1] + (double)s->r[2][k] * p[2]);
    }
    for (int k = 0; k < 3; k++) s->p[k] = (float)p[k], s->q[k] = (float)q[k], s->shift[k] = (float)shift[k];
    return true;
}

/* ---- the axes ---- */

typedef struct axes {
    v4 row[3], abs_row[3], abs_column[3];
} axes;

static v4 three(const float v[3])
{
    return (v4){v[0], v[1], v[2], 0};
}

static void axes_set(const pair *s, axes *x)
{
    for (int i = 0; i < 3; i++) {
        x->row[i] = three(s->r[i]);
        x->abs_row[i] = v4_abs(x->row[i]);
        x->abs_column[i] = v4_abs((v4){s->r[0][i], s->r[1][i], s->r[2][i], 0});
    }
}

/* The best of the first three lanes; the lowest of equal ones. */
static best_axis best_of(v4 separation)
{
    best_axis best = {separation[0], 0};
    if (separation[1] > best.separation) best = (best_axis){separation[1], 1};
    if (separation[2] > best.separation) best = (best_axis){separation[2], 2};
    return best;
}

static best_axis faces(const float centre[3], const float mine[3], const float theirs[3], const v4 spread[3])
{
    v4 reach = (spread[0] * v4_set(theirs[0]) + spread[1] * v4_set(theirs[1])) + spread[2] * v4_set(theirs[2]);
    return best_of((v4_abs(three(centre)) - three(mine)) - reach);
}

/* Edge i of a with the three of b. Parallel ones are far inside. */
static v4 edges(const pair *s, const axes *x, int i)
{
    int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    v4 r = x->row[i], m = x->abs_row[i], one = v4_set(1);
    v4 h1 = {s->hb[1], s->hb[2], s->hb[0], 0}, h2 = {s->hb[2], s->hb[0], s->hb[1], 0};
    v4 m1 = {m[1], m[2], m[0], 0}, m2 = {m[2], m[0], m[1], 0};
    v4 distance = v4_abs(v4_set(s->p[i2]) * x->row[i1] - v4_set(s->p[i1]) * x->row[i2]);
    v4 reach_a = v4_set(s->ha[i1]) * x->abs_row[i2] + v4_set(s->ha[i2]) * x->abs_row[i1];
    v4 square = one - r * r, reach_b = h1 * m2 + h2 * m1;
    v4i crossing = square > v4_set(PARALLEL);
    v4 length = v4_sqrt(v4_select(crossing, square, one));
    return v4_select(crossing, ((distance - reach_a) - reach_b) / length, v4_set(-INFINITY));
}

/* ---- a face ---- */

/* One box's face, and the other box as seen from the first. */
typedef struct reference {
    const float *half;  /* of the box whose face it is */
    const float *other; /* half edges of the other */
    float centre[3];    /* of the other */
    float m[3][3];      /* the other's axes are the columns */
    int axis;
    float sign;
} reference;

/* Which of the other's faces looks at the reference most; sets its four corners. */
static int incident(const reference *f, float *facing, daft_clip_point corners[4])
{
    const float *row = f->m[f->axis];
    int j = fabsf(row[1]) > fabsf(row[0]) ? 1 : 0;
    if (fabsf(row[2]) > fabsf(row[j])) j = 2;
    int j1 = (j + 1) % 3, j2 = (j + 2) % 3, k1 = (f->axis + 1) % 3, k2 = (f->axis + 2) % 3;
    *facing = f->sign * row[j] > 0 ? -1.0f : 1.0f;
    static const float around[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    float out = *facing * f->other[j];
    for (uint32_t i = 0; i < 4; i++) {
        float s1 = around[i][0] * f->other[j1], s2 = around[i][1] * f->other[j2], x[3];
        for (int k = 0; k < 3; k++) x[k] = ((f->centre[k] + out * f->m[k][j]) + s1 * f->m[k][j1]) + s2 * f->m[k][j2];
        corners[i] = (daft_clip_point){x[k1], x[k2], f->sign * x[f->axis] - f->half[f->axis], i};
    }
    return j;
}

/* Clips by the four sides, only those that any corner is beyond. Gives where the points are. */
static daft_clip_point *clip_sides(const reference *f, daft_clip_point *from, daft_clip_point *to, uint32_t *count)
{
    float u = f->half[(f->axis + 1) % 3] * (1 + OVERHANG), v = f->half[(f->axis + 2) % 3] * (1 + OVERHANG);
    const float limit[4] = {u, v, u, v};
    static const float sign[4] = {1, 1, -1, -1};
    for (uint32_t side = 0; side < 4; side++) {
        bool along_u = side % 2 == 0, beyond = false;
        for (uint32_t i = 0; i < *count; i++) beyond |= sign[side] * (along_u ? from[i].u : from[i].v) > limit[side];
        if (!beyond) continue;
        *count = daft_clip(from, *count, along_u ? sign[side] : 0, along_u ? 0 : sign[side], limit[side], side, to);
        daft_clip_point *swapped = from;
        from = to, to = swapped;
    }
    return from;
}

/* From the reference's axes to a's frame. */
static daft_vec3 out_of(const pair *s, bool of_b, const float x[3])
{
    if (!of_b) return daft_v3(x[0] + s->shift[0], x[1] + s->shift[1], x[2] + s->shift[2]);
    float y[3];
    for (int i = 0; i < 3; i++)
        y[i] = (s->p[i] + s->shift[i]) + ((s->r[i][0] * x[0] + s->r[i][1] * x[1]) + s->r[i][2] * x[2]);
    return daft_v3(y[0], y[1], y[2]);
}

static daft_vec3 column(const pair *s, int j, float sign)
{
    return daft_v3(sign * s->r[0][j], sign * s->r[1][j], sign * s->r[2][j]);
}

static daft_vec3 unit_axis(int k, float sign)
{
    return daft_v3(k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0);
}

static daft_clip_point farthest_in(const reference *f)
{
    float x[3] = {f->centre[0], f->centre[1], f->centre[2]};
    uint32_t corner = 0;
    for (int j = 0; j < 3; j++) {
        bool low = f->sign * f->m[f->axis][j] > 0;
        for (int k = 0; k < 3; k++) x[k] += (low ? -f->other[j] : f->other[j]) * f->m[k][j];
        corner |= (uint32_t)low << j;
    }
    return (daft_clip_point){x[(f->axis + 1) % 3], x[(f->axis + 2) % 3], f->sign * x[f->axis] - f->half[f->axis],
                             8 | corner};
}

static void reference_set(const pair *s, bool of_b, int axis, reference *f)
{
    const float *centre = of_b ? s->q : s->p;
    *f = (reference){.half = of_b ? s->hb : s->ha, .other = of_b ? s->ha : s->hb, .axis = axis};
    for (int i = 0; i < 3; i++) {
        f->centre[i] = centre[i];
        for (int j = 0; j < 3; j++) f->m[i][j] = of_b ? s->r[j][i] : s->r[i][j];
    }
    f->sign = centre[axis] < 0 ? -1.0f : 1.0f;
}

static uint32_t face_contact(const pair *s, bool of_b, int axis, float separation, daft_manifold *out)
{
    daft_clip_point buffers[2][12], *points;
    reference f;
    float facing;
    uint32_t count = 4, kept = 0;
    reference_set(s, of_b, axis, &f);
    int j = incident(&f, &facing, buffers[0]), k1 = (axis + 1) % 3, k2 = (axis + 2) % 3;
    points = clip_sides(&f, buffers[0], buffers[1], &count);
    for (uint32_t i = 0; i < count; i++)
        if (points[i].w <= s->margin) points[kept++] = points[i];
    if (kept == 0) {
        if (separation > 0) return 0;
        kept = 1; /* deep in each other, the faces may miss each other: the corner that is farthest in */
        points[0] = farthest_in(&f);
    }
    kept = daft_clip_reduce(points, kept, EVEN * f.half[k1]);
    uint32_t features = (of_b ? 1u << 30 : 0) | (uint32_t)((axis << 1) + (f.sign < 0)) << 27 |
                        (uint32_t)((j << 1) + (facing < 0)) << 24;
    out->count = kept;
    for (uint32_t i = 0; i < kept; i++) {
        float x[3];
        x[k1] = points[i].u, x[k2] = points[i].v;
        x[axis] = f.sign * (f.half[axis] + 0.5f * points[i].w);
        uint32_t id = points[i].id; /* two bits for the corner or side before, two for the side */
        uint32_t small = id & 0x80000000u ? 0x80u | (id >> 28 & 3) << 4 | (id >> 15 & 3) << 2 | (id & 3) : id;
        out->points[i] = (daft_manifold_point){out_of(s, of_b, x), points[i].w, features | small};
    }
    bool flat = fabsf(f.m[axis][j]) > 0.9995f;
    daft_feature_kind other = flat ? DAFT_FEATURE_FACE : kept == 1 ? DAFT_FEATURE_VERTEX : DAFT_FEATURE_EDGE;
    out->feature_a = of_b ? other : DAFT_FEATURE_FACE;
    out->feature_b = of_b ? DAFT_FEATURE_FACE : other;
    out->normal = of_b ? column(s, axis, -f.sign) : unit_axis(axis, f.sign);
    out->face_b = of_b ? daft_neg(out->normal) : column(s, j, facing);
    return 1;
}

/* ---- two edges ---- */

static float clampf(float x, float limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

static uint32_t edge_contact(const pair *s, int i, int j, float separation, daft_manifold *out)
{
    daft_vec3 p = daft_v3(s->p[0], s->p[1], s->p[2]), along_b = column(s, j, 1), along_a = unit_axis(i, 1);
    daft_vec3 n = daft_normalize(daft_cross(along_a, along_b));
    if (daft_dot(n, p) < 0) n = daft_neg(n);
    float va[3] = {0, 0, 0}, closest = -INFINITY;
    daft_vec3 vb = p, face = {0, 0, 0};
    uint32_t corner_a = 0, corner_b = 0;
    for (int k = 0; k < 3; k++) {
        if (k != i) {
            bool low = (&n.x)[k] < 0;
            va[k] = low ? -s->ha[k] : s->ha[k];
            corner_a |= (uint32_t)low << k;
        }
        daft_vec3 axis = column(s, k, 1);
        float d = daft_dot(axis, n);
        if (k != j) {
            bool low = d > 0;
            vb = daft_add(vb, daft_scale(axis, low ? -s->hb[k] : s->hb[k]));
            corner_b |= (uint32_t)low << k;
            if (fabsf(d) > closest) closest = fabsf(d), face = low ? daft_neg(axis) : axis;
        }
    }
    /* Closest points of two lines with unit directions a, b: solve by d = a·b. */
    daft_vec3 from = daft_v3(va[0], va[1], va[2]), w = daft_sub(vb, from);
    float d = daft_dot(along_a, along_b), wa = daft_dot(w, along_a), wb = daft_dot(w, along_b);
    float t = clampf((wa * d - wb) / (1 - d * d), s->hb[j]), u = clampf(wa + t * d, s->ha[i]);
    daft_vec3 on_a = daft_add(from, daft_scale(along_a, u)), on_b = daft_add(vb, daft_scale(along_b, t));
    daft_vec3 middle = daft_scale(daft_add(on_a, on_b), 0.5f);
    uint32_t id = 3u << 30 | (uint32_t)i << 8 | (uint32_t)j << 6 | corner_a << 3 | corner_b;
    daft_vec3 shift = daft_v3(s->shift[0], s->shift[1], s->shift[2]);
    out->normal = n;
    out->count = 1;
    out->points[0] = (daft_manifold_point){daft_add(middle, shift), separation, id};
    out->feature_a = out->feature_b = DAFT_FEATURE_EDGE;
    out->face_b = face;
    return 1;
}

/* ---- choice ---- */

static daft_axis_kind choose(const pair *s, best_axis a, best_axis b, best_axis e, const daft_pair_cache *cache)
{
    float la = largest(s->ha), lb = largest(s->hb), even = EVEN * (la < lb ? la : lb);
    uint8_t before = cache ? cache->kind : 0;
    float face = a.separation > b.separation ? a.separation : b.separation, beyond = daft_edges_beyond(face);
    if (before == DAFT_AXIS_NONE || before == DAFT_AXIS_EDGES) {
        if (before == DAFT_AXIS_EDGES ? e.separation > beyond - even && face < 0 : e.separation > beyond + even)
            return DAFT_AXIS_EDGES;
    } else if (e.separation > beyond + 2 * even) {
        return DAFT_AXIS_EDGES;
    }
    /* The larger box's face is the more exact one. */
    bool prefer_b = before == DAFT_AXIS_FACE_B || (before != DAFT_AXIS_FACE_A && s->large_b);
    return b.separation > a.separation + (prefer_b ? -even : even) ? DAFT_AXIS_FACE_B : DAFT_AXIS_FACE_A;
}

/* What was cut off a box is a good deal farther away than the smaller box is large. */
static uint32_t apart(daft_pair_cache *cache, daft_axis_kind kind, const pair *s, float separation)
{
    float la = largest(s->ha), lb = largest(s->hb), most = la < lb ? la : lb;
    if (cache) *cache = (daft_pair_cache){.kind = (uint8_t)kind, .clearance = separation < most ? separation : most};
    return 0;
}

uint32_t daft_collide_boxes(daft_vec3 half_a, daft_vec3 half_b, const daft_relpose *pose, float margin,
                            daft_manifold *out, daft_pair_cache *cache)
{
    pair s;
    axes x;
    double gap;
    if (!pair_set(&s, half_a, half_b, pose, margin, &gap)) {
        if (cache) cache->clearance = (float)gap;
        return 0;
    }
    axes_set(&s, &x);
    /* a's faces: b's spread over a's axes is a sum over columns; b's faces: over rows. */
    best_axis a = faces(s.p, s.ha, s.hb, x.abs_column), b = faces(s.q, s.hb, s.ha, x.abs_row);
    if (a.separation > margin) return apart(cache, DAFT_AXIS_FACE_A, &s, a.separation);
    if (b.separation > margin) return apart(cache, DAFT_AXIS_FACE_B, &s, b.separation);
    best_axis e = {-INFINITY, 0};
    for (int i = 0; i < 3; i++) {
        best_axis one = best_of(edges(&s, &x, i));
        if (one.separation > e.separation) e = (best_axis){one.separation, 3 * i + one.number};
    }
    if (e.separation > margin) return apart(cache, DAFT_AXIS_EDGES, &s, e.separation);
    daft_axis_kind kind = choose(&s, a, b, e, cache);
    float most = fmaxf(fmaxf(a.separation, b.separation), e.separation);
    if (cache) *cache = (daft_pair_cache){.kind = (uint8_t)kind, .clearance = fmaxf(most, 0)};
    if (kind == DAFT_AXIS_EDGES) return edge_contact(&s, e.number / 3, e.number % 3, e.separation, out);
    best_axis best = kind == DAFT_AXIS_FACE_B ? b : a;
    return face_contact(&s, kind == DAFT_AXIS_FACE_B, best.number, best.separation, out);
}
