/* Patches (patches.h). A patch grows from a triangle that no patch has yet, in the order of the tree's leaves, by the neighbour
 * that is near its middle, looks the same way and brings few corners. Patches are then put in order by halving them along what
 * parts them most, at multiples of sixteen, so that clusters and groups are near and full. */
#include "accel/patches.h"
#include "geometry/adjacency.h"

#include <float.h>
#include <stdlib.h>

enum { FEATURES = 6, FRINGE = 3 * DAFT_PATCH, BALL_STEPS = 16, SHAPE_STEPS = 16 };

/* How much a patch's normal counts in their order, in sizes of the mesh. Measured on crowds of cows: from 0 to 0.1 it is about the same,
 * and with 0.25 clusters are half as large again. */
#define NORMALS_WEIGHT 0.1

typedef struct patch_item {
    float key, at[FEATURES]; /* the middle, then the weighted normal; key: one of them */
    uint32_t number, first, count; /* of its triangles */
} patch_item;

typedef struct patch_job {
    const daft_trimesh *mesh;
    const daft_adjacency *adjacency;
    const daft_bvh *bvh;
    uint8_t *used;       /* of each triangle */
    uint32_t *triangles; /* by patches */
    patch_item *items;
    size_t capacity;
    uint32_t triangle_count, count;
} patch_job;

/* ---- growing ---- */

typedef struct face {
    daft_dvec3 middle, normal; /* a unit normal, or 0 */
} face;

static daft_dvec3 mesh_corner(const daft_trimesh *mesh, uint32_t triangle, uint32_t k)
{
    return daft_to_double(daft_v3(mesh->x[mesh->indices[3 * (size_t)triangle + k]], mesh->y[mesh->indices[3 * (size_t)triangle + k]],
                                  mesh->z[mesh->indices[3 * (size_t)triangle + k]]));
}

static face face_of(const daft_trimesh *mesh, uint32_t triangle)
{
    daft_dvec3 a = mesh_corner(mesh, triangle, 0), b = mesh_corner(mesh, triangle, 1), c = mesh_corner(mesh, triangle, 2);
    daft_dvec3 n = daft_dcross(daft_dsub(b, a), daft_dsub(c, a));
    double length = sqrt(daft_ddot(n, n)), inverse = length > 0 && length <= DBL_MAX ? 1 / length : 0;
    return (face){daft_dscale(daft_dadd(a, daft_dadd(b, c)), 1.0 / 3), daft_dscale(n, inverse)};
}

/* A patch that grows: its corners by place, and the triangles across its edges. */
typedef struct growth {
    uint32_t first, count, corner_count, corners[DAFT_PATCH], fringe_count, fringe[FRINGE];
    daft_dvec3 middle, normal; /* sums over its triangles */
} growth;

static uint32_t place_of(const patch_job *j, uint32_t triangle, uint32_t k)
{
    return j->adjacency->place[j->mesh->indices[3 * (size_t)triangle + k]];
}

static bool has_corner(const growth *g, uint32_t place)
{
    for (uint32_t i = 0; i < g->corner_count; i++)
        if (g->corners[i] == place) return true;
    return false;
}

static uint32_t new_corners(const patch_job *j, const growth *g, uint32_t triangle)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < 3; k++) count += !has_corner(g, place_of(j, triangle, k));
    return count;
}

static void add_triangle(patch_job *j, growth *g, uint32_t triangle)
{
    face f = face_of(j->mesh, triangle);
    g->middle = daft_dadd(g->middle, f.middle), g->normal = daft_dadd(g->normal, f.normal);
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t place = place_of(j, triangle, k), across = j->adjacency->across[3 * (size_t)triangle + k];
        if (!has_corner(g, place)) g->corners[g->corner_count++] = place;
        if (across < j->mesh->triangle_count && !j->used[across]) g->fringe[g->fringe_count++] = across;
    }
    j->used[triangle] = 1;
    j->triangles[g->first + g->count++] = triangle;
}

/* Triangles across its edges that no patch has. */
static uint32_t open_neighbours(const patch_job *j, uint32_t triangle)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t across = j->adjacency->across[3 * (size_t)triangle + k];
        count += across < j->mesh->triangle_count && !j->used[across];
    }
    return count;
}

