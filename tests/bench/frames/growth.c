/* The group growth: how the time of a frame (camera rays, shadows, Lambert) grows with triangles, instances, pixels,
 * lights and threads. The peer of each row is the row before it, so its ratio says what the step cost: 0.5 is twice the
 * time. With --only it runs to the end; a run of everything stops before the slow rows. */
#include "harness/scenes.h"

#include "math/trig.h"

#include <stdio.h>
#include <string.h>

/* ---- one row after the other ---- */

typedef struct growth {
    bench *self;
    const char *scene;
    double before; /* milliseconds of the row before; negative: this is the first */
    bool wall;     /* use the wall clock for one thread too, because rows of more threads compare with it */
} growth;

static double frame_ms(void *context) { return bench_frame_ms(context); }

static double wall_ms(void *context)
{
    double start = daft_clock_ms();
    return bench_frame_ms(context) < 0 ? -1 : daft_clock_ms() - start;
}

static void describe(void *context, char *out, size_t size)
{
    const daft_counters *c = bench_frame_counters(context);
    snprintf(out, size, "%llu triangles tested, %llu shadow rays", (unsigned long long)c->triangles_tested,
             (unsigned long long)c->shadow_rays);
}

/* min_ratio: the floor of the ratio to the row before; 0: none. */
static void add_step(growth *g, const bench_scene *scene, const char *what, int threads, int lights, double min_ratio)
{
    bench *self = g->self;
    bench_frame *frame = bench_frame_create(self, scene, threads, lights);
    if (!frame) return;
    bench_subject subject = {.scene = g->scene,
                             .what = what,
                             .unit = "ms",
                             .isa = self->isa,
                             .threads = threads,
                             .ours = g->wall ? wall_ms : frame_ms,
                             .context = frame,
                             .describe = describe};
    if (bench_measure(self, &subject)) {
        bench_row *row = &self->rows[self->count - 1];
        row->peer = g->before;
        row->peer_name = g->before < 0 ? NULL : "the row before";
        row->budget.floor = min_ratio;
        g->before = row->ours;
    }
    bench_frame_destroy(frame);
}

static growth begin(bench *self, const char *scene) { return (growth){self, scene, -1, false}; }

static bool to_the_end(const bench *self) { return self->only != NULL; }

static int threads_of(const bench *self) { return self->threads ? self->threads : 1; }

/* ---- triangles: a wavy wall that fills the picture ---- */

static daft_vec3 wall_point(double u, double v)
{
    double z = -2 + 0.04 * daft_sin(37 * u) * daft_cos(23 * v) + 0.006 * daft_sin(211 * u + 3 * v) * daft_cos(173 * v);
    return daft_v3((float)(2.5 * (u - 0.5)), (float)(1.45 * (0.5 - v)), (float)z);
}

static bool make_wall(bench *self, uint32_t triangles, bench_scene *out)
{
    uint32_t rows = (uint32_t)(sqrt(triangles / 2.0 * 9 / 16) + 0.5), columns = (triangles / 2 + rows / 2) / rows;
    *out = (bench_scene){.name = "growth, triangles", .single = true, .light = {-1.5f, 1.2f, -0.5f}};
    bench_look(&out->view, daft_v3(0, 0, 0), daft_v3(0, 0, -1));
    out->mesh_count = bench_grid(self, columns, rows, wall_point, &out->mesh[0]);
    if (out->mesh_count && bench_add_meshes(self, out, 1)) return true;
    bench_note(self, true, "a wall of %u triangles cannot be made", triangles);
    bench_scene_free(self, out);
    return false;
}

static void with_triangles(bench *self)
{
    enum { LARGEST = 10000000, LARGEST_OF_ALL = 1024000 };
    growth g = begin(self, "growth, triangles");
    uint32_t limit = to_the_end(self) ? LARGEST : LARGEST_OF_ALL, pixels = BENCH_WIDTH * BENCH_HEIGHT;
    for (uint32_t n = 1000, last = 0; n <= limit && n != last; last = n, n = n * 2 > LARGEST ? LARGEST : n * 2) {
        char what[32];
        bench_scene scene;
        snprintf(what, sizeof what, "frame, %uk", n / 1000);
        if (!bench_wants(self, g.scene, what) || !make_wall(self, n, &scene)) continue;
        bool doubled = n == 2 * last && last > pixels; /* the wall fills the picture: more than one a pixel */
        add_step(&g, &scene, what, threads_of(self), 1, doubled ? 0.5 : 0);
        bench_scene_free(self, &scene);
    }
}

/* ---- instances, pixels, lights, threads ---- */

static void with_instances(bench *self)
{
    growth g = begin(self, "growth, instances");
    for (uint32_t n = 1; n <= (to_the_end(self) ? 100000u : 1000u); n *= 10) {
        char what[32];
        bench_scene scene;
        snprintf(what, sizeof what, "frame, %u", n);
        if (!bench_wants(self, g.scene, what) || !bench_scene_cows(self, n, &scene)) continue;
        add_step(&g, &scene, what, threads_of(self), 1, 0);
        bench_scene_free(self, &scene);
    }
}

static void with_pixels(bench *self)
{
    static const int SIZES[][2] = {{320, 180}, {640, 360}, {1280, 720}, {1920, 1080}, {2560, 1440}, {3840, 2160}};
    growth g = begin(self, "growth, pixels");
    for (size_t i = 0; i < (to_the_end(self) ? DAFT_COUNT_OF(SIZES) : 4); i++) {
        char what[32];
        bench_scene scene;
        snprintf(what, sizeof what, "frame, %dx%d", SIZES[i][0], SIZES[i][1]);
        if (!bench_wants(self, g.scene, what) || !bench_scene_named(self, "bunny, whole", &scene)) continue;
        bench_view_size(&scene.view, SIZES[i][0], SIZES[i][1]);
        add_step(&g, &scene, what, threads_of(self), 1, 0);
        bench_scene_free(self, &scene);
    }
}

static void with_lights(bench *self)
{
    growth g = begin(self, "growth, lights");
    for (int n = 1; n <= (to_the_end(self) ? 64 : 16); n *= 2) {
        char what[32];
        bench_scene scene;
        snprintf(what, sizeof what, "frame, %d", n);
        if (!bench_wants(self, g.scene, what) || !bench_scene_named(self, "bunny, whole", &scene)) continue;
        add_step(&g, &scene, what, threads_of(self), n, 0);
        bench_scene_free(self, &scene);
    }
}

static void with_threads(bench *self)
{
    growth g = begin(self, "growth, threads");
    g.wall = true;
    int all = self->threads ? self->threads : daft_processor_count();
    for (int n = 1, last = 0; n != last; last = n, n = n * 2 > all ? all : n * 2) {
        char what[32];
        bench_scene scene;
        snprintf(what, sizeof what, "frame, %d", n);
        if (!bench_wants(self, g.scene, what) || !bench_scene_named(self, "bunny, whole", &scene)) continue;
        add_step(&g, &scene, what, n, 1, 0);
        bench_scene_free(self, &scene);
    }
}

void bench_growth(bench *self)
{
    with_triangles(self);
    with_instances(self);
    with_pixels(self);
    with_lights(self);
    with_threads(self);
}
