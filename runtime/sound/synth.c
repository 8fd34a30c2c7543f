/* One voice: a wave whose pitch slides, under an envelope; or a row of such notes. Steps of square and saw waves are
 * rounded off over two frames, so that high notes do not ring (PolyBLEP: Välimäki and Huovilainen 2007). */
#include "sound/synth.h"

#include "common/util.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

synth_def synth_default(void)
{
    return (synth_def){.wave = SYNTH_SINE,
                       .pitch = 440,
                       .slide = 440,
                       .attack = 0.005,
                       .decay = 0.3,
                       .vibrato_rate = 6,
                       .duty = 0.5,
                       .volume = 0.6,
                       .beat = 0.25};
}

enum { MOST_SECONDS = 120 }; /* of all notes: what takes a fraction of a second to make */

/* ---- notes ---- */

/* Hz of "c4", "f#3" or "bb5", equal temperament with a4 = 440; 0: none of these. */
static double read_note(const char *text, size_t length)
{
    static const int SEMITONES[7] = {9, 11, 0, 2, 4, 5, 7}; /* a to g */
    const int letter = tolower((unsigned char)text[0]);
    size_t at = 1;
    if (letter < 'a' || letter > 'g') return 0;
    int semitone = SEMITONES[letter - 'a'];
    if (at < length && (text[at] == '#' || text[at] == 'b')) semitone += text[at++] == '#' ? 1 : -1;
    if (at + 1 != length || text[at] < '0' || text[at] > '8') return 0;
    return 440 * daft_exp2((semitone - 9 + 12 * (text[at] - '4')) / 12.0);
}

/* The next word, or false. */
static bool next_word(const char **at, const char **word, size_t *length)
{
    *word = *at + strspn(*at, " \t\n");
    *length = strcspn(*word, " \t\n");
    *at = *word + *length;
    return *length > 0;
}

/* Hz of each, 0 for rests. Gives their number; 0: *error says why. */
static int read_notes(const char *text, double out[SYNTH_NOTES], daft_error *error)
{
    const char *at = text, *word;
    size_t length;
    int count = 0;
    while (next_word(&at, &word, &length)) {
        const bool rest = length == 1 && word[0] == '-';
        const double hz = rest ? 0 : read_note(word, length);
        if (!rest && hz == 0) {
            fail(error, DAFT_ERROR_ARGUMENT, "notes: '%.*s' is no note: c4, f#3, bb5 and - for a rest are",
                 (int)(length < 16 ? length : 16), word);
            return 0;
        }
        if (count == SYNTH_NOTES) {
            fail(error, DAFT_ERROR_ARGUMENT, "notes: more than %d", SYNTH_NOTES);
            return 0;
        }
        out[count++] = hz;
    }
    if (!count) fail(error, DAFT_ERROR_ARGUMENT, "notes: there is none");
    return count;
}

/* ---- waves ---- */

typedef struct oscillator {
    double phase; /* 0 to 1 */
    double held;  /* of noise */
    uint32_t random;
} oscillator;

/* What rounds off a step at phase 0, of a wave that moves by `step` a frame. */
static double round_off(double phase, double step)
{
    if (phase < step) return phase /= step, 2 * phase - phase * phase - 1;
    if (phase > 1 - step) return phase = (phase - 1) / step, phase * phase + 2 * phase + 1;
    return 0;
}

static double noise(oscillator *o)
{
    o->random ^= o->random << 13, o->random ^= o->random >> 17, o->random ^= o->random << 5; /* Marsaglia 2003 */
    return (double)o->random / 2147483648.0 - 1;
}

static double wave_at(oscillator *o, const synth_def *def, double step)
{
    const double p = o->phase;
    switch (def->wave) {
    case SYNTH_TRIANGLE: return p < 0.5 ? 4 * p - 1 : 3 - 4 * p;
    case SYNTH_SAW: return 2 * p - 1 - round_off(p, step);
    case SYNTH_SQUARE: {
        const double down = p + 1 - def->duty;
        return (p < def->duty ? 1 : -1) + round_off(p, step) - round_off(down < 1 ? down : down - 1, step);
    }
    case SYNTH_NOISE: return o->held;
    default: return daft_sin(2 * PI * p);
    }
}

