/* Frames to packets, with FFmpeg's libavcodec; colours by libswscale, GIF's palettes by libavfilter. */
#include "video/encode/ffmpeg.h"

#include "common/util.h"

#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libswscale/swscale.h>

#include <stdlib.h>

struct encoder {
    AVCodecContext *codec;
    AVFrame *frame;   /* as the codec wants it */
    AVPacket *packet; /* reused */
    struct SwsContext *scale;
    AVFilterGraph *graph; /* GIF: a palette for each frame */
    AVFilterContext *graph_in, *graph_out;
    int64_t frames; /* so far */
    int width, height;
};

bool ffmpeg_fail(daft_error *error, const char *what, int code)
{
    char text[AV_ERROR_MAX_STRING_SIZE] = "";
    if (code == AVERROR(ENOMEM)) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
    av_strerror(code, text, sizeof text);
    return fail(error, DAFT_ERROR_IO, "%s: %s", what, text);
}

static const char *codec_name(video_format format)
{
    return format == VIDEO_MP4 ? "libx264" : format == VIDEO_WEBM ? "libvpx-vp9" : "gif";
}

/* NULL with the message. */
static const AVCodec *find_codec(video_format format, daft_error *error)
{
    av_log_set_level(AV_LOG_ERROR);
    const AVCodec *codec = avcodec_find_encoder_by_name(codec_name(format));
    if (!codec)
        fail(error, DAFT_ERROR_UNSUPPORTED,
             "this FFmpeg has no encoder '%s': install the package libavcodec-extra (Debian) or ffmpeg with it, or "
             "choose another format: %s",
             codec_name(format), format == VIDEO_MP4 ? ".webm, .gif or numbered .png" : "numbered .png");
    return codec;
}

static void describe(AVCodecContext *codec, const video_def *def)
{
    codec->width = def->width, codec->height = def->height;
    codec->time_base = (AVRational){1000, def->rate};
    codec->framerate = (AVRational){def->rate, 1000};
    codec->thread_count = 1;
    codec->pix_fmt = def->format == VIDEO_GIF ? AV_PIX_FMT_PAL8 : AV_PIX_FMT_YUV420P;
    codec->flags |= AV_CODEC_FLAG_BITEXACT; /* no version of the library in the file */
    if (def->format == VIDEO_GIF) return;
    codec->flags |= (int)(AV_CODEC_FLAG_CLOSED_GOP | AV_CODEC_FLAG_GLOBAL_HEADER);
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->colorspace = AVCOL_SPC_BT709;
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709; /* what players of sRGB pictures expect */
    char number[16];
    snprintf(number, sizeof number, "%d", def->crf);
    av_opt_set(codec->priv_data, "crf", number, 0);
    if (def->format == VIDEO_MP4) {
        av_opt_set(codec->priv_data, "preset", "medium", 0);
        /* x264 164's macroblock tree reads memory it never wrote (its output changes with MALLOC_PERTURB_). */
        av_opt_set(codec->priv_data, "mbtree", "0", 0);
    } else {
        codec->bit_rate = 0; /* constant quality */
        av_opt_set(codec->priv_data, "deadline", "good", 0);
        av_opt_set(codec->priv_data, "cpu-used", "3", 0);
        av_opt_set(codec->priv_data, "row-mt", "0", 0);
    }
}

AVCodecContext *ffmpeg_open_codec(const video_def *def, daft_error *error)
{
    const AVCodec *found = find_codec(def->format, error);
    if (!found) return NULL;
    AVCodecContext *codec = avcodec_alloc_context3(found);
    int code = AVERROR(ENOMEM);
    if (codec) {
        describe(codec, def);
        code = avcodec_open2(codec, found, NULL);
    }
    if (code >= 0) return codec;
    ffmpeg_fail(error, codec_name(def->format), code);
    avcodec_free_context(&codec);
    return NULL;
}

/* RGBA in, PAL8 out: each frame gets a palette of its own, dithered in a pattern that does not crawl. */
static int open_palette(encoder *self, const video_def *def)
{
    char source[128];
    AVFilterInOut *inputs = NULL, *outputs = NULL;
    self->graph = avfilter_graph_alloc();
    if (!self->graph) return AVERROR(ENOMEM);
    self->graph->nb_threads = 1;
    snprintf(source, sizeof source, "video_size=%dx%d:pix_fmt=%d:time_base=1000/%d:pixel_aspect=1/1", def->width,
             def->height, AV_PIX_FMT_RGBA, def->rate);
    int code =
        avfilter_graph_create_filter(&self->graph_in, avfilter_get_by_name("buffer"), "in", source, NULL, self->graph);
    if (code >= 0)
        code = avfilter_graph_create_filter(&self->graph_out, avfilter_get_by_name("buffersink"), "out", NULL, NULL,
                                            self->graph);
    if (code >= 0)
        code = avfilter_graph_parse2(self->graph,
                                     "split[a][b];[a]palettegen=stats_mode=single:reserve_transparent=0[p];"
                                     "[b][p]paletteuse=new=1:dither=bayer:bayer_scale=4",
                                     &inputs, &outputs);
    if (code >= 0) code = avfilter_link(self->graph_in, 0, inputs->filter_ctx, (unsigned)inputs->pad_idx);
    if (code >= 0) code = avfilter_link(outputs->filter_ctx, (unsigned)outputs->pad_idx, self->graph_out, 0);
    if (code >= 0) code = avfilter_graph_config(self->graph, NULL);
    avfilter_inout_free(&inputs);
    avfilter_inout_free(&outputs);
    return code;
}

