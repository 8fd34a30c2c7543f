/* sound, game/ear, platform/audio: the mixer against a slow twin in double, what the synthesiser makes against closed
 * forms, what the camera hears, and sound files, whole and broken. */
#include "game/ear.h"
#include "platform/audio.h"
#include "sound/cache.h"
#include "sound/tape.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>
#include <time.h>

static daft_engine *engine;
static daft_error error;
static uint64_t used; /* bytes, before the first test */

static int open_engine(void **unused)
{
    (void)unused;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    engine = daft_engine_create(&def, &error);
    used = engine ? daft_engine_memory(engine).used : 0;
    return engine ? 0 : -1;
}

static int close_engine(void **unused)
{
    (void)unused;
    audio_close();
    assert_int_equal(daft_engine_memory(engine).used, used); /* every sound was let go */
    daft_engine_destroy(engine);
    return 0;
}

static uint64_t state = 1;

static double chance(void)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

static sound *random_sound(uint32_t frames, int channels, double size)
{
    sound *s = sound_create(engine, NULL, channels, frames, &error);
    assert_non_null(s);
    for (uint32_t i = 0; i < frames * (uint32_t)channels; i++)
        s->samples[i] = (int16_t)lrint((2 * chance() - 1) * size);
    return s;
}

/* ---- the mixer ---- */

static void a_voice_alone_is_its_sound(void **unused)
{
    (void)unused;
    mixer m;
    int16_t out[2 * SOUND_TICK];
    sound *s = random_sound(3 * SOUND_TICK + 100, 1, 20000);
    mixer_init(&m);
    mixer_play(&m, s);
    for (uint32_t tick = 0; tick < 4; tick++) {
        mixer_tick(&m, out);
        for (uint32_t i = 0; i < SOUND_TICK; i++) {
            const uint32_t at = tick * SOUND_TICK + i;
            const int16_t wanted = at < s->frames ? s->samples[at] : 0;
            assert_int_equal(out[2 * i], wanted);
            assert_int_equal(out[2 * i + 1], wanted);
        }
        assert_int_equal(mixer_count(&m), tick < 3);
    }
    sound_release(s);
    mixer_free(&m);
}

enum { TICKS = 12 };

/* All frames of one voice that never changes, from the definitions. */
static void twin(const voice *v, double group, double sum[2 * SOUND_TICK * TICKS])
{
    double low[2] = {0, 0};
    const double pan = fmax(-1, fmin(1, (double)v->pan + (double)v->side)), open = 1 - 0.89 * (double)v->muffle;
    const double loud = (double)v->volume * group * (double)v->gain * (1 - 0.5 * (double)v->muffle);
    const double side[2] = {loud * sqrt(1 - pan), loud * sqrt(1 + pan)};
    for (int i = 0; i < SOUND_TICK * TICKS; i++) {
        double at = i * v->pitch;
        if (v->loops) at = fmod(at, v->what->frames);
        const uint32_t first = (uint32_t)at, channels = (uint32_t)v->what->channels;
        if (first >= v->what->frames) return;
        uint32_t next = first + 1;
        if (next == v->what->frames && v->loops) next = 0;
        for (uint32_t k = 0; k < 2; k++) {
            const uint32_t channel = k % channels;
            const double a = v->what->samples[first * channels + channel];
            const double b = next < v->what->frames ? v->what->samples[next * channels + channel] : 0;
            low[k] += (a + (b - a) * (at - first) - low[k]) * open;
            sum[2 * i + (int)k] += low[k] * side[k];
        }
    }
}

