/* A WAV file of what was heard: 16 bits, left and right, SOUND_RATE frames a second. */
#ifndef RUNTIME_SOUND_TAPE_H
#define RUNTIME_SOUND_TAPE_H

#include "sound/sound.h"

typedef struct tape {
    daft_writer *writer;
    uint64_t bytes; /* of frames */
} tape;

bool tape_begin(tape *out, const char *path, daft_error *error);
void tape_put(tape *self, const int16_t *frames, uint32_t count); /* left and right by turns */
/* Puts the file into place. False: nothing is left behind. */
bool tape_commit(tape *self, daft_error *error);

#endif