/* The next frame of a wave. Noise takes another value sixteen times a period. */
static double swing(oscillator *o, const synth_def *def, double hz)
{
    const double step = fmin(hz, 20000) / SOUND_RATE * (def->wave == SYNTH_NOISE ? 16 : 1), now = wave_at(o, def, step);
    o->phase += step;
    if (o->phase >= 1) o->phase -= floor(o->phase), o->held = noise(o);
    return now;
}

/* Falls as a square, fast at first as struck things do. */
static double envelope(const synth_def *def, double t)
{
    if (t < def->attack) return t / def->attack;
    t -= def->attack;
    if (t < def->hold) return 1;
    const double left = 1 - (t - def->hold) / def->decay;
    return left > 0 ? left * left : 0;
}

/* ---- the sound ---- */

static double length_of(const synth_def *def) { return def->attack + def->hold + def->decay; }

/* Adds a note that begins at `first`; what goes past the end of a tune sounds at its beginning, so that it can loop. */
static void add_note(float *sum, uint32_t frames, uint32_t first, const synth_def *def, double hz)
{
    oscillator o = {.random = 0x9e3779b9, .held = 0};
    const double length = length_of(def), ratio = hz / def->pitch;
    const uint32_t count = (uint32_t)fmin(length * SOUND_RATE, (double)frames);
    for (uint32_t i = 0; i < count; i++) {
        const double t = (double)i / SOUND_RATE;
        double now = (def->pitch + (def->slide - def->pitch) * t / length) * ratio;
        if (def->vibrato > 0) now *= daft_exp2(def->vibrato / 12 * daft_sin(2 * PI * def->vibrato_rate * t));
        sum[(first + i) % frames] += (float)(swing(&o, def, now) * envelope(def, t));
    }
}

static void low_pass(float *samples, uint32_t frames, double hz)
{
    const float open = (float)(1 - daft_exp2(-2 * PI * fmin(hz, 20000) / SOUND_RATE * 1.44269504088896341));
    float low = 0;
    for (uint32_t i = 0; i < frames; i++) samples[i] = low += (samples[i] - low) * open;
}

static void fill(sound *s, const float *from, double volume)
{
    for (uint32_t i = 0; i < s->frames; i++) {
        const double x = (double)from[i] * volume;
        s->samples[i] = (int16_t)lrint(32767 * fmax(-1, fmin(1, x)));
    }
}

sound *synth_make(daft_engine *engine, const daft_allocator *memory, const synth_def *def, daft_error *error)
{
    double notes[SYNTH_NOTES] = {def->pitch};
    const int count = def->notes ? read_notes(def->notes, notes, error) : 1;
    const double beat = floor(def->beat * SOUND_RATE), seconds = length_of(def);
    if (!count) return NULL;
    if (seconds * count > MOST_SECONDS) {
        fail(error, DAFT_ERROR_ARGUMENT, "%d notes of %g s are too much: %d s together", count, seconds, MOST_SECONDS);
        return NULL;
    }
    sound *s = sound_create(engine, memory, 1, (uint64_t)(def->notes ? beat * count : seconds * SOUND_RATE), error);
    float *sum = s ? calloc(s->frames, sizeof *sum) : NULL;
    if (s && !sum) {
        sound_release(s), s = NULL;
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a sound");
    }
    for (int i = 0; s && i < count; i++)
        if (notes[i] > 0) add_note(sum, s->frames, (uint32_t)(beat * i), def, notes[i]);
    if (s && def->cut > 0) low_pass(sum, s->frames, def->cut);
    if (s) fill(s, sum, def->volume);
    free(sum);
    return s;
}
