/* The mover: see mover.h. Planes come from manifolds, which know what lies across the edges of a mesh, so that nothing
 * trips over seams; the nearest place that all planes allow is found by projected Gauss-Seidel on their pushes (Catto,
 * Box2D v3.1, b2SolvePlanes); casts see to it that nothing is passed on the way that no plane told of. */
#include "sim/character/mover.h"

#include "sim/collide/manifold.h"

enum { SLIDES = 8, PASSES = 32, MANIFOLDS = 24 };

/* Casts end this near to the gap, as a fraction of it. */
#define TOLERANCE 0.02
/* What is nearer than the gap at the start of a cast cannot stop it. So one by a capsule that is so much thinner that
 * nothing is too near follows, by these shares of the gap (more than the tolerance, lest what is beside it counts as
 * met); but no thinner than the last share of the radius. */
#define NEAR    1.03
#define THINNER 1.05
#define NEEDLE  0.02

bool daft_mover_walkable(const daft_mover *m, daft_dvec3 normal) { return normal.y >= m->max_slope; }

static daft_rigid capsule_frame(const daft_mover *m)
{
    daft_rigid frame = daft_rigid_identity();
    frame.p = m->position;
    return frame;
}

/* ---- planes ---- */

static bool is_before(const daft_mover_plane *a, const daft_mover_plane *b)
{
    return a->part != b->part ? a->part < b->part : a->number < b->number;
}

/* Keeps the deepest; of equally deep ones the first in order. */
static void keep_plane(daft_mover *m, const daft_mover_plane *plane)
{
    if (m->count == DAFT_MOVER_PLANES) {
        uint32_t least = 0;
        for (uint32_t i = 1; i < m->count; i++)
            if (m->planes[i].separation >= m->planes[least].separation) least = i;
        const daft_mover_plane *out = &m->planes[least];
        if (plane->separation > out->separation || (plane->separation >= out->separation && !is_before(plane, out)))
            return;
        m->count--;
        for (uint32_t i = least; i < m->count; i++) m->planes[i] = m->planes[i + 1];
    }
    uint32_t at = m->count++;
    for (; at > 0 && is_before(plane, &m->planes[at - 1]); at--) m->planes[at] = m->planes[at - 1];
    m->planes[at] = *plane;
}

/* Whether a part's surface can be approached from both sides. Then no plane counts that the capsule's core is beyond:
 * it is a back side, and casts have seen to it that the core is still on the side it came from. */
static bool is_sheet(const daft_sim_shape *shape, uint32_t child)
{
    if (shape->type == DAFT_GEOMETRY_COMPOUND) shape = &shape->compound->children[child].shape;
    return shape->type == DAFT_GEOMETRY_MESH && !shape->mesh->one_sided;
}

static void visit_planes(void *context, uint32_t index)
{
    daft_mover *m = context;
    const daft_sim_part *part = &m->world->parts[index];
    daft_manifold manifolds[MANIFOLDS];
    if (part->body + 1 == m->skip) return;
    daft_rigid a = capsule_frame(m), b = daft_sim_part_frame(&m->world->bodies[part->body], part);
    daft_relpose pose = daft_relpose_make(&a, &b);
    uint32_t count = daft_collide(&m->capsule, &part->shape, &pose, (float)(2 * m->skin), manifolds, MANIFOLDS, NULL);
    for (uint32_t i = 0; i < count; i++) {
        const daft_manifold *from = &manifolds[i];
        uint32_t deepest = 0;
        for (uint32_t k = 1; k < from->count; k++)
            if (from->points[k].separation < from->points[deepest].separation) deepest = k;
        daft_dvec3 n = daft_to_double(daft_neg(from->normal));
        double length = sqrt(daft_ddot(n, n));
        if (!(length > 0.5)) continue;
        if (from->points[deepest].separation < -m->capsule.radius && is_sheet(&part->shape, from->part_b.child))
            continue;
        daft_mover_plane plane = {.normal = daft_dscale(n, 1 / length),
                                  .separation = (double)from->points[deepest].separation,
                                  .point = daft_to_double(from->points[deepest].point),
                                  .part = index,
                                  .number = i};
        keep_plane(m, &plane);
    }
}

