/* Rays that surfaces send on, mirrored and refracted, and the kernels of render/ in one table. Scalar: one point
 * after the other.
 *
 * Where a surface transmits, Fresnel's equations (for light that is not polarised) divide what is transmitted between
 * the mirrored and the refracted ray, and Snell's law bends the latter; past the critical angle all of it is mirrored.
 * Which index lies on which side follows from the hit alone, by the surface's outer side, so nothing is carried along a
 * path: a camera may stand in glass, and parts may cross each other; what lies beyond a surface that is left counts as
 * air. Where materials have priorities or absorb, rays carry their media along (render/media.h), and tile/media.c has
 * found what each point's surface is between. Radiance is not scaled by the square of the index: it would be scaled
 * back where the light leaves again.
 *
 * Rough surfaces are facets (GGX: Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough
 * Surfaces", EGSR 2007), each a smooth surface; a ray meets one of those that its viewer sees. Light that other facets
 * hide on its way is not lost but goes on from these; so a white surface under a white sky stays white. */
#include "render/dice.h"
#include "render/kernels.h"

#define GRAZING 1e-3f /* the sine of the least angle between a facet and a ray that leaves it */

static daft_vec3 lane3(const daft_lanes3 *a, uint32_t i) { return daft_v3(a->x[i], a->y[i], a->z[i]); }

/* The normal of a facet that is seen (Dupuy, Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023);
 * the surface's own where that is smooth. */
static daft_vec3 facet_at(const daft_batch *b, uint32_t i, float alpha, const daft_spawning *allowed)
{
    const daft_vec3 normal = lane3(&b->normal, i), view = lane3(&b->view, i);
    if (!(alpha > 0) || !allowed->rough) return normal;
    const uint32_t place = allowed->place ? allowed->place[b->pixel[i]] : b->pixel[i];
    const daft_dice dice = daft_dice_throw(allowed->column + place % DAFT_TILE, allowed->row + place / DAFT_TILE,
                                           allowed->round, allowed->salt);
    const daft_vec2 turn = allowed->turns[daft_dice_turn(dice, allowed->ray)];
    const float part = daft_dice_part(dice, allowed->ray, allowed->rays), up = daft_dot(view, normal);
    daft_vec3 x, y;
    daft_axes_across(normal, &x, &y);
    const daft_vec3 v =
        daft_normalize(daft_v3(alpha * daft_dot(view, x), alpha * daft_dot(view, y), up > GRAZING ? up : GRAZING));
    const float z = (1 - part) * (1 + v.z) - v.z, across = z * z < 1 ? sqrtf(1 - z * z) : 0;
    const float high = z + v.z > 1e-6f ? z + v.z : 1e-6f;
    const daft_vec3 h = daft_v3(alpha * (across * turn.x + v.x), alpha * (across * turn.y + v.y), high);
    return daft_normalize(daft_add(daft_add(daft_scale(x, h.x), daft_scale(y, h.y)), daft_scale(normal, h.z)));
}

/* The mirrored direction; one that would enter the surface, which smooth normals can ask for, is bent to graze it, and
 * by facets is mirrored once more. */
static daft_vec3 mirrored(daft_vec3 view, daft_vec3 normal, daft_vec3 outward, bool rough)
{
    daft_vec3 d = daft_sub(daft_scale(normal, 2 * daft_dot(normal, view)), view);
    float under = daft_dot(d, outward);
    if (rough && under < 0) d = daft_sub(d, daft_scale(outward, 2 * under)), under = -under;
    if (under < GRAZING) d = daft_add(d, daft_scale(outward, GRAZING - under));
    return daft_normalize(d);
}

/* What happens to a ray at a surface between two indices. */
typedef struct interface {
    float eta;    /* the index on the viewer's side over the one beyond */
    float cosine; /* between the normal and the direction to the viewer, up to 1; more than 0, though smooth normals may
                     face away */
    float beyond; /* between the normal and the refracted ray; 0 where all is mirrored */
    float fresnel; /* fraction that is mirrored */
} interface;

