/* A list of parallel loops that workers go through together, without leaving the loop in between (stages.c). */
#ifndef DAFT_SIM_STAGES_H
#define DAFT_SIM_STAGES_H

#include "base/base.h"

typedef struct daft_sim_stages daft_sim_stages;

typedef struct daft_sim_stage {
    /* Items first..first + count of the stage, in any order and number of calls. */
    void (*run)(void *context, int argument, uint32_t first, uint32_t count);
    int argument;
    uint32_t first, count, grain; /* grain: items that are taken together */
} daft_sim_stage;

daft_sim_stages *daft_sim_stages_create(const daft_allocator *allocator);
void daft_sim_stages_free(daft_sim_stages *stages);
/* Room for a list of `count` stages. */
bool daft_sim_stages_reserve(daft_sim_stages *stages, size_t count);
void daft_sim_stages_clear(daft_sim_stages *stages);
void daft_sim_stages_add(daft_sim_stages *stages, daft_sim_stage stage); /* one without items is left out */
/* On all workers of a team, or alone where it is NULL. */
void daft_sim_stages_run(daft_sim_stages *stages, daft_team *team, void *context);

#endif
