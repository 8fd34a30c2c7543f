/* The pencil's first pass: instances against the camera's frustum, and into tiles by their projected bounds. */
#include "raster/raster.h"
#include "math/exact.h"
#include "math/simd/dispatch.h"
#include "raster/kernels.h"

#include <string.h>

enum { INSTANCES_A_WORK_ITEM = 128 };

const daft_raster_kernels *daft_raster_kernels_for(int isa)
{
    static const daft_raster_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_raster);
    return TABLE[isa];
}

bool daft_raster_init(daft_raster *raster, const daft_allocator *allocator, int workers, int isa, daft_error *error)
{
    *raster = (daft_raster){.allocator = allocator, .workers = workers, .kernels = daft_raster_kernels_for(isa)};
    raster->bins = daft_alloc_zero(allocator, (size_t)workers, sizeof *raster->bins);
    return raster->bins ? true : daft_fail_memory(error, "the renderer");
}

void daft_raster_free(daft_raster *raster)
{
    if (!raster->allocator) return;
    for (int i = 0; raster->bins && i < raster->workers; i++) {
        daft_release(raster->allocator, raster->bins[i].blocks);
        daft_release(raster->allocator, raster->bins[i].tiles);
        daft_release(raster->allocator, raster->bins[i].order);
    }
    daft_release(raster->allocator, raster->bins);
    daft_release(raster->allocator, raster->seen);
}

/* The map to camera space: axes times to_frame, in double, rounded once. */
static daft_affine camera_map(const daft_pencil *p, const daft_affine *frame)
{
    const daft_vec3 axes[3] = {p->right, p->up, p->forward};
    daft_affine map;
    for (int i = 0; i < 3; i++) {
        daft_dvec3 axis = daft_to_double(axes[i]);
        for (int j = 0; j < 3; j++)
            map.m[3 * i + j] = (float)(axis.x * (double)frame->m[j] + axis.y * (double)frame->m[3 + j] +
                                       axis.z * (double)frame->m[6 + j]);
        map.t[i] = (float)(axis.x * (double)frame->t[0] + axis.y * (double)frame->t[1] + axis.z * (double)frame->t[2]);
    }
    return map;
}

static void seen_box(const daft_seen *seen, daft_vec3 *low, daft_vec3 *high)
{
    daft_instance moved;
    moved.mesh = seen->mesh, moved.bvh = seen->bvh, moved.radius = seen->instance->radius, moved.to_frame = seen->to_camera;
    daft_instance_bound(&moved); /* reads no more of it */
    *low = moved.low;
    *high = moved.high;
}

/* The pixels whose rays may meet a box: exclusive of those whose ray lies beyond a side of it. False: none. */
static bool pixel_range(float low, float high, float near_z, float far_z, double focal, double centre, int size, int *first,
                        int *last)
{
    double a = 0, b = size - 1;
    if (near_z > 0) {
        double l = (double)low, h = (double)high, nz = (double)near_z, fz = (double)far_z;
        a = focal * (l < 0 ? l / nz : l / fz) + centre;
        b = focal * (h < 0 ? h / fz : h / nz) + centre;
        a = ceil((a < 0 ? 0 : a) - 1e-3);
        b = floor((b > size - 1 ? size - 1 : b) + 1e-3);
    }
    if (!(a <= b) || a > size - 1 || b < 0) return false;
    *first = a < 0 ? 0 : (int)a;
    *last = b > size - 1 ? size - 1 : (int)b;
    return true;
}

/* A box with corners in front of and behind the camera's plane: is all of it beyond one side of the frustum? */
static bool outside_sides(const daft_pencil *p, daft_vec3 low, daft_vec3 high)
{
    double half_x = (double)p->width * 0.5 + 1, half_y = (double)p->height * 0.5 + 1;
    double f = (double)p->focal, z = (double)high.z;
    return (double)low.x * f > z * half_x || -(double)high.x * f > z * half_x || (double)low.y * f > z * half_y ||
           -(double)high.y * f > z * half_y;
}

/* The slopes low..high of the rays that touch a sphere in the plane of z and another axis (Mara and McGuire, "2D Polyhedral
 * Bounds of a Clipped, Perspective-Projected 3D Sphere", JCGT 2(2), 2013); the sphere is in front of the camera's plane. */
