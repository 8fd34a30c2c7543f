/* Contacts with edges that are none. A marble that rolls over boxes side by side must not feel their edges, nor a crate
 * that slides over them their sides. A contact with a body that does not yield counts only where it is on the surface
 * of the union of all such bodies: if all its points lie on another one that is met no later, it is on an inner wall,
 * and is dropped. Within one mesh the geometry sees to that itself.
 *
 * A ball whose centre is inside a box leaves it by the nearest face, but not through one that leads into a neighbour:
 * it would be sent to and fro between the two. */
#include "sim/world.h"
#include "sim/contact/contact.h"

/* How near to a body's surface a point counts as on it: a fraction of the moving part's size, and what rounding of its
 * size and rotation to floats may shift its surface by, as a fraction of its reach. */
#define ON_SURFACE       1e-3
#define CLIP_SLACK       6e-4 /* m: the clipping of manifolds leaves points outside a face by up to 0.5 mm */
#define SURFACE_ROUNDING 2e-7

enum {
    MAX_NEAR = 64
}; /* manifolds of one body with what does not yield; of more, those past it are left as they are */

typedef struct candidate {
    daft_sim_pair *pair;
    daft_sim_manifold *manifold;
    float separation; /* least of its points */
} candidate;

typedef struct group {
    const daft_world *world;
    candidate near[MAX_NEAR]; /* what is met first, first */
    int count;
    float dt;
} group;

/* Whether it will be met later in the step only. */
static bool is_ahead(const daft_sim_manifold *manifold) { return !daft_sim_is_zero(manifold->shift); }

static bool comes_before(const candidate *a, const candidate *b)
{
    if (a->separation != b->separation) return a->separation < b->separation;
    if (a->pair->part_b != b->pair->part_b) return a->pair->part_b < b->pair->part_b;
    if (a->pair->part_a != b->pair->part_a) return a->pair->part_a < b->pair->part_a;
    return a->manifold < b->manifold;
}

static void keep(group *g, daft_sim_pair *pair, daft_sim_manifold *manifold)
{
    candidate c = {pair, manifold, INFINITY};
    for (uint32_t i = 0; i < manifold->count; i++)
        c.separation = daft_sim_min(c.separation, manifold->points[i].separation);
    if (g->count == MAX_NEAR) return;
    int i = g->count++;
    for (; i > 0 && comes_before(&c, &g->near[i - 1]); i--) g->near[i] = g->near[i - 1];
    g->near[i] = c;
}

static double margin_on(const group *g, const candidate *mine, const daft_sim_part *other)
{
    const daft_sim_part *part = &g->world->parts[mine->pair->part_a];
    return CLIP_SLACK + ON_SURFACE * (double)part->reach + SURFACE_ROUNDING * (double)other->reach;
}

static bool lies_on(const group *g, uint32_t index, daft_dvec3 at, double margin)
{
    const daft_sim_part *part = &g->world->parts[index];
    daft_rigid frame = daft_sim_part_frame(&g->world->bodies[part->body], part);
    daft_dvec3 nearest;
    double distance;
    daft_shape_part where;
    return daft_shape_closest(&part->shape, daft_rigid_to_local(&frame, at), margin, &nearest, &distance, &where) &&
           distance <= margin;
}

/* A contact's point on the surface of body b. */
static daft_dvec3 point_on_b(const group *g, const candidate *c, uint32_t i)
{
    const daft_sim_manifold_point *p = &c->manifold->points[i];
    float gap = p->separation - daft_dot(c->manifold->shift, c->manifold->normal);
    daft_vec3 at = daft_add(p->anchor, daft_scale(c->manifold->normal, 0.5f * gap));
    return daft_dadd(g->world->bodies[c->pair->body_a].centre, daft_to_double(daft_add(at, c->manifold->shift)));
}

typedef struct probe {
    const group *g;
    daft_dvec3 at;
    double margin;
    bool hit;
} probe;

static void visit_probe(void *context, uint32_t part)
{
    probe *p = context;
    p->hit = p->hit || (!p->g->world->parts[part].sensor && lies_on(p->g, part, p->at, p->margin));
}

