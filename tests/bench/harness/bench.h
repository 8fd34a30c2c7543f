/* bench: the harness of the benchmarks. A benchmark is two functions that return one sample each, ours and a peer's on
 * the same work; the harness runs them in turns, so that a slow moment of the machine meets both, and reports the best
 * of each: what disturbs a sample only ever makes it slower.
 *
 *   harness/  options and sampling (main.c), the table and the JSON (report.c), the manual's tables (tables.c), plots
 *             (svg.c), meshes (models.c) and scenes (scenes.c) that both sides see, Embree (embree.c)
 *   frames/   users' frames: games.c, shown_scenes.c; whole frames against Embree (frames.c, embree_frame.c), growth.c
 *   rays/     camera rays (visibility.c, camera.c), shadow.c, rays.c, what a right pixel costs (accuracy.c), robust.c
 *   scripts/  games that do one thing over and over, and what it costs them
 *   llvmpipe/ users' frames by OpenGL, a program of its own
 *   load/     OBJ files, trees, memory     sim/   steps of the simulation, what a right motion costs */
#ifndef DAFT_BENCH_H
#define DAFT_BENCH_H

#include "accel/accel.h"
#include "base/base.h"
#include "geometry/mesh.h"

/* What a row should reach: the floor, and the aim. Both zero: the row has none. */
typedef struct bench_budget {
    double floor, aim;
    bool of_value; /* they are about our own figure, in the row's unit; else about the ratio */
} bench_budget;

typedef struct bench_row {
    char scene[64], what[64], counters[320];
    const char *unit, *isa, *peer_name;
    int threads;
    double ours, peer; /* the best samples; peer is negative where there is none */
    bench_budget budget;
} bench_row;

typedef struct bench {
    const char *only, *json, *isa; /* isa: NULL for the best there is */
    const char *tables;            /* a folder of the manual's pages to fill from `from`; NULL: measure */
    const char *from[32];          /* JSON files; the rest: NULL */
    const char *csv, *svg;         /* where visibility-accuracy or sim-accuracy is written; NULL: nowhere */
    int threads;                   /* 0: one, and all there are */
    int rounds;                    /* 0: as many as it takes */
    bool peers, list;
    daft_allocator allocator;
    bench_row *rows;
    size_t count, capacity;
    bool failed;
    char command[512], machine[128], date[16]; /* what stands with each figure */
} bench;

/* A sample in the row's unit, or a negative number if the work failed. */
typedef double bench_sample(void *context);

typedef struct bench_subject {
    const char *scene, *what;
    const char *unit; /* "ms", "ns", "mm" and "B/...": smaller is better; everything else: larger is */
    const char *isa;
    int threads;
    bench_sample *ours, *peer; /* peer: NULL where there is none, or it is not installed */
    void *context;
    const char *peer_name;                                   /* NULL: nothing to compare with */
    void (*describe)(void *context, char *out, size_t size); /* counters, after the last round; may be NULL */
    bench_budget budget;
    bool own_peer; /* the peer is ours, too: it runs without --peers */
} bench_subject;

/* Whether the user asked for it. With --list it prints the name, and the answer is no. */
bool bench_wants(bench *self, const char *scene, const char *what);
/* Samples both sides and adds the row; gives it, or NULL on failure. It is valid until the next one. */
const bench_row *bench_measure(bench *self, const bench_subject *subject);
/* The same, with a second row of the same figures under another name and budget, without the peer. */
void bench_measure_twice(bench *self, const bench_subject *subject, const char *what, bench_budget budget);
/* Adds a row whose figures are already known, and tells it on stderr. False: out of memory. */
bool bench_add(bench *self, const bench_row *row);
/* The clock for work of so many threads. One thread: its own processor time, because the time slices of other programs
 * would hit long samples more than short ones. More threads: the wall clock. */
