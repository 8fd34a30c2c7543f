/* Smooth normals. Around each vertex, corners are joined across every edge that two triangles meet at flatter than the
 * crease; each set of joined corners gets the mean of its faces' normals, weighted by the angle of the face at the
 * corner (Thürmer and Wüthrich 1998), which does not depend on how a flat region is cut into triangles.
 *
 * Corners are listed by vertex with one counting sort, and then one vertex after the other is worked on in small
 * arrays: time is linear, but for a factor log k around a vertex of k > 16 corners. The order is that of the corners,
 * so the bits depend on the mesh alone. */
#include "geometry/trimesh.h"

#include "math/real.h"

#include <string.h>

/* Around a vertex of up to so many corners every pair is compared; above, neighbours are sorted. */
enum { SMALL_FAN = 16 };

#define SEVERAL UINT32_MAX

typedef struct face {
    daft_vec3 normal; /* unit length, zero without area */
    float angles[3];  /* at the corners, radians */
} face;

typedef uint32_t lanes __attribute__((vector_size(16)));

/* The corners at a vertex of few, side by side. */
enum { RING = 8, AHEAD = 32 };
typedef struct ring {
    lanes next[RING / 4], previous[RING / 4]; /* the other two vertices of each triangle */
    daft_vec3 normals[RING];
    float angles[RING];
    uint32_t groups[RING];
} ring;

/* One corner at the vertex that is worked on. */
typedef struct spoke {
    uint32_t corner, next, previous; /* the other two vertices of its triangle */
    uint32_t parent;                 /* union-find among the spokes; the first of a set is its root */
    uint32_t set;
} spoke;

/* A spoke seen along one of its two edges. */
typedef struct edge {
    uint32_t vertex, spoke;
} edge;

typedef struct smoother {
    const daft_allocator *allocator;
    daft_trimesh *mesh;
    const uint32_t *groups;
    float cosine; /* of the crease; above 1 where nothing is joined */
    face *faces;
    uint32_t *first; /* of each vertex in `corners`; vertex_count + 1 */
    uint32_t *corners;
    uint32_t *single; /* the normal that all corners of a vertex share, or SEVERAL */
    spoke *spokes;    /* as many as the vertex with most corners has */
    daft_dvec3 *sums; /* of each set of them */
    edge *edges;      /* twice as many, for fans that are not small */
    size_t normal_room;
} smoother;

/* Abramowitz and Stegun 4.4.46 on 0..1; absolute error below 3e-8. */
static double arc_cosine(double x)
{
    double a = fabs(x) < 1 ? fabs(x) : 1;
    double series = -0.0012624911;
    series = series * a + 0.0066700901;
    series = series * a - 0.0170881256;
    series = series * a + 0.0308918810;
    series = series * a - 0.0501743046;
    series = series * a + 0.0889789874;
    series = series * a - 0.2145988016;
    series = series * a + 1.5707963050;
    double angle = sqrt(1 - a) * series;
    return x < 0 ? DAFT_PI - angle : angle;
}

static face face_of(const daft_trimesh *mesh, uint32_t triangle)
{
    const uint32_t *v = mesh->indices + 3 * (size_t)triangle;
    daft_dvec3 a = daft_to_double(daft_trimesh_position(mesh, v[0]));
    daft_dvec3 b = daft_to_double(daft_trimesh_position(mesh, v[1]));
    daft_dvec3 c = daft_to_double(daft_trimesh_position(mesh, v[2]));
    daft_dvec3 ab = daft_dsub(b, a), ac = daft_dsub(c, a), bc = daft_dsub(c, b);
    double ab2 = daft_ddot(ab, ab), ac2 = daft_ddot(ac, ac), bc2 = daft_ddot(bc, bc);
    face f = {daft_to_float(daft_unit(daft_dcross(ab, ac))), {0, 0, 0}};
    if (!(ab2 > 0 && ac2 > 0 && bc2 > 0)) return f; /* a corner without an angle weighs nothing */
    double at_a = arc_cosine(daft_ddot(ab, ac) / sqrt(ab2 * ac2)),
           at_b = arc_cosine(-daft_ddot(ab, bc) / sqrt(ab2 * bc2));
    f.angles[0] = (float)at_a;
    f.angles[1] = (float)at_b;
    f.angles[2] = (float)fmax(0, DAFT_PI - at_a - at_b);
    return f;
}

