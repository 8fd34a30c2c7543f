/* Collision geometry: manifolds of resting pairs, distances, rays and sweeps, one call after the other on one thread.
 */
#include "harness/bench.h"

#include "accel/accel.h"
#include "sim/collide/manifold.h"

#include <stdio.h>

enum { POSES = 256, CALLS = 40000, GRID = 40 };

typedef enum shape_work { COLLIDE, DISTANCE, RAYCAST, IMPACT } shape_work;

typedef struct shape_job {
    shape_work work;
    daft_sim_shape a, b;
    daft_rigid poses[POSES]; /* b as seen from a */
    daft_relpose relposes[POSES];
    double rate; /* million a second */
    uint64_t found;
} shape_job;

static float random_unit(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (float)(*state >> 40) * 0x1p-23f - 1;
}

static uint64_t one_call(const shape_job *job, uint32_t i)
{
    switch (job->work) {
    case COLLIDE: {
        daft_manifold m[16];
        return daft_collide(&job->a, &job->b, &job->relposes[i], 0.02f, m, 16, NULL);
    }
    case DISTANCE: {
        daft_distance d;
        return daft_shape_distance(&job->a, &job->b, &job->poses[i], INFINITY, &d) && d.distance > 0;
    }
    case RAYCAST: {
        daft_ray_result r;
        return daft_shape_raycast(&job->b, job->poses[i].p, daft_dscale(job->poses[i].p, -1), 1, &r);
    }
    default: {
        daft_impact hit;
        daft_rigid a_in_b = daft_rigid_inverse(&job->poses[i]);
        return daft_shape_cast(&job->a, &a_in_b, daft_dscale(a_in_b.p, -1), &job->b, &hit) == DAFT_IMPACT_HIT;
    }
    }
}

static double rate(void *context)
{
    shape_job *job = context;
    double start = daft_clock_ms();
    job->found = 0;
    for (uint32_t i = 0; i < CALLS; i++) job->found += one_call(job, i % POSES);
    job->rate = CALLS / ((daft_clock_ms() - start) * 1e3);
    return job->rate;
}

static void describe(void *context, char *out, size_t size)
{
    const shape_job *job = context;
    snprintf(out, size, "%.0f ns a call; %.0f%% touch", 1e3 / job->rate, 100.0 * (double)job->found / CALLS);
}

/* b lies about `gap` below a, turned about the vertical and tilted by up to `tilt`. */
static void set_poses(shape_job *job, double gap, float tilt, float spread)
{
    uint64_t state = 7;
    for (uint32_t i = 0; i < POSES; i++) {
        float yaw = random_unit(&state), x = random_unit(&state), z = random_unit(&state);
        daft_quat turn =
            daft_quat_normalize((daft_quat){tilt * random_unit(&state), yaw, tilt * random_unit(&state), 1});
        daft_rigid identity = daft_rigid_identity(), pose = daft_rigid_make(daft_dv3(0, 0, 0), turn);
        daft_daabb a = daft_shape_bounds(&job->a, &identity), b = daft_shape_bounds(&job->b, &pose);
        pose.p = daft_dv3((double)(spread * x), a.low.y - b.high.y - gap, (double)(spread * z));
        if (job->b.type == DAFT_GEOMETRY_MESH) pose.p.y = a.low.y - gap;
        job->poses[i] = pose;
        job->relposes[i] = daft_relpose_make(&identity, &pose);
    }
}

static void measure(bench *self, shape_job *job, const char *what)
{
    if (!bench_wants(self, "sim-shapes", what)) return;
    bench_subject subject = {.scene = "sim-shapes",
                             .what = what,
                             .unit = "M/s",
                             .isa = self->isa,
                             .threads = 1,
                             .ours = rate,
                             .context = job,
                             .describe = describe};
    bench_measure(self, &subject);
}

static daft_hull *some_hull(bench *self, uint32_t points)
{
    daft_vec3 p[128];
    uint64_t state = points;
    for (uint32_t i = 0; i < points; i++) {
        float x = random_unit(&state), y = random_unit(&state);
        p[i] = daft_scale(daft_normalize(daft_v3(x, y, random_unit(&state))), 0.5f);
    }
    return daft_hull_create(&self->allocator, p, points, 0, NULL);
}

