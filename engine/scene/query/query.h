/* query: rays against a scene: one at a time (query.c), or all those of a laser scanner (pattern.c, scan.c).
 * Public headers: none. Inner headers: query.h
 * Promises: an answer depends on the scene and the ray alone; each ray of a scan that stands still is answered as
 * daft_scene_cast_ray answers it, bit for bit. */
#ifndef DAFT_SCENE_QUERY_H
#define DAFT_SCENE_QUERY_H

#include "scene/scene.h"

/* The tree for rays from about here. False: memory is out. */
bool daft_query_open(daft_scene *scene, daft_dvec3 from, daft_error *error);
/* World transforms of all that rays can hit, for daft_query_answer. */
void daft_query_walk(daft_scene *scene);
/* The instance of an entity to pass through; UINT32_MAX for none. */
uint32_t daft_query_skip(const daft_scene *scene, daft_entity ignore);
/* A ray for the search in floats; `direction` is unit. */
daft_ray daft_query_float_ray(const daft_scene *scene, daft_dvec3 origin, daft_dvec3 direction, float max_distance);
/* What the search has found, in double: `direction` is unit. Any thread may call it. */
void daft_query_answer(const daft_scene *scene, const daft_hit *found, daft_dvec3 origin, daft_dvec3 direction,
                       daft_ray_hit *out);

/* ---- pattern.c ---- */

/* A ray of a scan as it leaves the sensor. */
typedef struct daft_scan_line {
    daft_dvec3 origin;
    daft_vec3 direction; /* unit, but for rounding */
    double time;         /* s */
} daft_scan_line;

/* Sines and cosines of a pattern's rows and columns. */
typedef struct daft_scan_table {
    const daft_scan_def *def;
    uint32_t fast, slow;  /* ray i is number i % fast of line i / fast */
    double *row, *column; /* two each; NULL for a list */
} daft_scan_table;

bool daft_scan_table_open(const daft_allocator *allocator, const daft_scan_def *def, daft_scan_table *out,
                          daft_error *error);
void daft_scan_table_close(const daft_allocator *allocator, daft_scan_table *table);
/* Rays first to first + count - 1 of one line. */
void daft_scan_lines(const daft_scan_table *table, uint32_t line, uint32_t first, uint32_t count, daft_scan_line *out);
bool daft_scan_def_check(const daft_scan_def *def, daft_error *error);

#endif
