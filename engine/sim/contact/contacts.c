/* What the pairs of a step are like: manifolds from geometry, and what they keep from the step before.
 *
 * Margins. Two parts get contact points while still apart, as far as they may close in within the step; the solver
 * lets them close the gap and no more. A point that they will not reach is left out, so that nothing trips over an
 * edge it only passes. */
#include "sim/contact/persistence.h"
#include "sim/contact/contact.h"
#include "sim/collide/manifold_box.h"

#include <string.h>

/* Of a movement within a step, as much as this fraction of the part's reach is met by wider margins; farther is swept.
 */
#define MARGIN_OF_MOVE DAFT_ROUND_FAST

/* ---- materials ---- */

static float static_friction(const daft_sim_material *m) { return daft_sim_max(m->friction, m->static_friction); }

static float rolling_radius(const daft_sim_part *a, const daft_sim_part *b)
{
    if (a->round != b->round) return a->round ? a->roll : b->roll;
    return daft_sim_min(a->roll, b->roll);
}

void daft_sim_pair_materials(const daft_world *world, daft_sim_pair *pair)
{
    const daft_sim_part *a = &world->parts[pair->part_a], *b = &world->parts[pair->part_b];
    const daft_sim_material *x = &a->material, *y = &b->material;
    daft_sim_material_pair mix = {sqrtf(x->friction * y->friction), sqrtf(static_friction(x) * static_friction(y)),
                                  daft_sim_max(x->restitution, y->restitution),
                                  daft_sim_max(x->rolling_resistance, y->rolling_resistance)};
    if (world->material_pairs && world->material_pairs[x->kind * DAFT_SIM_MATERIAL_KINDS + y->kind].friction >= 0)
        mix = world->material_pairs[x->kind * DAFT_SIM_MATERIAL_KINDS + y->kind];
    pair->materials_cached = true;
    pair->surface_moves = !daft_sim_is_zero(x->surface_velocity) || !daft_sim_is_zero(y->surface_velocity);
    pair->friction = mix.friction;
    pair->static_friction = daft_sim_max(mix.friction, mix.static_friction);
    pair->restitution = mix.restitution;
    pair->rolling = mix.rolling_resistance * rolling_radius(a, b);
}

/* ---- manifolds ---- */

static daft_vec3 turned(const daft_rigid *f, daft_vec3 v)
{
    return daft_to_float(daft_rigid_vector(f, daft_to_double(v)));
}

/* Velocity of b's surface relative to a's at an anchor. */
static daft_vec3 closing(const daft_sim_body *a, const daft_sim_body *b, daft_vec3 anchor, daft_vec3 apart)
{
    daft_vec3 va = daft_add(a->linear, daft_cross(a->angular, anchor));
    daft_vec3 vb = daft_add(b->linear, daft_cross(b->angular, daft_add(anchor, apart)));
    return daft_sub(vb, va);
}

typedef struct motion {
    const daft_sim_body *a, *b;
    daft_vec3 apart; /* from b's centre to a's */
    float margin, dt;
    float approach; /* bound of their displacement against each other within the step */
} motion;

/* Where a's manifolds are. */
typedef struct place {
    daft_rigid frame_a;
    daft_vec3 offset; /* from a's centre of mass to part a's origin, world axes */
    daft_vec3 shift;  /* of a against b, to where the manifold is */
} place;

/* Whether a point is within the margin, or will be within the step. */
static bool is_met(const motion *p, daft_vec3 anchor, daft_vec3 normal, float separation)
{
    if (!(separation > p->margin)) return true;
    float speed = daft_dot(closing(p->a, p->b, anchor, p->apart), normal);
    return !(separation + speed * p->dt > p->margin);
}

static void convert(const motion *p, const place *where, const daft_manifold *from, daft_sim_manifold *to)
{
    *to = (daft_sim_manifold){.normal = daft_normalize(turned(&where->frame_a, from->normal)),
                              .part_a = from->part_a,
                              .part_b = from->part_b,
                              .shift = where->shift};
    for (uint32_t i = 0; i < from->count; i++) {
        const daft_manifold_point *point = &from->points[i];
        daft_vec3 anchor = daft_add(where->offset, turned(&where->frame_a, point->point));
        if (!is_met(p, anchor, to->normal, point->separation)) continue;
        to->points[to->count++] =
            (daft_sim_manifold_point){.anchor = anchor, .separation = point->separation, .id = point->id};
    }
}

