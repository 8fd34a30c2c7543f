/* Voices become frames. */
#include "sound/sound.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- samples ---- */

static size_t bytes_of(int channels, uint64_t frames)
{
    return sizeof(sound) + sizeof(int16_t) * (size_t)channels * (size_t)frames;
}

sound *sound_create(daft_engine *engine, const daft_allocator *memory, int channels, uint64_t frames, daft_error *error)
{
    if (frames < 1 || frames > (uint64_t)SOUND_SECONDS * SOUND_RATE) {
        fail(error, DAFT_ERROR_UNSUPPORTED, frames ? "the sound is longer than %d minutes" : "the sound is empty",
             SOUND_SECONDS / 60);
        return NULL;
    }
    const size_t bytes = bytes_of(channels, frames);
    const bool fits = daft_engine_reserve(engine, bytes);
    sound *s = fits ? memory_take(memory, bytes) : NULL;
    if (s) {
        memset(s, 0, bytes);
        if (memory) s->memory = *memory;
        s->engine = engine, s->holders = 1, s->channels = channels, s->frames = (uint32_t)frames;
        return s;
    }
    if (fits) daft_engine_unreserve(engine, bytes);
    fail(error, DAFT_ERROR_MEMORY, "out of memory for a sound of %.1f s", (double)frames / SOUND_RATE);
    return NULL;
}

sound *sound_hold(sound *self)
{
    self->holders++;
    return self;
}

void sound_release(sound *self)
{
    if (!self || --self->holders) return;
    if (self->link) *self->link = self->next;
    if (self->link && self->next) self->next->link = self->link;
    daft_engine_unreserve(self->engine, bytes_of(self->channels, self->frames));
    const daft_allocator memory = self->memory;
    memory_release(&memory, self);
}

/* ---- voices ---- */

void mixer_init(mixer *self)
{
    *self = (mixer){0};
    mixer_group(self, "all");
}

static void end(voice *v)
{
    sound_release(v->what);
    *v = (voice){0};
}

void mixer_free(mixer *self)
{
    for (int i = 0; i < SOUND_VOICES; i++)
        if (self->voices[i].id) end(&self->voices[i]);
}

static uint64_t frames_left(const voice *v) { return v->what->frames - (v->at >> 32); }

/* A free one; else the one with the least left to play, of those that loop only where all do. */
static voice *choose(mixer *self)
{
    voice *best = NULL;
    for (int i = 0; i < SOUND_VOICES; i++) {
        voice *v = &self->voices[i];
        if (!v->id) return v;
        if (!best || v->loops < best->loops || (v->loops == best->loops && frames_left(v) < frames_left(best)))
            best = v;
    }
    end(best);
    return best;
}

voice *mixer_play(mixer *self, sound *what)
{
    voice *v = choose(self);
    *v = (voice){.id = ++self->last_id,
                 .what = sound_hold(what),
                 .volume = 1,
                 .pitch = 1,
                 .near = 3,
                 .far = 100,
                 .fade = 1,
                 .gain = 1};
    return v;
}

voice *mixer_find(mixer *self, uint32_t id)
{
    for (int i = 0; id && i < SOUND_VOICES; i++)
        if (self->voices[i].id == id) return &self->voices[i];
    return NULL;
}

void voice_stop(voice *v, double seconds)
{
    const double ticks = seconds * 60;
    v->fade_step = ticks > 1 ? (float)(-1 / ticks) : -1;
}

int mixer_group(mixer *self, const char *name)
{
    for (int i = 0; i < self->group_count; i++)
        if (strcmp(self->group_names[i], name) == 0) return i;
    if (self->group_count == SOUND_GROUPS || strlen(name) >= SOUND_NAME) return -1;
    strcpy(self->group_names[self->group_count], name);
    self->group_volumes[self->group_count] = 1;
    return self->group_count++;
}

uint32_t mixer_count(const mixer *self)
{
    uint32_t count = 0;
    for (int i = 0; i < SOUND_VOICES; i++) count += self->voices[i].id != 0;
    return count;
}

/* ---- mixing ---- */

typedef struct frame {
    float side[2];
} frame;

static frame frame_at(const sound *s, uint64_t index)
{
    const int16_t *at = &s->samples[index * (uint64_t)s->channels];
    return (frame){{(float)at[0], (float)at[s->channels - 1]}};
}