static bool is_at(const daft_mover *m, daft_dvec3 p)
{
    return m->position.x == p.x && m->position.y == p.y && m->position.z == p.z;
}

void daft_mover_collect(daft_mover *m)
{
    if (m->collected && is_at(m, m->collected_at)) return;
    daft_rigid frame = capsule_frame(m);
    daft_sim_path path = daft_sim_path_of(&m->capsule, &frame, daft_dv3(0, 0, 0));
    path.reach = daft_dadd(path.reach, daft_dv3(2 * m->skin, 2 * m->skin, 2 * m->skin));
    m->count = 0;
    daft_sim_walk(m->world, &path, &m->filter, visit_planes, m);
    m->collected = true;
    m->collected_at = m->position;
}

/* A half-space: normal·x >= offset. */
typedef struct limit {
    daft_dvec3 normal;
    double offset, push;
} limit;

/* For one that walks, what it cannot walk on is upright, but for a ceiling that is about level. */
static limit limit_of(const daft_mover *m, const daft_mover_plane *p, double clear)
{
    limit l = {p->normal, clear - p->separation, 0};
    double level = sqrt(p->normal.x * p->normal.x + p->normal.z * p->normal.z);
    if (!m->walking || daft_mover_walkable(m, p->normal) || level < 0.1) return l;
    l.normal = daft_dv3(p->normal.x / level, 0, p->normal.z / level);
    l.offset /= level;
    return l;
}

/* The point nearest to `wish` that all limits allow, or nearly: pushes are summed in turns. */
static daft_dvec3 solve(limit *limits, uint32_t count, daft_dvec3 wish, double enough)
{
    for (uint32_t pass = 0; pass < PASSES; pass++) {
        double most = 0;
        for (uint32_t i = 0; i < count; i++) {
            limit *l = &limits[i];
            double push = l->push + l->offset - daft_ddot(l->normal, wish);
            if (push < 0) push = 0;
            wish = daft_dadd(wish, daft_dscale(l->normal, push - l->push));
            most = fmax(most, fabs(push - l->push));
            l->push = push;
        }
        if (most <= enough) break;
    }
    return wish;
}

daft_dvec3 daft_mover_speed(const daft_mover *m, const daft_mover_plane *plane)
{
    const daft_sim_body *body = &m->world->bodies[m->world->parts[plane->part].body];
    daft_dvec3 arm = daft_dsub(daft_dadd(m->position, plane->point), body->centre);
    return daft_dadd(daft_to_double(body->linear), daft_dcross(daft_to_double(body->angular), arm));
}

daft_dvec3 daft_mover_clip(const daft_mover *m, daft_dvec3 velocity, daft_dvec3 frame)
{
    limit limits[DAFT_MOVER_PLANES];
    for (uint32_t i = 0; i < m->count; i++) {
        const daft_mover_plane *p = &m->planes[i];
        daft_body_kind kind = m->world->bodies[m->world->parts[p->part].body].kind;
        limits[i] = limit_of(m, p, 0);
        double speed = daft_ddot(limits[i].normal, daft_dsub(daft_mover_speed(m, p), frame));
        limits[i].offset = kind == DAFT_BODY_DYNAMIC && speed > 0 ? 0 : speed;
    }
    return solve(limits, m->count, velocity, 1e-9);
}

/* ---- casts ---- */

typedef struct cast {
    daft_mover *mover;
    daft_sim_shape capsule;
    daft_sim_path path;
    daft_dvec3 motion, normal, point;
    double gap, met_gap, fraction;
    uint32_t part;
} cast;

