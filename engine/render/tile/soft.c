/* Light that is sampled: shadows of lights that have a size, and how much of the surroundings a point sees (ambient
 * occlusion). Each point casts some rays, to places on the light or over its hemisphere (render/dice.h), and counts
 * those that nothing stops.
 *
 * Of an area, places count by how much of its light at the surface they stand for: one of four is drawn by that for
 * each ray (Talbot, Cline, Egbert, "Importance Resampling for Global Illumination", EGSR 2005), and rays weigh as much
 * as the places that they were drawn from. With what arrives unhindered in closed form (shade/area_kernel.c), their
 * mean is all that is sampled: the ratio estimator of Heitz and others, "Combining Analytic Direct Illumination and
 * Stochastic Shadows" (I3D 2018).
 *
 * Where many lights reach a point, some are drawn for it, in each colour by how much of it they would bring: what
 * arrives of a colour is the part of the draws whose light comes through. That is right in the mean, and has no noise
 * where all come through or none does (many lights: Shirley, Wang, Zimmerman, "Monte Carlo Techniques for Direct
 * Lighting Calculations", 1996; here with the unhindered light itself as measure).
 *
 * What sampled light adds is kept apart: all of it as it would be if nothing were in its way (whole), and what arrives
 * (arrived), so that their ratio can be filtered without blurring anything else. */
#include "render/tile/tile.h"

#include <math.h>
#include <string.h>

enum { STREAM = 256 }; /* rays that are asked together */
/* Lights that reach a point up to which all are asked, and draws of each colour where there are more, for each of a
 * light's samples. */
enum { LIGHTS_ASKED = 6, LIGHTS_DRAWN = 3 };

/* Where in the picture a point counts, in pixels of which one is sampled; and the picture's sample. */
static void place_of(const tile_job *j, const daft_batch *points, uint32_t i, uint32_t *x, uint32_t *y)
{
    const uint32_t place = j->refines ? j->s->wanted[points->pixel[i]] : points->pixel[i],
                   step = (uint32_t)j->frame->light_grid.step;
    *x = (j->number % daft_tile_columns(j->snapshot) * DAFT_TILE + place % DAFT_TILE) / step;
    *y = (j->number / daft_tile_columns(j->snapshot) * DAFT_TILE + place / DAFT_TILE) / step;
}

static uint32_t round_of(const tile_job *j) { return (uint32_t)j->frame->sample + j->snapshot->seed; }

/* What tells a point's samples from those of others; `salt`: of the light that asks. */
static daft_dice throw_dice(const tile_job *j, const daft_batch *points, uint32_t i, uint32_t salt)
{
    uint32_t x, y;
    place_of(j, points, i, &x, &y);
    return daft_dice_throw(x, y, round_of(j), salt);
}

/* Point `k` of `count` in the unit disc. */
static void disc_point(const daft_renderer *r, daft_dice d, uint32_t k, uint32_t count, float *x, float *y)
{
    const float away = sqrtf(daft_dice_part(d, k, count));
    const daft_vec2 unit = r->turns[daft_dice_turn(d, k)];
    *x = unit.x * away, *y = unit.y * away;
}

static daft_vec3 lane(const daft_lanes3 *v, uint32_t i) { return daft_v3(v->x[i], v->y[i], v->z[i]); }

/* ---- rays ---- */

static daft_ray ray_to_light(const tile_job *j, const daft_batch *points, uint32_t i, const daft_light_source *light,
                             uint32_t k, uint32_t rays, uint32_t salt)
{
    const daft_vec3 from = lane(&points->shadow_origin, i);
    daft_vec3 to = light->sun ? light->to_light : daft_sub(light->position, from), a, b;
    const float distance = light->sun ? 1 : sqrtf(daft_dot(to, to));
    float x, y;
    if (!(distance > 0)) return (daft_ray){.origin = from, .direction = to, .tmax = 0};
    daft_axes_across(daft_scale(to, 1 / distance), &a, &b);
    disc_point(j->r, throw_dice(j, points, i, salt), k, rays, &x, &y);
    to = daft_add(to, daft_scale(daft_add(daft_scale(a, x), daft_scale(b, y)), light->radius));
    return (daft_ray){.origin = from, .direction = to, .tmax = light->sun ? INFINITY : 1};
}