static void voices_add_up_as_in_double(void **unused)
{
    (void)unused;
    const uint64_t seed = (uint64_t)time(NULL);
    state = seed * 2 + 1;
    static double sum[2 * SOUND_TICK * TICKS];
    int16_t out[2 * SOUND_TICK];
    for (int round = 0; round < 20; round++) {
        mixer m;
        mixer_init(&m);
        memset(sum, 0, sizeof sum);
        for (int i = 0; i < 8; i++) {
            sound *s = random_sound(100 + (uint32_t)(chance() * 9000), 1 + (chance() < 0.5), 2000);
            voice *v = mixer_play(&m, s);
            sound_release(s);                                   /* the voice holds it */
            v->pitch = (double)(1 + (int)(chance() * 40)) / 16; /* sixteenths add up without rounding in both */
            v->pan = (float)(2 * chance() - 1), v->side = (float)(chance() - 0.5), v->muffle = (float)chance();
            v->volume = (float)chance(), v->gain = (float)chance(), v->loops = chance() < 0.5;
            v->group = mixer_group(&m, chance() < 0.5 ? "a" : "b");
            m.group_volumes[v->group] = 0.5f, m.group_volumes[0] = 0.75f;
            twin(v, 0.5 * 0.75, sum);
        }
        for (int tick = 0; tick < TICKS; tick++) {
            mixer_tick(&m, out);
            for (int i = 0; i < 2 * SOUND_TICK; i++)
                if (fabs(out[i] - sum[2 * SOUND_TICK * tick + i]) > 1)
                    fail_msg("seed %llu, round %d, tick %d, sample %d: %d, not %.2f", (unsigned long long)seed, round,
                             tick, i, out[i], sum[2 * SOUND_TICK * tick + i]);
        }
        mixer_free(&m);
    }
}

/* What a game can ask for does not depend on whether anybody listens. */
static void voices_end_alike_when_nobody_listens(void **unused)
{
    (void)unused;
    const uint64_t seed = (uint64_t)time(NULL);
    state = seed * 2 + 1;
    mixer heard, unheard;
    int16_t out[2 * SOUND_TICK];
    mixer_init(&heard), mixer_init(&unheard);
    for (int tick = 0; tick < 2000; tick++) {
        if (chance() < 0.5) {
            sound *s = random_sound(1 + (uint32_t)(chance() * 20000), 1, 1000);
            const double pitch = 1.0 / 16 + chance() * 15, stop = chance();
            const bool loops = chance() < 0.1;
            mixer *both[2] = {&heard, &unheard};
            for (int i = 0; i < 2; i++) {
                voice *v = mixer_play(both[i], s);
                v->pitch = pitch, v->loops = loops;
                if (stop < 0.3) voice_stop(v, stop);
            }
            sound_release(s);
        }
        mixer_tick(&heard, out), mixer_tick(&unheard, NULL);
        for (uint32_t id = 1; id <= heard.last_id; id++)
            if (!mixer_find(&heard, id) != !mixer_find(&unheard, id))
                fail_msg("seed %llu, tick %d: voice %u", (unsigned long long)seed, tick, id);
    }
    mixer_free(&heard), mixer_free(&unheard);
}

/* Nothing that a voice is told makes a step of more than its own wave and the change of a tick allow. */
static void changes_do_not_click(void **unused)
{
    (void)unused;
    mixer m;
    int16_t out[2 * SOUND_TICK], before = 0;
    sound *s = sound_create(engine, NULL, 1, 100 * SOUND_TICK, &error);
    assert_non_null(s);
    for (uint32_t i = 0; i < s->frames; i++) s->samples[i] = 10000; /* a constant: each step is a change of loudness */
    mixer_init(&m);
    voice *v = mixer_play(&m, s);
    v->fade = 0, v->fade_step = 0.25f;
    for (int tick = 0; tick < 40; tick++) {
        if (tick == 10) v->volume = 0.2f;
        if (tick == 15) v->pan = 1;
        if (tick == 20) v->gain = 0.3f, v->muffle = 1;
        if (tick == 30) voice_stop(v, 0.1);
        mixer_tick(&m, out);
        for (int i = 0; i < SOUND_TICK; i++) {
            assert_true(abs(out[2 * i] - before) <= 14);
            before = out[2 * i];
        }
        assert_int_equal(mixer_count(&m), tick < 35);
    }
    assert_int_equal(before, 0);
    sound_release(s);
    mixer_free(&m);
}

