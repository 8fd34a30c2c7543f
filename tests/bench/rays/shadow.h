/* The group of shadow rays: what its two sources share. */
#ifndef DAFT_BENCH_SHADOW_H
#define DAFT_BENCH_SHADOW_H

#include "accel/accel.h"
#include "harness/bench.h"
#include "shade/shade.h"

/* Where shadow rays start, in the order of tiles, and within them of blocks of 4 by 4 pixels. */
typedef struct shadow_origins {
    float *x, *y, *z;
    size_t count, capacity; /* with room for 16 more */
} shadow_origins;

typedef struct shadow_embree_api {
    const char *name;
    /* The instances in frame space: baked into one scene, or one level of instances. */
    bench_embree *(*create)(const daft_instance *instances, uint32_t count, bool two_level, int threads);
    void (*destroy)(bench_embree *self);
    /* Milliseconds for packets of 16 rays from the origins to the light; *dark: the number that hit something. */
    double (*occluded_ms)(bench_embree *self, const shadow_origins *from, const daft_light_source *light,
                          uint64_t *dark);
} shadow_embree_api;

/* NULL where Embree is not part of this build. */
const shadow_embree_api *shadow_find_embree(void);

#endif