/* Bodies whose centres are closer, as a fraction of their reach, are in one place, and no direction out is better than
 * another. */
#define ONE_PLACE (double)DAFT_ROUND_ONE_PLACE

static double scattered(uint32_t part, uint32_t axis)
{
    uint32_t x = (3 * part + axis) * 0x9e3779b9u;
    x = (x ^ x >> 15) * 0x2c1b3c6du;
    x = (x ^ x >> 12) * 0x297a2d39u;
    return (double)(x ^ x >> 15) * 0x1p-31 - 1;
}

/* Where many are made in one place, each has its own corner of it, so that they part in all directions and not in one
 * line. */
static void scatter(const daft_world *world, const daft_sim_pair *pair, const motion *p, daft_rigid *frame_a,
                    daft_rigid *frame_b)
{
    daft_dvec3 offset = daft_dsub(frame_b->p, frame_a->p);
    double size = ONE_PLACE * (double)world->parts[pair->part_a].reach;
    if (!(daft_ddot(offset, offset) < size * size) || p->b->kind != DAFT_BODY_DYNAMIC) return;
    uint32_t a = pair->part_a, b = pair->part_b;
    daft_dvec3 at_a = daft_dv3(scattered(a, 0), scattered(a, 1), scattered(a, 2));
    daft_dvec3 at_b = daft_dv3(scattered(b, 0), scattered(b, 1), scattered(b, 2));
    frame_a->p = daft_dadd(frame_a->p, daft_dscale(at_a, size));
    frame_b->p = daft_dadd(frame_b->p, daft_dscale(at_b, size));
}

static uint32_t collide(const daft_world *world, daft_sim_pair *pair, const motion *p, daft_rigid frame_a, float reach,
                        daft_manifold *found)
{
    const daft_sim_part *a = &world->parts[pair->part_a], *b = &world->parts[pair->part_b];
    daft_rigid frame_b = daft_sim_part_frame(p->b, b);
    scatter(world, pair, p, &frame_a, &frame_b);
    daft_relpose pose = daft_relpose_make(&frame_a, &frame_b);
    return daft_collide(&a->shape, &b->shape, &pose, reach, found, pair->more ? DAFT_SIM_MAX_MANIFOLDS : 1,
                        &pair->cache);
}

/* ---- what fast bodies will meet within the step ---- */

/* Gap at which they are taken to meet, as a fraction of the inner radius, and the fraction of it that does not matter.
 */
#define MEETING_GAP       0.01
#define MEETING_TOLERANCE 0.25

daft_sweep daft_sim_plan(const daft_world *world, const daft_sim_body *body, const daft_sim_part *part, float dt)
{
    daft_vec3 mean = body->linear;
    if (body->kind == DAFT_BODY_DYNAMIC)
        mean = daft_add(mean, daft_scale(world->gravity, 0.5f * body->gravity_scale * dt));
    daft_quat rotation = daft_sim_turn(body->rotation, body->angular, dt);
    daft_dvec3 centre = daft_rigid_to_local(&part->pose, daft_to_double(body->local_centre));
    return (daft_sweep){.from = body->centre,
                        .to = daft_dadd(body->centre, daft_to_double(daft_scale(mean, dt))),
                        .rotation_from = daft_quat_normalize(daft_quat_mul(body->rotation, part->turn)),
                        .rotation_to = daft_quat_normalize(daft_quat_mul(rotation, part->turn)),
                        .centre = daft_to_float(centre)};
}

