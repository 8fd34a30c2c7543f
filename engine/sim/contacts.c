/* Which pairs touch in the coming step, and how: one contact point a pair.
 *
 * No ghost hits. A marble that rolls over boxes side by side must not feel their edges. A body's nearest point matters
 * only if it is nearest on the union of all bodies near it: if it lies on another, convex body that is at least as
 * near, then the distance falls from it all the way to that body's own nearest point, so it is no edge of the union but
 * an inner one, and its contact is dropped. The same holds for what the sphere will touch later in the step, judged
 * where the sphere is then.
 *
 * Order. Contacts are sorted by the indices of their bodies, those between yielding bodies first: the solver ends with
 * what cannot give way. The tree's order never shows. */
#include "sim/internal.h"

#include <stdlib.h>
#include <string.h>

/* Bodies no farther apart than this share of the sphere's radius (but never more than MAX_MARGIN) get a contact even if
 * their plans do not meet: another contact may deflect one into the other. */
#define MARGIN     0.02
#define MAX_MARGIN 0.01
/* How near to a body's surface a point counts as on it: a share of the sphere's radius, and what rounding of its size
 * and rotation to floats may shift its surface by, as a share of its reach. */
#define ON_SURFACE       1e-3
#define SURFACE_ROUNDING 2e-7

typedef struct candidate {
    uint32_t body;
    daft_sim_touch touch;
} candidate;

typedef struct search {
    daft_world *world;
    float dt;
    uint32_t sphere;
    const daft_sim_body *body;
    double margin;
    candidate near[DAFT_SIM_MAX_FIXED_CONTACTS]; /* bodies that do not yield: what is touched first, first */
    int near_count;
    uint32_t
        partners[DAFT_SIM_MAX_PARTNERS]; /* yielding bodies whose pair counts for this sphere, lowest index first */
    int partner_count;
} search;

/* What touches now comes before what is touched later; then the nearer first; then by index. */
static bool comes_before(const candidate *a, const candidate *b)
{
    if (a->touch.time != b->touch.time) return a->touch.time < b->touch.time;
    if (a->touch.separation != b->touch.separation) return a->touch.separation < b->touch.separation;
    return a->body < b->body;
}

/* Keeps the first of the order. A body that hides another is before it, so none is dropped that would be needed. */
static void keep_near(search *s, const candidate *c)
{
    int i = s->near_count;
    if (i == DAFT_SIM_MAX_FIXED_CONTACTS) {
        if (!comes_before(c, &s->near[i - 1])) return;
        i--;
    } else {
        s->near_count++;
    }
    for (; i > 0 && comes_before(c, &s->near[i - 1]); i--) s->near[i] = s->near[i - 1];
    s->near[i] = *c;
}

/* How far a turning body's surface may move beside its centre's movement, near the sphere. */
static double swing(const search *s, const daft_sim_body *other, const daft_sim_motion *motion)
{
    daft_dvec3 d = daft_dsub(s->body->position, other->position);
    double arm = sqrt(daft_ddot(d, d));
    if (arm > (double)other->reach) arm = (double)other->reach;
    double angle = (double)daft_length(motion->angular) * (double)s->dt;
    return arm * (angle < 2 ? angle : 2);
}

static bool touches(const search *s, uint32_t other, daft_sim_touch *touch)
{
    const daft_sim_body *body = &s->world->bodies[other];
    const daft_sim_motion *motions = s->world->motions;
    double margin = s->margin;
    if (body->kind == DAFT_BODY_KINEMATIC) margin += swing(s, body, &motions[other]);
    daft_dvec3 plan = daft_to_double(daft_sub(motions[s->sphere].planned, motions[other].planned));
    return daft_sim_touch_sphere(body, s->body->position, (double)s->body->radius, plan, margin, touch);
}

static void visit_fixed(void *context, uint32_t index)
{
    search *s = context;
    candidate c = {.body = index};
    if (daft_sim_overlap(&s->world->bodies[index].bounds, &s->body->bounds) && touches(s, index, &c.touch))
        keep_near(s, &c);
}

/* The pair counts for the smaller sphere, or the one of lower index where they are equal. */
static bool counts_here(const search *s, uint32_t other)
{
    float mine = s->body->radius, theirs = s->world->bodies[other].radius;
    return mine < theirs || (mine == theirs && s->sphere < other);
}

