/* Packets to a file, with FFmpeg's libavformat, through the safe writer. */
#include "video/encode/ffmpeg.h"

#include "common/util.h"

#include <libavformat/avformat.h>

#include <stdlib.h>

enum { BUFFER = 1 << 16 };

struct muxer {
    AVFormatContext *format;
    AVPacket *packet; /* reused */
    daft_writer *writer;
    int64_t position, size;  /* of the file, bytes */
    AVRational frame;        /* duration of a frame, seconds */
    const soundtrack *sound; /* or NULL */
    size_t heard;            /* bytes of its packets that are written */
};

/* libavformat goes back to fill in sizes. */
static int put(void *user, uint8_t *bytes, int size)
{
    muxer *self = user;
    int64_t inside = self->size - self->position;
    if (inside > size) inside = size;
    if (inside > 0) daft_writer_put_at(self->writer, (uint64_t)self->position, bytes, (size_t)inside);
    if (inside < size) daft_writer_put(self->writer, bytes + inside, (size_t)(size - inside));
    self->position += size;
    if (self->position > self->size) self->size = self->position;
    return size;
}

static int64_t seek(void *user, int64_t offset, int whence)
{
    muxer *self = user;
    if (whence == AVSEEK_SIZE) return self->size;
    int64_t base = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? self->position : self->size;
    if (base + offset < 0 || base + offset > self->size) return AVERROR(EINVAL);
    return self->position = base + offset;
}

static int open_stream(muxer *self, const AVCodecContext *codec)
{
    AVStream *stream = avformat_new_stream(self->format, NULL);
    if (!stream) return AVERROR(ENOMEM);
    int code = avcodec_parameters_from_context(stream->codecpar, codec);
    stream->time_base = codec->time_base;
    if (codec->codec_type == AVMEDIA_TYPE_VIDEO) stream->avg_frame_rate = stream->r_frame_rate = codec->framerate;
    return code;
}

static int open_format(muxer *self, const video_def *def, const AVCodecContext *codec)
{
    const char *name = def->format == VIDEO_MP4 ? "mp4" : def->format == VIDEO_WEBM ? "webm" : "gif";
    int code = avformat_alloc_output_context2(&self->format, NULL, name, NULL);
    if (code < 0) return code;
    self->format->flags |= AVFMT_FLAG_BITEXACT; /* no date, no version */
    unsigned char *buffer = av_malloc(BUFFER);
    self->packet = av_packet_alloc();
    if (!buffer || !self->packet) {
        av_free(buffer);
        return AVERROR(ENOMEM);
    }
    self->format->pb = avio_alloc_context(buffer, BUFFER, 1, self, NULL, put, seek);
    if (!self->format->pb) {
        av_free(buffer);
        return AVERROR(ENOMEM);
    }
    code = open_stream(self, codec);
    if (code >= 0 && def->sound) code = open_stream(self, def->sound->codec);
    self->sound = def->sound;
    if (code >= 0) code = avformat_write_header(self->format, NULL);
    return code;
}

muxer *ffmpeg_muxer_open(const video_def *def, daft_error *error)
{
    muxer *self = calloc(1, sizeof *self);
    AVCodecContext *codec = NULL;
    if (!self) fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
    if (self) codec = ffmpeg_open_codec(def, error);
    if (codec) self->writer = daft_writer_begin(def->out, error);
    int code = codec && self->writer ? open_format(self, def, codec) : 0;
    bool good = self && self->writer && code >= 0;
    if (code < 0) ffmpeg_fail(error, def->out, code);
    if (self && codec) self->frame = codec->time_base;
    avcodec_free_context(&codec);
    if (good) return self;
    ffmpeg_muxer_abandon(self);
    return NULL;
}

/* `length`: of a packet, in `unit` seconds. */
static int write_packet(muxer *self, int stream, const packet *head, const uint8_t *bytes, int64_t start,
                        int64_t length, AVRational unit)
{
    int code = av_new_packet(self->packet, (int)head->size);
    if (code < 0) return code;
    memcpy(self->packet->data, bytes, head->size);
    self->packet->stream_index = stream;
    self->packet->pts = start + head->shown;
    self->packet->dts = start + head->decoded;
    self->packet->duration = length;
    if (head->key) self->packet->flags |= AV_PKT_FLAG_KEY;
    av_packet_rescale_ts(self->packet, unit, self->format->streams[stream]->time_base);
    return av_interleaved_write_frame(self->format, self->packet);
}

/* The sound that begins before a frame; before one past all others, all of it. */
static int write_sound(muxer *self, int64_t frame)
{
    int code = 0;
    packet head;
    for (size_t at = self->sound ? self->heard : 0; code >= 0 && self->sound;) {
        const AVRational unit = self->sound->codec->time_base;
        const uint8_t *bytes = packets_next(&self->sound->packets, &at, &head);
        if (!bytes || av_compare_ts(head.shown, unit, frame, self->frame) >= 0) break;
        code = write_packet(self, 1, &head, bytes, 0, self->sound->codec->frame_size, unit);
        self->heard = at;
    }
    return code;
}

bool ffmpeg_muxer_add(muxer *self, const packet_list *clip, uint64_t start, daft_error *error)
{
    packet head;
    size_t at = 0;
    for (const uint8_t *bytes; (bytes = packets_next(clip, &at, &head));) {
        int code = write_sound(self, (int64_t)start + head.decoded);
        if (code >= 0) code = write_packet(self, 0, &head, bytes, (int64_t)start, 1, self->frame);
        if (code < 0) return ffmpeg_fail(error, "writing the video", code);
    }
    return true;
}

/* Frees all but the writer. */
static void drop(muxer *self)
{
    av_packet_free(&self->packet);
    if (self->format && self->format->pb) {
        av_freep(&self->format->pb->buffer);
        avio_context_free(&self->format->pb);
    }
    avformat_free_context(self->format);
    self->format = NULL;
}

bool ffmpeg_muxer_commit(muxer *self, daft_error *error)
{
    int code = write_sound(self, INT32_MAX);
    if (code >= 0) code = av_write_trailer(self->format);
    avio_flush(self->format->pb);
    if (code < 0) {
        ffmpeg_muxer_abandon(self);
        return ffmpeg_fail(error, "writing the video", code);
    }
    drop(self);
    bool good = daft_writer_commit(self->writer, error);
    free(self);
    return good;
}

void ffmpeg_muxer_abandon(muxer *self)
{
    if (!self) return;
    drop(self);
    daft_writer_abandon(self->writer);
    free(self);
}
