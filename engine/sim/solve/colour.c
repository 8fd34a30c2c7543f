/* Rows for the bodies that move in this step, and colours for the constraints between them: constraints of one colour
 * share no body that yields, so they can be solved side by side (graph colouring as in Box2D v3). Each constraint takes
 * the lowest colour that is free at both its bodies, in the order of the active list; so the colours of one island are
 * its own, whatever else is in the world. Contacts with what does not yield come last: the solver ends with what cannot
 * give way. */
#include "sim/solve/solver.h"

#include <stdatomic.h>
#include <stddef.h>
#include <string.h>

enum {
    MASKED = 32, /* colours of each class that a body's mask tells; its further constraints climb level by level */
    CLASSES = DAFT_SIM_CLASSES,
    SIZES = DAFT_MANIFOLD_POINTS,
    KINDS = 2 * CLASSES * SIZES /* of each class those that are not stiff and those that are; those of most points first
                                 */
};

#define UNUSED_SEPARATION 1e20f

/* ---- rows ---- */

static bool reserve_rows(daft_world *world, size_t needed)
{
    daft_sim_solver *s = world->scratch.solver;
    if (needed <= s->row_capacity) return true;
    size_t capacity = 0, floats = DAFT_SIM_ROW;
    float **rows[] = {&s->rows.velocity, &s->rows.moved, &s->rows.gain, &s->rows.turn, &s->rows.mass};
    needed += needed / 2;
    for (size_t i = 0; i < DAFT_COUNT_OF(rows); i++) {
        capacity = s->row_capacity * floats;
        if (!daft_grow(&world->allocator, rows[i], &capacity, needed * floats, 0, sizeof(float))) {
            s->row_capacity = 0; /* some are larger than others now: all will be made anew */
            return false;
        }
    }
    s->row_capacity = needed;
    return true;
}

static uint32_t rate_of(const daft_sim_solver *s, uint32_t body) { return s->islands[s->island_of[body]].rate; }

/* Rows of the islands of each substep rate follow each other. */
static void order_rows(daft_world *world, bool rates)
{
    daft_sim_solver *s = world->scratch.solver;
    uint32_t row = 1 + s->mover_count, next[DAFT_SIM_RATES] = {0};
    for (size_t i = 0; i < world->awake.count; i++) next[rates ? rate_of(s, world->awake.items[i]) : 0]++;
    for (uint32_t rate = 0; rate < DAFT_SIM_RATES; rate++) {
        uint32_t count = next[rate];
        next[rate] = row;
        s->rate_end[rate] = row += count;
    }
    for (size_t i = 0; i < world->awake.count; i++)
        s->row_bodies[next[rates ? rate_of(s, world->awake.items[i]) : 0]++] = world->awake.items[i];
    s->row_count = row;
}

static bool yields(const daft_world *world, uint32_t row) { return daft_sim_row_yields(world->scratch.solver, row); }

/* ---- colours ---- */

void daft_sim_colours_clear(daft_sim_solver *s, size_t place)
{
    s->masks[place] = 0;
    for (size_t class = 0; class < CLASSES; class ++) s->levels[place * CLASSES + class] = 0;
}

uint32_t daft_sim_colour_take(daft_sim_solver *s, size_t a, size_t b, uint32_t class)
{
    uint32_t shift = class * MASKED;
    uint64_t taken = (s->masks[a] | s->masks[b]) >> shift & UINT32_MAX;
    if (taken != UINT32_MAX) {
        uint32_t colour = (uint32_t)__builtin_ctzll(~taken);
        uint64_t bit = (uint64_t)1 << (colour + shift);
        s->masks[a] |= bit, s->masks[b] |= bit;
        s->masks[0] = 0;
        return colour;
    }
    uint32_t *level_a = &s->levels[a * CLASSES + class], *level_b = &s->levels[b * CLASSES + class];
    uint32_t level = *level_a > *level_b ? *level_a : *level_b;
    *level_a = *level_b = level + 1;
    s->levels[class] = 0;
    return MASKED + level;
}

/* Whether a pair that met is solved, as it yields somewhere: a does. */
static bool is_solved(const daft_world *world, const daft_sim_active *entry)
{
    return entry->flags & (DAFT_SIM_FIXED | DAFT_SIM_JOINS) &&
           yields(world, world->scratch.solver->row_of[entry->body_a]);
}

