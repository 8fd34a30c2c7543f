/* Smooth normals. Corners are joined across every edge that two triangles meet at flatter than the crease (union-find
 * over corners); each set of joined corners gets the mean of its faces' normals, weighted by the angle of the face at
 * the corner (Thürmer and Wüthrich 1998), which does not depend on how a flat region is cut into triangles.
 *
 * Time and memory are linear in the triangles: edges are brought together by two counting sorts. Everything runs in
 * the order of the corners, so the bits depend on the mesh alone. */
#include "geometry/trimesh.h"

#include "math/real.h"

typedef struct smoother {
    const daft_allocator *allocator;
    daft_trimesh *mesh;
    const uint32_t *groups;
    float cosine;         /* of the crease; above 1 where nothing is joined */
    daft_vec3 *faces;     /* unit normal of each triangle */
    uint32_t *parent;     /* union-find over corners */
    uint32_t *edges;      /* half-edges, sorted by their two vertices. Half-edge i goes from corner i to the next one */
    uint32_t *scratch;
    uint32_t *counts;     /* vertex_count + 1 */
} smoother;

static uint32_t next_corner(uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

static uint32_t low_vertex(const smoother *s, uint32_t edge)
{
    return daft_min_u(s->mesh->indices[edge], s->mesh->indices[next_corner(edge)]);
}

static uint32_t high_vertex(const smoother *s, uint32_t edge)
{
    uint32_t a = s->mesh->indices[edge], b = s->mesh->indices[next_corner(edge)];
    return a > b ? a : b;
}

/* One stable counting sort of half-edges by a vertex; `from` NULL: in their own order. */
static void sort_edges(smoother *s, const uint32_t *from, uint32_t *to, uint32_t (*key)(const smoother *, uint32_t))
{
    uint32_t edges = 3 * s->mesh->triangle_count, vertices = s->mesh->vertex_count;
    for (uint32_t i = 0; i <= vertices; i++) s->counts[i] = 0;
    for (uint32_t i = 0; i < edges; i++) s->counts[key(s, i) + 1]++;
    for (uint32_t i = 0; i < vertices; i++) s->counts[i + 1] += s->counts[i];
    for (uint32_t i = 0; i < edges; i++) {
        uint32_t edge = from ? from[i] : i;
        to[s->counts[key(s, edge)]++] = edge;
    }
}

static uint32_t find(uint32_t *parent, uint32_t corner)
{
    while (parent[corner] != corner) {
        parent[corner] = parent[parent[corner]];
        corner = parent[corner];
    }
    return corner;
}

/* The smaller corner becomes the root, whatever the order. */
static void join(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = find(parent, a), b = find(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static bool is_flat(const smoother *s, uint32_t a, uint32_t b)
{
    if (s->groups && (s->groups[a] != s->groups[b] || s->groups[a] == 0)) return false;
    return daft_dot(s->faces[a], s->faces[b]) > s->cosine;
}

/* Two half-edges along the same edge. */
static void join_edges(smoother *s, uint32_t e, uint32_t f)
{
    if (e / 3 == f / 3 || !is_flat(s, e / 3, f / 3)) return;
    uint32_t e2 = next_corner(e), f2 = next_corner(f);
    const uint32_t *v = s->mesh->indices;
    join(s->parent, e, v[e] == v[f] ? f : f2);
    join(s->parent, e2, v[e2] == v[f2] ? f2 : f);
}

/* More than two triangles at an edge: each with the next one in the order of the file. */
static void join_all(smoother *s)
{
    uint32_t edges = 3 * s->mesh->triangle_count;
    for (uint32_t i = 1; i < edges; i++) {
        uint32_t e = s->edges[i - 1], f = s->edges[i];
        if (low_vertex(s, e) == low_vertex(s, f) && high_vertex(s, e) == high_vertex(s, f)) join_edges(s, e, f);
    }
}

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

/* The three angles of a triangle; zero where an edge has no length. */
static void corner_angles(const daft_trimesh *mesh, uint32_t triangle, double angles[3])
{
    daft_dvec3 p[3], edge[3];
    for (int k = 0; k < 3; k++) p[k] = daft_to_double(daft_trimesh_position(mesh, mesh->indices[3 * (size_t)triangle + (size_t)k]));
    for (int k = 0; k < 3; k++) edge[k] = daft_unit(daft_dsub(p[(k + 1) % 3], p[k]));
    angles[0] = arc_cosine(-daft_ddot(edge[0], edge[2]));
    angles[1] = arc_cosine(-daft_ddot(edge[1], edge[0]));
    angles[2] = fmax(0, DAFT_PI - angles[0] - angles[1]);
}

/* Numbers the sets in the order of their first corners, into scratch[corner]. Returns how many there are. */
static uint32_t number_sets(smoother *s)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < 3 * s->mesh->triangle_count; i++) {
        uint32_t root = find(s->parent, i);
        s->scratch[i] = root == i ? count++ : s->scratch[root];
    }
    return count;
}

static void sum_normals(const smoother *s, daft_dvec3 *sums)
{
    double angles[3];
    for (uint32_t i = 0; i < s->mesh->triangle_count; i++) {
        daft_dvec3 face = daft_to_double(s->faces[i]);
        corner_angles(s->mesh, i, angles);
        for (uint32_t k = 0; k < 3; k++) {
            daft_dvec3 *sum = &sums[s->scratch[3 * i + k]];
            *sum = daft_dadd(*sum, daft_dscale(face, angles[k]));
        }
    }
}

/* Fills normals; a set whose faces have no area or cancel takes some unit vector. */
static bool make_normals(smoother *s, uint32_t count)
{
    daft_trimesh *mesh = s->mesh;
    daft_dvec3 *sums = daft_alloc_zero(s->allocator, count, sizeof *sums);
    mesh->normals = daft_alloc(s->allocator, count, sizeof *mesh->normals);
    if (sums && mesh->normals) {
        sum_normals(s, sums);
        for (uint32_t i = 0; i < count; i++) {
            daft_dvec3 unit = daft_unit(sums[i]);
            mesh->normals[i] = daft_ddot(unit, unit) > 0.5 ? daft_to_float(unit) : daft_v3(0, 1, 0);
        }
        mesh->normal_count = count;
        mesh->normal_indices = s->scratch;
        s->scratch = NULL;
    }
    daft_release(s->allocator, sums);
    return mesh->normal_indices != NULL;
}

static bool prepare(smoother *s)
{
    uint32_t triangles = s->mesh->triangle_count;
    size_t corners = 3 * (size_t)triangles;
    s->faces = daft_alloc(s->allocator, triangles, sizeof *s->faces);
    s->parent = daft_alloc(s->allocator, corners, sizeof *s->parent);
    s->edges = daft_alloc(s->allocator, corners, sizeof *s->edges);
    s->scratch = daft_alloc(s->allocator, corners, sizeof *s->scratch);
    s->counts = daft_alloc(s->allocator, (size_t)s->mesh->vertex_count + 1, sizeof *s->counts);
    if (!s->faces || !s->parent || !s->edges || !s->scratch || !s->counts) return false;
    for (uint32_t i = 0; i < triangles; i++) s->faces[i] = daft_trimesh_face_normal(s->mesh, i);
    for (size_t i = 0; i < corners; i++) s->parent[i] = (uint32_t)i;
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
    bool done = prepare(&s);
    if (done) {
        sort_edges(&s, NULL, s.scratch, high_vertex);
        sort_edges(&s, s.scratch, s.edges, low_vertex);
        join_all(&s);
        done = make_normals(&s, number_sets(&s));
    }
    daft_release(allocator, s.faces);
    daft_release(allocator, s.parent);
    daft_release(allocator, s.edges);
    daft_release(allocator, s.scratch);
    daft_release(allocator, s.counts);
    return done || daft_fail_memory(error, "a mesh's normals");
}

bool daft_trimesh_smooth(const daft_allocator *allocator, daft_trimesh *mesh, float crease, daft_error *error)
{
    return daft_trimesh_smooth_groups(allocator, mesh, crease, NULL, error);
}
