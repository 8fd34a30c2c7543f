/* Sounds from numbers: what small games need before anybody has recorded anything. */
#ifndef RUNTIME_SOUND_SYNTH_H
#define RUNTIME_SOUND_SYNTH_H

#include "sound/sound.h"

typedef enum synth_wave { SYNTH_SINE, SYNTH_TRIANGLE, SYNTH_SAW, SYNTH_SQUARE, SYNTH_NOISE, SYNTH_WAVES } synth_wave;

enum { SYNTH_NOTES = 1024 };

typedef struct synth_def {
    synth_wave wave;
    double pitch, slide;          /* Hz, 10 to 20,000: at the beginning and at the end of a note */
    double attack, hold, decay;   /* seconds in which a note rises, stays, and falls to nothing */
    double vibrato, vibrato_rate; /* semitones up and down, and how often a second */
    double duty;                  /* part of a square wave that is high, 0.05 to 0.95 */
    double cut;                   /* Hz of a low-pass; 0: none */
    double volume;                /* 0 to 1 */
    const char *notes; /* NULL: one note of `pitch`. "c4 e4 g#4 - c5": by the time of a beat; '-' is a rest */
    double beat;       /* seconds */
} synth_def;

/* A sine of 440 Hz that falls off within 0.3 s. */
synth_def synth_default(void);
/* Mono. NULL: a note that is none, or a sound that is too long, or notes of more than
 * two minutes together. Every field is within its range. */
sound *synth_make(daft_engine *engine, const daft_allocator *memory, const synth_def *def, daft_error *error);

#endif
