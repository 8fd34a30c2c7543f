/* The worlds whose motion is known. */
#include "sim_truth.h"

#include "math/trig.h"

static const double GRAVITY = (double)9.81f;

/* ---- building ---- */

static void add(truth_run *run, daft_body_kind kind, daft_sim_shape shape, daft_dvec3 at, daft_quat turn, float mass,
                float friction)
{
    daft_sim_shape_def part = daft_default_sim_shape_def();
    part.shape = shape, part.material.friction = friction;
    if (run->joint_count) part.mask = 0; /* linked bodies do not collide */
    daft_sim_body_def def = daft_default_sim_body_def();
    def.kind = kind, def.position = at, def.rotation = turn, def.mass = mass, def.shapes = &part, def.shape_count = 1;
    uint32_t body = daft_world_add(run->world, &def, NULL);
    run->failed |= body == 0;
    if (kind != DAFT_BODY_DYNAMIC || run->failed) return;
    run->shapes[run->body_count] = shape;
    run->bodies[run->body_count++] = body;
}

static void join(truth_run *run, uint32_t a, uint32_t b, daft_dvec3 anchor)
{
    daft_sim_joint_def def = daft_default_sim_joint_def();
    def.kind = DAFT_JOINT_BALL, def.body_a = a, def.body_b = b, def.anchor = anchor;
    uint32_t joint = daft_world_add_joint(run->world, &def, NULL);
    run->failed |= joint == 0;
    if (!run->failed) run->joints[run->joint_count++] = joint;
}

static daft_sim_shape ball_of(float radius)
{
    daft_sim_shape shape;
    daft_shape_sphere(radius, &shape, NULL);
    return shape;
}

static daft_sim_shape box_of(float x, float y, float z)
{
    daft_sim_shape shape;
    daft_shape_box(daft_v3(x, y, z), &shape, NULL);
    return shape;
}

static daft_quat about_z(double angle)
{
    return (daft_quat){0, 0, (float)daft_sin(angle / 2), (float)daft_cos(angle / 2)};
}

static daft_sim_state state_of(const truth_run *run, uint32_t body)
{
    daft_sim_state state;
    daft_world_get(run->world, run->bodies[body], &state);
    return state;
}

static daft_dvec3 first_point(const truth_run *run) { return state_of(run, 0).position; }
static daft_dvec3 last_point(const truth_run *run) { return state_of(run, run->body_count - 1).position; }

/* ---- a projectile: x = v t, y = v t - g t^2 / 2 ---- */

static void build_projectile(truth_run *run)
{
    add(run, DAFT_BODY_DYNAMIC, ball_of(0.1f), daft_dv3(0, 0, 0), daft_quat_identity(), 1, 0.6f);
    if (!run->failed) daft_world_set_velocity(run->world, run->bodies[0], daft_v3(10, 10, 0), daft_v3(0, 0, 0));
}

static void exact_projectile(int seconds, daft_dvec3 *frames)
{
    for (int i = 0; i < seconds * TRUTH_FRAMES_HZ; i++) {
        double t = (double)(i + 1) / TRUTH_FRAMES_HZ;
        frames[i] = daft_dv3(10 * t, 10 * t - 0.5 * GRAVITY * t * t, 0);
    }
}

/* ---- a pendulum of 1 m from the horizontal: a'' = -g L / (L^2 + 2/5 r^2) sin a ---- */

static const float BOB = 0.1f;

static void build_pendulum(truth_run *run)
{
    add(run, DAFT_BODY_DYNAMIC, ball_of(BOB), daft_dv3(1, 0, 0), daft_quat_identity(), 1, 0.6f);
    if (!run->failed) join(run, 0, run->bodies[0], daft_dv3(0, 0, 0));
}

static void exact_pendulum(int seconds, daft_dvec3 *frames)
{
    enum { PARTS = 200 }; /* of a frame: Runge and Kutta's error is below 1e-12 then */
    double a = DAFT_PI / 2, w = 0, h = 1.0 / (TRUTH_FRAMES_HZ * PARTS);
    double pull = -GRAVITY / (1 + 0.4 * (double)BOB * (double)BOB);
    for (int i = 0; i < seconds * TRUTH_FRAMES_HZ * PARTS; i++) {
        double w1 = w, f1 = pull * daft_sin(a);
        double w2 = w + 0.5 * h * f1, f2 = pull * daft_sin(a + 0.5 * h * w1);
        double w3 = w + 0.5 * h * f2, f3 = pull * daft_sin(a + 0.5 * h * w2);
        double w4 = w + h * f3, f4 = pull * daft_sin(a + h * w3);
        a += h / 6 * (w1 + 2 * w2 + 2 * w3 + w4);
        w += h / 6 * (f1 + 2 * f2 + 2 * f3 + f4);
        if (i % PARTS == PARTS - 1) frames[i / PARTS] = daft_dv3(daft_sin(a), -daft_cos(a), 0);
    }
}

/* ---- a ball of 100 kg on a chain of 20 links of 1 kg, let go at 45 degrees ---- */

