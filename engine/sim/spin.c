/* Free rotation. Semi-implicit Euler on the angular velocity gains energy where the moments of inertia differ, and an
 * implicit step of Newton's loses a fifth to a half of it in a minute. Here it is the implicit midpoint rule on Euler's
 * equations in the principal axes,
 *     I·w - h/2 (I·w) × w = L,                              w: in the middle of the substep; L: momentum at its start
 * whose solution keeps both |L| and the energy, since both are quadratic; turning the body by the Cayley map of h·w is
 * what takes L at the start to L at the end, so the momentum in the world stays what it is (Austin, Krishnaprasad and
 * Wang, "Almost Poisson Integration of Rigid Body Systems", J. Comput. Phys. 107, 1993; Lewis and Simo, J. Nonlinear
 * Sci. 4, 1994). Contacts and joints act on w in between. */
#include "sim/solver.h"

enum { NEWTON_STEPS = 3 }; /* from the speed at the start: errors of |h·w|^2, ^4, ^8 … */

typedef struct vec {
    double v[3];
} vec;

static vec cross(vec a, vec b)
{
    return (vec){{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2],
                  a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

/* J·x = f by Cramer's rule; J is row-major and close to diag(I) for the turns of a substep. */
static vec solve3(const double j[9], vec f)
{
    vec a = {{j[0], j[3], j[6]}}, b = {{j[1], j[4], j[7]}}, c = {{j[2], j[5], j[8]}};
    vec bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    double det = a.v[0] * bc.v[0] + a.v[1] * bc.v[1] + a.v[2] * bc.v[2];
    if (det == 0) return (vec){{0, 0, 0}};
    double s = 1 / det;
    return (vec){{s * (f.v[0] * bc.v[0] + f.v[1] * bc.v[1] + f.v[2] * bc.v[2]),
                  s * (f.v[0] * ca.v[0] + f.v[1] * ca.v[1] + f.v[2] * ca.v[2]),
                  s * (f.v[0] * ab.v[0] + f.v[1] * ab.v[1] + f.v[2] * ab.v[2])}};
}

/* The angular velocity in the middle, from that at the start; principal axes. */
static vec midpoint(const double inertia[3], vec start, double h)
{
    vec w = start;
    for (int i = 0; i < NEWTON_STEPS; i++) {
        vec l = {{inertia[0] * w.v[0], inertia[1] * w.v[1], inertia[2] * w.v[2]}}, lw = cross(l, w), f;
        for (int k = 0; k < 3; k++) f.v[k] = l.v[k] - 0.5 * h * lw.v[k] - inertia[k] * start.v[k];
        const double *I = inertia, *x = w.v, *m = l.v, half = 0.5 * h;
        /* d(I w × w) = -[w]× I + [I w]× */
        const double j[9] = {I[0],
                             -half * (x[2] * I[1] - m[2]),
                             -half * (m[1] - x[1] * I[2]),
                             -half * (m[2] - x[2] * I[0]),
                             I[1],
                             -half * (x[0] * I[2] - m[0]),
                             -half * (x[1] * I[0] - m[1]),
                             -half * (m[0] - x[0] * I[1]),
                             I[2]};
        vec d = solve3(j, f);
        for (int k = 0; k < 3; k++) w.v[k] -= d.v[k];
    }
    return w;
}

/* Principal axes in the world, as the body is turned now: a row-major rotation. */
static void principal_axes(const daft_world *world, uint32_t row, double m[9])
{
    const daft_sim_body *body = &world->bodies[world->solver->row_bodies[row]];
    const float *t = world->solver->rows.turn + (size_t)row * DAFT_SIM_ROW;
    daft_quat turn = {t[0], t[1], t[2], t[3]};
    daft_rigid frame =
        daft_rigid_make(daft_dv3(0, 0, 0), daft_quat_mul(turn, daft_quat_mul(body->rotation, body->axes)));
    for (int i = 0; i < 9; i++) m[i] = frame.m[i];
}

void daft_sim_spin_before(const daft_world *world, daft_sim_spin *spin, float h)
{
    const daft_sim_body *body = &world->bodies[world->solver->row_bodies[spin->row]];
    float *v = world->solver->rows.velocity + (size_t)spin->row * DAFT_SIM_ROW + 3;
    double m[9], inertia[3] = {(double)body->moments.x, (double)body->moments.y, (double)body->moments.z};
    principal_axes(world, spin->row, m);
    vec start, middle;
    for (int k = 0; k < 3; k++)
        start.v[k] = m[k] * (double)v[0] + m[3 + k] * (double)v[1] + m[6 + k] * (double)v[2];
    middle = midpoint(inertia, start, (double)h);
    for (int k = 0; k < 3; k++) {
        spin->momentum[k] = m[3 * k] * inertia[0] * start.v[0] + m[3 * k + 1] * inertia[1] * start.v[1] +
                            m[3 * k + 2] * inertia[2] * start.v[2];
        v[k] = (float)(m[3 * k] * middle.v[0] + m[3 * k + 1] * middle.v[1] + m[3 * k + 2] * middle.v[2]);
        spin->middle[k] = v[k];
    }
}

/* Momentum in the principal axes from that in the world. */
static vec to_axes(const double m[9], const double l[3])
{
    vec out;
    for (int k = 0; k < 3; k++) out.v[k] = m[k] * l[0] + m[3 + k] * l[1] + m[6 + k] * l[2];
    return out;
}

/* Changes of velocity within a step that turn the body by more in a step, in radians, are no part of the midpoint rule: the
 * momentum of a long body, seen in axes that are off by a part of that, would spin it about its length. */
#define MAX_JOLT 0.08

void daft_sim_spin_between(const daft_world *world, daft_sim_spin *spin, float h, float dt)
{
    const daft_sim_body *body = &world->bodies[world->solver->row_bodies[spin->row]];
    const float *v = world->solver->rows.velocity + (size_t)spin->row * DAFT_SIM_ROW + 3;
    double m[9], d[3], inertia[3] = {(double)body->moments.x, (double)body->moments.y, (double)body->moments.z};
    for (int k = 0; k < 3; k++) d[k] = (double)v[k] - (double)spin->middle[k];
    spin->jolts += sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * (double)dt;
    spin->jolted = spin->jolts > MAX_JOLT || daft_length(daft_v3(v[0], v[1], v[2])) * h > DAFT_SIM_WILD_TURN;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) return;
    principal_axes(world, spin->row, m);
    vec change = to_axes(m, d);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) spin->momentum[k] += m[3 * k + i] * inertia[i] * change.v[i];
}