static void what_is_too_loud_is_bent_and_not_wrapped(void **unused)
{
    (void)unused;
    mixer m;
    int16_t out[2 * SOUND_TICK];
    sound *s = sound_create(engine, NULL, 1, SOUND_TICK, &error);
    assert_non_null(s);
    for (uint32_t i = 0; i < s->frames; i++) s->samples[i] = (int16_t)(32767 * sin(i * 0.05));
    mixer_init(&m);
    for (int i = 0; i < 200; i++) mixer_play(&m, s)->volume = 4; /* more than there are voices */
    assert_int_equal(mixer_count(&m), SOUND_VOICES);
    mixer_tick(&m, out);
    for (uint32_t i = 0; i < SOUND_TICK; i++)
        if (abs(s->samples[i]) > 1000) assert_true(out[2 * i] * s->samples[i] > 0 && abs(out[2 * i]) > 24000);
    sound_release(s);
    mixer_free(&m);
}

/* ---- sounds that are in memory ---- */

static bool is_found(sound_cache *cache, sound_key key, const sound *wanted)
{
    sound *found = sound_cache_find(cache, key);
    const bool same = found == wanted;
    sound_release(found);
    return same;
}

/* A sound is there as long as somebody holds it, and not for others: each number counts. */
static void sounds_are_found_while_they_are_held(void **unused)
{
    (void)unused;
    sound_cache *cache = sound_cache_open(NULL);
    synth_def defs[14];
    sound *made[14];
    for (int i = 0; i < 14; i++) defs[i] = synth_default();
    defs[1].wave = SYNTH_SAW, defs[2].pitch = 441, defs[3].slide = 441, defs[4].attack = 0.006, defs[5].hold = 0.1;
    defs[6].decay = 0.31, defs[7].vibrato = 1, defs[8].vibrato_rate = 7, defs[9].duty = 0.4, defs[10].cut = 800;
    defs[11].volume = 0.5, defs[12].notes = "a4", defs[13].notes = "a4", defs[13].beat = 0.26;
    for (int i = 0; i < 14; i++) {
        assert_null(sound_cache_find(cache, sound_key_of_synth(&defs[i])));
        assert_non_null(made[i] = synth_make(engine, NULL, &defs[i], &error));
        sound_cache_add(cache, sound_key_of_synth(&defs[i]), made[i]);
    }
    for (int i = 0; i < 14; i++) assert_true(is_found(cache, sound_key_of_synth(&defs[i]), made[i]));
    for (int k = 0; k < 14; k++) { /* in another order */
        const int i = k * 5 % 14;
        sound_hold(made[i]);
        sound_release(made[i]);
        assert_true(is_found(cache, sound_key_of_synth(&defs[i]), made[i]));
        sound_release(made[i]);
        assert_null(sound_cache_find(cache, sound_key_of_synth(&defs[i])));
    }
    assert_true(sound_key_of_file("ab", 2).hash != sound_key_of_file("ac", 2).hash);
    assert_null(sound_cache_find(NULL, sound_key_of_file("ab", 2)));
    sound_cache_hold(cache);
    sound_cache_release(cache);
    sound_cache_release(cache);
}

/* ---- the synthesiser ---- */

static int rising(const sound *s)
{
    int count = 0;
    for (uint32_t i = 1; i < s->frames; i++) count += s->samples[i - 1] < 0 && s->samples[i] >= 0;
    return count;
}

static sound *synth(synth_def def)
{
    sound *s = synth_make(engine, NULL, &def, &error);
    if (!s) fail_msg("%s", error.message);
    return s;
}

static void waves_have_their_pitch(void **unused)
{
    (void)unused;
    for (synth_wave wave = SYNTH_SINE; wave < SYNTH_NOISE; wave++) {
        synth_def def = synth_default();
        def.wave = wave, def.pitch = def.slide = 500, def.hold = 1, def.decay = 0.001, def.attack = 0.001;
        sound *s = synth(def);
        assert_in_range(s->frames, 1.001 * SOUND_RATE, 1.003 * SOUND_RATE);
        assert_in_range(rising(s), 498, 502);
        for (uint32_t i = 1000; i < 40000; i++) assert_in_range(s->samples[i] + 32768, 32768 - 21000, 32768 + 21000);
        sound_release(s);
    }
    synth_def def = synth_default();
    def.pitch = 400, def.slide = 800, def.hold = 1, def.decay = 0.001, def.attack = 0.001;
    sound *s = synth(def);
    assert_in_range(rising(s), 596, 604); /* the mean of both for a second */
    sound_release(s);
}

