/* How many substeps a heap is taken in. The spring of a contact is as stiff as the length of a substep allows (colour.c),
 * so a load that is many times the weight of what it presses on needs shorter ones: what lies under it sinks by the
 * square of their length, and a column buckles. Of n cubes of side s, with a spring of frequency omega at each corner,
 * it stands while
 *     omega² > g n³ / s                    (Greenhill 1881, q L³ < 7.84 E I, with the springs as the column's E I)
 * and contacts can have omega = 1 / h. So each contact between bodies at rest to each other asks for a rate of substeps
 * by the load that it lately carried, and a heap is taken in twice, four, eight times as many substeps as the world's
 * as its contacts ask, if they are so few that it does not matter. A heap's substeps are its own, whatever else there
 * is. Bodies begin with the finest, so that what is made at rest does not sink before its loads are known. */
#include "sim/solver.h"

#include <string.h>

#define LOAD_SHARE 0.2f  /* of the last step in the load: a knock is no load */
#define MOST_LOAD  1e30f /* N: it stays finite */
#define STRAIN     6.5f  /* weights of the lighter body; what carries less asks for nothing */
#define REST_SPEED 0.05f /* m/s, of one's fastest point against the other's */
#define MARGIN     25.0f /* of omega²: columns sink by 2 mm at most, and do not only just stand */
#define LEAST_G    1.0f  /* m/s²: where there is less gravity, what presses is no weight */
#define COLUMN     2.5f  /* times the mean of what its bodies ask for is what a heap gets */
#define DEEP       0.1f  /* of a body's extent: what overlaps by more is to be parted, and not so that it flies */
#define FAST   0.1f  /* of its extent: if its fastest point moves by more in a step */
#define STAYS      1.4f  /* times what is asked for, before a heap takes fewer substeps: it would go to and fro */
#define LASTS      0.9f  /* of what was asked for, in a step in which nothing asks */

enum {
    MOST_SUBSTEPS = 32,
    MOST_WORK = 14400 /* contacts times substeps of a heap; about half a millisecond */
};

float daft_sim_finer_begin(void) { return MOST_SUBSTEPS * 60; }

static float gravity(const daft_world *world) { return daft_sim_max(daft_length(world->gravity), LEAST_G); }

