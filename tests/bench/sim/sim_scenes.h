/* Shared by the benchmarks of the simulation: scenes as data, from which each engine builds its world, and one measure
 * of the poses that come out. */
#ifndef DAFT_BENCH_SIM_SCENES_H
#define DAFT_BENCH_SIM_SCENES_H

#include "harness/bench.h"

#include "sim/sim.h"

/* Dynamic, of 1,000 kg/m³, friction 0.6, no restitution. */
typedef struct sim_body {
    daft_sim_shape shape; /* sphere, box, or capsule along y */
    daft_dvec3 position;
    daft_quat rotation;
    bool asleep;   /* at first */
    bool restless; /* never sleeps */
} sim_body;

/* Of two bodies: a ball, or a hinge about `axis` from `lower` to `upper`. */
typedef struct sim_joint {
    uint32_t a, b;
    daft_dvec3 anchor;
    bool hinge;
    daft_vec3 axis;
    float lower, upper; /* radians, from the pose at the start */
} sim_joint;

/* All stand on a floor, whose top is at y = 0, within walls. */
typedef struct sim_scene {
    sim_body *bodies;
    sim_joint *joints;
    uint32_t body_count, joint_count;
    size_t body_capacity, joint_capacity;
    double half[2]; /* of the space between the walls, along x and z, metres; 0: there are none */
    bool sleeping;  /* bodies may fall asleep */
} sim_scene;

/* False when memory is out. Released with bench_sim_scene_free, whatever was given. */
bool bench_sim_heap(bench *self, uint32_t columns, uint32_t rows, uint32_t layers, sim_scene *out);
bool bench_sim_stack(bench *self, uint32_t boxes, sim_scene *out);
bool bench_sim_ragdolls(bench *self, uint32_t count, sim_scene *out); /* of 11 bodies, in layers of a hundred */
bool bench_sim_sleepers(bench *self, uint32_t count, sim_scene *out); /* boxes that do not touch, and one more awake */
void bench_sim_scene_free(bench *self, sim_scene *scene);

enum { BENCH_SIM_HZ = 60 };

/* An engine. Worlds step BENCH_SIM_HZ times a second, with the engine's default accuracy. */
typedef struct sim_engine {
    const char *name;
    void *(*create)(bench *self, const sim_scene *scene, int threads); /* NULL on failure */
    void (*destroy)(void *world);
    bool (*step)(void *world);
    daft_rigid (*pose)(void *world, uint32_t body); /* body: its place in the scene */
} sim_engine;

const sim_engine *bench_sim_ours(void);
const sim_engine *bench_find_ode(void); /* NULL where ODE is not part of this build */

/* How deep bodies overlap, and how far joints open. */
typedef struct sim_faults {
    double deepest, depth_sum; /* metres; over points of contact at which surfaces overlap */
    double widest;             /* metres between the anchors of a joint, at most */
    uint64_t points;
} sim_faults;

/* Adds the faults of the current poses. False: out of memory. */
bool bench_sim_look(bench *self, const sim_scene *scene, const sim_engine *engine, void *world, sim_faults *faults);

#endif
