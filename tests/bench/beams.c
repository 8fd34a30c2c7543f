/* Long things that lie across the axes: a leaning frame of beams, its tree along the mesh's axes and turned, side by side. */
#include "scenes.h"

#include "math/isa.h"
#include "math/real.h"

#include <stdio.h>
#include <string.h>

/* Beams along three axes that are at right angles, 1.2 by 1 by 1 m: tubes whose triangles are a hundred times as long as
 * wide, as tools for construction make them. */
enum { LONG = 24, CROSS = 8, BEAMS = LONG * LONG + 2 * LONG * CROSS, SIDES = 16, PIECES = 8, RINGS = PIECES + 1, RAYS = 100000 };
static const double RADIUS = 0.004;

typedef struct heap {
    daft_vec3 *positions;
    uint32_t *indices;
    uint32_t beams;
} heap;

/* A tube around an axis of the frame, `turn` being its axes in columns. */
static void add_beam(heap *to, const double turn[9], const double middle[3], int axis, double length)
{
    uint32_t first = to->beams * RINGS * SIDES, next = to->beams * PIECES * SIDES * 6;
    for (uint32_t i = 0; i < RINGS * SIDES; i++) {
        double angle = 2 * DAFT_PI * (i % SIDES) / SIDES, p[3] = {middle[0], middle[1], middle[2]};
        p[axis] += length * ((double)(i / SIDES) / PIECES - 0.5);
        p[(axis + 1) % 3] += RADIUS * daft_cos(angle), p[(axis + 2) % 3] += RADIUS * daft_sin(angle);
        float q[3];
        for (int k = 0; k < 3; k++) q[k] = (float)(turn[3 * k] * p[0] + turn[3 * k + 1] * p[1] + turn[3 * k + 2] * p[2]);
        to->positions[first + i] = daft_v3(q[0], q[1], q[2]);
    }
    for (uint32_t i = 0; i < PIECES * SIDES; i++) {
        uint32_t a = first + i, b = first + i / SIDES * SIDES + (i + 1) % SIDES;
        const uint32_t corners[6] = {a, b, b + SIDES, a, b + SIDES, a + SIDES};
        memcpy(to->indices + next + 6 * i, corners, sizeof corners);
    }
    to->beams++;
}

bool bench_beams_make(bench *self, daft_trimesh *out)
{
    heap all = {.positions = daft_alloc(&self->allocator, BEAMS * RINGS * SIDES, sizeof(daft_vec3)),
                .indices = daft_alloc(&self->allocator, BEAMS * PIECES * SIDES * 6, sizeof(uint32_t))};
    double turn[9], spacing = 1.0 / LONG;
    daft_quat_matrix(daft_quat_normalize((daft_quat){0.18f, 0.35f, 0.42f, 0.82f}), turn);
    for (int i = 0; all.positions && all.indices && i < LONG * LONG; i++) {
        double y = (i % LONG + 0.5) * spacing - 0.5, z = ((double)(i / LONG) + 0.5) * spacing - 0.5;
        add_beam(&all, turn, (double[3]){0, y, z}, 0, 1.2);
        if (i / LONG >= CROSS) continue;
        double x = 1.2 * ((i / LONG + 0.5) / CROSS - 0.5);
        add_beam(&all, turn, (double[3]){x, 0, y + 0.5 * spacing}, 1, 1);
        add_beam(&all, turn, (double[3]){x + 0.01, y + 0.5 * spacing, 0}, 2, 1);
    }
    daft_mesh_def def = daft_default_mesh_def();
    daft_log log = {0};
    def.positions = all.positions, def.vertex_count = BEAMS * RINGS * SIDES;
    def.indices = all.indices, def.triangle_count = BEAMS * PIECES * SIDES * 2;
    bool made = all.positions && all.indices && daft_trimesh_from_arrays(&self->allocator, &def, &log, out, NULL);
    daft_release(&self->allocator, all.positions);
    daft_release(&self->allocator, all.indices);
    return made;
}

/* ---- turned and not ---- */

typedef struct beams_job {
    bench_scene scene[2]; /* the second one is not turned */
    bench_camera *camera[2];
    daft_arena arena;
    daft_instance *instances[2];
    const daft_tlas *tlas[2];
    const daft_accel_kernels *kernels;
    daft_ray *rays;
    daft_ray_packet *packets;
    enum { NEAREST, ANY, TOGETHER } how;
    uint32_t hits[2];
} beams_job;

static double see(beams_job *job, int which)
{
    double ms = bench_camera_ms(job->camera[which], DAFT_INTERSECT_EXACT);
    return ms < 0 ? ms : BENCH_WIDTH * BENCH_HEIGHT / ms / 1e3;
}
static double see_turned(void *context) { return see(context, 0); }
static double see_straight(void *context) { return see(context, 1); }

static double trace(beams_job *job, int which)
{
    const daft_accel_kernels *k = job->kernels;
    const daft_tlas *tlas = job->tlas[which];
    daft_hit hits[DAFT_PACKET];
    uint32_t count = 0;
    double start = bench_clock_ms(1);
    for (uint32_t i = 0; i < RAYS && job->how == NEAREST; i++) count += k->closest(tlas, &job->rays[i], UINT32_MAX, hits);
    for (uint32_t i = 0; i < RAYS && job->how == ANY; i++) count += k->occluded(tlas, &job->rays[i]);
    for (uint32_t i = 0; i < RAYS / DAFT_PACKET && job->how == TOGETHER; i++)
        count += (uint32_t)__builtin_popcount(k->closest_packet(tlas, &job->packets[i], 0xffff, UINT32_MAX, hits));
    job->hits[which] = count;
    return RAYS / (bench_clock_ms(1) - start) / 1e3;
}
static double trace_turned(void *context) { return trace(context, 0); }
static double trace_straight(void *context) { return trace(context, 1); }

