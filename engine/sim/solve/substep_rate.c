/* How many substeps an island is taken in. The spring of a contact is as stiff as the length of a substep allows
 * (colour.c), so a load that is many times the weight of what it presses on needs shorter ones: what lies under it
 * sinks by the square of their length, and a column buckles. Of n cubes of side s, with a spring of frequency omega at
 * each corner, it stands while
 *
 *     omega² > g n³ / s    (Greenhill 1881, q L³ < 7.84 E I, with the springs as the column's E I)
 *
 * and contacts can have omega = 1 / h. So each contact between bodies at rest to each other asks
 * for a rate of substeps by the load that it lately carried, and an island is taken in twice, four, eight times as many
 * substeps as the world's as its contacts ask, if they are so few that it does not matter. An island's substeps are its
 * own, whatever else there is. Bodies begin with the finest, so that what is made at rest does not sink before its
 * loads are known.
 *
 * Where that is too much work, as for a column that stands in an island of hundreds, or where there are joints, the few
 * contacts that carry much are made stiff instead: their springs are solved several times in a substep, which spreads
 * what each does along the column, and so may be stiffer. A column of 20 then sinks by 16 mm instead of 1, and stands.
 *
 * Joints ask by their bodies' masses: what a chain stretches by grows with the load at its end, in weights of its
 * links, and shrinks with the square of the substeps. */
#include "sim/solve/solver.h"
#include "sim/sleep.h"

#include <stdatomic.h>
#include <string.h>

#define LOAD_FRACTION 0.2f   /* of the last step in the load: a knock is no load */
#define MAX_LOAD      1e30f  /* N: it stays finite */
#define STRAIN        6.5f   /* weights of the lighter body; what carries less asks for nothing */
#define REST_SPEED    0.05f  /* m/s, of one's fastest point against the other's */
#define MARGIN        25.0f  /* of omega²: columns sink by 2 mm at most, and do not only just stand */
#define MIN_GRAVITY   1.0f   /* m/s²: where there is less gravity, what presses is no weight */
#define COLUMN        2.5f   /* times the mean of what its bodies ask for is what an island gets */
#define EVEN_MASSES   100.0f /* times the other's mass: a joint between bodies that differ by less asks for nothing, */
#define EVEN_RATE     240.0f /* and one of so much would for as many substeps a second */
#define FAST          0.1f   /* of its extent: if its fastest point moves by more in a step */
#define STAYS         1.4f /* times what is asked for, before an island takes fewer substeps: it would go to and fro */
#define LASTS         0.9f /* of what was asked for, in a step in which nothing asks */

enum {
    MAX_SUBSTEPS = 32,
    MAX_WORK = 14400, /* contacts times substeps of an island; about half a millisecond */
    MAX_STIFF = 32    /* stiff contacts of an island: a hundredth of the time that a thousand bodies take */
};

float daft_sim_substep_demand_begin(void) { return MAX_SUBSTEPS * 60; }

static float gravity(const daft_world *world) { return daft_sim_max(daft_length(world->gravity), MIN_GRAVITY); }

bool daft_sim_substep_load(const daft_world *world, daft_sim_manifold *manifold, float inv_mass, float dt)
{
    manifold->load += LOAD_FRACTION * (daft_sim_min(manifold->total_impulse / dt, MAX_LOAD) - manifold->load);
    return manifold->load * inv_mass > STRAIN * gravity(world);
}

static float rest_speed(const daft_sim_body *a, const daft_sim_body *b)
{
    return daft_length(daft_sub(b->linear, a->linear)) + daft_length(a->angular) * a->extent +
           daft_length(b->angular) * b->extent;
}

/* Of a cube that stands about as firmly: thin ones do not. */
static float side_of(const daft_sim_body *body) { return 1.5197f * sqrtf(body->extent * body->inner); }

/* Substeps a second that a contact asks for. */
static float asked_by(const daft_world *world, const daft_sim_body *a, const daft_sim_body *b, float load)
{
    bool both = b->kind == DAFT_BODY_DYNAMIC;
    float light = both && b->inv_mass > a->inv_mass ? b->inv_mass : a->inv_mass;
    float side = both ? daft_sim_min(side_of(a), side_of(b)) : side_of(a);
    float push = load * light, weights = push / gravity(world);
    if (weights <= STRAIN || !(side > 0) || !(rest_speed(a, b) < REST_SPEED)) return 0;
    return daft_sim_min(sqrtf(MARGIN * push / side) * weights, DAFT_SIM_FINEST);
}

