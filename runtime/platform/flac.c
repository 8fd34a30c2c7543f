/* By libFLAC itself, which SDL_mixer decodes with: both see the same frames, also in files that are broken. */
#include "platform/flac.h"

#include <string.h>

bool flac_is(const void *bytes, size_t size) { return size >= 4 && memcmp(bytes, "fLaC", 4) == 0; }

#ifdef DAFT_HAS_FLAC

#include <FLAC/stream_decoder.h>

typedef struct file {
    const uint8_t *bytes;
    size_t size, at;
    uint32_t channels;    /* that it says it has */
    double seconds, most; /* of its frames so far, and of all at most */
    bool fewer;           /* a frame has fewer channels */
} file;

static FLAC__StreamDecoderReadStatus give(const FLAC__StreamDecoder *unused, FLAC__byte to[], size_t *count, void *user)
{
    file *f = user;
    (void)unused;
    if (*count > f->size - f->at) *count = f->size - f->at;
    memcpy(to, f->bytes + f->at, *count);
    f->at += *count;
    return *count ? FLAC__STREAM_DECODER_READ_STATUS_CONTINUE : FLAC__STREAM_DECODER_READ_STATUS_END_OF_STREAM;
}

static FLAC__StreamDecoderWriteStatus take(const FLAC__StreamDecoder *unused, const FLAC__Frame *frame,
                                           const FLAC__int32 *const samples[], void *user)
{
    file *f = user;
    const FLAC__FrameHeader *h = &frame->header;
    (void)unused, (void)samples;
    f->fewer = h->channels < f->channels;
    f->seconds += h->sample_rate ? (double)h->blocksize / h->sample_rate : 0;
    return f->fewer || f->seconds > f->most ? FLAC__STREAM_DECODER_WRITE_STATUS_ABORT
                                            : FLAC__STREAM_DECODER_WRITE_STATUS_CONTINUE;
}

static void tell(const FLAC__StreamDecoder *unused, const FLAC__StreamMetadata *metadata, void *user)
{
    file *f = user;
    (void)unused;
    if (metadata->type == FLAC__METADATA_TYPE_STREAMINFO && metadata->data.stream_info.channels > f->channels)
        f->channels = metadata->data.stream_info.channels;
}

/* What is broken is passed over, as SDL_mixer does. */
static void pass(const FLAC__StreamDecoder *unused, FLAC__StreamDecoderErrorStatus status, void *user)
{
    (void)unused, (void)status, (void)user;
}

double flac_seconds(const void *bytes, size_t size, double most, const char *name, daft_error *error)
{
    file f = {.bytes = bytes, .size = size, .most = most};
    FLAC__StreamDecoder *decoder = FLAC__stream_decoder_new();
    if (!decoder) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a sound");
    const FLAC__StreamDecoderInitStatus status =
        FLAC__stream_decoder_init_stream(decoder, give, NULL, NULL, NULL, NULL, take, tell, pass, &f);
    if (status == FLAC__STREAM_DECODER_INIT_STATUS_OK) FLAC__stream_decoder_process_until_end_of_stream(decoder);
    FLAC__stream_decoder_delete(decoder);
    if (f.fewer || f.channels == 0 || f.seconds == 0) return fail_at(error, name, 0, 0, "the sound is broken");
    if (f.seconds > most) return fail_at(error, name, 0, 0, "the sound is longer than %g minutes", most / 60);
    return f.seconds;
}

#else

double flac_seconds(const void *bytes, size_t size, double most, const char *name, daft_error *error)
{
    (void)bytes, (void)size, (void)most;
    return fail_at(error, name, 0, 0, "this program was built without libFLAC, and reads no FLAC files");
}

#endif
