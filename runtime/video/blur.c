/* The mean of several pictures in linear light. */
#include "video/blur.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* IEC 61966-2-1. */
static double decode(double value) { return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4); }

bool blur_open(blur *out, size_t pixels, daft_error *error)
{
    *out = (blur){.sum = calloc(3 * pixels, sizeof(float)), .pixels = pixels};
    for (int i = 0; i < 256; i++) {
        out->light[i] = (float)decode(i / 255.0);
        out->edge[i] = (float)decode((i + 0.5) / 255);
    }
    return out->sum || fail(error, DAFT_ERROR_MEMORY, "out of memory for motion blur");
}

void blur_close(blur *self)
{
    free(self->sum);
    self->sum = NULL;
}

void blur_add(blur *self, const uint8_t *pixels)
{
    for (size_t i = 0; i < self->pixels; i++)
        for (size_t k = 0; k < 3; k++) self->sum[3 * i + k] += self->light[pixels[4 * i + k]];
    self->count++;
}

/* The number of edges that lie below `light`. */
static uint8_t encode(const blur *self, float light)
{
    int low = 0;
    for (int step = 128; step > 0; step /= 2)
        if (light > self->edge[low + step - 1]) low += step;
    return (uint8_t)low;
}

void blur_take(blur *self, uint8_t *pixels)
{
    float part = 1 / (float)self->count;
    for (size_t i = 0; i < self->pixels; i++) {
        for (size_t k = 0; k < 3; k++) pixels[4 * i + k] = encode(self, self->sum[3 * i + k] * part);
        pixels[4 * i + 3] = 255;
    }
    memset(self->sum, 0, 3 * self->pixels * sizeof(float));
    self->count = 0;
}