bool daft_sim_load_is_heavy(const daft_world *world, const daft_sim_body *a, const daft_sim_body *b, float load)
{
    if (!(load > 0)) return false;
    /* Nearly all carry far less, and are told so without a root. */
    float push = load * (b->kind == DAFT_BODY_DYNAMIC ? daft_sim_max(a->inv_mass, b->inv_mass) : a->inv_mass);
    float far_less = 0.5f * STRAIN;
    if (push * push < far_less * far_less * daft_dot(world->gravity, world->gravity)) return false;
    return asked_by(world, a, b, load) > 0;
}

/* Bits of floats that are not negative are in the order of what they stand for. */
static void raise(_Atomic uint32_t *to, float rate)
{
    uint32_t bits, most = atomic_load_explicit(to, memory_order_relaxed);
    memcpy(&bits, &rate, sizeof bits);
    while (bits > most &&
           !atomic_compare_exchange_weak_explicit(to, &most, bits, memory_order_relaxed, memory_order_relaxed))
        ;
}

static float raised_to(_Atomic uint32_t *to)
{
    uint32_t bits = atomic_load_explicit(to, memory_order_relaxed);
    float rate;
    memcpy(&rate, &bits, sizeof rate);
    return rate;
}

static void ask(const daft_sim_solver *s, uint32_t row, float rate)
{
    if (row > s->mover_count) raise(&s->asked[row], rate);
}

void daft_sim_substep_ask(const daft_world *world, const daft_sim_pair *pair, float load, const daft_sim_slot *slot)
{
    float rate = asked_by(world, &world->bodies[pair->body_a], &world->bodies[pair->body_b], load);
    ask(world->scratch.solver, slot->row_a, rate);
    ask(world->scratch.solver, slot->row_b, rate);
}

float daft_sim_substep_demand_next(const daft_world *world, float now, uint32_t row)
{
    return daft_sim_max(LASTS * now, raised_to(&world->scratch.solver->asked[row]));
}

/* ---- islands ---- */

static daft_sim_island *island_of(const daft_world *world, uint32_t body)
{
    return &world->scratch.solver->islands[world->scratch.solver->island_of[body]];
}

/* Numbers them. */
static void number_islands(daft_world *world)
{
    daft_sim_solver *s = world->scratch.solver;
    daft_sim_islands_find(world);
    s->island_count = 0;
    for (size_t i = 0; i < world->awake.count; i++) {
        uint32_t body = world->awake.items[i];
        if (world->scratch.island_parents[body] == body) s->island_of[body] = s->island_count++;
    }
    for (size_t i = 0; i < world->awake.count; i++) {
        uint32_t body = world->awake.items[i];
        s->island_of[body] = s->island_of[daft_sim_island_of(world, body)];
    }
}

/* The least substep rate that does what is asked for within the work allowed. In a column, where loads grow evenly,
 * bodies ask for two fifths of what the lowest does on average; in a broad island for much less. */
static uint32_t rate_of(const daft_world *world, const daft_sim_island *island, float dt)
{
    if (island->joined ? island->pull == 0 : island->contacts == 0 || island->deep || island->fast) return 0;
    uint32_t rate = 0, substeps = (uint32_t)world->substeps;
    float wanted = island->joined ? island->pull * dt : COLUMN * (float)island->asked / (float)island->bodies * dt;
    while (rate + 1 < DAFT_SIM_RATES && 2 * substeps <= MAX_SUBSTEPS &&
           2 * substeps * (uint64_t)island->contacts <= MAX_WORK &&
           (float)substeps < (2 * substeps <= island->before ? STAYS * wanted : wanted))
        substeps *= 2, rate++;
    return rate;
}

/* Contacts are found once a step. A stiff spring at a point that the body has left within the step gives it energy. */
static bool is_fast(const daft_sim_body *body, float dt)
{
    return (daft_length(body->linear) + daft_length(body->angular) * body->extent) * dt > FAST * body->extent;
}

enum { PARALLEL_BODIES = 512 };

/* Islands and colours need nothing of each other. */
static void number_islands_or_colour(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    if (index == 0)
        number_islands(context);
    else
        daft_sim_contacts_colour(context);
}

/* Islands with joints get no shorter substeps for what bodies carry. */
static float demand_of(const daft_sim_body *body)
{
    return body->first_joint == DAFT_SIM_NONE ? body->substep_demand : 0;
}

static float max_demand(const daft_world *world)
{
    float most = 0;
    for (size_t i = 0; i < world->awake.count; i++)
        most = daft_sim_max(most, demand_of(&world->bodies[world->awake.items[i]]));
    return most;
}

