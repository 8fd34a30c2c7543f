/* trace: what the program did when, for chrome://tracing and Perfetto: a file in the Trace Event Format (Google, 2016),
 * complete events alone. They stay in memory until the file is written, the newest of them where there are too many.
 * Promises: where nobody traces (NULL) a span costs a comparison; the file is whole or not there, also where the
 * program ends early. */
#ifndef RUNTIME_COMMON_TRACE_H
#define RUNTIME_COMMON_TRACE_H

#include "daft.h"

enum { TRACE_EVENTS = 1 << 18, TRACE_NAME = 32 }; /* 15 MB; four minutes of a game, or so */

/* Lines of the picture, one below the other. Spans of one line lie beside or within each other. */
typedef enum trace_track {
    TRACE_MAIN,   /* the thread that runs the game and waits for the others */
    TRACE_EFFECTS /* of pictures: the time of all threads, divided by their number, one after the other */
} trace_track;

typedef struct tracer tracer;

/* NULL: memory is out. `events`: the most that are kept. */
tracer *trace_open(const char *path, size_t events, daft_error *error);
/* Writes the file, once: from any thread, while others add what is not written any more. NULL is fine. */
bool trace_finish(tracer *self, daft_error *error);
void trace_free(tracer *self); /* NULL is fine */

/* Now, to be handed to trace_end; 0 where nobody traces. */
uint64_t trace_begin(const tracer *self);
void trace_end(tracer *self, const char *name, uint64_t began_ns);
/* What has been timed by somebody else. */
void trace_span(tracer *self, trace_track track, const char *name, uint64_t began_ns, uint64_t ended_ns);
/* The stages of a step of the simulation that began then; and the effects of a picture. */
void trace_step(tracer *self, const daft_scene *scene, uint64_t began_ns);
void trace_picture(tracer *self, const daft_scene *scene, uint64_t began_ns);

#endif