/* A place of a rectangle that shines, in parts of its sides. A ray ends before what glows in its place. */
static float rectangle_ray(const daft_light_source *light, daft_vec3 n, float u, float v, daft_ray *ray)
{
    const daft_vec3 place = daft_add(daft_scale(light->edges[0], u - 0.5f), daft_scale(light->edges[1], v - 0.5f));
    const daft_vec3 to = daft_add(daft_sub(light->position, ray->origin), place);
    const float length2 = daft_dot(to, to), there = daft_dot(to, light->to_light), here = daft_dot(to, n);
    ray->direction = to, ray->tmax = 1 - DAFT_BEFORE_RECTANGLE;
    return there > 0 && here > 0 ? there * here / (length2 * length2) : 0;
}

/* A direction to a sphere that glows, within its cone: `part` of the solid angle around the middle, turned to `unit`,
 * or with NULL up. The ray ends before the sphere. */
static float sphere_ray(const daft_light_source *light, daft_vec3 n, float part, const daft_vec2 *unit, daft_ray *ray)
{
    const daft_vec3 p = light->position, to = daft_sub(p, ray->origin);
    const float length2 = daft_dot(to, to), r = light->radius, length = sqrtf(length2), sine2 = r * r / length2;
    if (!(sine2 < 1)) return 0;
    const float aside = part * (sine2 / (1 + sqrtf(1 - sine2))), sine = sqrtf(aside * (2 - aside));
    const float larger = daft_sphere_end(light), off = larger * larger - length2 * sine * sine;
    daft_vec3 a, b;
    const daft_vec3 middle = daft_scale(to, 1 / length);
    daft_axes_across(middle, &a, &b);
    const daft_vec3 across = unit ? daft_add(daft_scale(a, unit->x), daft_scale(b, unit->y))
                                  : daft_normalize(daft_sub(n, daft_scale(middle, daft_dot(n, middle))));
    ray->direction = daft_add(daft_scale(middle, 1 - aside), daft_scale(across, sine));
    ray->tmax = fmaxf(length * (1 - aside) - sqrtf(fmaxf(off, 0)), 0);
    return fmaxf(daft_dot(ray->direction, n), 0);
}

/* Ends the ray before the bounds of what glows, where it comes to them. */
static void end_before_bounds(const daft_light_source *light, daft_ray *ray)
{
    const daft_vec3 from = daft_sub(ray->origin, light->bounds.middle);
    float first = 0, last = ray->tmax;
    for (int k = 0; k < 3; k++) {
        const float at = daft_dot(light->bounds.axes[k], from), by = daft_dot(light->bounds.axes[k], ray->direction);
        if (fabsf(at) > 1 && at * by >= 0) return;
        if (by == 0) continue;
        const float a = (-1 - at) / by, b = (1 - at) / by;
        first = fmaxf(first, fminf(a, b)), last = fminf(last, fmaxf(a, b));
    }
    if (first <= last) ray->tmax = first;
}

/* Place `k` of `count`. */
static float place_ray(const tile_job *j, const daft_light_source *light, daft_vec3 n, daft_dice d, uint32_t k,
                       uint32_t count, daft_ray *ray)
{
    const float part = daft_dice_part(d, k, count);
    if (light->area == DAFT_AREA_SPHERE) return sphere_ray(light, n, part, &j->r->turns[daft_dice_turn(d, k)], ray);
    const float along = (float)((d.turn + k * DAFT_GOLDEN) >> 8) * 0x1p-24f;
    return rectangle_ray(light, n, along, part, ray);
}

/* A place of what little of the light is above the horizon, where no other was found: ever nearer to the highest
 * corner of a rectangle, or at the top of a sphere. */
