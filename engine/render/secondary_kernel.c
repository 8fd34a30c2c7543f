/* Mirrored rays from surfaces, and the kernels of render/ in one table. */
#include "render/kernels.h"

/* Mirrored light below this share of white is left out: half a step of 8-bit sRGB is 1/3300. */
#define LEAST_WEIGHT (1.0f / 2048)

static daft_vec3 lane3(const daft_lanes3 *a, uint32_t i) { return daft_v3(a->x[i], a->y[i], a->z[i]); }

/* The mirrored direction; one that would enter the surface, which smooth normals can ask for, is bent to graze it. */
static daft_vec3 mirrored(daft_vec3 view, daft_vec3 normal, daft_vec3 outward)
{
    daft_vec3 d = daft_sub(daft_scale(normal, 2 * daft_dot(normal, view)), view);
    float under = daft_dot(d, outward);
    if (under < 1e-3f) d = daft_add(d, daft_scale(outward, 1e-3f - under));
    return daft_normalize(d);
}

static void reflections(const daft_batch *b, const daft_surface *materials, daft_ray_batch *rays)
{
    rays->count = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        daft_vec3 weight = daft_mul(lane3(&b->weight, i), materials[b->material[i]].mirror);
        if (!(weight.x > LEAST_WEIGHT || weight.y > LEAST_WEIGHT || weight.z > LEAST_WEIGHT)) continue;
        daft_vec3 d = mirrored(lane3(&b->view, i), lane3(&b->normal, i), lane3(&b->outward, i));
        uint32_t at = rays->count++;
        rays->origin.x[at] = b->point.x[i], rays->origin.y[at] = b->point.y[i], rays->origin.z[at] = b->point.z[i];
        rays->direction.x[at] = d.x, rays->direction.y[at] = d.y, rays->direction.z[at] = d.z;
        rays->weight.x[at] = weight.x, rays->weight.y[at] = weight.y, rays->weight.z[at] = weight.z;
        rays->reach[at] = b->reach[i];
        rays->pixel[at] = b->pixel[i];
    }
}

const daft_render_kernels DAFT_KERNEL(daft_render) = {DAFT_KERNEL(daft_surfaces), DAFT_KERNEL(daft_hit_point),
                                                      DAFT_KERNEL(daft_finish_hits),
                                                      DAFT_KERNEL(daft_shadows), reflections};
