/* Light that comes through surfaces with alpha (instances of DAFT_INSTANCE_FILTERS_SHADOW): each hit leaves of it what
 * the surface does not cover, and of what it covers what its material transmits. For the points of a batch and one
 * light, raster/samples finds what opacity classes and masks tell. The others send rays, which are told of all their
 * hits; the texture is read where neither the class of the triangle nor its mask tells. */
#include "render/tile/tile.h"

#include "math/trig.h"

#include <math.h>

/* A ray on its way, and what is left of it. In double, so that the order of hits is not seen in the float. */
typedef struct beam {
    const tile_job *j;
    daft_ray ray;
    uint32_t instance, own; /* where it begins; own: the triangle there, if it leaves that, which then cannot stop it */
    double left[3];
    uint32_t reads;
} beam;

/* As render/points/surface_kernel.c has it of points. */
static daft_vec2 sphere_uv(const daft_instance *s, daft_vec3 p)
{
    const daft_vec3 from = daft_sub(p, daft_v3(s->to_frame.t[0], s->to_frame.t[1], s->to_frame.t[2]));
    const daft_vec3 local = daft_normalize(daft_affine_vector(&s->to_object, from));
    return (daft_vec2){0.5f + (float)(daft_atan2((double)local.z, (double)local.x) / (2 * DAFT_PI)),
                       0.5f + (float)(daft_asin((double)local.y) / DAFT_PI)};
}

static daft_vec2 triangle_uv(const daft_trimesh *mesh, const daft_pierced *hit)
{
    const uint32_t *corner = &(mesh->uv_indices ? mesh->uv_indices : mesh->indices)[3 * (size_t)hit->triangle];
    const float weight[3] = {1 - hit->u - hit->v, hit->u, hit->v};
    daft_vec2 uv = {0, 0};
    for (int k = 0; k < 3 && mesh->uvs; k++) {
        if (corner[k] == DAFT_NO_UV) continue;
        uv.x += mesh->uvs[corner[k]].x * weight[k], uv.y += mesh->uvs[corner[k]].y * weight[k];
    }
    return uv;
}

/* As render/points/surface_kernel.c has it of points. */
static float vertex_alpha(const daft_trimesh *mesh, const daft_pierced *hit)
{
    if (!mesh || !mesh->alphas) return 1;
    const uint32_t *corner = &(mesh->color_indices ? mesh->color_indices : mesh->indices)[3 * (size_t)hit->triangle];
    const float a = mesh->alphas[corner[0]], b = mesh->alphas[corner[1]], c = mesh->alphas[corner[2]];
    return a + (b - a) * hit->u + (c - a) * hit->v;
}

/* False: the texture must be read. */
static bool mask_tells(const daft_mask *m, daft_vec2 uv, float *opacity)
{
    const float u = uv.x * m->scale_u + m->offset_u, v = 1 - (uv.y * m->scale_v + m->offset_v);
    const float off_u = (1 + fabsf(u) + fabsf(m->offset_u)) * 0x1p-20f,
                off_v = (1 + fabsf(v) + fabsf(m->offset_v)) * 0x1p-20f;
    if (!m->cells || !(off_u <= m->slack_u && off_v <= m->slack_v)) return false;
    const uint32_t cell = daft_mask_cell(m, u, v);
    *opacity = cell == DAFT_OPACITY_OPAQUE;
    return cell != DAFT_OPACITY_MIXED;
}

static float opacity_at(beam *b, const daft_instance *instance, const daft_surface *m, const daft_pierced *hit)
{
    const daft_snapshot *s = b->j->snapshot;
    daft_vec2 uv = {0, 0};
    if (!daft_surface_blends(m)) return 1;
    if (m->maps[DAFT_MAP_ALPHA] != DAFT_NO_TEXTURE) {
        uv = instance->mesh ? triangle_uv(instance->mesh, hit)
                            : sphere_uv(instance, daft_add(b->ray.origin, daft_scale(b->ray.direction, hit->t)));
        const uint32_t slot = instance->mesh && instance->mesh->slots ? instance->mesh->slots[hit->triangle] : 0;
        float told;
        if (instance->masks && mask_tells(&instance->masks[slot], uv, &told)) return told;
        b->reads++;
    }
    return daft_surface_opacity(m, s->textures, uv, vertex_alpha(instance->mesh, hit), s->quality.texture_filter);
}

/* What of the light a surface leaves that is `there` so far. */
static void pass(double left[3], const daft_surface *m, double there)
{
    left[0] *= 1 - there + there * (double)m->transmittance.x;
    left[1] *= 1 - there + there * (double)m->transmittance.y;
    left[2] *= 1 - there + there * (double)m->transmittance.z;
}

static bool meet(void *user, const daft_pierced *hit)
{
    beam *b = user;
    const daft_snapshot *s = b->j->snapshot;
    const daft_instance *instance = &s->instances[hit->instance];
    if (hit->instance == b->instance && hit->triangle == b->own) return true;
    if (instance->opacity && instance->opacity[hit->triangle] == DAFT_OPACITY_OPAQUE) {
        b->left[0] = b->left[1] = b->left[2] = 0;
        return false;
    }
    const uint32_t slot = instance->mesh && instance->mesh->slots ? instance->mesh->slots[hit->triangle] : 0;
    const daft_surface *m = &s->materials[instance->materials[slot]];
    const double there = (double)opacity_at(b, instance, m, hit);
    pass(b->left, m, there);
    return b->left[0] > 0 || b->left[1] > 0 || b->left[2] > 0;
}

