/* The reference path: one ray at a time, scalar, double. It shares with the pencil what defines the answer (how
 * vertices are moved, the predicates, the depth) and nothing of how candidates are found: boxes here are only ever too
 * large. */
#include "accel/kdtree.h"
#include "math/exact.h"
#include "raster/holes.h"
#include "raster/raster.h"

typedef struct double_ray {
    double origin[3], inverse[3]; /* inverse of a zero component: 1e300, so that no 0·inf arises */
} double_ray;

typedef struct best {
    double z;
    uint32_t instance, triangle;
    const daft_hole_view *holes; /* NULL: they are not passed over */
    int column, row;             /* of the ray, in the tile */
} best;

static double_ray ray_setup(daft_dvec3 origin, daft_dvec3 direction)
{
    const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    double_ray ray;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = o[k];
        ray.inverse[k] = fabs(d[k]) > 1e-300 ? 1 / d[k] : 1e300;
    }
    return ray;
}

/* Whether the ray meets the child's box grown by pad, anywhere in front of the origin. */
static bool box_met(const daft_node *node, int child, const double_ray *ray, double pad)
{
    double near = 0, far = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = ((double)node->bounds[k][child] - pad - ray->origin[k]) * ray->inverse[k];
        double b = ((double)node->bounds[k + 3][child] + pad - ray->origin[k]) * ray->inverse[k];
        double low = a < b ? a : b, high = a < b ? b : a;
        low -= fabs(low) * 1e-12, high += fabs(high) * 1e-12;
        if (low > near) near = low;
        if (high < far) far = high;
    }
    return near <= far;
}

static void offer(best *nearest, double z, uint32_t instance, uint32_t triangle)
{
    bool wins = z < nearest->z ||
                (z == nearest->z &&
                 (instance < nearest->instance || (instance == nearest->instance && triangle < nearest->triangle)));
    if (wins) nearest->z = z, nearest->instance = instance, nearest->triangle = triangle;
}

static bool passes_hole(const daft_view_instance *view, uint32_t triangle, const best *nearest)
{
    daft_holes holes;
    return nearest->holes && view->instance->masks && daft_holes_make(nearest->holes, view, triangle, &holes) &&
           daft_in_hole(&holes, nearest->column, nearest->row);
}

static void test_triangle(const daft_view_instance *view, uint32_t triangle, daft_vec3 ray, best *nearest)
{
    daft_vec3 c[3];
    daft_view_corners(view, triangle, c);
    if (!daft_pencil_hits(c[0], c[1], c[2], ray) || passes_hole(view, triangle, nearest)) return;
    offer(nearest, daft_pencil_depth(c[0], c[1], c[2], ray), view->index, triangle);
}

/* The inverse of the map to camera space, in double, and how far a moved vertex may be from where the exact map would
 * put it, measured back in object space. */
static double invert(const daft_view_instance *view, double inverse[9])
{
    const float *m = view->to_view.m, *t = view->to_view.t;
    double a[9];
    for (int i = 0; i < 9; i++) a[i] = (double)m[i];
    double c0 = a[4] * a[8] - a[5] * a[7], c1 = a[5] * a[6] - a[3] * a[8], c2 = a[3] * a[7] - a[4] * a[6];
    double scale = 1 / (a[0] * c0 + a[1] * c1 + a[2] * c2);
    inverse[0] = c0 * scale, inverse[1] = (a[2] * a[7] - a[1] * a[8]) * scale,
    inverse[2] = (a[1] * a[5] - a[2] * a[4]) * scale;
    inverse[3] = c1 * scale, inverse[4] = (a[0] * a[8] - a[2] * a[6]) * scale,
    inverse[5] = (a[2] * a[3] - a[0] * a[5]) * scale;
    inverse[6] = c2 * scale, inverse[7] = (a[1] * a[6] - a[0] * a[7]) * scale,
    inverse[8] = (a[0] * a[4] - a[1] * a[3]) * scale;
    const daft_trimesh *mesh = view->mesh;
    double reach = 0, size = 0, stretch = 0;
    const float low[3] = {mesh->low.x, mesh->low.y, mesh->low.z}, high[3] = {mesh->high.x, mesh->high.y, mesh->high.z};
    for (int k = 0; k < 3; k++) {
        reach = fmax(reach, fmax(fabs((double)low[k]), fabs((double)high[k])));
        stretch = fmax(stretch, fabs(inverse[3 * k]) + fabs(inverse[3 * k + 1]) + fabs(inverse[3 * k + 2]));
    }
    for (int k = 0; k < 3; k++)
        size = fmax(size, (fabs(a[3 * k]) + fabs(a[3 * k + 1]) + fabs(a[3 * k + 2])) * reach + fabs((double)t[k]));
    return stretch * size * 0x1p-20; /* 4 roundings of 2^-24, with room to spare */
}