static interface interface_at(float eta, float cosine)
{
    interface f = {eta, cosine > GRAZING ? (cosine < 1 ? cosine : 1) : GRAZING, 0, 1};
    if (eta == 1) f.beyond = f.cosine, f.fresnel = 0;
    float sine2 = eta * eta * (1 - f.cosine * f.cosine);
    if (eta == 1 || !(sine2 < 1)) return f;
    f.beyond = sqrtf(1 - sine2);
    float across = (eta * f.cosine - f.beyond) / (eta * f.cosine + f.beyond);
    float along = (f.cosine - eta * f.beyond) / (f.cosine + eta * f.beyond);
    f.fresnel = 0.5f * (across * across + along * along);
    return f;
}

/* By Snell's law; not bent at all between equal indices, to the bit. */
static daft_vec3 refracted(const interface *f, daft_vec3 view, daft_vec3 normal, daft_vec3 outward)
{
    if (f->eta == 1) return daft_neg(view);
    daft_vec3 d = daft_sub(daft_scale(normal, f->eta * f->cosine - f->beyond), daft_scale(view, f->eta));
    float over = daft_dot(d, outward);
    if (over > -GRAZING) d = daft_sub(d, daft_scale(outward, over + GRAZING));
    return daft_normalize(d);
}

/* What is known of the triangle that was asked for last: neighbours mostly lie on the same one, seen from the same
 * side. */
typedef struct side_planes {
    uint32_t instance, triangle; /* instance UINT32_MAX: none yet */
    daft_vec3 outward;
    daft_vec3 corner[3], in[3]; /* in: unit, in the triangle's plane, off the side that begins at the corner */
    bool from_inside;           /* whether its inner side is seen */
} side_planes;

typedef struct spawning {
    const daft_snapshot *snapshot;
    const daft_batch *b;
    const daft_spawning *allowed;
    daft_ray_batch *mirrored, *refracted;
    side_planes planes;
} spawning;

static void find_sides(side_planes *p, const daft_instance *instance)
{
    const daft_trimesh *mesh = instance->mesh;
    const uint32_t *at = &mesh->indices[3 * (size_t)p->triangle];
    daft_vec3 *c = p->corner;
    for (int k = 0; k < 3; k++)
        c[k] = daft_affine_point(&instance->to_frame, daft_v3(mesh->x[at[k]], mesh->y[at[k]], mesh->z[at[k]]));
    for (int k = 0; k < 3; k++) {
        daft_vec3 in = daft_normalize(daft_cross(p->outward, daft_sub(c[(k + 1) % 3], c[k])));
        if (daft_dot(in, daft_sub(c[(k + 2) % 3], c[k])) < 0) in = daft_neg(in);
        p->in[k] = in;
    }
}

/* Of a point on a mesh. */
static const side_planes *planes_at(spawning *s, uint32_t i)
{
    const daft_batch *b = s->b;
    side_planes *p = &s->planes;
    const daft_vec3 outward = lane3(&b->outward, i), was = p->outward;
    if (p->instance == b->instance[i] && p->triangle == b->triangle[i] && was.x == outward.x && was.y == outward.y &&
        was.z == outward.z)
        return p;
    const daft_instance *instance = &s->snapshot->instances[b->instance[i]];
    p->instance = b->instance[i], p->triangle = b->triangle[i], p->outward = outward;
    p->from_inside = daft_seen_from_inside(instance, p->triangle, lane3(&b->point, i), outward);
    find_sides(p, instance);
    return p;
}

static bool from_inside(spawning *s, uint32_t i)
{
    const daft_batch *b = s->b;
    const daft_instance *instance = &s->snapshot->instances[b->instance[i]];
    if (instance->mesh) return planes_at(s, i)->from_inside;
    return daft_seen_from_inside(instance, b->triangle[i], lane3(&b->point, i), lane3(&b->outward, i));
}

