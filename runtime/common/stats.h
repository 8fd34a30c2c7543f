/* stats: what a frame cost, as JSON and as the table of --explain. */
#ifndef RUNTIME_COMMON_STATS_H
#define RUNTIME_COMMON_STATS_H

#include "daft.h"

#include <stdio.h>

/* Times of frames, in the order they were drawn. */
typedef struct frame_times {
    double *ms;
    size_t count, capacity;
} frame_times;

/* A time for which there is no memory is left out. */
void frame_times_add(frame_times *times, double ms);
void frame_times_free(frame_times *times);
/* The time that a share of the frames does not exceed: 0.5 is the median. 0 without frames. */
double frame_times_share(const frame_times *times, double share);

/* {"width", "height", "threads", "isa", "frame_ms": {"median", "p95", "frames"}, "rays", "effects", "counters"}.
 * Counters are of the last frame. */
bool stats_write(const char *path, const daft_counters *counters, const frame_times *times, daft_error *error);
void stats_print_json(FILE *out, const daft_counters *counters, const frame_times *times);
/* The plan: each effect, whether it ran and why, tiles, rays, milliseconds. */
void stats_print_plan(FILE *out, const daft_counters *counters);

#endif
