/* Frames of sound to packets, with FFmpeg's libavcodec. */
#include "video/encode/ffmpeg.h"

#include "common/util.h"

#include <libavutil/channel_layout.h>
#include <stdlib.h>

static int set_up(soundtrack *self, const AVCodec *codec)
{
    AVCodecContext *c = self->codec = avcodec_alloc_context3(codec);
    self->frame = av_frame_alloc(), self->packet = av_packet_alloc();
    if (!c || !self->frame || !self->packet) return AVERROR(ENOMEM);
    c->sample_rate = SOUNDTRACK_RATE;
    c->sample_fmt = codec->sample_fmts[0];
    c->time_base = (AVRational){1, SOUNDTRACK_RATE};
    c->bit_rate = 160000;
    c->thread_count = 1;
    c->flags |= AV_CODEC_FLAG_BITEXACT | (int)AV_CODEC_FLAG_GLOBAL_HEADER;
    av_channel_layout_default(&c->ch_layout, 2);
    int code = avcodec_open2(c, codec, NULL);
    if (code < 0) return code;
    self->frame->format = c->sample_fmt, self->frame->nb_samples = c->frame_size;
    self->frame->sample_rate = SOUNDTRACK_RATE;
    code = av_channel_layout_copy(&self->frame->ch_layout, &c->ch_layout);
    return code < 0 ? code : av_frame_get_buffer(self->frame, 0);
}

soundtrack *ffmpeg_soundtrack_open(video_format format, daft_error *error)
{
    const char *name = format == VIDEO_MP4 ? "aac" : "libopus";
    av_log_set_level(AV_LOG_ERROR);
    const AVCodec *codec = avcodec_find_encoder_by_name(name);
    if (!codec) {
        fail(error, DAFT_ERROR_UNSUPPORTED, "this FFmpeg has no encoder '%s' for sound", name);
        return NULL;
    }
    soundtrack *self = calloc(1, sizeof *self);
    const int code = self ? set_up(self, codec) : AVERROR(ENOMEM);
    if (code >= 0) return self;
    ffmpeg_fail(error, "sound", code);
    ffmpeg_soundtrack_close(self);
    return NULL;
}

static int take_packets(soundtrack *self)
{
    for (;;) {
        const int code = avcodec_receive_packet(self->codec, self->packet);
        if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return 0;
        if (code < 0) return code;
        const AVPacket *p = self->packet;
        const packet head = {p->pts, p->dts, (uint32_t)p->size, true};
        const bool kept = packets_add(&self->packets, &head, p->data);
        av_packet_unref(self->packet);
        if (!kept) return AVERROR(ENOMEM);
    }
}

static int send(soundtrack *self)
{
    self->frame->pts = self->next, self->frame->nb_samples = self->filled;
    self->next += self->filled, self->filled = 0;
    int code = avcodec_send_frame(self->codec, self->frame);
    if (code >= 0) code = take_packets(self);
    self->frame->nb_samples = self->codec->frame_size;
    return code < 0 ? code : av_frame_make_writable(self->frame);
}

static void put(AVFrame *frame, int at, const int16_t sides[2])
{
    for (int k = 0; k < 2; k++) {
        float *planar = (float *)(void *)frame->data[frame->format == AV_SAMPLE_FMT_FLTP ? k : 0];
        if (frame->format == AV_SAMPLE_FMT_FLTP)
            planar[at] = (float)sides[k] / 32768;
        else if (frame->format == AV_SAMPLE_FMT_FLT)
            planar[2 * at + k] = (float)sides[k] / 32768;
        else
            ((int16_t *)(void *)frame->data[0])[2 * at + k] = sides[k];
    }
}

bool ffmpeg_soundtrack_add(soundtrack *self, const int16_t *frames, uint32_t count, daft_error *error)
{
    for (uint32_t i = 0; i < count; i++) {
        put(self->frame, self->filled++, &frames[(size_t)2 * i]);
        const int code = self->filled == self->codec->frame_size ? send(self) : 0;
        if (code < 0) return ffmpeg_fail(error, "sound", code);
    }
    return true;
}

bool ffmpeg_soundtrack_finish(soundtrack *self, daft_error *error)
{
    int code = self->filled ? send(self) : 0;
    if (code >= 0) code = avcodec_send_frame(self->codec, NULL);
    if (code >= 0) code = take_packets(self);
    return code >= 0 || ffmpeg_fail(error, "sound", code);
}

void ffmpeg_soundtrack_close(soundtrack *self)
{
    if (!self) return;
    avcodec_free_context(&self->codec);
    av_frame_free(&self->frame);
    av_packet_free(&self->packet);
    packets_free(&self->packets);
    free(self);
}
