/* The separating-axis test between convex cores: faces of either, and pairs of edges whose arcs on the Gauss map cross
 * (Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013). A triangle's edge has half a great circle
 * for an arc and a segment's a whole one: there the third corner decides, or nothing. */
#include "math/simd/ops.h"
#include "sim/shape/gjk.h"
#include "sim/collide/manifold_parts.h"

/* Axes within this fraction of the smaller core's size count as equally good. */
#define EVEN 1e-3f
/* Edges whose angle's square sine is less are parallel: a face has their axis. */
#define PARALLEL 1e-5f
/* A core over this many times as large as the other has the more exact faces. */
#define LARGE 4.0f

/* Pairs of half-edges that are tried without thought. */
enum { MANY = 6000 };

static v4 dot4(const v4 x[3], const v4 y[3]) { return (x[0] * y[0] + x[1] * y[1]) + x[2] * y[2]; }

static void spread4(daft_vec3 v, v4 out[3]) { out[0] = v4_set(v.x), out[1] = v4_set(v.y), out[2] = v4_set(v.z); }

/* Of up to four faces, from `first` on. */
static void face_separations(const daft_poly *mine, uint32_t first, uint32_t count, const daft_poly *other,
                             float out[4])
{
    v4 n[3] = {v4_set(0), v4_set(0), v4_set(0)}, least = v4_set(INFINITY);
    for (uint32_t i = 0; i < count; i++) {
        daft_vec3 m = mine->planes[first + i].normal;
        n[0][i] = m.x, n[1][i] = m.y, n[2][i] = m.z;
    }
    for (uint32_t i = 0; i < other->vertex_count; i++) {
        v4 p[3];
        spread4(other->vertices[i], p);
        v4 d = dot4(n, p);
        least = v4_if_then_else(d < least, d, least);
    }
    for (uint32_t i = 0; i < count; i++) out[i] = least[i] - mine->planes[first + i].offset;
}

static bool face_counts(const daft_poly *p, uint32_t face, uint32_t sides)
{
    return p->core != DAFT_CORE_TRIANGLE || (sides >> face & 1);
}

static void try_faces(const daft_poly *mine, const daft_poly *other, bool is_b, uint32_t sides, float enough,
                      daft_axis *best)
{
    float separations[4];
    best->separation = -INFINITY;
    best->kind = DAFT_AXIS_NONE;
    for (uint32_t f = 0; f < mine->face_count; f++) {
        if (f % 4 == 0) {
            uint32_t left = mine->face_count - f;
            face_separations(mine, f, left < 4 ? left : 4, other, separations);
        }
        if (!face_counts(mine, f, sides)) continue;
        float s = separations[f % 4];
        if (s <= best->separation) continue;
        daft_vec3 n = mine->planes[f].normal;
        *best = is_b ? (daft_axis){.kind = DAFT_AXIS_FACE_B, .b = f, .separation = s, .normal = daft_neg(n)}
                     : (daft_axis){.kind = DAFT_AXIS_FACE_A, .a = f, .separation = s, .normal = n};
        if (s > enough) return;
    }
}

/* The same as try_faces of both, for a box around the origin of a's frame and a triangle: extents say it all. */
static void try_box_faces(const daft_poly *box, const daft_poly *triangle, uint32_t sides, daft_axis *of_box,
                          daft_axis *of_triangle)
{
    of_box->separation = of_triangle->separation = -INFINITY;
    of_box->kind = of_triangle->kind = DAFT_AXIS_NONE;
    for (uint32_t f = 0; f < 6; f++) {
        const daft_plane *plane = &box->planes[f];
        float s = (f & 1 ? daft_v3_at(triangle->low, (int)(f / 2)) : -daft_v3_at(triangle->high, (int)(f / 2))) -
                  plane->offset;
        if (s > of_box->separation)
            *of_box = (daft_axis){.kind = DAFT_AXIS_FACE_A, .a = f, .separation = s, .normal = plane->normal};
    }
    float least = INFINITY, most = -INFINITY;
    daft_vec3 n = triangle->planes[0].normal;
    for (uint32_t i = 0; i < 8; i++) {
        float d = daft_dot(n, box->vertices[i]);
        least = d < least ? d : least, most = d > most ? d : most;
    }
    for (uint32_t f = 0; f < 2; f++) {
        float s = (f ? -most : least) - triangle->planes[f].offset;
        if (!(sides >> f & 1) || s <= of_triangle->separation) continue;
        *of_triangle = (daft_axis){
            .kind = DAFT_AXIS_FACE_B, .b = f, .separation = s, .normal = daft_neg(triangle->planes[f].normal)};
    }
}

