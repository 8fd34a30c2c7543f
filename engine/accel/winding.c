/* The winding number behind the triangles that nothing comes near: it is the same over all of them that hang together by
 * edges, so one line through one triangle of each such piece tells. Crossings of the line are decided exactly, edges and
 * corners given to one triangle each, so they add up to what the mesh winds. */
#include "accel/find_sides.h"
#include "math/exact.h"

enum { TRIES = 4, WORK_A_TRIANGLE = 16 };

typedef struct winder {
    const daft_side_search *search;
    uint32_t *piece; /* of each triangle: the piece it was put in + 1; 0: none yet */
    uint32_t *stack;
    bool *solid;     /* of each piece: rays from outside do not come from behind it */
    uint32_t *seen;  /* of each triangle: the line that last met it */
    uint32_t line;   /* counts lines */
    uint64_t work;   /* tests of boxes and triangles left: where very many pieces use them up, the rest stay as they are */
} winder;

/* A line through a triangle, and what it crosses on either side of it. */
typedef struct crossings {
    daft_vec3 o, d;
    uint32_t triangle;
    double at;          /* where the line meets the triangle, in units of d from o */
    int front, behind; /* crossings in front of the triangle and behind it, each by its sign on the way from it */
    bool met, sure;     /* the line meets the triangle; no other crossing is near or edge-on */
} crossings;

static daft_dvec3 normal_of(const daft_trimesh *mesh, uint32_t triangle)
{
    daft_dvec3 a = daft_corner_of(mesh, triangle, 0);
    return daft_dcross(daft_dsub(daft_corner_of(mesh, triangle, 1), a), daft_dsub(daft_corner_of(mesh, triangle, 2), a));
}

static bool hits(const daft_trimesh *mesh, uint32_t triangle, daft_vec3 o, daft_vec3 d)
{
    daft_vec3 c[3];
    for (uint32_t k = 0; k < 3; k++) c[k] = daft_to_float(daft_corner_of(mesh, triangle, k));
    return daft_line_hits(o, c[0], c[1], c[2], d);
}

/* Where the line meets the triangle's plane. *slope: the cosine between the two, up to the normal's sign. */
static double plane_at(const daft_trimesh *mesh, uint32_t triangle, const crossings *c, double *slope)
{
    daft_dvec3 n = normal_of(mesh, triangle), d = daft_to_double(c->d);
    double along = daft_ddot(n, d);
    *slope = along / sqrt(daft_ddot(n, n));
    return daft_ddot(n, daft_dsub(daft_corner_of(mesh, triangle, 0), daft_to_double(c->o))) / along;
}

static void cross(const winder *w, crossings *c, uint32_t triangle)
{
    const daft_trimesh *mesh = w->search->mesh;
    if (!hits(mesh, triangle, c->o, c->d)) return;
    if (triangle == c->triangle) {
        c->met = true;
        return;
    }
    double slope, t = plane_at(mesh, triangle, c, &slope);
    int outwards = slope > 0 ? 1 : -1; /* of the mesh, along d */
    if (!(fabs(slope) > 1e-9) || !(fabs(t - c->at) > w->search->pad)) c->sure = false;
    if (t > c->at)
        c->front += outwards;
    else
        c->behind -= outwards;
}

/* Whether the line, both ways without end, meets the child's box, a little larger; the line as boxes see it. */
static bool line_meets(const daft_node *node, int child, const double o[3], const double d[3], double pad)
{
    double near = -INFINITY, far = INFINITY;
    for (int k = 0; k < 3; k++) {
        double low = (double)node->bounds[k][child] - pad - o[k], high = (double)node->bounds[k + 3][child] + pad - o[k];
        if (d[k] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low / d[k], b = high / d[k];
        near = fmax(near, fmin(a, b)), far = fmin(far, fmax(a, b));
    }
    return near <= far;
}

/* False: too much work. */
static bool cross_all(winder *w, crossings *c)
{
    const daft_bvh *bvh = w->search->bvh;
    daft_dvec3 o = daft_to_double(c->o), d = daft_to_double(c->d);
    const double from[3] = {o.x, o.y, o.z}, way[3] = {d.x, d.y, d.z};
    uint32_t stack[DAFT_STACK];
    int top = 0;
    stack[top++] = 0;
    w->line++;
    while (top > 0) {
        uint32_t child = stack[--top], count = child & DAFT_CHILD_LEAF ? ((child & 3) + 1) * DAFT_BLOCK : DAFT_WIDTH;
        if (w->work < count) return false;
        w->work -= count;
        if (child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t i = 0; i < count; i++) {
                uint32_t triangle = block[i / DAFT_BLOCK].triangle[i % DAFT_BLOCK];
                if (triangle == DAFT_NO_TRIANGLE || w->seen[triangle] == w->line) continue;
                w->seen[triangle] = w->line;
                cross(w, c, triangle);
            }
            continue;
        }
        const daft_node *node = &bvh->nodes.items[child];
        for (int i = 0; i < DAFT_WIDTH; i++)
            if (node->child[i] != DAFT_CHILD_NONE && line_meets(node, i, from, way, w->search->pad)) stack[top++] = node->child[i];
    }
    return true;
}

