/* A program that was built without SDL2_mixer: games run in silence. */
#include "platform/audio.h"

#include "common/util.h"

static bool missing(daft_error *error)
{
    return fail(error, DAFT_ERROR_UNSUPPORTED,
                "this program was built without SDL2_mixer: install libsdl2-mixer-dev and build again");
}

bool audio_open(daft_error *error) { return missing(error); }

void audio_play(const int16_t *frames, uint32_t count) { (void)frames, (void)count; }

void audio_volume(double volume) { (void)volume; }

void audio_close(void) {}

bool audio_load_decoders(void) { return false; }

sound *audio_decode(daft_engine *engine, const void *bytes, size_t size, const char *name, daft_error *error)
{
    (void)engine, (void)bytes, (void)size, (void)name;
    missing(error);
    return NULL;
}