/* The manifold is that of where they meet; separations are those of now, along its normal. */
static uint32_t foresee(const daft_world *world, daft_sim_pair *pair, motion *p, place *where, daft_manifold *found)
{
    const daft_sim_part *a = &world->parts[pair->part_a], *b = &world->parts[pair->part_b];
    daft_sweep path_a = daft_sim_plan(world, p->a, a, p->dt), path_b = daft_sim_plan(world, p->b, b, p->dt);
    double gap = MEETING_GAP * (double)(a->inner > 0 ? a->inner : a->reach);
    daft_impact impact;
    daft_impact_kind kind =
        daft_shape_impact(&a->shape, &path_a, &b->shape, &path_b, gap, MEETING_TOLERANCE * gap, &impact);
    if (kind != DAFT_IMPACT_HIT) return 0;
    daft_rigid at_a = daft_sweep_frame(&path_a, impact.t), at_b = daft_sweep_frame(&path_b, impact.t);
    daft_relpose pose = daft_relpose_make(&at_a, &at_b);
    uint32_t count =
        daft_collide(&a->shape, &b->shape, &pose, 2 * (float)gap, found, pair->more ? DAFT_SIM_MAX_MANIFOLDS : 1, NULL);
    daft_dvec3 go_a = daft_dscale(daft_dsub(path_a.to, path_a.from), impact.t);
    daft_dvec3 go_b = daft_dscale(daft_dsub(path_b.to, path_b.from), impact.t);
    where->frame_a = at_a;
    where->shift = daft_to_float(daft_dsub(go_a, go_b));
    where->offset = daft_to_float(daft_dsub(at_a.p, daft_dadd(p->a->centre, go_a)));
    p->apart = daft_add(p->apart, where->shift);
    p->margin = INFINITY; /* they will meet */
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < found[i].count; k++)
            found[i].points[k].separation += daft_dot(where->shift, turned(&at_a, found[i].normal));
    return count;
}

static float margin_of(float reach_a, float reach_b)
{
    return daft_sim_min(DAFT_SIM_MARGIN * daft_sim_min(reach_a, reach_b), DAFT_SIM_MAX_MARGIN);
}

static float approach_of(const motion *p)
{
    float speed = daft_length(daft_sub(p->a->linear, p->b->linear)) + daft_length(p->a->angular) * p->a->extent;
    if (!daft_sim_is_zero(p->b->angular)) {
        float arm = daft_sim_min(p->b->extent, daft_length(p->apart) + p->a->extent);
        speed += daft_length(p->b->angular) * arm;
    }
    return speed * p->dt;
}

/* Dynamic bodies look out for each other where one is flagged, or where it is cheap. */
static bool looks_out(const daft_sim_pair *pair, const motion *p, const daft_world *world)
{
    if (p->b->kind != DAFT_BODY_DYNAMIC || p->a->bullet || p->b->bullet) return true;
    return world->parts[pair->part_a].shape.type == DAFT_GEOMETRY_SPHERE &&
           world->parts[pair->part_b].shape.type == DAFT_GEOMETRY_SPHERE;
}

static bool is_fast(const daft_world *world, const daft_sim_pair *pair, const motion *p)
{
    return p->approach > MARGIN_OF_MOVE * world->parts[pair->part_a].reach;
}

static void find_manifolds(const daft_world *world, daft_sim_pair *pair, motion *p)
{
    place where = {.frame_a = daft_sim_part_frame(p->a, &world->parts[pair->part_a])};
    where.offset = daft_to_float(daft_dsub(where.frame_a.p, p->a->centre));
    daft_manifold found[DAFT_SIM_MAX_MANIFOLDS];
    daft_sim_manifold fresh[DAFT_SIM_MAX_MANIFOLDS], *manifolds = daft_sim_manifolds(pair);
    bool fast = is_fast(world, pair, p);
    uint32_t kept = 0, count = collide(world, pair, p, where.frame_a, p->margin + (fast ? 0 : p->approach), found);
    if (count == 0 && fast && looks_out(pair, p, world)) count = foresee(world, pair, p, &where, found);
    for (uint32_t i = 0; i < count; i++) {
        convert(p, &where, &found[i], &fresh[kept]);
        if (p->a->locks & DAFT_LOCK_POSITION) daft_sim_lock_axes(world, pair, &fresh[kept]);
        if (fresh[kept].count > 0) kept++;
    }
    daft_sim_persist(fresh, kept, manifolds, pair->manifold_count, daft_sim_extrapolation(world, pair, p->dt));
    for (uint32_t i = 0; i < kept; i++) manifolds[i] = fresh[i];
    if (kept > 0 && !pair->materials_cached) daft_sim_pair_materials(world, pair);
    pair->manifold_count = kept;
}