double bench_clock_ms(int threads);
/* Fills in the thread counts to measure, returns how many. */
int bench_thread_counts(const bench *self, int out[2]);
/* Writes to stderr why something is left out or failed; `fatal` makes the exit status 1. */
void bench_note(bench *self, bool fatal, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* ---- report.c ---- */

bool bench_smaller_is_better(const bench_row *row);
/* Larger than 1: ours is better. Negative where there is no peer. */
double bench_ratio(const bench_row *row);
/* One row on stderr as soon as it is there; the table comes at the end. */
void bench_tell(const bench_row *row);
void bench_print(const bench *self);
bool bench_write_json(const bench *self);

/* ---- tables.c ---- */

/* Fills the marked sections of the pages in self->tables from self->from. */
bool bench_write_tables(bench *self);

/* ---- models.c ---- */

/* A mesh scaled so that its longest side is 1 m, standing on y = 0 around the y axis. */
typedef struct bench_model {
    const char *name;
    const char *file;   /* in the models folder; NULL: generated */
    uint32_t triangles; /* of the file, and approximately of its stand-in */
} bench_model;

extern const bench_model BENCH_MODELS[];
extern const size_t BENCH_MODEL_COUNT;

const bench_model *bench_model_named(const char *name);
/* The file of a model; false when it has none or it is not there. */
bool bench_model_path(const bench_model *model, char *out, size_t size);
bool bench_model_load(bench *self, const bench_model *model, daft_trimesh *out);
/* The scene's displayed name, which says whether a stand-in replaces a model. */
void bench_label(const char *scene, char *out, size_t size);
/* A grid of columns by rows cells over u, v in 0..1, two triangles each, counter-clockwise where u, v is clockwise. */
typedef daft_vec3 bench_surface(double u, double v);
bool bench_grid(bench *self, uint32_t columns, uint32_t rows, bench_surface *point, daft_trimesh *out);
/* A mesh's tree as a scene builds it, by all processors. */
daft_bvh *bench_tree(bench *self, const daft_trimesh *mesh);
/* A copy of the positions as the public API takes them. Released with daft_release. */
daft_vec3 *bench_positions(bench *self, const daft_trimesh *mesh);

/* A number in 0..1 of 24 bits, and the state after it. */
static inline float bench_random(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (float)(*state >> 40) * 0x1p-24f;
}

/* ---- peers ---- */

/* A pinhole camera for both sides. */
typedef struct bench_view {
    int width, height;
    daft_vec3 from, at, right, up, forward;
    float focal, fov; /* pixels; radians across */
} bench_view;
typedef struct bench_scene bench_scene; /* scenes.h */

enum { BENCH_GROUND = 20 }; /* half the ground's edge, metres */

/* NULL where Embree is not part of this build. */
typedef struct bench_embree bench_embree;
typedef struct bench_embree_api {
    const char *name;
    bench_embree *(*create)(const daft_trimesh *mesh, bool ground, int threads);
    bench_embree *(*create_scene)(const bench_scene *scene, int threads);
    void (*destroy)(bench_embree *self);
    double (*build_ms)(bench_embree *self); /* builds anew */
    double (*camera_ms)(bench_embree *self, const bench_view *view, uint64_t *hits);
    /* Camera, one light with shadows, Lambert, sRGB: RGBA bytes. */
    double (*frame_ms)(bench_embree *self, const bench_scene *scene, uint8_t *pixels);
} bench_embree_api;
const bench_embree_api *bench_find_embree(void);

/* Milliseconds to load an OBJ with triangulation, negative on failure. NULL where tinyobjloader is not there. */
typedef double bench_obj_loader(const char *path, size_t *triangles);
bench_obj_loader *bench_find_tinyobj(void);

/* ---- benchmarks ---- */

void bench_games(bench *self);        /* users' frames: the games' demos */
void bench_shown_scenes(bench *self); /* users' frames: assets/scenes */
void bench_start_up(bench *self);     /* of the program */
void bench_scripts(bench *self);      /* what games' scripts pay */
void bench_visibility(bench *self);   /* camera rays */
void bench_rays(bench *self);
void bench_frames(bench *self);
void bench_shadow(bench *self);
void bench_load(bench *self);
/* A row of building a mesh's tree, beside Embree's (load.c). */
void bench_measure_build(bench *self, const char *scene, const char *what, const daft_trimesh *mesh);
void bench_trees(bench *self);
void bench_sim_shapes(bench *self);   /* collision geometry */
void bench_sim(bench *self);          /* steps of the simulation */
void bench_sim_accuracy(bench *self); /* what a right motion costs */
void bench_denoise(bench *self);      /* soft light, by rays and denoised */
void bench_edges(bench *self);        /* antialiasing: beside more samples of all, and while the camera turns */
void bench_budgets(bench *self);      /* what daft cost recommends, drawn */
void bench_growth(bench *self);       /* time against triangles, instances, pixels, lights, threads */
void bench_accuracy(bench *self);     /* what a right pixel costs */
void bench_robust(bench *self);       /* how often wrong, not how fast */

#endif
