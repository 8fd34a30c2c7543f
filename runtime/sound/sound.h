/* sound: what a game's sounds are and how they are mixed: samples that were decoded or made by the synthesiser, voices
 * that play them, and a tape of what was heard. Public headers: sound.h synth.h cache.h tape.h
 * Time is the game's: each tick is SOUND_TICK frames, so the same ticks give the same sound, at any speed, with and
 * without a loudspeaker. Promises: the same voices give the same bytes on every machine; nothing that a game can ask
 * for depends on whether anybody listens. */
#ifndef RUNTIME_SOUND_SOUND_H
#define RUNTIME_SOUND_SOUND_H

#include "daft.h"

enum {
    SOUND_RATE = 48000,           /* frames a second */
    SOUND_TICK = SOUND_RATE / 60, /* frames of a tick */
    SOUND_SECONDS = 600,          /* the longest sound */
    SOUND_VOICES = 64,            /* that play at once; where one more begins, the one that is nearest its end goes */
    SOUND_GROUPS = 16,            /* of voices with a volume in common */
    SOUND_NAME = 32               /* bytes of a group's name, with the zero */
};

/* ---- samples ---- */

/* What a sound is made of: a hash of its bytes, and their number. */
typedef struct sound_key {
    uint64_t hash, size;
} sound_key;

/* Frames at SOUND_RATE, of one channel or left and right by turns. Counts towards the engine's memory limit. */
typedef struct sound {
    daft_engine *engine;
    daft_allocator memory; /* that it is from; all zero: malloc */
    uint32_t holders;
    sound_key key; /* in a cache (cache.h); link NULL: it is in none */
    struct sound *next, **link;
    int channels;
    uint32_t frames;
    int16_t samples[];
} sound;

/* Silent, held once. `memory` NULL: malloc. NULL: it has no frame or too many, or the engine's memory limit is reached.
 */
sound *sound_create(daft_engine *engine, const daft_allocator *memory, int channels, uint64_t frames,
                    daft_error *error);
sound *sound_hold(sound *self);
void sound_release(sound *self); /* NULL is fine */

/* ---- voices ---- */

typedef struct voice {
    uint32_t id; /* of this play; 0: none plays here */
    sound *what;
    bool loops;
    float volume, pan; /* pan: -1 left, 1 right */
    double pitch;      /* how many times as fast, 1/16 to 16 */
    int group;
    bool placed;         /* somewhere in the world, */
    daft_entity carrier; /* where this is, or, where it is none or gone, at */
    daft_dvec3 place;
    float near, far;          /* metres: as loud as it is up to the one, and silent from the other on */
    float fade, fade_step;    /* a factor of the volume, 0 to 1, and by how much it changes in a tick */
    float gain, side, muffle; /* what distance, direction and walls do: 1, -1 to 1, 0 to 1: the ear sets them */
    /* inner: */
    uint64_t at; /* the frame that is next, in 2^-32 */
    bool heard;  /* before: `was` is known */
    struct {
        float left, right, open;
    } was;
    float low[2]; /* state of the low-pass */
} voice;

typedef struct mixer {
    voice voices[SOUND_VOICES];
    uint32_t last_id;
    char group_names[SOUND_GROUPS][SOUND_NAME]; /* the first is "all", whose volume is that of everything */
    float group_volumes[SOUND_GROUPS];
    int group_count;
} mixer;

void mixer_init(mixer *self);
void mixer_free(mixer *self); /* lets all sounds go */
/* A voice with defaults, which holds the sound. Never NULL. */
voice *mixer_play(mixer *self, sound *what);
/* NULL: it has ended. */
voice *mixer_find(mixer *self, uint32_t id);
/* Ends within `seconds`, silent at the end. At once is one tick, without a click. */
void voice_stop(voice *v, double seconds);
/* The number of a group, made where it is new; -1: there are SOUND_GROUPS, or the name is too long. */
int mixer_group(mixer *self, const char *name);
uint32_t mixer_count(const mixer *self); /* voices that play */
/* Plays on for a tick. `out`: SOUND_TICK frames, left and right by turns, or NULL where nobody listens. */
void mixer_tick(mixer *self, int16_t *out);

#endif
