/* ffmpeg: what the encoder and the muxer share of FFmpeg's libraries. */
#ifndef RUNTIME_VIDEO_FFMPEG_H
#define RUNTIME_VIDEO_FFMPEG_H

#include "video/video.h"

#include <libavcodec/avcodec.h>
#include <libavutil/opt.h>

/* "WHAT: FFmpeg's message"; returns false. */
bool ffmpeg_fail(daft_error *error, const char *what, int code);
/* The encoder of a format, or NULL with the message. */
const AVCodec *ffmpeg_find_codec(video_format format, daft_error *error);
/* An encoder that is ready for frames; the caller frees it. NULL with the message. */
AVCodecContext *ffmpeg_open_codec(const video_def *def, daft_error *error);

#endif