void daft_sim_spin_after(const daft_world *world, const daft_sim_spin *spin)
{
    const daft_sim_body *body = &world->bodies[world->solver->row_bodies[spin->row]];
    float *v = world->solver->rows.velocity + (size_t)spin->row * DAFT_SIM_ROW + 3;
    double m[9], inertia[3] = {(double)body->moments.x, (double)body->moments.y, (double)body->moments.z};
    if (spin->jolted) return;
    principal_axes(world, spin->row, m);
    vec l = to_axes(m, spin->momentum);
    for (int k = 0; k < 3; k++) l.v[k] /= inertia[k];
    for (int k = 0; k < 3; k++) {
        double w = m[3 * k] * l.v[0] + m[3 * k + 1] * l.v[1] + m[3 * k + 2] * l.v[2];
        if (fabs(w) <= (double)DAFT_SIM_MAX_SPIN) v[k] = (float)w;
    }
}

/* ---- far turns ---- */

#define FAR_TURN 0.4f /* rad in a step */

bool daft_sim_spin_refresh(const daft_world *world, uint32_t row, float dt)
{
    const daft_sim_rows *rows = &world->solver->rows;
    size_t at = (size_t)row * DAFT_SIM_ROW;
    const float *v = rows->velocity + at + 3;
    float *turn = rows->turn + at, most = FAR_TURN / dt;
    turn[4] = turn[5] != 0 && v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > most * most;
    if (turn[4] == 0) return false;
    daft_sim_body body = world->bodies[world->solver->row_bodies[row]];
    daft_quat q = {turn[0], turn[1], turn[2], turn[3]};
    body.frame = daft_rigid_make(daft_dv3(0, 0, 0), daft_quat_mul(q, body.rotation));
    daft_sim_body_inverse_inertia(&body, rows->mass + at + 1);
    return true;
}
