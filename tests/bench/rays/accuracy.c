/* The group visibility-accuracy: what a right pixel costs. Each method of finding what the camera sees is timed and
 * compared, pixel by pixel, with the oracle: every ray alone through the trees, in double, the sign of each predicate
 * decided exactly. As a table, as CSV, and as a plot of wrong pixels against milliseconds. */
#include "harness/scenes.h"

#include "math/trig.h"
#include "harness/svg.h"

#include <stdio.h>
#include <string.h>

/* ---- the methods ---- */

typedef enum method {
    BOXES,
    PENCIL, /* and the two other tests */
    BVH = PENCIL + 3,
    KDTREE = BVH + 3,
    ORACLE = KDTREE + 3,
    METHODS
} method;

static const svg_series METHOD[METHODS] = {
    [BOXES] = {"boxes alone", "#8c6d46", SVG_DIAMOND},
    [PENCIL + DAFT_INTERSECT_FAST] = {"pencil, fast", "#1f77b4", SVG_TRIANGLE},
    [PENCIL + DAFT_INTERSECT_WATERTIGHT] = {"pencil, watertight", "#1f77b4", SVG_SQUARE},
    [PENCIL + DAFT_INTERSECT_EXACT] = {"pencil, exact", "#1f77b4", SVG_DISC},
    [BVH + DAFT_INTERSECT_FAST] = {"ray through BVH, fast", "#d9641e", SVG_TRIANGLE},
    [BVH + DAFT_INTERSECT_WATERTIGHT] = {"ray through BVH, watertight", "#d9641e", SVG_SQUARE},
    [BVH + DAFT_INTERSECT_EXACT] = {"ray through BVH, exact", "#d9641e", SVG_DISC},
    [KDTREE + DAFT_INTERSECT_FAST] = {"ray through kd-tree, fast", "#2c8a3d", SVG_TRIANGLE},
    [KDTREE + DAFT_INTERSECT_WATERTIGHT] = {"ray through kd-tree, watertight", "#2c8a3d", SVG_SQUARE},
    [KDTREE + DAFT_INTERSECT_EXACT] = {"ray through kd-tree, exact", "#2c8a3d", SVG_DISC},
    [ORACLE] = {"oracle", "#333333", SVG_DIAMOND},
};

typedef struct result {
    double ms;
    uint64_t wrong, holes, ghosts; /* holes: nothing is seen where something is; ghosts: something is seen where nothing
                                      is */
} result;

typedef struct accuracy_job {
    const bench_scene *scene;
    bench_camera *camera;
    bench_boxes *boxes;
    uint64_t *truth, *seen;
    result results[METHODS];
} accuracy_job;

static double look_with(accuracy_job *job, method how, uint64_t *seen)
{
    if (how == BOXES) return bench_boxes_see(job->boxes, seen);
    if (how == ORACLE) return bench_camera_oracle(job->camera, seen);
    if (how < BVH) return bench_camera_see(job->camera, (daft_intersection)(how - PENCIL), seen);
    bool kdtree = how >= KDTREE;
    return bench_camera_trees(job->camera, kdtree, (daft_intersection)(how - (kdtree ? KDTREE : BVH)), seen);
}

static void compare(accuracy_job *job, result *r)
{
    size_t pixels = (size_t)job->scene->view.width * (size_t)job->scene->view.height;
    for (size_t i = 0; i < pixels; i++) {
        r->wrong += job->seen[i] != job->truth[i];
        r->holes += job->seen[i] == BENCH_NOTHING && job->truth[i] != BENCH_NOTHING;
        r->ghosts += job->seen[i] != BENCH_NOTHING && job->truth[i] == BENCH_NOTHING;
    }
}