static daft_vec3 lane(const daft_lanes3 *v, uint32_t i) { return daft_v3(v->x[i], v->y[i], v->z[i]); }

/* `neighbours`: the rays of a batch go to one light, so what stopped the one before often stops this one, too, and is
 * asked first. Any order gives the same: where a hit takes all of the light, nothing else of it is told. */
static daft_vec3 left_of(tile_job *j, const daft_batch *points, uint32_t i, const daft_ray *ray, bool neighbours)
{
    const bool flat = j->snapshot->instances[points->instance[i]].mesh != NULL;
    const bool leaves = flat && daft_dot(lane(&points->outward, i), ray->direction) > 0;
    daft_pierced_leaf *last = &j->s->last_stop;
    beam b = {.j = j,
              .ray = *ray,
              .instance = points->instance[i],
              .own = leaves ? points->triangle[i] : UINT32_MAX,
              .left = {1, 1, 1}};
    if (!neighbours || !j->r->accel->pierce_leaf(j->frame->tlas, ray, last, meet, &b)) {
        b.left[0] = b.left[1] = b.left[2] = 1;
        j->r->accel->pierce(j->frame->tlas, ray, DAFT_INSTANCE_FILTERS_SHADOW, UINT32_MAX, meet, &b, last);
    }
    j->s->alpha_reads += b.reads;
    return daft_v3((float)b.left[0], (float)b.left[1], (float)b.left[2]);
}

daft_vec3 daft_tile_filtered(tile_job *j, const daft_batch *points, uint32_t i, const daft_ray *ray)
{
    j->s->alpha_rays++;
    return left_of(j, points, i, ray, false);
}

/* By point i's own ray. */
static daft_vec3 left_by_ray(tile_job *j, const daft_batch *points, uint32_t i, const daft_light_source *light)
{
    daft_ray ray;
    if (!daft_tile_sharp_ray(points, i, light, &ray)) return daft_v3(0, 0, 0);
    return left_of(j, points, i, &ray, true);
}

/* By the even surfaces that it is known to meet. */
static daft_vec3 left_by_surfaces(const tile_job *j, const daft_filtered *f, uint32_t i)
{
    const daft_snapshot *s = j->snapshot;
    double left[3] = {1, 1, 1};
    for (uint32_t k = 0; k < f->count[i]; k++) {
        const daft_surface *m = &s->materials[f->material[k][i]];
        pass(left, m, (double)daft_surface_opacity(m, s->textures, (daft_vec2){0, 0}, 1, s->quality.texture_filter));
    }
    return daft_v3((float)left[0], (float)left[1], (float)left[2]);
}

/* Point i keeps this of the light: false where it is nothing. */
static bool keep_light(daft_lanes3 *passed, uint32_t i, daft_vec3 left, bool *some)
{
    if (left.x == 1 && left.y == 1 && left.z == 1) return true;
    if (!(left.x > 0 || left.y > 0 || left.z > 0)) return false;
    *some = true;
    passed->x[i] *= left.x, passed->y[i] *= left.y, passed->z[i] *= left.z;
    return true;
}

const daft_lanes3 *daft_tile_filters(tile_job *j, const daft_batch *points, const daft_light_source *light,
                                     const daft_lanes3 *passed)
{
    daft_scratch *s = j->s;
    const daft_samples samples = daft_samples_of(points);
    const daft_apex apex = daft_apex_of(light);
    void *memory = j->r->sample_scratch + j->worker * j->r->sample_kernels->scratch_size;
    const daft_filtered *f;
    uint32_t aside[DAFT_BATCH_WORDS] = {0};
    bool some = passed != NULL;
    const bool parts = light->area && j->r->kernels->skip_middle(points, light, s->lit, aside);
    uint32_t rays = j->r->sample_kernels->filters(&samples, &apex, j->frame->tlas, s->lit, &f, memory);
    for (uint32_t k = 0; parts && k < DAFT_BATCH_WORDS; k++)
        s->lit[k] |= aside[k], rays += (uint32_t)__builtin_popcount(aside[k]);
    if (!rays) return passed;
    if (!passed)
        for (uint32_t i = 0; i < points->count + 16; i++) s->passed->x[i] = s->passed->y[i] = s->passed->z[i] = 1;
    daft_cost_add_some(j, points->pixel, f->under, points->count);
    for (uint32_t i = 0; i < points->count; i++) {
        const uint32_t bit = 1u << (i % 32);
        const bool open = (f->open[i / 32] | aside[i / 32]) & bit;
        if (!(s->lit[i / 32] & bit) || !(open || f->count[i])) continue;
        const daft_vec3 left = open ? left_by_ray(j, points, i, light) : left_by_surfaces(j, f, i);
        if (!keep_light(s->passed, i, left, &some)) s->lit[i / 32] &= ~bit;
    }
    s->alpha_rays += rays;
    s->rays_cast[DAFT_EFFECT_SHADOW] += rays, s->shadow_points += rays;
    ran(j, DAFT_EFFECT_SHADOW);
    book(j, DAFT_EFFECT_SHADOW);
    return some ? s->passed : NULL;
}

void daft_tile_skip_holes(const daft_batch *points, uint32_t *bits)
{
    if (!(points->traits & DAFT_TRAIT_BLEND)) return;
    for (uint32_t i = 0; i < points->count; i++)
        if (points->varying->opacity[i] == 0) bits[i / 32] &= ~(1u << (i % 32));
}
