/* Manifolds of convex cores along an axis, and of all convex pairs that have no code of their own. */
#include "sim/collide/manifold_parts.h"

/* The reference face reaches this fraction of the smaller core's size farther when it clips; points within this
 * fraction of it count as equally deep. */
#define OVERHANG 1e-3f
/* Sides of a face whose outward normals' cosine is less meet in a corner of under 41 degrees. */
#define ACUTE -0.75f
/* Of the number of an edge: the cut across the corner where it begins. */
#define BEVEL 0x4000u
/* A normal whose cosine with a face's is over this is that face's. */
#define SAME 0.9999f

/* ---- along a face ---- */

typedef daft_face_basis basis;

static basis basis_on(daft_vec3 n, daft_vec3 origin)
{
    daft_vec3 other = fabsf(n.x) < 0.6f ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0);
    daft_vec3 u = daft_normalize(daft_cross(other, n));
    return (basis){origin, u, daft_cross(n, u), n};
}

static daft_clip_point laid(const basis *s, daft_vec3 p, float offset, uint32_t id)
{
    daft_vec3 d = daft_sub(p, s->origin);
    return (daft_clip_point){daft_dot(s->u, d), daft_dot(s->v, d), daft_dot(s->n, p) - offset, id};
}

static float smaller_size(const daft_poly *mine, const daft_poly *other)
{
    float size = other->core == DAFT_CORE_POINT ? other->radius : other->size;
    return mine->size < size ? mine->size : size;
}

/* The face that looks most against n. */
static uint32_t facing(const daft_poly *p, daft_vec3 n)
{
    uint32_t best = 0;
    float least = INFINITY;
    for (uint32_t f = 0; f < p->face_count; f++) {
        float d = daft_dot(p->planes[f].normal, n);
        if (d < least) least = d, best = f;
    }
    return best;
}

/* Of the faces around the vertex that is lowest along n, the one that looks most against n. */
static uint32_t facing_at_lowest(const daft_poly *p, daft_vec3 n)
{
    uint32_t lowest = 0, best = 0;
    float least = INFINITY;
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        float d = daft_dot(n, p->vertices[i]);
        if (d < least) least = d, lowest = i;
    }
    least = INFINITY;
    for (uint32_t e = 0; e < p->half_edge_count; e++) {
        if (p->half_edges[e].origin != lowest) continue;
        float d = daft_dot(p->planes[p->half_edges[e].face].normal, n);
        if (d < least) least = d, best = p->half_edges[e].face;
    }
    return best;
}

static uint32_t lay_incident(const basis *s, const daft_poly *p, uint32_t face, daft_clip_point *out)
{
    uint32_t count = 0;
    if (p->core == DAFT_CORE_POINT || p->core == DAFT_CORE_SEGMENT) {
        for (; count < p->vertex_count; count++) out[count] = laid(s, p->vertices[count], 0, count);
        return count;
    }
    uint32_t first = p->first_half_edges[face], e = first;
    do {
        uint32_t vertex = p->half_edges[e].origin;
        out[count++] = laid(s, p->vertices[vertex], 0, vertex);
        e = p->half_edges[e].next;
    } while (e != first);
    return count;
}

/* A line in the plane of a face; what is beyond it is cut off. */
typedef struct side {
    float a, b, c; /* unit outward normal, distance */
    uint32_t edge;
    float u, v; /* where it begins */
} side;

/* Gives how many sides a face has; those without length are left out. */
static uint32_t lay_sides(const basis *s, const daft_poly *p, uint32_t face, side sides[DAFT_HULL_MAX_VERTICES])
{
    uint32_t first = p->first_half_edges[face], e = first, count = 0;
    daft_clip_point from = laid(s, daft_poly_edge_start(p, e), 0, 0);
    do {
        daft_clip_point to = laid(s, daft_poly_edge_end(p, e), 0, 0);
        float a = to.v - from.v, b = from.u - to.u, length = sqrtf(a * a + b * b);
        if (length > 0) {
            a /= length, b /= length;
            sides[count++] = (side){a, b, a * from.u + b * from.v, e, from.u, from.v};
        }
        from = to;
        e = p->half_edges[e].next;
    } while (e != first);
    return count;
}

/* Clips by one line, if it cuts anything; gives where the points are then, and in `spare` the other buffer. */
static daft_clip_point *cut(daft_clip_point *from, uint32_t *count, float a, float b, float c, uint32_t edge,
                            daft_clip_point **spare)
{
    bool cuts = false;
    for (uint32_t i = 0; i < *count; i++) cuts |= !(from[i].u * a + from[i].v * b - c <= 0);
    if (!cuts) return from;
    daft_clip_point *to = *spare;
    *count = daft_clip(from, *count, a, b, c, edge, to);
    *spare = from;
    return to;
}

