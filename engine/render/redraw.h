/* What a picture may keep of the one before (redraw.c). */
#ifndef DAFT_RENDER_REDRAW_H
#define DAFT_RENDER_REDRAW_H

#include "render/internal.h"

/* Why a tile is drawn: a change reaches it; it is beside such a tile, so its antialiased pixels may differ; it is
 * beside one of these, which are compared with it. */
enum { DAFT_TILE_KEPT, DAFT_TILE_REACHED, DAFT_TILE_MIXED, DAFT_TILE_BESIDE };

/* Chooses the frame's tiles: all of them, those that changes since the picture before may reach, or none. Then puts
 * what is kept into the target. False: memory is out. */
bool daft_redraw_begin(daft_frame *frame, daft_error *error);
/* Once all of the frame's tiles are drawn: restores those that were drawn for their neighbours' sake alone, and keeps
 * the rest for the next picture. */
bool daft_redraw_end(daft_frame *frame, daft_error *error);

#endif
