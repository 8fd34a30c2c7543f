/* Rays within media: in which the camera is; what the surfaces that a batch's points lie on are between; what light
 * loses on its way within (Beer's law). Rays carry their media along; what they meet tells the rest. Only where some
 * material that transmits has a priority or absorbs.
 *
 * A length within is that of the ray, which starts off its surface: it is too short by up to 4 · DAFT_SPAWN_ERROR · S
 * over the cosine there, S as in render/kernels.h. */
#include "render/tile/tile.h"

#include <math.h>

enum { LONGEST_WALK = 256 }; /* surfaces in a row */

static daft_vec3 lane(const daft_lanes3 *v, uint32_t i) { return daft_v3(v->x[i], v->y[i], v->z[i]); }

/* ---- all surfaces along a ray, one after the other ---- */

typedef struct walk {
    const daft_frame *frame;
    daft_ray ray; /* what is left of it */
    bool tied;    /* where the last one was there is another one's */
    daft_hit tie;
} walk;

/* Bodies that touch have surfaces at the same place: each is met. */
static bool next_surface(walk *w, daft_hit *hit)
{
    const daft_accel_kernels *accel = w->frame->renderer->accel;
    if (w->tied) {
        *hit = w->tie, w->tied = false;
        return true;
    }
    if (!accel->closest(w->frame->tlas, &w->ray, UINT32_MAX, hit)) return false;
    w->ray.tmin = hit->t;
    w->tied = accel->closest(w->frame->tlas, &w->ray, hit->instance, &w->tie) && w->tie.t == hit->t;
    w->ray.tmin = nextafterf(hit->t, INFINITY);
    return true;
}

static uint32_t material_of(const daft_snapshot *s, const daft_hit *hit)
{
    const daft_instance *instance = &s->instances[hit->instance];
    return instance->materials[instance->mesh && instance->mesh->slots ? instance->mesh->slots[hit->triangle] : 0];
}

static bool leaves(const daft_snapshot *s, const daft_ray *ray, const daft_hit *hit)
{
    const daft_instance *instance = &s->instances[hit->instance];
    daft_vec3 outward = daft_neg(ray->direction);
    if (instance->mesh) outward = daft_dot(hit->normal, ray->direction) > 0 ? daft_neg(hit->normal) : hit->normal;
    const daft_vec3 point = daft_add(ray->origin, daft_scale(ray->direction, hit->t));
    return daft_seen_from_inside(instance, hit->triangle, point, outward);
}

/* ---- the camera's ---- */

static bool holds_eye(const daft_snapshot *s, const daft_instance *i)
{
    const uint32_t slots = i->mesh && i->mesh->slot_count ? i->mesh->slot_count : 1;
    if (i->low.x > 0 || i->low.y > 0 || i->low.z > 0 || i->high.x < 0 || i->high.y < 0 || i->high.z < 0) return false;
    for (uint32_t k = 0; k < slots; k++)
        if (s->materials[i->materials[k]].transmission > 0) return true;
    return false;
}

bool daft_media_near_eye(const daft_snapshot *s)
{
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (holds_eye(s, &s->instances[i])) return true;
    return false;
}

/* Bodies that a ray upwards leaves without having entered them; what it leaves first was entered last. */
static daft_media media_of_eye(const daft_frame *frame)
{
    const daft_snapshot *s = frame->snapshot;
    walk w = {.frame = frame, .ray = {.direction = {0, 1, 0}, .tmax = INFINITY}};
    uint32_t entered[LONGEST_WALK], within[LONGEST_WALK], entered_count = 0, count = 0;
    daft_media media = daft_no_media();
    daft_hit hit;
    for (int i = 0; i < LONGEST_WALK && next_surface(&w, &hit); i++) {
        const uint32_t material = material_of(s, &hit);
        if (!(s->materials[material].transmission > 0)) continue;
        if (!leaves(s, &w.ray, &hit)) {
            entered[entered_count++] = material;
            continue;
        }
        uint32_t k = 0;
        while (k < entered_count && entered[k] != material) k++;
        if (k < entered_count)
            entered[k] = entered[--entered_count];
        else
            within[count++] = material;
    }
    while (count > 0) daft_media_pass(&media, s->materials, within[--count], false);
    return media;
}

/* ---- for a frame ---- */

