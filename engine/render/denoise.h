/* What denoising remembers of the picture before (reuse.c). */
#ifndef DAFT_RENDER_DENOISE_H
#define DAFT_RENDER_DENOISE_H

#include "render/internal.h"

/* A pixel whose sampled light is known: where among its grid's, its ray in view space, what it sees, and the inverse of
 * its depth. */
typedef struct daft_seen_pixel {
    int x, y;
    daft_vec3 ray;
    uint32_t instance;
    float inverse;
    float shown; /* the inverse depth of what it shows: its own, or farther, behind a surface that mirrors; 0: the sky
                  */
} daft_seen_pixel;

/* Pictures that count together: more would leave trails behind moving shadows. */
#define DAFT_LONGEST_PAST 8

bool daft_past_prepare(daft_past *past, const daft_allocator *allocator, const daft_snapshot *s, const daft_grid *grid,
                       daft_error *error);
/* `ratio`: what the pixel found; becomes the mean with what was found before, which is remembered. Different pixels may
 * be asked at the same time. Gives over how many pictures. */
float daft_past_pixel_reuse(daft_past *past, const daft_snapshot *s, const daft_seen_pixel *seen, float ratio[3]);
/* A pixel without sampled light. */
void daft_past_pixel_clear(daft_past *past, int x, int y);
/* What this picture has remembered is from now on what the picture before knew. */
void daft_past_turn(daft_past *past);

#endif
