/* Smooth normals. Around each vertex, corners are joined across every edge that two triangles meet at flatter than the
 * crease; each set of joined corners gets the mean of its faces' normals, weighted by the angle of the face at the
 * corner (Thürmer and Wüthrich 1998), which does not depend on how a flat region is cut into triangles.
 *
 * One pass over the triangles adds up what decides most vertices of a scanned or tessellated surface: that all corners
 * are one set (is_one_ring). The corners of the others are listed by vertex with one counting sort, and then one vertex
 * after the other is worked on in small arrays: time is linear, but for a factor log k around a vertex of k > 16
 * corners. The order is that of the corners, so the bits depend on the mesh alone. */
#include "geometry/analysis/smooth.h"

#include "math/trig.h"

#include <string.h>

/* Around a vertex of up to so many corners every pair is compared; above, neighbours are sorted. */
enum { SMALL_FAN = 16 };

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
    const daft_smooth_kernels *kernels;
    daft_trimesh *mesh;
    const uint32_t *groups;
    float cosine;  /* of the crease; above 1 where nothing is joined */
    float spread;  /* see is_one_ring */
    char *scratch; /* for these */
    daft_smooth_faces faces;
    daft_smooth_sum *sums_of; /* each vertex */
    daft_smooth_lists lists;  /* of vertices that take more than adding up; filled where any_listed */
    bool any_listed;
    spoke *spokes;    /* as many as the vertex with most corners has */
    daft_dvec3 *sums; /* of each set of them */
    edge *edges;      /* twice as many, for fans that are not small */
    size_t normal_room;
} smoother;

/* Whether all corners at a vertex are one set, by three things that adding up tells:
 *   - its triangles close to rings: each of the other vertices is as often next as it is previous. Hashes say so; they
 *     err once in 2^64, and then two fans share a normal.
 *   - no two faces meet at the crease or more: of k unit normals, two of which are an angle c apart, the sum is no
 *     longer than k - 2 + 2 cos(c / 2). `spread` is 2 - 2 cos(c / 2), less a bound on rounding.
 *   - there is but one ring: where all faces are within 40 degrees of a direction, each ring has angles of at least
 *     2 pi cos 40°, as seen along it, and the weighted sum is at least cos 40° of them: 7.37 for two rings. */
static bool is_one_ring(const smoother *s, const daft_smooth_sum *sum)
{
    float k = sum->count, min = k - s->spread + k * k * 2e-7f;
    const float *p = sum->plain;
    const double *w = sum->weighted;
    return sum->links == 0 && k < 256 && p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > min * min &&
           w[0] * w[0] + w[1] * w[1] + w[2] * w[2] < 7.3 * 7.3;
}

/* Decides which vertices are listed, with how many corners. Returns whether any are. */
static bool choose_listed(smoother *s)
{
    bool any = false, exact = true;
    const daft_smooth_sum *sums = s->sums_of;
    uint8_t *restrict listed = s->lists.listed;
    uint32_t *restrict first = s->lists.first;
    for (uint32_t i = 0; i < s->mesh->vertex_count; i++) {
        bool is_listed = s->groups || !is_one_ring(s, &sums[i]);
        listed[i] = is_listed;
        first[i] = is_listed ? (uint32_t)sums[i].count : 0;
        exact &= sums[i].count < 0x1p24f;
        any |= is_listed;
    }
    if (exact) return any;
    memset(s->lists.first, 0, s->mesh->vertex_count * sizeof *s->lists.first);
    for (size_t i = 0; i < 3 * (size_t)s->mesh->triangle_count; i++)
        s->lists.first[s->mesh->indices[i]] += s->lists.listed[s->mesh->indices[i]];
    return any;
}