/* ---- edges ---- */

typedef struct edge {
    uint32_t number; /* half-edge */
    daft_vec3 from, d;
    daft_vec3 n1, n2; /* of the faces on both sides; solids */
} edge;

enum { MAX_EDGES = DAFT_HULL_MAX_HALF_EDGES / 2 };

/* All edges, or those whose bounds come within `reach` of the other core's. */
static uint32_t gather_edges(const daft_poly *p, const daft_poly *other, float reach, edge *out)
{
    daft_vec3 r = daft_v3(reach, reach, reach), low = daft_sub(other->low, r), high = daft_add(other->high, r);
    uint32_t count = 0;
    for (uint32_t i = 0; i < p->half_edge_count; i += 2) {
        daft_vec3 from = daft_poly_edge_start(p, i), to = daft_poly_edge_end(p, i);
        daft_vec3 least = daft_min3(from, to), most = daft_max3(from, to);
        if (least.x > high.x || least.y > high.y || least.z > high.z) continue;
        if (most.x < low.x || most.y < low.y || most.z < low.z) continue;
        edge *e = &out[count++];
        *e = (edge){.number = i, .from = from, .d = daft_sub(to, from)};
        if (p->core != DAFT_CORE_SOLID) continue;
        e->n1 = p->planes[p->half_edges[i].face].normal;
        e->n2 = p->planes[p->half_edges[i ^ 1].face].normal;
    }
    return count;
}

/* Where the arc between the faces' normals crosses the plane across `d`: the direction in which this edge is extreme.
 */
static daft_vec3 arc_crossing(const edge *e, float t1, float t2)
{
    return daft_add(daft_scale(e->n1, fabsf(t2)), daft_scale(e->n2, fabsf(t1)));
}

/* A point of the core that is not on the edge, which tells on which side of the edge a triangle is. */
static daft_vec3 third(const daft_poly *p, const edge *e)
{
    uint32_t next = p->half_edges[p->half_edges[e->number].next].next;
    return p->vertices[p->half_edges[next].origin];
}

/* Whether, with `out` as the direction away from the core, the edge is extreme. May turn `out` round once, where
 * nothing has fixed its sign yet. */
static bool is_extreme(const daft_poly *p, const edge *e, daft_vec3 crossing, float sign, daft_vec3 *out, bool *fixed)
{
    float along = 0; /* of the core beyond the edge; must be negative */
    if (p->core == DAFT_CORE_SEGMENT) return true;
    if (p->core == DAFT_CORE_SOLID)
        along = -sign * daft_dot(*out, crossing);
    else
        along = sign * daft_dot(*out, daft_sub(third(p, e), e->from));
    if (along > 0 && !*fixed) *out = daft_neg(*out), along = -along;
    *fixed = true;
    return along <= 0;
}

static void try_edge_pair(const daft_poly *a, const daft_poly *b, const edge *ea, const edge *eb, daft_axis *best)
{
    daft_vec3 crossing_a = {0, 0, 0}, crossing_b = {0, 0, 0};
    if (a->core == DAFT_CORE_SOLID) {
        float t1 = daft_dot(ea->n1, eb->d), t2 = daft_dot(ea->n2, eb->d);
        if (t1 * t2 >= 0) return;
        crossing_a = arc_crossing(ea, t1, t2);
    }
    if (b->core == DAFT_CORE_SOLID) {
        float t1 = daft_dot(eb->n1, ea->d), t2 = daft_dot(eb->n2, ea->d);
        if (t1 * t2 >= 0) return;
        crossing_b = arc_crossing(eb, t1, t2);
    }
    daft_vec3 n = daft_cross(ea->d, eb->d);
    float square = daft_dot(n, n);
    if (square <= PARALLEL * daft_dot(ea->d, ea->d) * daft_dot(eb->d, eb->d)) return;
    bool fixed = false;
    if (!is_extreme(a, ea, crossing_a, 1, &n, &fixed) || !is_extreme(b, eb, crossing_b, -1, &n, &fixed)) return;
    n = daft_scale(n, 1 / sqrtf(square));
    float s = daft_dot(n, daft_sub(eb->from, ea->from));
    if (s > best->separation)
        *best = (daft_axis){.kind = DAFT_AXIS_EDGES, .a = ea->number, .b = eb->number, .separation = s, .normal = n};
}

