/* Rays within media: in which the camera is; what the surfaces that a batch's points lie on are between; what light
 * loses on its way within (Beer's law). Rays carry their media along; what they meet tells the rest. Only where some
 * material that transmits has a priority or absorbs.
 *
 * A length within is that of the ray, which starts off its surface: it is too short by up to 4 · DAFT_SPAWN_ERROR · S
 * over the cosine there, S as in render/kernels.h. */
#include "render/tile/tile.h"

#include <math.h>
#include <string.h>

enum {
    LONGEST_WALK = 256, /* surfaces in a row */
    TOUCHING = 64,      /* rays that are asked together, */
    NEIGHBOURS = 256    /* of so many points in a row */
};

static daft_vec3 lane(const daft_lanes3 *v, uint32_t i) { return daft_v3(v->x[i], v->y[i], v->z[i]); }

/* ---- all surfaces along a ray ---- */

/* The first ones of bodies that transmit, by their distances: at the same one by their instances, since bodies that
 * touch are each met, and of an instance once, where its triangles share an edge. */
typedef struct walk {
    uint32_t count;
    daft_pierced at[LONGEST_WALK];
} walk;

static bool comes_before(const daft_pierced *a, const daft_pierced *b)
{
    return a->t < b->t || (a->t == b->t && a->instance < b->instance);
}

static bool take_surface(void *user, const daft_pierced *hit)
{
    walk *w = user;
    uint32_t place = w->count;
    while (place > 0 && comes_before(hit, &w->at[place - 1])) place--;
    daft_pierced *same = place > 0 ? &w->at[place - 1] : NULL;
    if (same && same->t == hit->t && same->instance == hit->instance) {
        same->triangle = daft_min_u(same->triangle, hit->triangle);
        return true;
    }
    if (place == LONGEST_WALK) return true;
    w->count = daft_min_u(w->count + 1, LONGEST_WALK);
    memmove(&w->at[place + 1], &w->at[place], (w->count - 1 - place) * sizeof w->at[0]);
    w->at[place] = *hit;
    return true;
}

/* `ignore`: an instance, or UINT32_MAX. */
static void find_surfaces(walk *w, const daft_frame *frame, const daft_ray *ray, uint32_t ignore)
{
    w->count = 0;
    frame->renderer->accel->pierce(frame->tlas, ray, DAFT_INSTANCE_TRANSMITS, ignore, take_surface, w, NULL);
}

static uint32_t material_of(const daft_instance *instance, uint32_t triangle)
{
    return instance->materials[instance->mesh && instance->mesh->slots ? instance->mesh->slots[triangle] : 0];
}

static daft_vec3 normal_of(const daft_instance *instance, uint32_t triangle)
{
    const daft_trimesh *mesh = instance->mesh;
    daft_vec3 p[3];
    for (int k = 0; k < 3; k++) {
        const uint32_t v = mesh->indices[3 * (size_t)triangle + (size_t)k];
        p[k] = daft_affine_point(&instance->to_frame, daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]));
    }
    return daft_cross(daft_sub(p[1], p[0]), daft_sub(p[2], p[0]));
}

static bool leaves(const daft_instance *instance, const daft_ray *ray, const daft_pierced *hit)
{
    daft_vec3 outward = daft_neg(ray->direction);
    if (instance->mesh) {
        const daft_vec3 normal = normal_of(instance, hit->triangle);
        outward = daft_dot(normal, ray->direction) > 0 ? daft_neg(normal) : normal;
    }
    const daft_vec3 point = daft_add(ray->origin, daft_scale(ray->direction, hit->t));
    return daft_seen_from_inside(instance, hit->triangle, point, outward);
}

