/* A triangle mesh as a shape: what lies across each edge, found once. Edges are matched by the positions of their ends:
 * vertices are numbered anew by sorting them, then edges are sorted by their two numbers. */
#include "accel/bvh.h"
#include "sim/shape/triangles.h"

#include <stdlib.h>
#include <string.h>

/* A triangle whose height is below this fraction of its longest side has no area to speak of. */
#define SLIVER 1e-6

typedef struct placed {
    float at[3];
    uint32_t vertex;
} placed;

typedef struct edge_key {
    uint32_t low, high; /* ends, welded */
    uint32_t half_edge; /* 3·triangle + k */
} edge_key;

static int compare_placed(const void *x, const void *y)
{
    const placed *a = x, *b = y;
    for (int k = 0; k < 3; k++)
        if (a->at[k] != b->at[k]) return a->at[k] < b->at[k] ? -1 : 1;
    return (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

static int compare_edges(const void *x, const void *y)
{
    const edge_key *a = x, *b = y;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return (a->half_edge > b->half_edge) - (a->half_edge < b->half_edge);
}

/* welded[v]: the same for all vertices in one place. */
static bool weld(const daft_allocator *allocator, const daft_trimesh *mesh, uint32_t *welded)
{
    placed *list = daft_alloc(allocator, mesh->vertex_count, sizeof *list);
    if (!list) return false;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) list[v] = (placed){{mesh->x[v], mesh->y[v], mesh->z[v]}, v};
    qsort(list, mesh->vertex_count, sizeof *list, compare_placed);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        bool same = i > 0;
        for (int k = 0; same && k < 3; k++) same = list[i].at[k] == list[i - 1].at[k];
        welded[list[i].vertex] = same ? welded[list[i - 1].vertex] : list[i].vertex;
    }
    daft_release(allocator, list);
    return true;
}

static void corners_of(const daft_trimesh *mesh, uint32_t triangle, daft_vec3 out[3])
{
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t v = mesh->indices[3 * (size_t)triangle + k];
        out[k] = daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]);
    }
}

static bool has_area(const daft_vec3 corners[3])
{
    daft_dvec3 a = daft_to_double(corners[0]), u = daft_dsub(daft_to_double(corners[1]), a);
    daft_dvec3 v = daft_dsub(daft_to_double(corners[2]), a), w = daft_dsub(v, u), n = daft_dcross(u, v);
    double longest = fmax(daft_ddot(u, u), fmax(daft_ddot(v, v), daft_ddot(w, w)));
    return sqrt(daft_ddot(n, n)) > SLIVER * longest;
}

static void match(daft_mesh_shape *s, const edge_key *keys, size_t count)
{
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && keys[end].low == keys[i].low && keys[end].high == keys[i].high; end++) {
        }
        if (end - i != 2) continue; /* a border, or several sheets that meet: judged where bodies touch */
        s->neighbours[keys[i].half_edge] = keys[i + 1].half_edge;
        s->neighbours[keys[i + 1].half_edge] = keys[i].half_edge;
    }
}

static bool connect(const daft_allocator *allocator, daft_mesh_shape *s)
{
    const daft_trimesh *mesh = s->mesh;
    size_t count = 0;
    uint32_t *welded = daft_alloc(allocator, mesh->vertex_count, sizeof *welded);
    edge_key *keys = daft_alloc(allocator, 3 * (size_t)mesh->triangle_count, sizeof *keys);
    bool done = welded && keys && weld(allocator, mesh, welded);
    for (uint32_t t = 0; done && t < mesh->triangle_count; t++) {
        daft_vec3 corners[3];
        corners_of(mesh, t, corners);
        s->no_area[t] = !has_area(corners);
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t p = welded[mesh->indices[3 * (size_t)t + k]];
            uint32_t q = welded[mesh->indices[3 * (size_t)t + (k + 1) % 3]], half_edge = 3 * t + k;
            s->neighbours[half_edge] = DAFT_NO_FEATURE;
            if (!s->no_area[t]) keys[count++] = (edge_key){p < q ? p : q, p < q ? q : p, half_edge};
        }
    }
    if (done) {
        qsort(keys, count, sizeof *keys, compare_edges);
        match(s, keys, count);
        s->closed = count > 0;
        for (size_t i = 0; i < count; i++) s->closed &= s->neighbours[keys[i].half_edge] != DAFT_NO_FEATURE;
    }
    daft_release(allocator, keys);
    daft_release(allocator, welded);
    return done;
}

daft_mesh_shape *daft_mesh_shape_create(const daft_allocator *allocator, const daft_trimesh *mesh,
                                        const struct daft_bvh *bvh, bool one_sided, daft_error *error)
{
    daft_mesh_shape *s = daft_alloc_zero(allocator, 1, sizeof *s);
    if (s) {
        s->allocator = *allocator;
        s->mesh = mesh, s->bvh = bvh, s->one_sided = one_sided;
        s->neighbours = daft_alloc(allocator, 3 * (size_t)mesh->triangle_count, sizeof *s->neighbours);
        s->no_area = daft_alloc(allocator, mesh->triangle_count, sizeof *s->no_area);
        if (s->neighbours && s->no_area && connect(allocator, s)) return s;
    }
    daft_mesh_shape_free(s);
    daft_fail_memory(error, "a mesh's adjacency");
    return NULL;
}

void daft_mesh_shape_free(daft_mesh_shape *shape)
{
    if (!shape) return;
    daft_allocator allocator = shape->allocator;
    daft_release(&allocator, shape->neighbours);
    daft_release(&allocator, shape->no_area);
    daft_release(&allocator, shape);
}
