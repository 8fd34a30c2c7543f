/* What lies across each edge of a mesh, with vertices in one place taken as one.
 *
 * Half-edges are listed at the lower of their two places and sorted there by the other, so time is O(n log n) at worst,
 * about linear where no vertex has many triangles. */
#include "geometry/adjacency.h"

#include <stdlib.h>
#include <string.h>

/* ---- places ---- */

static bool same_place(const daft_trimesh *mesh, uint32_t a, uint32_t b)
{
    return mesh->x[a] == mesh->x[b] && mesh->y[a] == mesh->y[b] && mesh->z[a] == mesh->z[b];
}

static uint64_t place_hash(const daft_trimesh *mesh, uint32_t vertex)
{
    const float position[3] = {mesh->x[vertex] + 0.0f, mesh->y[vertex] + 0.0f, mesh->z[vertex] + 0.0f}; /* -0 is 0 */
    return daft_hash(position, sizeof position, 0);
}

/* Open addressing, at most half full. */
static bool find_places(const daft_allocator *allocator, const daft_trimesh *mesh, uint32_t *place)
{
    size_t size = 16;
    while (size < 2 * (size_t)mesh->vertex_count) size *= 2;
    uint32_t *first = daft_alloc_zero(allocator, size, sizeof *first); /* vertex + 1; 0: free */
    if (!first) return false;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        size_t at = place_hash(mesh, i) & (size - 1);
        while (first[at] && !same_place(mesh, first[at] - 1, i)) at = (at + 1) & (size - 1);
        if (!first[at]) first[at] = i + 1;
        place[i] = first[at] - 1;
    }
    daft_release(allocator, first);
    return true;
}

/* ---- edges ---- */

typedef struct matcher {
    const daft_trimesh *mesh;
    daft_adjacency *out;
    uint32_t *first; /* of each place: where its half-edges begin; one more than there are vertices */
    uint64_t *edges; /* higher place << 32 | corner that the half-edge starts from */
} matcher;

static void edge_ends(const matcher *m, uint32_t corner, uint32_t *from, uint32_t *to)
{
    *from = m->out->place[m->mesh->indices[corner]];
    *to = m->out->place[m->mesh->indices[corner % 3 == 2 ? corner - 2 : corner + 1]];
}

static bool is_point_or_line(const matcher *m, uint32_t triangle)
{
    const uint32_t *v = &m->mesh->indices[3 * (size_t)triangle], *place = m->out->place;
    return place[v[0]] == place[v[1]] || place[v[1]] == place[v[2]] || place[v[2]] == place[v[0]];
}

static void list_edges(matcher *m)
{
    uint32_t corners = 3 * m->mesh->triangle_count, places = m->mesh->vertex_count, from, to;
    for (uint32_t i = 0; i < corners; i++) {
        m->out->across[i] = DAFT_ACROSS_NONE;
        edge_ends(m, i, &from, &to);
        if (!is_point_or_line(m, i / 3)) m->first[daft_min_u(from, to) + 1]++;
    }
    for (uint32_t i = 0; i < places; i++) m->first[i + 1] += m->first[i];
    for (uint32_t i = corners; i-- > 0;) { /* first[] moves on to where the next place's begin, and back below */
        edge_ends(m, i, &from, &to);
        if (!is_point_or_line(m, i / 3)) m->edges[m->first[daft_min_u(from, to)]++] = (uint64_t)daft_max_u(from, to) << 32 | i;
    }
    for (uint32_t i = places; i > 0; i--) m->first[i] = m->first[i - 1];
    m->first[0] = 0;
}

static int by_value(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static void sort_few(uint64_t *list, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint64_t value = list[i];
        uint32_t at = i;
        for (; at > 0 && list[at - 1] > value; at--) list[at] = list[at - 1];
        list[at] = value;
    }
}

/* All half-edges of one edge. */
static void match(matcher *m, const uint64_t *edges, uint32_t count)
{
    uint32_t forward = 0, from, to;
    for (uint32_t i = 0; i < count; i++) {
        edge_ends(m, (uint32_t)edges[i], &from, &to);
        forward += from < to;
    }
    if (2 * forward != count) m->out->closed = false;
    for (uint32_t i = 0; i < count; i++)
        m->out->across[(uint32_t)edges[i]] = count == 2 && forward == 1 ? (uint32_t)edges[1 - i] / 3 : DAFT_ACROSS_MANY;
}

static void match_edges(matcher *m)
{
    enum { FEW = 24 };
    for (uint32_t place = 0; place < m->mesh->vertex_count; place++) {
        uint64_t *list = m->edges + m->first[place];
        uint32_t count = m->first[place + 1] - m->first[place];
        if (count > FEW)
            qsort(list, count, sizeof *list, by_value);
        else
            sort_few(list, count);
        for (uint32_t i = 0, end; i < count; i = end) {
            for (end = i + 1; end < count && list[end] >> 32 == list[i] >> 32;) end++;
            match(m, list + i, end - i);
        }
    }
}

bool daft_adjacency_make(const daft_allocator *allocator, const daft_trimesh *mesh, daft_adjacency *out)
{
    size_t corners = 3 * (size_t)mesh->triangle_count;
    *out = (daft_adjacency){.closed = mesh->triangle_count > 0};
    out->place = daft_alloc(allocator, mesh->vertex_count, sizeof *out->place);
    out->across = daft_alloc(allocator, corners, sizeof *out->across);
    matcher m = {.mesh = mesh, .out = out};
    m.first = daft_alloc_zero(allocator, (size_t)mesh->vertex_count + 1, sizeof *m.first);
    m.edges = daft_alloc(allocator, corners, sizeof *m.edges);
    bool done = out->place && out->across && m.first && m.edges && find_places(allocator, mesh, out->place);
    if (done) {
        list_edges(&m);
        match_edges(&m);
    }
    daft_release(allocator, m.first);
    daft_release(allocator, m.edges);
    if (!done) daft_adjacency_free(allocator, out);
    return done;
}

void daft_adjacency_free(const daft_allocator *allocator, daft_adjacency *adjacency)
{
    daft_release(allocator, adjacency->place);
    daft_release(allocator, adjacency->across);
    *adjacency = (daft_adjacency){0};
}