/* Is a point inside some body that does not yield, or on it? */
static bool walled_up(const group *g, daft_dvec3 at, double margin)
{
    probe p = {g, at, margin, false};
    daft_dvec3 reach = daft_dv3(margin, margin, margin);
    daft_sim_bounds bounds = {daft_dsub(at, reach), daft_dadd(at, reach)};
    daft_sim_tree_query(&g->world->trees[DAFT_BODY_STATIC], &bounds, visit_probe, &p);
    daft_sim_tree_query(&g->world->trees[DAFT_BODY_KINEMATIC], &bounds, visit_probe, &p);
    return p.hit;
}

/* Met no later, but for what the choice of a contact's axis holds for even (DAFT_BOX_EVEN): the corner of a tile that
 * is just reached may be met by the side of what slides, deeper than by its face. */
static bool may_hide(const group *g, const candidate *other, const candidate *mine)
{
    float even = (float)ON_SURFACE * g->world->parts[mine->pair->part_a].reach;
    return other->pair != mine->pair && other->manifold->count > 0 && other->separation <= mine->separation + even;
}

static bool is_hidden(const group *g, int c)
{
    const candidate *mine = &g->near[c];
    for (uint32_t i = 0; i < mine->manifold->count; i++) {
        daft_dvec3 at = point_on_b(g, mine, i);
        bool found = false;
        for (int k = 0; k < g->count && !found; k++) {
            const candidate *other = &g->near[k];
            if (!may_hide(g, other, mine)) continue;
            const daft_sim_part *part = &g->world->parts[other->pair->part_b];
            found = lies_on(g, other->pair->part_b, at, margin_on(g, mine, part));
        }
        if (!found) return false;
    }
    return true;
}

/* ---- directions out ---- */

/* Depth of a local point under one of a box's six faces, the outward normal there: high and low in y, then x, then z.
 */
static double face_of(daft_dvec3 p, daft_dvec3 h, int face, daft_dvec3 *normal)
{
    double sign = face & 1 ? -1 : 1;
    int axis = face >> 1;
    *normal = daft_dv3(axis == 1 ? sign : 0, axis == 0 ? sign : 0, axis == 2 ? sign : 0);
    return axis == 0 ? h.y - sign * p.y : axis == 1 ? h.x - sign * p.x : h.z - sign * p.z;
}

static void find_way_out(const group *g, candidate *c)
{
    const daft_sim_part *a = &g->world->parts[c->pair->part_a], *b = &g->world->parts[c->pair->part_b];
    if (a->shape.type != DAFT_GEOMETRY_SPHERE || b->shape.type != DAFT_GEOMETRY_BOX) return;
    const daft_sim_body *body = &g->world->bodies[c->pair->body_a];
    daft_rigid frame = daft_sim_part_frame(&g->world->bodies[b->body], b);
    daft_rigid mine = daft_sim_part_frame(body, a);
    daft_dvec3 local = daft_rigid_to_local(&frame, mine.p), h = daft_to_double(b->shape.half);
    double best = INFINITY, margin = margin_on(g, c, b);
    for (int face = 0; face < 6; face++) {
        daft_dvec3 normal;
        double depth = face_of(local, h, face, &normal);
        if (depth < 0 || depth >= best) continue;
        daft_dvec3 out = daft_rigid_vector(&frame, normal);
        daft_dvec3 exit = daft_dadd(mine.p, daft_dscale(out, depth + 2 * margin));
        if (walled_up(g, exit, margin)) continue;
        best = depth;
        c->separation = -(float)depth - a->shape.radius;
        c->manifold->normal = daft_neg(daft_normalize(daft_to_float(out)));
        c->manifold->points[0].separation = c->separation;
        c->manifold->points[0].anchor = daft_to_float(daft_dsub(mine.p, body->centre));
        c->manifold->points[0].anchor = daft_add(
            c->manifold->points[0].anchor, daft_scale(c->manifold->normal, 0.5f * (a->shape.radius - (float)depth)));
    }
}

/* ---- thin walls ---- */

/* How far a contact's surface is from the middle of the part, towards the surface; below 0: the middle is behind it. */
static float in_front(const group *g, const candidate *c)
{
    const daft_sim_part *part = &g->world->parts[c->pair->part_a];
    daft_rigid frame = daft_sim_part_frame(&g->world->bodies[c->pair->body_a], part);
    daft_dvec3 offset = daft_dsub(point_on_b(g, c, 0), daft_rigid_point(&frame, daft_to_double(part->middle)));
    return daft_dot(daft_to_float(offset), c->manifold->normal);
}