static void update_sensor(const daft_world *world, daft_sim_pair *pair)
{
    const daft_sim_part *a = &world->parts[pair->part_a], *b = &world->parts[pair->part_b];
    daft_rigid frame_a = daft_sim_part_frame(&world->bodies[pair->body_a], a);
    daft_rigid frame_b = daft_sim_part_frame(&world->bodies[pair->body_b], b);
    bool swap = !daft_shape_has_mass(&a->shape);
    daft_rigid relative = swap ? daft_rigid_relative(&frame_b, &frame_a) : daft_rigid_relative(&frame_a, &frame_b);
    pair->manifold_count = daft_shape_overlap(swap ? &b->shape : &a->shape, swap ? &a->shape : &b->shape, &relative, 0);
}

/* Whether geometry has to be asked: no for sensors, which are then done with. */
static bool begin(const daft_world *world, daft_sim_pair *pair, float dt, motion *p)
{
    const daft_sim_part *a = &world->parts[pair->part_a], *b = &world->parts[pair->part_b];
    if (pair->sensor) {
        update_sensor(world, pair);
        return false;
    }
    p->a = &world->bodies[pair->body_a], p->b = &world->bodies[pair->body_b], p->dt = dt;
    p->apart = daft_to_float(daft_dsub(p->a->centre, p->b->centre));
    p->margin = margin_of(a->reach, b->reach);
    p->approach = approach_of(p);
    return true;
}

enum { GRAIN = 256, PARALLEL_PAIRS = 256 };

/* ---- what is found in lanes ---- */

/* The pair's own manifold, for what was found in lanes: what it keeps stays, all else is set by who asks, or here.
 * Gives how many points it had. */
static uint32_t begin_manifold(const daft_world *world, daft_sim_pair *pair)
{
    daft_sim_manifold *manifold = &pair->own;
    daft_vec3 zero = daft_v3(0, 0, 0);
    uint32_t had = pair->manifold_count ? manifold->count : 0;
    manifold->part_a = manifold->part_b = (daft_shape_part){0, DAFT_NO_FEATURE};
    manifold->shift = zero;
    manifold->shared = false;
    manifold->total_impulse = manifold->speed = 0;
    if (pair->manifold_count > 0) return had;
    if (!pair->materials_cached) daft_sim_pair_materials(world, pair);
    manifold->friction_impulse = manifold->rolling_impulse = manifold->slip = zero;
    manifold->twist_impulse = manifold->twist_slip = manifold->load = 0;
    return 0;
}

typedef struct boxes {
    daft_box_batch batch;
    daft_sim_active *entries[DAFT_PAIR_LANES];
    float margins[DAFT_PAIR_LANES];
    int count;
} boxes;

typedef struct rounds {
    daft_round_batch batch;
    daft_sim_active *entries[DAFT_PAIR_LANES];
    int count;
} rounds;

/* What is at hand while a range of the active list is gone over. */
typedef struct range {
    const daft_world *world;
    float dt;
    rounds rounds, round_boxes;
    boxes boxes;
    daft_sim_active *asked[GRAIN]; /* to be looked at one at a time */
    size_t asked_count;
} range;

/* Whether a point found in lanes, which is not within the margin, counts nevertheless. */
static bool will_reach(const range *r, const daft_sim_pair *pair, float margin, daft_vec3 anchor, daft_vec3 normal,
                       float separation)
{
    motion p = {
        .a = &r->world->bodies[pair->body_a], .b = &r->world->bodies[pair->body_b], .margin = margin, .dt = r->dt};
    p.apart = daft_to_float(daft_dsub(p.a->centre, p.b->centre));
    return is_met(&p, anchor, normal, separation);
}

/* From body a's centre of mass to part a's origin. */
static daft_vec3 offset_of(const daft_world *world, const daft_sim_pair *pair)
{
    const daft_outline *outline = &world->outlines[pair->part_a];
    if (outline->centred) return daft_v3(0, 0, 0);
    return daft_to_float(daft_dsub(outline->centre, world->bodies[pair->body_a].centre));
}