static void notes_are_those_of_the_scale(void **unused)
{
    (void)unused;
    static const struct {
        const char *name;
        double hz;
    } notes[] = {{"a4", 440}, {"C4", 261.626}, {"c#5", 554.365}, {"bb3", 233.082}, {"g6", 1567.98}, {"e2", 82.4069}};
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++) {
        synth_def def = synth_default();
        def.notes = notes[i].name, def.beat = 2, def.hold = 1.9, def.decay = 0.05;
        sound *s = synth(def);
        assert_in_range(rising(s), (int)(1.95 * notes[i].hz) - 3, (int)(1.96 * notes[i].hz) + 3);
        sound_release(s);
    }
    static const char *const wrong[] = {"h4", "c", "c44", "c9", "##", "", "  ", "c4 - x"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        synth_def def = synth_default();
        def.notes = wrong[i];
        assert_null(synth_make(engine, NULL, &def, &error));
        assert_non_null(strstr(error.message, "notes"));
    }
}

/* A tune that is played over and over has no gap and no cut tail: what rings past its end is at its beginning. */
static void tunes_fit_into_a_loop(void **unused)
{
    (void)unused;
    synth_def def = synth_default();
    def.notes = "- - - a4", def.beat = 0.1, def.decay = 0.4;
    sound *s = synth(def);
    assert_int_equal(s->frames, 4 * 4800);
    int loudest = 0, quiet = 0;
    for (uint32_t i = 0; i < 4800; i++) loudest = abs(s->samples[i]) > loudest ? abs(s->samples[i]) : loudest;
    for (uint32_t i = 3 * 4800 - 4800; i < 3 * 4800; i++)
        quiet = abs(s->samples[i]) > quiet ? abs(s->samples[i]) : quiet;
    assert_in_range(loudest, 8000, 12000); /* 0.6 · (1 − 0.095 / 0.4)² of all */
    assert_in_range(quiet, 100, 3000);
    sound_release(s);
    def.notes = "c4 c4 c4 c4 c4 c4 c4 c4 c4 c4 c4 c4 c4", def.hold = 10;
    assert_null(synth_make(engine, NULL, &def, &error));
    assert_non_null(strstr(error.message, "120 s"));
}

static void a_low_pass_takes_what_is_above(void **unused)
{
    (void)unused;
    double power[2];
    for (int i = 0; i < 2; i++) {
        synth_def def = synth_default();
        def.pitch = def.slide = 8000, def.hold = 0.5, def.cut = i ? 800 : 0;
        sound *s = synth(def);
        power[i] = 0;
        for (uint32_t k = 0; k < s->frames; k++) power[i] += (double)s->samples[k] * s->samples[k];
        sound_release(s);
    }
    assert_in_range(power[0] / power[1], 60, 140); /* a decade above: 100 times less, about */
}

/* ---- the ear ---- */

