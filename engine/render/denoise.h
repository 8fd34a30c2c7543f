/* What denoising remembers of the picture before (reuse.c). */
#ifndef DAFT_RENDER_DENOISE_H
#define DAFT_RENDER_DENOISE_H

#include "render/internal.h"

bool daft_past_prepare(daft_past *past, const daft_allocator *allocator, const daft_snapshot *s, const daft_grid *grid,
                       daft_error *error);
/* A tile, `side` pixels of the past high and wide, without sampled light. */
void daft_past_clear(daft_past *past, int x, int y, int side);
/* What this picture has remembered is from now on what the picture before knew. */
void daft_past_turn(daft_past *past);

#endif
