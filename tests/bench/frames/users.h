/* Users' frames: what games and scenes cost as people meet them, at 1280x720. Each gives two rows, the median and the
 * 95th percentile of its frames, with the milliseconds of each effect. These rows lead the table. */
#ifndef DAFT_BENCH_USERS_H
#define DAFT_BENCH_USERS_H

#include "harness/bench.h"

/* The frames of one game or scene with so many threads. */
typedef struct users_frames {
    double median, p95;                /* milliseconds */
    double effects[DAFT_EFFECT_COUNT]; /* milliseconds, mean of all frames */
    const char *names[DAFT_EFFECT_COUNT];
    int frames;
} users_frames;

/* Adds the two rows. `note` stands before the effects; floor and aim are for the 95th percentile, in milliseconds; 0:
 * none. */
void users_report(bench *self, const char *scene, int threads, const users_frames *f, const char *note, double floor,
                  double aim);
/* Whether the user asked for one of the two rows. */
bool users_wants(bench *self, const char *scene);

#endif