static uint64_t step_of(const voice *v) { return (uint64_t)(v->pitch * 0x1p32); }

/* Past the end a loop begins again; anything else is over. */
static bool advance(voice *v, uint64_t by)
{
    const uint64_t length = (uint64_t)v->what->frames << 32;
    v->at += by;
    if (v->at < length) return true;
    if (!v->loops) return false;
    v->at %= length;
    return true;
}

/* Between two frames on a straight line; at the end the first one follows, or silence. */
static frame sample_at(const voice *v)
{
    const uint64_t index = v->at >> 32;
    const float part = (float)(v->at & 0xffffffff) * 0x1p-32f;
    const frame a = frame_at(v->what, index);
    frame b = {{0, 0}};
    if (index + 1 < v->what->frames)
        b = frame_at(v->what, index + 1);
    else if (v->loops)
        b = frame_at(v->what, 0);
    return (frame){{a.side[0] + (b.side[0] - a.side[0]) * part, a.side[1] + (b.side[1] - a.side[1]) * part}};
}

/* A one-pole low-pass lets through what is open of each step: 1 all, 0.11 what is below about 900 Hz. */
static float open_of(const voice *v) { return 1 - 0.89f * v->muffle; }

/* Where left and right are as loud as each other, both have factor 1; the power of both is the same everywhere. */
static void place_of(const mixer *self, const voice *v, float *left, float *right)
{
    const float pan = fmaxf(-1, fminf(1, v->pan + v->side));
    const float muffled = 1 - 0.5f * v->muffle;
    const float loud = v->volume * v->fade * v->gain * muffled * self->group_volumes[v->group] *
                       (v->group ? self->group_volumes[0] : 1);
    *left = loud * sqrtf(1 - pan), *right = loud * sqrtf(1 + pan);
}

/* Loudness, direction and the low-pass go straight from what they were to what they are: no clicks. */
static bool mix_voice(const mixer *self, voice *v, float sum[2 * SOUND_TICK])
{
    float left, right, open = open_of(v);
    place_of(self, v, &left, &right);
    if (!v->heard) {
        v->was.left = v->fade_step > 0 ? 0 : left, v->was.right = v->fade_step > 0 ? 0 : right;
        v->was.open = open, v->heard = true;
    }
    const uint64_t step = step_of(v);
    bool goes_on = true;
    for (int i = 0; i < SOUND_TICK && goes_on; i++) {
        const float part = (float)(i + 1) / SOUND_TICK;
        const float through = v->was.open + (open - v->was.open) * part;
        const frame f = sample_at(v);
        for (int k = 0; k < 2; k++) v->low[k] += (f.side[k] - v->low[k]) * through;
        sum[2 * i] += v->low[0] * (v->was.left + (left - v->was.left) * part);
        sum[2 * i + 1] += v->low[1] * (v->was.right + (right - v->was.right) * part);
        goes_on = advance(v, step);
    }
    v->was.left = left, v->was.right = right, v->was.open = open;
    return goes_on;
}

/* As it is up to three quarters of what fits; what is louder is bent towards all of it. */
static int16_t bend(float x)
{
    const float knee = 24576, rest = 32767 - knee;
    float size = fabsf(x);
    if (size > knee) size = knee + rest * (size - knee) / (size - knee + rest);
    return (int16_t)lrintf(copysignf(size, x));
}

static void step_fade(voice *v)
{
    if (v->fade_step == 0) return;
    v->fade += v->fade_step;
    if (v->fade >= 1) v->fade = 1, v->fade_step = 0;
    if (v->fade < 0) v->fade = 0;
}

void mixer_tick(mixer *self, int16_t *out)
{
    float sum[2 * SOUND_TICK];
    if (out) memset(sum, 0, sizeof sum);
    for (int i = 0; i < SOUND_VOICES; i++) {
        voice *v = &self->voices[i];
        if (!v->id) continue;
        step_fade(v);
        const bool goes_on = out ? mix_voice(self, v, sum) : advance(v, SOUND_TICK * step_of(v));
        if (!goes_on || (v->fade == 0 && v->fade_step < 0)) end(v);
    }
    for (int i = 0; out && i < 2 * SOUND_TICK; i++) out[i] = bend(sum[i]);
}
