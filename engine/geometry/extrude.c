/* Flat outlines to closed solids: two lids and a wall around every ring. */
#include "geometry/outline.h"
#include "geometry/trimesh.h"

#include <math.h>
#include <string.h>

enum { MOST_POINTS = 65536, MOST_EDGES = 1 << 18 };
static const float FARTHEST = 1e30f; /* sums of squares then stay finite in double */

/* ---- to the grid ---- */

/* Metres a cell: the power of two at which the largest coordinate has at most 22 bits, which a float can hold. */
static double cell_of(const daft_extrude_def *def)
{
    double largest = 0;
    for (uint32_t i = 0; i < def->point_count; i++)
        largest = fmax(largest, fmax(fabs((double)def->points[i].x), fabs((double)def->points[i].y)));
    int exponent = 0;
    (void)frexp(largest, &exponent);
    return ldexp(1, exponent - 22);
}

static int32_t to_grid(float value, double cell) { return (int32_t)floor((double)value / cell + 0.5); }

static bool check_def(const daft_extrude_def *def, daft_error *error)
{
    uint64_t sum = 0;
    if (!isfinite(def->depth) || !(def->depth > 0))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "depth is %g; it must be above 0", (double)def->depth);
    if (def->point_count > MOST_POINTS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%u points: at most %d make one solid", def->point_count,
                         (int)MOST_POINTS);
    for (uint32_t i = 0; i < def->contour_count && sum <= def->point_count; i++) sum += def->counts[i];
    if (sum != def->point_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "the contours' counts do not add up to the %u points",
                         def->point_count);
    for (uint32_t i = 0; i < def->point_count; i++)
        if (!(fabsf(def->points[i].x) <= FARTHEST) || !(fabsf(def->points[i].y) <= FARTHEST))
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "point %u is not finite, or farther off than 1e30 m", i);
    return true;
}

static bool add_contours(const daft_allocator *allocator, const daft_extrude_def *def, double cell,
                         daft_outline *outline, daft_error *error)
{
    daft_grid_point *grid = daft_alloc(allocator, (size_t)def->point_count + 1, sizeof *grid);
    bool done = grid || daft_fail_memory(error, "an outline");
    for (uint32_t i = 0; done && i < def->point_count; i++)
        grid[i] = (daft_grid_point){to_grid(def->points[i].x, cell), to_grid(def->points[i].y, cell)};
    for (uint32_t i = 0, first = 0; done && i < def->contour_count; first += def->counts[i++])
        done = daft_outline_add(allocator, outline, grid + first, def->counts[i], error);
    daft_release(allocator, grid);
    return done;
}

/* ---- to a mesh ---- */

typedef struct solid {
    const daft_outline *outline;
    daft_trimesh *mesh;
    double cell;
    float depth;
    size_t corners; /* of triangles, so far */
} solid;

/* Vertices: all of the front, then all of the back. */
static bool set_positions(const daft_allocator *allocator, const solid *s, daft_error *error)
{
    const uint32_t count = s->outline->point_count;
    daft_vec3 *positions = daft_alloc(allocator, 2 * (size_t)count, sizeof *positions);
    if (!positions) return daft_fail_memory(error, "a solid's vertices");
    for (uint32_t i = 0; i < count; i++) {
        const daft_grid_point p = s->outline->points[i];
        positions[i] = daft_v3((float)(p.x * s->cell), (float)(p.y * s->cell), s->depth / 2);
        positions[count + i] = daft_v3(positions[i].x, positions[i].y, -s->depth / 2);
    }
    const bool done = daft_trimesh_set_positions(allocator, s->mesh, positions, 2 * count, error);
    daft_release(allocator, positions);
    return done;
}

static void put_corner(solid *s, uint32_t vertex, uint32_t uv)
{
    s->mesh->indices[s->corners] = vertex;
    s->mesh->uv_indices[s->corners++] = uv;
}