static void the_camera_hears_where_and_through_what(void **unused)
{
    (void)unused;
    mixer m;
    mixer_init(&m);
    sound *s = random_sound(48000, 1, 1000);
    voice *v = mixer_play(&m, s);
    daft_scene *scene = daft_scene_create(engine, &error);
    assert_non_null(scene);
    daft_camera camera = daft_camera_look_at((daft_dvec3){0, 0, 0}, (daft_dvec3){1, 0, 0}, 1.5f); /* right is +z */
    assert_true(daft_scene_set_camera(scene, &camera, true, &error));
    v->placed = true, v->near = 2, v->far = 50;
    v->place = (daft_dvec3){0, 0, 10};
    ear_listen(&m, scene);
    assert_true(v->side > 0.7f && v->muffle == 0);
    assert_true(fabsf(v->gain - 0.2f * 40 / 48) < 1e-5f); /* 2 m / 10 m, less what is left to the farthest place */
    v->place = (daft_dvec3){0, 0, -10};
    ear_listen(&m, scene);
    assert_true(v->side < -0.7f);
    v->place = (daft_dvec3){20, 5, 0};
    ear_listen(&m, scene);
    assert_true(fabsf(v->side) < 1e-6f && v->gain < 0.1f);
    v->place = (daft_dvec3){51, 0, 0};
    ear_listen(&m, scene);
    assert_true(v->gain == 0);
    v->place = (daft_dvec3){0, 0, 0};
    ear_listen(&m, scene);
    assert_true(v->gain == 1 && v->side == 0);

    /* A wall halfway; then the wall itself sounds; and what hangs on a parent is heard where it is in the world. */
    daft_entity_def def = daft_default_entity_def();
    def.body = DAFT_BODY_STATIC, def.shape = DAFT_SHAPE_BOX, def.size = (daft_vec3){1, 10, 10};
    def.position = (daft_dvec3){10, 0, 0};
    daft_entity wall = daft_entity_create(scene, &def, &error);
    if (!wall.id) fail_msg("%s", error.message);
    v->place = (daft_dvec3){20, 0, 0};
    ear_listen(&m, scene);
    assert_true(v->muffle == 1);
    v->carrier = wall;
    ear_listen(&m, scene);
    assert_true(v->muffle == 0 && v->place.x == 10);
    daft_entity_def child = daft_default_entity_def();
    child.parent = wall, child.position = (daft_dvec3){0, 0, 8};
    v->carrier = daft_entity_create(scene, &child, &error);
    ear_listen(&m, scene);
    assert_true(v->place.x == 10 && v->place.z == 8 && v->side > 0.2f);
    assert_true(daft_entity_destroy(scene, wall, &error));
    ear_listen(&m, scene); /* stays where it was */
    assert_true(v->place.z == 8 && v->carrier.id == 0);
    daft_scene_destroy(scene);
    mixer_free(&m);
    sound_release(s);
}

/* ---- files ---- */

/* SDL2_mixer 2.6 does not give back 8 KB of a FLAC file that breaks off, nor 72 bytes of such an OGG file. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libSDL2"; }

static void *read_tone(const char *kind, size_t *size)
{
    char path[600];
    snprintf(path, sizeof path, DAFT_ROOT "/tests/data/sounds/tone.%s", kind);
    void *bytes = daft_read_file(NULL, path, size, &error);
    if (!bytes) fail_msg("%s", error.message);
    return bytes;
}

static const char *const KINDS[] = {"wav", "ogg", "flac", "mp3"};

static bool can_decode(void)
{
    size_t size;
    void *bytes = read_tone("wav", &size);
    sound *s = audio_decode(engine, NULL, bytes, size, "tone.wav", &error);
    free(bytes);
    sound_release(s);
    if (!s) print_message("no sound files: %s\n", error.message);
    return s != NULL;
}

static void files_of_all_kinds_have_the_same_tone(void **unused)
{
    (void)unused;
    if (!can_decode()) skip();
    for (size_t i = 0; i < 4; i++) {
        size_t size;
        void *bytes = read_tone(KINDS[i], &size);
        sound *s = audio_decode(engine, NULL, bytes, size, KINDS[i], &error);
        if (!s) fail_msg("%s", error.message);
        assert_int_equal(s->channels, 1);
        assert_in_range(s->frames, 11500, 14500); /* a quarter of a second; codecs add some silence */
        assert_in_range(rising(s), 108, 112);
        sound_release(s);
        free(bytes);
    }
}

static void broken_files_are_refused(void **unused)
{
    (void)unused;
    const uint64_t seed = (uint64_t)time(NULL);
    state = seed * 2 + 1;
    if (!can_decode()) skip();
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int round = 0; round < 400; round++) {
        size_t size;
        uint8_t *bytes = read_tone(KINDS[round % 4], &size);
        const int changes = (int)(chance() * 20);
        for (int i = 0; i < changes; i++) bytes[(size_t)(chance() * (double)size)] = (uint8_t)(chance() * 256);
        if (chance() < 0.5) size = (size_t)(chance() * (double)size);
        sound *s = audio_decode(engine, NULL, bytes, size, "broken", &error);
        if (s) assert_in_range(s->frames, 1, (uint64_t)SOUND_SECONDS * SOUND_RATE);
        if (!s) assert_true(error.message[0]);
        sound_release(s);
        free(bytes);
    }
    static const char no_sound[64] = "print 'a script'";
    assert_null(audio_decode(engine, NULL, no_sound, sizeof no_sound, "main.lua", &error));
    assert_string_equal(error.message, "this is no WAV, OGG, FLAC or MP3 file");
    assert_string_equal(error.file, "main.lua");
}

