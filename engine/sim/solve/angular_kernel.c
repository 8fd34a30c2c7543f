/* Free rotation, in lanes. Semi-implicit Euler on the angular velocity gains energy where the moments of inertia
 * differ, and an implicit step of Newton's loses a fifth to a half of it in a minute. Here it is the implicit midpoint
 * rule on Euler's equations in the principal axes,
 *
 *     I·w - h/2 (I·w) × w = L,    w: in the middle of the substep; L: momentum at its start
 *
 * whose solution keeps both |L| and the energy, since both are
 * quadratic; turning the body by the Cayley map of h·w is what takes L at the start to L at the end, so the momentum in
 * the world stays what it is (Austin, Krishnaprasad and Wang, "Almost Poisson Integration of Rigid Body Systems", J.
 * Comput. Phys. 107, 1993; Lewis and Simo, J. Nonlinear Sci. 4, 1994). Contacts and joints act on w in between.
 * Velocities are floats, what is kept of them is computed in double. */
#include "sim/solve/lanes.h"

enum { NEWTON_STEPS = 3 }; /* from the speed at the start: errors of |h·w|^2, ^4, ^8 … */

/* Half of the lanes of a block that are taken at once, in double. */
enum { HALF = DAFT_VL / 2 };

typedef struct vd3 {
    vd x, y, z;
} vd3;