/* Clips by the sides of a face, each moved out by the overhang. Gives where the points are. */
static daft_clip_point *clip_sides(const basis *s, const daft_poly *p, uint32_t face, float overhang,
                                   daft_clip_point *from, daft_clip_point *to, uint32_t *count)
{
    side sides[DAFT_HULL_MAX_VERTICES];
    uint32_t side_count = lay_sides(s, p, face, sides);
    for (uint32_t i = 0; i<side_count && * count> 0; i++) {
        const side *l = &sides[i], *before = &sides[i > 0 ? i - 1 : side_count - 1];
        from = cut(from, count, l->a, l->b, l->c + overhang, l->edge, &to);
        if (l->a * before->a + l->b * before->b >= ACUTE) continue;
        /* Both sides moved out meet far from the corner: across it, then. */
        float a = l->a + before->a, b = l->b + before->b, length = sqrtf(a * a + b * b);
        if (!(length > 1e-6f)) continue;
        a /= length, b /= length;
        from = cut(from, count, a, b, (a * l->u + b * l->v) + overhang, l->edge | BEVEL, &to);
    }
    return from;
}

void daft_face_frame_set(daft_face_frame *frame, daft_vec3 normal, const daft_poly *other)
{
    frame->basis = basis_on(normal, other->centre);
    frame->incident = other->face_count ? facing_at_lowest(other, normal) : 0;
    frame->count = lay_incident(&frame->basis, other, frame->incident, frame->polygon);
}

/* The points of the frame's polygon over a face of `mine` that are within the margin; one of the buffers has them. */
static daft_clip_point *points_over(const daft_face_frame *frame, const daft_poly *mine, const daft_poly *other,
                                    uint32_t face, float margin, daft_clip_point buffers[2][DAFT_CLIP_MAX],
                                    uint32_t *count)
{
    float offset = mine->planes[face].offset, rounding = mine->radius + other->radius;
    *count = frame->count;
    for (uint32_t i = 0; i < frame->count; i++) {
        buffers[0][i] = frame->polygon[i];
        buffers[0][i].w -= offset;
    }
    daft_clip_point *p =
        clip_sides(&frame->basis, mine, face, OVERHANG * smaller_size(mine, other), buffers[0], buffers[1], count);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < *count; i++)
        if (p[i].w - rounding <= margin) p[kept++] = p[i];
    *count = kept;
    return p;
}

static daft_manifold_point placed(const basis *s, const daft_clip_point *p, float offset, float radius, float rounding,
                                  bool is_b)
{
    float height = (offset + radius + 0.5f * (p->w - rounding)) - daft_dot(s->n, s->origin);
    daft_vec3 at = daft_add(daft_add(s->origin, daft_scale(s->n, height)),
                            daft_add(daft_scale(s->u, p->u), daft_scale(s->v, p->v)));
    return (daft_manifold_point){at, p->w - rounding, p->id | (is_b ? 1u << 30 : 0)};
}

uint32_t daft_face_points(const daft_face_frame *frame, const daft_poly *mine, const daft_poly *other, uint32_t face,
                          bool is_b, float margin, bool all, daft_manifold *out,
                          daft_manifold_point points[DAFT_CLIP_MAX])
{
    daft_clip_point buffers[2][DAFT_CLIP_MAX];
    daft_plane plane = mine->planes[face];
    uint32_t count;
    daft_clip_point *p = points_over(frame, mine, other, face, margin, buffers, &count);
    if (count == 0) return 0;
    if (!all) count = daft_clip_reduce(p, count, OVERHANG * smaller_size(mine, other));
    for (uint32_t i = 0; i < count; i++)
        points[i] = placed(&frame->basis, &p[i], plane.offset, mine->radius, mine->radius + other->radius, is_b);
    out->normal = is_b ? daft_neg(plane.normal) : plane.normal;
    return count;
}

static uint32_t along_face(const daft_poly *mine, const daft_poly *other, uint32_t face, bool is_b, float margin,
                           daft_manifold *out)
{
    daft_manifold_point points[DAFT_CLIP_MAX];
    daft_face_frame frame;
    daft_face_frame_set(&frame, mine->planes[face].normal, other);
    out->count = daft_face_points(&frame, mine, other, face, is_b, margin, false, out, points);
    for (uint32_t i = 0; i < out->count; i++) out->points[i] = points[i];
    return out->count > 0;
}

/* ---- one point ---- */

static uint32_t one_point(daft_vec3 n, daft_vec3 point, float separation, uint32_t id, daft_manifold *out)
{
    out->normal = n;
    out->count = 1;
    out->points[0] = (daft_manifold_point){point, separation, id};
    return 1;
}

static daft_vec3 between(daft_vec3 p, daft_vec3 q, float t) { return daft_add(p, daft_scale(daft_sub(q, p), t)); }

