/* What the machine gives at most: bytes read from memory, and simple instructions; docs/measurements/performance.md holds the
 * kernels against them. */
#include "bench.h"

#include <string.h>

enum { WORDS = 1 << 24, STRIPES = 64 }; /* 128 MB: more than caches hold */

typedef struct machine_job {
    uint64_t *words;
    int threads;
    uint64_t sums[64];
} machine_job;

static void read_stripe(void *context, uint32_t stripe, uint32_t worker)
{
    machine_job *job = context;
    const uint64_t *from = job->words + (size_t)stripe * (WORDS / STRIPES);
    uint64_t sum[8] = {0};
    for (size_t i = 0; i < WORDS / STRIPES; i += 8)
        for (size_t k = 0; k < 8; k++) sum[k] += from[i + k];
    for (size_t k = 0; k < 8; k++) job->sums[worker] += sum[k];
}

static double read_memory(void *context)
{
    machine_job *job = context;
    double start = bench_clock_ms(job->threads);
    daft_parallel_for(job->threads, STRIPES, read_stripe, job);
    return (double)WORDS * sizeof(uint64_t) / (bench_clock_ms(job->threads) - start) / 1e6;
}

#if defined(__x86_64__)
enum { TURNS = 1 << 22, ADDS = 16 };

/* Additions that wait for nothing but their own register, on every worker. */
static void add_up(void *context, uint32_t index, uint32_t worker)
{
    uint64_t a = index, b = 1, c = 2, d = 3, e = 4, f = 5, g = 6, h = 7;
    for (int i = 0; i < TURNS; i++)
        __asm__ volatile("add $1, %0\n add $1, %1\n add $1, %2\n add $1, %3\n"
                         "add $1, %4\n add $1, %5\n add $1, %6\n add $1, %7\n"
                         "lea 1(%0), %0\n lea 1(%1), %1\n lea 1(%2), %2\n lea 1(%3), %3\n"
                         "lea 1(%4), %4\n lea 1(%5), %5\n lea 1(%6), %6\n lea 1(%7), %7\n"
                         : "+r"(a), "+r"(b), "+r"(c), "+r"(d), "+r"(e), "+r"(f), "+r"(g), "+r"(h));
    ((machine_job *)context)->sums[worker] += a + b + c + d + e + f + g + h;
}

static double issue(void *context)
{
    machine_job *job = context;
    double start = bench_clock_ms(job->threads);
    daft_parallel_for(job->threads, (uint32_t)job->threads, add_up, job);
    return (double)TURNS * ADDS * job->threads / (bench_clock_ms(job->threads) - start) / 1e6;
}

static void measure_issue(bench *self, machine_job *job)
{
    bench_subject subject = {.scene = "machine",
                             .what = "instructions",
                             .unit = "G/s",
                             .isa = self->isa,
                             .threads = job->threads,
                             .ours = issue,
                             .context = job};
    if (bench_wants(self, subject.scene, subject.what)) bench_measure(self, &subject);
}
#else
static void measure_issue(bench *self, machine_job *job)
{
    (void)self, (void)job;
}
#endif

static void measure_memory(bench *self, machine_job *job)
{
    bench_subject subject = {.scene = "machine",
                             .what = "memory, read",
                             .unit = "GB/s",
                             .isa = self->isa,
                             .threads = job->threads,
                             .ours = read_memory,
                             .context = job};
    if (!bench_wants(self, subject.scene, subject.what)) return;
    job->words = daft_alloc(&self->allocator, WORDS, sizeof *job->words);
    if (!job->words) {
        bench_note(self, true, "out of memory");
        return;
    }
    memset(job->words, 1, WORDS * sizeof *job->words);
    bench_measure(self, &subject);
    daft_release(&self->allocator, job->words);
}

void bench_machine(bench *self)
{
    int threads[2], count = self->list ? 1 : bench_thread_counts(self, threads);
    for (int t = 0; t < count; t++) {
        machine_job job = {.threads = self->list ? 1 : threads[t]};
        measure_memory(self, &job);
        measure_issue(self, &job);
    }
}
