/* Convex hulls: polygons from the triangulated surface of hull_build.c. Triangles whose corners all lie near to the
 * plane of a large one become one face, so that a box has six faces and contacts on them do not flicker between
 * triangles. On a convex surface such triangles around one form a disc; where rounding says otherwise the triangles
 * stay as they are. */
#include "sim/shape/hull_build.h"

#include <string.h>

/* Corners within this many times the rounding of a face's plane belong to it. */
#define FLAT 10

enum { MAX_CORNERS = 3 * DAFT_HULL_MAX_FACES };

/* Polygons over the points' compact numbers. */
typedef struct polygons {
    const daft_vec3 *points;
    uint32_t used[DAFT_HULL_MAX_VERTICES + 4]; /* compact number -> point */
    uint32_t vertex_count;
    uint16_t corners[DAFT_HULL_MAX_FACES][3]; /* of triangles, compact */
    uint16_t group[DAFT_HULL_MAX_FACES];      /* of triangles */
    uint32_t group_count;
    uint16_t loop[MAX_CORNERS]; /* faces' corners, one after the other */
    uint16_t first[DAFT_HULL_MAX_FACES + 1];
} polygons;

static daft_dvec3 corner(const polygons *p, uint16_t vertex) { return daft_to_double(p->points[p->used[vertex]]); }

static void number_vertices(const daft_hull_mesh *mesh, polygons *p)
{
    p->vertex_count = 0;
    for (uint32_t i = 0; i < mesh->count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t point = mesh->triangles[i].vertex[k], v = 0;
            while (v < p->vertex_count && p->used[v] != point) v++;
            if (v == p->vertex_count) p->used[p->vertex_count++] = point;
            p->corners[i][k] = (uint16_t)v;
        }
}

static daft_dvec3 triangle_normal(const polygons *p, uint32_t i)
{
    daft_dvec3 a = corner(p, p->corners[i][0]);
    return daft_dcross(daft_dsub(corner(p, p->corners[i][1]), a), daft_dsub(corner(p, p->corners[i][2]), a));
}

static bool lies_in(const polygons *p, uint32_t triangle, daft_dvec3 origin, daft_dvec3 unit, double tolerance)
{
    daft_dvec3 n = triangle_normal(p, triangle);
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        daft_dvec3 d = daft_dsub(corner(p, p->corners[triangle][k]), corner(p, p->corners[triangle][(k + 1) % 3]));
        longest = fmax(longest, sqrt(daft_ddot(d, d)));
    }
    /* A sliver's normal may point anywhere. */
    if (daft_ddot(n, unit) <= 0 && sqrt(daft_ddot(n, n)) > tolerance * longest) return false;
    for (int k = 0; k < 3; k++)
        if (fabs(daft_ddot(unit, daft_dsub(corner(p, p->corners[triangle][k]), origin))) > tolerance) return false;
    return true;
}

static void spread(const daft_hull_mesh *mesh, polygons *p, uint32_t seed)
{
    uint16_t stack[MAX_CORNERS];
    uint32_t depth = 0;
    daft_dvec3 n = triangle_normal(p, seed), origin = corner(p, p->corners[seed][0]);
    double length = sqrt(daft_ddot(n, n));
    n = daft_dscale(n, length > 0 ? 1 / length : 0);
    uint16_t number = (uint16_t)p->group_count++;
    p->group[seed] = number;
    stack[depth++] = (uint16_t)seed;
    while (depth > 0) {
        const daft_hull_triangle *t = &mesh->triangles[stack[--depth]];
        for (int k = 0; k < 3; k++) {
            uint16_t other = t->adjacent[k];
            if (p->group[other] != UINT16_MAX || !lies_in(p, other, origin, n, FLAT * mesh->tolerance)) continue;
            p->group[other] = number;
            stack[depth++] = other;
        }
    }
}

/* From the largest triangle on, so that slivers never decide a plane. */
static void group_triangles(const daft_hull_mesh *mesh, polygons *p)
{
    p->group_count = 0;
    for (uint32_t i = 0; i < mesh->count; i++) p->group[i] = UINT16_MAX;
    for (;;) {
        uint32_t best = UINT32_MAX;
        double most = -1;
        for (uint32_t i = 0; i < mesh->count; i++) {
            daft_dvec3 n = triangle_normal(p, i);
            double area = daft_ddot(n, n);
            if (p->group[i] == UINT16_MAX && area > most) most = area, best = i;
        }
        if (best == UINT32_MAX) return;
        spread(mesh, p, best);
    }
}

/* Walks around a group into loop[from..]. Gives the corners, or 0 if its rim is not one simple ring. */
static uint32_t walk_rim(const daft_hull_mesh *mesh, polygons *p, uint16_t group, uint32_t from)
{
    uint16_t next[DAFT_HULL_MAX_VERTICES + 4];
    uint16_t start = UINT16_MAX;
    uint32_t edges = 0, count = 0;
    memset(next, 0xff, sizeof next);
    for (uint32_t i = 0; i < mesh->count; i++) {
        if (p->group[i] != group) continue;
        for (int k = 0; k < 3; k++) {
            if (p->group[mesh->triangles[i].adjacent[k]] == group) continue;
            start = p->corners[i][k];
            if (next[start] != UINT16_MAX) return 0;
            next[start] = p->corners[i][(k + 1) % 3];
            edges++;
        }
    }
    uint16_t v = start;
    for (; count < edges && v != UINT16_MAX; v = next[v]) p->loop[from + count++] = v;
    return edges >= 3 && v == start && count == edges ? count : 0;
}