static uint32_t along_edges(const daft_poly *a, const daft_poly *b, const daft_axis *axis, float margin,
                            daft_manifold *out)
{
    daft_vec3 p0 = daft_poly_edge_start(a, axis->a), p1 = daft_poly_edge_end(a, axis->a);
    daft_vec3 q0 = daft_poly_edge_start(b, axis->b), q1 = daft_poly_edge_end(b, axis->b);
    float s, t;
    daft_segments_closest(p0, p1, q0, q1, &s, &t);
    daft_vec3 gap = daft_sub(between(q0, q1, t), between(p0, p1, s));
    /* An axis that separates, but not between what is nearest: these edges pass each other at a distance. */
    if (axis->separation > 0 && daft_length(gap) > margin + (a->radius + b->radius)) return 0;
    float separation = axis->separation - (a->radius + b->radius);
    /* Midway along the axis, from a's edge. Edges that cross have it between them; where a face is left out (a sheet's
     * other side) the best edges may pass each other, and halfway to b's the point would be on neither. */
    daft_vec3 point = daft_add(between(p0, p1, s), daft_scale(axis->normal, a->radius + 0.5f * separation));
    uint32_t id = 3u << 29 | axis->a << 10 | axis->b;
    return one_point(axis->normal, point, separation, id, out);
}

/* Deep in each other, the incident face may miss the reference face altogether: the vertex that is farthest in, then.
 */
static uint32_t along_support(const daft_poly *a, const daft_poly *b, const daft_axis *axis, daft_manifold *out)
{
    bool of_a = axis->kind == DAFT_AXIS_FACE_A;
    const daft_poly *mine = of_a ? a : b, *other = of_a ? b : a;
    daft_vec3 n = of_a ? axis->normal : daft_neg(axis->normal), on;
    uint32_t best = 0;
    for (uint32_t i = 1; i < other->vertex_count; i++)
        if (daft_dot(n, other->vertices[i]) < daft_dot(n, other->vertices[best])) best = i;
    on = other->vertices[best];
    if (mine->core == DAFT_CORE_TRIANGLE) {
        daft_poly_closest(mine, other->vertices[best], &on);
        on = daft_add(on, daft_scale(n, axis->separation));
    }
    float separation = axis->separation - (a->radius + b->radius);
    daft_vec3 point = daft_sub(on, daft_scale(n, other->radius + 0.5f * separation));
    return one_point(axis->normal, point, separation, 7u << 28 | best, out);
}

/* The contact along one of SAT's axes: by clipping for a face, where the edges cross for edges. 0 or 1 manifolds. */
static uint32_t along_axis(const daft_poly *a, const daft_poly *b, const daft_axis *axis, float margin,
                           daft_manifold *out)
{
    switch (axis->kind) {
    case DAFT_AXIS_FACE_A: return along_face(a, b, axis->a, false, margin, out);
    case DAFT_AXIS_FACE_B: return along_face(b, a, axis->b, true, margin, out);
    case DAFT_AXIS_EDGES: return along_edges(a, b, axis, margin, out);
    case DAFT_AXIS_CLOSEST:
        return one_point(axis->normal, daft_scale(daft_add(axis->on_a, axis->on_b), 0.5f), axis->separation,
                         7u << 28 | 0xffff, out);
    default: return 0;
    }
}

/* ---- round cores outside of a solid or triangle: the closest points decide ---- */

/* From `round` (a point or a segment) to `other`; both on the cores. */
typedef struct closest {
    float distance;
    daft_vec3 on_round, on_other;
    bool edges; /* the inside of the segment and an edge */
} closest;

static void try_closest(closest *best, daft_vec3 on_round, daft_vec3 on_other, bool edges)
{
    float d = daft_length(daft_sub(on_other, on_round));
    if (d < best->distance) *best = (closest){d, on_round, on_other, edges};
}

static closest find_closest(const daft_poly *round, const daft_poly *other)
{
    closest best = {.distance = INFINITY};
    for (uint32_t i = 0; i < round->vertex_count; i++) {
        daft_vec3 on;
        daft_poly_closest(other, round->vertices[i], &on);
        try_closest(&best, round->vertices[i], on, false);
    }
    for (uint32_t e = 0; round->core == DAFT_CORE_SEGMENT && e < other->half_edge_count; e += 2) {
        daft_vec3 q0 = daft_poly_edge_start(other, e), q1 = daft_poly_edge_end(other, e);
        float s, t;
        daft_segments_closest(round->vertices[0], round->vertices[1], q0, q1, &s, &t);
        try_closest(&best, between(round->vertices[0], round->vertices[1], s), between(q0, q1, t), true);
    }
    return best;
}