/* The capsule is seen from the part: so no large shape is turned by a rounded rotation. */
static void visit_cast(void *context, uint32_t index)
{
    cast *c = context;
    const daft_world *world = c->mover->world;
    const daft_sim_part *part = &world->parts[index];
    const daft_sim_body *body = &world->bodies[part->body];
    if (part->body + 1 == c->mover->skip) return;
    daft_rigid frame = daft_sim_part_frame(body, part), origin = daft_rigid_identity();
    daft_quat turn = daft_quat_normalize(daft_quat_mul(body->rotation, part->turn));
    daft_quat back = {-turn.x, -turn.y, -turn.z, turn.w};
    daft_dvec3 from = daft_rigid_to_local(&frame, c->mover->position);
    daft_sweep moving = {from, daft_dadd(from, daft_rigid_to_local_vector(&frame, c->motion)), back, back, {0, 0, 0}};
    daft_sweep still = daft_sweep_still(&origin, daft_quat_identity());
    daft_impact impact;
    daft_impact_kind kind =
        daft_shape_impact(&c->capsule, &moving, &part->shape, &still, c->gap, TOLERANCE * c->gap, &impact);
    if (kind != DAFT_IMPACT_HIT && kind != DAFT_IMPACT_GAVE_UP) return;
    if (impact.t > c->fraction || (impact.t >= c->fraction && index >= c->part)) return;
    c->fraction = impact.t;
    c->met_gap = c->gap;
    c->part = index;
    c->normal = daft_dscale(daft_rigid_vector(&frame, impact.normal), -1);
    c->point = daft_rigid_point(&frame, impact.point);
    c->path.end = impact.t;
}

static void cast_once(cast *c)
{
    daft_mover *m = c->mover;
    daft_rigid frame = capsule_frame(m);
    c->path = daft_sim_path_of(&c->capsule, &frame, c->motion);
    c->path.reach = daft_dadd(c->path.reach, daft_dv3(2 * c->gap, 2 * c->gap, 2 * c->gap));
    c->path.end = c->fraction;
    daft_sim_walk(m->world, &c->path, &m->filter, visit_cast, c);
}

double daft_mover_cast(daft_mover *m, daft_dvec3 motion, double gap, daft_mover_plane *hit)
{
    cast c = {.mover = m, .capsule = m->capsule, .motion = motion, .gap = gap, .fraction = 1, .part = UINT32_MAX};
    daft_mover_collect(m);
    double least = INFINITY;
    for (uint32_t i = 0; i < m->count; i++) least = fmin(least, m->planes[i].separation);
    cast_once(&c);
    if (least < NEAR * c.gap) {
        double radius = (double)m->capsule.radius;
        c.capsule.radius = (float)fmax(radius + least - THINNER * c.gap, NEEDLE * radius);
        cast_once(&c);
    }
    if (hit && c.fraction < 1)
        *hit = (daft_mover_plane){
            .normal = c.normal,
            .separation = c.met_gap,
            .point = daft_dsub(c.point, daft_dadd(m->position, daft_dscale(motion, c.fraction))),
            .part = c.part,
        };
    return c.fraction;
}

/* ---- sliding ---- */

void daft_mover_slide(daft_mover *m, daft_dvec3 motion)
{
    limit limits[DAFT_MOVER_PLANES];
    daft_dvec3 goal = daft_dadd(m->position, motion);
    double enough = 1e-3 * m->skin;
    for (int i = 0; i < SLIDES; i++) {
        daft_mover_collect(m);
        for (uint32_t k = 0; k < m->count; k++) limits[k] = limit_of(m, &m->planes[k], DAFT_MOVER_CLEAR * m->skin);
        daft_dvec3 displacement = solve(limits, m->count, daft_dsub(goal, m->position), enough);
        if (daft_ddot(displacement, displacement) <= enough * enough) return;
        double fraction = daft_mover_cast(m, displacement, 0.5 * m->skin, NULL);
        m->position = daft_dadd(m->position, daft_dscale(displacement, fraction));
    }
    daft_mover_collect(m);
}
