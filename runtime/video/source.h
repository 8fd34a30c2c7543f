/* source: where a film's pictures come from: a scene seen by a camera, or a game that is replayed. */
#ifndef RUNTIME_VIDEO_SOURCE_H
#define RUNTIME_VIDEO_SOURCE_H

#include "daft.h"

typedef enum frame_result {
    FRAME_DRAWN,
    FRAME_NONE, /* the source has ended before this time */
    FRAME_FAILED
} frame_result;

typedef struct frame_source frame_source;
struct frame_source {
    bool any_order; /* times may go back: no picture depends on earlier ones */
    /* Draws the picture at `time` seconds; without any_order, calls have ascending times. Not `wanted`: nobody looks at
     * this picture, so only what later ones depend on has to happen. */
    frame_result (*draw)(struct frame_source *self, double time, bool wanted, daft_image *target, daft_error *error);
};

#endif