/* Sums are of whole numbers, so their order does not matter. */
static void survey_bodies(daft_world *world, float dt)
{
    for (size_t i = 0; i < world->awake.count; i++) {
        const daft_sim_body *body = &world->bodies[world->awake.items[i]];
        daft_sim_island *island = island_of(world, world->awake.items[i]);
        uint32_t before = body->h > 0 ? (uint32_t)(daft_sim_min(dt / body->h, MAX_SUBSTEPS) + 0.5f) : 0;
        island->bodies++;
        island->asked += (uint64_t)demand_of(body);
        island->before = daft_max_u(island->before, before);
        island->fast |= is_fast(body, dt);
    }
}

static void survey_contacts(daft_world *world)
{
    for (size_t i = 0; i < world->active.count; i++) {
        const daft_sim_active *entry = &world->active.items[i];
        if (!(entry->flags & (DAFT_SIM_FIXED | DAFT_SIM_JOINS)) || world->scratch.solver->row_of[entry->body_a] == 0)
            continue;
        daft_sim_island *island = island_of(world, entry->body_a);
        island->contacts += entry->manifolds;
        island->deep |= (entry->flags & DAFT_SIM_DEEP) != 0;
        if (entry->flags & DAFT_SIM_STIFF) island->stiff_contacts += entry->manifolds;
    }
}

static void join(daft_sim_island *island, float pull)
{
    island->joined = true;
    island->pull = daft_sim_max(island->pull, pull);
}

/* Substeps a second that a joint asks for: a chain of 20 links stretches by a fiftieth of a link so. Joints expect the
 * next substep to be as long as the last, so this is of what stays: not the load, but the masses. */
static float pull_of(const daft_world *world, const daft_sim_joint *joint)
{
    if (joint->kind == 0 || joint->spring || joint->body[0] == DAFT_SIM_NONE || joint->body[1] == DAFT_SIM_NONE)
        return 0;
    const daft_sim_body *a = &world->bodies[joint->body[0]], *b = &world->bodies[joint->body[1]];
    if (a->kind != DAFT_BODY_DYNAMIC || b->kind != DAFT_BODY_DYNAMIC) return 0;
    float ratio = daft_sim_max(a->mass, b->mass) * daft_sim_max(a->inv_mass, b->inv_mass);
    return ratio > EVEN_MASSES ? daft_sim_min(EVEN_RATE * sqrtf(ratio / EVEN_MASSES), DAFT_SIM_FINEST) : 0;
}

static void survey_joints(daft_world *world)
{
    for (uint32_t i = 0; world->live_joints > 0 && i < world->joint_count; i++) {
        const daft_sim_joint *joint = &world->joints[i];
        for (int side = 0; joint->kind != 0 && side < 2; side++) {
            uint32_t body = joint->body[side];
            if (body != DAFT_SIM_NONE && world->bodies[body].kind == DAFT_BODY_DYNAMIC && !world->bodies[body].asleep)
                join(island_of(world, body), pull_of(world, joint));
        }
    }
}

static bool some_pull(const daft_world *world)
{
    for (uint32_t i = 0; world->live_joints > 0 && i < world->joint_count; i++)
        if (pull_of(world, &world->joints[i]) > 0) return true;
    return false;
}

bool daft_sim_is_stiff(const daft_world *world, uint32_t body)
{
    return world->scratch.solver->stiff && island_of(world, body)->stiff;
}

bool daft_sim_substep_rates(daft_world *world, float dt)
{
    daft_sim_solver *s = world->scratch.solver;
    uint32_t count = (uint32_t)world->awake.count;
    daft_sim_for(world, count >= PARALLEL_BODIES, 2, number_islands_or_colour, world);
    bool some = false, deep = false; /* are to take finer ones; overlap deeply */
    s->stiff = false;
    if (COLUMN * max_demand(world) * dt <= (float)world->substeps && !some_pull(world)) return false;
    memset(s->islands, 0, s->island_count * sizeof *s->islands);
    survey_bodies(world, dt);
    survey_contacts(world);
    survey_joints(world);
    for (size_t i = 0; i < s->island_count; i++) {
        daft_sim_island *island = &s->islands[i];
        island->rate = rate_of(world, island, dt);
        island->stiff = island->rate == 0 && island->stiff_contacts > 0 && island->stiff_contacts <= MAX_STIFF;
        s->stiff |= island->stiff;
        some |= island->rate > 0;
        deep |= island->deep;
    }
    for (size_t i = 0; deep && i < count; i++)
        if (island_of(world, world->awake.items[i])->deep) world->bodies[world->awake.items[i]].substep_demand = 0;
    return some;
}