/* Whether the winding number behind the triangle is known and is not 0. A closed mesh winds one less in front. */
static bool is_solid_behind(winder *w, uint32_t triangle)
{
    static const daft_dvec3 tilts[TRIES] = {{0, 0, 0}, {0.31, 0.17, -0.23}, {-0.19, 0.29, 0.37}, {0.13, -0.41, 0.11}};
    const daft_trimesh *mesh = w->search->mesh;
    daft_dvec3 a = daft_corner_of(mesh, triangle, 0), b = daft_corner_of(mesh, triangle, 1), c = daft_corner_of(mesh, triangle, 2);
    daft_dvec3 n = normal_of(mesh, triangle), middle = daft_dscale(daft_dadd(daft_dadd(a, b), c), 1.0 / 3);
    double area = sqrt(daft_ddot(n, n)), beside = 0.7 * sqrt(area); /* a line that starts in a triangle's plane does not cross it */
    n = daft_dscale(n, 1 / area);
    for (int i = 0; i < TRIES; i++) {
        crossings line = {.triangle = triangle, .sure = true, .d = daft_to_float(daft_dadd(n, tilts[i]))};
        line.o = daft_to_float(daft_dadd(middle, daft_dscale(daft_to_double(line.d), beside)));
        double slope;
        line.at = plane_at(mesh, triangle, &line, &slope);
        if (!(slope > 0) || !cross_all(w, &line)) continue;
        if (line.met && line.sure && line.behind == line.front + 1) return line.behind != 0;
    }
    return false;
}

/* All triangles that hang together with this one; gives the largest. */
static uint32_t flood(winder *w, uint32_t first, uint32_t number)
{
    const daft_side_search *s = w->search;
    uint32_t top = 0, largest = first;
    double most = 0;
    w->stack[top++] = first;
    w->piece[first] = number;
    while (top > 0) {
        uint32_t triangle = w->stack[--top];
        daft_dvec3 n = normal_of(s->mesh, triangle);
        double size = daft_ddot(n, n);
        if (size > most) most = size, largest = triangle;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t next = s->adjacency.across[3 * (size_t)triangle + k];
            if (next >= DAFT_ACROSS_MANY || s->marks[next] || w->piece[next]) continue;
            w->piece[next] = number;
            w->stack[top++] = next;
        }
    }
    return largest;
}

static void wind_all(winder *w, uint32_t *one_sided)
{
    const daft_side_search *s = w->search;
    uint32_t count = s->mesh->triangle_count, pieces = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (s->marks[i] || w->piece[i]) continue;
        uint32_t largest = flood(w, i, ++pieces);
        w->solid[pieces - 1] = is_solid_behind(w, largest);
    }
    for (uint32_t i = 0; i < count; i++) {
        /* Two corners in one place: no ray ever hits it. */
        bool none = s->adjacency.across[3 * (size_t)i] == DAFT_ACROSS_NONE;
        if (none || (w->piece[i] && w->solid[w->piece[i] - 1])) one_sided[i / 32] |= 1u << (i % 32);
    }
}

bool daft_sides_wind(const daft_side_search *search, uint32_t *one_sided)
{
    const daft_allocator *a = search->allocator;
    size_t count = search->mesh->triangle_count;
    winder w = {.search = search, .work = WORK_A_TRIANGLE * (uint64_t)count + 4096};
    w.piece = daft_alloc_zero(a, count, sizeof *w.piece);
    w.stack = daft_alloc(a, count, sizeof *w.stack);
    w.seen = daft_alloc_zero(a, count, sizeof *w.seen);
    w.solid = daft_alloc(a, count, sizeof *w.solid);
    bool done = w.piece && w.stack && w.seen && w.solid;
    if (done) wind_all(&w, one_sided);
    daft_release(a, w.piece);
    daft_release(a, w.stack);
    daft_release(a, w.seen);
    daft_release(a, w.solid);
    return done;
}