/* Room for rows, and for what there is of each; of each body, for its row. */
static bool reserve(daft_world *world, size_t rows)
{
    daft_sim_solver *s = world->scratch.solver;
    const daft_allocator *a = &world->allocator;
    size_t bodies = world->body_count, known = s->row_of_capacity, manifolds = 0;
    for (size_t i = 0; i < world->active.count; i++) manifolds += world->active.items[i].manifolds;
    if (!reserve_rows(world, rows) || !daft_grow(a, &s->row_of, &s->row_of_capacity, bodies, known, sizeof *s->row_of))
        return false;
    memset(s->row_of + known, 0, (s->row_of_capacity - known) * sizeof *s->row_of);
    return daft_grow(a, &s->row_bodies, &s->row_body_capacity, rows, s->row_count, sizeof *s->row_bodies) &&
           daft_grow(a, &s->island_of, &s->island_of_capacity, bodies, 0, sizeof *s->island_of) &&
           daft_grow(a, &s->masks, &s->mask_capacity, bodies + 1, 0, sizeof *s->masks) &&
           daft_grow(a, &s->constrained, &s->constrained_capacity, rows, 0, sizeof *s->constrained) &&
           daft_grow(a, &s->depenetration, &s->depenetration_capacity, rows, 0, sizeof *s->depenetration) &&
           daft_grow(a, &s->marks, &s->mark_capacity, rows, 0, sizeof *s->marks) &&
           daft_grow(a, &s->islands, &s->island_capacity, rows, 0, sizeof *s->islands) &&
           daft_grow(a, &s->asked, &s->asked_capacity, rows, 0, sizeof *s->asked) &&
           daft_grow(a, &s->targets, &s->target_capacity, rows, 0, sizeof *s->targets) &&
           daft_grow(a, &s->angular, &s->angular_capacity, rows / DAFT_SIM_LANES + 1, 0, sizeof *s->angular) &&
           daft_grow(a, &s->levels, &s->level_capacity, (bodies + 1) * CLASSES, 0, sizeof *s->levels) &&
           daft_grow(a, &s->contacts, &s->contact_capacity, manifolds, 0, sizeof *s->contacts);
}

/* Springs push each pair of a spot full of bodies apart, and those on the outside would get the sum of all their
 * speeds. So what overlaps deeply becomes no faster than one push, or than it or the other came. */
static void limit_depenetration(daft_world *world, uint32_t row, uint32_t other)
{
    const daft_sim_solver *s = world->scratch.solver;
    if (!yields(world, row)) return;
    daft_sim_depenetration most = {DAFT_SIM_PUSH_SPEED, DAFT_SIM_PUSH_SPEED};
    const uint32_t rows[2] = {row, other};
    for (int i = 0; i < 2; i++) {
        if (rows[i] == 0) continue;
        const daft_sim_body *body = &world->bodies[s->row_bodies[rows[i]]];
        float speed = daft_length(body->linear), swing = daft_length(body->angular) * body->extent;
        if (!yields(world, rows[i])) speed += swing; /* it goes on as it was */
        most.speed = daft_sim_max(most.speed, speed);
        most.swing = daft_sim_max(most.swing, swing);
    }
    s->depenetration[row].speed = daft_sim_max(s->depenetration[row].speed, most.speed);
    s->depenetration[row].swing = daft_sim_max(s->depenetration[row].swing, most.swing);
}

/* What contacts say of rows. */
static void tell_rows(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    s->constrained[0] = 0;
    for (uint32_t row = 1; row < s->row_count; row++) {
        uint32_t body = s->row_bodies[row];
        s->row_of[body] = row;
        s->constrained[row] =
            yields(world, row) && s->masks[daft_sim_colour_place(body)] != 0 ? DAFT_SIM_IN_CONTACT : 0;
    }
    memset(s->depenetration, 0, s->row_count * sizeof *s->depenetration);
    for (size_t i = 0; s->depenetrates && i < world->active.count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (!(entry->flags & DAFT_SIM_DEPENETRATES) || !is_solved(world, entry)) continue;
        uint32_t a = s->row_of[entry->body_a], b = s->row_of[entry->body_b];
        limit_depenetration(world, a, b), limit_depenetration(world, b, a);
    }
}

