/* The group `robust` counts wrong answers instead of time. The same hard rays go through DAFT and, where it is
 * installed, through Embree in its fast mode (its default) and in its robust mode. */
#ifndef DAFT_BENCH_ROBUST_H
#define DAFT_BENCH_ROBUST_H

#include "accel/accel.h"
#include "harness/bench.h"

/* Something that traces single rays through a mesh or a sphere. */
typedef struct robust_tracer {
    const char *name; /* lives as long as the program; NULL: not there */
    void *self;
    void *(*mesh)(void *self, const daft_trimesh *mesh); /* a scene; NULL on failure. The mesh outlives it. */
    void *(*sphere)(void *self, daft_vec3 centre, float radius);
    void (*drop)(void *scene);
    bool (*closest)(void *scene, const daft_ray *ray, float *t);
    void (*close)(void *self);
} robust_tracer;

bool robust_open_daft(const bench *self, robust_tracer *out);
/* False where Embree is not part of this build. */
bool robust_open_embree(bool robust, robust_tracer *out);

enum { ROBUST_TRACERS = 3 }; /* ours, Embree fast, Embree robust */

/* One row of the table: right answers of each tracer, out of how many. */
typedef struct robust_score {
    const char *scene, *what;
    uint64_t asked, wrong[ROBUST_TRACERS];
} robust_score;

/* The classes of tests/data/cases/ray_cases.csv that are about meshes, triangles and spheres: fills in `scores`,
 * returns how many; 0 where the file is missing. Tracers without a name are left out. */
enum { ROBUST_CLASSES = 5 };
size_t robust_cases(bench *self, const robust_tracer *tracers, robust_score scores[ROBUST_CLASSES]);

#endif