/* Far from the middle, looking another way, with corners of its own, or with neighbours that would still have each other: any of these
 * makes it dear. The factors are measured on crowds of cows and count for little: half or twice of one is within 3 % of the triangles tested. */
static double cost_of(const patch_job *j, const growth *g, uint32_t triangle, uint32_t corners)
{
    face f = face_of(j->mesh, triangle);
    daft_dvec3 d = daft_dsub(f.middle, daft_dscale(g->middle, 1.0 / g->count));
    double length = sqrt(daft_ddot(g->normal, g->normal)), cosine = length > 0 ? daft_ddot(f.normal, g->normal) / length : 0;
    return daft_ddot(d, d) * (1.2 - cosine) * (1 + corners) * (1 + 2 * open_neighbours(j, triangle));
}

/* False: no neighbour has room. */
static bool grow(patch_job *j, growth *g)
{
    double least = INFINITY;
    uint32_t best = UINT32_MAX, count = 0;
    for (uint32_t i = 0; i < g->fringe_count; i++) {
        uint32_t triangle = g->fringe[i], corners;
        if (j->used[triangle]) continue;
        g->fringe[count++] = triangle;
        corners = new_corners(j, g, triangle);
        if (g->corner_count + corners > DAFT_PATCH) continue;
        double cost = cost_of(j, g, triangle, corners);
        if (best == UINT32_MAX || cost < least) least = cost, best = triangle;
    }
    g->fringe_count = count;
    if (best != UINT32_MAX) add_triangle(j, g, best);
    return best != UINT32_MAX;
}

/* Gives what to go on from: of its open neighbours, one that has the fewest itself, so that few are left alone. */
static uint32_t grow_from(patch_job *j, uint32_t seed)
{
    growth g = {.first = j->triangle_count};
    uint32_t next = UINT32_MAX, fewest = UINT32_MAX;
    add_triangle(j, &g, seed);
    while (g.count < DAFT_PATCH && grow(j, &g)) {}
    j->items[j->count] = (patch_item){.number = j->count, .first = g.first, .count = g.count};
    j->triangle_count += g.count, j->count++;
    for (uint32_t i = 0; i < g.fringe_count; i++) {
        uint32_t open = j->used[g.fringe[i]] ? UINT32_MAX : open_neighbours(j, g.fringe[i]);
        if (open < fewest) fewest = open, next = g.fringe[i];
    }
    return next;
}

/* False: memory is out. */
static bool grow_all(patch_job *j)
{
    for (size_t i = 0; i < j->bvh->block_count * DAFT_BLOCK; i++) {
        uint32_t next = j->bvh->blocks[i / DAFT_BLOCK].triangle[i % DAFT_BLOCK];
        if (next == DAFT_NO_TRIANGLE || j->used[next]) continue;
        while (next != UINT32_MAX) {
            if (!daft_grow(&j->bvh->allocator, &j->items, &j->capacity, (size_t)j->count + 1, j->count, sizeof *j->items)) return false;
            next = grow_from(j, next);
        }
    }
    return true;
}

/* ---- order ---- */

