/* progress: a progress bar on stderr. */
#ifndef RUNTIME_COMMON_PROGRESS_H
#define RUNTIME_COMMON_PROGRESS_H

#include "daft.h"

/* A bar on stderr, drawn at most ten times a second, and only on a terminal. */
typedef struct progress_bar {
    const char *label;
    bool shown;
    uint64_t began_ns, last_ns;
} progress_bar;

void progress_begin(progress_bar *bar, const char *label);
void progress_show(progress_bar *bar, double done); /* 0..1 */
/* Erases the bar. */
void progress_end(progress_bar *bar);

#endif
