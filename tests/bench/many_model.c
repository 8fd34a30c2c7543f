/* How a film scales over many processes: the scheduler that daft video uses (runtime/many/share.c), on processes that
 * are only pretended. They draw, send and encode as long as was measured.
 *
 * many_model DRAW ENCODE [WIDTH HEIGHT SECONDS [STEP]]: milliseconds of one frame drawn, and encoded, by one process.
 * With STEP it is a game's film, in which each process steps through all that comes before its frames: so long for a
 * frame.
 *
 * A process draws on one thread and encodes on another. Its network takes 10 Gbit/s either way, a message 50 µs and the
 * process that looks for it 0.2 ms. Frames differ by a factor of up to 2, machines by up to 1.5; both are drawn from a
 * fixed seed. Efficiency is against all of them drawing all the time. Not in it: reading the scene, which every process
 * does at the start, and putting the clips together, which copies them. */
#include "many/share.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RATE = 60, CLIP = 120 };
static const double LATENCY = 50e-6 + 200e-6, BANDWIDTH = 1.25e9, HANDLING = 5e-6; /* s, bytes/s, s a message */

typedef enum event_kind { DRAWN, ARRIVED, ENCODED } event_kind;

typedef struct event {
    double time;
    uint64_t frame;
    int process, keeper;
    event_kind kind;
} event;

typedef struct process {
    double speed, artist, out, in; /* `artist`, `out`, `in`: busy until then */
    uint64_t cursor;               /* a game has come so far */
} process;

typedef struct clip {
    uint64_t arrived, encoded; /* frames */
    double free;               /* its encoder is busy until then */
} clip;

typedef struct model {
    double draw, encode, step, bytes;
    uint64_t frames;
    process *processes;
    clip *clips;
    event *heap;
    size_t size, capacity;
    share share;
    double server; /* process 0 answers messages until then */
    double end;
} model;

static uint64_t random_state;

static double random_unit(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 11) / 9007199254740992.0;
}

/* ---- events by their time ---- */

static void push(model *m, event e)
{
    if (m->size == m->capacity) {
        m->capacity = m->capacity ? 2 * m->capacity : 1024;
        m->heap = realloc(m->heap, m->capacity * sizeof *m->heap);
        if (!m->heap) abort();
    }
    size_t at = m->size++;
    for (; at > 0 && m->heap[(at - 1) / 2].time > e.time; at = (at - 1) / 2) m->heap[at] = m->heap[(at - 1) / 2];
    m->heap[at] = e;
}

static event pop(model *m)
{
    event first = m->heap[0], last = m->heap[--m->size];
    size_t at = 0;
    for (size_t next; (next = 2 * at + 1) < m->size; at = next) {
        if (next + 1 < m->size && m->heap[next + 1].time < m->heap[next].time) next++;
        if (m->heap[next].time >= last.time) break;
        m->heap[at] = m->heap[next];
    }
    m->heap[at] = last;
    return first;
}

/* ---- the processes ---- */

static double later(double a, double b) { return a > b ? a : b; }

static void hand_out(model *m, double now)
{
    share_work work;
    while (share_give(&m->share, &work)) {
        process *p = &m->processes[work.process];
        m->server = later(m->server, now) + HANDLING;
        double steps = m->step * (double)(work.piece + 1 - p->cursor), draw = m->draw * (0.667 + 0.667 * random_unit());
        p->cursor = work.piece + 1;
        p->artist = later(p->artist, m->server + LATENCY) + (draw + steps) * p->speed;
        push(m, (event){p->artist, work.piece, work.process, work.keeper, DRAWN});
    }
}

/* The frame goes through the network of who sends and of who encodes. */
static void send(model *m, const event *e)
{
    process *from = &m->processes[e->process], *to = &m->processes[e->keeper];
    double start = later(later(from->out, to->in), e->time), wire = from == to ? 0 : m->bytes / BANDWIDTH;
    from->out = to->in = start + wire;
    push(m, (event){start + wire + (from == to ? 0 : LATENCY), e->frame, e->process, e->keeper, ARRIVED});
}

/* Encoders take frames in order; those of one clip take equally long, so only their number counts. */
static void encode(model *m, const event *e)
{
    clip *c = &m->clips[e->frame / CLIP];
    c->free = later(c->free, e->time) + m->encode;
    push(m, (event){c->free, e->frame, e->process, e->keeper, ENCODED});
}

static double run(model *m)
{
    hand_out(m, 0);
    while (m->size > 0) {
        event e = pop(m);
        m->end = e.time;
        if (e.kind == DRAWN) {
            m->server = later(m->server, e.time) + HANDLING;
            share_made(&m->share, e.process);
            send(m, &e);
        } else if (e.kind == ARRIVED) {
            encode(m, &e);
        } else {
            m->server = later(m->server, e.time) + HANDLING;
            share_taken(&m->share, e.frame);
        }
        hand_out(m, e.time + LATENCY);
    }
    return m->end;
}

/* Seconds of the film, and of one for which all had drawn all the time. */
static double time_of(const model *of, int count, double *ideal)
{
    model m = *of;
    share_def def = {.count = m.frames, .group = CLIP, .processes = count, .ascending = m.step > 0};
    m.processes = calloc((size_t)count, sizeof *m.processes);
    m.clips = calloc(m.frames / CLIP + 1, sizeof *m.clips);
    if (!m.processes || !m.clips || !share_open(&m.share, &def)) abort();
    random_state = 1;
    double speed = 0;
    for (int i = 0; i < count; i++) {
        m.processes[i].speed = count > 1 ? 0.8 + 0.4 * i / (count - 1) : 1;
        speed += 1 / m.processes[i].speed;
    }
    *ideal = (m.draw + m.step) * (double)m.frames / speed;
    double end = run(&m);
    share_close(&m.share);
    free(m.processes), free(m.clips), free(m.heap);
    return end;
}

int main(int argc, char **argv)
{
    static const int COUNTS[] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000};
    double n[6] = {0, 0, 1280, 720, 600, 0};
    for (int i = 1; i < argc && i < 7; i++) n[i - 1] = atof(argv[i]);
    if ((argc != 3 && argc != 6 && argc != 7) || !(n[0] > 0 && n[1] >= 0 && n[2] * n[3] > 0 && n[4] > 0 && n[5] >= 0)) {
        fprintf(stderr, "usage: many_model DRAW_MS ENCODE_MS [WIDTH HEIGHT SECONDS [STEP_MS]]\n");
        return 2;
    }
    model m = {.draw = n[0] / 1000, .encode = n[1] / 1000, .step = n[5] / 1000, .bytes = 4 * n[2] * n[3]};
    m.frames = (uint64_t)(n[4] * RATE);
    printf("| processes | seconds | frames a second | efficiency |\n|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof COUNTS / sizeof *COUNTS; i++) {
        double ideal, time = time_of(&m, COUNTS[i], &ideal);
        printf("| %d | %.1f | %.0f | %.0f %% |\n", COUNTS[i], time, (double)m.frames / time, 100 * ideal / time);
    }
    return 0;
}