static int by_key(const void *a, const void *b)
{
    const patch_item *p = a, *q = b;
    if (p->key != q->key) return p->key < q->key ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

/* At whole groups while there is more than one, then at whole clusters. */
static void halve(patch_item *items, uint32_t count)
{
    int widest = 0;
    float most = -1;
    if (count <= DAFT_PATCH) return;
    for (int k = 0; k < FEATURES; k++) {
        float low = INFINITY, high = -INFINITY;
        for (uint32_t i = 0; i < count; i++) low = fminf(low, items[i].at[k]), high = fmaxf(high, items[i].at[k]);
        if (high - low > most) most = high - low, widest = k;
    }
    for (uint32_t i = 0; i < count; i++) items[i].key = items[i].at[widest];
    qsort(items, count, sizeof *items, by_key);
    uint32_t unit = count > DAFT_PATCH * DAFT_PATCH ? DAFT_PATCH * DAFT_PATCH : DAFT_PATCH;
    uint32_t half = (count + unit - 1) / unit / 2 * unit;
    halve(items, half);
    halve(items + half, count - half);
}

static void find_places(patch_job *j)
{
    daft_dvec3 extent = daft_dsub(daft_to_double(j->mesh->high), daft_to_double(j->mesh->low));
    double size = fmax(extent.x, fmax(extent.y, extent.z));
    for (uint32_t p = 0; p < j->count; p++) {
        patch_item *to = &j->items[p];
        daft_dvec3 middle = {0, 0, 0}, normal = {0, 0, 0};
        for (uint32_t i = 0; i < to->count; i++) {
            face f = face_of(j->mesh, j->triangles[to->first + i]);
            middle = daft_dadd(middle, f.middle), normal = daft_dadd(normal, f.normal);
        }
        middle = daft_dscale(middle, 1.0 / to->count), normal = daft_dscale(normal, NORMALS_WEIGHT * size / to->count);
        const double at[FEATURES] = {middle.x, middle.y, middle.z, normal.x, normal.y, normal.z};
        for (int k = 0; k < FEATURES; k++) to->at[k] = (float)at[k];
    }
}

/* ---- patches ---- */

/* The longest edge, rounded up. */
static float longest_edge(const daft_trimesh *mesh, uint32_t triangle)
{
    double square = 0;
    for (uint32_t k = 0; k < 3; k++) {
        daft_dvec3 d = daft_dsub(mesh_corner(mesh, triangle, k), mesh_corner(mesh, triangle, (k + 1) % 3));
        square = fmax(square, daft_ddot(d, d));
    }
    return (float)(sqrt(square) * (1 + 0x1p-23)) + FLT_MIN;
}

static void fill_patch(const patch_job *j, const patch_item *from, const uint32_t *one_sided, daft_patch *out)
{
    uint32_t places[DAFT_PATCH], count = 0;
    *out = (daft_patch){.there = (uint16_t)((1u << from->count) - 1)};
    for (uint32_t i = 0; i < DAFT_PATCH; i++) {
        out->triangle[i] = DAFT_NO_TRIANGLE;
        if (i >= from->count) continue;
        uint32_t triangle = out->triangle[i] = j->triangles[from->first + i];
        out->edge = fmaxf(out->edge, longest_edge(j->mesh, triangle));
        out->one_sided |= (uint16_t)((one_sided[triangle / 32] >> (triangle % 32) & 1) << i);
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t place = place_of(j, triangle, k), at = 0, vertex = j->mesh->indices[3 * (size_t)triangle + k];
            while (at < count && places[at] != place) at++;
            out->at[k][i] = (uint8_t)at;
            if (at < count) continue;
            places[count++] = place;
            out->corner[0][at] = j->mesh->x[vertex], out->corner[1][at] = j->mesh->y[vertex], out->corner[2][at] = j->mesh->z[vertex];
        }
    }
    for (int k = 0; k < 3; k++)
        for (uint32_t i = count; i < DAFT_PATCH; i++) out->corner[k][i] = out->corner[k][0];
}

/* ---- balls ---- */

static daft_dvec3 corner_at(const daft_patch *p, uint32_t i)
{
    return daft_dv3((double)p->corner[0][i], (double)p->corner[1][i], (double)p->corner[2][i]);
}

/* How far the farthest corner is. */
static double farthest(const daft_patch *patches, uint32_t count, daft_dvec3 from, daft_dvec3 *corner)
{
    double most = -1;
    *corner = from;
    for (uint32_t i = 0; i < count * DAFT_PATCH; i++) {
        daft_dvec3 at = corner_at(&patches[i / DAFT_PATCH], i % DAFT_PATCH), d = daft_dsub(at, from);
        double square = daft_ddot(d, d);
        if (square > most) most = square, *corner = at;
    }
    return sqrt(fmax(most, 0));
}

/* The mean of the corners, moved towards the farthest one, ever less (Badoiu and Clarkson, "Smaller Core-Sets for Balls", 2003). */
static daft_dvec3 middle_of(const daft_patch *patches, uint32_t count)
{
    daft_dvec3 middle = {0, 0, 0}, far, best;
    for (uint32_t i = 0; i < count * DAFT_PATCH; i++)
        middle = daft_dadd(middle, daft_dscale(corner_at(&patches[i / DAFT_PATCH], i % DAFT_PATCH), 1.0 / (DAFT_PATCH * (double)count)));
    double least = farthest(patches, count, middle, &far);
    best = middle;
    for (int step = 1; step <= BALL_STEPS; step++) {
        middle = daft_dadd(middle, daft_dscale(daft_dsub(far, middle), 1.0 / (step + 1)));
        double radius = farthest(patches, count, middle, &far);
        if (radius < least) least = radius, best = middle;
    }
    return best;
}