static void build_chain(truth_run *run)
{
    enum { LINKS = 20 };
    const double c = sqrt(0.5), link = 0.2;
    daft_quat turn = about_z(-DAFT_PI / 4);
    uint32_t last = 0;
    for (int i = 0; i <= LINKS && !run->failed; i++) {
        double top = i * link, middle = top + (i < LINKS ? 0.5 * link : 0.3);
        daft_sim_shape shape = i < LINKS ? box_of(0.1f, 0.03f, 0.03f) : ball_of(0.3f);
        add(run, DAFT_BODY_DYNAMIC, shape, daft_dv3(c * middle, -c * middle, 0), turn, i < LINKS ? 1.0f : 100.0f, 0.6f);
        if (!run->failed) join(run, last, run->bodies[run->body_count - 1], daft_dv3(c * top, -c * top, 0));
        last = run->bodies[run->body_count - 1];
    }
}

/* ---- a stack of ten boxes, which stays as it is ---- */

static void build_stack(truth_run *run)
{
    add(run, DAFT_BODY_STATIC, box_of(20, 1, 20), daft_dv3(0, -1, 0), daft_quat_identity(), 0, 0.6f);
    for (int i = 0; i < 10; i++)
        add(run, DAFT_BODY_DYNAMIC, box_of(0.5f, 0.5f, 0.5f), daft_dv3(0, 0.5 + i, 0), daft_quat_identity(), 0, 0.6f);
}

static void exact_stack(int seconds, daft_dvec3 *frames)
{
    for (int i = 0; i < seconds * TRUTH_FRAMES_HZ; i++) frames[i] = daft_dv3(0, 9.5, 0);
}

static double stack_overlap(const truth_run *run)
{
    double most = 0, below = -0.5;
    for (uint32_t i = 0; i < run->body_count; i++) {
        double y = state_of(run, i).position.y;
        most = fmax(most, 1 - (y - below));
        below = y;
    }
    return most;
}

static double stack_drift(const truth_run *run)
{
    daft_dvec3 p = last_point(run);
    return sqrt(p.x * p.x + p.z * p.z);
}

/* ---- two boxes on an incline: one slides with g (sin - m cos), the other should stay ---- */

static const double SLOPE = 0.55; /* its tangent; friction is that over 1.1, and over 0.9 */

static void build_incline(truth_run *run)
{
    double angle = daft_atan2(SLOPE, 1), x = daft_sin(angle), y = daft_cos(angle);
    daft_quat turn = about_z(-angle);
    add(run, DAFT_BODY_STATIC, box_of(50, 1, 5), daft_dv3(-x, -y, 0), turn, 0, 1);
    for (int i = 0; i < 2; i++) {
        double friction = SLOPE / (i ? 0.9 : 1.1); /* of both surfaces; the floor's is 1, and the mean is geometric */
        add(run, DAFT_BODY_DYNAMIC, box_of(0.5f, 0.5f, 0.5f), daft_dv3(0.5 * x, 0.5 * y, i ? 2 : -2), turn, 0,
            (float)(friction * friction));
    }
}

static void exact_incline(int seconds, daft_dvec3 *frames)
{
    double angle = daft_atan2(SLOPE, 1), s = daft_sin(angle), c = daft_cos(angle);
    double pull = GRAVITY * (s - SLOPE / 1.1 * c);
    for (int i = 0; i < seconds * TRUTH_FRAMES_HZ; i++) {
        double t = (double)(i + 1) / TRUTH_FRAMES_HZ, displacement = 0.5 * pull * t * t;
        frames[i] = daft_dv3(0.5 * s + c * displacement, 0.5 * c - s * displacement, -2);
    }
}

static double incline_overlap(const truth_run *run)
{
    double angle = daft_atan2(SLOPE, 1), most = 0;
    for (uint32_t i = 0; i < 2; i++) {
        daft_dvec3 p = state_of(run, i).position;
        most = fmax(most, 0.5 - (p.x * daft_sin(angle) + p.y * daft_cos(angle)));
    }
    return most;
}

static double incline_drift(const truth_run *run)
{
    double angle = daft_atan2(SLOPE, 1), s = daft_sin(angle), c = daft_cos(angle);
    daft_dvec3 off = daft_dsub(last_point(run), daft_dv3(0.5 * s, 0.5 * c, 2));
    double down = off.x * c - off.y * s;
    return sqrt(down * down + off.z * off.z);
}

/* ---- Dzhanibekov's box about its middle axis: Euler's equations ---- */

static const float PAGE[3] = {0.35f, 0.08f, 0.5f};

static void build_spin(truth_run *run)
{
    daft_world_set_gravity(run->world, daft_v3(0, 0, 0));
    add(run, DAFT_BODY_DYNAMIC, box_of(PAGE[0], PAGE[1], PAGE[2]), daft_dv3(0, 0, 0), daft_quat_identity(), 1, 0.6f);
    if (!run->failed) daft_world_set_velocity(run->world, run->bodies[0], daft_v3(0, 0, 0), daft_v3(5, 0.01f, 0.01f));
}

