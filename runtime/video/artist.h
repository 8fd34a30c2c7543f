/* artist: draws the frames of a film on a thread of its own, as they are ordered, so that this process can answer the
 * others meanwhile. */
#ifndef RUNTIME_VIDEO_ARTIST_H
#define RUNTIME_VIDEO_ARTIST_H

#include "video/film.h"

typedef struct artist artist;

typedef struct drawing {
    struct drawing *next;
    uint64_t frame;
    int keeper; /* the process that puts it in its clip */
    frame_result result;
    daft_error error; /* of FRAME_FAILED */
    uint8_t *bytes;   /* the frame's number, as uint64_t, and its pixels; NULL where the picture has been written */
    size_t size;
} drawing;

/* NULL with the message. Until artist_close nobody else may use the film's source and image. */
artist *artist_open(film *f, daft_error *error);
/* Orders a frame; unless the source is for any order, they ascend. False: out of memory. */
bool artist_order(artist *self, uint64_t frame, int keeper);
/* The next frame that is ready, or NULL. drawing_free frees it. */
drawing *artist_take(artist *self);
void drawing_free(drawing *self);
/* Waits for the frame that is being drawn. NULL is fine. */
void artist_close(artist *self);

#endif
