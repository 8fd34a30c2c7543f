/* What the tests of sim share: making worlds and bodies, stepping, comparing. */
#ifndef SIM_SCENE_H
#define SIM_SCENE_H

#include "sim/sim.h"

#include "math/trig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define DT (1.0f / 60)
#define G  9.81

static daft_allocator heap;

static uint64_t random_state = 88172645463325252u;
static inline void seed_random(uint64_t seed)
{
    random_state = seed;
    print_message("seed %llu\n", (unsigned long long)seed);
}
static inline double uniform(double low, double high)
{
    random_state ^= random_state << 13, random_state ^= random_state >> 7, random_state ^= random_state << 17;
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}

/* C leaves open in which order a call's arguments are computed, so random vectors are made here, one number at a time.
 */
static inline daft_dvec3 random_in(double low, double high)
{
    double x = uniform(low, high), y = uniform(low, high), z = uniform(low, high);
    return daft_dv3(x, y, z);
}

static inline daft_world *new_world(void)
{
    daft_error error;
    heap = daft_malloc_allocator();
    daft_world *world = daft_world_create(&heap, &error);
    assert_non_null(world);
    return world;
}

/* A body of one shape, as most are here. */
typedef struct one_shape {
    daft_body_kind kind;
    daft_sim_shape_def part;
    daft_dvec3 position;
    daft_quat rotation;
    float friction, restitution, rolling_resistance, density;
    uint32_t user;
    bool bullet;
} one_shape;

static inline one_shape body_def(daft_body_kind kind, daft_dvec3 position)
{
    return (one_shape){.kind = kind,
                       .part = daft_default_sim_shape_def(),
                       .position = position,
                       .rotation = {0, 0, 0, 1},
                       .density = 1000,
                       .friction = 0.6f};
}

static inline one_shape sphere(double radius, double x, double y, double z)
{
    one_shape def = body_def(DAFT_BODY_DYNAMIC, daft_dv3(x, y, z));
    def.part.shape.radius = (float)radius;
    return def;
}

static inline one_shape box(daft_vec3 half, double x, double y, double z)
{
    one_shape def = body_def(DAFT_BODY_STATIC, daft_dv3(x, y, z));
    def.part.shape.type = DAFT_GEOMETRY_BOX;
    def.part.shape.half = half;
    return def;
}

static inline one_shape dynamic_box(daft_vec3 half, double x, double y, double z)
{
    one_shape def = box(half, x, y, z);
    def.kind = DAFT_BODY_DYNAMIC;
    return def;
}

static inline uint32_t try_add(daft_world *world, const one_shape *def, daft_error *error)
{
    daft_sim_shape_def part = def->part;
    part.density = def->density;
    part.material.friction = def->friction;
    part.material.restitution = def->restitution;
    part.material.rolling_resistance = def->rolling_resistance;
    daft_sim_body_def body = daft_default_sim_body_def();
    body.kind = def->kind;
    body.position = def->position;
    body.rotation = def->rotation;
    body.shapes = &part;
    body.shape_count = 1;
    body.user = def->user;
    body.bullet = def->bullet;
    return daft_world_add(world, &body, error);
}

static inline uint32_t add(daft_world *world, one_shape def)
{
    daft_error error = {0};
    uint32_t body = try_add(world, &def, &error);
    if (!body) fail_msg("%s", error.message);
    return body;
}

/* A floor whose top is at y = 0. */
static inline uint32_t add_floor(daft_world *world, float half)
{
    return add(world, box(daft_v3(half, 1, half), 0, -1, 0));
}

static inline void steps(daft_world *world, int count)
{
    daft_error error = {0};
    for (int i = 0; i < count; i++)
        if (!daft_world_step(world, DT, &error)) fail_msg("%s", error.message);
}

static inline daft_sim_state state_of(const daft_world *world, uint32_t body)
{
    daft_sim_state state;
    daft_world_get(world, body, &state);
    return state;
}

static inline double speed_of(daft_sim_state s) { return (double)daft_length(s.linear); }

static inline void assert_near(double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.9g is not within %g of %.9g", value, tolerance, wanted);
}

static inline daft_quat turned(double x, double y, double z, double angle)
{
    double s = daft_sin(angle / 2), length = sqrt(x * x + y * y + z * z);
    return (daft_quat){(float)(x / length * s), (float)(y / length * s), (float)(z / length * s),
                       (float)daft_cos(angle / 2)};
}

/* Triangles that look up, two to each of cells × cells quads over a field of vertices, row by row; returns how many
 * indices. */
static inline uint32_t index_field(uint32_t cells, uint32_t *index)
{
    uint32_t used = 0;
    for (uint32_t row = 0; row < cells; row++)
        for (uint32_t column = 0; column < cells; column++) {
            uint32_t a = row * (cells + 1) + column, b = a + 1, c = a + cells + 1, d = c + 1;
            const uint32_t quad[] = {a, c, b, b, c, d};
            memcpy(index + used, quad, sizeof quad);
            used += 6;
        }
    return used;
}

/* A square tray with walls. */
static inline void add_tray(daft_world *world, daft_dvec3 at, float half)
{
    add(world, box(daft_v3(half, 1, half), at.x, at.y - 1, at.z));
    for (int side = -1; side <= 1; side += 2) {
        add(world, box(daft_v3(0.5f, 10, half), at.x + side * ((double)half + 0.5), at.y, at.z));
        add(world, box(daft_v3(half, 10, 0.5f), at.x, at.y, at.z + side * ((double)half + 0.5)));
    }
}

/* A closed room: six walls around its middle. */
static inline void add_room(daft_world *world, daft_dvec3 middle, float half, float wall_half, float restitution,
                            float friction)
{
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2) {
            double at = side * (double)half;
            one_shape wall = box(daft_v3(half, half, half), middle.x, middle.y, middle.z);
            *(axis == 0   ? &wall.part.shape.half.x
              : axis == 1 ? &wall.part.shape.half.y
                          : &wall.part.shape.half.z) = wall_half;
            *(axis == 0 ? &wall.position.x : axis == 1 ? &wall.position.y : &wall.position.z) += at;
            wall.restitution = restitution;
            wall.friction = friction;
            add(world, wall);
        }
}

#endif