static bool is_partner(const search *s, uint32_t other)
{
    return counts_here(s, other) && daft_sim_overlap(&s->world->bodies[other].bounds, &s->body->bounds);
}

/* Keeps the partners of lowest index. */
static void visit_dynamic(void *context, uint32_t index)
{
    search *s = context;
    bool full = s->partner_count == DAFT_SIM_MAX_PARTNERS;
    if (full && index > s->partners[DAFT_SIM_MAX_PARTNERS - 1]) return;
    if (index == s->sphere || !is_partner(s, index)) return;
    int i = full ? DAFT_SIM_MAX_PARTNERS - 1 : s->partner_count++;
    for (; i > 0 && index < s->partners[i - 1]; i--) s->partners[i] = s->partners[i - 1];
    s->partners[i] = index;
}

/* Thousands of bodies in one spot would each visit all the others to find as many partners as it may have. They were
 * most likely made one after the other: if enough of the bodies that follow are partners, they are taken, and none is
 * searched for. Elsewhere the bodies that follow miss at once. */
static bool crowded(search *s)
{
    const daft_world *world = s->world;
    int misses = 0;
    for (uint32_t i = s->sphere + 1; i < world->body_count && misses < 8 + 4 * s->partner_count; i++) {
        if (world->bodies[i].kind == DAFT_BODY_DYNAMIC && is_partner(s, i))
            s->partners[s->partner_count++] = i;
        else
            misses++;
        if (s->partner_count == DAFT_SIM_MAX_PARTNERS) return true;
    }
    s->partner_count = 0;
    return false;
}

/* How near to its surface a point counts as on it. */
static double surface_margin(const search *s, const daft_sim_body *body)
{
    return ON_SURFACE * (double)s->body->radius + SURFACE_ROUNDING * (double)body->reach;
}

/* Does candidate c's point lie on another body that the sphere meets no later? */
static bool hidden(const search *s, int c)
{
    const candidate *mine = &s->near[c];
    for (int i = 0; i < c; i++) {
        const daft_sim_body *other = &s->world->bodies[s->near[i].body];
        daft_dvec3 point, normal;
        if (daft_sim_distance(other, mine->touch.point, &point, &normal) <= surface_margin(s, other)) return true;
    }
    return false;
}

typedef struct probe {
    const daft_world *world;
    daft_dvec3 at;
    double margin;
    bool hit;
} probe;

static void visit_probe(void *context, uint32_t index)
{
    probe *p = context;
    daft_dvec3 point, normal;
    p->hit = p->hit || daft_sim_distance(&p->world->bodies[index], p->at, &point, &normal) <= p->margin;
}

/* Is a point inside some body that does not yield, or on it? */
static bool walled_up(const daft_world *world, daft_dvec3 at, double margin)
{
    probe p = {world, at, margin, false};
    daft_dvec3 reach = daft_dv3(margin, margin, margin);
    daft_sim_bounds bounds = {daft_dsub(at, reach), daft_dadd(at, reach)};
    daft_sim_tree_query(&world->trees[DAFT_BODY_STATIC], &bounds, visit_probe, &p);
    daft_sim_tree_query(&world->trees[DAFT_BODY_KINEMATIC], &bounds, visit_probe, &p);
    return p.hit;
}

/* A sphere whose centre is inside a body leaves it by the nearest face, but not through one that leads into a
 * neighbour: it would be sent to and fro between the two. */
static void find_way_out(const search *s, candidate *c)
{
    const daft_sim_body *body = &s->world->bodies[c->body];
    daft_dvec3 point, normal;
    double distance, best = -INFINITY, margin = surface_margin(s, body);
    for (int face = 0; daft_sim_exit(body, s->body->position, face, &point, &normal, &distance); face++) {
        if (distance <= best) continue;
        if (walled_up(s->world, daft_dadd(point, daft_dscale(normal, 2 * margin)), margin)) continue;
        best = distance;
        c->touch.point = point;
        c->touch.normal = daft_normalize(daft_to_float(normal));
        c->touch.separation = distance - (double)s->body->radius;
    }
}

/* ---- contact points ---- */

