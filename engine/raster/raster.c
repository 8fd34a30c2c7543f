/* The rasterizer's memory, its kernels, and what the exact fallbacks of both paths ask. */
#include "raster/raster.h"
#include "math/exact.h"
#include "math/simd/dispatch.h"

DAFT_KERNEL_DECLARE(daft_raster_kernels, daft_raster);

const daft_raster_kernels *daft_raster_kernels_for(int isa)
{
    static const daft_raster_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_raster);
    return TABLE[isa];
}

DAFT_KERNEL_DECLARE(daft_sample_kernels, daft_samples);

const daft_sample_kernels *daft_sample_kernels_for(int isa)
{
    static const daft_sample_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_samples);
    return TABLE[isa];
}

bool daft_raster_init(daft_raster *raster, const daft_allocator *allocator, int workers, int isa, daft_error *error)
{
    *raster = (daft_raster){.allocator = allocator, .workers = workers, .kernels = daft_raster_kernels_for(isa)};
    raster->bins = daft_alloc_zero(allocator, (size_t)workers, sizeof *raster->bins);
    raster->scratch = daft_alloc_zero(allocator, (size_t)workers, raster->kernels->scratch_size);
    return raster->bins && raster->scratch ? true : daft_fail_memory(error, "the renderer");
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
    daft_release(raster->allocator, raster->scratch);
    daft_release(raster->allocator, raster->visible);
}

size_t daft_raster_bytes(const daft_raster *raster)
{
    size_t bytes = raster->visible_capacity * sizeof *raster->visible;
    if (!raster->bins) return bytes;
    bytes += (size_t)raster->workers * raster->kernels->scratch_size;
    for (int i = 0; i < raster->workers; i++) {
        const daft_bins *bins = &raster->bins[i];
        bytes += bins->order_capacity * sizeof *bins->order + bins->block_capacity * sizeof *bins->blocks +
                 bins->tile_capacity * sizeof *bins->tiles;
    }
    return bytes;
}

void daft_view_corners(const daft_view_instance *view, uint32_t triangle, daft_vec3 corner[3])
{
    const daft_trimesh *mesh = view->mesh;
    const uint32_t *index = &mesh->indices[3 * (size_t)triangle];
    for (int k = 0; k < 3; k++)
        corner[k] = daft_affine_point(&view->to_view, daft_v3(mesh->x[index[k]], mesh->y[index[k]], mesh->z[index[k]]));
}

double daft_view_depth(const daft_view_instance *view, uint32_t triangle, daft_vec3 ray)
{
    if (!view->mesh) {
        const float *c = view->to_view.t;
        double t;
        if (!daft_pencil_sphere(daft_v3(c[0], c[1], c[2]), view->instance->radius, ray, &t)) return INFINITY;
        return t * (double)ray.z;
    }
    daft_vec3 corner[3];
    daft_view_corners(view, triangle, corner);
    return daft_pencil_depth(corner[0], corner[1], corner[2], ray);
}
