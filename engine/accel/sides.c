/* Which triangles of a mesh are one-sided (sides.h), step by step:
 * - the mesh must be closed: every edge is run along as often one way as the other (geometry/adjacency.c);
 * - triangles at edges of more than two, and those that others come near (contact.c), keep both sides: corners are rounded
 *   when they are moved, and what is near might then be crossed;
 * - of the rest, whose sides have one winding number over each piece that hangs together, those are one-sided that have
 *   another number than 0 behind them (winding.c). */
#include "accel/sides.h"
#include "accel/find_sides.h"

/* Of the mesh's size: how far corners may be moved before a triangle is met from another side than was found. */
#define PAD 0x1p-18

void daft_sides_drop(daft_bvh *bvh)
{
    daft_sides *sides = bvh->sides;
    if (!sides) return;
    daft_release(&bvh->allocator, sides->blocks);
    daft_release(&bvh->allocator, sides->triangles);
    daft_release(&bvh->allocator, sides->cones);
    daft_patches_free(&bvh->allocator, &sides->patches);
    daft_release(&bvh->allocator, sides);
    bvh->sides = NULL;
}

static size_t words(const daft_sides *sides)
{
    return (sides->triangle_count + 31) / 32;
}

size_t daft_sides_bytes(const daft_bvh *bvh)
{
    const daft_sides *sides = bvh->sides;
    if (!sides) return 0;
    return sizeof *sides + bvh->block_count + words(sides) * sizeof *sides->triangles + bvh->nodes.count * sizeof *sides->cones +
           daft_patches_bytes(&sides->patches);
}

/* False: no triangle can be one-sided. */
static bool mark_edges(daft_side_search *s)
{
    if (!s->adjacency.closed) return false;
    for (size_t i = 0; i < 3 * (size_t)s->mesh->triangle_count; i++)
        if (s->adjacency.across[i] >= DAFT_ACROSS_MANY) s->marks[i / 3] = DAFT_SIDES_DOUBLE;
    return true;
}

double daft_sides_pad(const daft_trimesh *mesh)
{
    double size = 0;
    for (int k = 0; k < 3; k++) {
        double low = (double)(&mesh->low.x)[k], high = (double)(&mesh->high.x)[k];
        size = fmax(fmax(size, high - low), fmax(fabs(low), fabs(high)));
    }
    return size * PAD;
}

static bool search(const daft_bvh *bvh, const daft_trimesh *mesh, daft_sides *out, int threads)
{
    daft_side_search s = {.allocator = &bvh->allocator, .mesh = mesh, .bvh = bvh, .pad = daft_sides_pad(mesh)};
    s.marks = daft_alloc_zero(s.allocator, mesh->triangle_count, sizeof *s.marks);
    bool done = s.marks && daft_adjacency_make(s.allocator, mesh, &s.adjacency) && mark_edges(&s);
    if (done) {
        daft_sides_mark_contacts(&s, threads);
        done = daft_sides_wind(&s, out->triangles) && daft_patches_make(bvh, mesh, &s.adjacency, out->triangles, &out->patches);
    }
    daft_adjacency_free(s.allocator, &s.adjacency);
    daft_release(s.allocator, s.marks);
    return done;
}

static void fill_blocks(const daft_bvh *bvh, daft_sides *sides)
{
    for (size_t b = 0; b < bvh->block_count; b++) {
        uint32_t bit = 0, bits = 0;
        for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
            uint32_t triangle = bvh->blocks[b].triangle[i];
            if (triangle != DAFT_NO_TRIANGLE) bit = daft_is_one_sided(sides, triangle);
            bits |= bit << i;
        }
        sides->blocks[b] = (uint8_t)bits;
    }
    for (size_t i = 0; i < words(sides); i++) sides->count += (uint32_t)__builtin_popcount(sides->triangles[i]);
}

