/* Encoder, muxer and soundtrack by daft_film.so, which is loaded when the first of them is opened. */
#include "video/encode/encoder.h"

#include "files/module.h"
#include "video/encode/module.h"
#include "video/soundtrack.h"

#include <stdatomic.h>
#include <stddef.h>

/* The same for all threads, and for as long as the program runs; NULL before the first open. */
static const film_module *_Atomic loaded;

static const film_module *load(daft_error *error)
{
    static const module_def DEF = {.name = "daft_film",
                                   .purpose = "a film",
                                   .library = "FFmpeg",
                                   .build = "libavcodec-dev, libavformat-dev, libavfilter-dev and libswscale-dev",
                                   .run = "FFmpeg's libraries (Debian: ffmpeg)",
                                   .instead = ", or choose numbered .png"};
    const film_module *film = module_open(&DEF, error);
    if (film) atomic_store(&loaded, film);
    return film;
}

encoder *encoder_open(const video_def *def, daft_error *error)
{
    const film_module *film = load(error);
    return film ? film->encoder_open(def, error) : NULL;
}

bool encoder_add(encoder *self, const uint8_t *pixels, packet_list *out, daft_error *error)
{
    return atomic_load(&loaded)->encoder_add(self, pixels, out, error);
}

bool encoder_finish(encoder *self, packet_list *out, daft_error *error)
{
    return atomic_load(&loaded)->encoder_finish(self, out, error);
}

void encoder_close(encoder *self)
{
    if (self) atomic_load(&loaded)->encoder_close(self);
}

muxer *muxer_open(const video_def *def, daft_error *error)
{
    const film_module *film = load(error);
    return film ? film->muxer_open(def, error) : NULL;
}

bool muxer_add(muxer *self, const packet_list *clip, uint64_t start, daft_error *error)
{
    return atomic_load(&loaded)->muxer_add(self, clip, start, error);
}

bool muxer_commit(muxer *self, daft_error *error) { return atomic_load(&loaded)->muxer_commit(self, error); }

void muxer_abandon(muxer *self)
{
    if (self) atomic_load(&loaded)->muxer_abandon(self);
}

soundtrack *soundtrack_open(video_format format, daft_error *error)
{
    const film_module *film = load(error);
    return film ? film->soundtrack_open(format, error) : NULL;
}

bool soundtrack_add(soundtrack *self, const int16_t *frames, uint32_t count, daft_error *error)
{
    return atomic_load(&loaded)->soundtrack_add(self, frames, count, error);
}

bool soundtrack_finish(soundtrack *self, daft_error *error)
{
    return atomic_load(&loaded)->soundtrack_finish(self, error);
}

void soundtrack_close(soundtrack *self)
{
    if (self) atomic_load(&loaded)->soundtrack_close(self);
}
