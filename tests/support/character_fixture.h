/* A character in a world, for the tests of both: makers of boxes, and ticks that assert that it is not inside what
 * stands. */
#ifndef CHARACTER_FIXTURE_H
#define CHARACTER_FIXTURE_H

#include "fixtures.h"
#include "sim/character/character.h"
#include "sim_scene.h"

static daft_dvec3 centre; /* of the scene at hand: the origin, or far away */

static inline uint32_t put_box(daft_world *world, double hx, double hy, double hz, double x, double y, double z)
{
    one_shape def = box(daft_v3((float)hx, (float)hy, (float)hz), centre.x + x, centre.y + y, centre.z + z);
    return add(world, def);
}

static inline uint32_t put_turned(daft_world *world, daft_vec3 half, double x, double y, double z, daft_quat turn)
{
    one_shape def = box(half, centre.x + x, centre.y + y, centre.z + z);
    def.rotation = turn;
    return add(world, def);
}

static inline uint32_t put_kinematic(daft_world *world, daft_vec3 half, double x, double y, double z)
{
    one_shape def = box(half, centre.x + x, centre.y + y, centre.z + z);
    def.kind = DAFT_BODY_KINEMATIC;
    return add(world, def);
}

static inline void put_ground(daft_world *world) { put_box(world, 50, 1, 50, 0, -1, 0); }

/* Feet at y. */
static inline daft_sim_character walker(double x, double y, double z)
{
    daft_sim_character c;
    daft_error error = {0};
    daft_sim_character_def def = daft_default_sim_character_def();
    def.position = daft_dv3(centre.x + x, centre.y + y + 0.5 * (double)def.height + 0.006, centre.z + z);
    if (!daft_sim_character_init(&c, &def, &error)) fail_msg("%s", error.message);
    return c;
}

static inline double feet(const daft_sim_character *c)
{
    return c->position.y - 0.5 * (double)c->def.height - centre.y;
}

static inline bool is_inside(daft_world *world, const daft_sim_character *c, float fraction)
{
    daft_sim_shape capsule;
    daft_error error;
    daft_sim_filter statics = daft_default_sim_filter();
    statics.kinds = 1u << DAFT_BODY_STATIC;
    float radius = c->def.radius * fraction;
    assert_true(daft_shape_capsule(0.5f * c->def.height - c->def.radius + 1e-3f, radius, &capsule, &error));
    return daft_world_overlap(world, &capsule, c->position, daft_quat_identity(), &statics, NULL, 0) > 0;
}

static inline void go(daft_world *world, daft_sim_character *c, double vx, double vz, double jump)
{
    daft_error error = {0};
    daft_sim_walk_wish wish = {daft_v3((float)vx, 0, (float)vz), (float)jump};
    if (!daft_sim_character_move(world, c, &wish, DT, &error)) fail_msg("%s", error.message);
    assert_true(daft_dfinite3(c->position) && daft_finite3(c->velocity));
    if (is_inside(world, c, 0.99f))
        fail_msg("inside at %g %g %g", c->position.x - centre.x, c->position.y - centre.y, c->position.z - centre.z);
}

static inline void walk(daft_world *world, daft_sim_character *c, double vx, double vz, int ticks)
{
    for (int i = 0; i < ticks; i++) go(world, c, vx, vz, 0);
}

#endif