bool daft_bvh_find_sides(daft_bvh *bvh, const daft_trimesh *mesh, int threads)
{
    const daft_allocator *a = &bvh->allocator;
    if (bvh->sides) return true;
    if (bvh->nodes.count == 0) return false;
    daft_sides *sides = bvh->sides = daft_alloc_zero(a, 1, sizeof *sides);
    if (!sides) return false;
    sides->triangle_count = mesh->triangle_count;
    sides->middle = daft_dscale(daft_dadd(daft_to_double(mesh->low), daft_to_double(mesh->high)), 0.5);
    daft_dvec3 half = daft_dscale(daft_dsub(daft_to_double(mesh->high), daft_to_double(mesh->low)), 0.5);
    sides->radius = (float)(sqrt(daft_ddot(half, half)) * (1 + 0x1p-20));
    sides->triangles = daft_alloc_zero(a, words(sides), sizeof *sides->triangles);
    sides->blocks = daft_alloc(a, bvh->block_count, sizeof *sides->blocks);
    sides->cones = daft_alloc(a, bvh->nodes.count, sizeof *sides->cones);
    bool done = sides->triangles && sides->blocks && sides->cones && search(bvh, mesh, sides, threads);
    if (done) {
        fill_blocks(bvh, sides);
        done = sides->count > 0 && daft_cones_fill(bvh, sides);
    }
    if (!done) daft_sides_drop(bvh);
    return done;
}

/* ---- outlooks ---- */

static inline double larger(double a, double b) { return a > b ? a : b; } /* fmax is a call */

bool daft_outlook_at(const daft_bvh *bvh, const daft_trimesh *mesh, daft_dvec3 point, double blur, daft_outlook *out)
{
    daft_dvec3 from = daft_dsub(point, bvh->sides->middle);
    const double p[3] = {point.x, point.y, point.z};
    double square = 0;
    bool outside = false;
    for (int k = 0; k < 3; k++) {
        double low = (double)(&mesh->low.x)[k], high = (double)(&mesh->high.x)[k], pad = blur + fabs(p[k]) * 1e-9;
        double far = larger(fabs(p[k] - low), fabs(p[k] - high));
        outside = outside || p[k] < low - pad || p[k] > high + pad;
        square += far * far;
    }
    *out = (daft_outlook){(float)from.x, (float)from.y, (float)from.z, 1, (float)(sqrt(square) * (1 + 0x1p-20)), (float)blur};
    return outside && isfinite(out->reach);
}

daft_outlook daft_outlook_along(daft_dvec3 direction, double blur)
{
    double length = sqrt(daft_ddot(direction, direction)) * (1 + 0x1p-20);
    return (daft_outlook){(float)direction.x, (float)direction.y, (float)direction.z, 0, (float)length, (float)blur};
}

/* What daft_affine_point is off by on axis k, to first order: three products and two sums of what the mesh's farthest
 * corner makes of them, and a last sum with the translation; each 2^-24 of its result. */
static double moved_off_by(const daft_trimesh *mesh, const daft_affine *map, int k)
{
    double size = 0;
    for (int j = 0; j < 3; j++) {
        double low = fabs((double)(&mesh->low.x)[j]), high = fabs((double)(&mesh->high.x)[j]);
        size += fabs((double)map->m[3 * k + j]) * larger(low, high);
    }
    return (4.01 * size + 1.01 * fabs((double)map->t[k])) * 0x1p-24;
}

bool daft_outlook_from(const daft_bvh *bvh, const daft_trimesh *mesh, const daft_affine *map, daft_outlook *out, int *front)
{
    const daft_dvec3 row[3] = {daft_dv3((double)map->m[0], (double)map->m[1], (double)map->m[2]),
                               daft_dv3((double)map->m[3], (double)map->m[4], (double)map->m[5]),
                               daft_dv3((double)map->m[6], (double)map->m[7], (double)map->m[8])};
    const daft_dvec3 column[3] = {daft_dcross(row[1], row[2]), daft_dcross(row[2], row[0]), daft_dcross(row[0], row[1])};
    double det = daft_ddot(row[0], column[0]), size = sqrt(daft_ddot(row[0], row[0]) * daft_ddot(column[0], column[0]));
    *front = 0;
    if (!(fabs(det) > 1e-12 * size)) return false;
    daft_dvec3 point = {0, 0, 0}, off = {0, 0, 0}; /* columns over det are those of the inverse */
    for (int k = 0; k < 3; k++) {
        daft_dvec3 c = daft_dscale(column[k], 1 / det);
        double e = moved_off_by(mesh, map, k);
        point = daft_dsub(point, daft_dscale(c, (double)map->t[k]));
        off = daft_dadd(off, daft_dv3(fabs(c.x) * e, fabs(c.y) * e, fabs(c.z) * e));
    }
    if (!daft_outlook_at(bvh, mesh, point, sqrt(daft_ddot(off, off)) * (1 + 0x1p-20), out)) return false;
    *front = det < 0 ? 1 : -1;
    return true;
}