static float sliver_ray(const daft_light_source *light, daft_vec3 n, float along, float across, daft_ray *ray)
{
    const float u = daft_dot(light->edges[0], n) > 0 ? 1 : 0, v = daft_dot(light->edges[1], n) > 0 ? 1 : 0;
    if (light->area == DAFT_AREA_SPHERE) return 0.01f * sphere_ray(light, n, 0.99f, NULL, ray);
    for (float part = 0.5f; part > 0x1p-8f; part *= 0.5f) {
        const float found = rectangle_ray(light, n, u + (along - u) * part, v + (across - v) * part, ray);
        if (found > 0) return found * part * part;
    }
    return 0;
}

/* A number that nothing of the dice is seen in (PCG's output: O'Neill, 2014): even ones would beat with their places.
 */
static uint32_t scramble(uint32_t x)
{
    x = ((x >> ((x >> 28) + 4)) ^ x) * 277803737u;
    return x >> 22 ^ x;
}

/* Ray `k` of `rays` to an area, and its weight. */
static float area_ray(const tile_job *j, const daft_batch *points, uint32_t i, const daft_light_source *light,
                      uint32_t k, uint32_t rays, uint32_t salt, daft_ray *ray)
{
    const daft_vec3 n = lane(&points->normal, i);
    const daft_dice d = throw_dice(j, points, i, salt);
    float sum = 0, upto[DAFT_PLACES];
    daft_ray all[DAFT_PLACES];
    for (uint32_t p = 0; p < DAFT_PLACES; p++) {
        all[p] = (daft_ray){.origin = lane(&points->shadow_origin, i)};
        upto[p] = sum += place_ray(j, light, n, d, k * DAFT_PLACES + p, DAFT_PLACES * rays, &all[p]);
    }
    const float at = (float)(scramble(d.turn + 2891336453u * d.radius + k * DAFT_R2_X) >> 8) * 0x1p-24f * sum;
    uint32_t p = 0;
    while (p + 1 < DAFT_PLACES && !(at < upto[p])) p++;
    *ray = all[p];
    const float along = (float)(d.turn >> 8) * 0x1p-24f, across = (float)(d.radius >> 8) * 0x1p-24f;
    if (!(sum > 0)) sum = sliver_ray(light, n, along, across, ray);
    if (light->bounded) end_before_bounds(light, ray);
    return sum;
}

bool daft_tile_sharp_ray(const daft_batch *points, uint32_t i, const daft_light_source *light, daft_ray *ray)
{
    const daft_vec3 from = lane(&points->shadow_origin, i), n = lane(&points->normal, i);
    const daft_vec2 any = {1, 0};
    float some;
    *ray = (daft_ray){.origin = from,
                      .direction = light->sun ? light->to_light : daft_sub(light->position, from),
                      .tmax = light->sun ? INFINITY : 1};
    if (!light->area) return true;
    some =
        light->area == DAFT_AREA_SPHERE ? sphere_ray(light, n, 0, &any, ray) : rectangle_ray(light, n, 0.5f, 0.5f, ray);
    if (!(some > 0)) some = sliver_ray(light, n, 0.5f, 0.5f, ray);
    if (light->bounded) end_before_bounds(light, ray);
    return some > 0;
}

/* More of them where the surface faces (Malley's method: points of the disc, raised to the hemisphere); those that
 * would enter the facets of a smooth surface are mirrored by them. */
static daft_ray ray_around(const tile_job *j, const daft_batch *points, uint32_t i, uint32_t k)
{
    const daft_vec3 n = lane(&points->normal, i), out = lane(&points->outward, i);
    daft_vec3 a, b;
    float x, y;
    daft_axes_across(n, &a, &b);
    disc_point(j->r, throw_dice(j, points, i, UINT32_MAX), k, (uint32_t)j->snapshot->quality.occlusion_samples, &x, &y);
    const float up = sqrtf(fmaxf(0, 1 - x * x - y * y));
    daft_vec3 to = daft_add(daft_add(daft_scale(a, x), daft_scale(b, y)), daft_scale(n, up));
    const float under = daft_dot(to, out);
    if (under < 0) to = daft_sub(to, daft_scale(out, 2 * under));
    return (daft_ray){.origin = lane(&points->shadow_origin, i), .direction = to, .tmax = j->snapshot->occlusion};
}

