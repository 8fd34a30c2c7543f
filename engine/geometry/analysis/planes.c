/* The planes of a mesh: which of its triangles lie in one, a floor of many as well as a mirror of two.
 *
 * Triangles are taken by falling area. One joins the first plane whose seed it lies in, or is the seed of another.
 * Coordinates are floats: with u = 2^-24 and S the sum of the largest |x|, |y|, |z|, a corner lies up to u·S off the
 * plane that was meant, and more where the file's author moved it before. A seed of height h that is off by e at its
 * corners is off by e·(1 + 2·d/h) at the distance d, so what joins it may be that much farther off. Once all have
 * joined, the plane is laid through three far corners of the group, and triangles that are off this one by more than
 * 16·u·S leave: that much is what mirrored rays start off their surface (DAFT_SPAWN_ERROR), so no ray tells. */
#include "geometry/planes.h"
#include "geometry/trimesh.h"

#include <stdlib.h>
#include <string.h>

enum { SEEDS = 64 };
#define PLANE_ERROR  (16 * 0x1p-24)
#define NORMAL_ERROR 1e-4 /* radians between a shading normal and the plane's; mirrored, a pixel in 5,000 */
#define FAR_JOIN     128  /* heights of the seed */

typedef struct candidate {
    double area;
    uint32_t triangle;
} candidate;

typedef struct group {
    daft_dvec3 normal, seed; /* unit; a corner of the seed */
    double offset, height;   /* height: of the seed */
    double area;             /* twice that of its triangles */
    uint32_t first;          /* of its triangles */
    uint8_t number;          /* before the largest were chosen */
} group;

typedef struct finder {
    const daft_trimesh *mesh;
    double tolerance;
    candidate *candidates;
    uint32_t count, group_count;
    group groups[SEEDS];
    uint8_t *of; /* a triangle's group, or DAFT_NO_PLANE */
} finder;

static daft_dvec3 corner_at(const daft_trimesh *m, uint32_t triangle, int k)
{
    return daft_to_double(daft_trimesh_position(m, m->indices[3 * (size_t)triangle + (size_t)k]));
}