static daft_dvec3 apply(const double m[9], daft_dvec3 v)
{
    return daft_dv3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                    m[6] * v.x + m[7] * v.y + m[8] * v.z);
}

typedef struct cell_entry {
    uint32_t node;
    double near, far;
} cell_entry;

/* Every cell within pad of the ray. A plane that the ray runs along lies 1e300 away, or at hand where it is within pad.
 */
static void test_cells(const daft_view_instance *view, const double_ray *r, double pad, daft_vec3 ray, best *nearest)
{
    const daft_kdtree *tree = view->instance->kdtree;
    cell_entry stack[DAFT_KD_DEPTH + 4];
    int top = 0;
    stack[top++] = (cell_entry){0, 0, 1e280};
    while (top > 0) {
        cell_entry at = stack[--top];
        const daft_kd_node *node = &tree->nodes[at.node];
        uint32_t axis = node->code & 3, pair = node->code >> 2;
        if (axis == DAFT_KD_LEAF) {
            for (uint32_t i = 0; i < node->count; i++) test_triangle(view, tree->items[pair + i], ray, nearest);
            continue;
        }
        double plane = (double)node->split - r->origin[axis];
        double a = (plane - pad) * r->inverse[axis], b = (plane + pad) * r->inverse[axis];
        double from = a < b ? a : b, until = a < b ? b : a;
        from -= fabs(from) * 1e-12, until += fabs(until) * 1e-12;
        uint32_t first = pair + (r->inverse[axis] < 0), second = pair + (r->inverse[axis] > 0);
        if (at.far >= from) stack[top++] = (cell_entry){second, from > at.near ? from : at.near, at.far};
        if (at.near <= until) stack[top++] = (cell_entry){first, at.near, until < at.far ? until : at.far};
    }
}

static void test_mesh(const daft_view_instance *view, daft_vec3 ray, best *nearest)
{
    double inverse[9];
    double pad = invert(view, inverse);
    const float *t = view->to_view.t;
    daft_dvec3 origin = apply(inverse, daft_dv3(-(double)t[0], -(double)t[1], -(double)t[2]));
    double_ray r = ray_setup(origin, apply(inverse, daft_to_double(ray)));
    if (view->instance->kdtree) {
        test_cells(view, &r, pad, ray, nearest);
        return;
    }
    const daft_bvh *bvh = view->bvh;
    uint32_t stack[DAFT_STACK];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        uint32_t child = stack[--top];
        if (child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t i = 0; i < ((child & 3) + 1) * DAFT_BLOCK; i++) {
                uint32_t triangle = block[i / DAFT_BLOCK].triangle[i % DAFT_BLOCK];
                if (triangle != DAFT_NO_TRIANGLE) test_triangle(view, triangle, ray, nearest);
            }
            continue;
        }
        const daft_node *node = &bvh->nodes.items[child];
        for (int i = 0; i < DAFT_WIDTH; i++)
            if (node->child[i] != DAFT_CHILD_NONE && box_met(node, i, &r, pad)) stack[top++] = node->child[i];
    }
}

static void test_instance(const daft_raster *raster, uint32_t index, daft_vec3 ray, best *nearest)
{
    const daft_view_instance *view = &raster->visible[index];
    if (!view->instance) return;
    if (view->mesh) {
        test_mesh(view, ray, nearest);
        return;
    }
    const float *c = view->to_view.t;
    double t;
    if (daft_pencil_sphere(daft_v3(c[0], c[1], c[2]), view->instance->radius, ray, &t))
        offer(nearest, t * (double)ray.z, index, 0);
}

