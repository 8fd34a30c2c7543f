/* ffmpeg: the sources of daft_film.so, all called ffmpeg*, which are linked with FFmpeg's libraries. */
#ifndef RUNTIME_VIDEO_FFMPEG_H
#define RUNTIME_VIDEO_FFMPEG_H

#include "video/encode/module.h"

#include <libavcodec/avcodec.h>
#include <libavutil/opt.h>

/* "WHAT: FFmpeg's message"; returns false. */
bool ffmpeg_fail(daft_error *error, const char *what, int code);
/* An encoder that is ready for frames; the caller frees it. NULL with the message. */
AVCodecContext *ffmpeg_open_codec(const video_def *def, daft_error *error);

/* What the muxer sees of a soundtrack. */
struct soundtrack {
    AVCodecContext *codec;
    AVFrame *frame;
    AVPacket *packet;    /* reused */
    int filled;          /* of the frame */
    int64_t next;        /* the frame's first sample */
    packet_list packets; /* their times in frames of sound */
};

/* As in encoder.h. */
encoder *ffmpeg_encoder_open(const video_def *def, daft_error *error);
bool ffmpeg_encoder_add(encoder *self, const uint8_t *pixels, packet_list *out, daft_error *error);
bool ffmpeg_encoder_finish(encoder *self, packet_list *out, daft_error *error);
void ffmpeg_encoder_close(encoder *self);
muxer *ffmpeg_muxer_open(const video_def *def, daft_error *error);
bool ffmpeg_muxer_add(muxer *self, const packet_list *clip, uint64_t start, daft_error *error);
bool ffmpeg_muxer_commit(muxer *self, daft_error *error);
void ffmpeg_muxer_abandon(muxer *self);
/* As in soundtrack.h. */
soundtrack *ffmpeg_soundtrack_open(video_format format, daft_error *error);
bool ffmpeg_soundtrack_add(soundtrack *self, const int16_t *frames, uint32_t count, daft_error *error);
bool ffmpeg_soundtrack_finish(soundtrack *self, daft_error *error);
void ffmpeg_soundtrack_close(soundtrack *self);

#endif
