/* The monotonic clock, and the processor's time stamp counter. */
#include "base/base.h"
#include "base/cpu.h"

#include <time.h>

uint64_t daft_clock_ticks(void) { return daft_cpu_ticks(); }

double daft_clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}