/* Which face has this normal, if one has. */
static bool face_of_normal(const daft_poly *p, daft_vec3 n, uint32_t sides, uint32_t *face)
{
    *face = facing(p, daft_neg(n));
    if (p->core == DAFT_CORE_TRIANGLE && !(sides >> *face & 1)) return false;
    return daft_dot(p->planes[*face].normal, n) > SAME;
}

/* is_b: `other` is b. */
static uint32_t round_outside(const daft_poly *round, const daft_poly *other, closest c, bool is_b, float margin,
                              uint32_t sides, daft_manifold *out)
{
    float separation = c.distance - round->radius;
    if (separation > margin) return 0;
    daft_vec3 away = daft_scale(daft_sub(c.on_round, c.on_other), 1 / c.distance); /* from other */
    uint32_t face;
    if (face_of_normal(other, away, sides, &face) && along_face(other, round, face, is_b, margin, out)) return 1;
    daft_vec3 n = is_b ? daft_neg(away) : away;
    daft_vec3 point = daft_add(c.on_other, daft_scale(away, 0.5f * separation));
    return one_point(n, point, separation, 5u << 28 | (uint32_t)c.edges, out);
}

static bool is_round(const daft_poly *p) { return p->core == DAFT_CORE_POINT || p->core == DAFT_CORE_SEGMENT; }

static bool is_apart(const daft_poly *a, const daft_poly *b, float reach)
{
    return a->low.x > b->high.x + reach || a->low.y > b->high.y + reach || a->low.z > b->high.z + reach ||
           b->low.x > a->high.x + reach || b->low.y > a->high.y + reach || b->low.z > a->high.z + reach;
}

/* Whether a segment goes through a triangle. */
static bool pierces(const daft_poly *segment, const daft_poly *triangle)
{
    daft_plane plane = triangle->planes[0];
    float h0 = daft_dot(plane.normal, segment->vertices[0]) - plane.offset;
    float h1 = daft_dot(plane.normal, segment->vertices[1]) - plane.offset;
    if ((h0 > 0) == (h1 > 0)) return false;
    daft_vec3 at = between(segment->vertices[0], segment->vertices[1], h0 / (h0 - h1));
    for (uint32_t e = 0; e < 6; e += 2) {
        daft_vec3 from = daft_poly_edge_start(triangle, e), d = daft_sub(daft_poly_edge_end(triangle, e), from);
        if (daft_dot(daft_cross(plane.normal, d), daft_sub(at, from)) < 0) return false;
    }
    return true;
}

/* Whether the closest points give a good normal, and which they are: the cores are apart by more than rounding blurs.
 */
static bool clear_of(const daft_poly *round, const daft_poly *other, float separation, closest *out)
{
    float blur = 1e-3f * round->radius + 1e-6f * other->size;
    bool triangle = other->core == DAFT_CORE_TRIANGLE;
    if (!triangle && !(separation > blur)) return false;
    if (triangle && round->core == DAFT_CORE_SEGMENT && pierces(round, other)) return false;
    *out = find_closest(round, other);
    /* Beside a triangle's edge, in its plane, no axis separates. */
    return !triangle || out->distance > blur;
}

bool daft_axis_find(const daft_poly *a, const daft_poly *b, float margin, uint32_t sides, daft_pair_cache *cache,
                    daft_axis *out)
{
    float enough = margin + (a->radius + b->radius);
    if (is_apart(a, b, enough)) return false;
    *out = daft_sat(a, b, enough, sides, cache);
    if (cache) cache->kind = (uint8_t)out->kind;
    return !(out->separation > enough);
}

uint32_t daft_collide_along(const daft_poly *a, const daft_poly *b, const daft_axis *axis, float margin, uint32_t sides,
                            daft_manifold *out)
{
    closest c;
    if (is_round(a) && clear_of(a, b, axis->separation, &c)) return round_outside(a, b, c, true, margin, sides, out);
    if (is_round(b) && clear_of(b, a, axis->separation, &c)) return round_outside(b, a, c, false, margin, sides, out);
    if (along_axis(a, b, axis, margin, out)) return 1;
    if (!(axis->separation < 0) || axis->kind == DAFT_AXIS_NONE) return 0;
    /* A face preferred to about as good an axis may have only the air beside the other core over it. */
    daft_axis best = daft_sat_strict(a, b, sides);
    if (along_axis(a, b, &best, margin, out)) return 1;
    return best.separation < 0 && best.kind != DAFT_AXIS_NONE ? along_support(a, b, &best, out) : 0;
}

uint32_t daft_collide_polys(const daft_poly *a, const daft_poly *b, float margin, uint32_t sides, daft_manifold *out,
                            daft_pair_cache *cache)
{
    daft_axis axis;
    return daft_axis_find(a, b, margin, sides, cache, &axis) && daft_collide_along(a, b, &axis, margin, sides, out);
}