/* What find_manifolds does with the one manifold of a pair. */
static void take(const range *r, daft_sim_active *entry, const daft_found_lanes *found, int lane, float margin)
{
    daft_sim_pair *pair = &r->world->pairs[entry->pair];
    daft_sim_manifold *manifold = &pair->own;
    daft_sim_persisted old;
    daft_sim_persisted_set(&old, manifold, begin_manifold(r->world, pair),
                           daft_sim_extrapolation(r->world, pair, r->dt));
    daft_vec3 offset = offset_of(r->world, pair);
    manifold->normal = daft_lane_get(found->normal, lane);
    manifold->count = 0;
    for (int i = 0; i < found->count[lane]; i++) {
        daft_vec3 anchor = daft_add(offset, daft_lane_get(found->point[i], lane));
        daft_sim_manifold_point point = {
            .anchor = anchor, .separation = found->separation[i][lane], .id = (uint32_t)found->id[i][lane]};
        if (point.separation <= margin || will_reach(r, pair, margin, anchor, manifold->normal, point.separation))
            daft_sim_persisted_put(&old, manifold, point);
    }
    daft_sim_persisted_end(&old, manifold);
    pair->manifold_count = manifold->count > 0;
    if (pair->manifold_count > 0) entry->flags |= DAFT_SIM_OVERLAPS;
}

/* ---- spheres and capsules, side by side ---- */

/* To be looked at alone. */
static void ask(range *r, daft_sim_active *entry) { r->asked[r->asked_count++] = entry; }

static void collide_rounds(range *r, rounds *all)
{
    static const daft_round_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_round);
    const daft_round_kernels *kernels = TABLE[r->world->isa];
    (all == &r->rounds ? kernels->rounds : kernels->boxes)(r->world->outlines, &all->batch, all->count);
    for (int lane = 0; lane < all->count; lane++) {
        daft_sim_active *entry = all->entries[lane];
        int32_t state = all->batch.state[lane];
        daft_sim_pair *pair = &r->world->pairs[entry->pair];
        if (state == DAFT_ROUND_ASK) {
            ask(r, entry);
        } else if (state == DAFT_ROUND_MET || entry->flags & DAFT_SIM_OVERLAPS) {
            if (state == DAFT_ROUND_MET)
                take(r, entry, &all->batch.found, lane, all->batch.margin[lane]);
            else
                pair->manifold_count = 0;
        }
    }
    all->count = 0;
}

/* ---- pairs of boxes, side by side ---- */

static void collide_boxes(range *r)
{
    static const daft_box_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_box);
    boxes *all = &r->boxes;
    TABLE[r->world->isa]->collide(&all->batch, all->count);
    for (int lane = 0; lane < all->count; lane++) {
        daft_sim_pair *pair = &r->world->pairs[all->entries[lane]->pair];
        pair->cache.kind = (uint8_t)all->batch.kind[lane];
        if (all->batch.found.count[lane] > 0)
            take(r, all->entries[lane], &all->batch.found, lane, all->margins[lane]);
        else
            pair->manifold_count = 0;
    }
    all->count = 0;
}

static void add_boxes(range *r, daft_sim_active *entry, uint32_t a, uint32_t b)
{
    const daft_outline *x = &r->world->outlines[a], *y = &r->world->outlines[b];
    const daft_sim_pair *pair = &r->world->pairs[entry->pair];
    const daft_rigid *frames = r->world->box_frames;
    float margin = margin_of(x->reach, y->reach),
          approach = daft_length(daft_sub(x->move, y->move)) + (x->swing + y->swing);
    daft_vec3 toward = daft_to_float(daft_dsub(y->centre, x->centre));
    bool one_place = daft_length(toward) < 2 * DAFT_ROUND_ONE_PLACE * x->reach;
    if (approach > MARGIN_OF_MOVE * x->reach || one_place) {
        ask(r, entry);
        return;
    }
    boxes *to = &r->boxes;
    int lane = to->count++;
    to->entries[lane] = entry, to->margins[lane] = margin;
    daft_box_batch_put(&to->batch, lane, &frames[a], &frames[b], x->half, y->half);
    to->batch.margin[lane] = margin + approach;
    to->batch.kind[lane] = pair->cache.kind;
    if (to->count == DAFT_PAIR_LANES) collide_boxes(r);
}

