/* Caps over a mesh's holes (inner.h): the boxes of what hangs together of the edges that lack a counterpart. */
#include "accel/find_inner.h"
#include "geometry/adjacency.h"

#include <stdlib.h>

enum { MANY = 8 }; /* a mesh of which more than one edge in so many has no or more than one counterpart is not worth it */

typedef struct half_edge {
    uint32_t low, high; /* places */
    int32_t way;        /* 1: from low to high; -1: back */
} half_edge;

typedef struct border {
    const daft_trimesh *mesh;
    daft_adjacency adjacency;
    half_edge *edges;
    size_t count;
    uint32_t *root; /* of each place: another one it hangs together with, nearer to the one that stands for all; UINT32_MAX: none */
} border;

static int by_ends(const void *a, const void *b)
{
    const half_edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    return (x->high > y->high) - (x->high < y->high);
}

static uint32_t root_of(border *b, uint32_t place)
{
    while (b->root[place] != place) place = b->root[place] = b->root[b->root[place]];
    return place;
}

static void join(border *b, uint32_t low, uint32_t high)
{
    if (b->root[low] == UINT32_MAX) b->root[low] = low;
    if (b->root[high] == UINT32_MAX) b->root[high] = high;
    uint32_t x = root_of(b, low), y = root_of(b, high);
    b->root[daft_max_u(x, y)] = daft_min_u(x, y);
}

static size_t count_odd(const border *b)
{
    size_t odd = 0;
    for (size_t i = 0; i < 3 * (size_t)b->mesh->triangle_count; i++) odd += b->adjacency.across[i] == DAFT_ACROSS_MANY;
    return odd;
}

static void list_odd(border *b)
{
    const uint32_t *place = b->adjacency.place, *indices = b->mesh->indices;
    for (size_t i = 0; i < 3 * (size_t)b->mesh->triangle_count; i++) {
        if (b->adjacency.across[i] != DAFT_ACROSS_MANY) continue;
        uint32_t from = place[indices[i]], to = place[indices[i % 3 == 2 ? i - 2 : i + 1]];
        b->edges[b->count++] = (half_edge){daft_min_u(from, to), daft_max_u(from, to), from < to ? 1 : -1};
    }
    qsort(b->edges, b->count, sizeof *b->edges, by_ends);
}

/* Joins the ends of all edges that are not run along as often one way as the other. */
static void join_open(border *b)
{
    for (uint32_t i = 0; i < b->mesh->vertex_count; i++) b->root[i] = UINT32_MAX;
    for (size_t i = 0, end; i < b->count; i = end) {
        int64_t way = 0;
        for (end = i; end < b->count && by_ends(&b->edges[i], &b->edges[end]) == 0; end++) way += b->edges[end].way;
        if (way) join(b, b->edges[i].low, b->edges[i].high);
    }
}

/* False: there are more than `out` holds. */
static bool box_open(border *b, daft_inner *out)
{
    uint32_t root[DAFT_INNER_CAPS];
    for (uint32_t i = 0; i < b->mesh->vertex_count; i++) {
        if (b->root[i] == UINT32_MAX) continue;
        uint32_t at = 0, mine = root_of(b, i);
        while (at < out->cap_count && root[at] != mine) at++;
        if (at == DAFT_INNER_CAPS) return false;
        if (at == out->cap_count) root[out->cap_count++] = mine;
        const float p[3] = {b->mesh->x[i], b->mesh->y[i], b->mesh->z[i]};
        for (int k = 0; k < 3; k++)
            out->caps.bounds[k][at] = fminf(out->caps.bounds[k][at], p[k]), out->caps.bounds[3 + k][at] = fmaxf(out->caps.bounds[3 + k][at], p[k]);
    }
    return true;
}

bool daft_inner_close(daft_inner_search *s)
{
    border b = {.mesh = s->mesh};
    if (!daft_adjacency_make(s->allocator, s->mesh, &b.adjacency)) return false;
    bool done = b.adjacency.closed;
    size_t odd = done ? 0 : count_odd(&b);
    if (odd && odd <= 3 * (size_t)s->mesh->triangle_count / MANY) {
        b.edges = daft_alloc(s->allocator, odd, sizeof *b.edges);
        b.root = daft_alloc(s->allocator, s->mesh->vertex_count, sizeof *b.root);
        if (b.edges && b.root) {
            list_odd(&b);
            join_open(&b);
            done = box_open(&b, s->out);
        }
        daft_release(s->allocator, b.edges);
        daft_release(s->allocator, b.root);
    }
    daft_adjacency_free(s->allocator, &b.adjacency);
    return done;
}