/* The oracle once, since it takes seconds; the others in turns, the best of the rounds. */
static bool run_all(const bench *self, accuracy_job *job)
{
    job->results[ORACLE].ms = look_with(job, ORACLE, job->truth);
    if (job->results[ORACLE].ms < 0) return false;
    double start = daft_clock_ms();
    int rounds = self->rounds ? self->rounds : 15;
    for (int round = 0; round < rounds && (round < 3 || daft_clock_ms() - start < 4e3); round++)
        for (method how = BOXES; how < ORACLE; how++) {
            result *r = &job->results[how];
            double ms = look_with(job, how, job->seen);
            if (ms < 0) return false;
            if (round == 0) compare(job, r);
            r->ms = round == 0 || ms < r->ms ? ms : r->ms;
        }
    return true;
}

/* ---- hard scenes ---- */

/* In -1..1. */
static float noise(uint64_t *state) { return 2 * bench_random(state) - 1; }

typedef struct soup {
    daft_vec3 *positions;
    uint32_t *indices;
    uint32_t vertices, triangles;
} soup;

static bool finish_soup(bench *self, soup *s, bench_scene *out)
{
    daft_mesh_def def = daft_default_mesh_def();
    daft_log log = {0};
    def.positions = s->positions, def.vertex_count = s->vertices;
    def.indices = s->indices, def.triangle_count = s->triangles;
    bool made =
        s->positions && s->indices && daft_trimesh_from_arrays(&self->allocator, &def, &log, &out->mesh[0], NULL);
    daft_release(&self->allocator, s->positions);
    daft_release(&self->allocator, s->indices);
    out->mesh_count = made, out->single = true;
    bench_look(&out->view, daft_v3(0, 0, 0), daft_v3(0, 0, -1));
    return made && bench_add_meshes(self, out, 1);
}

static bool make_soup(bench *self, uint32_t vertices, uint32_t triangles, soup *out)
{
    *out = (soup){.positions = daft_alloc(&self->allocator, vertices, sizeof(daft_vec3)),
                  .indices = daft_alloc(&self->allocator, triangles, 3 * sizeof(uint32_t))};
    if (out->positions && out->indices) return true;
    daft_release(&self->allocator, out->positions);
    daft_release(&self->allocator, out->indices);
    return false;
}

/* Triangles up to two pixels wide and a third of the picture long. */
static bool needles(bench *self, bench_scene *out)
{
    enum { COUNT = 2000 };
    soup s;
    uint64_t state = 7;
    if (!make_soup(self, 3 * COUNT, COUNT, &s)) return false;
    for (uint32_t i = 0; i < COUNT; i++) {
        float x = 1.4f * noise(&state), y = 0.8f * noise(&state), z = -2 - 0.5f * noise(&state);
        float dx = 0.4f * noise(&state), dy = 0.4f * noise(&state), dz = 0.1f * noise(&state);
        float wide = 0.005f * (1.2f + noise(&state));
        s.positions[s.vertices] = daft_v3(x - dx, y - dy, z - dz);
        s.positions[s.vertices + 1] = daft_v3(x + dx - dy * wide, y + dy + dx * wide, z + dz);
        s.positions[s.vertices + 2] = daft_v3(x + dx + dy * wide, y + dy - dx * wide, z + dz);
        for (uint32_t k = 0; k < 3; k++) s.indices[3 * i + k] = s.vertices++;
        s.triangles++;
    }
    return finish_soup(self, &s, out);
}

/* A grid of columns by rows cells over a rectangle across the view, at a depth that may lean by `lean` a metre. */
static void add_sheet(soup *s, uint32_t columns, uint32_t rows, float half_x, float half_y, float z, float lean)
{
    uint32_t first = s->vertices;
    for (uint32_t r = 0; r <= rows; r++)
        for (uint32_t c = 0; c <= columns; c++) {
            float x = half_x * (2 * (float)c / (float)columns - 1), y = half_y * (2 * (float)r / (float)rows - 1);
            s->positions[s->vertices++] = daft_v3(x, y, z + lean * x);
        }
    for (uint32_t r = 0; r < rows; r++)
        for (uint32_t c = 0; c < columns; c++) {
            uint32_t a = first + r * (columns + 1) + c, b = a + columns + 1;
            const uint32_t corners[6] = {a, a + 1, b + 1, a, b + 1, b};
            memcpy(s->indices + 3 * (size_t)s->triangles, corners, sizeof corners);
            s->triangles += 2;
        }
}