/* Turns counts in `first` into places and fills corners; returns the largest count. */
static uint32_t list_corners(smoother *s)
{
    const uint32_t *indices = s->mesh->indices;
    const uint8_t *listed = s->lists.listed;
    uint32_t *restrict first = s->lists.first, *restrict list = s->lists.corners;
    uint32_t corners = 3 * s->mesh->triangle_count, vertices = s->mesh->vertex_count, most = 0, sum = 0;
    for (uint32_t i = 0; i < vertices; i++) {
        if (first[i] > most) most = first[i];
        sum += first[i];
        first[i] = sum; /* the end, which the next loop moves down to the start */
    }
    first[vertices] = sum;
    for (uint32_t i = corners; i-- > 0;) { /* what is not listed is written behind all others */
        uint32_t vertex = indices[i], is_listed = listed[vertex], at = first[vertex] -= is_listed;
        list[is_listed ? at : corners] = i;
    }
    memset(list + sum, 0, DAFT_SMOOTH_AHEAD * sizeof *list);
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
    if (!(daft_dot(s->faces.normals[a], s->faces.normals[b]) > s->cosine)) return;
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

static bool is_before(edge a, edge b) { return a.vertex < b.vertex || (a.vertex == b.vertex && a.spoke < b.spoke); }

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
        uint32_t corner = s->lists.corners[s->lists.first[vertex] + i], base = corner - corner % 3;
        uint32_t next = corner == base + 2 ? base : corner + 1, previous = corner == base ? base + 2 : corner - 1;
        s->spokes[i] = (spoke){corner, indices[next], indices[previous], i, 0};
    }
}

static bool grow_normals(smoother *s, size_t more)
{
    daft_trimesh *mesh = s->mesh;
    return daft_grow(s->allocator, &mesh->normals, &s->normal_room, mesh->normal_count + more, mesh->normal_count,
                     sizeof *mesh->normals);
}

/* A set whose faces have no area takes some unit vector. */
static daft_vec3 direction_of(daft_dvec3 sum)
{
    daft_dvec3 unit = daft_unit(sum);
    return daft_ddot(unit, unit) > 0.5 ? daft_to_float(unit) : daft_v3(0, 1, 0);
}

/* Adds up the faces of each set of spokes; returns how many sets there are. */
static uint32_t add_sets(smoother *s, uint32_t count)
{
    uint32_t sets = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t root = find(s->spokes, i); /* never larger than i */
        if (root == i) s->spokes[i].set = sets, s->sums[sets++] = (daft_dvec3){0, 0, 0};
        uint32_t corner = s->spokes[i].corner, set = s->spokes[i].set = s->spokes[root].set;
        daft_dvec3 normal = daft_to_double(s->faces.normals[corner / 3]);
        s->sums[set] = daft_dadd(s->sums[set], daft_dscale(normal, (double)s->faces.angles[corner]));
    }
    return sets;
}

/* Corners have their vertices' normals until some vertex has more than one. */
static bool part_corners(smoother *s)
{
    daft_trimesh *mesh = s->mesh;
    size_t corners = 3 * (size_t)mesh->triangle_count;
    if (mesh->normal_indices) return true;
    mesh->normal_indices = daft_alloc(s->allocator, corners, sizeof *mesh->normal_indices);
    if (mesh->normal_indices) memcpy(mesh->normal_indices, mesh->indices, corners * sizeof *mesh->normal_indices);
    return mesh->normal_indices != NULL;
}

/* Gives every set a normal: the first has the vertex's own place, others follow behind those of all vertices. */
static bool put_normals(smoother *s, uint32_t vertex, uint32_t count)
{
    daft_trimesh *mesh = s->mesh;
    uint32_t sets = add_sets(s, count), others = mesh->normal_count;
    mesh->normals[vertex] = sets ? direction_of(s->sums[0]) : daft_v3(0, 1, 0);
    if (sets < 2) return true;
    if (!grow_normals(s, sets - 1) || !part_corners(s)) return false;
    for (uint32_t i = 1; i < sets; i++) mesh->normals[mesh->normal_count++] = direction_of(s->sums[i]);
    for (uint32_t i = 0; i < count; i++)
        if (s->spokes[i].set) mesh->normal_indices[s->spokes[i].corner] = others + s->spokes[i].set - 1;
    return true;
}

/* A part of the scratch memory, or, while there is none, its size onto *bytes. */
static void *part(const smoother *s, size_t *bytes, size_t count, size_t size)
{
    void *at = s->scratch ? s->scratch + *bytes : NULL;
    *bytes += (count * size + 63) / 64 * 64;
    return at;
}