static daft_dvec3 corner(const truth_run *run)
{
    daft_sim_state state = state_of(run, 0);
    daft_rigid pose = daft_rigid_make(state.position, state.rotation);
    return daft_dadd(pose.p, daft_rigid_vector(&pose, daft_dv3((double)PAGE[0], (double)PAGE[1], (double)PAGE[2])));
}

/* s: spin in the body's axes, then the body's three axes in the world's, one after the other. */
static void spin_rate(const double s[12], double rate[12])
{
    double inertia[3]; /* of a kilogram, times three */
    for (int i = 0; i < 3; i++) {
        double b = (double)PAGE[(i + 1) % 3], c = (double)PAGE[(i + 2) % 3];
        inertia[i] = b * b + c * c;
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        rate[i] = (inertia[j] - inertia[k]) * s[j] * s[k] / inertia[i];
        for (int x = 0; x < 3; x++) rate[3 + 3 * i + x] = s[k] * s[3 + 3 * j + x] - s[j] * s[3 + 3 * k + x];
    }
}

static void exact_spin(int seconds, daft_dvec3 *frames)
{
    enum { PARTS = 200 };
    double s[12] = {5, (double)0.01f, (double)0.01f, 1, 0, 0, 0, 1, 0, 0, 0, 1}, h = 1.0 / (TRUTH_FRAMES_HZ * PARTS);
    for (int i = 0; i < seconds * TRUTH_FRAMES_HZ * PARTS; i++) {
        static const double ahead[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
        double rate[12] = {0}, sum[12] = {0};
        for (int stage = 0; stage < 4; stage++) {
            double at[12];
            for (int k = 0; k < 12; k++) at[k] = s[k] + ahead[stage] * h * rate[k];
            spin_rate(at, rate);
            for (int k = 0; k < 12; k++) sum[k] += weight[stage] * rate[k];
        }
        for (int k = 0; k < 12; k++) s[k] += h / 6 * sum[k];
        if (i % PARTS < PARTS - 1) continue;
        double p[3] = {0, 0, 0};
        for (int k = 0; k < 9; k++) p[k % 3] += (double)PAGE[k / 3] * s[3 + k];
        frames[i / PARTS] = daft_dv3(p[0], p[1], p[2]);
    }
}

const truth_case TRUTH[TRUTH_CASES] = {
    {"projectile", 2, build_projectile, first_point, exact_projectile, NULL, NULL, true},
    {"pendulum", 10, build_pendulum, first_point, exact_pendulum, NULL, NULL, true},
    {"ball and chain", 4, build_chain, last_point, NULL, NULL, NULL, true},
    {"stack of 10", 10, build_stack, last_point, exact_stack, stack_overlap, stack_drift, false},
    {"incline", 2, build_incline, first_point, exact_incline, incline_overlap, incline_drift, false},
    {"Dzhanibekov's box", 10, build_spin, corner, exact_spin, NULL, NULL, true},
};

/* ---- what is conserved ---- */

static double spin_energy(const daft_sim_shape *shape, double mass, const daft_sim_state *state)
{
    daft_rigid pose = daft_rigid_make(state->position, state->rotation);
    daft_dvec3 w = daft_rigid_to_local_vector(&pose, daft_to_double(state->angular));
    double r = (double)shape->radius;
    if (shape->type == DAFT_GEOMETRY_SPHERE) return 0.2 * mass * r * r * daft_ddot(w, w);
    daft_dvec3 h = daft_to_double(shape->half);
    return mass / 6 *
           ((h.y * h.y + h.z * h.z) * w.x * w.x + (h.x * h.x + h.z * h.z) * w.y * w.y +
            (h.x * h.x + h.y * h.y) * w.z * w.z);
}

double truth_kinetic(const truth_run *run)
{
    double sum = 0;
    for (uint32_t i = 0; i < run->body_count; i++) {
        daft_sim_state state = state_of(run, i);
        double mass = (double)daft_world_mass(run->world, run->bodies[i]);
        daft_dvec3 v = daft_to_double(state.linear);
        sum += 0.5 * mass * daft_ddot(v, v) + spin_energy(&run->shapes[i], mass, &state);
    }
    return sum;
}

double truth_energy(const truth_run *run)
{
    double sum = truth_kinetic(run);
    for (uint32_t i = 0; i < run->body_count; i++)
        sum += (double)daft_world_mass(run->world, run->bodies[i]) * GRAVITY * state_of(run, i).position.y;
    return sum;
}

double truth_stretch(const truth_run *run)
{
    double most = 0;
    for (uint32_t i = 0; i < run->joint_count; i++) {
        daft_sim_joint_state joint;
        if (!daft_world_get_joint(run->world, run->joints[i], &joint)) continue;
        daft_dvec3 gap = daft_dsub(joint.anchor_a, joint.anchor_b);
        most = fmax(most, sqrt(daft_ddot(gap, gap)));
    }
    return most;
}