static bool walk_all(const daft_hull_mesh *mesh, polygons *p)
{
    uint32_t used = 0;
    for (uint32_t g = 0; g < p->group_count; g++) {
        p->first[g] = (uint16_t)used;
        uint32_t count = walk_rim(mesh, p, (uint16_t)g, used);
        if (count == 0) return false;
        used += count;
    }
    p->first[p->group_count] = (uint16_t)used;
    return true;
}

/* A corner of only two faces is on the edge between them, and one of none is inside a face: both go. */
static bool drop_idle_corners(polygons *p)
{
    uint8_t faces[DAFT_HULL_MAX_VERTICES + 4] = {0};
    uint16_t number[DAFT_HULL_MAX_VERTICES + 4];
    for (uint32_t i = 0; i < p->first[p->group_count]; i++) faces[p->loop[i]]++;
    uint32_t kept = 0, out = 0;
    for (uint32_t v = 0; v < p->vertex_count; v++) {
        if (faces[v] < 3) continue;
        number[v] = (uint16_t)kept;
        p->used[kept++] = p->used[v];
    }
    p->vertex_count = kept;
    for (uint32_t g = 0, i = 0; g < p->group_count; g++) {
        uint32_t end = p->first[g + 1], begun = out;
        p->first[g] = (uint16_t)out;
        for (; i < end; i++)
            if (faces[p->loop[i]] >= 3) p->loop[out++] = number[p->loop[i]];
        if (out - begun < 3) return false;
    }
    p->first[p->group_count] = (uint16_t)out;
    return kept + p->group_count == out / 2 + 2; /* Euler */
}

static bool merge_faces(const daft_hull_mesh *mesh, polygons *p)
{
    number_vertices(mesh, p);
    group_triangles(mesh, p);
    if (walk_all(mesh, p) && drop_idle_corners(p)) return true;
    number_vertices(mesh, p);
    p->group_count = mesh->count;
    for (uint16_t i = 0; i < mesh->count; i++) p->group[i] = i;
    return walk_all(mesh, p);
}

/* ---- the hull itself ---- */

/* Newell's normal, in double; the offset is the farthest of all vertices', so that none is in front. */
static daft_plane fit_plane(const daft_hull *hull, uint16_t face)
{
    daft_dvec3 n = {0, 0, 0};
    uint16_t first = hull->first_half_edges[face], e = first;
    daft_dvec3 origin = daft_to_double(hull->vertices[hull->half_edges[first].origin]);
    do {
        uint16_t next = hull->half_edges[e].next;
        daft_dvec3 u = daft_dsub(daft_to_double(hull->vertices[hull->half_edges[e].origin]), origin);
        daft_dvec3 v = daft_dsub(daft_to_double(hull->vertices[hull->half_edges[next].origin]), origin);
        n = daft_dadd(n, daft_dcross(u, v));
        e = next;
    } while (e != first);
    double length = sqrt(daft_ddot(n, n)), offset = -INFINITY;
    daft_vec3 normal = daft_to_float(daft_dscale(n, 1 / length));
    for (uint16_t i = 0; i < hull->vertex_count; i++)
        offset = fmax(offset, daft_ddot(daft_to_double(normal), daft_to_double(hull->vertices[i])));
    return (daft_plane){normal, (float)offset};
}

/* An edge gets the pair of numbers 2i, 2i + 1 when its first side is met. */
static bool link_half_edges(daft_hull *hull, const polygons *p)
{
    uint16_t made = 0;
    static const uint16_t none = UINT16_MAX;
    uint16_t edge_of[DAFT_HULL_MAX_VERTICES][DAFT_HULL_MAX_VERTICES]; /* from, to */
    memset(edge_of, 0xff, sizeof edge_of);
    for (uint16_t f = 0; f < hull->face_count; f++) {
        uint16_t previous = none, first = none;
        for (uint32_t i = p->first[f]; i < p->first[f + 1]; i++) {
            uint16_t from = p->loop[i], to = p->loop[i + 1 < p->first[f + 1] ? i + 1 : p->first[f]];
            if (edge_of[from][to] == none) {
                if (made + 2 > hull->half_edge_count) return false;
                edge_of[from][to] = made, edge_of[to][from] = (uint16_t)(made + 1);
                made = (uint16_t)(made + 2);
            }
            uint16_t e = edge_of[from][to];
            hull->half_edges[e] = (daft_half_edge){.origin = from, .face = f};
            if (first == none) first = e;
            if (previous != none) hull->half_edges[previous].next = e;
            previous = e;
        }
        hull->half_edges[previous].next = first;
        hull->first_half_edges[f] = first;
    }
    return made == hull->half_edge_count;
}

