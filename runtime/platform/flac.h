/* FLAC files, before SDL_mixer decodes them. */
#ifndef RUNTIME_PLATFORM_FLAC_H
#define RUNTIME_PLATFORM_FLAC_H

#include "common/util.h"

#include <stddef.h>

/* Whether the bytes begin as a FLAC file does. */
bool flac_is(const void *bytes, size_t size);

/* Decodes all of such a file, and gives its length in seconds. Every frame must have the channels that the file says it
 * has: SDL_mixer reads as many of each as the file says, and crashes where there are fewer. Takes some milliseconds for
 * a minute of sound, and ends where the sound is longer than `most` seconds. On failure 0, and the error says at `name`
 * what is wrong. */
double flac_seconds(const void *bytes, size_t size, double most, const char *name, daft_error *error);

#endif