/* Islands share no body, so the colours that contacts take are those of their own islands, whichever substep rate these
 * are of. */
void daft_sim_contacts_colour(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    s->contact_count = s->contact_rows = 0;
    s->contact_colours[0] = s->contact_colours[1] = 0;
    s->depenetrates = false;
    daft_sim_colours_clear(s, 0);
    for (size_t i = 0; i < world->awake.count; i++)
        daft_sim_colours_clear(s, daft_sim_colour_place(world->awake.items[i]));
    for (size_t i = 0; i < world->active.count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (!is_solved(world, entry)) continue;
        bool both = yields(world, s->row_of[entry->body_b]), stiff = entry->flags & DAFT_SIM_STIFF;
        size_t a = daft_sim_colour_place(entry->body_a), b = both ? daft_sim_colour_place(entry->body_b) : 0;
        uint32_t class = !both, points = (entry->points + entry->manifolds - 1u) / entry->manifolds; /* where there are
                                                                                                        several: about
                                                                                                      */
        s->contact_rows += 3u * entry->manifolds + entry->points;
        s->depenetrates |= (entry->flags & DAFT_SIM_DEPENETRATES) != 0;
        for (uint32_t k = 0; k < entry->manifolds; k++) {
            uint32_t colour = daft_sim_colour_take(s, a, b, class);
            if (colour >= s->contact_colours[class]) s->contact_colours[class] = colour + 1;
            s->contacts[s->contact_count++] = (daft_sim_coloured){
                entry->pair, k, entry->body_a, entry->body_b, colour << 1 | class, (uint8_t)points, stiff, false, 0};
        }
    }
}

bool daft_sim_solver_bodies_assign(daft_world *world, float dt)
{
    daft_sim_solver *s = world->scratch.solver;
    size_t count = 1 + world->movers.count + world->awake.count;
    if (!reserve(world, count)) return false;
    for (uint32_t row = 1; row < s->row_count; row++) s->row_of[s->row_bodies[row]] = 0; /* of the last step */
    s->row_count = 0;
    uint32_t row = 1;
    s->row_bodies[0] = DAFT_SIM_NONE;
    for (size_t i = 0; i < world->movers.count; i++) s->row_bodies[row++] = world->movers.items[i];
    s->mover_count = (uint32_t)world->movers.count;
    for (size_t i = 0; i < world->awake.count; i++) s->row_of[world->awake.items[i]] = row; /* any, but 0 */
    order_rows(world, daft_sim_substep_rates(world, dt));
    tell_rows(world);
    for (uint32_t i = 0; i < s->row_count; i++) atomic_init(&s->asked[i], 0);
    return true;
}

/* Where those of a kind are counted. */
static uint32_t kind_of(const daft_sim_coloured *c)
{
    return (c->colour >> 1) * KINDS + (2 * (c->colour & 1) + c->stiff) * SIZES + (SIZES - c->points);
}

/* Of each kind, how many contacts of the islands that are being solved. */
static void count_kinds(daft_world *world, uint32_t *counts)
{
    daft_sim_solver *s = world->scratch.solver;
    for (size_t i = 0; i < s->contact_count; i++) {
        daft_sim_coloured *c = &s->contacts[i];
        c->kind = DAFT_SIM_NONE;
        if (!daft_sim_row_is_solved(s, s->row_of[c->body_a])) continue;
        c->stiff = c->loaded && daft_sim_is_stiff(world, c->body_a);
        c->kind = kind_of(c);
        counts[c->kind]++;
    }
}

/* Gives how many blocks those of any number of points take, from block `first` on; counts become their next free slots.
 */
static uint32_t lay_sizes(uint32_t *counts, uint32_t first)
{
    uint32_t slot = first * DAFT_SIM_LANES, next = slot;
    for (size_t size = 0; size < SIZES; size++) {
        uint32_t count = counts[size];
        counts[size] = next;
        next += count;
    }
    return (next - slot + DAFT_SIM_LANES - 1) / DAFT_SIM_LANES;
}

