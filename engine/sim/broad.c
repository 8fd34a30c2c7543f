/* The broad phase: which bodies may meet within a step. Static bodies stand in one tree with their exact bounds, the
 * others in a second one with fattened bounds, so that a body that moves a little does not touch the tree. A body's own
 * bounds (swept over the step, not fattened) decide in the end, so that pairs do not depend on the history of a tree.
 */
#include "sim/internal.h"

/* Fat on each side, as a share of the reach. A leaf is entered anew when the body leaves it, or has grown much smaller
 * than it (a shot that has come to rest). */
#define FAT  0.25
#define SLIM 4.0

static daft_sim_bounds grown(const daft_sim_bounds *bounds, double by)
{
    daft_dvec3 d = daft_dv3(by, by, by);
    return (daft_sim_bounds){daft_dsub(bounds->low, d), daft_dadd(bounds->high, d)};
}

daft_sim_bounds daft_sim_shape_bounds(const daft_sim_body *body)
{
    daft_dvec3 half = daft_dv3((double)body->reach, (double)body->reach, (double)body->reach);
    if (body->shape == DAFT_SHAPE_BOX) {
        const double *m = body->basis;
        daft_dvec3 h = daft_to_double(body->half_extent);
        half = daft_dv3(fabs(m[0]) * h.x + fabs(m[1]) * h.y + fabs(m[2]) * h.z,
                        fabs(m[3]) * h.x + fabs(m[4]) * h.y + fabs(m[5]) * h.z,
                        fabs(m[6]) * h.x + fabs(m[7]) * h.y + fabs(m[8]) * h.z);
    }
    return (daft_sim_bounds){daft_dsub(body->position, half), daft_dadd(body->position, half)};
}

static void enter(daft_world *world, uint32_t index)
{
    daft_sim_body *body = &world->bodies[index];
    double fat = body->kind == DAFT_BODY_STATIC ? 0 : FAT * (double)body->reach;
    daft_sim_bounds bounds = grown(&body->bounds, fat);
    body->leaf = daft_sim_tree_insert(&world->trees[body->kind], &bounds, index);
}

void daft_sim_broad_add(daft_world *world, uint32_t index)
{
    world->bodies[index].bounds = daft_sim_shape_bounds(&world->bodies[index]);
    enter(world, index);
}

void daft_sim_broad_remove(daft_world *world, uint32_t index)
{
    daft_sim_tree_remove(&world->trees[world->bodies[index].kind], world->bodies[index].leaf);
}

static bool contains(const daft_sim_bounds *outer, const daft_sim_bounds *inner)
{
    return outer->low.x <= inner->low.x && outer->low.y <= inner->low.y && outer->low.z <= inner->low.z &&
           outer->high.x >= inner->high.x && outer->high.y >= inner->high.y && outer->high.z >= inner->high.z;
}

/* A dynamic body goes where its plan leads; a kinematic one that turns may be anywhere within its reach. */
static daft_sim_bounds swept_bounds(const daft_sim_body *body, const daft_sim_motion *motion, float dt)
{
    daft_sim_bounds bounds = daft_sim_shape_bounds(body);
    daft_vec3 w = motion->angular;
    if (body->kind == DAFT_BODY_KINEMATIC && (w.x != 0 || w.y != 0 || w.z != 0)) {
        double swing = (double)daft_length(w) * (double)dt;
        double reach = (double)body->reach * (1 + (swing < 2 ? swing : 2));
        daft_sim_bounds point = {body->position, body->position};
        bounds = grown(&point, reach);
    }
    daft_dvec3 d = daft_to_double(motion->planned), zero = daft_dv3(0, 0, 0);
    bounds.low = daft_dadd(bounds.low, daft_sim_dmin(d, zero));
    bounds.high = daft_dadd(bounds.high, daft_sim_dmax(d, zero));
    return bounds;
}

static double longest_side(const daft_sim_bounds *bounds)
{
    daft_dvec3 d = daft_dsub(bounds->high, bounds->low);
    double longest = d.x > d.y ? d.x : d.y;
    return longest > d.z ? longest : d.z;
}

static void update(daft_world *world, uint32_t index, float dt)
{
    daft_sim_body *body = &world->bodies[index];
    body->bounds = swept_bounds(body, &world->motions[index], dt);
    const daft_sim_bounds *fat = &world->trees[body->kind].nodes[body->leaf].bounds;
    if (contains(fat, &body->bounds) && longest_side(fat) <= SLIM * longest_side(&body->bounds)) return;
    daft_sim_broad_remove(world, index);
    enter(world, index);
}

void daft_sim_broad_update(daft_world *world, float dt)
{
    for (size_t i = 0; i < world->dynamics.count; i++) update(world, world->dynamics.items[i], dt);
    for (size_t i = 0; i < world->movers.count; i++) update(world, world->movers.items[i], dt);
}