/* Fills first and corners; returns the largest number of corners at a vertex. */
static uint32_t list_corners(smoother *s)
{
    const uint32_t *indices = s->mesh->indices;
    uint32_t corners = 3 * s->mesh->triangle_count, vertices = s->mesh->vertex_count, most = 0;
    memset(s->first, 0, ((size_t)vertices + 1) * sizeof *s->first);
    for (uint32_t i = 0; i < corners; i++) s->first[indices[i]]++;
    uint32_t sum = 0;
    for (uint32_t i = 0; i <= vertices; i++) {
        uint32_t count = i < vertices ? s->first[i] : 0;
        if (count > most) most = count;
        sum += count;
        s->first[i] = sum; /* the end, which the next loop moves down to the start */
    }
    for (uint32_t i = corners; i-- > 0;) s->corners[--s->first[indices[i]]] = i;
    return most;
}

static uint32_t find(spoke *spokes, uint32_t i)
{
    while (spokes[i].parent != i) i = spokes[i].parent = spokes[spokes[i].parent].parent;
    return i;
}

/* Joins two spokes that share an edge, if it is flat there. The smaller becomes the root, whatever the order. */
static void join(smoother *s, uint32_t i, uint32_t j)
{
    uint32_t a = s->spokes[i].corner / 3, b = s->spokes[j].corner / 3;
    if (s->groups && (s->groups[a] != s->groups[b] || s->groups[a] == 0)) return;
    if (!(daft_dot(s->faces[a].normal, s->faces[b].normal) > s->cosine)) return;
    i = find(s->spokes, i), j = find(s->spokes, j);
    if (i < j)
        s->spokes[j].parent = i;
    else
        s->spokes[i].parent = j;
}

/* Each spoke with the next one at each of its two edges: at an edge of more than two triangles, in the file's order. */
static void join_small(smoother *s, uint32_t count)
{
    const spoke *spokes = s->spokes;
    for (uint32_t i = 0; i < count; i++)
        for (int side = 0; side < 2; side++) {
            uint32_t vertex = side ? spokes[i].previous : spokes[i].next, j = i + 1;
            while (j < count && spokes[j].next != vertex && spokes[j].previous != vertex) j++;
            if (j < count) join(s, i, j);
        }
}

static bool is_before(edge a, edge b)
{
    return a.vertex < b.vertex || (a.vertex == b.vertex && a.spoke < b.spoke);
}

static void sift_down(edge *heap, uint32_t at, uint32_t count)
{
    for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && is_before(heap[child], heap[child + 1])) child++;
        if (!is_before(heap[at], heap[child])) return;
        edge swapped = heap[at];
        heap[at] = heap[child], heap[child] = swapped;
    }
}

/* The same pairs as join_small finds, by sorting. */
static void join_large(smoother *s, uint32_t count)
{
    edge *edges = s->edges;
    for (uint32_t i = 0; i < count; i++) {
        edges[2 * i] = (edge){s->spokes[i].next, i};
        edges[2 * i + 1] = (edge){s->spokes[i].previous, i};
    }
    for (uint32_t i = count; i-- > 0;) sift_down(edges, i, 2 * count);
    for (uint32_t left = 2 * count; left > 1;) {
        left--;
        edge swapped = edges[0];
        edges[0] = edges[left], edges[left] = swapped;
        sift_down(edges, 0, left);
    }
    for (uint32_t i = 1; i < 2 * count; i++)
        if (edges[i - 1].vertex == edges[i].vertex) join(s, edges[i - 1].spoke, edges[i].spoke);
}

static void gather_spokes(smoother *s, uint32_t vertex, uint32_t count)
{
    const uint32_t *indices = s->mesh->indices;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t corner = s->corners[s->first[vertex] + i], base = corner - corner % 3;
        uint32_t next = corner == base + 2 ? base : corner + 1, previous = corner == base ? base + 2 : corner - 1;
        s->spokes[i] = (spoke){corner, indices[next], indices[previous], i, 0};
    }
}

/* ---- the common case: a closed fan of few triangles, smooth all around ---- */