/* To the lanes where its kind is looked at, or to those that are looked at one at a time. */
static void sort_in(range *r, daft_sim_active *entry)
{
    const daft_outline *all = r->world->outlines;
    uint32_t a = (uint32_t)(entry->key >> 32), b = (uint32_t)entry->key;
    daft_outline_kind kind_a = all[a].kind, kind_b = all[b].kind;
    if (kind_a == DAFT_OUTLINE_NONE || kind_b == DAFT_OUTLINE_NONE) {
        ask(r, entry);
        return;
    }
    if (kind_a == DAFT_OUTLINE_BOX && kind_b == DAFT_OUTLINE_BOX) {
        add_boxes(r, entry, a, b);
        return;
    }
    bool boxed = kind_a != kind_b;
    rounds *to = boxed ? &r->round_boxes : &r->rounds;
    int lane = to->count++;
    to->entries[lane] = entry;
    daft_round_batch_put(&to->batch, lane, all, a, b, margin_of(all[a].reach, all[b].reach));
    if (boxed) {
        bool box_first = kind_a == DAFT_OUTLINE_BOX;
        const daft_rigid *frame = &r->world->box_frames[box_first ? a : b];
        daft_dvec3 centre = daft_rigid_to_local_vector(frame, daft_dsub(all[box_first ? b : a].centre, frame->p));
        daft_round_batch_put_box(&to->batch, lane, all, centre, frame->m, box_first);
    }
    if (to->count == DAFT_PAIR_LANES) collide_rounds(r, to);
}

/* ---- all ---- */

typedef struct job {
    daft_world *world;
    float dt;
} job;

static void update_asked(range *r)
{
    const daft_world *world = r->world;
    for (size_t i = 0; i < r->asked_count; i++) {
        daft_sim_pair *pair = &world->pairs[r->asked[i]->pair];
        motion p;
        if (begin(world, pair, r->dt, &p)) find_manifolds(world, pair, &p);
        if (pair->manifold_count > 0) r->asked[i]->flags |= DAFT_SIM_OVERLAPS;
    }
}

static void update_range(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const job *j = context;
    daft_world *world = j->world;
    size_t first = (size_t)index * GRAIN, left = world->active.count - first, count = left < GRAIN ? left : GRAIN;
    daft_sim_active *entries = &world->active.items[first];
    range r = {.world = world, .dt = j->dt}; /* lanes past the last are read, too: all of them hold defined values */
    for (size_t i = 0; i < count; i++) sort_in(&r, &entries[i]);
    if (r.boxes.count > 0) collide_boxes(&r);
    if (r.rounds.count > 0) collide_rounds(&r, &r.rounds);
    if (r.round_boxes.count > 0) collide_rounds(&r, &r.round_boxes);
    update_asked(&r);
    for (size_t i = 0; i < count; i++)
        if (entries[i].flags) daft_sim_active_refresh(world, &entries[i]);
}

/* Pairs of what is not convex have many manifolds. */
static bool reserve_manifolds(daft_world *world)
{
    for (size_t i = 0; i < world->active.count; i++) {
        daft_sim_pair *pair = &world->pairs[world->active.items[i].pair];
        if (!daft_sim_is_unallocated(world, pair)) continue;
        pair->more = daft_alloc_zero(&world->allocator, DAFT_SIM_MAX_MANIFOLDS, sizeof *pair->more); /* saved as it is
                                                                                                      */
        if (!pair->more) return false;
        pair->manifold_count = 0;
    }
    return true;
}

bool daft_sim_contacts_update(daft_world *world, float dt)
{
    if (world->unallocated && !reserve_manifolds(world)) return false;
    world->unallocated = false;
    job j = {world, dt};
    uint32_t tasks = (uint32_t)((world->active.count + GRAIN - 1) / GRAIN);
    daft_sim_for(world, world->active.count >= PARALLEL_PAIRS, tasks, update_range, &j);
    return true;
}