static int open_scale(encoder *self, const video_def *def)
{
    const int *matrix = sws_getCoefficients(SWS_CS_ITU709);
    /* Bit-exact: the same bytes whatever instructions the machine has. */
    self->scale = sws_getContext(def->width, def->height, AV_PIX_FMT_RGBA, def->width, def->height, AV_PIX_FMT_YUV420P,
                                 SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT, NULL, NULL, NULL);
    if (!self->scale) return AVERROR(ENOMEM);
    sws_setColorspaceDetails(self->scale, matrix, 1, matrix, 0, 0, 1 << 16, 1 << 16);
    return 0;
}

static int open_frame(encoder *self, const video_def *def)
{
    self->packet = av_packet_alloc();
    self->frame = av_frame_alloc();
    if (!self->packet || !self->frame) return AVERROR(ENOMEM);
    self->frame->format = def->format == VIDEO_GIF ? AV_PIX_FMT_RGBA : AV_PIX_FMT_YUV420P;
    self->frame->width = def->width, self->frame->height = def->height;
    int code = av_frame_get_buffer(self->frame, 0);
    if (code < 0) return code;
    return def->format == VIDEO_GIF ? open_palette(self, def) : open_scale(self, def);
}

encoder *ffmpeg_encoder_open(const video_def *def, daft_error *error)
{
    encoder *self = calloc(1, sizeof *self);
    if (!self) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
        return NULL;
    }
    self->width = def->width, self->height = def->height;
    self->codec = ffmpeg_open_codec(def, error);
    int code = self->codec ? open_frame(self, def) : 0;
    if (code < 0) ffmpeg_fail(error, "preparing frames", code);
    if (self->codec && code >= 0) return self;
    ffmpeg_encoder_close(self);
    return NULL;
}

static bool take_packets(encoder *self, packet_list *out, daft_error *error)
{
    for (;;) {
        int code = avcodec_receive_packet(self->codec, self->packet);
        if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return true;
        if (code < 0) return ffmpeg_fail(error, "encoding", code);
        packet head = {self->packet->pts, self->packet->dts, (uint32_t)self->packet->size,
                       (self->packet->flags & AV_PKT_FLAG_KEY) != 0};
        bool good = packets_add(out, &head, self->packet->data);
        av_packet_unref(self->packet);
        if (!good) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
    }
}

/* The frame's pixels, as the codec wants them. */
static int convert(encoder *self, const uint8_t *pixels)
{
    int code = av_frame_make_writable(self->frame), stride = 4 * self->width;
    if (code < 0) return code;
    self->frame->pts = self->frames++;
    if (self->scale) {
        const uint8_t *const rows[4] = {pixels};
        const int strides[4] = {stride};
        return sws_scale(self->scale, rows, strides, 0, self->height, self->frame->data, self->frame->linesize);
    }
    for (int y = 0; y < self->height; y++)
        memcpy(self->frame->data[0] + (ptrdiff_t)y * self->frame->linesize[0], pixels + (ptrdiff_t)y * stride,
               (size_t)stride);
    return av_buffersrc_add_frame_flags(self->graph_in, self->frame, AV_BUFFERSRC_FLAG_KEEP_REF);
}

/* Sends what the palette filter has ready. */
static int send_paletted(encoder *self)
{
    AVFrame *ready = av_frame_alloc();
    int code = ready ? av_buffersink_get_frame(self->graph_out, ready) : AVERROR(ENOMEM);
    if (code >= 0) code = avcodec_send_frame(self->codec, ready);
    av_frame_free(&ready);
    return code == AVERROR(EAGAIN) || code == AVERROR_EOF ? 0 : code;
}

bool ffmpeg_encoder_add(encoder *self, const uint8_t *pixels, packet_list *out, daft_error *error)
{
    int code = convert(self, pixels);
    if (code >= 0) code = self->graph ? send_paletted(self) : avcodec_send_frame(self->codec, self->frame);
    if (code < 0) return ffmpeg_fail(error, "encoding", code);
    return take_packets(self, out, error);
}

bool ffmpeg_encoder_finish(encoder *self, packet_list *out, daft_error *error)
{
    int code = avcodec_send_frame(self->codec, NULL);
    if (code < 0) return ffmpeg_fail(error, "encoding", code);
    return take_packets(self, out, error);
}

void ffmpeg_encoder_close(encoder *self)
{
    if (!self) return;
    avcodec_free_context(&self->codec);
    av_frame_free(&self->frame);
    av_packet_free(&self->packet);
    sws_freeContext(self->scale);
    avfilter_graph_free(&self->graph);
    free(self);
}