static double length_of(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

/* Twice the area, in the normal's direction. */
static daft_dvec3 area_vector(const daft_trimesh *m, uint32_t triangle)
{
    const daft_dvec3 a = corner_at(m, triangle, 0);
    return daft_dcross(daft_dsub(corner_at(m, triangle, 1), a), daft_dsub(corner_at(m, triangle, 2), a));
}

/* Whether the normals by which the triangle is shaded are this unit one, of either side. */
static bool normals_agree(const daft_trimesh *m, uint32_t triangle, daft_dvec3 normal)
{
    const uint32_t *at = &(m->normal_indices ? m->normal_indices : m->indices)[3 * (size_t)triangle];
    for (int k = 0; k < (m->normals ? 3 : 1); k++) {
        const daft_dvec3 n = m->normals ? daft_to_double(m->normals[at[k]]) : area_vector(m, triangle),
                         across = daft_dcross(n, normal);
        if (!(daft_ddot(across, across) <= NORMAL_ERROR * NORMAL_ERROR * daft_ddot(n, n))) return false;
    }
    return true;
}

static int by_area(const void *a, const void *b)
{
    const candidate *x = a, *y = b;
    if (x->area != y->area) return x->area > y->area ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

static void list_candidates(finder *f, const bool *wanted)
{
    const daft_trimesh *m = f->mesh;
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        if (!wanted[m->slots ? m->slots[t] : 0]) continue;
        const daft_dvec3 n = area_vector(m, t);
        const double area = length_of(n);
        if (area > 0 && normals_agree(m, t, daft_dscale(n, 1 / area))) f->candidates[f->count++] = (candidate){area, t};
    }
    if (f->count) qsort(f->candidates, f->count, sizeof *f->candidates, by_area);
}

static group group_of_seed(const finder *f, const candidate *c)
{
    const daft_trimesh *m = f->mesh;
    double longest = 0;
    group g = {
        .normal = daft_unit(area_vector(m, c->triangle)), .seed = corner_at(m, c->triangle, 0), .first = c->triangle};
    for (int k = 0; k < 3; k++)
        longest =
            fmax(longest, length_of(daft_dsub(corner_at(m, c->triangle, k), corner_at(m, c->triangle, (k + 1) % 3))));
    g.offset = daft_ddot(g.normal, g.seed), g.height = c->area / longest;
    return g;
}

static bool joins(const finder *f, const group *g, uint32_t triangle)
{
    for (int k = 0; k < 3; k++) {
        const daft_dvec3 c = corner_at(f->mesh, triangle, k);
        const double away = length_of(daft_dsub(c, g->seed)) / g->height;
        if (!(away < FAR_JOIN)) return false;
        if (!(fabs(daft_ddot(g->normal, c) - g->offset) <= f->tolerance * (1 + away / 8))) return false;
    }
    return true;
}

static void make_groups(finder *f)
{
    for (uint32_t i = 0; i < f->count; i++) {
        const uint32_t triangle = f->candidates[i].triangle;
        uint32_t g = 0;
        while (g < f->group_count && !joins(f, &f->groups[g], triangle)) g++;
        if (g == SEEDS) continue;
        if (g == f->group_count) f->groups[f->group_count++] = group_of_seed(f, &f->candidates[i]);
        f->groups[g].area += f->candidates[i].area, f->groups[g].first = daft_min_u(f->groups[g].first, triangle);
        f->of[triangle] = (uint8_t)g;
    }
}

static int by_first(const void *a, const void *b)
{
    const group *x = a, *y = b;
    return x->first < y->first ? -1 : x->first > y->first;
}

/* Leaves the groups of largest area, by their first triangles: whether planes share a mesh, their order is the same. */
static void keep_largest(finder *f)
{
    bool kept[SEEDS] = {false};
    uint8_t number[SEEDS];
    uint32_t count = 0;
    for (; count < daft_min_u(DAFT_MESH_PLANES, f->group_count); count++) {
        uint32_t best = SEEDS;
        for (uint32_t g = 0; g < f->group_count; g++)
            if (!kept[g] && (best == SEEDS || f->groups[g].area > f->groups[best].area)) best = g;
        kept[best] = true;
    }
    memset(number, DAFT_NO_PLANE, sizeof number);
    f->group_count = 0;
    for (uint32_t g = 0; f->group_count < count; g++)
        if (kept[g]) f->groups[f->group_count] = f->groups[g], f->groups[f->group_count++].number = (uint8_t)g;
    if (count) qsort(f->groups, count, sizeof *f->groups, by_first);
    for (uint32_t g = 0; g < count; g++) number[f->groups[g].number] = (uint8_t)g;
    for (uint32_t i = 0; i < f->count; i++) {
        uint8_t *of = &f->of[f->candidates[i].triangle];
        if (*of != DAFT_NO_PLANE) *of = number[*of];
    }
}

/* ---- the plane of each group ---- */

/* The corner of the group that is farthest from a point, or from a line through it in a unit direction. */
static daft_dvec3 farthest(const finder *f, uint32_t g, daft_dvec3 from, const daft_dvec3 *along)
{
    daft_dvec3 best = from;
    double most = 0;
    for (uint32_t i = 0; i < f->count; i++) {
        if (f->of[f->candidates[i].triangle] != g) continue;
        for (int k = 0; k < 3; k++) {
            const daft_dvec3 c = corner_at(f->mesh, f->candidates[i].triangle, k);
            const daft_dvec3 way = daft_dsub(c, from), across = along ? daft_dcross(*along, way) : way;
            const double distance = daft_ddot(across, across);
            if (distance > most) most = distance, best = c;
        }
    }
    return best;
}

static void lay_plane(finder *f, uint32_t number)
{
    group *g = &f->groups[number];
    const daft_dvec3 a = farthest(f, number, g->seed, NULL), b = farthest(f, number, a, NULL);
    const daft_dvec3 along = daft_unit(daft_dsub(b, a)), c = farthest(f, number, a, &along);
    const daft_dvec3 n = daft_dcross(along, daft_dsub(c, a));
    if (!(daft_ddot(n, n) > 0)) return;
    g->normal = daft_unit(n);
    g->offset = (daft_ddot(g->normal, a) + daft_ddot(g->normal, b) + daft_ddot(g->normal, c)) / 3;
}

static bool lies_in(const finder *f, const group *g, uint32_t triangle)
{
    for (int k = 0; k < 3; k++)
        if (!(fabs(daft_ddot(g->normal, corner_at(f->mesh, triangle, k)) - g->offset) <= f->tolerance)) return false;
    return normals_agree(f->mesh, triangle, g->normal);
}

/* Those that do not lie in their group's plane leave it; what is left has bounds. */
static void settle(finder *f, daft_mesh_planes *out)
{
    const daft_trimesh *m = f->mesh;
    const daft_vec3 inf = daft_v3(INFINITY, INFINITY, INFINITY);
    out->count = f->group_count;
    for (uint32_t g = 0; g < f->group_count; g++)
        out->planes[g] = (daft_mesh_plane){f->groups[g].normal, f->groups[g].offset, inf, daft_neg(inf)};
    for (uint32_t i = 0; i < f->count; i++) {
        const uint32_t t = f->candidates[i].triangle, g = f->of[t];
        if (g == DAFT_NO_PLANE) continue;
        if (!lies_in(f, &f->groups[g], t)) {
            f->of[t] = DAFT_NO_PLANE;
            continue;
        }
        daft_mesh_plane *plane = &out->planes[g];
        for (int k = 0; k < 3; k++) {
            const daft_vec3 c = daft_trimesh_position(m, m->indices[3 * (size_t)t + (size_t)k]);
            plane->low = daft_min3(plane->low, c), plane->high = daft_max3(plane->high, c);
        }
    }
}

bool daft_trimesh_planes(const daft_allocator *allocator, const daft_trimesh *mesh, const bool *wanted,
                         daft_mesh_planes *out)
{
    *out = (daft_mesh_planes){0};
    if (!mesh->triangle_count) return true;
    const daft_vec3 most = daft_max3(daft_neg(mesh->low), mesh->high);
    finder f = {.mesh = mesh, .tolerance = PLANE_ERROR * ((double)most.x + (double)most.y + (double)most.z)};
    f.candidates = daft_alloc(allocator, mesh->triangle_count, sizeof *f.candidates);
    f.of = daft_alloc(allocator, mesh->triangle_count, 1);
    const bool some = f.candidates && f.of;
    if (some) {
        memset(f.of, DAFT_NO_PLANE, mesh->triangle_count);
        list_candidates(&f, wanted), make_groups(&f);
        keep_largest(&f);
        for (uint32_t g = 0; g < f.group_count; g++) lay_plane(&f, g);
        settle(&f, out);
    }
    if (out->count)
        out->of = f.of;
    else
        daft_release(allocator, f.of);
    daft_release(allocator, f.candidates);
    return some;
}

void daft_mesh_planes_free(const daft_allocator *allocator, daft_mesh_planes *planes)
{
    daft_release(allocator, planes->of);
    *planes = (daft_mesh_planes){0};
}