static float units(double length, double unit, double round)
{
    return (float)floor(fmin(fmax(length / unit + round, 0), UINT16_MAX));
}

/* Centres are at most 32768 units from the low corner on each axis, and radii at most the diagonal of that cube. */
static void ball_around(const daft_patches *p, uint32_t first, uint32_t count, daft_outlines *out, uint32_t lane)
{
    double unit = (double)p->unit;
    daft_dvec3 low = daft_to_double(p->low), middle = daft_dsub(middle_of(&p->items[first], count), low), far;
    daft_dvec3 centre = daft_dv3((double)units(middle.x, unit, 0.5), (double)units(middle.y, unit, 0.5), (double)units(middle.z, unit, 0.5));
    out->ball[0][lane] = (float)centre.x, out->ball[1][lane] = (float)centre.y, out->ball[2][lane] = (float)centre.z;
    out->ball[3][lane] = units(farthest(&p->items[first], count, daft_dadd(low, daft_dscale(centre, unit)), &far), unit, 1.01);
}

static uint32_t sixteens(uint32_t count) { return (count + DAFT_PATCH - 1) / DAFT_PATCH; }

static bool make_level(const daft_allocator *a, daft_patches *p, int level, uint32_t patches, uint32_t each)
{
    daft_outline_level *to = &p->level[level];
    to->count = (patches + each - 1) / each;
    to->items = daft_alloc_zero(a, sixteens(to->count), sizeof *to->items);
    if (!to->items) return false;
    for (uint32_t i = 0; i < to->count; i++)
        ball_around(p, i * each, daft_min_u(each, patches - i * each), &to->items[i / DAFT_PATCH], i % DAFT_PATCH);
    return true;
}

/* ---- ellipsoids ---- */

/* Of a symmetric matrix, xx, yy, zz, xy, xz, yz. */
static void invert(const double m[DAFT_SHAPE], double out[DAFT_SHAPE])
{
    double xx = m[1] * m[2] - m[5] * m[5], xy = m[4] * m[5] - m[3] * m[2], xz = m[3] * m[5] - m[1] * m[4];
    double inverse = 1 / (m[0] * xx + m[3] * xy + m[4] * xz);
    const double all[DAFT_SHAPE] = {xx, m[0] * m[2] - m[4] * m[4], m[0] * m[1] - m[3] * m[3], xy, xz, m[3] * m[4] - m[0] * m[5]};
    for (int k = 0; k < DAFT_SHAPE; k++) out[k] = all[k] * inverse;
}

static double form(const double m[DAFT_SHAPE], const double x[3])
{
    return m[0] * x[0] * x[0] + m[1] * x[1] * x[1] + m[2] * x[2] * x[2] + 2 * (m[3] * x[0] * x[1] + m[4] * x[0] * x[2] + m[5] * x[1] * x[2]);
}

/* The mean of squares, by weights; what is flat is taken for a hundredth as thick as it is wide. */
static void spread_of(double x[DAFT_PATCH][3], const double weight[DAFT_PATCH], double m[DAFT_SHAPE])
{
    for (int k = 0; k < DAFT_SHAPE; k++) m[k] = 0;
    for (int i = 0; i < DAFT_PATCH; i++)
        for (int k = 0; k < 3; k++) m[k] += weight[i] * x[i][k] * x[i][k], m[3 + k] += weight[i] * x[i][k == 2] * x[i][k ? 2 : 1];
    double thick = (m[0] + m[1] + m[2]) * 1e-4 + 1;
    for (int k = 0; k < 3; k++) m[k] += thick;
}

/* A small ellipsoid about the ball's middle: the weights of the corners move towards the one that is farthest out (Khachiyan, "Rounding
 * of Polytopes in the Real Number Model of Computation", 1996). Rounding to floats is off by 2^-24 of the largest term, 2^-10 of the least
 * it can be in any direction. */