bool daft_sim_finer_load(const daft_world *world, daft_sim_patch *patch, float inv_mass, float dt)
{
    patch->load += LOAD_SHARE * (daft_sim_min(patch->total_impulse / dt, MOST_LOAD) - patch->load);
    return patch->load * inv_mass > STRAIN * gravity(world);
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

static void ask(daft_sim_solver *s, int32_t row, float rate)
{
    if (row > (int32_t)s->mover_count) s->asked[row] = daft_sim_max(s->asked[row], rate);
}

void daft_sim_finer_ask(daft_world *world)
{
    daft_sim_solver *s = world->solver;
    for (uint32_t i = 0; i < s->block_count; i++) {
        const daft_sim_block *block = &s->blocks[i];
        for (int lane = 0; block->strained && lane < block->lanes; lane++) {
            const daft_sim_slot *slot = &s->slots[(size_t)i * DAFT_SIM_LANES + (size_t)lane];
            daft_sim_touch *touch = &world->touches[slot->touch];
            float rate = asked_by(world, &world->bodies[touch->body_a], &world->bodies[touch->body_b],
                                  daft_sim_patches(touch)[slot->patch].load);
            ask(s, block->a[lane], rate);
            ask(s, block->b[lane], rate);
        }
    }
}

float daft_sim_finer_next(float now, float asked) { return daft_sim_max(LASTS * now, asked); }

/* ---- heaps ---- */

static daft_sim_heap *heap_of(daft_world *world, uint32_t body)
{
    return &world->solver->heaps[world->bodies[daft_sim_island_of(world, body)].list_slot];
}

uint32_t daft_sim_finer_pace(daft_world *world, uint32_t body) { return heap_of(world, body)->pace; }

/* The least pace that does what is asked for within the work allowed. In a column, where loads grow evenly, bodies ask
 * for two fifths of what the lowest does on average; in a broad heap for much less. */
static uint32_t pace_of(const daft_world *world, const daft_sim_heap *heap, float dt)
{
    if (heap->contacts == 0 || heap->deep || heap->joined || heap->fast) return 0;
    uint32_t pace = 0, substeps = (uint32_t)world->substeps;
    float wanted = COLUMN * (float)heap->asked / (float)heap->bodies * dt;
    while (pace + 1 < DAFT_SIM_PACES && 2 * substeps <= MOST_SUBSTEPS &&
           2 * substeps * (uint64_t)heap->contacts <= MOST_WORK &&
           (float)substeps < (2 * substeps <= heap->before ? STAYS * wanted : wanted))
        substeps *= 2, pace++;
    return pace;
}

static bool is_deep(const daft_world *world, daft_sim_touch *touch)
{
    float most = -DEEP * world->bodies[touch->body_a].extent;
    for (uint32_t i = 0; i < touch->patch_count; i++) {
        const daft_sim_patch *patch = &daft_sim_patches(touch)[i];
        for (uint32_t k = 0; k < patch->count; k++)
            if (patch->points[k].separation < most) return true;
    }
    return false;
}

/* Contacts are found once a step. A stiff spring at a point that the body has left within the step gives it energy. */
static bool is_fast(const daft_sim_body *body, float dt)
{
    return (daft_length(body->linear) + daft_length(body->angular) * body->extent) * dt > FAST * body->extent;
}

/* Sums are of whole numbers, so their order does not matter. */
static void survey(daft_world *world, float dt)
{
    memset(world->solver->heaps, 0, world->awake.count * sizeof *world->solver->heaps);
    for (size_t i = 0; i < world->awake.count; i++) {
        daft_sim_heap *heap = heap_of(world, world->awake.items[i]);
        heap->bodies++;
        const daft_sim_body *body = &world->bodies[world->awake.items[i]];
        uint32_t before = body->h > 0 ? (uint32_t)(daft_sim_min(dt / body->h, MOST_SUBSTEPS) + 0.5f) : 0;
        heap->asked += (uint64_t)body->finer;
        if (before > heap->before) heap->before = before;
        heap->fast |= is_fast(body, dt);
    }
    for (size_t i = 0; i < world->met.count; i++) {
        daft_sim_touch *touch = &world->touches[world->met.items[i]];
        if (touch->sensor || !daft_sim_is_active(&world->bodies[touch->body_a])) continue;
        daft_sim_heap *heap = heap_of(world, touch->body_a);
        heap->contacts += touch->patch_count;
        heap->deep |= is_deep(world, touch);
    }
}

/* Joints are stiff at any length of a substep, and expect the next one to be as long as the last. */
static void survey_joints(daft_world *world)
{
    for (uint32_t i = 0; world->live_joints > 0 && i < world->joint_count; i++) {
        const daft_sim_joint *joint = &world->joints[i];
        for (int side = 0; joint->kind != 0 && side < 2; side++) {
            uint32_t body = joint->body[side];
            if (body != DAFT_SIM_NONE && world->bodies[body].kind == DAFT_BODY_DYNAMIC && !world->bodies[body].asleep)
                heap_of(world, body)->joined = true;
        }
    }
}

bool daft_sim_finer_paces(daft_world *world, float dt)
{
    float most = 0;
    for (size_t i = 0; i < world->awake.count; i++)
        most = daft_sim_max(most, world->bodies[world->awake.items[i]].finer);
    if (COLUMN * most * dt <= (float)world->substeps) return false;
    daft_sim_islands_find(world);
    survey(world, dt);
    survey_joints(world);
    for (size_t i = 0; i < world->awake.count; i++)
        world->solver->heaps[i].pace = pace_of(world, &world->solver->heaps[i], dt);
    for (size_t i = 0; i < world->awake.count; i++)
        if (heap_of(world, world->awake.items[i])->deep) world->bodies[world->awake.items[i]].finer = 0;
    return true;
}
