/* Box against box: the fifteen axes of two boxes (Gottschalk, Lin and Manocha, "OBBTree", 1996) four lanes at a time,
 * then what one face and the rectangle of the other share, or one point where two edges cross.
 *
 * A box much larger than the other is cut down to what is near the other before anything else, in double: what was 500
 * m of lever times a rounding error is gone, and every float below is of the size of the smaller box. */
#include "math/simd/ops.h"
#include "sim/collide/manifold_box.h"

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

/* Farther than `depth` from all faces: rounding does not matter there, the direction out does. */
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
    float la = daft_box_largest(s->ha), lb = daft_box_largest(s->hb);
    s->large_b = lb > DAFT_BOX_LARGE * la && !deep(q, s->hb, 2 * ball_a);
    s->large_a = la > DAFT_BOX_LARGE * lb && !deep(p, s->ha, 2 * ball_b);
    if (s->large_b) {
        cut_down(s->hb, q, (double)DAFT_BOX_LARGE * ball_a + (double)margin, unused);
        for (int k = 0; k < 3; k++)
            p[k] = -((double)s->r[k][0] * q[0] + (double)s->r[k][1] * q[1] + (double)s->r[k][2] * q[2]);
    } else if (s->large_a) {
        cut_down(s->ha, p, (double)DAFT_BOX_LARGE * ball_b + (double)margin, shift);
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

static v4 three(const float v[3]) { return (v4){v[0], v[1], v[2], 0}; }

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
    v4i crossing = square > v4_set(DAFT_BOX_PARALLEL);
    v4 length = v4_sqrt(v4_if_then_else(crossing, square, one));
    return v4_if_then_else(crossing, ((distance - reach_a) - reach_b) / length, v4_set(-INFINITY));
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

/* The incident face as seen from the reference: u and v in its plane, w above it. Corners are base ± a ± b. */
typedef struct outline {
    float base[3], a[3], b[3];
} outline;

typedef struct overlap {
    float u[DAFT_BOX_FARTHEST + 1], v[DAFT_BOX_FARTHEST + 1], w[DAFT_BOX_FARTHEST + 1];
    uint32_t there; /* bits */
} overlap;

/* Which of the other's faces looks at the reference most. */
static int incident(const reference *f, float *facing, outline *o)
{
    const float *row = f->m[f->axis];
    int j = fabsf(row[1]) > fabsf(row[0]) ? 1 : 0;
    if (fabsf(row[2]) > fabsf(row[j])) j = 2;
    int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    *facing = f->sign * row[j] > 0 ? -1.0f : 1.0f;
    for (int n = 0; n < 3; n++) {
        int k = (f->axis + 1 + n) % 3;
        o->base[n] = f->centre[k] + (*facing * f->other[j]) * f->m[k][j];
        o->a[n] = f->other[j1] * f->m[k][j1], o->b[n] = f->other[j2] * f->m[k][j2];
    }
    o->base[2] = f->sign * o->base[2] - f->half[f->axis];
    o->a[2] = f->sign * o->a[2], o->b[2] = f->sign * o->b[2];
    return j;
}

static void put(overlap *p, int at, float u, float v, float w, bool there)
{
    p->u[at] = u, p->v[at] = v, p->w[at] = w;
    p->there |= (uint32_t)there << at;
}

static float lesser(float a, float b) { return a < b ? a : b; }
static float greater(float a, float b) { return a > b ? a : b; }

/* Cuts the stretch of from + t·along, t from *in to *out, down to what is within ±limit. */
static void cut_stretch(float from, float along, float limit, float *in, float *out)
{
    bool flat = fabsf(along) <= DAFT_BOX_FLAT, inside = fabsf(from) <= limit;
    float inverse = 1 / (flat ? 1 : along), low = (-limit - from) * inverse, high = (limit - from) * inverse;
    float first = lesser(low, high), last = greater(low, high);
    if (flat) first = inside ? -INFINITY : INFINITY, last = -first;
    *in = greater(first, *in), *out = lesser(last, *out);
}

/* Corners of the incident face, and its edges where they cross the sides (Liang and Barsky 1984). Whether a corner is
 * inside decides alone whether an edge comes in or goes out: rounding moves points but loses none. */
static void put_edges(const outline *o, const float limit[2], overlap *p)
{
    static const float around[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    float corner[4][3];
    bool inside[4];
    for (int i = 0; i < 4; i++) {
        for (int n = 0; n < 3; n++) corner[i][n] = (o->base[n] + around[i][0] * o->a[n]) + around[i][1] * o->b[n];
        inside[i] = fabsf(corner[i][0]) <= limit[0] && fabsf(corner[i][1]) <= limit[1];
        put(p, i, corner[i][0], corner[i][1], corner[i][2], inside[i]);
    }
    for (int i = 0; i < 4; i++) {
        const float *c = corner[i], *side = i % 2 ? o->b : o->a, sign = i < 2 ? -2.0f : 2.0f;
        float along[3] = {sign * side[0], sign * side[1], sign * side[2]}, in = -INFINITY, out = INFINITY;
        cut_stretch(c[0], along[0], limit[0], &in, &out);
        cut_stretch(c[1], along[1], limit[1], &in, &out);
        bool next = inside[(i + 1) % 4], crosses = greater(in, 0) < lesser(out, 1);
        in = lesser(greater(in, 0), 1), out = lesser(greater(out, 0), 1);
        put(p, DAFT_BOX_ENTER + i, c[0] + in * along[0], c[1] + in * along[1], c[2] + in * along[2],
            !inside[i] && (next || crosses));
        put(p, DAFT_BOX_LEAVE + i, c[0] + out * along[0], c[1] + out * along[1], c[2] + out * along[2],
            !next && (inside[i] || crosses));
    }
}

/* Corners of the reference face under the incident one: by Cramer's rule in base + (x·a + y·b) / det. */
static void put_under(const outline *o, const float limit[2], overlap *p)
{
    float det = o->a[0] * o->b[1] - o->a[1] * o->b[0], most = fabsf(det) * (1 + DAFT_BOX_SEAM);
    float inverse = 1 / (det == 0 ? 1 : det);
    for (int i = 0; i < 4; i++) {
        float u = i == 1 || i == 2 ? -limit[0] : limit[0], v = i < 2 ? limit[1] : -limit[1];
        float du = u - o->base[0], dv = v - o->base[1];
        float x = du * o->b[1] - dv * o->b[0], y = o->a[0] * dv - o->a[1] * du;
        float w = o->base[2] + (x * o->a[2] + y * o->b[2]) * inverse;
        put(p, DAFT_BOX_UNDER + i, u, v, w, fabsf(x) <= most && fabsf(y) <= most && most > 0);
    }
}

static uint32_t rim_point(const overlap *p, float even)
{
    float deepest = INFINITY, most = -INFINITY;
    uint32_t best = 0;
    for (uint32_t i = 0; i < DAFT_BOX_FARTHEST; i++)
        if (p->there >> i & 1) deepest = lesser(p->w[i], deepest);
    for (uint32_t i = 0; i < DAFT_BOX_FARTHEST; i++) {
        float along = p->u[i] + DAFT_BOX_SLANT * p->v[i];
        if (p->there >> i & 1 && p->w[i] <= deepest + even && along > most) most = along, best = i;
    }
    return best;
}

/* At most four, as daft_clip_reduce chooses them. */
static uint32_t reduce(const overlap *p, float even)
{
    if (__builtin_popcount(p->there) <= DAFT_MANIFOLD_POINTS) return p->there;
    uint32_t first = rim_point(p, even), second = first, left = 0, right = 0;
    float farthest = 0, most = 0, least = 0;
    for (uint32_t i = 0; i < DAFT_BOX_FARTHEST; i++) {
        float u = p->u[i] - p->u[first], v = p->v[i] - p->v[first], square = u * u + v * v;
        if (p->there >> i & 1 && square > farthest) farthest = square, second = i;
    }
    float u = p->u[second] - p->u[first], v = p->v[second] - p->v[first];
    for (uint32_t i = 0; i < DAFT_BOX_FARTHEST; i++) {
        if (!(p->there >> i & 1)) continue;
        float side = u * (p->v[i] - p->v[first]) - v * (p->u[i] - p->u[first]);
        if (side > most) most = side, left = 1u << i;
        if (side < least) least = side, right = 1u << i;
    }
    return 1u << first | 1u << second | left | right;
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

static void put_farthest(const reference *f, overlap *p, uint32_t *corner)
{
    float x[3] = {f->centre[0], f->centre[1], f->centre[2]};
    *corner = 0;
    for (int j = 0; j < 3; j++) {
        bool low = f->sign * f->m[f->axis][j] > 0;
        for (int k = 0; k < 3; k++) x[k] += (low ? -f->other[j] : f->other[j]) * f->m[k][j];
        *corner |= (uint32_t)low << j;
    }
    put(p, DAFT_BOX_FARTHEST, x[(f->axis + 1) % 3], x[(f->axis + 2) % 3], f->sign * x[f->axis] - f->half[f->axis],
        true);
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

/* Which points there are, at most four; 0: none. */
static uint32_t face_points(const pair *s, const reference *f, const outline *o, float separation, overlap *p,
                            uint32_t *corner)
{
    int k1 = (f->axis + 1) % 3, k2 = (f->axis + 2) % 3;
    const float limit[2] = {f->half[k1] * (1 + DAFT_BOX_OVERHANG), f->half[k2] * (1 + DAFT_BOX_OVERHANG)};
    p->there = 0;
    put_edges(o, limit, p);
    put_under(o, limit, p);
    for (uint32_t i = 0; i < DAFT_BOX_FARTHEST; i++)
        if (!(p->w[i] <= s->margin)) p->there &= ~(1u << i);
    if (p->there) return reduce(p, DAFT_BOX_EVEN * f->half[k1]);
    if (separation <= 0) put_farthest(f, p, corner);
    return p->there;
}

static uint32_t face_contact(const pair *s, bool of_b, int axis, float separation, daft_manifold *out)
{
    reference f;
    outline o;
    overlap p;
    float facing;
    uint32_t corner = 0;
    reference_set(s, of_b, axis, &f);
    int j = incident(&f, &facing, &o);
    uint32_t kept = face_points(s, &f, &o, separation, &p, &corner);
    uint32_t features = (of_b ? 1u << 30 : 0) | (uint32_t)((axis << 1) + (f.sign < 0)) << 27 |
                        (uint32_t)((j << 1) + (facing < 0)) << 24;
    out->count = 0;
    for (; kept; kept &= kept - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(kept), id = i == DAFT_BOX_FARTHEST ? i | corner : i;
        float x[3];
        x[(axis + 1) % 3] = p.u[i], x[(axis + 2) % 3] = p.v[i];
        x[axis] = f.sign * (f.half[axis] + 0.5f * p.w[i]);
        out->points[out->count++] = (daft_manifold_point){out_of(s, of_b, x), p.w[i], features | id};
    }
    bool flat = fabsf(f.m[axis][j]) > 0.9995f;
    daft_feature_kind other = flat ? DAFT_FEATURE_FACE : out->count == 1 ? DAFT_FEATURE_VERTEX : DAFT_FEATURE_EDGE;
    out->feature_a = of_b ? other : DAFT_FEATURE_FACE;
    out->feature_b = of_b ? DAFT_FEATURE_FACE : other;
    out->normal = of_b ? column(s, axis, -f.sign) : unit_axis(axis, f.sign);
    out->face_b = of_b ? daft_neg(out->normal) : column(s, j, facing);
    return out->count > 0;
}

/* ---- two edges ---- */

static float clampf(float x, float limit) { return x > limit ? limit : x < -limit ? -limit : x; }

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
            bool low = daft_v3_at(n, k) < 0;
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
    float la = daft_box_largest(s->ha), lb = daft_box_largest(s->hb), even = DAFT_BOX_EVEN * (la < lb ? la : lb);
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
    float la = daft_box_largest(s->ha), lb = daft_box_largest(s->hb), most = la < lb ? la : lb;
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
    float most = greater(greater(greater(a.separation, b.separation), e.separation), 0);
    if (cache) *cache = (daft_pair_cache){.kind = (uint8_t)kind, .clearance = most};
    if (kind == DAFT_AXIS_EDGES) return edge_contact(&s, e.number / 3, e.number % 3, e.separation, out);
    best_axis best = kind == DAFT_AXIS_FACE_B ? b : a;
    return face_contact(&s, kind == DAFT_AXIS_FACE_B, best.number, best.separation, out);
}
