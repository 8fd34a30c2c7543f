/* cache: the sounds of a game that are in memory, by what they are made of: whoever asks for one of them again gets the
 * same one. Of a game that is opened while the old one runs, after a file was saved, most sounds are there. A cache
 * holds no sound: each leaves it with its last holder. */
#ifndef RUNTIME_SOUND_CACHE_H
#define RUNTIME_SOUND_CACHE_H

#include "sound/synth.h"

typedef struct sound_cache sound_cache;

/* Held once. `memory`: that of the sounds; NULL: malloc. NULL: memory is out. */
sound_cache *sound_cache_open(const daft_allocator *memory);
sound_cache *sound_cache_hold(sound_cache *self);
/* After the last sound is gone, or while somebody else holds it. NULL is fine. */
void sound_cache_release(sound_cache *self);

/* By the bytes of a sound file, and by what a sound is synthesised from. */
sound_key sound_key_of_file(const void *bytes, size_t size);
sound_key sound_key_of_synth(const synth_def *def);

/* Held once more; NULL: it is not there. `self` may be NULL in both. */
sound *sound_cache_find(const sound_cache *self, sound_key key);
/* It is not in a cache yet. */
void sound_cache_add(sound_cache *self, sound_key key, sound *what);

#endif