/* Rays that wait to be asked, whose they are, and what they bring; those from `made` on are yet to be made. */
typedef struct ray_queue {
    _Alignas(64) daft_ray ray[STREAM + 16]; /* room for whole registers */
    uint32_t count, made;
    uint32_t point[STREAM + 16];
    int32_t number[STREAM + 16], rays[STREAM + 16]; /* which of how many of the point's */
    float weight[STREAM + 16];
    daft_vec3 light[STREAM];
} ray_queue;

/* Whom a queue's new rays go to: a light, by its number, or with NULL around. */
typedef struct target {
    const daft_light_source *light;
    uint32_t number;
} target;

/* What surfaces with alpha leave of a ray, over all colours. */
static float filtered(tile_job *j, const daft_batch *points, const daft_ray *ray, uint32_t point)
{
    const daft_vec3 left = daft_tile_filtered(j, points, point, ray);
    return left.x == left.y && left.y == left.z ? left.x : (left.x + left.y + left.z) / 3;
}

static void ask(tile_job *j, const daft_batch *points, ray_queue *q, daft_effect_kind effect)
{
    uint32_t stopped[STREAM / 32];
    daft_lanes3 *arrived = &j->s->sampled->arrived;
    j->r->accel->occluded_stream(j->frame->tlas, q->ray, q->count, stopped);
    for (uint32_t k = 0; k < q->count; k++) {
        if (stopped[k / 32] >> (k % 32) & 1) continue;
        const uint32_t i = q->point[k];
        const float part = j->frame->plan.filters ? filtered(j, points, &q->ray[k], i) : 1;
        arrived->x[i] += q->light[k].x * part, arrived->y[i] += q->light[k].y * part;
        arrived->z[i] += q->light[k].z * part;
    }
    j->s->rays_cast[effect] += q->count;
    q->count = q->made = 0;
}

/* Ray `k` of `rays` to the light, or with NULL around, and its weight; 0: there is none. */
static float make_ray(const tile_job *j, const daft_batch *points, uint32_t i, const target *to, uint32_t k,
                      uint32_t rays, daft_ray *ray)
{
    if (to->light && to->light->area) return area_ray(j, points, i, to->light, k, rays, to->number, ray);
    *ray = to->light ? ray_to_light(j, points, i, to->light, k, rays, to->number) : ray_around(j, points, i, k);
    return 1;
}

/* The new rays, with their weights. Of rectangles in lanes, but for those that find only slivers. */
static void make_rays(const tile_job *j, const daft_batch *points, const target *to, ray_queue *q)
{
    const uint32_t first = q->made, count = q->count - first, columns = daft_tile_columns(j->snapshot);
    const daft_area_rays def = {.points = points,
                                .light = to->light,
                                .column = j->number % columns * DAFT_TILE,
                                .row = j->number / columns * DAFT_TILE,
                                .step = (uint32_t)j->frame->light_grid.step,
                                .round = round_of(j),
                                .salt = to->number,
                                .place = j->refines ? j->s->wanted : NULL};
    const bool lanes = to->light && to->light->area == DAFT_AREA_RECTANGLE;
    if (lanes)
        j->r->kernels->rectangle_rays(&def, &q->point[first], &q->number[first], &q->rays[first], count, &q->ray[first],
                                      &q->weight[first]);
    for (uint32_t k = first; k < q->count; k++)
        if (!lanes || !(q->weight[k] > 0))
            q->weight[k] =
                make_ray(j, points, q->point[k], to, (uint32_t)q->number[k], (uint32_t)q->rays[k], &q->ray[k]);
}

/* Makes the new rays; each point's bring, among them, what the first of them has. Those without weight are left out. */
static void finish_rays(const tile_job *j, const daft_batch *points, const target *to, ray_queue *q)
{
    const uint32_t end = q->count;
    if (q->made == end) return;
    make_rays(j, points, to, q);
    q->count = q->made;
    for (uint32_t k = q->made; k < end;) {
        const uint32_t next = k + (uint32_t)q->rays[k];
        const daft_vec3 brought = q->light[k];
        float all = 0;
        for (uint32_t i = k; i < next; i++) all += q->weight[i] > 0 ? q->weight[i] : 0;
        for (; k < next; k++) {
            if (!(q->weight[k] > 0)) continue;
            daft_cost_add(j, &points->pixel[q->point[k]], 1);
            if (q->count != k) q->ray[q->count] = q->ray[k], q->point[q->count] = q->point[k];
            q->light[q->count++] = daft_scale(brought, q->weight[k] / all);
        }
    }
    q->made = q->count;
}