static bool reserve(daft_renderer *r, size_t batches, size_t lists, daft_error *error)
{
    const size_t threads = (size_t)r->threads, rows = threads * lists * DAFT_BATCH_ROOM;
    return (daft_grow(&r->allocator, &r->crossings, &r->crossing_capacity, threads * batches, 0,
                      sizeof *r->crossings) &&
            daft_grow(&r->allocator, &r->media, &r->media_capacity, rows, 0, sizeof *r->media)) ||
           daft_fail_memory(error, "the media of rays");
}

bool daft_media_prepare(daft_frame *frame, daft_error *error)
{
    enum { BATCHES = 3 };
    daft_renderer *r = frame->renderer;
    const bool inside = frame->plan.media && daft_media_near_eye(frame->snapshot);
    frame->eye = inside ? media_of_eye(frame) : daft_no_media();
    frame->media = frame->plan.media && (frame->plan.refracts || frame->eye.material[0] != DAFT_NO_MEDIUM);
    const size_t waiting = frame->plan.refracts ? (size_t)(frame->plan.through_depth * frame->plan.through_lists) : 0;
    const size_t lists = frame->media ? 1 + waiting : 0;
    if (frame->media && !reserve(r, BATCHES, lists, error)) return false;
    for (int i = 0; i < r->threads; i++) {
        daft_scratch *s = &r->scratch[i];
        daft_batch *const batches[BATCHES] = {&s->points, &s->next, s->third};
        daft_media *rows = frame->media ? r->media + (size_t)i * lists * DAFT_BATCH_ROOM : NULL;
        for (int k = 0; k < BATCHES; k++)
            if (batches[k]) batches[k]->media = frame->media ? &r->crossings[BATCHES * i + k] : NULL;
        s->rays.media = rows;
        for (size_t k = 0; k < waiting; k++) s->refracted[k].media = rows ? rows + (1 + k) * DAFT_BATCH_ROOM : NULL;
    }
    return true;
}

size_t daft_media_bytes(const daft_renderer *r)
{
    return r->crossing_capacity * sizeof *r->crossings + r->media_capacity * sizeof *r->media;
}

/* ---- a batch's points ---- */

void daft_media_begin(const tile_job *j, daft_batch *points, int depth)
{
    if (depth) return; /* their rays brought them along */
    for (uint32_t i = 0; i < points->count; i++) points->media->from[i] = j->frame->eye;
}

static bool holds(const daft_media *media, uint32_t material)
{
    for (int i = 0; i < DAFT_MEDIA; i++)
        if (media->material[i] == material) return true;
    return false;
}

/* Rays that go on start a little beyond the surface; what of other bodies lies in between is passed with it. A body
 * that the ray is in already was entered shortly before: its surface crosses this one. */
static void pass_touching(const tile_job *j, const daft_batch *b, uint32_t i, daft_media *beyond)
{
    const daft_snapshot *s = j->snapshot;
    const daft_vec3 p = lane(&b->point, i), outward = lane(&b->outward, i);
    const float error = (fabsf(p.x) + fabsf(p.y) + fabsf(p.z) + b->extent[i]) * DAFT_SPAWN_ERROR;
    daft_ray ray = {
        .origin = p, .direction = daft_neg(outward), .tmax = (2.5f + daft_dot(outward, lane(&b->view, i))) * error};
    daft_hit hit;
    for (int k = 0; k < DAFT_MEDIA && j->r->accel->closest(j->frame->tlas, &ray, b->instance[i], &hit); k++) {
        const uint32_t material = material_of(s, &hit);
        const bool out = leaves(s, &ray, &hit);
        if (s->materials[material].transmission > 0 && (out || !holds(&b->media->from[i], material)))
            daft_media_pass(beyond, s->materials, material, out);
        ray.tmin = nextafterf(hit.t, INFINITY);
    }
}

static void cross(const tile_job *j, daft_batch *b, uint32_t i)
{
    const daft_snapshot *s = j->snapshot;
    const uint32_t material = b->material[i];
    daft_crossings *c = b->media;
    c->eta[i] = 1;
    if (!(s->materials[material].transmission > 0)) return;
    const bool out = b->inner[i];
    if (out) daft_media_learn(&c->from[i], material);
    c->beyond[i] = c->from[i];
    daft_media_pass(&c->beyond[i], s->materials, material, out);
    pass_touching(j, b, i, &c->beyond[i]);
    c->eta[i] = daft_media_eta(&c->from[i], &c->beyond[i], s->materials, material, out);
}

static void scale_lane(daft_lanes3 *v, uint32_t i, daft_vec3 by) { v->x[i] *= by.x, v->y[i] *= by.y, v->z[i] *= by.z; }