/* Colours in order, each on whole blocks, in which contacts have about as many points. */
static bool lay_out(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    const uint32_t *most = s->contact_colours;
    if (!daft_grow(&world->allocator, &s->colours, &s->colour_capacity, (size_t)most[0] + most[1], 0,
                   sizeof *s->colours))
        return false;
    for (uint32_t class = 0; class < CLASSES; class ++)
        for (uint32_t colour = 0; colour < most[class]; colour++) {
            uint32_t *counts = &s->colour_counts[colour * KINDS], first = s->block_count, soft = 0;
            for (uint32_t stiff = 0; stiff < 2; stiff++) {
                s->block_count += lay_sizes(counts + (2 * class + stiff) * SIZES, s->block_count);
                if (!stiff) soft = s->block_count;
            }
            if (s->block_count == first) continue;
            s->colours[s->colour_count++] = (daft_sim_colour){first, s->block_count - first, s->block_count - soft};
        }
    return daft_grow(&world->allocator, &s->blocks, &s->block_capacity, s->block_count, 0, sizeof *s->blocks) &&
           daft_grow(&world->allocator, &s->slots, &s->slot_capacity, (size_t)s->block_count * DAFT_SIM_LANES, 0,
                     sizeof *s->slots);
}

static void fill_slots(daft_sim_solver *s)
{
    for (size_t i = 0; i < (size_t)s->block_count * DAFT_SIM_LANES; i++) s->slots[i].pair = DAFT_SIM_NONE;
    for (size_t i = 0; i < s->contact_count; i++) {
        const daft_sim_coloured *c = &s->contacts[i];
        if (c->kind == DAFT_SIM_NONE) continue;
        uint32_t slot = s->colour_counts[c->kind]++;
        s->slots[slot] = (daft_sim_slot){c->pair, c->manifold, s->row_of[c->body_a], s->row_of[c->body_b], c->stiff};
    }
}

bool daft_sim_contacts_place(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    const uint32_t *most = s->contact_colours;
    size_t kinds = (size_t)(most[0] > most[1] ? most[0] : most[1]) * KINDS;
    s->colour_count = s->block_count = 0;
    if (s->contact_count == 0) return true;
    if (!daft_grow(&world->allocator, &s->colour_counts, &s->colour_count_capacity, kinds, 0, sizeof *s->colour_counts))
        return false;
    memset(s->colour_counts, 0, kinds * sizeof *s->colour_counts);
    count_kinds(world, s->colour_counts);
    if (!lay_out(world)) return false;
    fill_slots(s);
    return true;
}

/* ---- blocks ---- */

static void put3(daft_sim_lanes *to, int lane, daft_vec3 v) { to[0][lane] = v.x, to[1][lane] = v.y, to[2][lane] = v.z; }
static daft_vec3 get3(daft_sim_lanes *from, int lane) { return daft_v3(from[0][lane], from[1][lane], from[2][lane]); }

static daft_vec3 any_perpendicular(daft_vec3 n)
{
    daft_vec3 axis = fabsf(n.x) < 0.6f ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0);
    return daft_normalize(daft_cross(n, axis));
}

static daft_vec3 surface_velocity_of(const daft_world *world, uint32_t body, uint32_t part)
{
    daft_vec3 surface_velocity = world->parts[part].material.surface_velocity;
    return daft_sim_is_zero(surface_velocity) ? surface_velocity
                                              : daft_quat_rotate(world->bodies[body].rotation, surface_velocity);
}

/* What sticks has static friction. */
#define STICK_SPEED 0.02f /* m/s */

static float friction_of(const daft_world *world, const daft_sim_pair *pair, const daft_sim_manifold *manifold)
{
    if (!(pair->static_friction > pair->friction)) return pair->friction;
    const daft_sim_body *a = &world->bodies[pair->body_a], *b = &world->bodies[pair->body_b];
    daft_vec3 ra = manifold->points[0].anchor, rb = daft_add(ra, daft_to_float(daft_dsub(a->centre, b->centre)));
    daft_vec3 v =
        daft_sub(daft_add(b->linear, daft_cross(b->angular, rb)), daft_add(a->linear, daft_cross(a->angular, ra)));
    v = daft_sub(v, daft_scale(manifold->normal, daft_dot(v, manifold->normal)));
    return daft_length(v) < STICK_SPEED ? pair->static_friction : pair->friction;
}