/* 1 / effective mass of the pair along a unit vector at its anchors. */
static float inverse_mass(const daft_sim_point *p, const daft_sim_motion *a, const daft_sim_motion *b, daft_vec3 along)
{
    daft_vec3 ra = daft_cross(p->anchor_a, along), rb = daft_cross(p->anchor_b, along);
    return a->inv_mass + b->inv_mass + a->inv_inertia * daft_dot(ra, ra) + b->inv_inertia * daft_dot(rb, rb);
}

static daft_vec3 any_perpendicular(daft_vec3 n)
{
    daft_vec3 axis = fabsf(n.x) < 0.6f ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0);
    return daft_normalize(daft_cross(n, axis));
}

/* The speed at which the pair meets: its speed now and what gravity and forces add until the surfaces touch. */
static float meeting_speed(const daft_sim_point *p, const daft_sim_motion *a, const daft_sim_motion *b)
{
    daft_vec3 turning = daft_sub(daft_cross(b->angular, p->anchor_b), daft_cross(a->angular, p->anchor_a));
    float speed = daft_dot(p->normal, daft_add(daft_sub(b->linear, a->linear), turning));
    float acceleration = daft_dot(p->normal, daft_sub(b->acceleration, a->acceleration));
    float square = speed * speed - 2 * acceleration * p->separation;
    return speed < 0 && square > 0 ? sqrtf(square) : 0;
}

static void set_materials(daft_sim_point *p, const daft_sim_body *a, const daft_sim_body *b)
{
    p->friction = sqrtf(a->friction * b->friction);
    p->restitution = a->restitution > b->restitution ? a->restitution : b->restitution;
    float rolling = a->rolling_resistance > b->rolling_resistance ? a->rolling_resistance : b->rolling_resistance;
    float radius = a->shape != DAFT_SHAPE_SPHERE                            ? b->radius
                   : b->shape != DAFT_SHAPE_SPHERE || a->radius < b->radius ? a->radius
                                                                            : b->radius;
    p->rolling = rolling * radius;
}

static void set_masses(daft_sim_point *p, const daft_sim_motion *a, const daft_sim_motion *b)
{
    p->held_mass = p->normal_mass = 1 / inverse_mass(p, a, b, p->normal);
    p->tangent_mass = 1 / inverse_mass(p, a, b, any_perpendicular(p->normal));
    p->rolling_mass = 1 / (a->inv_inertia + b->inv_inertia);
}

/* Spheres that share a centre part along a direction of their own, so that many in one spot leave it in all directions.
 */
static daft_vec3 parting(uint32_t a, uint32_t b)
{
    uint64_t h = (((uint64_t)a << 32 | b) + 1) * 0x9E3779B97F4A7C15u;
    h = (h ^ h >> 29) * 0xBF58476D1CE4E5B9u;
    daft_vec3 d = daft_v3((float)(h & 0xffff), (float)(h >> 16 & 0xffff), (float)(h >> 32 & 0xffff));
    return daft_normalize(daft_sub(daft_scale(d, 1.0f / 0x8000), daft_v3(0.99f, 0.99f, 0.99f)));
}

/* One side of a contact as seen from the sphere that searched (`sphere`) and the body it met. */
static void set_sides(daft_sim_point *p, const search *s, uint32_t other, const daft_sim_touch *touch)
{
    const daft_sim_body *body = &s->world->bodies[other];
    bool sphere_is_a = s->sphere < other;
    daft_vec3 sphere_anchor = daft_scale(touch->normal, -s->body->radius);
    daft_vec3 other_anchor = body->shape == DAFT_SHAPE_SPHERE ? daft_scale(touch->normal, body->radius)
                                                              : daft_to_float(daft_dsub(touch->point, body->position));
    daft_vec3 other_core = body->shape == DAFT_SHAPE_SPHERE ? daft_v3(0, 0, 0) : other_anchor;
    p->a = sphere_is_a ? s->sphere : other;
    p->b = sphere_is_a ? other : s->sphere;
    p->normal = sphere_is_a ? daft_neg(touch->normal) : touch->normal;
    p->anchor_a = sphere_is_a ? sphere_anchor : other_anchor;
    p->anchor_b = sphere_is_a ? other_anchor : sphere_anchor;
    p->core_a = sphere_is_a ? daft_v3(0, 0, 0) : other_core;
    p->core_b = sphere_is_a ? other_core : daft_v3(0, 0, 0);
}

