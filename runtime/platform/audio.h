/* audio: the loudspeaker, and sound files, both through SDL2_mixer (audio.c), or neither (audio_missing.c). */
#ifndef RUNTIME_PLATFORM_AUDIO_H
#define RUNTIME_PLATFORM_AUDIO_H

#include "sound/sound.h"

/* Before the process is sealed. Without a loudspeaker nothing sounds and all else works; false says why. */
bool audio_open(daft_error *error);
/* Frames to play next, left and right by turns. Where more than a tenth of a second waits, they are dropped. */
void audio_play(const int16_t *frames, uint32_t count);
/* 0 silent, 1 as it is. */
void audio_volume(double volume);
/* Lets go of the loudspeaker, and of what decoding needed. Fine where nothing was opened. */
void audio_close(void);

/* Loads what decoding needs, for who looks at which libraries that is. False: this program has no sound. */
bool audio_load_decoders(void);
/* WAV, OGG (Vorbis), FLAC and MP3, told apart by content; `name` is for messages. Works without a loudspeaker. */
sound *audio_decode(daft_engine *engine, const void *bytes, size_t size, const char *name, daft_error *error);

#endif