static void dim_point(const tile_job *j, daft_batch *points, uint32_t i, daft_vec3 by)
{
    daft_sampled_light *sampled = j->s->sampled;
    scale_lane(&points->light, i, by);
    if (!sampled || !sampled->some) return;
    scale_lane(&sampled->whole, i, by), scale_lane(&sampled->arrived, i, by);
}

/* What is no interface has no light of its own; from the camera, light is absorbed on its way here. */
void daft_media_end(const tile_job *j, daft_batch *points, int depth)
{
    const daft_snapshot *s = j->snapshot;
    const uint32_t medium = daft_media_winner(&j->frame->eye, s->materials);
    const bool sends = points->traits & DAFT_TRAIT_SENDS;
    const bool dims = depth == 0 && medium != DAFT_NO_MEDIUM && daft_surface_absorbs(&s->materials[medium]);
    for (uint32_t i = 0; sends && i < points->count; i++) {
        cross(j, points, i);
        if (points->media->eta[i] == 0) dim_point(j, points, i, daft_v3(0, 0, 0));
    }
    for (uint32_t i = 0; dims && i < points->count; i++) {
        const daft_vec3 left = daft_media_passed(&j->frame->eye, s->materials, points->distance[i]);
        dim_point(j, points, i, left);
        if (sends) scale_lane(&points->weight, i, left);
    }
}

/* ---- rays that are sent on ---- */

/* One that meets nothing is in no closed body. */
void daft_media_absorb(const tile_job *j, daft_ray_batch *rays, uint32_t first, const daft_hit *hits, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t at = first + i;
        if (hits[i].instance == UINT32_MAX || rays->media[at].material[0] == DAFT_NO_MEDIUM) continue;
        scale_lane(&rays->weight, at, daft_media_passed(&rays->media[at], j->snapshot->materials, hits[i].t));
    }
}

/* ---- light ---- */

static bool absorbs(const daft_snapshot *s, const daft_media *media)
{
    const uint32_t medium = daft_media_winner(media, s->materials);
    return medium != DAFT_NO_MEDIUM && daft_surface_absorbs(&s->materials[medium]);
}

bool daft_media_hold_points(const tile_job *j, const daft_batch *points, uint32_t *bits)
{
    bool some = false;
    for (uint32_t i = 0; points->media && i < points->count; i++) {
        if (!absorbs(j->snapshot, &points->media->from[i])) continue;
        bits[i / 32] |= 1u << (i % 32), some = true;
    }
    return some;
}

/* What comes straight through all media between a point and a light; what lies beyond the last surface is the light's
 * own medium. */
static daft_vec3 passed_to_light(const tile_job *j, const daft_batch *points, uint32_t i,
                                 const daft_light_source *light)
{
    const daft_snapshot *s = j->snapshot;
    const daft_vec3 from = lane(&points->shadow_origin, i),
                    way = light->sun ? light->to_light : daft_sub(light->position, from);
    const float unit = light->sun ? 1 : daft_length(way), end = light->sun ? INFINITY : 1;
    walk w = {.frame = j->frame, .ray = {.origin = from, .direction = way, .tmax = end}};
    daft_media media = points->media ? points->media->from[i] : daft_no_media();
    daft_vec3 left = {1, 1, 1};
    daft_hit hit;
    float reached = 0;
    for (int k = 0; k < LONGEST_WALK && next_surface(&w, &hit); k++) {
        const uint32_t material = material_of(s, &hit);
        if (!(s->materials[material].transmission > 0)) continue;
        const bool out = leaves(s, &w.ray, &hit);
        if (out) daft_media_learn(&media, material);
        left = daft_mul(left, daft_media_passed(&media, s->materials, (hit.t - reached) * unit));
        daft_media_pass(&media, s->materials, material, out);
        reached = hit.t;
    }
    return light->sun ? left : daft_mul(left, daft_media_passed(&media, s->materials, (end - reached) * unit));
}

void daft_media_dim(const tile_job *j, const daft_batch *points, const daft_light_source *light, const uint32_t *bits,
                    daft_lanes3 *passed)
{
    uint32_t rays = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        if (!(j->s->lit[i / 32] & bits[i / 32] & 1u << (i % 32))) continue;
        scale_lane(passed, i, passed_to_light(j, points, i, light));
        rays++;
    }
    j->s->rays_cast[DAFT_EFFECT_SHADOW] += rays;
    j->s->shadow_points += rays;
}