/* Point i's rays, which among them bring so much. */
static void cast(tile_job *j, const daft_batch *points, uint32_t i, const target *to, uint32_t rays, daft_vec3 brought,
                 ray_queue *q)
{
    if (q->count + rays > STREAM) {
        finish_rays(j, points, to, q);
        ask(j, points, q, to->light ? DAFT_EFFECT_SHADOW : DAFT_EFFECT_OCCLUSION);
    }
    q->light[q->count] = brought;
    for (uint32_t k = 0; k < rays; k++, q->count++)
        q->point[q->count] = i, q->number[q->count] = (int32_t)k, q->rays[q->count] = (int32_t)rays;
}

/* The points of which rays are cast: of those that are to be filtered the ones of the grid, and where rough surfaces
 * show them, which is filtered by itself, all; of more samples, those that recall nothing. */
static void choose(const tile_job *j, const daft_batch *points, const uint32_t *bits, uint32_t *chosen)
{
    const daft_grid *g = &j->frame->light_grid;
    const daft_sampled_light *light = j->s->sampled;
    for (uint32_t k = 0; k < DAFT_BATCH_WORDS; k++)
        chosen[k] = light->recalls ? bits[k] & ~light->recalled[k] : bits[k];
    for (uint32_t i = 0; g->step > 1 && !j->refines && i < points->count; i++) {
        const uint32_t pixel = points->pixel[i];
        if (!daft_grid_has(g, pixel % DAFT_TILE, pixel / DAFT_TILE) && !daft_gloss_is_rough(j->s->gloss, pixel))
            chosen[i / 32] &= ~(1u << (i % 32));
    }
}

/* ---- light that arrives ---- */

/* The points of the bits that cast rays become candidates' points; the batch's sampled light begins. */
static void begin(tile_job *j, const daft_batch *points, const uint32_t *bits)
{
    daft_sampled_light *s = j->s->sampled;
    daft_candidates *c = &s->candidates;
    if (!s->some) {
        memset(&s->whole, 0, sizeof s->whole);
        memset(&s->arrived, 0, sizeof s->arrived);
    }
    s->some = true;
    c->lights = c->points = 0;
    choose(j, points, bits, s->chosen);
    for (uint32_t i = 0; i < points->count; i++)
        if (s->chosen[i / 32] >> (i % 32) & 1) c->point[c->points++] = i;
}

static void all_points(const daft_batch *points, uint32_t *bits)
{
    for (uint32_t i = 0; i < DAFT_BATCH_WORDS; i++) {
        const uint32_t left = points->count > 32 * i ? points->count - 32 * i : 0;
        bits[i] = left >= 32 ? UINT32_MAX : (1u << left) - 1;
    }
    daft_tile_skip_holes(points, bits);
}

static void keep(daft_sampled_light *s, const daft_batch *points)
{
    memcpy(s->before.x, points->light.x, points->count * sizeof(float));
    memcpy(s->before.y, points->light.y, points->count * sizeof(float));
    memcpy(s->before.z, points->light.z, points->count * sizeof(float));
    s->kept = true;
}

/* What the points' light has become more than it was is sampled light, of a light or of what is around. */
static void take(tile_job *j, daft_batch *points)
{
    daft_sampled_light *s = j->s->sampled;
    j->r->kernels->take_light(points, &s->before, s->chosen, &s->whole, &s->candidates.from[s->candidates.lights]);
}