/* The front's texture coordinates are its x and y, and so are the back's. */
static void put_lids(solid *s)
{
    const daft_outline *o = s->outline;
    for (uint32_t i = 0; i < o->point_count; i++) s->mesh->uvs[i] = (daft_vec2){s->mesh->x[i], s->mesh->y[i]};
    for (size_t i = 0; i < o->triangle_count; i++) {
        const uint32_t *t = o->triangles + 3 * i;
        for (int k = 0; k < 3; k++) put_corner(s, t[k], t[k]);
        for (int k = 2; k >= 0; k--) put_corner(s, o->point_count + t[k], t[k]);
    }
}

/* Four texture coordinates a border: metres along the ring, and from the back to the front. */
static void put_walls(solid *s)
{
    const daft_outline *o = s->outline;
    const uint32_t back = o->point_count;
    double along = 0;
    for (uint32_t i = 0; i < o->edge_count; i++) {
        static const uint8_t order[6] = {0, 1, 2, 0, 2, 3};
        const uint32_t a = o->ends[2 * i], b = o->ends[2 * i + 1], first = back + 4 * i;
        const daft_grid_edge *e = &o->edges[i];
        if (i == 0 || o->ends[2 * i - 1] != a) along = 0; /* another ring */
        const double x = ((double)e->b.x - e->a.x) * s->cell, y = ((double)e->b.y - e->a.y) * s->cell;
        const double end = along + sqrt(x * x + y * y);
        const daft_vec2 uvs[4] = {{(float)along, 0}, {(float)end, 0}, {(float)end, s->depth}, {(float)along, s->depth}};
        const uint32_t vertices[4] = {back + a, back + b, b, a};
        memcpy(s->mesh->uvs + first, uvs, sizeof uvs);
        for (int k = 0; k < 6; k++) put_corner(s, vertices[order[k]], first + order[k]);
        along = end;
    }
}

static bool make_mesh(const daft_allocator *allocator, solid *s, daft_error *error)
{
    const daft_outline *o = s->outline;
    daft_trimesh *mesh = s->mesh;
    const size_t triangles = 2 * (o->triangle_count + o->edge_count), uvs = o->point_count + 4 * o->edge_count;
    mesh->triangle_count = (uint32_t)triangles, mesh->uv_count = (uint32_t)uvs;
    mesh->indices = daft_alloc(allocator, 3 * triangles, sizeof(uint32_t));
    mesh->uv_indices = daft_alloc(allocator, 3 * triangles, sizeof(uint32_t));
    mesh->uvs = daft_alloc(allocator, uvs, sizeof(daft_vec2));
    if (!mesh->indices || !mesh->uv_indices || !mesh->uvs) return daft_fail_memory(error, "a solid");
    if (!set_positions(allocator, s, error)) return false;
    put_lids(s);
    put_walls(s);
    daft_trimesh_set_bounds(mesh);
    return daft_trimesh_smooth(allocator, mesh, DAFT_SMOOTH_CREASE, error);
}

bool daft_trimesh_extrude(const daft_allocator *allocator, const daft_extrude_def *def, daft_trimesh *out,
                          daft_error *error)
{
    if (!check_def(def, error)) return false;
    const double cell = cell_of(def);
    daft_outline outline = {.work = DAFT_OUTLINE_WORK};
    daft_trimesh mesh = {0};
    solid s = {.outline = &outline, .mesh = &mesh, .cell = cell, .depth = def->depth};
    bool done = add_contours(allocator, def, cell, &outline, error) &&
                daft_outline_resolve(allocator, &outline, MOST_EDGES, error) &&
                daft_outline_triangulate(allocator, &outline, error);
    if (done && outline.triangle_count == 0)
        done = daft_fail(error, DAFT_ERROR_ARGUMENT, "the contours enclose nothing");
    done = done && make_mesh(allocator, &s, error);
    daft_outline_free(allocator, &outline);
    if (done)
        *out = mesh;
    else
        daft_trimesh_free(allocator, &mesh);
    return done;
}