static bool flat_grid(bench *self, daft_trimesh *out)
{
    enum { SIDE = GRID + 1 };
    static daft_vec3 p[SIDE * SIDE];
    static uint32_t index[6 * GRID * GRID];
    uint32_t used = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        p[i] = daft_v3((float)(i % SIDE - GRID / 2) * 0.5f, 0, (float)(i / SIDE - GRID / 2) * 0.5f);
    for (uint32_t z = 0; z < GRID; z++)
        for (uint32_t x = 0; x < GRID; x++) {
            uint32_t a = z * SIDE + x, b = a + SIDE;
            const uint32_t corner[6] = {a, b, b + 1, a, b + 1, a + 1};
            for (int k = 0; k < 6; k++) index[used++] = corner[k];
        }
    daft_mesh_def def = {.cookie = DAFT_COOKIE,
                         .positions = p,
                         .vertex_count = SIDE * SIDE,
                         .indices = index,
                         .triangle_count = 2 * GRID * GRID};
    return daft_trimesh_from_arrays(&self->allocator, &def, NULL, out, NULL);
}

static void with_mesh(bench *self, shape_job *job, daft_sim_shape box, daft_sim_shape ball)
{
    daft_trimesh mesh;
    if (!flat_grid(self, &mesh)) return;
    daft_bvh *bvh = daft_bvh_build_mesh(&self->allocator, &mesh, 1, NULL);
    daft_mesh_shape *shape = bvh ? daft_mesh_shape_create(&self->allocator, &mesh, bvh, false, NULL) : NULL;
    if (shape) {
        job->work = COLLIDE;
        job->a = box, job->b = daft_shape_mesh(shape);
        set_poses(job, -0.002, 0, 3);
        measure(self, job, "box on a mesh");
        job->a = ball;
        set_poses(job, -0.002, 0, 3);
        measure(self, job, "sphere on a mesh");
        job->work = IMPACT;
        set_poses(job, 3, 0.5f, 2);
        measure(self, job, "sphere cast at a mesh");
    }
    daft_mesh_shape_free(shape);
    daft_bvh_free(bvh);
    daft_trimesh_free(&self->allocator, &mesh);
}

void bench_sim_shapes(bench *self)
{
    static shape_job job;
    daft_hull *small = some_hull(self, 14), *large = some_hull(self, 64);
    daft_sim_shape box, ball, capsule;
    daft_shape_box(daft_v3(0.5f, 0.5f, 0.5f), &box, NULL);
    daft_shape_sphere(0.5f, &ball, NULL);
    daft_shape_capsule(0.5f, 0.25f, &capsule, NULL);
    if (!small || !large) return;
    const struct {
        const char *what;
        daft_sim_shape a, b;
        double gap;
        float tilt, spread;
        shape_work work;
    } rows[] = {{"boxes, face to face", box, box, -0.002, 0, 0.4f, COLLIDE},
                {"boxes, tilted", box, box, -0.01, 0.3f, 0.4f, COLLIDE},
                {"boxes, near but apart", box, box, 0.1, 0.3f, 0.4f, COLLIDE},
                {"sphere and box", ball, box, -0.002, 0, 0.4f, COLLIDE},
                {"capsule and box", capsule, box, -0.002, 0, 0.4f, COLLIDE},
                {"capsules", capsule, capsule, -0.002, 0.3f, 0.1f, COLLIDE},
                {"hulls of 14", daft_shape_hull(small), daft_shape_hull(small), -0.01, 0.3f, 0.1f, COLLIDE},
                {"hulls of 64", daft_shape_hull(large), daft_shape_hull(large), -0.01, 0.3f, 0.1f, COLLIDE},
                {"distance of boxes", box, box, 0.3, 0.3f, 0.4f, DISTANCE},
                {"distance of hulls of 64", daft_shape_hull(large), daft_shape_hull(large), 0.3, 0.3f, 0.4f, DISTANCE},
                {"ray at a box", box, box, 0.3, 0.3f, 0.4f, RAYCAST},
                {"box cast at a box", box, box, 0.3, 0.3f, 0.4f, IMPACT}};
    for (size_t i = 0; i < DAFT_COUNT_OF(rows); i++) {
        job.a = rows[i].a, job.b = rows[i].b, job.work = rows[i].work;
        set_poses(&job, rows[i].gap, rows[i].tilt, rows[i].spread);
        measure(self, &job, rows[i].what);
    }
    with_mesh(self, &job, box, ball);
    daft_hull_free(small);
    daft_hull_free(large);
}