/* Enough, in radians, that a point a metre away leaves its tangent by a micrometre within the step. */
#define MIN_TURN 1e-3f

static bool turns_about(daft_vec3 normal, const daft_sim_body *body, float dt)
{
    return fabsf(daft_dot(normal, body->angular)) * dt > MIN_TURN;
}

static void fill_lane(const daft_world *world, daft_sim_block *block, int lane, const daft_sim_slot *slot,
                      const float soft[2][3], float dt)
{
    daft_sim_pair *pair = &world->pairs[slot->pair];
    const daft_sim_manifold *manifold = &daft_sim_manifolds(pair)[slot->manifold];
    const daft_sim_body *a = &world->bodies[pair->body_a], *b = &world->bodies[pair->body_b];
    uint32_t row_a = slot->row_a, row_b = slot->row_b;
    bool fixed = !yields(world, row_b);
    float longer = a->h > 0 ? world->scratch.solver->h / a->h : 1; /* than the substep that the impulses are of */
    daft_vec3 n = manifold->normal, t = any_perpendicular(n), u = daft_cross(n, t);
    block->a[lane] = (int32_t)row_a, block->b[lane] = (int32_t)row_b;
    block->writes_a |= 1u << lane;
    if (!fixed) block->writes_b |= 1u << lane;
    put3(block->normal, lane, n);
    put3(block->tangent, lane, t);
    put3(block->apart, lane, daft_add(daft_to_float(daft_dsub(a->centre, b->centre)), manifold->shift));
    block->rate[lane] = soft[fixed][0], block->soft_mass[lane] = soft[fixed][1];
    block->soft_impulse[lane] = soft[fixed][2];
    block->friction[lane] = friction_of(world, pair, manifold);
    block->restitution[lane] = pair->restitution;
    block->rolling[lane] = pair->rolling;
    block->rolls |= pair->rolling > 0;
    block->bounces |= pair->restitution > 0;
    block->tangent_impulse[0][lane] = daft_dot(manifold->friction_impulse, t) * longer;
    block->tangent_impulse[1][lane] = daft_dot(manifold->friction_impulse, u) * longer;
    block->twist_impulse[lane] = manifold->twist_impulse * longer;
    block->slip[0][lane] = daft_dot(manifold->slip, t);
    block->slip[1][lane] = daft_dot(manifold->slip, u);
    block->twist_slip[lane] = manifold->twist_slip;
    block->shares |= manifold->shared;
    block->shared[lane] = manifold->shared;
    put3(block->rolling_impulse, lane, daft_scale(manifold->rolling_impulse, longer));
    if (turns_about(n, a, dt) || turns_about(n, b, dt)) {
        block->turns = true;
        for (int k = 0; k < 2; k++) block->bend_a[k][lane] = block->bend_b[k][lane] = 1;
    }
    if (pair->surface_moves) {
        daft_vec3 surface_velocity = daft_sub(surface_velocity_of(world, pair->body_a, pair->part_a),
                                              surface_velocity_of(world, pair->body_b, pair->part_b));
        block->surface_velocity[0][lane] = daft_dot(surface_velocity, t),
        block->surface_velocity[1][lane] = daft_dot(surface_velocity, u);
    }
    for (uint32_t i = 0; i < manifold->count; i++) {
        daft_sim_block_point *p = &block->point[i];
        put3(p->arm_a, lane, manifold->points[i].anchor);
        p->separation[lane] = manifold->points[i].separation;
        p->impulse[lane] = manifold->points[i].impulse * longer;
    }
}

/* The springs of contacts (Catto), heavily overdamped: 37.7 Hz at 240 substeps a second. One pass changes an impulse
 * by a fraction of what is wrong, so what is not solved fully acts as a spring of its own, without damping: it stays
 * stable as long as a contact forgets (soft_impulse / h) faster than it pushes (soft_mass·rate), which is
 * h·2π·hertz < 1. Stiffer ones make a pyramid sway; where they are too soft, substeps are shorter (substep_rate.c).
 * Against what does not yield overlap is undone faster and the impulse is rigid. */