static void make_shape(const daft_patches *p, uint32_t at)
{
    double x[DAFT_PATCH][3], weight[DAFT_PATCH], m[DAFT_SHAPE], inverse[DAFT_SHAPE], most;
    daft_dvec3 middle = daft_outline_middle(&p->level[0], at);
    for (uint32_t i = 0; i < DAFT_PATCH; i++) {
        daft_dvec3 d = daft_dsub(daft_dscale(daft_dsub(corner_at(&p->items[at], i), daft_to_double(p->low)), 1 / (double)p->unit), middle);
        x[i][0] = d.x, x[i][1] = d.y, x[i][2] = d.z, weight[i] = 1.0 / DAFT_PATCH;
    }
    for (int step = 0;; step++) {
        int far = 0;
        most = 0;
        spread_of(x, weight, m);
        invert(m, inverse);
        for (int i = 0; i < DAFT_PATCH; i++) {
            double f = form(inverse, x[i]);
            if (f > most) most = f, far = i;
        }
        if (step == SHAPE_STEPS || !(most > 3)) break;
        double share = (most / 3 - 1) / (most - 1);
        for (int i = 0; i < DAFT_PATCH; i++) weight[i] *= 1 - share;
        weight[far] += share;
    }
    daft_shapes *to = &p->shapes[at / DAFT_PATCH];
    for (int k = 0; k < DAFT_SHAPE; k++) to->m[k][at % DAFT_PATCH] = (float)(m[k] * most * (1 + 0x1p-9));
}

static bool make_shapes(const daft_allocator *a, daft_patches *p)
{
    uint32_t count = p->level[0].count;
    p->shapes = daft_alloc_zero(a, sixteens(count), sizeof *p->shapes);
    if (!p->shapes) return false;
    for (uint32_t i = 0; i < count; i++) make_shape(p, i);
    return true;
}

bool daft_patches_make(const daft_bvh *bvh, const daft_trimesh *mesh, const daft_adjacency *adjacency, const uint32_t *one_sided, daft_patches *out)
{
    const daft_allocator *a = &bvh->allocator;
    patch_job j = {.mesh = mesh, .adjacency = adjacency, .bvh = bvh};
    *out = (daft_patches){.low = mesh->low};
    daft_dvec3 size = daft_dsub(daft_to_double(mesh->high), daft_to_double(mesh->low));
    out->unit = fmaxf((float)(fmax(size.x, fmax(size.y, size.z)) / 32767), FLT_MIN); /* over a part in 32768, in spite of rounding */
    j.used = daft_alloc_zero(a, mesh->triangle_count, 1);
    j.triangles = daft_alloc(a, mesh->triangle_count, sizeof *j.triangles);
    bool done = j.used && j.triangles && grow_all(&j);
    if (done) {
        find_places(&j);
        halve(j.items, j.count);
        out->items = daft_alloc_zero(a, j.count, sizeof *out->items);
        done = out->items != NULL;
    }
    for (uint32_t i = 0; done && i < j.count; i++) {
        fill_patch(&j, &j.items[i], one_sided, &out->items[i]);
        out->edge = fmaxf(out->edge, out->items[i].edge);
    }
    for (uint32_t i = 0, each = 1; done && i < DAFT_PATCH_LEVELS; i++, each *= DAFT_PATCH) done = make_level(a, out, (int)i, j.count, each);
    done = done && make_shapes(a, out);
    for (uint32_t i = 0; done && i < j.count; i++) out->radius = fmaxf(out->radius, out->level[0].items[i / DAFT_PATCH].ball[3][i % DAFT_PATCH]);
    daft_release(a, j.used);
    daft_release(a, j.triangles);
    daft_release(a, j.items);
    if (!done) daft_patches_free(a, out);
    return done;
}

void daft_patches_free(const daft_allocator *allocator, daft_patches *p)
{
    daft_release(allocator, p->items);
    daft_release(allocator, p->shapes);
    for (int i = 0; i < DAFT_PATCH_LEVELS; i++) daft_release(allocator, p->level[i].items);
    *p = (daft_patches){0};
}

size_t daft_patches_bytes(const daft_patches *p)
{
    size_t bytes = p->level[0].count * sizeof *p->items + sixteens(p->level[0].count) * sizeof *p->shapes;
    for (int i = 0; i < DAFT_PATCH_LEVELS; i++) bytes += sixteens(p->level[i].count) * sizeof *p->level[i].items;
    return bytes;
}