/* `media`: that the ray is in; read where rays carry them. */
static void add_ray(const daft_batch *b, uint32_t i, daft_vec3 origin, daft_vec3 d, daft_vec3 weight,
                    const daft_media *media, daft_ray_batch *rays)
{
    uint32_t at = rays->count++;
    rays->origin.x[at] = origin.x, rays->origin.y[at] = origin.y, rays->origin.z[at] = origin.z;
    rays->direction.x[at] = d.x, rays->direction.y[at] = d.y, rays->direction.z[at] = d.z;
    rays->weight.x[at] = weight.x, rays->weight.y[at] = weight.y, rays->weight.z[at] = weight.z;
    rays->distance[at] = b->distance[i];
    rays->pixel[at] = b->pixel[i];
    if (rays->media) rays->media[at] = media[i];
}

static const daft_media *media_from(const daft_batch *b) { return b->media ? b->media->from : NULL; }
static const daft_media *media_beyond(const daft_batch *b) { return b->media ? b->media->beyond : NULL; }

static bool counts(daft_vec3 weight, float min) { return weight.x > min || weight.y > min || weight.z > min; }

/* What moves a point that lies closer than `margin` to the sides of its triangle, or beyond one by rounding, away from
 * them. */
static daft_vec3 off_sides(const side_planes *planes, daft_vec3 p, float margin)
{
    daft_vec3 shift = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const float inside = daft_dot(planes->in[k], daft_sub(p, planes->corner[k]));
        if (inside < margin) shift = daft_add(shift, daft_scale(planes->in[k], margin - inside));
    }
    return shift;
}

/* Batches hold points that lie off the surface by e along `outward` and e along `view`; this one lies e beyond it, and
 * half as much again for the roundings on the way. Within e of a facet's side it may lie across the neighbouring one,
 * inside when it is meant to be outside or the other way round; so it is moved away from sides by as much. */
static daft_vec3 place_beyond(spawning *s, uint32_t i)
{
    const daft_batch *b = s->b;
    daft_vec3 outward = lane3(&b->outward, i);
    daft_vec3 p = lane3(&b->point, i);
    float error = (fabsf(p.x) + fabsf(p.y) + fabsf(p.z) + b->extent[i]) * DAFT_SPAWN_ERROR;
    daft_vec3 on = daft_sub(p, daft_scale(daft_add(outward, lane3(&b->view, i)), error));
    if (s->snapshot->instances[b->instance[i]].mesh) on = daft_add(on, off_sides(planes_at(s, i), on, error));
    return daft_sub(on, daft_scale(outward, 1.5f * error));
}

/* A point that transmits: `mirror` is what its material mirrors besides. Where mirrored rays are not followed any more,
 * what can be refracted is, in full; what cannot still is mirrored, since that is the only way the light has. */
static void divide(spawning *s, uint32_t i, float alpha, daft_vec3 mirror, daft_vec3 weight)
{
    const daft_batch *b = s->b;
    const daft_spawning *allowed = s->allowed;
    const daft_surface *material = &s->snapshot->materials[b->material[i]];
    const bool rough = allowed->rough && alpha > 0;
    daft_vec3 view = lane3(&b->view, i), outward = lane3(&b->outward, i);
    daft_vec3 normal = facet_at(b, i, alpha, allowed);
    float eta = b->media ? b->media->eta[i] : from_inside(s, i) ? material->index : 1 / material->index;
    interface f = interface_at(eta, daft_dot(normal, view));
    if (!allowed->mirrors && f.fresnel < 1) f.fresnel = 0;
    float fraction = material->transmission * f.fresnel;
    daft_vec3 back = daft_mul(weight, daft_add(mirror, daft_v3(fraction, fraction, fraction)));
    if (counts(back, allowed->min))
        add_ray(b, i, lane3(&b->point, i), mirrored(view, normal, outward, rough), back, media_from(b), s->mirrored);
    daft_vec3 on = daft_mul(weight, daft_scale(material->transmittance, 1 - f.fresnel));
    if (counts(on, allowed->min))
        add_ray(b, i, place_beyond(s, i), refracted(&f, view, normal, outward), on, media_beyond(b), s->refracted);
}

