/* The monotonic clock, and the processor's time stamp counter. */
#include "base/base.h"

#include <time.h>

#if defined(__x86_64__) || defined(__i386__)
uint64_t daft_clock_ticks(void) { return __builtin_ia32_rdtsc(); }
#else
uint64_t daft_clock_ticks(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}
#endif

double daft_clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}