void daft_tile_occlusion(tile_job *j, daft_batch *points)
{
    const daft_ambient none = {0};
    const target around = {0};
    daft_sampled_light *s = j->s->sampled;
    const daft_candidates *c = &s->candidates;
    uint32_t all[DAFT_BATCH_WORDS];
    ray_queue q;
    q.count = q.made = 0;
    all_points(points, all);
    begin(j, points, all);
    j->r->shade->ambient(points, j->snapshot->materials, &none);
    keep(s, points);
    j->r->shade->ambient(points, j->snapshot->materials, &j->snapshot->ambient);
    take(j, points);
    book(j, DAFT_EFFECT_LIGHTING);
    const uint32_t rays = (uint32_t)daft_max_i(j->snapshot->quality.occlusion_samples, 1);
    for (uint32_t i = 0; i < c->points; i++) cast(j, points, c->point[i], &around, rays, lane(&c->from[0], i), &q);
    finish_rays(j, points, &around, &q);
    if (q.count) ask(j, points, &q, DAFT_EFFECT_OCCLUSION);
    ran(j, DAFT_EFFECT_OCCLUSION);
    book(j, DAFT_EFFECT_OCCLUSION);
}

void daft_tile_soft_light(tile_job *j, daft_batch *points, uint32_t number, const daft_lanes3 *passed)
{
    daft_sampled_light *s = j->s->sampled;
    daft_candidates *c = &s->candidates;
    if (c->lights == 0) {
        uint32_t all[DAFT_BATCH_WORDS];
        all_points(points, all);
        begin(j, points, all);
    }
    if (!s->kept) keep(s, points);
    j->r->shade->direct_light(points, j->snapshot->materials, &j->snapshot->lights[number], j->s->lit, passed, NULL);
    take(j, points);
    c->light[c->lights++] = number;
    book(j, DAFT_EFFECT_LIGHTING);
    if (c->lights == DAFT_CANDIDATES) daft_tile_ask_lights(j, points);
}

/* Where a point's draws begin, evenly over the picture and from picture to picture, whatever its places on lights: by
 * the square roots of 2, 3 and 5, as fractions of 2^32 (Richtmyer, "The Evaluation of Definite Integrals, and a
 * Quasi-Monte-Carlo Method", 1951). */
static float turn_of(const tile_job *j, const daft_batch *points, uint32_t i)
{
    uint32_t x, y;
    place_of(j, points, i, &x, &y);
    return (float)((x * 1779033703u + y * 3144134277u + round_of(j) * 1013904243u) >> 20) * 0x1p-12f;
}

void daft_tile_ask_lights(tile_job *j, const daft_batch *points)
{
    daft_sampled_light *s = j->s->sampled;
    daft_candidates *c = &s->candidates;
    const int rays = daft_max_i(j->snapshot->quality.shadow_samples, 1);
    const daft_drawing how = {.rays = rays, .all = LIGHTS_ASKED, .draws = LIGHTS_DRAWN * rays};
    daft_asking asking;
    ray_queue q;
    q.count = q.made = 0;
    if (c->lights == 0) return;
    for (uint32_t i = 0; i < c->points; i++) c->turn[i] = turn_of(j, points, c->point[i]);
    j->r->kernels->sum_candidates(c, &how);
    for (uint32_t l = 0; l < c->lights; l++) {
        const target to = {.light = &j->snapshot->lights[c->light[l]], .number = c->light[l]};
        j->r->kernels->draw_light(c, &how, l, &asking);
        for (uint32_t i = 0; i < asking.count; i++)
            cast(j, points, asking.point[i], &to, (uint32_t)asking.rays[i], lane(&asking.light, i), &q);
        finish_rays(j, points, &to, &q);
    }
    if (q.count) ask(j, points, &q, DAFT_EFFECT_SHADOW);
    c->lights = 0;
    ran(j, DAFT_EFFECT_SHADOW);
    book(j, DAFT_EFFECT_SHADOW);
}

void daft_tile_add_sampled(const daft_sampled_light *s, daft_batch *points)
{
    for (uint32_t i = 0; i < points->count; i++) {
        const bool known = s->recalls && s->recalled[i / 32] >> (i % 32) & 1;
        points->light.x[i] += known ? s->whole.x[i] * s->fraction.x[i] : s->arrived.x[i];
        points->light.y[i] += known ? s->whole.y[i] * s->fraction.y[i] : s->arrived.y[i];
        points->light.z[i] += known ? s->whole.z[i] * s->fraction.z[i] : s->arrived.z[i];
    }
}