/* A face of a one-sided mesh pushes what is behind it to its front, however deep it is: through a wall that is thinner
 * than the body, if the body's middle is before the wall's other face. */
static bool is_behind(const group *g, int c)
{
    const candidate *mine = &g->near[c];
    if (g->world->parts[mine->pair->part_b].shape.type != DAFT_GEOMETRY_MESH || in_front(g, mine) >= 0) return false;
    for (int k = 0; k < g->count; k++)
        if (daft_dot(mine->manifold->normal, g->near[k].manifold->normal) < -0.5f && g->near[k].manifold->count > 0 &&
            in_front(g, &g->near[k]) > 0)
            return true;
    return false;
}

/* ---- what is only passed ---- */

#define UPRIGHT 0.9999f

/* Gap at which a body that is swept along what it rests on meets something, as a fraction of how far it is lifted for
 * that. */
#define PASSING_GAP 0.25
/* What turns farther in a step, in radians, may touch at a place that its planned path does not have. */
#define PASSING_TURN 1.0f

/* Where a part goes within the step: to `bend`, and from there along what it meets. */
typedef struct course {
    daft_sweep path;            /* as planned */
    daft_dvec3 bend, end, lift; /* of the centre of mass; lift: away from what it goes along then */
    double bend_at;             /* fraction of the step; 1: it meets nothing before */
} course;

/* Fraction of the step after which a moving part meets the plane of a contact; above 1: not in this step. */
static double meeting_at(const candidate *c, daft_dvec3 move)
{
    double into = daft_ddot(move, daft_to_double(c->manifold->normal)), gap = fmax(0, (double)c->separation);
    return into > gap ? gap / into : 2;
}

/* The contact that bends the path before c does, and how. What the part touches already comes first. */
static course course_of(const group *g, int c, double margin)
{
    const candidate *mine = &g->near[c];
    const daft_sim_part *part = &g->world->parts[mine->pair->part_a];
    course out = {.path = daft_sim_plan(g->world, &g->world->bodies[part->body], part, g->dt), .bend_at = 1};
    daft_dvec3 move = daft_dsub(out.path.to, out.path.from), along = move;
    double mine_at = meeting_at(mine, move);
    for (int k = 0; k < g->count; k++) {
        const candidate *on = &g->near[k];
        if (k == c || on->manifold->count == 0 || on->pair->part_a != mine->pair->part_a) continue;
        double at = (double)on->separation <= margin ? 0 : meeting_at(on, move);
        if (at >= mine_at || at > out.bend_at || (at == out.bend_at && at > 0)) continue;
        daft_dvec3 n = daft_to_double(on->manifold->normal);
        if (at < out.bend_at) along = move, out.lift = daft_dv3(0, 0, 0);
        out.bend_at = at;
        along = daft_dsub(along, daft_dscale(n, fmax(0, daft_ddot(along, n))));
        out.lift = daft_dsub(out.lift, daft_dscale(n, margin + fmax(0, -(double)on->separation)));
    }
    out.bend = daft_dadd(out.path.from, daft_dscale(move, out.bend_at));
    out.end = daft_dadd(out.bend, daft_dscale(along, 1 - out.bend_at));
    return out;
}

/* The contact of a ball becomes that of where it will be met. went: how far the ball goes against the other until then.
 */
static void turn_to_meeting(const group *g, candidate *c, const daft_impact *impact, daft_dvec3 went)
{
    const daft_sim_part *part = &g->world->parts[c->pair->part_a];
    const daft_sim_body *body = &g->world->bodies[part->body];
    daft_rigid frame = daft_sim_part_frame(body, part);
    daft_vec3 n = daft_to_float(impact->normal), offset = daft_to_float(daft_dsub(frame.p, body->centre));
    if (c->manifold->count != 1 || daft_dot(n, c->manifold->normal) > UPRIGHT) return;
    c->manifold->normal = n;
    c->manifold->shift = daft_to_float(went);
    c->manifold->points[0].anchor = daft_add(offset, daft_scale(n, part->shape.radius));
    c->manifold->points[0].separation = daft_sim_max(0, daft_dot(c->manifold->shift, n));
}

/* A contact that is ahead pushes along the normal of now, or of where the two meet. Where a body goes past an edge, or
 * rolls towards one that is level with what it rests on, that normal leans, and it would be thrown up by what it grazes
 * at most. So what is ahead counts only if the body meets it on its path: as far as what it meets first, and then along
 * that, lifted by as much as counts as touching. */