static bool add_point(search *s, uint32_t other, daft_sim_touch *touch)
{
    daft_world *world = s->world;
    if (!daft_grow(&world->allocator, &world->points, &world->point_capacity, world->point_count + 1,
                   world->point_count, sizeof *world->points))
        return false;
    const daft_sim_body *body = &world->bodies[other];
    const daft_sim_motion *spin = &world->motions[other];
    daft_sim_point *p = &world->points[world->point_count++];
    *p = (daft_sim_point){.separation = (float)touch->separation, .fixed = body->kind != DAFT_BODY_DYNAMIC};
    p->turns = p->fixed && body->shape == DAFT_SHAPE_BOX &&
               (spin->angular.x != 0 || spin->angular.y != 0 || spin->angular.z != 0);
    set_sides(p, s, other, touch);
    p->key = (uint64_t)p->fixed << 63 | (uint64_t)p->a << 32 | p->b;
    set_materials(p, &world->bodies[p->a], &world->bodies[p->b]);
    set_masses(p, &world->motions[p->a], &world->motions[p->b]);
    p->approach = meeting_speed(p, &world->motions[p->a], &world->motions[p->b]);
    return true;
}

static bool search_sphere(search *s, uint32_t sphere)
{
    s->sphere = sphere;
    s->body = &s->world->bodies[sphere];
    s->near_count = s->partner_count = 0;
    s->margin = MARGIN * (double)s->body->radius;
    if (s->margin > MAX_MARGIN) s->margin = MAX_MARGIN;
    daft_sim_tree_query(&s->world->trees[DAFT_BODY_STATIC], &s->body->bounds, visit_fixed, s);
    daft_sim_tree_query(&s->world->trees[DAFT_BODY_KINEMATIC], &s->body->bounds, visit_fixed, s);
    if (!crowded(s)) daft_sim_tree_query(&s->world->trees[DAFT_BODY_DYNAMIC], &s->body->bounds, visit_dynamic, s);
    for (int i = 0; i < s->near_count; i++) {
        const daft_sim_touch *touch = &s->near[i].touch;
        if (touch->time == 0 && touch->separation <= -(double)s->body->radius) find_way_out(s, &s->near[i]);
    }
    for (int i = 0; i < s->near_count; i++)
        if (!hidden(s, i) && !add_point(s, s->near[i].body, &s->near[i].touch)) return false;
    for (int i = 0; i < s->partner_count; i++) {
        daft_sim_touch touch;
        if (!touches(s, s->partners[i], &touch)) continue;
        daft_dvec3 apart = daft_dsub(touch.centre, s->world->bodies[s->partners[i]].position);
        if (daft_ddot(apart, apart) == 0) touch.normal = parting(sphere, s->partners[i]);
        if (!add_point(s, s->partners[i], &touch)) return false;
    }
    return true;
}

/* ---- impulses kept from the last step ---- */

static int by_key(const void *a, const void *b)
{
    uint64_t x = ((const daft_sim_point *)a)->key, y = ((const daft_sim_point *)b)->key;
    return (x > y) - (x < y);
}

/* The tangent plane may have turned since: what friction held is projected onto the new one. */
static void inherit(daft_sim_point *p, const daft_sim_point *old)
{
    p->normal_impulse = old->normal_impulse;
    p->rolling_impulse = old->rolling_impulse;
    p->friction_impulse =
        daft_sub(old->friction_impulse, daft_scale(p->normal, daft_dot(old->friction_impulse, p->normal)));
}

/* Both arrays are in the order of keys. */
static void inherit_impulses(daft_world *world)
{
    size_t old = 0;
    for (size_t i = 0; i < world->point_count; i++) {
        daft_sim_point *p = &world->points[i];
        while (old < world->old_count && world->old_points[old].key < p->key) old++;
        if (old == world->old_count) return;
        if (world->old_points[old].key == p->key && !world->bodies[p->a].fresh && !world->bodies[p->b].fresh)
            inherit(p, &world->old_points[old]);
    }
}

bool daft_sim_find_contacts(daft_world *world, float dt)
{
    search s = {.world = world, .dt = dt};
    world->point_count = 0;
    for (size_t i = 0; i < world->dynamics.count; i++)
        if (!search_sphere(&s, world->dynamics.items[i])) return false;
    if (world->point_count == 0) return true;
    qsort(world->points, world->point_count, sizeof *world->points,
          by_key); /* keys differ: the order is theirs alone */
    inherit_impulses(world);
    return true;
}