/* Six sheets in one plane, and as many a float's last bit apart, each cut in its own method, all leaning. */
static bool coplanar_layers(bench *self, bench_scene *out)
{
    soup s;
    if (!make_soup(self, 12 * 64 * 64, 12 * 2 * 64 * 64, &s)) return false;
    for (uint32_t i = 0; i < 12; i++) {
        uint32_t cut = 40 + i;
        add_sheet(&s, cut, cut / 2 + i % 3, 1, 0.6f, i < 6 ? -1.9f : -1.9f + (float)(i - 6) * 0x1p-22f, 0.3f);
    }
    return finish_soup(self, &s, out);
}

/* A pixel is a metre at this depth: every fourth ray of every fourth row goes through a corner, others along edges. */
static bool edge_aligned_grid(bench *self, bench_scene *out)
{
    enum { COLUMNS = BENCH_WIDTH / 4 - 2, ROWS = BENCH_HEIGHT / 4 - 2 };
    soup s;
    bench_view view;
    if (!make_soup(self, (COLUMNS + 1) * (ROWS + 1), 2 * COLUMNS * ROWS, &s)) return false;
    bench_view_size(&view, BENCH_WIDTH, BENCH_HEIGHT);
    add_sheet(&s, COLUMNS, ROWS, 2 * COLUMNS, 2 * ROWS, -view.focal, 0);
    for (uint32_t i = 0; i < s.vertices; i++) s.positions[i].x += 0.5f, s.positions[i].y += 0.5f;
    return finish_soup(self, &s, out);
}

/* ---- the scenes ---- */

typedef struct accuracy_scene {
    const char *name;
    bool (*make)(bench *self, bench_scene *out); /* NULL: one of the rendering rows' */
} accuracy_scene;

static const accuracy_scene SCENES[] = {
    {"cow, whole", NULL},
    {"bunny, close up", NULL},
    {"interior", NULL},
    {"1,000 instances of the cow", NULL},
    {"needles", needles},
    {"coplanar layers", coplanar_layers},
    {"edge-aligned grid", edge_aligned_grid},
};
enum { SCENE_COUNT = DAFT_COUNT_OF(SCENES) };

static bool make_scene(bench *self, const accuracy_scene *entry, bench_scene *out)
{
    *out = (bench_scene){.name = entry->name};
    bool made = entry->make && entry->make(self, out) && bench_scene_build(self, out);
    for (size_t i = 0; !entry->make && i < bench_scene_count(); i++)
        if (strcmp(bench_scene_name(i), entry->name) == 0) made = bench_scene_make(self, i, out);
    if (!made) bench_note(self, true, "%s cannot be made", entry->name);
    if (!made) bench_scene_free(self, out);
    return made;
}

/* ---- results ---- */

typedef struct report {
    svg_point points[SCENE_COUNT * METHODS];
    result results[SCENE_COUNT * METHODS];
    size_t count;
    char names[SCENE_COUNT][48];
} report;

static void add_results(bench *self, report *all, size_t scene, const accuracy_job *job, int threads)
{
    bench_label(job->scene->name, all->names[scene], sizeof all->names[scene]);
    double pixels = (double)job->scene->view.width * (double)job->scene->view.height;
    for (method how = BOXES; how < METHODS; how++) {
        const result *r = &job->results[how];
        bench_row row = {.unit = "ms", .isa = self->isa, .threads = threads, .ours = r->ms, .peer = -1};
        snprintf(row.scene, sizeof row.scene, "accuracy, %s", all->names[scene]);
        snprintf(row.what, sizeof row.what, "%s", METHOD[how].name);
        snprintf(row.counters, sizeof row.counters, "%7llu pixels wrong, %.4f%%, %llu of them holes, %llu ghosts",
                 (unsigned long long)r->wrong, 100 * (double)r->wrong / pixels, (unsigned long long)r->holes,
                 (unsigned long long)r->ghosts);
        bench_add(self, &row);
        all->points[all->count] = (svg_point){scene, how, r->ms, (double)r->wrong};
        all->results[all->count++] = *r;
    }
}