static void describe_rays(void *context, char *out, size_t size)
{
    const beams_job *job = context;
    snprintf(out, size, "%d rays, %u and %u hits", RAYS, job->hits[0], job->hits[1]);
}

static double random_unit(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 40) * 0x1p-24;
}

static daft_vec3 random_way(uint64_t *state)
{
    double y = 2 * random_unit(state) - 1, around = 2 * DAFT_PI * random_unit(state), r = sqrt(1 - y * y);
    return daft_v3((float)(r * daft_cos(around)), (float)y, (float)(r * daft_sin(around)));
}

/* From within the frame, every way; or, sixteen at a time, from one point about one way. */
static void fill_rays(beams_job *job)
{
    const daft_instance *beams = &job->instances[0][0];
    daft_vec3 low = beams->low, size = daft_sub(beams->high, low), from = low, way = low;
    uint64_t state = 5;
    for (uint32_t i = 0; i < RAYS; i++) {
        if (i % DAFT_PACKET == 0 || job->how != TOGETHER) {
            float x = (float)random_unit(&state), y = (float)random_unit(&state);
            from = daft_add(low, daft_v3(x * size.x, y * size.y, (float)random_unit(&state) * size.z));
            way = random_way(&state);
        }
        daft_vec3 aside = daft_scale(random_way(&state), job->how == TOGETHER ? 0.02f : 0);
        job->rays[i] = (daft_ray){.origin = from, .direction = daft_normalize(daft_add(way, aside)), .tmax = INFINITY};
        daft_ray_packet_set(&job->packets[i / DAFT_PACKET], i % DAFT_PACKET, &job->rays[i]);
    }
}

static const struct {
    const char *what;
    bool camera;
    int how;
} ROWS[] = {{"turned tree, camera rays", true, 0},
            {"turned tree, nearest hit", false, NEAREST},
            {"turned tree, any hit", false, ANY},
            {"turned tree, packets", false, TOGETHER}};

static bool job_begin(bench *self, beams_job *job)
{
    daft_arena *arena = &job->arena;
    int isa;
    daft_isa_parse(self->isa, &isa);
    job->kernels = daft_accel_kernels_for(isa);
    job->rays = daft_arena_alloc(arena, RAYS, sizeof *job->rays);
    job->packets = daft_arena_alloc(arena, RAYS / DAFT_PACKET + 1, sizeof *job->packets);
    bool made = job->rays && job->packets;
    for (int k = 0; made && k < 2; k++) {
        bench_scene *scene = &job->scene[k];
        if (!bench_scene_named(self, "diagonal beams", scene)) return false;
        daft_bvh_free(scene->bvh[0]);
        const daft_bvh_def def = {.threads = daft_processor_count(), .isa = isa, .may_turn = k == 0};
        scene->bvh[0] = daft_bvh_build(&self->allocator, &scene->mesh[0], &def, NULL);
        job->instances[k] = daft_arena_alloc(arena, scene->thing_count, sizeof(daft_instance));
        if (!scene->bvh[0] || !job->instances[k]) return false;
        for (uint32_t i = 0; i < scene->thing_count; i++) job->instances[k][i] = bench_thing_instance(scene, i);
        job->tlas[k] = daft_tlas_build(arena, job->instances[k], 1, NULL);
        job->camera[k] = bench_camera_create(self, scene, 1);
        made = job->tlas[k] && job->camera[k];
    }
    return made;
}

void bench_beams(bench *self)
{
    bool wanted[DAFT_COUNT_OF(ROWS)], any = false;
    for (size_t i = 0; i < DAFT_COUNT_OF(ROWS); i++) any |= wanted[i] = bench_wants(self, "diagonal beams", ROWS[i].what);
    if (!any) return;
    beams_job job = {.hits = {0}};
    daft_arena_init(&job.arena, &self->allocator);
    bool ready = job_begin(self, &job);
    if (!ready) bench_note(self, true, "out of memory");
    for (size_t i = 0; ready && i < DAFT_COUNT_OF(ROWS); i++) {
        if (!wanted[i]) continue;
        job.how = ROWS[i].how;
        if (!ROWS[i].camera) fill_rays(&job);
        bench_subject subject = {.scene = "diagonal beams", .what = ROWS[i].what, .unit = "Mray/s", .isa = self->isa, .threads = 1,
                                 .ours = ROWS[i].camera ? see_turned : trace_turned, .peer = ROWS[i].camera ? see_straight : trace_straight,
                                 .context = &job, .peer_name = "not turned", .describe = ROWS[i].camera ? NULL : describe_rays,
                                 .own_peer = true};
        bench_measure(self, &subject);
    }
    for (int k = 0; k < 2; k++) {
        if (job.camera[k]) bench_camera_destroy(job.camera[k]);
        bench_scene_free(self, &job.scene[k]);
    }
    daft_arena_free(&job.arena);
}
