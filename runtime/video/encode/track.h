/* track: what the muxer sees of a soundtrack. */
#ifndef RUNTIME_VIDEO_TRACK_H
#define RUNTIME_VIDEO_TRACK_H

#include "video/encode/ffmpeg.h"
#include "video/encode/packets.h"

struct soundtrack {
    AVCodecContext *codec;
    AVFrame *frame;
    AVPacket *packet;    /* reused */
    int filled;          /* of the frame */
    int64_t next;        /* the frame's first sample */
    packet_list packets; /* their times in frames of sound */
};

#endif