static void sphere_slopes(double c, double z, double r, double *low, double *high)
{
    double t = sqrt(c * c + z * z - r * r);
    *low = (c * t - z * r) / (z * t + c * r);
    *high = (c * t + z * r) / (z * t - c * r);
}

static bool sphere_range(const daft_pencil *p, daft_seen *seen, double cx, double cy)
{
    const float *c = seen->to_camera.t;
    double z = (double)c[2], r = (double)seen->instance->radius * (1 + 0x1p-20) + fabs(z) * 0x1p-20, f = (double)p->focal;
    if (!(z > r * 1.001)) return true; /* around the camera or through its plane: the whole picture */
    double x0, x1, y0, y1;
    sphere_slopes((double)c[0], z, r, &x0, &x1);
    sphere_slopes(-(double)c[1], z, r, &y0, &y1);
    return pixel_range((float)x0, (float)x1, 1, 1, f, cx, p->width, &seen->x0, &seen->x1) &&
           pixel_range((float)y0, (float)y1, 1, 1, f, cy, p->height, &seen->y0, &seen->y1);
}

static bool seen_setup(const daft_pencil *p, const daft_instance *instance, uint32_t index, daft_seen *seen)
{
    if (instance->mesh && instance->mesh->triangle_count == 0) return false;
    *seen = (daft_seen){.instance = instance, .mesh = instance->mesh, .bvh = instance->bvh, .index = index};
    seen->to_camera = camera_map(p, &instance->to_frame);
    daft_vec3 low, high;
    seen_box(seen, &low, &high);
    if (!daft_finite3(low) || !daft_finite3(high) || high.z <= 0 || outside_sides(p, low, high)) return false;
    seen->near_z = low.z;
    double f = (double)p->focal;
    double cx = daft_pencil_middle_x(p), cy = daft_pencil_middle_y(p);
    if (!pixel_range(low.x, high.x, low.z, high.z, f, cx, p->width, &seen->x0, &seen->x1) ||
        !pixel_range(-high.y, -low.y, low.z, high.z, f, cy, p->height, &seen->y0, &seen->y1))
        return false;
    if (!instance->mesh) return sphere_range(p, seen, cx, cy);
    seen->dense = daft_seen_dense(seen);
    return true;
}

static bool tile_add(const daft_raster *raster, daft_bins *bins, uint32_t tile, uint64_t item)
{
    daft_bin_list *list = &bins->tiles[tile];
    uint32_t place = list->count % DAFT_BIN_ITEMS;
    if (place == 0) {
        if (!daft_grow(raster->allocator, &bins->blocks, &bins->block_capacity, bins->block_count + 1, bins->block_count,
                       sizeof *bins->blocks))
            return false;
        uint32_t fresh = (uint32_t)bins->block_count++;
        if (list->count)
            bins->blocks[list->last].next = fresh;
        else
            list->first = fresh;
        list->last = fresh;
    }
    bins->blocks[list->last].items[place] = item;
    list->count++;
    return true;
}

static void add_to_tiles(const daft_raster *raster, daft_bins *bins, const daft_seen *seen)
{
    uint32_t bits; /* of a positive float: they are in its order */
    float z = seen->near_z > 0 ? seen->near_z : 0;
    memcpy(&bits, &z, sizeof bits);
    for (int y = seen->y0 / DAFT_TILE; y <= seen->y1 / DAFT_TILE; y++)
        for (int x = seen->x0 / DAFT_TILE; x <= seen->x1 / DAFT_TILE; x++)
            if (!bins->out_of_memory && !tile_add(raster, bins, (uint32_t)(y * raster->tiles_x + x), (uint64_t)bits << 32 | seen->index))
                bins->out_of_memory = true;
}

static bool is_mesh(const daft_instance *instance) { return instance->mesh && instance->mesh->triangle_count; }