/* Of one surface its material, and whether the ray leaves the body there. False: it does not transmit. */
static bool crosses(const daft_snapshot *s, const daft_ray *ray, const daft_pierced *hit, uint32_t *material, bool *out)
{
    const daft_instance *instance = &s->instances[hit->instance];
    *material = material_of(instance, hit->triangle);
    if (!(s->materials[*material].transmission > 0)) return false;
    *out = leaves(instance, ray, hit);
    return true;
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
    const daft_ray up = {.direction = {0, 1, 0}, .tmax = INFINITY};
    uint32_t entered[LONGEST_WALK], within[LONGEST_WALK], entered_count = 0, count = 0, material;
    daft_media media = daft_no_media();
    walk w;
    bool out;
    find_surfaces(&w, frame, &up, UINT32_MAX);
    for (uint32_t i = 0; i < w.count; i++) {
        if (!crosses(s, &up, &w.at[i], &material, &out)) continue;
        if (!out) {
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

/* Rays that go on start a little beyond the surface: what is on the way there. */
static daft_ray ray_beyond(const daft_batch *b, uint32_t i)
{
    const daft_vec3 p = lane(&b->point, i), outward = lane(&b->outward, i);
    const float error = (fabsf(p.x) + fabsf(p.y) + fabsf(p.z) + b->extent[i]) * DAFT_SPAWN_ERROR;
    return (daft_ray){
        .origin = p, .direction = daft_neg(outward), .tmax = (2.5f + daft_dot(outward, lane(&b->view, i))) * error};
}

/* Of points on one instance, one or more, clears the bits of those that no other one touches. */
static void keep_touching(const tile_job *j, const daft_batch *b, const uint32_t *points, uint32_t count,
                          uint32_t *touched)
{
    daft_ray rays[TOUCHING];
    daft_hit hits[TOUCHING];
    uint32_t given = 0;
    do rays[given] = ray_beyond(b, points[given]);
    while (++given < count);
    j->r->accel->closest_stream(j->frame->tlas, rays, count, b->instance[points[0]], hits);
    for (uint32_t k = 0; k < count; k++)
        if (hits[k].instance == UINT32_MAX) touched[points[k] / 32] &= ~(1u << (points[k] % 32));
}

/* Bits of points that transmit where another instance touches their own: few do, and rays of neighbours tell so
 * quickly. */
static void find_touched(const tile_job *j, const daft_batch *b, uint32_t touched[DAFT_BATCH_WORDS])
{
    uint32_t left[DAFT_BATCH_WORDS] = {0}, points[TOUCHING];
    for (uint32_t i = 0; i < b->count; i++)
        if (j->snapshot->materials[b->material[i]].transmission > 0) left[i / 32] |= 1u << (i % 32);
    memcpy(touched, left, sizeof left);
    for (uint32_t first = 0; first < b->count; first++) {
        uint32_t count = 0;
        if (!(left[first / 32] >> (first % 32) & 1)) continue;
        for (uint32_t i = first; i < daft_min_u(b->count, first + NEIGHBOURS) && count < TOUCHING; i++) {
            if (!(left[i / 32] >> (i % 32) & 1) || b->instance[i] != b->instance[first]) continue;
            left[i / 32] &= ~(1u << (i % 32)), points[count++] = i;
        }
        keep_touching(j, b, points, count, touched);
    }
}

/* What of other bodies lies on the way beyond the surface is passed with it. A body that the ray is in already was
 * entered shortly before: its surface crosses this one. */
static void pass_touching(const tile_job *j, const daft_batch *b, uint32_t i, daft_media *beyond)
{
    const daft_snapshot *s = j->snapshot;
    const daft_ray ray = ray_beyond(b, i);
    uint32_t material;
    walk w;
    bool out;
    find_surfaces(&w, j->frame, &ray, b->instance[i]);
    for (uint32_t k = 0; k < w.count; k++)
        if (crosses(s, &ray, &w.at[k], &material, &out) && (out || !holds(&b->media->from[i], material)))
            daft_media_pass(beyond, s->materials, material, out);
}

static void cross(const tile_job *j, daft_batch *b, uint32_t i, bool touched)
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
    if (touched) pass_touching(j, b, i, &c->beyond[i]);
    c->eta[i] = daft_media_eta(&c->from[i], &c->beyond[i], s->materials, material, out);
}

static bool absorbs(const daft_snapshot *s, const daft_media *media)
{
    const uint32_t medium = daft_media_winner(media, s->materials);
    return medium != DAFT_NO_MEDIUM && daft_surface_absorbs(&s->materials[medium]);
}

static void make_black(daft_lanes3 *v, uint32_t i) { v->x[i] = v->y[i] = v->z[i] = 0; }

static void set_loss(daft_lanes3 *loss, uint32_t i, daft_vec3 by)
{
    loss->x[i] = by.x, loss->y[i] = by.y, loss->z[i] = by.z;
}

/* What the way from the camera takes. */
static void dim_points(const tile_job *j, daft_batch *points)
{
    daft_sampled_light *sampled = j->s->sampled;
    daft_lanes3 loss;
    for (uint32_t i = 0; i < points->count; i++)
        set_loss(&loss, i, daft_media_loss(&j->frame->eye, j->snapshot->materials, points->distance[i]));
    j->r->shade->fade(&points->light, 0, points->count, &loss);
    if (points->traits & DAFT_TRAIT_SENDS) j->r->shade->fade(&points->weight, 0, points->count, &loss);
    if (!sampled || !sampled->some) return;
    j->r->shade->fade(&sampled->whole, 0, points->count, &loss);
    j->r->shade->fade(&sampled->arrived, 0, points->count, &loss);
}

/* What is no interface has no light of its own; from the camera, light is absorbed on its way here. */
void daft_media_end(const tile_job *j, daft_batch *points, int depth)
{
    daft_sampled_light *sampled = j->s->sampled && j->s->sampled->some ? j->s->sampled : NULL;
    const bool sends = points->traits & DAFT_TRAIT_SENDS;
    uint32_t touched[DAFT_BATCH_WORDS];
    if (sends) find_touched(j, points, touched);
    for (uint32_t i = 0; sends && i < points->count; i++) {
        cross(j, points, i, touched[i / 32] >> (i % 32) & 1);
        if (points->media->eta[i] != 0) continue;
        make_black(&points->light, i);
        if (sampled) make_black(&sampled->whole, i), make_black(&sampled->arrived, i);
    }
    if (depth == 0 && absorbs(j->snapshot, &j->frame->eye)) dim_points(j, points);
}

/* ---- rays that are sent on ---- */

/* One that meets nothing is in no closed body. */
void daft_media_absorb(const tile_job *j, daft_ray_batch *rays, uint32_t first, const daft_hit *hits, uint32_t count)
{
    daft_lanes3 loss;
    bool some = false;
    for (uint32_t i = 0; i < count; i++) {
        const bool meets = hits[i].instance != UINT32_MAX;
        set_loss(&loss, i, daft_media_loss(&rays->media[first + i], j->snapshot->materials, meets ? hits[i].t : 0));
        some |= meets && rays->media[first + i].material[0] != DAFT_NO_MEDIUM;
    }
    if (some) j->r->shade->fade(&rays->weight, first, count, &loss);
}

/* ---- light ---- */

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
static daft_vec3 loss_to_light(const tile_job *j, const daft_batch *points, uint32_t i, const daft_light_source *light)
{
    const daft_snapshot *s = j->snapshot;
    const daft_vec3 from = lane(&points->shadow_origin, i),
                    way = light->sun ? light->to_light : daft_sub(light->position, from);
    const float unit = light->sun ? 1 : daft_length(way), end = light->sun ? INFINITY : 1;
    const daft_ray ray = {.origin = from, .direction = way, .tmax = end};
    daft_media media = points->media ? points->media->from[i] : daft_no_media();
    daft_vec3 loss = {0, 0, 0};
    float reached = 0;
    uint32_t material;
    walk w;
    bool out;
    find_surfaces(&w, j->frame, &ray, UINT32_MAX);
    for (uint32_t k = 0; k < w.count; k++) {
        if (!crosses(s, &ray, &w.at[k], &material, &out)) continue;
        if (out) daft_media_learn(&media, material);
        loss = daft_add(loss, daft_media_loss(&media, s->materials, (w.at[k].t - reached) * unit));
        daft_media_pass(&media, s->materials, material, out);
        reached = w.at[k].t;
    }
    if (!light->sun) loss = daft_add(loss, daft_media_loss(&media, s->materials, (end - reached) * unit));
    return loss;
}

void daft_media_dim(const tile_job *j, const daft_batch *points, const daft_light_source *light, const uint32_t *bits,
                    daft_lanes3 *passed)
{
    daft_lanes3 loss;
    uint32_t rays = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        const bool asks = (j->s->lit[i / 32] & bits[i / 32]) >> (i % 32) & 1;
        set_loss(&loss, i, asks ? loss_to_light(j, points, i, light) : daft_v3(0, 0, 0));
        rays += asks;
    }
    if (rays) j->r->shade->fade(passed, 0, points->count, &loss);
    j->s->rays_cast[DAFT_EFFECT_SHADOW] += rays;
    j->s->shadow_points += rays;
}
