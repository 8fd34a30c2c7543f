/* Quickhull (Barber, Dobkin and Huhdanpaa 1996), made robust by integers: the points are laid on a grid of 2^30 steps
 * in each axis, which is finer than their floats, and which side of a face a point is on is decided there without
 * error. So the surface is closed and convex at every moment whatever the input, and no repair of topology is needed
 * (Gregorius, "Implementing Quickhull", GDC 2014, tells what it takes otherwise). Hulls are the same under scaling of
 * an axis, so each has its own scale.
 *
 * Always the point that sticks out farthest of all is added next: stopping at any number of vertices leaves a good
 * hull. */
#include "sim/shape/hull_build.h"

#define NOTHING UINT32_MAX
/* Rounding of coordinates, as a fraction of the largest: points nearer to a face's plane than this are on it. */
#define ROUNDING 4e-7

enum { MAX_FACES = DAFT_HULL_MAX_FACES + 4 };

typedef struct face {
    uint32_t vertex[3];
    uint16_t adjacent[3];
    bool used, visible;
    int64_t exact[3];  /* the normal on the grid; below 2^61 */
    daft_dvec3 normal; /* unit, metres */
    uint32_t outside;  /* the first of the points in front of it */
    uint32_t farthest;
    double distance; /* of the farthest */
} face;

typedef struct horizon_edge {
    uint32_t from, to;
    uint16_t beyond, side; /* the face that stays, and which edge of it */
} horizon_edge;

typedef struct builder {
    const daft_vec3 *points;
    int32_t (*grid)[3];
    uint32_t *next; /* points in front of the same face */
    uint32_t count;
    double tolerance;
    face faces[MAX_FACES];
    horizon_edge horizon[3 * MAX_FACES];
    uint32_t horizon_count;
    uint16_t stack[3 * MAX_FACES];
} builder;

static daft_dvec3 at(const builder *b, uint32_t point) { return daft_to_double(b->points[point]); }

/* > 0: in front of the face. Exact. */
static int side(const builder *b, const face *f, uint32_t point)
{
    const int32_t *p = b->grid[point], *o = b->grid[f->vertex[0]];
    __int128 sum = 0;
    for (int k = 0; k < 3; k++) sum += (__int128)f->exact[k] * ((int64_t)p[k] - o[k]);
    return (sum > 0) - (sum < 0);
}

static double height(const builder *b, const face *f, uint32_t point)
{
    return daft_ddot(f->normal, daft_dsub(at(b, point), at(b, f->vertex[0])));
}

static void make_face(builder *b, face *f, uint32_t v0, uint32_t v1, uint32_t v2)
{
    const int32_t *o = b->grid[v0], *p = b->grid[v1], *q = b->grid[v2];
    int64_t u[3], v[3];
    for (int k = 0; k < 3; k++) u[k] = (int64_t)p[k] - o[k], v[k] = (int64_t)q[k] - o[k];
    *f = (face){.vertex = {v0, v1, v2}, .used = true, .outside = NOTHING, .farthest = NOTHING};
    f->exact[0] = u[1] * v[2] - u[2] * v[1];
    f->exact[1] = u[2] * v[0] - u[0] * v[2];
    f->exact[2] = u[0] * v[1] - u[1] * v[0];
    daft_dvec3 n = daft_dcross(daft_dsub(at(b, v1), at(b, v0)), daft_dsub(at(b, v2), at(b, v0)));
    double length = sqrt(daft_ddot(n, n));
    f->normal = length > 0 ? daft_dscale(n, 1 / length) : n;
}

/* Gives the point to the face, of those listed, that it sticks out of farthest; to none if it is within them all. */
static void give_point(builder *b, uint32_t point, const uint16_t *list, uint32_t count)
{
    face *best = NULL;
    double most = b->tolerance;
    for (uint32_t i = 0; i < count; i++) {
        double d = height(b, &b->faces[list[i]], point);
        if (d > most) most = d, best = &b->faces[list[i]];
    }
    if (!best) return;
    b->next[point] = best->outside;
    best->outside = point;
    if (best->farthest == NOTHING || most > best->distance) best->farthest = point, best->distance = most;
}

/* ---- the grid and the first tetrahedron ---- */

static bool lay_grid(builder *b, daft_error *error)
{
    daft_vec3 low = daft_v3(INFINITY, INFINITY, INFINITY), high = daft_neg(low);
    for (uint32_t i = 0; i < b->count; i++) {
        if (!daft_finite3(b->points[i]))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "point %u of a convex hull is not finite", i);
        low = daft_min3(low, b->points[i]), high = daft_max3(high, b->points[i]);
    }
    const float l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z};
    double largest = 0;
    for (int k = 0; k < 3; k++) {
        largest = fmax(largest, fmax(fabs((double)l[k]), fabs((double)h[k])));
        double half = ((double)h[k] - (double)l[k]) / 2, middle = ((double)h[k] + (double)l[k]) / 2;
        double scale = half > 0 ? 0x1p29 / half : 0;
        for (uint32_t i = 0; i < b->count; i++)
            b->grid[i][k] = (int32_t)floor(((double)daft_v3_at(b->points[i], k) - middle) * scale + 0.5);
    }
    if (largest > (double)DAFT_SHAPE_MAX_SIZE)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a convex hull reaches %g m; the most is %g", largest,
                         (double)DAFT_SHAPE_MAX_SIZE);
    b->tolerance = ROUNDING * largest;
    return true;
}

