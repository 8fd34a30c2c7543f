/* Queries: a walk finds parts, each is asked in its own frame, and the best answers are kept in an order that does not
 * depend on the walk's. */
#include "sim/query/query.h"

#include "sim/query/walk.h"

daft_sim_filter daft_default_sim_filter(void)
{
    return (daft_sim_filter){.layers = UINT32_MAX,
                             .mask = UINT32_MAX,
                             .kinds = 1u << DAFT_BODY_STATIC | 1u << DAFT_BODY_KINEMATIC | 1u << DAFT_BODY_DYNAMIC};
}

/* ---- what is kept ---- */

/* The first `capacity` answers in order; `found` counts all. */
typedef struct answers {
    daft_sim_hit *hits;
    uint32_t capacity, count, found;
} answers;

typedef struct query {
    daft_world *world;
    daft_sim_path path;
    daft_rigid frame; /* of the shape; the ray's origin */
    const daft_sim_shape *shape;
    double limit;
    answers answers;
    bool all;
} query;

static bool is_before(const daft_sim_hit *a, const daft_sim_hit *b)
{
    if (a->distance != b->distance) return a->distance < b->distance;
    if (a->body != b->body) return a->body < b->body;
    return a->shape < b->shape;
}

static void keep(answers *a, const daft_sim_hit *hit)
{
    uint32_t at = a->count;
    while (at > 0 && is_before(hit, &a->hits[at - 1])) at--;
    a->found++;
    if (at == a->capacity) return;
    if (a->count < a->capacity) a->count++;
    for (uint32_t i = a->count - 1; i > at; i--) a->hits[i] = a->hits[i - 1];
    a->hits[at] = *hit;
}

static daft_sim_hit hit_of(const daft_world *world, uint32_t index, daft_shape_part at)
{
    const daft_sim_part *part = &world->parts[index];
    return (daft_sim_hit){.body = part->body + 1,
                          .user = world->bodies[part->body].user,
                          .shape = daft_sim_part_ordinal(world, index),
                          .shape_user = part->user,
                          .child = at.child,
                          .triangle = at.triangle};
}

static daft_rigid frame_of(const daft_world *world, uint32_t part)
{
    return daft_sim_part_frame(&world->bodies[world->parts[part].body], &world->parts[part]);
}