#define HERTZ_FRACTION       0.157f /* of the substeps' rate */
#define STIFF_HERTZ_FRACTION 0.4f   /* where passes are DAFT_SIM_STIFF_PASSES */
#define FIXED_HERTZ_FRACTION 0.5f
#define CONTACT_DAMPING      10.0f

static void make_soft(float hertz, float h, float out[3])
{
    float omega = 2 * (float)DAFT_PI * hertz;
    float a1 = 2 * CONTACT_DAMPING + h * omega, a2 = h * omega * a1, a3 = 1 / (1 + a2);
    out[0] = omega / a1, out[1] = a2 * a3, out[2] = a3;
}

void daft_sim_block_fill(daft_world *world, uint32_t index)
{
    daft_sim_solver *s = world->scratch.solver;
    daft_sim_block *block = &s->blocks[index];
    float h = s->h, soft[2][3];
    bool stiff = s->slots[(size_t)index * DAFT_SIM_LANES].stiff;
    make_soft((stiff ? STIFF_HERTZ_FRACTION : HERTZ_FRACTION) / h, h, soft[0]);
    make_soft(FIXED_HERTZ_FRACTION / h, h, soft[1]);
    soft[1][1] = 1, soft[1][2] = 0;
    const daft_sim_slot *slots = &s->slots[(size_t)index * DAFT_SIM_LANES];
    int lanes = 0;
    while (lanes < DAFT_SIM_LANES && slots[lanes].pair != DAFT_SIM_NONE) lanes++;
    memset(block, 0, offsetof(daft_sim_block, inv_mass_a));
    block->lanes = lanes;
    for (int lane = 0; lane < lanes; lane++) {
        const daft_sim_manifold *manifold = &daft_sim_manifolds(&world->pairs[slots[lane].pair])[slots[lane].manifold];
        block->points = daft_max_i(block->points, (int)manifold->count);
    }
    for (int i = 0; i < block->points; i++) {
        memset(&block->point[i], 0, offsetof(daft_sim_block_point, arm_b));
        for (int lane = 0; lane < DAFT_SIM_LANES; lane++) block->point[i].separation[lane] = UNUSED_SEPARATION;
    }
    for (int lane = 0; lane < lanes; lane++) fill_lane(world, block, lane, &slots[lane], soft, h * (float)s->substeps);
}

static void store_lane(daft_sim_block *block, int lane, daft_sim_manifold *manifold)
{
    daft_vec3 n = get3(block->normal, lane), t = get3(block->tangent, lane), u = daft_cross(n, t);
    manifold->friction_impulse =
        daft_add(daft_scale(t, block->tangent_impulse[0][lane]), daft_scale(u, block->tangent_impulse[1][lane]));
    manifold->twist_impulse = block->twist_impulse[lane];
    manifold->slip = daft_add(daft_scale(t, block->slip[0][lane]), daft_scale(u, block->slip[1][lane]));
    manifold->twist_slip = block->twist_slip[lane];
    manifold->rolling_impulse = get3(block->rolling_impulse, lane);
    manifold->total_impulse = 0;
    manifold->speed = 0;
    for (uint32_t i = 0; i < manifold->count; i++) {
        const daft_sim_block_point *p = &block->point[i];
        manifold->points[i].impulse = p->impulse[lane];
        manifold->total_impulse += p->total[lane];
        if (p->total[lane] > 0) manifold->speed = daft_sim_max(manifold->speed, p->approach[lane]);
    }
}

void daft_sim_block_store(daft_world *world, uint32_t index)
{
    daft_sim_solver *s = world->scratch.solver;
    daft_sim_block *block = &s->blocks[index];
    const daft_sim_slot *slots = &s->slots[(size_t)index * DAFT_SIM_LANES];
    for (int lane = 0; lane < block->lanes; lane++) {
        daft_sim_manifold *manifold = &daft_sim_manifolds(&world->pairs[slots[lane].pair])[slots[lane].manifold];
        store_lane(block, lane, manifold);
        float light = daft_sim_max(block->inv_mass_a[lane], block->inv_mass_b[lane]);
        if (daft_sim_substep_load(world, manifold, light, s->h * (float)s->substeps))
            daft_sim_substep_ask(world, &world->pairs[slots[lane].pair], manifold->load, &slots[lane]);
    }
}