/* The two points that are farthest apart along an axis. */
static void widest(const builder *b, uint32_t *first, uint32_t *second)
{
    double most = -1;
    for (int k = 0; k < 3; k++) {
        uint32_t least = 0, greatest = 0;
        for (uint32_t i = 1; i < b->count; i++) {
            if (daft_v3_at(b->points[i], k) < daft_v3_at(b->points[least], k)) least = i;
            if (daft_v3_at(b->points[i], k) > daft_v3_at(b->points[greatest], k)) greatest = i;
        }
        double extent = (double)daft_v3_at(b->points[greatest], k) - (double)daft_v3_at(b->points[least], k);
        if (extent > most) most = extent, *first = least, *second = greatest;
    }
}

/* The point farthest from the line through u and v, or where w is given, from the plane. Gives the distance. */
static double farthest_from(const builder *b, uint32_t u, uint32_t v, uint32_t w, uint32_t *out)
{
    daft_dvec3 origin = at(b, u), along = daft_dsub(at(b, v), origin);
    if (w != NOTHING) along = daft_dcross(along, daft_dsub(at(b, w), origin));
    double length = sqrt(daft_ddot(along, along)), most = -1;
    along = daft_dscale(along, length > 0 ? 1 / length : 0);
    for (uint32_t i = 0; i < b->count; i++) {
        daft_dvec3 d = daft_dsub(at(b, i), origin), c = daft_dcross(along, d);
        double distance = w != NOTHING ? fabs(daft_ddot(along, d)) : sqrt(daft_ddot(c, c));
        if (distance > most) most = distance, *out = i;
    }
    return most;
}

