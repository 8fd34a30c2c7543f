/* Bodies in free rotation, for angular_kernel.c, and what far turns do to inertia. */
#include "sim/solve/solver.h"

#include <string.h>

/* Bodies under constraints are left to these where they turn slowly: what is lost is second order in the turn of a
 * substep. */
#define SLOW_TURN 0.02f /* rad */
#define NO_TURN   1e-6f

bool daft_sim_integrates_angular(const daft_world *world, uint32_t row)
{
    const daft_sim_solver *s = world->scratch.solver;
    const daft_sim_body *body = &world->bodies[s->row_bodies[row]];
    if (body->kind != DAFT_BODY_DYNAMIC || body->round || body->locks & DAFT_LOCK_ROTATION) return false;
    float turn = daft_length(body->angular) * s->h;
    return turn > (s->constrained[row] ? SLOW_TURN : NO_TURN) && turn < DAFT_SIM_WILD_TURN;
}

void daft_sim_angular_add(daft_world *world, uint32_t row)
{
    daft_sim_solver *s = world->scratch.solver;
    const daft_sim_body *body = &world->bodies[s->row_bodies[row]];
    if (s->angular_count == 0 || s->angular[s->angular_count - 1].lanes == DAFT_SIM_LANES) {
        daft_sim_angular *fresh = &s->angular[s->angular_count++];
        memset(fresh, 0, sizeof *fresh);
        for (int lane = 0; lane < DAFT_SIM_LANES; lane++)
            for (int k = 0; k < 4; k++)
                fresh->axes[k][lane] = fresh->moments[k % 3][lane] = 1; /* no lane divides by 0 */
    }
    daft_sim_angular *spin = &s->angular[s->angular_count - 1];
    int lane = spin->lanes++;
    daft_quat axes = daft_quat_mul(body->rotation, body->axes);
    spin->row[lane] = (int32_t)row;
    spin->axes[0][lane] = axes.x, spin->axes[1][lane] = axes.y, spin->axes[2][lane] = axes.z;
    spin->axes[3][lane] = axes.w;
    spin->moments[0][lane] = body->moments.x, spin->moments[1][lane] = body->moments.y;
    spin->moments[2][lane] = body->moments.z;
}

/* ---- far turns ---- */

#define FAR_TURN 0.4f /* rad in a step */

static void refresh(const daft_world *world, uint32_t row)
{
    const daft_sim_solver_bodies *rows = &world->scratch.solver->rows;
    size_t at = (size_t)row * DAFT_SIM_ROW;
    const float *turn = rows->turn + at;
    const daft_sim_body *body = &world->bodies[world->scratch.solver->row_bodies[row]];
    daft_quat q = {turn[0], turn[1], turn[2], turn[3]};
    daft_rigid frame = daft_rigid_make(daft_dv3(0, 0, 0), daft_quat_mul(q, body->rotation));
    daft_sim_body_inverse_inertia(body, &frame, rows->mass + at + 1);
}

bool daft_sim_angular_refresh(const daft_world *world, uint32_t first, uint32_t count, float dt)
{
    const daft_sim_solver *s = world->scratch.solver;
    enum { MOST = 32 };
    bool any = false;
    for (uint32_t i = 0; i < count; i += MOST) {
        uint32_t far = s->motion_kernels->find_far(&s->rows, first + i, daft_min_u(count - i, MOST), FAR_TURN / dt);
        any |= far != 0;
        for (; far; far &= far - 1) refresh(world, first + i + (uint32_t)__builtin_ctz(far));
    }
    return any;
}
