/* What moves, in groups of parts that are near each other: their bounds stand side by side, so that a part is held
 * against a whole group at once. Groups are fitted anew in each step; which parts stand together is kept from step to
 * step, and matters for time only. */
#ifndef DAFT_SIM_GROUPS_H
#define DAFT_SIM_GROUPS_H

#include "math/simd/dispatch.h"
#include "sim/world.h"

enum { DAFT_SIM_GROUP = 16 };

/* In floats from the world's group_origin, rounded outwards. A lane not in use is inside out: nothing meets it. */
typedef struct daft_sim_boxes {
    _Alignas(64) float low[3][DAFT_SIM_GROUP], high[3][DAFT_SIM_GROUP];
} daft_sim_boxes;

typedef enum daft_sim_part_class {
    DAFT_SIM_STANDS = 1, /* of a static body */
    DAFT_SIM_YIELDS = 2, /* of a dynamic one */
    DAFT_SIM_SENSES = 4  /* a sensor */
} daft_sim_part_class;

typedef struct daft_sim_group {
    daft_sim_boxes boxes;
    float reach[DAFT_SIM_GROUP];   /* what does not yield is larger than all */
    uint32_t part[DAFT_SIM_GROUP]; /* DAFT_SIM_NONE: none */
    uint32_t body[DAFT_SIM_GROUP], layers[DAFT_SIM_GROUP], mask[DAFT_SIM_GROUP], class[DAFT_SIM_GROUP];
    uint64_t joined[DAFT_SIM_GROUP]; /* as of the bodies */
    float low[3], high[3];           /* around all of them */
    uint32_t used;                   /* bits */
} daft_sim_group;

/* A part of one group and one of another whose bounds meet: row · DAFT_SIM_GROUP + lane. A kernel writes some more than
 * it finds. */
enum { DAFT_SIM_CROSSINGS = DAFT_SIM_GROUP * DAFT_SIM_GROUP + 8 };

typedef struct daft_sim_group_kernels {
    /* Which of the boxes a box meets: bits. */
    uint32_t (*meets)(const daft_sim_boxes *boxes, const float low[3], const float high[3]);
    /* Parts of a group against those of another one, which may be the same. Each finds all that it meets, in its own
     * group those in lanes after it; by size: the larger ones, and of its own size those of higher index. Row by row;
     * gives how many. */
    uint32_t (*cross)(const daft_sim_group *group, const daft_sim_group *other, bool by_size,
                      uint32_t out[DAFT_SIM_CROSSINGS]);
} daft_sim_group_kernels;

DAFT_KERNEL_DECLARE(daft_sim_group_kernels, daft_sim_group);

#endif
