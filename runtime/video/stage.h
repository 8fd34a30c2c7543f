/* stage: encodes the frames of a clip on a thread of its own, while the next ones are drawn. */
#ifndef RUNTIME_VIDEO_STAGE_H
#define RUNTIME_VIDEO_STAGE_H

#include "video/encode/encoder.h"

typedef struct stage stage;

/* `size`: bytes of a frame. Packets go to `out`, which belongs to the stage until stage_close. Where the system gives
 * no thread, frames are encoded as they come. NULL with the message. */
stage *stage_open(encoder *to, size_t size, packet_list *out, daft_error *error);
/* Copies the frame; waits while STAGE_FRAMES are under way. False where one before it failed: stage_close has the
 * message. */
bool stage_add(stage *self, const uint8_t *pixels);
/* Whether stage_add would wait. */
bool stage_full(stage *self);
/* No more frames come. The thread encodes those that are there, and what the encoder still holds; stage_ended tells
 * when that is done, and stage_close does not wait then. */
void stage_end(stage *self);
bool stage_ended(stage *self);
/* Waits for the frames, finishes the clip where `finish` is set, and frees the stage. */
bool stage_close(stage *self, bool finish, daft_error *error);

#endif