/* SDL_mixer would read the second channel of frames that have one. */
static void flac_has_the_channels_that_it_says(void **unused)
{
    (void)unused;
    if (!can_decode()) skip();
    size_t size;
    uint8_t *bytes = read_tone("flac", &size);
    assert_int_equal(bytes[20] >> 1 & 7, 0); /* one channel */
    bytes[20] |= 1 << 1;
    assert_null(audio_decode(engine, NULL, bytes, size, "two.flac", &error));
    assert_string_equal(error.message, "the sound is broken");
    free(bytes);
}

/* ---- FLAC files made by hand (RFC 9639) ---- */

static uint32_t crc(const uint8_t *b, size_t size, int bits, uint32_t polynomial)
{
    uint32_t rest = 0;
    for (size_t i = 0; i < size; i++) {
        rest ^= (uint32_t)b[i] << (bits - 8);
        for (int k = 0; k < 8; k++) rest = rest >> (bits - 1) & 1 ? rest << 1 ^ polynomial : rest << 1;
    }
    return rest & ((1u << bits) - 1);
}

enum { FLAC_HEADER = 42, FLAC_BLOCK = 65535 };

/* 44,100 samples a second of 16 bits, one second in all. */
static void flac_header(uint8_t b[FLAC_HEADER], int channels)
{
    const uint8_t start[] = {'f', 'L', 'a', 'C', 0x80, 0, 0, 34, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0, 0, 0};
    memset(b, 0, FLAC_HEADER);
    memcpy(b, start, sizeof start);
    b[18] = 44100 >> 12, b[19] = 44100 >> 4 & 0xff, b[20] = (uint8_t)((44100 & 15) << 4 | (channels - 1) << 1);
    b[21] = 15 << 4, b[24] = 44100 >> 8, b[25] = 44100 & 0xff;
}

/* A frame of FLAC_BLOCK equal samples; gives its bytes. */
static size_t flac_frame(uint8_t *b, int channels, int number)
{
    const uint8_t start[] = {0xff, 0xf8, 0x70, (uint8_t)((channels - 1) << 4 | 8), (uint8_t)number, 0xff, 0xfe};
    size_t size = sizeof start;
    memcpy(b, start, size);
    b[size] = (uint8_t)crc(b, size, 8, 7), size++;
    for (int k = 0; k < channels; k++) b[size] = 0, b[size + 1] = 1, b[size + 2] = 0, size += 3;
    const uint32_t end = crc(b, size, 16, 0x8005);
    b[size] = (uint8_t)(end >> 8), b[size + 1] = (uint8_t)end;
    return size + 2;
}

static sound *flac_of(const int *channels, int frames)
{
    static uint8_t bytes[FLAC_HEADER + 32 * 1000];
    size_t size = FLAC_HEADER;
    flac_header(bytes, channels[0]);
    for (int i = 0; i < frames; i++) size += flac_frame(bytes + size, channels[i], i % 128);
    return audio_decode(engine, NULL, bytes, size, "made.flac", &error);
}

static void flac_keeps_its_channels(void **unused)
{
    (void)unused;
    if (!can_decode()) skip();
    sound *s = flac_of((const int[]){2, 2, 2}, 3);
    if (!s) fail_msg("%s", error.message);
    sound_release(s);
    assert_null(flac_of((const int[]){2, 2, 1}, 3));
    assert_string_equal(error.message, "the sound is broken");
    assert_string_equal(error.file, "made.flac");
}

static void flac_in_ogg_is_no_sound(void **unused)
{
    (void)unused;
    if (!can_decode()) skip();
    uint8_t page[64] = {'O', 'g', 'g', 'S', [28] = 0x7f, 'F', 'L', 'A', 'C'};
    assert_null(audio_decode(engine, NULL, page, sizeof page, "flac.ogg", &error));
    assert_string_equal(error.message, "this is no WAV, OGG, FLAC or MP3 file");
}

