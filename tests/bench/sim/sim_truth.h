/* Small worlds whose motion is known, to measure the accuracy of the simulation. Each has a closed form, or equations
 * that are integrated here in double, independently of the engine. */
#ifndef DAFT_BENCH_SIM_TRUTH_H
#define DAFT_BENCH_SIM_TRUTH_H

#include "sim/sim.h"

enum { TRUTH_BODIES = 32, TRUTH_FRAMES_HZ = 30, TRUTH_SECONDS = 10, TRUTH_FRAMES = TRUTH_FRAMES_HZ * TRUTH_SECONDS };

typedef struct truth_run {
    daft_world *world;
    uint32_t bodies[TRUTH_BODIES], joints[TRUTH_BODIES];
    daft_sim_shape shapes[TRUTH_BODIES];
    uint32_t body_count, joint_count;
    bool failed;
} truth_run;

typedef struct truth_case {
    const char *name;
    int seconds;
    void (*build)(truth_run *run);                  /* in an empty world; sets `failed` if it cannot */
    daft_dvec3 (*point)(const truth_run *run);      /* the point that is watched */
    void (*exact)(int seconds, daft_dvec3 *frames); /* where it is after each 1/30 s; NULL: not known */
    double (*overlap)(const truth_run *run);        /* of neighbours, metres; NULL: nothing touches */
    double (*drift)(const truth_run *run);          /* of what should stand, metres; NULL: nothing should */
    bool conservative;                              /* its energy should stay */
} truth_case;

enum { TRUTH_CASES = 6 };
extern const truth_case TRUTH[TRUTH_CASES];

double truth_energy(const truth_run *run); /* J, of all that moves; potential 0 at y = 0 */
double truth_kinetic(const truth_run *run);
double truth_stretch(const truth_run *run); /* metres between the anchors of a joint, at most */

#endif
