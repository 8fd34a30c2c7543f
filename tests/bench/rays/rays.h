/* Rays through trees: ours (rays.c) and Embree's (rays_embree.c). Each side reads rays from memory in the layout that
 * suits it best; only tracing is timed. */
#ifndef DAFT_BENCH_RAYS_H
#define DAFT_BENCH_RAYS_H

#include "harness/scenes.h"

typedef enum rays_how {
    RAYS_CLOSEST_SINGLE,
    RAYS_OCCLUDED_SINGLE,
    RAYS_CLOSEST_PACKET,
    RAYS_OCCLUDED_PACKET,
    RAYS_CLOSEST_STREAM,
    RAYS_HOW_COUNT
} rays_how;

enum { RAYS_TASK = 1024 }; /* rays in a task; a multiple of 16 */

typedef struct rays_embree rays_embree;
typedef struct rays_embree_api {
    rays_embree *(*create)(bench_embree *scene); /* which must outlive it; NULL: out of memory */
    void (*destroy)(rays_embree *self);
    /* In world space; count: a multiple of 16. False: out of memory. */
    bool (*load)(rays_embree *self, const daft_ray *rays, uint32_t count);
    double (*trace_ms)(rays_embree *self, rays_how how, bool coherent, uint64_t *hits);
} rays_embree_api;

/* NULL where Embree is not part of this build. */
const rays_embree_api *rays_find_embree(void);

#endif