static bool write_csv(const bench *self, const report *all, int threads)
{
    FILE *file = fopen(self->csv, "w");
    if (!file) return false;
    fprintf(file, "scene,method,threads,isa,width,height,ms,wrong,holes,ghosts\n");
    for (size_t i = 0; i < all->count; i++) {
        const result *r = &all->results[i];
        fprintf(file, "\"%s\",\"%s\",%d,%s,%d,%d,%.4f,%llu,%llu,%llu\n", all->names[all->points[i].panel],
                METHOD[all->points[i].series].name, threads, self->isa, BENCH_WIDTH, BENCH_HEIGHT, r->ms,
                (unsigned long long)r->wrong, (unsigned long long)r->holes, (unsigned long long)r->ghosts);
    }
    bool written = !ferror(file);
    return fclose(file) == 0 && written;
}

static bool write_svg(const bench *self, const report *all, size_t scenes, int threads)
{
    static const double marks[] = {1e3 / 60, 1e3 / 30};
    static const char *const mark_names[] = {"60 Hz", "30 Hz"};
    const char *panels[SCENE_COUNT];
    char note[256];
    for (size_t i = 0; i < scenes; i++) panels[i] = all->names[i];
    snprintf(
        note, sizeof note,
        "%d by %d pixels, %d thread%s, %s; the best of several rounds in turns. Filled and joined: the Pareto front; "
        "hollow: something else is both faster and no less right.",
        BENCH_WIDTH, BENCH_HEIGHT, threads, threads == 1 ? "" : "s", self->isa);
    const svg_plot plot = {.title = "What a right pixel costs: wrong pixels against the exact oracle, and milliseconds",
                           .note = note,
                           .x_label = "milliseconds a frame",
                           .y_label = "wrong pixels",
                           .panels = panels,
                           .panel_count = scenes,
                           .series = METHOD,
                           .series_count = METHODS,
                           .points = all->points,
                           .point_count = all->count,
                           .marks = marks,
                           .mark_names = mark_names,
                           .mark_count = DAFT_COUNT_OF(marks)};
    return svg_write(&plot, self->svg);
}

static bool measure_scene(bench *self, report *all, size_t place, const accuracy_scene *entry, int threads)
{
    bench_scene scene;
    if (!make_scene(self, entry, &scene)) return false;
    fprintf(stderr, "visibility-accuracy %s\n", entry->name);
    size_t pixels = (size_t)(BENCH_WIDTH * BENCH_HEIGHT);
    accuracy_job job = {.scene = &scene,
                        .camera = bench_camera_create(self, &scene, threads),
                        .boxes = bench_boxes_create(self, &scene, threads)};
    job.truth = daft_alloc(&self->allocator, 2 * pixels, sizeof *job.truth);
    job.seen = job.truth ? job.truth + pixels : NULL;
    bool good = job.camera && job.boxes && job.truth && run_all(self, &job);
    if (good)
        add_results(self, all, place, &job, threads);
    else
        bench_note(self, true, "%s failed", entry->name);
    daft_release(&self->allocator, job.truth);
    bench_boxes_destroy(job.boxes);
    bench_camera_destroy(job.camera);
    bench_scene_free(self, &scene);
    return good;
}

void bench_accuracy(bench *self)
{
    int threads = self->threads ? self->threads : 1;
    size_t scenes = 0;
    report *all = daft_alloc_zero(&self->allocator, 1, sizeof *all);
    if (!all) return;
    for (size_t i = 0; i < SCENE_COUNT; i++) {
        char name[96];
        snprintf(name, sizeof name, "visibility-accuracy, %s", SCENES[i].name);
        if (bench_wants(self, name, "") && measure_scene(self, all, scenes, &SCENES[i], threads)) scenes++;
    }
    if (self->csv && scenes && !write_csv(self, all, threads)) bench_note(self, true, "cannot write %s", self->csv);
    if (self->svg && scenes && !write_svg(self, all, scenes, threads))
        bench_note(self, true, "cannot write %s", self->svg);
    daft_release(&self->allocator, all);
}