/* What a surface that blends does not cover: straight on. */
static void pass_through(spawning *s, uint32_t i)
{
    const daft_batch *b = s->b;
    const daft_vec3 left = daft_scale(lane3(&b->weight, i), 1 - b->varying->opacity[i]);
    if (counts(left, s->allowed->min))
        add_ray(b, i, place_beyond(s, i), daft_neg(lane3(&b->view, i)), left, media_from(b), s->refracted);
}

/* A surface within a medium that wins: it is not there. */
static void pass_by(spawning *s, uint32_t i)
{
    const daft_batch *b = s->b;
    const daft_vec3 weight = lane3(&b->weight, i);
    if (s->refracted && s->allowed->refracts && counts(weight, s->allowed->min))
        add_ray(b, i, place_beyond(s, i), daft_neg(lane3(&b->view, i)), weight, media_beyond(b), s->refracted);
}

/* What point i mirrors and, where it transmits, refracts. */
static void send(spawning *s, uint32_t i)
{
    const daft_batch *b = s->b;
    const daft_spawning *allowed = s->allowed;
    const daft_surface *material = &s->snapshot->materials[b->material[i]];
    const daft_varying *varying = b->traits & DAFT_TRAIT_VARIES ? b->varying : NULL;
    const float alpha = varying ? varying->alpha[i] : material->alpha;
    const bool rough = allowed->rough && alpha > 0;
    if (allowed->ray && !rough) return;
    daft_vec3 weight = lane3(&b->weight, i);
    if (rough) weight = daft_scale(weight, 1 / (float)allowed->rays);
    const daft_vec3 own = varying ? lane3(&varying->mirror, i) : material->mirror;
    const daft_vec3 mirror = allowed->mirrors ? own : daft_v3(0, 0, 0);
    if (s->refracted && allowed->refracts && material->transmission > 0) {
        divide(s, i, alpha, mirror, weight);
        return;
    }
    weight = daft_mul(weight, mirror);
    if (!counts(weight, allowed->min)) return;
    const daft_vec3 normal = facet_at(b, i, alpha, allowed);
    const daft_vec3 d = mirrored(lane3(&b->view, i), normal, lane3(&b->outward, i), rough);
    add_ray(b, i, lane3(&b->point, i), d, weight, media_from(b), s->mirrored);
}

static void spawn(const daft_snapshot *snapshot, const daft_batch *b, const daft_spawning *allowed,
                  daft_ray_batch *mirror_rays, daft_ray_batch *refracted_rays)
{
    spawning s = {snapshot, b, allowed, mirror_rays, refracted_rays, {.instance = UINT32_MAX}};
    const bool blends = b->traits & DAFT_TRAIT_BLEND && allowed->blends && refracted_rays && allowed->ray == 0;
    mirror_rays->count = 0;
    if (refracted_rays) refracted_rays->count = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        if (b->media && b->media->eta[i] == 0) {
            if (allowed->ray == 0) pass_by(&s, i);
            continue;
        }
        if (blends && b->varying->opacity[i] < 1) pass_through(&s, i);
        send(&s, i);
    }
}

const daft_render_kernels DAFT_KERNEL(daft_render) = {.surfaces = DAFT_KERNEL(daft_surfaces),
                                                      .listed_surfaces = DAFT_KERNEL(daft_listed_surfaces),
                                                      .hit_points = DAFT_KERNEL(daft_hit_points),
                                                      .spawn = spawn,
                                                      .ids = DAFT_KERNEL(daft_tile_ids),
                                                      .contrast = DAFT_KERNEL(daft_find_contrast),
                                                      .corners = DAFT_KERNEL(daft_find_corners),
                                                      .match_corners = DAFT_KERNEL(daft_match_corners),
                                                      .mix_corners = DAFT_KERNEL(daft_mix_corners),
                                                      .filter_noise = DAFT_KERNEL(daft_filter_noise),
                                                      .filter_spread = DAFT_KERNEL(daft_filter_spread),
                                                      .filter_pass = DAFT_KERNEL(daft_filter_pass),
                                                      .reuse = DAFT_KERNEL(daft_reuse),
                                                      .enlarge = DAFT_KERNEL(daft_enlarge)};