static bool is_passed(const group *g, candidate *mine, int c)
{
    const daft_sim_part *a = &g->world->parts[mine->pair->part_a], *b = &g->world->parts[mine->pair->part_b];
    double margin = margin_on(g, mine, b), gap = PASSING_GAP * margin;
    bool wild =
        daft_length(g->world->bodies[a->body].angular) * g->dt > PASSING_TURN && a->shape.type != DAFT_GEOMETRY_SPHERE;
    if (wild || (double)mine->separation <= gap) return false;
    course go = course_of(g, c, margin);
    daft_dvec3 move = daft_dsub(go.path.to, go.path.from);
    if (daft_ddot(move, move) < 2 * margin * (double)a->inner)
        return false; /* too short a path for the normal to turn much */
    daft_sweep its = daft_sim_plan(g->world, &g->world->bodies[b->body], b, g->dt), path = go.path;
    daft_impact_kind met = DAFT_IMPACT_MISS;
    daft_impact impact = {.t = 0};
    path.to = go.bend;
    if (go.bend_at > 0) met = daft_shape_impact(&a->shape, &path, &b->shape, &its, gap, gap, &impact);
    daft_dvec3 went = daft_dscale(daft_dsub(path.to, path.from), impact.t);
    if (met == DAFT_IMPACT_MISS && go.bend_at < 1) {
        path.from = daft_dadd(go.bend, go.lift), path.to = daft_dadd(go.end, go.lift);
        met = daft_shape_impact(&a->shape, &path, &b->shape, &its, gap, gap, &impact);
        went = daft_dadd(daft_dsub(go.bend, go.path.from), daft_dscale(daft_dsub(path.to, path.from), impact.t));
    }
    if (met == DAFT_IMPACT_HIT && a->shape.type == DAFT_GEOMETRY_SPHERE &&
        g->world->bodies[b->body].kind == DAFT_BODY_STATIC)
        turn_to_meeting(g, mine, &impact, went);
    return met == DAFT_IMPACT_MISS;
}

/* ---- floors of many pieces ---- */

#define LEVEL 5e-3f /* m */

/* What slides over several pieces of one floor is braked by each at the middle of what it touches of it, and would be
 * turned by that; on one piece it would not. */
static bool is_one_floor(const group *g)
{
    const candidate *first = NULL;
    int manifolds = 0;
    for (int i = 0; i < g->count; i++) {
        const candidate *c = &g->near[i];
        if (c->manifold->count == 0) continue;
        if (!first) first = c;
        const daft_vec3 n = first->manifold->normal,
                        apart = daft_sub(c->manifold->points[0].anchor, first->manifold->points[0].anchor);
        bool still = g->world->bodies[c->pair->body_b].kind == DAFT_BODY_STATIC && !c->pair->surface_moves;
        if (!still || is_ahead(c->manifold) || c->pair->friction != first->pair->friction ||
            daft_dot(c->manifold->normal, n) < UPRIGHT || fabsf(daft_dot(apart, n)) > LEVEL)
            return false;
        manifolds++;
    }
    return manifolds > 1;
}

/* ---- all of them ---- */

static void drop(candidate *c) { c->manifold->count = 0; }

static void squeeze(daft_sim_pair *pair)
{
    daft_sim_manifold *manifolds = daft_sim_manifolds(pair);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < pair->manifold_count; i++)
        if (manifolds[i].count > 0) {
            if (kept != i) manifolds[kept] = manifolds[i];
            kept++;
        }
    pair->manifold_count = kept;
}

static bool is_fixed(const daft_world *world, const daft_sim_pair *pair)
{
    return pair->manifold_count > 0 && !pair->sensor && world->bodies[pair->body_b].kind != DAFT_BODY_DYNAMIC;
}

