/* What only a processor's own instructions do, with a twin for every other processor. */
#ifndef DAFT_CPU_H
#define DAFT_CPU_H

#include <stdint.h>
#include <time.h>

/* Ticks of a counter that runs evenly, read in a few nanoseconds: the processor's own, or nanoseconds. */
static inline uint64_t daft_cpu_ticks(void)
{
#if defined(__x86_64__)
    uint32_t low, high;
    __asm__ volatile("rdtsc" : "=a"(low), "=d"(high));
    return (uint64_t)high << 32 | low;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
#endif
}

/* Inside a loop that waits for another thread: leaves the core's resources to its other thread. */
static inline void daft_cpu_pause(void)
{
#if defined(__x86_64__)
    __asm__ volatile("pause");
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

#endif