static bool start(builder *b, daft_error *error)
{
    uint32_t v[4] = {0, 0, 0, 0};
    widest(b, &v[0], &v[1]);
    daft_dvec3 d = daft_dsub(at(b, v[1]), at(b, v[0]));
    const char *what = NULL;
    if (sqrt(daft_ddot(d, d)) <= b->tolerance)
        what = "in one spot";
    else if (farthest_from(b, v[0], v[1], NOTHING, &v[2]) <= b->tolerance)
        what = "on one line";
    else if (farthest_from(b, v[0], v[1], v[2], &v[3]) <= b->tolerance)
        what = "in one plane";
    make_face(b, &b->faces[0], v[0], v[1], v[2]);
    int above = what ? 0 : side(b, &b->faces[0], v[3]);
    if (above == 0)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "the %u points of a convex hull are all %s", b->count,
                         what ? what : "in one plane");
    if (above > 0) {
        uint32_t swapped = v[1];
        v[1] = v[2], v[2] = swapped;
    }
    static const uint8_t corners[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    static const uint8_t adjacent[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    static const uint16_t all[4] = {0, 1, 2, 3};
    for (int i = 0; i < 4; i++) {
        make_face(b, &b->faces[i], v[corners[i][0]], v[corners[i][1]], v[corners[i][2]]);
        for (int k = 0; k < 3; k++) b->faces[i].adjacent[k] = adjacent[i][k];
    }
    for (uint32_t i = 0; i < b->count; i++) give_point(b, i, all, 4);
    return true;
}

/* ---- adding a point ---- */

/* Marks the faces that the point sees, from one of them on; collects the edges where they end. */
static void find_horizon(builder *b, uint32_t point, uint16_t first)
{
    uint32_t depth = 0;
    b->horizon_count = 0;
    b->stack[depth++] = first;
    b->faces[first].visible = true;
    while (depth > 0) {
        const face *f = &b->faces[b->stack[--depth]];
        for (int k = 0; k < 3; k++) {
            face *other = &b->faces[f->adjacent[k]];
            if (other->visible) continue;
            if (side(b, other, point) > 0) {
                other->visible = true;
                b->stack[depth++] = f->adjacent[k];
                continue;
            }
            uint32_t from = f->vertex[k], to = f->vertex[(k + 1) % 3];
            uint16_t s = 0;
            while (s < 2 && other->vertex[s] != to) s++;
            b->horizon[b->horizon_count++] = (horizon_edge){from, to, f->adjacent[k], s};
        }
    }
}

/* Puts the horizon's edges in order around. False if they are not one ring, which exact sides rule out. */
static bool order_horizon(builder *b)
{
    horizon_edge *h = b->horizon;
    for (uint32_t i = 0; i + 1 < b->horizon_count; i++) {
        uint32_t j = i + 1;
        while (j < b->horizon_count && h[j].from != h[i].to) j++;
        if (j == b->horizon_count) return false;
        horizon_edge swapped = h[i + 1];
        h[i + 1] = h[j], h[j] = swapped;
    }
    return b->horizon_count >= 3 && h[b->horizon_count - 1].to == h[0].from;
}

/* Frees the visible faces; gives the list of points that were in front of them. */
static uint32_t remove_visible(builder *b)
{
    uint32_t loose = NOTHING;
    for (uint32_t i = 0; i < MAX_FACES; i++) {
        face *f = &b->faces[i];
        if (!f->used || !f->visible) continue;
        f->used = f->visible = false;
        while (f->outside != NOTHING) {
            uint32_t point = f->outside;
            f->outside = b->next[point];
            b->next[point] = loose;
            loose = point;
        }
    }
    return loose;
}

static void add_point(builder *b, uint32_t point, uint16_t seen_from)
{
    uint16_t list[MAX_FACES];
    face *f = &b->faces[seen_from];
    bool ring = side(b, f, point) > 0;
    if (ring) {
        find_horizon(b, point, seen_from);
        ring = order_horizon(b);
    }
    if (!ring) { /* rounding of the metric made it stick out: leave the face's points be */
        for (uint32_t i = 0; i < MAX_FACES; i++) b->faces[i].visible = false;
        f->outside = f->farthest = NOTHING;
        return;
    }
    uint32_t loose = remove_visible(b), count = b->horizon_count;
    for (uint32_t i = 0, slot = 0; i < count; i++, slot++) {
        while (b->faces[slot].used) slot++;
        list[i] = (uint16_t)slot;
        make_face(b, &b->faces[slot], b->horizon[i].from, b->horizon[i].to, point);
    }
    for (uint32_t i = 0; i < count; i++) {
        const horizon_edge *e = &b->horizon[i];
        face *made = &b->faces[list[i]];
        made->adjacent[0] = e->beyond;
        made->adjacent[1] = list[(i + 1) % count];
        made->adjacent[2] = list[(i + count - 1) % count];
        b->faces[e->beyond].adjacent[e->side] = list[i];
    }
    while (loose != NOTHING) {
        uint32_t p = loose;
        loose = b->next[p];
        if (p != point) give_point(b, p, list, count);
    }
}

/* The face out of which a point sticks farthest of all; MAX_FACES when there is none. */
static uint16_t next_face(const builder *b)
{
    uint16_t best = MAX_FACES;
    for (uint32_t i = 0; i < MAX_FACES; i++) {
        const face *f = &b->faces[i];
        if (!f->used || f->farthest == NOTHING) continue;
        if (best == MAX_FACES || f->distance > b->faces[best].distance) best = (uint16_t)i;
    }
    return best;
}

static void collect(const builder *b, daft_hull_mesh *out)
{
    uint16_t number[MAX_FACES];
    uint16_t count = 0;
    for (int i = 0; i < MAX_FACES; i++)
        if (b->faces[i].used) number[i] = count++;
    out->count = 0;
    for (int i = 0; i < MAX_FACES; i++) {
        const face *f = &b->faces[i];
        if (!f->used) continue;
        daft_hull_triangle *t = &out->triangles[out->count++];
        for (int k = 0; k < 3; k++) t->vertex[k] = f->vertex[k], t->adjacent[k] = number[f->adjacent[k]];
    }
    uint16_t left = next_face(b);
    out->deviation = left < MAX_FACES ? b->faces[left].distance : 0;
    out->tolerance = b->tolerance;
}

/* Euler: a triangulated surface of V vertices has 2·V - 4 faces. */
static uint32_t vertex_count(const builder *b)
{
    uint32_t faces = 0;
    for (int i = 0; i < MAX_FACES; i++) faces += b->faces[i].used;
    return faces / 2 + 2;
}

bool daft_hull_build(const daft_allocator *allocator, const daft_vec3 *points, uint32_t count, uint32_t max_vertices,
                     daft_hull_mesh *out, daft_error *error)
{
    if (count < 4) return daft_fail(error, DAFT_ERROR_ARGUMENT, "a convex hull needs four points, not %u", count);
    builder *b = daft_alloc_zero(allocator, 1, sizeof *b);
    int32_t(*grid)[3] = daft_alloc(allocator, count, sizeof *grid);
    uint32_t *next = daft_alloc(allocator, count, sizeof *next);
    bool done = b && grid && next;
    if (!done) daft_fail_memory(error, "a convex hull");
    if (done) {
        b->points = points, b->count = count, b->grid = grid, b->next = next;
        done = lay_grid(b, error) && start(b, error);
    }
    if (done) {
        /* An insertion may bury corners but adds one at most. Corners only come from points, each tried once. */
        for (uint16_t f; (f = next_face(b)) < MAX_FACES && vertex_count(b) < max_vertices;)
            add_point(b, b->faces[f].farthest, f);
        collect(b, out);
    }
    daft_release(allocator, next);
    daft_release(allocator, grid);
    daft_release(allocator, b);
    return done;
}