static void filter_body(daft_world *world, uint32_t index, float dt)
{
    group g = {.world = world, .dt = dt};
    for (uint32_t e = world->bodies[index].first_pair; e != DAFT_SIM_NONE; e = world->pairs[e >> 1].next[e & 1]) {
        daft_sim_pair *pair = &world->pairs[e >> 1];
        if (e & 1 || !is_fixed(world, pair)) continue;
        for (uint32_t i = 0; i < pair->manifold_count; i++) keep(&g, pair, &daft_sim_manifolds(pair)[i]);
    }
    for (int i = 0; i < g.count; i++)
        if (g.near[i].separation <= -world->parts[g.near[i].pair->part_a].inner) find_way_out(&g, &g.near[i]);
    for (int i = g.count - 1; i >= 0; i--)
        if (is_hidden(&g, i)) drop(&g.near[i]);
    for (int i = g.count - 1; i >= 0; i--)
        if (g.near[i].manifold->count > 0 && is_behind(&g, i)) drop(&g.near[i]);
    for (int i = g.count - 1; i >= 0; i--)
        if (g.near[i].manifold->count > 0 && is_passed(&g, &g.near[i], i)) drop(&g.near[i]);
    if (is_one_floor(&g))
        for (int i = 0; i < g.count; i++) g.near[i].manifold->shared = true;
    for (int i = 0; i < g.count; i++) squeeze(g.near[i].pair);
}

enum { GRAIN = 4, PARALLEL_BODIES = 32 };

typedef struct job {
    daft_world *world;
    float dt;
} job;

static void filter_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const job *j = context;
    daft_world *world = j->world;
    size_t first = (size_t)index * GRAIN, end = first + GRAIN;
    if (end > world->scratch.ghosts.count) end = world->scratch.ghosts.count;
    for (size_t i = first; i < end; i++) filter_body(world, world->scratch.ghosts.items[i], j->dt);
}

/* So deep in a mesh that it may be pushed to both sides of a wall: it counts as two. */
static bool is_deep(const daft_world *world, daft_sim_pair *pair)
{
    if (world->parts[pair->part_b].shape.type != DAFT_GEOMETRY_MESH) return false;
    const daft_sim_manifold *manifolds = daft_sim_manifolds(pair);
    float deep = -0.5f * world->parts[pair->part_a].inner;
    for (uint32_t i = 0; i < pair->manifold_count; i++)
        for (uint32_t k = 0; k < manifolds[i].count; k++)
            if (manifolds[i].points[k].separation < deep) return true;
    return false;
}

#define FILTERED UINT32_MAX /* as a body's fixed_pairs */

/* A contact is a ghost beside another one only, and the way out matters for balls only. The bodies that this may be
 * about, of those that overlap what does not yield. */
static void find_doubtful(daft_world *world)
{
    daft_sim_list *list = &world->scratch.ghosts;
    size_t bodies = 0, doubtful = 0;
    for (size_t i = 0; i < world->active.count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (!(entry->flags & DAFT_SIM_FIXED)) continue;
        daft_sim_body *body = &world->bodies[entry->body_a];
        if (body->asleep) continue;
        if (body->fixed_pairs == 0) list->items[bodies++] = entry->body_a;
        body->fixed_pairs += body->ball || (entry->manifolds > 1 && is_deep(world, &world->pairs[entry->pair])) ? 2 : 1;
    }
    for (size_t i = 0; i < bodies; i++) {
        daft_sim_body *body = &world->bodies[list->items[i]];
        bool keep = body->fixed_pairs > 1;
        body->fixed_pairs = keep ? FILTERED : 0;
        if (keep) list->items[doubtful++] = list->items[i];
    }
    list->count = doubtful;
}

static void refresh_filtered(daft_world *world)
{
    for (size_t i = 0; i < world->active.count; i++) {
        daft_sim_active *entry = &world->active.items[i];
        if (entry->flags & DAFT_SIM_FIXED && world->bodies[entry->body_a].fixed_pairs == FILTERED)
            daft_sim_active_refresh(world, entry);
    }
}

bool daft_sim_ghosts_drop(daft_world *world, float dt)
{
    daft_sim_list *bodies = &world->scratch.ghosts;
    if (!daft_grow(&world->allocator, &bodies->items, &bodies->capacity, world->awake.count, 0, sizeof *bodies->items))
        return false;
    find_doubtful(world);
    if (bodies->count == 0) return true;
    job j = {world, dt};
    uint32_t tasks = (uint32_t)((bodies->count + GRAIN - 1) / GRAIN);
    daft_sim_for(world, bodies->count >= PARALLEL_BODIES, tasks, filter_range, &j);
    refresh_filtered(world);
    for (size_t i = 0; i < bodies->count; i++) world->bodies[bodies->items[i]].fixed_pairs = 0;
    return true;
}