/* A solid's edges, component by component; those past the end are zero and cross no arc. */
typedef struct edge_lanes {
    float d[3][MAX_EDGES + 4], n1[3][MAX_EDGES + 4], n2[3][MAX_EDGES + 4];
} edge_lanes;

static void fill_lanes(const edge *e, uint32_t count, edge_lanes *out)
{
    for (uint32_t i = 0; i < ((count + 3) & ~3u); i++) {
        static const edge none = {0};
        const edge *from = i < count ? &e[i] : &none;
        for (int k = 0; k < 3; k++) {
            out->d[k][i] = daft_v3_at(from->d, k);
            out->n1[k][i] = daft_v3_at(from->n1, k);
            out->n2[k][i] = daft_v3_at(from->n2, k);
        }
    }
}

static void load3(const float from[3][MAX_EDGES + 4], uint32_t i, v4 out[3])
{
    for (int k = 0; k < 3; k++) out[k] = v4_load(&from[k][i]);
}

/* Of four of a solid's edges, which have an arc that crosses that of `e`, another solid's edge. */
static uint32_t crossing_arcs(const edge *e, const edge_lanes *lanes, uint32_t i)
{
    v4 mine[3], theirs[3];
    load3(lanes->d, i, theirs);
    spread4(e->n1, mine);
    v4 t1 = dot4(mine, theirs);
    spread4(e->n2, mine);
    v4i crosses = t1 * dot4(mine, theirs) < v4_set(0);
    if (v4_bits_from_mask(crosses) == 0) return 0;
    spread4(e->d, mine);
    load3(lanes->n1, i, theirs);
    v4 u1 = dot4(mine, theirs);
    load3(lanes->n2, i, theirs);
    return v4_bits_from_mask(crosses & (u1 * dot4(mine, theirs) < v4_set(0)));
}

static void try_edges(const daft_poly *a, const daft_poly *b, float reach, float enough, daft_axis *best)
{
    edge ea[MAX_EDGES], eb[MAX_EDGES];
    edge_lanes lanes;
    best->separation = -INFINITY;
    best->kind = DAFT_AXIS_NONE;
    if (a->half_edge_count == 0 || b->half_edge_count == 0) return;
    uint32_t count_a = gather_edges(a, b, reach, ea), count_b = gather_edges(b, a, reach, eb);
    bool solids = a->core == DAFT_CORE_SOLID && b->core == DAFT_CORE_SOLID;
    if (solids) fill_lanes(eb, count_b, &lanes);
    for (uint32_t i = 0; i < count_a; i++)
        for (uint32_t j = 0; j < count_b; j += 4) {
            uint32_t left = count_b - j < 4 ? count_b - j : 4;
            uint32_t tried = solids ? crossing_arcs(&ea[i], &lanes, j) : (1u << left) - 1;
            for (; tried; tried &= tried - 1)
                try_edge_pair(a, b, &ea[i], &eb[j + (uint32_t)__builtin_ctz(tried)], best);
            if (best->separation > enough) return;
        }
}

/* The greatest separation along the axes across both an edge of a triangle and one of a box, which is a's frame's own
 * and around its origin: never less than what its edges give, but for parallel ones, which give nothing
 * (Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", 2001). */
static float box_edges_bound(const daft_poly *box, const daft_poly *triangle)
{
    const float h[3] = {box->high.x, box->high.y, box->high.z};
    float most = -INFINITY;
    for (int k = 0; k < 3; k++) {
        const daft_vec3 *v0 = &triangle->vertices[k], *v1 = &triangle->vertices[(k + 1) % 3],
                        *v2 = &triangle->vertices[(k + 2) % 3];
        const float p[3] = {v0->x, v0->y, v0->z}, q[3] = {v1->x, v1->y, v1->z}, r[3] = {v2->x, v2->y, v2->z};
        float d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
        float square[3] = {d[0] * d[0], d[1] * d[1], d[2] * d[2]}, all = (square[0] + square[1]) + square[2];
        for (int i = 0; i < 3; i++) { /* the axis: (0, -d[v], d[u]) for i = 0, and so on */
            int u = (i + 1) % 3, v = (i + 2) % 3;
            float length = square[u] + square[v];
            if (!(length > PARALLEL * all)) continue;
            float on = d[u] * p[v] - d[v] * p[u], off = d[u] * r[v] - d[v] * r[u];
            float reach = h[v] * fabsf(d[u]) + h[u] * fabsf(d[v]);
            float apart = on < off ? (on > -off ? on : -off) : (off > -on ? off : -on);
            apart = (apart - reach) / sqrtf(length);
            if (apart > most) most = apart;
        }
    }
    return most;
}