DAFT_INLINE vd3 widen(vf3 a, int half)
{
    return (vd3){vd_promote_half(a.x, half), vd_promote_half(a.y, half), vd_promote_half(a.z, half)};
}
DAFT_INLINE vf3 narrow(const vd3 a[2])
{
    return (vf3){vf_demote2(a[0].x, a[1].x), vf_demote2(a[0].y, a[1].y), vf_demote2(a[0].z, a[1].z)};
}
DAFT_INLINE vd3 vd3_cross(vd3 a, vd3 b)
{
    return (vd3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE vd vd3_dot(vd3 a, vd3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DAFT_INLINE vd3 vd3_mul(vd3 a, vd3 b) { return (vd3){a.x * b.x, a.y * b.y, a.z * b.z}; }

/* The principal axes as the body is turned now. */
typedef struct axes {
    vd3 row[3]; /* of the matrix that takes them to the world */
} axes;

DAFT_INLINE vd3 to_world(const axes *m, vd3 v)
{
    return (vd3){vd3_dot(m->row[0], v), vd3_dot(m->row[1], v), vd3_dot(m->row[2], v)};
}
DAFT_INLINE vd3 to_axes(const axes *m, vd3 v)
{
    const vd3 *r = m->row;
    return (vd3){r[0].x * v.x + r[1].x * v.y + r[2].x * v.z, r[0].y * v.x + r[1].y * v.y + r[2].y * v.z,
                 r[0].z * v.x + r[1].z * v.y + r[2].z * v.z};
}

/* turn·axes, as floats. */
DAFT_INLINE quat load_axes(const daft_sim_solver_bodies *rows, const daft_sim_angular *spin, int lane)
{
    vf row[8];
    vf_gather_rows8(rows->turn, spin->row + lane, row);
    quat a = {row[0], row[1], row[2], row[3]};
    quat b = {vf_load(spin->axes[0] + lane), vf_load(spin->axes[1] + lane), vf_load(spin->axes[2] + lane),
              vf_load(spin->axes[3] + lane)};
    return quat_mul(a, b);
}
/* A rotation however long the rounded quaternion is: what it is off by would add up to energy. */
DAFT_INLINE axes make_axes(quat q, int half)
{
    vd x = vd_promote_half(q.x, half), y = vd_promote_half(q.y, half), z = vd_promote_half(q.z, half),
       w = vd_promote_half(q.w, half);
    vd s = 2 / (x * x + y * y + z * z + w * w);
    return (axes){{{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
                   {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)},
                   {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)}}};
}
/* 0 where det is. */
DAFT_INLINE vd inverse_of(vd det)
{
    const vd none = {0};
    return (vd)((vl)(1 / det) & (vl)(det != none));
}

/* One step of Newton's: J·x = f by Cramer's rule; J, the derivative of f, is close to diag(I) for the turns of a
 * substep. */
DAFT_INLINE vd3 newton_step(vd3 inertia, vd3 w, vd3 start, vd half_h)
{
    vd3 l = vd3_mul(inertia, w), lw = vd3_cross(l, w), i = inertia;
    vd3 f = {l.x - half_h * lw.x - i.x * start.x, l.y - half_h * lw.y - i.y * start.y,
             l.z - half_h * lw.z - i.z * start.z};
    /* d(I w × w) = -[w]× I + [I w]×; by columns. */
    vd3 a = {i.x, -half_h * (l.z - w.z * i.x), -half_h * (w.y * i.x - l.y)};
    vd3 b = {-half_h * (w.z * i.y - l.z), i.y, -half_h * (l.x - w.x * i.y)};
    vd3 c = {-half_h * (l.y - w.y * i.z), -half_h * (w.x * i.z - l.x), i.z};
    vd3 bc = vd3_cross(b, c), ca = vd3_cross(c, a), ab = vd3_cross(a, b);
    vd s = inverse_of(vd3_dot(a, bc));
    return (vd3){w.x - s * vd3_dot(f, bc), w.y - s * vd3_dot(f, ca), w.z - s * vd3_dot(f, ab)};
}

DAFT_INLINE vd3 load_moments(const daft_sim_angular *spin, int lane, int half)
{
    return widen(load3(spin->moments, lane), half);
}
DAFT_INLINE vd3 load_momentum(const daft_sim_angular *spin, int at)
{
    return (vd3){vd_load(spin->momentum[0] + at), vd_load(spin->momentum[1] + at), vd_load(spin->momentum[2] + at)};
}
DAFT_INLINE void store_momentum(daft_sim_angular *spin, int at, vd3 l)
{
    vd_store(spin->momentum[0] + at, l.x);
    vd_store(spin->momentum[1] + at, l.y);
    vd_store(spin->momentum[2] + at, l.z);
}
DAFT_INLINE vbits used(const daft_sim_angular *spin, int lane) { return vbits_first_n(spin->lanes - lane); }

DAFT_INLINE void before_lanes(const daft_sim_solver_bodies *rows, daft_sim_angular *spin, float h, int lane)
{
    body b = load_body(rows->velocity, spin->row + lane);
    quat q = load_axes(rows, spin, lane);
    const vd none = {0};
    vd half_h = none + 0.5 * (double)h;
    vd3 after[2];
    for (int half = 0; half < 2; half++) {
        axes m = make_axes(q, half);
        vd3 inertia = load_moments(spin, lane, half), start = to_axes(&m, widen(b.w, half)), w = start;
        for (int i = 0; i < NEWTON_STEPS; i++) w = newton_step(inertia, w, start, half_h);
        store_momentum(spin, lane + half * HALF, to_world(&m, vd3_mul(inertia, start)));
        after[half] = to_world(&m, w);
    }
    b.w = narrow(after);
    store3(spin->middle, lane, b.w);
    store_body(rows->velocity, spin->row + lane, &b, used(spin, lane));
}

/* Changes of velocity within a step that turn the body by more in a step, in radians, are no part of the midpoint rule:
 * the momentum of a long body, seen in axes that are off by a part of that, would spin it about its length. */
#define MAX_JOLT 0.08f

DAFT_INLINE void between_lanes(const daft_sim_solver_bodies *rows, daft_sim_angular *spin, float h, float dt, int lane)
{
    body b = load_body(rows->velocity, spin->row + lane);
    quat q = load_axes(rows, spin, lane);
    vf3 change = vf3_sub(b.w, load3(spin->middle, lane));
    vf jolts = vf_load(spin->jolts + lane) + vf_sqrt(vf3_dot(change, change)) * vf_set(dt);
    vf turn = vf_sqrt(vf3_dot(b.w, b.w)) * vf_set(h);
    vm jolted = vm_or(vf_lt(vf_set(MAX_JOLT), jolts), vf_lt(vf_set(DAFT_SIM_WILD_TURN), turn));
    vf_store(spin->jolts + lane, jolts);
    vf_store(spin->jolted + lane, vf_if_then_else(jolted, vf_set(1), vf_set(0)));
    for (int half = 0; half < 2; half++) {
        int at = lane + half * HALF;
        axes m = make_axes(q, half);
        vd3 l = load_momentum(spin, at);
        vd3 more = to_world(&m, vd3_mul(load_moments(spin, lane, half), to_axes(&m, widen(change, half))));
        store_momentum(spin, at, (vd3){l.x + more.x, l.y + more.y, l.z + more.z});
    }
}

DAFT_INLINE vf bounded(vf w, vm jolted, vf was)
{
    return vf_if_then_else(vm_and(vf_le(vf_abs(w), vf_set(DAFT_SIM_MAX_ANGULAR_SPEED)), vm_not(jolted)), w, was);
}

DAFT_INLINE void after_lanes(const daft_sim_solver_bodies *rows, daft_sim_angular *spin, int lane)
{
    vm jolted = vf_lt(vf_set(0), vf_load(spin->jolted + lane));
    body b = load_body(rows->velocity, spin->row + lane);
    quat q = load_axes(rows, spin, lane);
    vd3 after[2];
    for (int half = 0; half < 2; half++) {
        axes m = make_axes(q, half);
        vd3 l = to_axes(&m, load_momentum(spin, lane + half * HALF)), inertia = load_moments(spin, lane, half);
        after[half] = to_world(&m, (vd3){l.x / inertia.x, l.y / inertia.y, l.z / inertia.z});
    }
    vf3 w = narrow(after);
    b.w = (vf3){bounded(w.x, jolted, b.w.x), bounded(w.y, jolted, b.w.y), bounded(w.z, jolted, b.w.z)};
    store_body(rows->velocity, spin->row + lane, &b, used(spin, lane));
}

/* ---- blocks ---- */

static void before(const daft_sim_solver_bodies *rows, daft_sim_angular *spins, uint32_t count, float h)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < spins[i].lanes; lane += DAFT_VL) before_lanes(rows, &spins[i], h, lane);
}
static void between(const daft_sim_solver_bodies *rows, daft_sim_angular *spins, uint32_t count, float h, float dt)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < spins[i].lanes; lane += DAFT_VL) between_lanes(rows, &spins[i], h, dt, lane);
}
static void after(const daft_sim_solver_bodies *rows, daft_sim_angular *spins, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        for (int lane = 0; lane < spins[i].lanes; lane += DAFT_VL) after_lanes(rows, &spins[i], lane);
}

const daft_sim_angular_kernels DAFT_KERNEL(daft_sim_angular) = {before, between, after};
