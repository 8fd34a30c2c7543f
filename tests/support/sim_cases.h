/* What the tests of the table of physics cases share: each scene is played at the origin, far from it, mirrored in x,
 * and by two and four workers, from which the same bits must come as from one. */
#ifndef SIM_CASES_H
#define SIM_CASES_H

#include "fixtures.h"

#include "sim_scene.h"

typedef struct variant {
    const char *name;
    daft_dvec3 origin;
    double side; /* -1: mirrored in x */
    int workers;
} variant;

enum { VARIANTS = 5 };

static const variant VARIANT[VARIANTS] = {{"at the origin", {0, 0, 0}, 1, 1},
                                          {"far away", {1e4, 0, -1e4}, 1, 1},
                                          {"mirrored", {0, 0, 0}, -1, 1},
                                          {"two workers", {0, 0, 0}, 1, 2},
                                          {"four workers", {0, 0, 0}, 1, 4}};

static inline daft_world *variant_world(const variant *v)
{
    daft_world *world = new_world();
    daft_world_set_workers(world, v->workers, daft_isa_best());
    return world;
}

/* Where the variant has what the scene has at p, and the other way. */
static inline daft_dvec3 variant_at(const variant *v, daft_dvec3 p)
{
    return daft_dadd(v->origin, daft_dv3(v->side * p.x, p.y, p.z));
}
static inline daft_dvec3 variant_from(const variant *v, daft_dvec3 p)
{
    daft_dvec3 d = daft_dsub(p, v->origin);
    return daft_dv3(v->side * d.x, d.y, d.z);
}
static inline daft_quat variant_turn(const variant *v, daft_quat q)
{
    return v->side < 0 ? (daft_quat){q.x, -q.y, -q.z, q.w} : q;
}

static inline uint32_t put(daft_world *world, const variant *v, one_shape def)
{
    def.position = variant_at(v, def.position);
    def.rotation = variant_turn(v, def.rotation);
    return add(world, def);
}

static inline daft_dvec3 place_of(const daft_world *world, const variant *v, uint32_t body)
{
    return variant_from(v, state_of(world, body).position);
}

/* Velocities as the scene has them. A spin is an axial vector: its part along x is what a mirror keeps. */
static inline daft_vec3 variant_direction(const variant *v, daft_vec3 d)
{
    return daft_v3((float)v->side * d.x, d.y, d.z);
}
static inline daft_vec3 variant_spin(const variant *v, daft_vec3 spin)
{
    return daft_v3(spin.x, (float)v->side * spin.y, (float)v->side * spin.z);
}
static inline void launch(daft_world *world, const variant *v, uint32_t body, daft_vec3 linear, daft_vec3 angular)
{
    daft_world_set_velocity(world, body, variant_direction(v, linear), variant_spin(v, angular));
}

static inline uint32_t put_floor(daft_world *world, const variant *v, float half)
{
    return put(world, v, box(daft_v3(half, 1, half), 0, -1, 0));
}

/* What the scene would have at the origin, not mirrored. */
static inline daft_sim_state state_in(const daft_world *world, const variant *v, uint32_t body)
{
    daft_sim_state s = state_of(world, body);
    s.position = variant_from(v, s.position);
    s.rotation = variant_turn(v, s.rotation);
    s.linear = variant_direction(v, s.linear), s.angular = variant_spin(v, s.angular);
    return s;
}

/* In a mirror, triangles are wound the other way round. */
static inline fixture_mesh variant_mesh(const variant *v, const daft_vec3 *p, uint32_t vertices, const uint32_t *index,
                                        uint32_t triangles)
{
    daft_vec3 *at = malloc(vertices * sizeof *at);
    uint32_t *wound = malloc(3 * (size_t)triangles * sizeof *wound);
    assert_true(at && wound);
    for (uint32_t i = 0; i < vertices; i++) at[i] = variant_direction(v, p[i]);
    for (uint32_t i = 0; i < 3 * triangles; i += 3) {
        wound[i] = index[i];
        wound[i + 1] = index[v->side < 0 ? i + 2 : i + 1], wound[i + 2] = index[v->side < 0 ? i + 1 : i + 2];
    }
    fixture_mesh mesh = mesh_make(at, vertices, wound, triangles);
    free(at);
    free(wound);
    return mesh;
}