/* Cores that overlap by less than all faces say have the two edges that cross at the least depth near each other, so
 * those far from the other core need no look; where there are many that saves most of the work. Cores that are apart
 * may be separated by edges that are anywhere: then the closest points say more than all edges do. */
static void try_near_edges(const daft_poly *a, const daft_poly *b, float face, float enough, daft_axis *best)
{
    bool many = a->half_edge_count * b->half_edge_count > MANY;
    if (!many || face >= 0) {
        try_edges(a, b, many ? enough : INFINITY, enough, best);
        return;
    }
    daft_proxy pa = {.points = a->vertices, .count = a->vertex_count};
    daft_proxy pb = {.points = b->vertices, .count = b->vertex_count};
    daft_rigid same = daft_rigid_identity();
    daft_gjk g;
    daft_gjk_distance(&pa, &pb, &same, INFINITY, &g);
    if (!(g.distance > 1e-6 * (double)(a->size + b->size))) {
        try_edges(a, b, fmaxf(-face, enough), enough, best);
        return;
    }
    *best = (daft_axis){DAFT_AXIS_CLOSEST,    0, 0, (float)g.distance, daft_to_float(g.normal), daft_to_float(g.on_a),
                        daft_to_float(g.on_b)};
}

/* ---- all ---- */

daft_axis daft_sat(const daft_poly *a, const daft_poly *b, float enough, uint32_t sides, const daft_pair_cache *cache)
{
    daft_axis axis_a, axis_b, axis_e;
    bool boxed = a->half_edges == daft_box_half_edges && b->core == DAFT_CORE_TRIANGLE;
    if (boxed)
        try_box_faces(a, b, sides, &axis_a, &axis_b);
    else
        try_faces(a, b, false, sides, enough, &axis_a);
    if (axis_a.separation > enough) return axis_a;
    if (!boxed) try_faces(b, a, true, sides, enough, &axis_b);
    if (axis_b.separation > enough) return axis_b;
    float face = axis_a.separation > axis_b.separation ? axis_a.separation : axis_b.separation;
    float size = a->size < b->size ? a->size : b->size, even = EVEN * size;
    uint8_t before = cache ? cache->kind : DAFT_AXIS_NONE;
    float beyond = daft_edges_beyond(face);
    beyond += before == DAFT_AXIS_EDGES ? -even : before == DAFT_AXIS_NONE ? even : 2 * even;
    axis_e.kind = DAFT_AXIS_NONE, axis_e.separation = -INFINITY;
    if (!boxed || box_edges_bound(a, b) > beyond - 1e-5f * (a->size + b->size))
        try_near_edges(a, b, face, enough, &axis_e);
    if (axis_e.separation > enough || axis_e.kind == DAFT_AXIS_CLOSEST) return axis_e;

    if (axis_e.kind == DAFT_AXIS_EDGES && axis_e.separation > beyond) return axis_e;
    bool prefer_b = before == DAFT_AXIS_FACE_B || (before != DAFT_AXIS_FACE_A && b->size > LARGE * a->size);
    if (axis_a.kind == DAFT_AXIS_NONE) return axis_b;
    if (axis_b.kind == DAFT_AXIS_NONE) return axis_a;
    return axis_b.separation > axis_a.separation + (prefer_b ? -even : even) ? axis_b : axis_a;
}

daft_axis daft_sat_strict(const daft_poly *a, const daft_poly *b, uint32_t sides)
{
    daft_axis axis_a, axis_b, axis_e;
    try_faces(a, b, false, sides, INFINITY, &axis_a);
    try_faces(b, a, true, sides, INFINITY, &axis_b);
    daft_axis best = axis_b.separation > axis_a.separation ? axis_b : axis_a;
    try_near_edges(a, b, best.separation, 0, &axis_e);
    return axis_e.separation > best.separation ? axis_e : best;
}
