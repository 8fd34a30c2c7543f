/* The encoder of a program that was built without FFmpeg's libraries. */
#include "video/encode/encoder.h"

#include "common/util.h"
#include "video/soundtrack.h"

static bool missing(daft_error *error)
{
    return fail(error, DAFT_ERROR_UNSUPPORTED,
                "this program was built without FFmpeg: install libavcodec-dev, libavformat-dev, libavfilter-dev and "
                "libswscale-dev and build again, or choose numbered .png");
}

encoder *encoder_open(const video_def *def, daft_error *error)
{
    (void)def;
    missing(error);
    return NULL;
}

bool encoder_add(encoder *self, const uint8_t *pixels, packet_list *out, daft_error *error)
{
    (void)self, (void)pixels, (void)out;
    return missing(error);
}

bool encoder_finish(encoder *self, packet_list *out, daft_error *error)
{
    (void)self, (void)out;
    return missing(error);
}

void encoder_close(encoder *self) { (void)self; }

muxer *muxer_open(const video_def *def, daft_error *error)
{
    (void)def;
    missing(error);
    return NULL;
}

bool muxer_add(muxer *self, const packet_list *clip, uint64_t start, daft_error *error)
{
    (void)self, (void)clip, (void)start;
    return missing(error);
}

bool muxer_commit(muxer *self, daft_error *error)
{
    (void)self;
    return missing(error);
}

void muxer_abandon(muxer *self) { (void)self; }

soundtrack *soundtrack_open(video_format format, daft_error *error)
{
    (void)format;
    missing(error);
    return NULL;
}

bool soundtrack_add(soundtrack *self, const int16_t *frames, uint32_t count, daft_error *error)
{
    (void)self, (void)frames, (void)count;
    return missing(error);
}

bool soundtrack_finish(soundtrack *self, daft_error *error)
{
    (void)self;
    return missing(error);
}

void soundtrack_close(soundtrack *self) { (void)self; }
