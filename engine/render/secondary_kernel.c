/* Rays from surfaces: shadow rays of the points that lie under some candidate's bounds, mirrored rays where a material
 * mirrors. */
#include "math/simd.h"
#include "render/kernels.h"

/* Mirrored light below this share of white is left out: half a step of 8-bit sRGB is 1/3300. */
#define LEAST_WEIGHT (1.0f / 2048)

DAFT_INLINE vf3 load3(const daft_lanes3 *a, uint32_t i)
{
    return (vf3){vf_load(&a->x[i]), vf_load(&a->y[i]), vf_load(&a->z[i])};
}

/* ---- shadows ---- */

DAFT_INLINE vf3 lamp_way(const daft_batch *b, const daft_lamp *lamp, uint32_t i)
{
    if (lamp->sun) return (vf3){vf_set(lamp->to_light.x), vf_set(lamp->to_light.y), vf_set(lamp->to_light.z)};
    vf3 o = load3(&b->lifted, i);
    return (vf3){vf_set(lamp->position.x) - o.x, vf_set(lamp->position.y) - o.y, vf_set(lamp->position.z) - o.z};
}

DAFT_INLINE vf inverse(vf d)
{
    vf least = vf_set(1e-18f);
    vi sign = (vi)d & vi_set(INT32_MIN);
    vf magnitude = vf_max(vf_abs(d), least);
    return vf_set(1) / vf_xor_sign(magnitude, sign);
}

/* Bits of the points whose way to the lamp meets the box; widened as in accel's slab test. */
static vbits box_bits(const daft_batch *b, const daft_lamp *lamp, const daft_instance *c, uint32_t i)
{
    vf3 o = load3(&b->lifted, i), d = lamp_way(b, lamp, i), inv = {inverse(d.x), inverse(d.y), inverse(d.z)};
    vf x0 = (vf_set(c->low.x) - o.x) * inv.x, x1 = (vf_set(c->high.x) - o.x) * inv.x;
    vf y0 = (vf_set(c->low.y) - o.y) * inv.y, y1 = (vf_set(c->high.y) - o.y) * inv.y;
    vf z0 = (vf_set(c->low.z) - o.z) * inv.z, z1 = (vf_set(c->high.z) - o.z) * inv.z;
    vf near = vf_max(vf_max(vf_min(x0, x1), vf_min(y0, y1)), vf_max(vf_min(z0, z1), vf_set(0)));
    vf far = vf_min(vf_min(vf_max(x0, x1), vf_max(y0, y1)), vf_max(z0, z1));
    if (!lamp->sun) far = vf_min(far, vf_set(1));
    return vm_bits(vf_le(near, far * vf_set(1.0f + 6 * 0x1p-24f)));
}

/* A convex thing does not shadow its own points that face the lamp. */
static bool hides(const daft_batch *b, const daft_lamp *lamp, const daft_instance *instances, uint32_t candidate,
                  const daft_accel_kernels *accel, uint32_t i)
{
    const daft_instance *c = &instances[candidate];
    daft_ray ray = {.origin = {b->lifted.x[i], b->lifted.y[i], b->lifted.z[i]}, .direction = lamp->to_light, .tmax = INFINITY};
    if (!lamp->sun) ray.direction = daft_sub(lamp->position, ray.origin), ray.tmax = 1;
    if (b->instance[i] == candidate && (!c->mesh || (c->flags & DAFT_INSTANCE_CONVEX))) {
        daft_vec3 outward = {b->outward.x[i], b->outward.y[i], b->outward.z[i]};
        if (daft_dot(outward, ray.direction) > 0) return false;
    }
    return accel->instance_occluded(c, &ray);
}

static uint32_t shadows(const daft_batch *b, const daft_lamp *lamp, const daft_instance *instances,
                        const uint32_t *candidates, uint32_t candidate_count, const daft_accel_kernels *accel,
                        uint32_t bits[DAFT_BATCH_WORDS])
{
    uint32_t under[DAFT_BATCH_WORDS] = {0}, total = 0;
    for (uint32_t c = 0; c < candidate_count; c++) {
        for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
            uint32_t word = i / 32, shift = i % 32;
            vbits open = bits[word] >> shift & DAFT_ALL_LANES;
            if (!open) continue;
            vbits met = open & box_bits(b, lamp, &instances[candidates[c]], i);
            under[word] |= met << shift;
            for (; met; met &= met - 1) {
                uint32_t k = (uint32_t)__builtin_ctz(met);
                if (hides(b, lamp, instances, candidates[c], accel, i + k)) bits[word] &= ~((uint32_t)1 << (shift + k));
            }
        }
    }
    for (uint32_t w = 0; w < DAFT_BATCH_WORDS; w++) total += (uint32_t)__builtin_popcount(under[w]);
    return total;
}

/* ---- mirrors ---- */

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
        if (!(fmaxf(weight.x, fmaxf(weight.y, weight.z)) > LEAST_WEIGHT)) continue;
        daft_vec3 d = mirrored(lane3(&b->view, i), lane3(&b->normal, i), lane3(&b->outward, i));
        uint32_t at = rays->count++;
        rays->origin.x[at] = b->point.x[i], rays->origin.y[at] = b->point.y[i], rays->origin.z[at] = b->point.z[i];
        rays->direction.x[at] = d.x, rays->direction.y[at] = d.y, rays->direction.z[at] = d.z;
        rays->weight.x[at] = weight.x, rays->weight.y[at] = weight.y, rays->weight.z[at] = weight.z;
        rays->reach[at] = b->reach[i];
        rays->pixel[at] = b->pixel[i];
    }
}

const daft_render_kernels DAFT_KERNEL(daft_render) = {DAFT_KERNEL(daft_surfaces), DAFT_KERNEL(daft_hit_point), shadows,
                                                      reflections};