/* A sanitizer takes ten times as long, so under it only one and two workers at the origin play. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

static inline bool is_played(int k) { return !SANITIZED || k == 0 || k == 3; }

/* Two and four workers give the bits of one: `hashes` are of all variants, in their order. */
static inline void assert_workers_agree(const uint64_t hashes[VARIANTS])
{
    assert_true(hashes[3] == hashes[0]);
    if (is_played(4)) assert_true(hashes[4] == hashes[0]);
}

static inline uint64_t end_of(daft_world *world)
{
    uint64_t hash = daft_world_hash(world, 0);
    daft_world_destroy(world);
    return hash;
}

/* A scene plays a variant, asserts what is asked of it, and returns a hash of the world or worlds at its end. */
typedef uint64_t case_scene(const variant *v);

static inline void play_variants(case_scene *play)
{
    uint64_t hashes[VARIANTS] = {0};
    for (int k = 0; k < VARIANTS; k++) {
        print_message("-- %s%s\n", VARIANT[k].name, is_played(k) ? "" : ": not under a sanitizer");
        if (is_played(k)) hashes[k] = play(&VARIANT[k]);
    }
    assert_workers_agree(hashes);
}

/* Where a scene is long: the hash is of this tick, and with more than one worker it ends there. */
static inline bool heard(const daft_world *world, const variant *v, int tick, int when, uint64_t *hash)
{
    if (tick == when) *hash = daft_world_hash(world, 0);
    return tick == when && v->workers > 1;
}

/* Of several worlds, one after the other. */
static inline uint64_t hash_of_both(uint64_t before, uint64_t next) { return before * 1099511628211u ^ next; }

static inline double distance_of(daft_dvec3 a, daft_dvec3 b)
{
    daft_dvec3 d = daft_dsub(a, b);
    return sqrt(daft_ddot(d, d));
}

/* The angle between the body's own y axis and the world's, radians. */
static inline double tilt_of(const daft_world *world, uint32_t body)
{
    daft_quat q = state_of(world, body).rotation;
    double x = 2 * ((double)q.x * (double)q.y - (double)q.w * (double)q.z),
           z = 2 * ((double)q.y * (double)q.z + (double)q.w * (double)q.x),
           y = 1 - 2 * ((double)q.x * (double)q.x + (double)q.z * (double)q.z);
    return daft_atan2(hypot(x, z), y);
}

/* Of motion, in J. */
static inline double energy_of(const daft_world *world, uint32_t body, daft_vec3 half)
{
    daft_sim_state s = state_of(world, body);
    daft_rigid frame = daft_rigid_make(s.position, s.rotation);
    daft_dvec3 w = daft_rigid_to_local_vector(&frame, daft_to_double(s.angular)), h = daft_to_double(half);
    double third = (double)daft_world_mass(world, body) / 3;
    return 0.5 * (3 * third * speed_of(s) * speed_of(s) +
                  third * ((h.y * h.y + h.z * h.z) * w.x * w.x + (h.x * h.x + h.z * h.z) * w.y * w.y +
                           (h.x * h.x + h.y * h.y) * w.z * w.z));
}

/* Round its y axis, of so many sides. */
static inline daft_hull *prism(double radius, double half_height, int sides)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_error error = {0};
    daft_vec3 p[64];
    for (int i = 0; i < sides; i++) {
        double angle = 2 * DAFT_PI * i / sides;
        float x = (float)(radius * daft_cos(angle)), z = (float)(radius * daft_sin(angle));
        p[2 * i] = daft_v3(x, (float)half_height, z), p[2 * i + 1] = daft_v3(x, (float)-half_height, z);
    }
    daft_hull *hull = daft_hull_create(&allocator, p, 2 * (uint32_t)sides, 0, &error);
    if (!hull) fail_msg("%s", error.message);
    return hull;
}

static inline daft_hull *cylinder(double radius, double half_height)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_error error = {0};
    daft_hull *hull = daft_hull_create_cylinder(&allocator, (float)radius, (float)half_height, &error);
    if (!hull) fail_msg("%s", error.message);
    return hull;
}

#endif