/* Twelve minutes in 9 kB that say they are a second. */
static void flac_is_as_long_as_its_frames(void **unused)
{
    (void)unused;
    static int mono[500];
    if (!can_decode()) skip();
    for (int i = 0; i < 500; i++) mono[i] = 1;
    assert_null(flac_of(mono, 500));
    assert_string_equal(error.message, "the sound is longer than 10 minutes");
}

/* One frame a second for hours: a small file that would be large in memory. */
static void a_small_file_cannot_ask_for_much_memory(void **unused)
{
    (void)unused;
    if (!can_decode()) skip();
    enum { DATA = 40000 };
    static uint8_t wav[44 + DATA] = "RIFF....WAVEfmt \x10\0\0\0\1\0\1\0\1\0\0\0\1\0\0\0\1\0\x8\0data";
    const uint32_t whole = 36 + DATA, data = DATA;
    memcpy(wav + 4, &whole, 4), memcpy(wav + 40, &data, 4);
    assert_null(audio_decode(engine, NULL, wav, sizeof wav, "slow.wav", &error));
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1, def.memory_limit = 10000;
    daft_engine *small = daft_engine_create(&def, &error);
    assert_non_null(small);
    size_t size;
    void *bytes = read_tone("ogg", &size);
    assert_null(audio_decode(small, NULL, bytes, size, "tone.ogg", &error));
    assert_non_null(strstr(error.message, "out of memory"));
    free(bytes);
    daft_engine_destroy(small);
}

/* ---- the tape ---- */

static void a_tape_is_a_sound_file(void **unused)
{
    (void)unused;
    char path[] = "/tmp/daft-tape-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    tape t;
    sound *s = random_sound(5000, 2, 30000);
    assert_true(tape_begin(&t, path, &error));
    tape_put(&t, s->samples, 2000), tape_put(&t, s->samples + 4000, 3000);
    assert_true(tape_commit(&t, &error));
    size_t size;
    uint8_t *bytes = daft_read_file(NULL, path, &size, &error);
    assert_non_null(bytes);
    assert_int_equal(size, 44 + 5000 * 4);
    assert_memory_equal(bytes + 44, s->samples, 5000 * 4);
    if (can_decode()) {
        sound *back = audio_decode(engine, NULL, bytes, size, path, &error);
        assert_non_null(back);
        assert_int_equal(back->frames, 5000);
        assert_memory_equal(back->samples, s->samples, 5000 * 4);
        sound_release(back);
    }
    free(bytes);
    sound_release(s);
    assert_int_equal(remove(path), 0);
    assert_false(tape_begin(&t, "/no/such/folder/a.wav", &error));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_voice_alone_is_its_sound),
                                       cmocka_unit_test(voices_add_up_as_in_double),
                                       cmocka_unit_test(voices_end_alike_when_nobody_listens),
                                       cmocka_unit_test(changes_do_not_click),
                                       cmocka_unit_test(what_is_too_loud_is_bent_and_not_wrapped),
                                       cmocka_unit_test(sounds_are_found_while_they_are_held),
                                       cmocka_unit_test(waves_have_their_pitch),
                                       cmocka_unit_test(notes_are_those_of_the_scale),
                                       cmocka_unit_test(tunes_fit_into_a_loop),
                                       cmocka_unit_test(a_low_pass_takes_what_is_above),
                                       cmocka_unit_test(the_camera_hears_where_and_through_what),
                                       cmocka_unit_test(files_of_all_kinds_have_the_same_tone),
                                       cmocka_unit_test(broken_files_are_refused),
                                       cmocka_unit_test(flac_has_the_channels_that_it_says),
                                       cmocka_unit_test(flac_keeps_its_channels),
                                       cmocka_unit_test(flac_in_ogg_is_no_sound),
                                       cmocka_unit_test(flac_is_as_long_as_its_frames),
                                       cmocka_unit_test(a_small_file_cannot_ask_for_much_memory),
                                       cmocka_unit_test(a_tape_is_a_sound_file)};
    return cmocka_run_group_tests(tests, open_engine, close_engine);
}