static void gather_ring(const smoother *s, uint32_t vertex, uint32_t count, ring *r)
{
    for (uint32_t i = 0; i < RING / 4; i++) r->next[i] = r->previous[i] = (lanes){~0u, ~0u, ~0u, ~0u};
    const uint32_t *corners = s->corners + s->first[vertex];
    for (uint32_t i = 0; i < count; i++) {
        uint32_t corner = corners[i], triangle = corner / 3, k = corner - 3 * triangle;
        uint32_t soon = corners[i + AHEAD] / 3; /* the file's order is often far from the vertices' */
        __builtin_prefetch(&s->faces[soon]);
        __builtin_prefetch(&s->mesh->indices[3 * (size_t)soon]);
        const uint32_t *v = s->mesh->indices + 3 * (size_t)triangle;
        r->next[i / 4][i % 4] = v[k == 2 ? 0 : k + 1];
        r->previous[i / 4][i % 4] = v[k == 0 ? 2 : k - 1];
        r->normals[i] = s->faces[triangle].normal;
        r->angles[i] = s->faces[triangle].angles[k];
        r->groups[i] = s->groups ? s->groups[triangle] : 1;
    }
}

/* A bit for each lane that holds `vertex`. */
static inline unsigned lanes_with(const lanes values[RING / 4], uint32_t vertex)
{
    lanes wanted = {vertex, vertex, vertex, vertex};
    lanes bits = ((lanes)(values[0] == wanted) & (lanes){1, 2, 4, 8}) |
                 ((lanes)(values[1] == wanted) & (lanes){16, 32, 64, 128});
    return bits[0] | bits[1] | bits[2] | bits[3];
}

/* Goes around from triangle to triangle. True if that passes all of them, comes back, and crosses at most one crease:
 * then join would make one set of them. */
static bool is_smooth_ring(const smoother *s, const ring *r, uint32_t count)
{
    unsigned creases = 0;
    uint32_t at = 0, passed = 0;
    do {
        unsigned match = lanes_with(r->next, r->previous[at / 4][at % 4]);
        if (match == 0 || (match & (match - 1)) || ++passed > count) return false;
        uint32_t to = (uint32_t)__builtin_ctz(match);
        bool flat =
            daft_dot(r->normals[at], r->normals[to]) > s->cosine && r->groups[at] == r->groups[to] && r->groups[at];
        creases += !flat;
        at = to;
    } while (at != 0);
    return passed == count && creases <= 1;
}

static bool append_normal(smoother *s, daft_dvec3 sum)
{
    daft_trimesh *mesh = s->mesh;
    if (!daft_grow(s->allocator, &mesh->normals, &s->normal_room, (size_t)mesh->normal_count + 1, mesh->normal_count,
                   sizeof *mesh->normals))
        return false;
    daft_dvec3 unit = daft_unit(sum);
    mesh->normals[mesh->normal_count++] = daft_ddot(unit, unit) > 0.5 ? daft_to_float(unit) : daft_v3(0, 1, 0);
    return true;
}

static bool put_ring_normal(smoother *s, uint32_t vertex, uint32_t count, const ring *r)
{
    daft_dvec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < count; i++)
        sum = daft_dadd(sum, daft_dscale(daft_to_double(r->normals[i]), (double)r->angles[i]));
    s->single[vertex] = s->mesh->normal_count;
    return append_normal(s, sum);
}

/* ---- the general case ---- */

/* Gives every set a normal. A set whose faces have no area takes some unit vector. */
static bool put_normals(smoother *s, uint32_t vertex, uint32_t count)
{
    daft_trimesh *mesh = s->mesh;
    uint32_t sets = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t root = find(s->spokes, i); /* never larger than i */
        if (root == i) s->spokes[i].set = sets, s->sums[sets++] = (daft_dvec3){0, 0, 0};
        uint32_t corner = s->spokes[i].corner, set = s->spokes[i].set = s->spokes[root].set;
        const face *f = &s->faces[corner / 3];
        s->sums[set] = daft_dadd(s->sums[set], daft_dscale(daft_to_double(f->normal), (double)f->angles[corner % 3]));
        mesh->normal_indices[corner] = mesh->normal_count + set;
    }
    s->single[vertex] = sets == 1 ? mesh->normal_count : SEVERAL;
    for (uint32_t i = 0; i < sets; i++)
        if (!append_normal(s, s->sums[i])) return false;
    return true;
}