static double largest(const daft_node *node, int child)
{
    double max = 0;
    for (int k = 0; k < 6; k++) max = fmax(max, fabs((double)node->bounds[k][child]));
    return max;
}

static best trace(const daft_raster *raster, const daft_tlas *tlas, daft_vec3 ray, best nearest)
{
    if (tlas->nodes.count == 0) return nearest;
    const daft_pencil *p = &raster->pencil;
    daft_dvec3 direction = daft_dadd(daft_dscale(daft_to_double(p->right), (double)ray.x),
                                     daft_dadd(daft_dscale(daft_to_double(p->up), (double)ray.y),
                                               daft_dscale(daft_to_double(p->forward), (double)ray.z)));
    double_ray r = ray_setup(daft_dv3(0, 0, 0), direction);
    uint32_t stack[DAFT_STACK];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        uint32_t child = stack[--top];
        if (child & DAFT_CHILD_LEAF) {
            test_instance(raster, child & ~DAFT_CHILD_LEAF, ray, &nearest);
            continue;
        }
        const daft_node *node = &tlas->nodes.items[child];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            if (node->child[i] == DAFT_CHILD_NONE) continue;
            /* camera axes and maps are rounded to floats: a few parts in 2^24 of the distance */
            if (box_met(node, i, &r, largest(node, i) * 0x1p-19)) stack[top++] = node->child[i];
        }
    }
    return nearest;
}

static best nothing(const daft_raster *raster, const daft_hole_view *holes, int column, int row)
{
    return (best){.z = INFINITY,
                  .instance = DAFT_NOTHING,
                  .holes = raster->passes_holes ? holes : NULL,
                  .column = column,
                  .row = row};
}

void daft_reference_tile(const daft_raster *raster, const daft_tlas *tlas, uint32_t tile, const daft_tile_part *part,
                         daft_tile *out)
{
    const daft_pencil pencil = daft_part_pencil(&raster->pencil, part);
    daft_tile_place(raster, tile, out);
    const daft_hole_view holes = daft_hole_view_of(raster, &pencil, out->x, out->y, DAFT_TILE);
    for (int row = 0; row < out->height; row++) {
        for (int column = 0; column < out->width; column++) {
            best nearest = nothing(raster, &holes, column, row);
            if (!part || (part->asked[row] >> column & 1))
                nearest = trace(raster, tlas, daft_pencil_ray(&pencil, out->x + column, out->y + row), nearest);
            int at = row * DAFT_TILE_STRIDE + column;
            out->instance[at] = nearest.instance;
            out->triangle[at] = nearest.triangle;
        }
    }
}

void daft_reference_fine(const daft_raster *raster, const daft_tlas *tlas, uint32_t tile, daft_fine_tile *out)
{
    const daft_pencil pencil = daft_fine_pencil(&raster->pencil);
    const int left = (int)(tile % (uint32_t)raster->tiles_x) * DAFT_FINE_SIDE,
              top = (int)(tile / (uint32_t)raster->tiles_x) * DAFT_FINE_SIDE;
    const daft_hole_view holes = daft_hole_view_of(raster, &pencil, left, top, DAFT_FINE_SIDE);
    for (int i = 0; i < DAFT_TILE * DAFT_TILE * DAFT_FINE_RAYS; i++) {
        const int pixel = i / DAFT_FINE_RAYS, ray = i % DAFT_FINE_RAYS, x = pixel % DAFT_TILE, y = pixel / DAFT_TILE;
        if (!(out->pixels[y] >> x & 1)) continue;
        const int column = DAFT_FINE * x + ray % DAFT_FINE, row = DAFT_FINE * y + ray / DAFT_FINE;
        best nearest = nothing(raster, &holes, column, row);
        if (out->asked[pixel] >> ray & 1)
            nearest = trace(raster, tlas, daft_pencil_ray(&pencil, left + column, top + row), nearest);
        out->instance[i] = nearest.instance, out->triangle[i] = nearest.triangle;
    }
}