static daft_hull *hull_allocate(const daft_allocator *allocator, const polygons *p)
{
    daft_hull *hull = daft_alloc_zero(allocator, 1, sizeof *hull);
    if (!hull) return NULL;
    hull->allocator = *allocator;
    hull->vertex_count = (uint16_t)p->vertex_count;
    hull->face_count = (uint16_t)p->group_count;
    hull->half_edge_count = p->first[p->group_count];
    hull->vertices = daft_alloc(allocator, hull->vertex_count, sizeof *hull->vertices);
    hull->planes = daft_alloc(allocator, hull->face_count, sizeof *hull->planes);
    hull->first_half_edges = daft_alloc(allocator, hull->face_count, sizeof *hull->first_half_edges);
    hull->half_edges = daft_alloc_zero(allocator, hull->half_edge_count, sizeof *hull->half_edges);
    if (hull->vertices && hull->planes && hull->first_half_edges && hull->half_edges) return hull;
    daft_hull_free(hull);
    return NULL;
}

static void hull_fill(daft_hull *hull, const polygons *p)
{
    hull->low = daft_v3(INFINITY, INFINITY, INFINITY), hull->high = daft_neg(hull->low);
    for (uint16_t i = 0; i < hull->vertex_count; i++) {
        hull->vertices[i] = p->points[p->used[i]];
        hull->low = daft_min3(hull->low, hull->vertices[i]);
        hull->high = daft_max3(hull->high, hull->vertices[i]);
    }
}

daft_hull *daft_hull_create(const daft_allocator *allocator, const daft_vec3 *points, uint32_t count,
                            uint32_t max_vertices, daft_error *error)
{
    if (max_vertices == 0) max_vertices = DAFT_HULL_MAX_VERTICES;
    if (max_vertices < 4 || max_vertices > DAFT_HULL_MAX_VERTICES) {
        daft_fail(error, DAFT_ERROR_ARGUMENT, "a convex hull of at most %u vertices; it takes 4 to %d", max_vertices,
                  DAFT_HULL_MAX_VERTICES);
        return NULL;
    }
    daft_hull_mesh *mesh = daft_alloc(allocator, 1, sizeof *mesh);
    polygons *p = daft_alloc(allocator, 1, sizeof *p);
    daft_hull *hull = NULL;
    if (!mesh || !p) {
        daft_fail_memory(error, "a convex hull");
    } else if (daft_hull_build(allocator, points, count, max_vertices, mesh, error)) {
        p->points = points;
        if (!merge_faces(mesh, p))
            daft_fail(error, DAFT_ERROR_ARGUMENT, "the points of a convex hull are too flat for their size");
        else if (!(hull = hull_allocate(allocator, p)))
            daft_fail_memory(error, "a convex hull");
    }
    if (hull) {
        hull_fill(hull, p);
        hull->deviation = (float)mesh->deviation;
        bool linked = link_half_edges(hull, p);
        for (uint16_t f = 0; linked && f < hull->face_count; f++) {
            hull->planes[f] = fit_plane(hull, f);
            linked = daft_finite3(hull->planes[f].normal);
        }
        daft_sim_shape shape = daft_shape_hull(hull);
        daft_mass mass;
        if (!linked || !daft_shape_mass(&shape, 1, &mass)) {
            daft_fail(error, DAFT_ERROR_ARGUMENT, "the points of a convex hull are too flat for their size");
            daft_hull_free(hull);
            hull = NULL;
        } else {
            hull->centre = daft_to_float(mass.centre);
        }
    }
    daft_release(allocator, p);
    daft_release(allocator, mesh);
    return hull;
}

daft_hull *daft_hull_create_mesh(const daft_allocator *allocator, const daft_trimesh *mesh, daft_vec3 scale,
                                 uint32_t max_vertices, daft_error *error)
{
    size_t corners = 3 * (size_t)mesh->triangle_count, count = 0;
    daft_vec3 *points = daft_alloc(allocator, mesh->vertex_count, sizeof *points);
    uint8_t *used = daft_alloc_zero(allocator, mesh->vertex_count, 1);
    daft_hull *hull = NULL;
    if (points && used) {
        for (size_t i = 0; i < corners; i++) used[mesh->indices[i]] = 1;
        for (uint32_t v = 0; v < mesh->vertex_count; v++)
            if (used[v]) points[count++] = daft_mul(daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]), scale);
        hull = daft_hull_create(allocator, points, (uint32_t)count, max_vertices, error);
    } else {
        daft_fail_memory(error, "the points of a convex hull");
    }
    daft_release(allocator, used);
    daft_release(allocator, points);
    return hull;
}

void daft_hull_free(daft_hull *hull)
{
    if (!hull) return;
    daft_allocator allocator = hull->allocator;
    daft_release(&allocator, hull->vertices);
    daft_release(&allocator, hull->planes);
    daft_release(&allocator, hull->first_half_edges);
    daft_release(&allocator, hull->half_edges);
    daft_release(&allocator, hull);
}
