/* The scenes of the rendering benchmarks, and our camera rays into them. */
#ifndef DAFT_BENCH_SCENES_H
#define DAFT_BENCH_SCENES_H

#include "bench.h"

enum { BENCH_WIDTH = 1280, BENCH_HEIGHT = 720, BENCH_SPHERE = -1 };

/* A mesh of the scene or a sphere, somewhere in the world. */
typedef struct bench_instance {
    int mesh; /* or BENCH_SPHERE */
    daft_quat rotation;
    daft_vec3 position;
    float scale; /* a sphere's: its radius */
} bench_instance;

struct bench_scene {
    const char *name;
    daft_trimesh mesh[2];
    daft_bvh *bvh[2];
    int mesh_count;
    bool single; /* each mesh stands once, where its coordinates say */
    bench_instance *instances;
    uint32_t instance_count;
    bench_view view;
    daft_vec3 light;
};

/* The scenes of the rendering rows. */
size_t bench_scene_count(void);
const char *bench_scene_name(size_t index);
bool bench_scene_make(bench *self, size_t index, bench_scene *out); /* false: a note says why */
bool bench_scene_named(bench *self, const char *name, bench_scene *out);
/* Builds the trees of a scene whose meshes are there. */
bool bench_scene_build(bench *self, bench_scene *scene);
/* So many instances of the cow; without trees, since frames build their own. */
bool bench_scene_cows(bench *self, uint32_t count, bench_scene *out);
void bench_scene_free(bench *self, bench_scene *scene);
void bench_view_size(bench_view *view, int width, int height);
void bench_look(bench_view *view, daft_vec3 from, daft_vec3 at);
/* Meshes that stand where their coordinates say: instances 0 to count - 1. */
bool bench_add_meshes(bench *self, bench_scene *scene, uint32_t count);
daft_affine bench_instance_map(const bench_instance *item);
/* In frame space: the origin is at the camera. */
daft_instance bench_engine_instance(const bench_scene *scene, uint32_t index);

/* ---- camera.c: our camera rays, timed around the pencil's passes ---- */

typedef struct bench_camera bench_camera;
typedef struct bench_camera_counts {
    uint64_t hits, triangles_tested, exact_edges;
} bench_camera_counts;

bench_camera *bench_camera_create(bench *self, const bench_scene *scene, int threads); /* NULL: memory is out */
void bench_camera_destroy(bench_camera *camera);
/* Milliseconds; negative on failure. */
double bench_camera_ms(bench_camera *camera, daft_intersection intersection);
/* The same, and what each pixel sees: a number for each triangle of each item; BENCH_NOTHING where that is nothing. */
#define BENCH_NOTHING UINT64_MAX
double bench_camera_see(bench_camera *camera, daft_intersection intersection, uint64_t *seen);
/* Every ray alone through the trees, in double and exactly: what is true for the vertices as floats move them. */
double bench_camera_oracle(bench_camera *camera, uint64_t *seen);
/* One ray a pixel through the tree over instances and those over triangles: BVHs, or kd-trees. */
double bench_camera_trees(bench_camera *camera, bool kdtree, daft_intersection intersection, uint64_t *seen);
bench_camera_counts bench_camera_counted(const bench_camera *camera);

/* ---- boxes.c: visibility by projected boxes alone ---- */

typedef struct bench_boxes bench_boxes;
bench_boxes *bench_boxes_create(bench *self, const bench_scene *scene, int threads); /* NULL: memory is out */
void bench_boxes_destroy(bench_boxes *boxes);
double bench_boxes_see(bench_boxes *boxes, uint64_t *seen); /* milliseconds; negative on failure */

/* ---- frames.c: a scene through the public API ---- */

typedef struct bench_frame bench_frame;
/* NULL on failure; a note says why. `lights`: how many point lights, in a ring around the scene's own where it is more
 * than one; each casts shadows. */
bench_frame *bench_frame_create(bench *self, const bench_scene *scene, int threads, int lights);
void bench_frame_destroy(bench_frame *frame);
double bench_frame_ms(bench_frame *frame); /* negative on failure */
const daft_counters *bench_frame_counters(const bench_frame *frame);
const uint8_t *bench_frame_pixels(const bench_frame *frame);

/* What the light and the surfaces are like, for ours and the peer's. */
#define BENCH_ALBEDO      ((daft_vec3){0.8f, 0.75f, 0.7f})
#define BENCH_AMBIENT     ((daft_vec3){0.2f, 0.22f, 0.25f})
#define BENCH_LIGHT_COLOR ((daft_vec3){0.9f, 0.85f, 0.8f})
#define BENCH_SKY         ((daft_vec3){0.5f, 0.6f, 0.8f})

#endif
