/* A ring of spans, and their file. */
#include "common/trace.h"

#include "common/json.h"
#include "common/util.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

typedef struct span {
    uint64_t began_ns, ended_ns;
    char name[TRACE_NAME];
    trace_track track;
} span;

struct tracer {
    pthread_mutex_t lock;
    char path[PATH_SIZE];
    uint64_t opened_ns, count; /* spans so far, also those that are lost */
    size_t room;
    bool written;
    span spans[];
};

tracer *trace_open(const char *path, size_t events, daft_error *error)
{
    tracer *self = malloc(sizeof *self + events * sizeof(span));
    if (!self) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a trace");
        return NULL;
    }
    *self = (tracer){.opened_ns = clock_now_ns(), .room = events};
    pthread_mutex_init(&self->lock, NULL);
    snprintf(self->path, sizeof self->path, "%s", path);
    return self;
}

void trace_free(tracer *self)
{
    if (!self) return;
    pthread_mutex_destroy(&self->lock);
    free(self);
}

/* ---- spans ---- */

uint64_t trace_begin(const tracer *self) { return self ? clock_now_ns() : 0; }

void trace_span(tracer *self, trace_track track, const char *name, uint64_t began_ns, uint64_t ended_ns)
{
    if (!self) return;
    pthread_mutex_lock(&self->lock);
    if (!self->written) {
        span *s = &self->spans[self->count++ % self->room];
        s->began_ns = began_ns, s->ended_ns = ended_ns, s->track = track;
        snprintf(s->name, sizeof s->name, "%s", name);
    }
    pthread_mutex_unlock(&self->lock);
}

void trace_end(tracer *self, const char *name, uint64_t began_ns)
{
    if (self) trace_span(self, TRACE_MAIN, name, began_ns, clock_now_ns());
}

/* Adds a span of so many milliseconds, and moves on behind it; not beyond `end`, since times were rounded. */
static void put_next(tracer *self, trace_track track, const char *name, double ms, uint64_t *at, uint64_t end)
{
    uint64_t next = *at + (uint64_t)(ms * 1e6);
    if (next > end) next = end;
    if (ms > 0) trace_span(self, track, name, *at, next);
    *at = next;
}

void trace_step(tracer *self, const daft_scene *scene, uint64_t began_ns)
{
    if (!self) return;
    const daft_sim_times t = daft_scene_sim_times(scene);
    const uint64_t end = clock_now_ns();
    uint64_t at = began_ns;
    put_next(self, TRACE_MAIN, "broad phase", t.broad, &at, end);
    put_next(self, TRACE_MAIN, "contacts", t.contacts, &at, end);
    put_next(self, TRACE_MAIN, "solve", t.solve, &at, end);
    put_next(self, TRACE_MAIN, "sweep", t.sweep, &at, end);
    put_next(self, TRACE_MAIN, "events", t.events, &at, end);
    trace_span(self, TRACE_MAIN, "simulation", began_ns, end);
}

void trace_picture(tracer *self, const daft_scene *scene, uint64_t began_ns)
{
    if (!self) return;
    const daft_counters *c = daft_scene_counters(scene);
    const uint64_t end = clock_now_ns();
    uint64_t at = began_ns;
    for (size_t i = 0; i < DAFT_EFFECT_COUNT; i++)
        if (c->effects[i].name && c->effects[i].ran)
            put_next(self, TRACE_EFFECTS, c->effects[i].name, c->effects[i].ms, &at, end);
    trace_span(self, TRACE_MAIN, "picture", began_ns, end);
}

/* ---- the file ---- */

static void put_name(FILE *out, const char *what, int track, const char *name)
{
    fprintf(out, "{\"ph\":\"M\",\"name\":\"%s\",\"pid\":1,\"tid\":%d,\"args\":{\"name\":", what, track);
    json_put_text(out, name);
    fputs("}}", out);
}

/* Microseconds from when the trace began; before that, in a ring that was never opened late, nothing is. */
static void put_span(FILE *out, const tracer *self, const span *s)
{
    fputs(",\n{\"ph\":\"X\",\"name\":", out);
    json_put_text(out, s->name);
    fprintf(out, ",\"cat\":\"daft\",\"pid\":1,\"tid\":%d,\"ts\":%.3f,\"dur\":%.3f}", (int)s->track,
            (double)(int64_t)(s->began_ns - self->opened_ns) / 1e3, (double)(s->ended_ns - s->began_ns) / 1e3);
}

static void put_all(FILE *out, const tracer *self)
{
    const uint64_t lost = self->count > self->room ? self->count - self->room : 0;
    fprintf(out, "{\"displayTimeUnit\":\"ms\",\"otherData\":{\"spans_lost\":%" PRIu64 "},\"traceEvents\":[\n", lost);
    put_name(out, "process_name", 0, "daft");
    fputs(",\n", out);
    put_name(out, "thread_name", TRACE_MAIN, "game");
    fputs(",\n", out);
    put_name(out, "thread_name", TRACE_EFFECTS, "effects of pictures (all threads)");
    for (uint64_t i = lost; i < self->count; i++) put_span(out, self, &self->spans[i % self->room]);
    fputs("\n]}\n", out);
}

bool trace_finish(tracer *self, daft_error *error)
{
    if (!self) return true;
    pthread_mutex_lock(&self->lock);
    const bool first = !self->written;
    self->written = true;
    pthread_mutex_unlock(&self->lock);
    draft_file text;
    if (!first) return true;
    if (self->count > self->room)
        fprintf(stderr, "daft: %s: the first %" PRIu64 " of %" PRIu64 " spans are lost: there is room for %zu\n",
                self->path, self->count - self->room, self->count, self->room);
    if (!draft_open(&text, error)) return false;
    put_all(text.file, self);
    return draft_commit(&text, self->path, error);
}
