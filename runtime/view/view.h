/* view: a window to look at a scene, a mesh or a picture: flying, what of the shading is shown, channels of pixels,
 * what lies under the cursor, and a picture that gets finer while nothing moves. Public headers: view.h
 *
 * Data flow, all on the thread that calls: events -> keys.c (what a key does, as a table) -> viewer -> fly.c (the
 * camera) -> draw.c (a picture at quality `game`, or a channel of it) -> refine.c (bands of it at `reference` while
 * nothing moves) -> screen.c (text over a copy) -> the window. Snapshots and films are made beside it (job/).
 * Promises: a move is answered in the next frame; what is opened by mistake or saved half-way leaves what is shown as
 * it was, with the message on the screen. */
#ifndef RUNTIME_VIEW_VIEW_H
#define RUNTIME_VIEW_VIEW_H

#include "common/quality.h"
#include "hud/canvas.h"
#include "platform/platform.h"

typedef struct view_def {
    platform *screen;
    daft_engine *engine;
    font *face;
    const char *path;                    /* a .scene, an .obj, or a picture */
    long camera;                         /* of the file's cameras, from 0; below 0: the first */
    quality_wish quality;                /* while the camera moves */
    int snapshot_width, snapshot_height; /* 0: the window's */
} view_def;

/* Shows the file until the user leaves. False: it could not be opened, or the window failed. */
bool view_run(const view_def *def, daft_error *error);
/* Every key and what it does, a line each, for --help. Returns `out`. */
const char *view_keys_text(char *out, size_t size);

#endif