/* All in one block: fewer pages are touched for the first time, and large ones at that. */
static size_t lay_out(smoother *s)
{
    size_t bytes = 0, vertices = s->mesh->vertex_count, triangles = s->mesh->triangle_count;
    s->sums_of = part(s, &bytes, vertices, sizeof *s->sums_of);
    s->lists.listed = part(s, &bytes, vertices, 1);
    s->lists.first = part(s, &bytes, vertices + 1, sizeof *s->lists.first);
    s->faces.normals = part(s, &bytes, triangles, sizeof *s->faces.normals);
    s->faces.angles = part(s, &bytes, 3 * triangles, sizeof *s->faces.angles);
    s->lists.corners = part(s, &bytes, 3 * triangles + DAFT_SMOOTH_AHEAD, sizeof *s->lists.corners);
    return bytes;
}

static bool prepare(smoother *s)
{
    daft_trimesh *mesh = s->mesh;
    s->scratch = daft_alloc(s->allocator, lay_out(s), 1);
    if (!s->scratch) return false;
    lay_out(s);
    memset(s->sums_of, 0, mesh->vertex_count * sizeof *s->sums_of);
    s->kernels->add_faces(mesh, s->faces, s->sums_of);
    s->any_listed = choose_listed(s);
    uint32_t most = s->any_listed ? list_corners(s) : 0;
    s->spokes = daft_alloc(s->allocator, most, sizeof *s->spokes);
    s->sums = daft_alloc(s->allocator, most, sizeof *s->sums);
    s->edges = daft_alloc(s->allocator, most > SMALL_FAN ? 2 * (size_t)most : 1, sizeof *s->edges);
    return s->spokes && s->sums && s->edges &&
           daft_grow(s->allocator, &mesh->normals, &s->normal_room,
                     (size_t)mesh->vertex_count + mesh->vertex_count / 8 + 1, 0, sizeof *mesh->normals);
}

static bool smooth_vertex(smoother *s, uint32_t vertex)
{
    uint32_t count = s->lists.first[vertex + 1] - s->lists.first[vertex];
    gather_spokes(s, vertex, count);
    if (count <= SMALL_FAN)
        join_small(s, count);
    else
        join_large(s, count);
    return put_normals(s, vertex, count);
}

static bool smooth_vertices(smoother *s)
{
    enum { TOGETHER = 64 }; /* vertices: what the first look at them fetched is still in the cache at the second */
    daft_trimesh *mesh = s->mesh;
    uint32_t end = mesh->vertex_count;
    s->kernels->normalize(s->sums_of, end, mesh->normals);
    mesh->normal_count = end;
    for (uint32_t first = 0, next; s->any_listed && first < end; first = next) {
        next = end - first < TOGETHER ? end : first + TOGETHER;
        s->kernels->unlist_rings(mesh, s->faces.normals, s->groups, s->cosine, &s->lists, first, next);
        for (uint32_t vertex = first; vertex < next; vertex++)
            if (s->lists.listed[vertex] && !smooth_vertex(s, vertex)) return false;
    }
    return true;
}

const daft_smooth_kernels *daft_smooth_kernels_for(int isa)
{
    static const daft_smooth_kernels *const table[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_smooth);
    return table[isa];
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
                  .kernels = daft_smooth_kernels_for(daft_isa_best()),
                  .mesh = mesh,
                  .groups = all_alike(groups, mesh->triangle_count) ? NULL : groups,
                  .cosine = cosine,
                  .spread = (float)(2 - 2 * daft_cos(angle / 2) - 1e-5)};
    bool done = prepare(&s) && smooth_vertices(&s);
    daft_release(allocator, s.scratch);
    daft_release(allocator, s.spokes);
    daft_release(allocator, s.sums);
    daft_release(allocator, s.edges);
    return done || daft_fail_memory(error, "a mesh's normals");
}

bool daft_trimesh_smooth(const daft_allocator *allocator, daft_trimesh *mesh, float crease, daft_error *error)
{
    return daft_trimesh_smooth_groups(allocator, mesh, crease, NULL, error);
}
