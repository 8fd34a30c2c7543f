/* soundtrack: what a film sounds like, encoded: AAC for MP4, Opus for WebM; other formats are silent. */
#ifndef RUNTIME_VIDEO_SOUNDTRACK_H
#define RUNTIME_VIDEO_SOUNDTRACK_H

#include "video/video.h"

enum { SOUNDTRACK_RATE = 48000 }; /* frames a second */

/* NULL with the message where this FFmpeg cannot. */
soundtrack *soundtrack_open(video_format format, daft_error *error);
/* Frames of 16 bits, left and right by turns. */
bool soundtrack_add(soundtrack *self, const int16_t *frames, uint32_t count, daft_error *error);
/* After the last frame: all packets are there. */
bool soundtrack_finish(soundtrack *self, daft_error *error);
void soundtrack_close(soundtrack *self); /* NULL is fine */

#endif
