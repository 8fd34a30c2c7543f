/* A program of libFuzzer for one target: FUZZ_TARGET is its name. */
#include "fuzz.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const fuzz_target *target;
    for (int i = 0; !target && i < FUZZ_TARGET_COUNT; i++)
        if (strcmp(FUZZ_TARGETS[i].name, FUZZ_TARGET) == 0) target = &FUZZ_TARGETS[i];
    return fuzz_run(target, data, size);
}
