/* stats: what a frame cost, as JSON and as the table of --explain. */
#ifndef RUNTIME_COMMON_STATS_H
#define RUNTIME_COMMON_STATS_H

#include "daft.h"

#include <stdio.h>

/* Times of frames, in the order they were drawn, and the sums of their effects. */
typedef struct frame_times {
    double *ms;
    size_t count, capacity;
    double effects[DAFT_EFFECT_COUNT];
    daft_memory memory;           /* of the engine, at the end */
    daft_sim_counters simulation; /* of the last tick; 0 where nothing ticks */
} frame_times;

/* `counters`: those of the frame. Drops the time when memory runs out. */
void frame_times_add(frame_times *times, double ms, const daft_counters *counters);
void frame_times_free(frame_times *times);

/* {"width", "height", "threads", "isa", "frame_ms": {"median", "p95", "frames"}, "memory": {"used", "peak", "limit"},
 * "rays", "effects", "counters", "simulation"}.
 * The counters are those of the last frame, but for the effects' "mean_ms", the mean of all frames. path: "-" writes to
 * stdout. */
bool stats_write(const char *path, const daft_counters *counters, const frame_times *times, daft_error *error);
/* Prints the plan: each effect, whether it ran and why, its tiles, rays and milliseconds. */
void stats_print_plan(FILE *out, const daft_counters *counters);

#endif