static double length_of(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

/* Neither NaN nor far beyond where bodies can be. */
static bool is_sane(daft_dvec3 v)
{
    double limit = DAFT_SIM_MAX_QUERY;
    return fabs(v.x) <= limit && fabs(v.y) <= limit && fabs(v.z) <= limit;
}

/* Where casts meet; distances from then on need not be looked at. */
static void take_cast(query *q, daft_sim_hit *hit, double fraction)
{
    hit->fraction = fraction;
    hit->distance = fraction * length_of(q->path.motion);
    if (hit->inside) {
        double length = length_of(q->path.motion);
        hit->normal = daft_to_float(daft_dscale(q->path.motion, length > 0 ? -1 / length : 0));
    }
    keep(&q->answers, hit);
    if (!q->all && fraction < q->path.end) q->path.end = fraction;
}

/* ---- rays ---- */

static void visit_ray(void *context, uint32_t part)
{
    query *q = context;
    daft_rigid frame = frame_of(q->world, part);
    daft_ray_result r;
    daft_dvec3 origin = daft_rigid_to_local(&frame, q->frame.p);
    daft_dvec3 motion = daft_rigid_to_local_vector(&frame, q->path.motion);
    if (!daft_shape_raycast(&q->world->parts[part].shape, origin, motion, q->path.end, &r)) return;
    daft_sim_hit hit = hit_of(q->world, part, r.part);
    hit.point = daft_dadd(q->frame.p, daft_dscale(q->path.motion, r.t));
    hit.normal = daft_to_float(daft_rigid_vector(&frame, daft_to_double(r.normal)));
    hit.inside = r.t == 0 && hit.triangle == DAFT_NO_FEATURE;
    take_cast(q, &hit, r.t);
}

static bool ray_begin(query *q, daft_world *world, daft_dvec3 origin, daft_dvec3 motion)
{
    daft_dvec3 zero = {0, 0, 0};
    q->world = world;
    q->frame = daft_rigid_identity();
    q->frame.p = origin;
    q->path = (daft_sim_path){origin, motion, zero, 1};
    return is_sane(origin) && is_sane(motion) && length_of(motion) > 0;
}

bool daft_world_cast_ray(daft_world *world, daft_dvec3 origin, daft_dvec3 motion, const daft_sim_filter *filter,
                         daft_sim_hit *hit)
{
    daft_sim_hit nearest;
    query q = {.answers = {&nearest, 1, 0, 0}};
    if (!ray_begin(&q, world, origin, motion)) return false;
    daft_sim_walk(world, &q.path, filter, visit_ray, &q);
    if (q.answers.count > 0 && hit) *hit = nearest;
    return q.answers.count > 0;
}

static void visit_any(void *context, uint32_t part)
{
    query *q = context;
    if (q->path.end < 0) return;
    visit_ray(context, part);
    if (q->answers.found > 0) q->path.end = -1;
}

bool daft_world_is_blocked(daft_world *world, daft_dvec3 origin, daft_dvec3 motion, const daft_sim_filter *filter)
{
    query q = {.all = true};
    if (!ray_begin(&q, world, origin, motion)) return false;
    daft_sim_walk(world, &q.path, filter, visit_any, &q);
    return q.answers.found > 0;
}

uint32_t daft_world_cast_ray_all(daft_world *world, daft_dvec3 origin, daft_dvec3 motion, const daft_sim_filter *filter,
                                 daft_sim_hit *hits, uint32_t capacity)
{
    query q = {.answers = {hits, capacity, 0, 0}, .all = true};
    if (!ray_begin(&q, world, origin, motion)) return 0;
    daft_sim_walk(world, &q.path, filter, visit_ray, &q);
    return q.answers.found;
}

/* ---- shapes ---- */

static bool shape_begin(query *q, daft_world *world, const daft_sim_shape *shape, daft_dvec3 position,
                        daft_quat rotation, daft_dvec3 motion)
{
    bool sane = is_sane(position) && is_sane(motion) && isfinite(rotation.x) && isfinite(rotation.y) &&
                isfinite(rotation.z) && isfinite(rotation.w);
    if (!sane || !daft_shape_has_mass(shape)) return false;
    q->world = world;
    q->shape = shape;
    q->frame = daft_rigid_make(position, rotation);
    q->path = daft_sim_path_of(shape, &q->frame, motion);
    return true;
}

static void visit_overlap(void *context, uint32_t part)
{
    query *q = context;
    daft_rigid frame = frame_of(q->world, part), relative = daft_rigid_relative(&q->frame, &frame);
    if (!daft_shape_overlap(q->shape, &q->world->parts[part].shape, &relative, 0)) return;
    daft_sim_hit hit = hit_of(q->world, part, (daft_shape_part){0, DAFT_NO_FEATURE});
    hit.inside = true;
    keep(&q->answers, &hit);
}

static void visit_cast(void *context, uint32_t part)
{
    query *q = context;
    daft_rigid frame = frame_of(q->world, part), relative = daft_rigid_relative(&frame, &q->frame);
    daft_dvec3 motion = daft_rigid_to_local_vector(&frame, q->path.motion);
    daft_impact impact;
    daft_impact_kind kind = daft_shape_cast(q->shape, &relative, motion, &q->world->parts[part].shape, &impact);
    if (kind == DAFT_IMPACT_MISS) return;
    daft_sim_hit hit = hit_of(q->world, part, impact.part_b);
    hit.inside = kind == DAFT_IMPACT_OVERLAP;
    hit.point = hit.inside ? q->frame.p : daft_rigid_point(&frame, impact.point);
    hit.normal = daft_to_float(daft_dscale(daft_rigid_vector(&frame, impact.normal), -1));
    take_cast(q, &hit, hit.inside ? 0 : impact.t);
}

bool daft_world_cast_shape(daft_world *world, const daft_sim_shape *shape, daft_dvec3 position, daft_quat rotation,
                           daft_dvec3 motion, const daft_sim_filter *filter, daft_sim_hit *hit)
{
    daft_sim_hit nearest;
    query q = {.answers = {&nearest, 1, 0, 0}};
    if (!shape_begin(&q, world, shape, position, rotation, motion)) return false;
    bool moves = length_of(motion) > 0;
    daft_sim_walk(world, &q.path, filter, moves ? visit_cast : visit_overlap, &q);
    if (q.answers.count == 0) return false;
    if (!moves) nearest.point = position;
    if (hit) *hit = nearest;
    return true;
}

uint32_t daft_world_overlap(daft_world *world, const daft_sim_shape *shape, daft_dvec3 position, daft_quat rotation,
                            const daft_sim_filter *filter, daft_sim_hit *hits, uint32_t capacity)
{
    query q = {.answers = {hits, capacity, 0, 0}, .all = true};
    if (!shape_begin(&q, world, shape, position, rotation, daft_dv3(0, 0, 0))) return 0;
    daft_sim_walk(world, &q.path, filter, visit_overlap, &q);
    return q.answers.found;
}

/* ---- points ---- */

static void visit_closest(void *context, uint32_t part)
{
    query *q = context;
    daft_rigid frame = frame_of(q->world, part);
    daft_dvec3 local = daft_rigid_to_local(&frame, q->frame.p), on;
    daft_shape_part at;
    double distance;
    if (!daft_shape_closest(&q->world->parts[part].shape, local, q->limit, &on, &distance, &at)) return;
    daft_sim_hit hit = hit_of(q->world, part, at);
    hit.distance = distance;
    hit.inside = distance == 0 && at.triangle == DAFT_NO_FEATURE;
    hit.point = daft_rigid_point(&frame, on);
    if (distance > 0)
        hit.normal = daft_to_float(daft_rigid_vector(&frame, daft_dscale(daft_dsub(local, on), 1 / distance)));
    keep(&q->answers, &hit);
    if (distance >= q->limit) return;
    q->limit = distance;
    q->path.reach = daft_dv3(distance, distance, distance);
}

bool daft_world_closest(daft_world *world, daft_dvec3 point, double limit, const daft_sim_filter *filter,
                        daft_sim_hit *hit)
{
    daft_sim_hit nearest;
    query q = {.answers = {&nearest, 1, 0, 0}};
    daft_dvec3 zero = {0, 0, 0};
    if (!(limit >= 0)) return false;
    q.limit = limit < DAFT_SIM_MAX_QUERY ? limit : DAFT_SIM_MAX_QUERY;
    if (!ray_begin(&q, world, point, daft_dv3(1, 0, 0))) return false;
    q.path = (daft_sim_path){point, zero, daft_dv3(q.limit, q.limit, q.limit), 1};
    daft_sim_walk(world, &q.path, filter, visit_closest, &q);
    if (q.answers.count > 0 && hit) *hit = nearest;
    return q.answers.count > 0;
}