static bool prepare(smoother *s)
{
    daft_trimesh *mesh = s->mesh;
    size_t corners = 3 * (size_t)mesh->triangle_count;
    s->faces = daft_alloc(s->allocator, mesh->triangle_count, sizeof *s->faces);
    s->first = daft_alloc(s->allocator, (size_t)mesh->vertex_count + 1, sizeof *s->first);
    s->corners = daft_alloc(s->allocator, corners + AHEAD, sizeof *s->corners);
    s->single = daft_alloc(s->allocator, mesh->vertex_count, sizeof *s->single);
    mesh->normal_indices = daft_alloc(s->allocator, corners, sizeof *mesh->normal_indices);
    if (!s->faces || !s->first || !s->corners || !s->single || !mesh->normal_indices) return false;
    memset(s->corners + corners, 0, AHEAD * sizeof *s->corners);
    for (uint32_t i = 0; i < mesh->triangle_count; i++) s->faces[i] = face_of(mesh, i);
    uint32_t most = list_corners(s);
    s->spokes = daft_alloc(s->allocator, most, sizeof *s->spokes);
    s->sums = daft_alloc(s->allocator, most, sizeof *s->sums);
    s->edges = daft_alloc(s->allocator, most > SMALL_FAN ? 2 * (size_t)most : 1, sizeof *s->edges);
    return s->spokes && s->sums && s->edges &&
           daft_grow(s->allocator, &mesh->normals, &s->normal_room,
                     (size_t)mesh->vertex_count + mesh->vertex_count / 8 + 1, 0, sizeof *mesh->normals);
}

static bool smooth_vertex(smoother *s, uint32_t vertex)
{
    uint32_t count = s->first[vertex + 1] - s->first[vertex];
    if (count > 0 && count <= RING) {
        ring r;
        gather_ring(s, vertex, count, &r);
        if (is_smooth_ring(s, &r, count)) return put_ring_normal(s, vertex, count, &r);
    }
    gather_spokes(s, vertex, count);
    if (count <= SMALL_FAN)
        join_small(s, count);
    else
        join_large(s, count);
    return put_normals(s, vertex, count);
}

static bool smooth_vertices(smoother *s)
{
    bool same = true; /* so far every vertex has one normal, with the vertex's own number */
    for (uint32_t vertex = 0; vertex < s->mesh->vertex_count; vertex++) {
        if (!smooth_vertex(s, vertex)) return false;
        same = same && s->single[vertex] == vertex;
    }
    uint32_t *out = s->mesh->normal_indices;
    if (same) {
        daft_release(s->allocator, out);
        s->mesh->normal_indices = NULL;
        return true;
    }
    for (size_t i = 0; i < 3 * (size_t)s->mesh->triangle_count; i++) {
        uint32_t normal = s->single[s->mesh->indices[i]];
        if (normal != SEVERAL) out[i] = normal;
    }
    return true;
}

bool daft_trimesh_smooth_groups(const daft_allocator *allocator, daft_trimesh *mesh, float crease,
                                const uint32_t *groups, daft_error *error)
{
    daft_release(allocator, mesh->normals);
    daft_release(allocator, mesh->normal_indices);
    mesh->normals = NULL;
    mesh->normal_indices = NULL;
    mesh->normal_count = 0;
    float cosine = crease > 0 ? (float)daft_cos(fmin((double)crease, DAFT_PI)) : 2;
    smoother s = {.allocator = allocator, .mesh = mesh, .groups = groups, .cosine = cosine};
    bool done = prepare(&s) && smooth_vertices(&s);
    daft_release(allocator, s.faces);
    daft_release(allocator, s.first);
    daft_release(allocator, s.corners);
    daft_release(allocator, s.single);
    daft_release(allocator, s.spokes);
    daft_release(allocator, s.sums);
    daft_release(allocator, s.edges);
    return done || daft_fail_memory(error, "a mesh's normals");
}

bool daft_trimesh_smooth(const daft_allocator *allocator, daft_trimesh *mesh, float crease, daft_error *error)
{
    return daft_trimesh_smooth_groups(allocator, mesh, crease, NULL, error);
}
