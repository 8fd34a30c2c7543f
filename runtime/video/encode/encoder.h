/* encoder: frames to packets, packets to a file, through FFmpeg's libraries. They lie behind daft_film.so (module.h),
 * which is loaded when a film is made: they pull in 150 others, which take 0.1 s to load. Without it, every `open`
 * fails with a message that names the packages. Public headers: encoder.h packets.h */
#ifndef RUNTIME_VIDEO_ENCODER_H
#define RUNTIME_VIDEO_ENCODER_H

#include "video/encode/packets.h"
#include "video/video.h"

/* One encoder makes one clip. It uses one thread, since the bits of some codecs depend on the number. */
typedef struct encoder encoder;
encoder *encoder_open(const video_def *def, daft_error *error);
/* The next frame, RGBA of the size in `def`; the packets that are ready go to `out`. */
bool encoder_add(encoder *self, const uint8_t *pixels, packet_list *out, daft_error *error);
/* After the last frame: the rest of the packets. */
bool encoder_finish(encoder *self, packet_list *out, daft_error *error);
void encoder_close(encoder *self); /* NULL is fine */

/* The file that holds all clips, written by the safe writer. */
typedef struct muxer muxer;
muxer *muxer_open(const video_def *def, daft_error *error);
/* The next clip; `start` is the number of frames before it. */
bool muxer_add(muxer *self, const packet_list *clip, uint64_t start, daft_error *error);
/* Puts the file into place and frees the muxer. */
bool muxer_commit(muxer *self, daft_error *error);
void muxer_abandon(muxer *self); /* NULL is fine */

#endif