/* Fills raster->seen from one on, no further than `end`: of one instance, or of as many meshes as the kernel takes at once. Gives how many. */
static uint32_t see(daft_raster *raster, uint32_t first, uint32_t end)
{
    uint32_t lanes = raster->kernels->lanes, meshes = 0;
    const daft_instance *instances = &raster->instances[first];
    for (; meshes < lanes && first + meshes < end && is_mesh(&instances[meshes]); meshes++) {
        const char *ahead = (const char *)&instances[daft_min_u(meshes + lanes, end - first - 1)];
        for (size_t line = 0; line < sizeof *instances; line += 64) __builtin_prefetch(ahead + line);
    }
    if (meshes == lanes) {
        raster->kernels->seen(raster, first);
        return lanes;
    }
    daft_seen *seen = &raster->seen[first];
    if (!seen_setup(&raster->pencil, &raster->instances[first], first, seen)) seen->instance = NULL;
    return 1;
}

void daft_raster_bin(daft_raster *raster, uint32_t work, uint32_t worker)
{
    daft_bins *bins = &raster->bins[worker];
    uint32_t first = work * INSTANCES_A_WORK_ITEM, end = daft_min_u(raster->instance_count, first + INSTANCES_A_WORK_ITEM);
    for (uint32_t i = first; i < end;) {
        for (uint32_t next = i + see(raster, i, end); i < next; i++) {
            if (!raster->seen[i].instance) continue;
            bins->seen++;
            add_to_tiles(raster, bins, &raster->seen[i]);
        }
    }
}

static bool clear_bins(daft_raster *raster)
{
    size_t tiles = (size_t)raster->tiles_x * (size_t)raster->tiles_y;
    for (int i = 0; i < raster->workers; i++) {
        daft_bins *bins = &raster->bins[i];
        if (!daft_grow(raster->allocator, &bins->tiles, &bins->tile_capacity, tiles, 0, sizeof *bins->tiles) ||
            !daft_grow(raster->allocator, &bins->order, &bins->order_capacity, 2 * (size_t)raster->instance_count, 0, sizeof *bins->order))
            return false;
        memset(bins->tiles, 0, tiles * sizeof *bins->tiles);
        bins->block_count = 0;
        bins->seen = bins->nodes = bins->tested = bins->binned = bins->spheres = bins->exact_edges = bins->exact_depths = 0;
        bins->out_of_memory = false;
    }
    return true;
}

bool daft_raster_begin(daft_raster *raster, const daft_pencil *pencil, const daft_instance *instances, uint32_t count,
                       daft_error *error)
{
    raster->pencil = *pencil;
    raster->instances = instances;
    raster->instance_count = count;
    raster->tiles_x = (pencil->width + DAFT_TILE - 1) / DAFT_TILE;
    raster->tiles_y = (pencil->height + DAFT_TILE - 1) / DAFT_TILE;
    raster->work_count = (count + INSTANCES_A_WORK_ITEM - 1) / INSTANCES_A_WORK_ITEM;
    if (daft_grow(raster->allocator, &raster->seen, &raster->seen_capacity, count, 0, sizeof *raster->seen) &&
        clear_bins(raster))
        return true;
    return daft_fail_memory(error, "the list of visible things");
}

void daft_seen_corners(const daft_seen *seen, uint32_t triangle, daft_vec3 corner[3])
{
    const daft_trimesh *mesh = seen->mesh;
    const uint32_t *index = &mesh->indices[3 * (size_t)triangle];
    for (int k = 0; k < 3; k++)
        corner[k] = daft_affine_point(&seen->to_camera, daft_v3(mesh->x[index[k]], mesh->y[index[k]], mesh->z[index[k]]));
}

double daft_seen_depth(const daft_seen *seen, uint32_t triangle, daft_vec3 ray)
{
    if (!seen->mesh) {
        const float *c = seen->to_camera.t;
        double t;
        if (!daft_pencil_sphere(daft_v3(c[0], c[1], c[2]), seen->instance->radius, ray, &t)) return INFINITY;
        return t * (double)ray.z;
    }
    daft_vec3 corner[3];
    daft_seen_corners(seen, triangle, corner);
    return daft_pencil_depth(corner[0], corner[1], corner[2], ray);
}

void daft_tile_place(const daft_raster *raster, uint32_t tile, daft_tile *out)
{
    out->x = (int)(tile % (uint32_t)raster->tiles_x) * DAFT_TILE;
    out->y = (int)(tile / (uint32_t)raster->tiles_x) * DAFT_TILE;
    out->width = daft_min_i(DAFT_TILE, raster->pencil.width - out->x);
    out->height = daft_min_i(DAFT_TILE, raster->pencil.height - out->y);
}
