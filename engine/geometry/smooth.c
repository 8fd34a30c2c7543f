/* Smooth normals. Around each vertex, corners are joined across every edge that two triangles meet at flatter than the
 * crease; each set of joined corners gets the mean of its faces' normals, weighted by the angle of the face at the
 * corner (Thürmer and Wüthrich 1998), which does not depend on how a flat region is cut into triangles.
 *
 * One pass over the triangles adds up what decides most vertices of a scanned or tessellated surface: that all corners
 * are one set (is_one_ring). The corners of the others are listed by vertex with one counting sort, and then one vertex
 * after the other is worked on in small arrays: time is linear, but for a factor log k around a vertex of k > 16
 * corners. The order is that of the corners, so the bits depend on the mesh alone. */
#include "geometry/smooth.h"

#include "math/real.h"

#include <string.h>

/* Around a vertex of up to so many corners every pair is compared; above, neighbours are sorted. */
enum { SMALL_FAN = 16 };

#define SEVERAL UINT32_MAX

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
    float spread; /* see is_one_ring */
    daft_smooth_face *faces;
    daft_smooth_sum *sums_of; /* each vertex */
    uint8_t *listed;          /* 1: the vertex's corners are in `corners` */
    uint32_t *first;          /* of each vertex there; vertex_count + 1 */
    uint32_t *corners;
    uint32_t *single; /* the normal that all corners of a vertex share, or SEVERAL */
    spoke *spokes;    /* as many as the vertex with most corners has */
    daft_dvec3 *sums; /* of each set of them */
    edge *edges;      /* twice as many, for fans that are not small */
    size_t normal_room;
} smoother;

/* Whether all corners at a vertex are one set, by three things that adding up tells:
 *   - its triangles close to rings: each of the other vertices is as often next as it is previous. Hashes say so; they
 *     err once in 2^64, and then two fans share a normal.
 *   - no two faces meet at the crease or more: of k unit normals, two of which are an angle c apart, the sum is no longer
 *     than k - 2 + 2 cos(c / 2). `spread` is 2 - 2 cos(c / 2), less a bound on rounding.
 *   - there is but one ring: where all faces are within 40 degrees of a direction, each ring has angles of at least
 *     2 pi cos 40°, as seen along it, and the weighted sum is at least cos 40° of them: 7.37 for two rings. */
static bool is_one_ring(const smoother *s, const daft_smooth_sum *sum)
{
    float k = sum->count, least = k - s->spread + k * k * 2e-7f;
    const float *p = sum->plain;
    const double *w = sum->weighted;
    return sum->links == 0 && k < 256 && p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > least * least &&
           w[0] * w[0] + w[1] * w[1] + w[2] * w[2] < 7.3 * 7.3;
}

/* Decides which vertices are listed, with how many corners. Returns whether any are. */
static bool choose_listed(smoother *s)
{
    bool any = false, exact = true;
    for (uint32_t i = 0; i < s->mesh->vertex_count; i++) {
        bool listed = s->groups || !is_one_ring(s, &s->sums_of[i]);
        s->listed[i] = listed;
        s->first[i] = listed ? (uint32_t)s->sums_of[i].count : 0;
        exact &= s->sums_of[i].count < 0x1p24f;
        any |= listed;
    }
    if (exact) return any;
    memset(s->first, 0, s->mesh->vertex_count * sizeof *s->first);
    for (size_t i = 0; i < 3 * (size_t)s->mesh->triangle_count; i++)
        s->first[s->mesh->indices[i]] += s->listed[s->mesh->indices[i]];
    return any;
}

/* Turns counts in `first` into places and fills corners; returns the largest count. */
static uint32_t list_corners(smoother *s)
{
    const uint32_t *indices = s->mesh->indices;
    uint32_t corners = 3 * s->mesh->triangle_count, vertices = s->mesh->vertex_count, most = 0, sum = 0;
    for (uint32_t i = 0; i < vertices; i++) {
        if (s->first[i] > most) most = s->first[i];
        sum += s->first[i];
        s->first[i] = sum; /* the end, which the next loop moves down to the start */
    }
    s->first[vertices] = sum;
    for (uint32_t i = corners; i-- > 0;) { /* what is not listed is written behind all others */
        uint32_t vertex = indices[i], listed = s->listed[vertex], at = s->first[vertex] -= listed;
        s->corners[listed ? at : corners] = i;
    }
    memset(s->corners + sum, 0, AHEAD * sizeof *s->corners);
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
        const daft_smooth_face *f = &s->faces[corner / 3];
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
    static const daft_smooth_kernels *const kernels[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_smooth);
    daft_trimesh *mesh = s->mesh;
    size_t corners = 3 * (size_t)mesh->triangle_count;
    s->faces = daft_alloc(s->allocator, mesh->triangle_count, sizeof *s->faces);
    s->sums_of = daft_alloc_zero(s->allocator, mesh->vertex_count, sizeof *s->sums_of);
    s->listed = daft_alloc(s->allocator, mesh->vertex_count, 1);
    s->first = daft_alloc(s->allocator, (size_t)mesh->vertex_count + 1, sizeof *s->first);
    s->corners = daft_alloc(s->allocator, corners + AHEAD, sizeof *s->corners);
    s->single = daft_alloc(s->allocator, mesh->vertex_count, sizeof *s->single);
    mesh->normal_indices = daft_alloc(s->allocator, corners, sizeof *mesh->normal_indices);
    if (!s->faces || !s->sums_of || !s->listed || !s->first || !s->corners || !s->single || !mesh->normal_indices)
        return false;
    kernels[daft_isa_best()]->add_faces(mesh, s->faces, s->sums_of);
    uint32_t most = choose_listed(s) ? list_corners(s) : 0;
    s->spokes = daft_alloc(s->allocator, most, sizeof *s->spokes);
    s->sums = daft_alloc(s->allocator, most, sizeof *s->sums);
    s->edges = daft_alloc(s->allocator, most > SMALL_FAN ? 2 * (size_t)most : 1, sizeof *s->edges);
    return s->spokes && s->sums && s->edges &&
           daft_grow(s->allocator, &mesh->normals, &s->normal_room,
                     (size_t)mesh->vertex_count + mesh->vertex_count / 8 + 1, 0, sizeof *mesh->normals);
}

static bool smooth_vertex(smoother *s, uint32_t vertex)
{
    if (!s->listed[vertex]) {
        const double *sum = s->sums_of[vertex].weighted;
        s->single[vertex] = s->mesh->normal_count;
        return append_normal(s, daft_dv3(sum[0], sum[1], sum[2]));
    }
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
        out[i] = normal == SEVERAL ? out[i] : normal;
    }
    return true;
}

/* In one group, which is not 0: as if there were none. */
static bool all_alike(const uint32_t *groups, uint32_t count)
{
    if (!groups || count == 0 || groups[0] == 0) return false;
    for (uint32_t i = 1; i < count; i++)
        if (groups[i] != groups[0]) return false;
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
    double angle = fmin(fmax((double)crease, 0), 40 * (DAFT_PI / 180));
    smoother s = {.allocator = allocator,
                  .mesh = mesh,
                  .groups = all_alike(groups, mesh->triangle_count) ? NULL : groups,
                  .cosine = cosine,
                  .spread = (float)(2 - 2 * daft_cos(angle / 2) - 1e-5)};
    bool done = prepare(&s) && smooth_vertices(&s);
    daft_release(allocator, s.faces);
    daft_release(allocator, s.sums_of);
    daft_release(allocator, s.listed);
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
