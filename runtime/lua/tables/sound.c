/* daft.sound: sounds from files or from numbers, voices that play them, music, and volumes of groups. */
#include "lua/fields.h"

#include "common/util.h"
#include "platform/audio.h"
#include "sound/synth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct sound_handle {
    api_handle handle;
    sound *what;
} sound_handle;

/* A number in a field of the table at 1, between two limits; `usual` where there is none. */
static double number(lua_State *L, host *h, int table, const char *name, double usual, double low, double high)
{
    if (!api_field(L, table, name)) return usual;
    const double value = api_number(L, h, -1, name);
    if (value < low || value > high) api_error(L, h, "%s: %g to %g expected, got %g", name, low, high, value);
    lua_pop(L, 1);
    return value;
}

/* ---- sounds ---- */

/* Before the sound is made: it is let go of whatever fails afterwards. */
static sound_handle *push_sound(lua_State *L, host *h)
{
    sound_handle *s = lua_newuserdatauv(L, sizeof *s, 0);
    *s = (sound_handle){.handle.id = ++h->sounds};
    api_set_type(L, API_SOUND);
    return s;
}

/* Lua sees only its small handle: long ones count more towards the next time it lets go of what nothing holds. */
static int made(host *h, const sound *what)
{
    h->made += 1 + what->frames / SOUND_RATE;
    return 1;
}

int api_release_sound(lua_State *L)
{
    sound_handle *s = lua_touserdata(L, 1);
    sound_release(s->what);
    s->what = NULL;
    return 0;
}

static int from_file(lua_State *L, host *h)
{
    char path[PATH_SIZE];
    size_t size;
    daft_error error;
    const char *name = api_text(L, h, 1, "file");
    sound_handle *s = push_sound(L, h);
    void *bytes =
        host_find_file(h, name, path, sizeof path, &error) ? daft_read_file(h->def.files, path, &size, &error) : NULL;
    if (bytes) {
        const sound_key key = sound_key_of_file(bytes, size);
        s->what = sound_cache_find(h->cache, key);
        const bool is_new = !s->what;
        if (is_new) s->what = audio_decode(h->def.engine, h->def.memory, bytes, size, name, &error);
        if (is_new && s->what) sound_cache_add(h->cache, key, s->what);
    }
    free(bytes);
    if (!s->what) api_engine_error(L, h, &error);
    return made(h, s->what);
}

static void read_notes(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((synth_def *)out)->notes = api_text(L, h, -1, "notes"); /* the table holds it */
}

static void set_synth_default(void *out)
{
    const synth_def def = synth_default();
    memcpy(out, &def, sizeof def);
}

static const char *const WAVES[SYNTH_WAVES] = {"sine", "triangle", "saw", "square", "noise"};

#define NUMBER(member, low, high, ...)                                                                                 \
    API_ROW(synth_def, member, #member, DAFT_FIELD_DOUBLE, .min = low, .max = high, __VA_ARGS__)

static const daft_field SYNTH_FIELDS[] = {
    API_ROW(synth_def, wave, "wave", DAFT_FIELD_CHOICE, .choices = WAVES, .choice_count = SYNTH_WAVES,
            .doc = "From soft to harsh"),
    NUMBER(pitch, 10, 20000, .unit = "Hz", .doc = "At the beginning of the sound"),
    NUMBER(slide, 10, 20000, .unit = "Hz", .doc = "At its end; where only the pitch is given, the same"),
    NUMBER(attack, 0.001, 10, .unit = "s", .doc = "Time in which it rises"),
    NUMBER(hold, 0, 10, .unit = "s", .doc = "Time in which it stays"),
    NUMBER(decay, 0.001, 10, .unit = "s", .doc = "Time in which it falls to nothing"),
    NUMBER(vibrato, 0, 24, .unit = "semitones", .doc = "By which the pitch sways, up and down"),
    NUMBER(vibrato_rate, 0.1, 50, .unit = "Hz", .doc = "How often it does"),
    NUMBER(duty, 0.05, 0.95, .doc = "Part of a square wave that is high: thin or full"),
    NUMBER(cut, 0, 20000, .unit = "Hz", .doc = "What is higher is softened; 0: nothing is"),
    NUMBER(volume, 0, 1, .doc = "How loud it is"),
    NUMBER(beat, 0.01, 10, .unit = "s", .doc = "Time from one note to the next"),
};
const api_list api_synth_list = {SYNTH_FIELDS, COUNT_OF(SYNTH_FIELDS), set_synth_default};
static const api_special SYNTH_SPECIALS[] = {
    {"notes", read_notes, NULL, "string",
     "A tune of such sounds, one each beat: \"c4 e4 g#4 - bb4\", - for a rest; it repeats without a gap"}};
const api_form api_synth_form = {"sound", "daft.sound",   DAFT_STRUCT_COUNT,
                                 -1,      SYNTH_SPECIALS, COUNT_OF(SYNTH_SPECIALS)};

static int from_numbers(lua_State *L, host *h)
{
    synth_def def = synth_default();
    lua_settop(L, 1);
    api_read_struct(L, h, 1, NULL, &api_synth_form, &def);
    if (!api_has_field(L, 1, "slide")) def.slide = def.pitch;
    daft_error error;
    sound_handle *s = push_sound(L, h);
    const sound_key key = sound_key_of_synth(&def);
    if ((s->what = sound_cache_find(h->cache, key))) return made(h, s->what);
    s->what = synth_make(h->def.engine, h->def.memory, &def, &error);
    if (!s->what) api_engine_error(L, h, &error);
    sound_cache_add(h->cache, key, s->what);
    return made(h, s->what);
}

static int make(lua_State *L, host *h)
{
    if (lua_type(L, 1) == LUA_TSTRING) return from_file(L, h);
    if (lua_type(L, 1) != LUA_TTABLE) api_wrong(L, h, 1, "sound", "file or table");
    return from_numbers(L, h);
}

static sound *check_sound(lua_State *L, host *h, int index)
{
    return ((sound_handle *)api_check_handle(L, h, index, API_SOUND, "sound"))->what;
}

static int seconds(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)check_sound(L, h, 1)->frames / SOUND_RATE);
    return 1;
}

/* ---- voices ---- */

static int read_group(lua_State *L, host *h, int index)
{
    const int group = mixer_group(&h->mixer, api_text(L, h, index, "group"));
    if (group < 0)
        api_error(L, h, "group: at most %d groups, with names of at most %d bytes", SOUND_GROUPS, SOUND_NAME - 1);
    return group;
}

/* A place, or an entity that carries the voice from now on. */
static void read_place(lua_State *L, host *h, int index, voice *v)
{
    const api_handle *carrier = api_test_handle(L, index, API_ENTITY);
    v->place = api_place(L, h, index, "at");
    v->carrier = (daft_entity){carrier ? carrier->id : 0};
    v->placed = true;
}

static int push_voice(lua_State *L, const voice *v)
{
    api_new_handle(L, API_VOICE, v->id);
    return 1;
}

/* What sound:play is told. */
typedef struct play_wish {
    voice v;
    double fade;
} play_wish;

static void read_voice_group(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((play_wish *)out)->v.group = read_group(L, h, -1);
}

static void read_voice_place(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    read_place(L, h, -1, &((play_wish *)out)->v);
}

static void set_play_default(void *out)
{
    const play_wish wish = {.v = {.near = 3, .far = 100, .volume = 1, .pitch = 1, .fade = 1}};
    memcpy(out, &wish, sizeof wish);
}

static const daft_field PLAY_FIELDS[] = {
    API_ROW(play_wish, v.volume, "volume", DAFT_FIELD_FLOAT, .max = 4, .doc = "How loud, to the sound's own"),
    API_ROW(play_wish, v.pitch, "pitch", DAFT_FIELD_DOUBLE, .min = 1.0 / 16, .max = 16,
            .doc = "How many times as fast"),
    API_ROW(play_wish, v.pan, "pan", DAFT_FIELD_FLOAT, .min = -1, .max = 1, .doc = "-1: left; 1: right"),
    API_ROW(play_wish, v.loops, "loop", DAFT_FIELD_BOOL, .doc = "Over and over, without a gap"),
    API_ROW(play_wish, v.near, "near", DAFT_FIELD_FLOAT, .unit = "m", .min = (double)0.01f, .max = 1e6,
            .doc = "Up to this distance it has its full volume"),
    API_ROW(play_wish, v.far, "far", DAFT_FIELD_FLOAT, .unit = "m", .min = (double)0.02f, .max = 2e6,
            .doc = "From this distance on it is silent: more than near; where only near is given, at least twice that"),
    API_ROW(play_wish, fade, "fade", DAFT_FIELD_DOUBLE, .unit = "s", .max = 60, .doc = "Time in which it rises"),
};
const api_list api_voice_list = {PLAY_FIELDS, COUNT_OF(PLAY_FIELDS), set_play_default};
static const api_special PLAY_SPECIALS[] = {
    {"group", read_voice_group, NULL, "string", "Whose volume daft.volume sets"},
    {"at", read_voice_place, NULL, "{x, y, z} or entity, m",
     "Where it is, or the entity that carries it; without, it is everywhere"}};
const api_form api_voice_form = {"sound:play", "sound:play",  DAFT_STRUCT_COUNT,
                                 -1,           PLAY_SPECIALS, COUNT_OF(PLAY_SPECIALS)};

static void read_options(lua_State *L, host *h, play_wish *wish)
{
    voice *v = &wish->v;
    api_read_struct(L, h, 2, "options", &api_voice_form, wish);
    if (!api_has_field(L, 2, "far")) v->far = (float)fmax(100, 2 * (double)v->near);
    if (!(v->far > v->near))
        api_error(L, h, "far: more than near, %g, expected, got %g", (double)v->near, (double)v->far);
    if (wish->fade > 1.0 / 60) v->fade = 0, v->fade_step = (float)(1 / (wish->fade * 60));
}

static int play(lua_State *L, host *h)
{
    lua_settop(L, 2);
    play_wish wish;
    set_play_default(&wish);
    sound *what = check_sound(L, h, 1);
    if (!lua_isnil(L, 2)) read_options(L, h, &wish);
    voice *v = mixer_play(&h->mixer, what);
    wish.v.id = v->id, wish.v.what = v->what, wish.v.gain = v->gain;
    *v = wish.v;
    return push_voice(L, v);
}

/* NULL: it is over, and there is nothing to do. */
static voice *check_voice(lua_State *L, host *h)
{
    return mixer_find(&h->mixer, api_check_handle(L, h, 1, API_VOICE, "voice")->id);
}

static double read_fade(lua_State *L, host *h, int index)
{
    const double fade = lua_isnoneornil(L, index) ? 0 : api_number(L, h, index, "seconds");
    if (fade < 0 || fade > 60) api_error(L, h, "seconds: 0 to 60 expected, got %g", fade);
    return fade;
}

static int stop(lua_State *L, host *h)
{
    const double fade = read_fade(L, h, 2);
    voice *v = check_voice(L, h);
    if (v) voice_stop(v, fade);
    return 0;
}

static double limited(lua_State *L, host *h, const char *what, double low, double high)
{
    const double value = api_number(L, h, 2, what);
    if (value < low || value > high) api_error(L, h, "%s: %g to %g expected, got %g", what, low, high, value);
    return value;
}

static int set_volume(lua_State *L, host *h)
{
    const double value = limited(L, h, "volume", 0, 4);
    voice *v = check_voice(L, h);
    if (v) v->volume = (float)value;
    return 0;
}

static int set_pitch(lua_State *L, host *h)
{
    const double value = limited(L, h, "pitch", 1.0 / 16, 16);
    voice *v = check_voice(L, h);
    if (v) v->pitch = value;
    return 0;
}

static int set_pan(lua_State *L, host *h)
{
    const double value = limited(L, h, "pan", -1, 1);
    voice *v = check_voice(L, h);
    if (v) v->pan = (float)value;
    return 0;
}

static int set_place(lua_State *L, host *h)
{
    voice unused, *v = check_voice(L, h);
    read_place(L, h, 2, v ? v : &unused);
    return 0;
}

static int is_playing(lua_State *L, host *h)
{
    lua_pushboolean(L, check_voice(L, h) != NULL);
    return 1;
}

/* ---- music and groups ---- */

static int music(lua_State *L, host *h)
{
    static const char *const FIELDS[] = {"fade", "volume"};
    lua_settop(L, 2);
    double fade = 1, volume = 1;
    sound *what = lua_isnil(L, 1) ? NULL : check_sound(L, h, 1);
    if (!lua_isnil(L, 2)) {
        api_fields(L, h, 2, "options", FIELDS, COUNT_OF(FIELDS));
        fade = number(L, h, 2, "fade", fade, 0, 60), volume = number(L, h, 2, "volume", volume, 0, 4);
    }
    voice *before = mixer_find(&h->mixer, h->music);
    if (before && before->what == what && before->fade_step >= 0) {
        before->volume = (float)volume;
        return 0;
    }
    if (before) voice_stop(before, fade);
    h->music = 0;
    if (!what) return 0;
    voice *v = mixer_play(&h->mixer, what);
    v->volume = (float)volume, v->loops = true, v->group = mixer_group(&h->mixer, "music");
    if (fade > 1.0 / 60) v->fade = 0, v->fade_step = (float)(1 / (fade * 60));
    h->music = v->id;
    return 0;
}

static int group_volume(lua_State *L, host *h)
{
    const int group = read_group(L, h, 1);
    if (!lua_isnoneornil(L, 2)) h->mixer.group_volumes[group] = (float)limited(L, h, "volume", 0, 4);
    lua_pushnumber(L, (double)h->mixer.group_volumes[group]);
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"sound", "(file) or {...} -> sound",
     "A sound from a WAV, OGG, FLAC or MP3 file, at most ten minutes long; or made of numbers.", make, API_CHANGES},
    {"sound:play", "([{...}]) -> voice",
     "Plays it. What is at a place is muffled by bodies between it and the camera. 64 voices play at once; where one\n"
     "more begins, the one that is nearest its end goes.",
     play, API_CHANGES},
    {"sound:seconds", "() -> s", "How long it is.", seconds, 0},
    {"voice:stop", "([seconds])", "Fades it out.", stop, API_CHANGES},
    {"voice:volume", "(v)", "As in play. What has ended takes all of these, and nothing happens.", set_volume,
     API_CHANGES},
    {"voice:pitch", "(p)", "", set_pitch, API_CHANGES},
    {"voice:pan", "(p)", "", set_pan, API_CHANGES},
    {"voice:at", "(place or entity)", "Moves it there.", set_place, API_CHANGES},
    {"voice:playing", "() -> boolean", "False once it has ended.", is_playing, 0},
    {"music", "([sound [, {fade =, volume =}]])",
     "Plays a sound over and over, in the group \"music\", while the one before fades out (1 s); nil: no more.", music,
     API_CHANGES},
    {"volume", "(group [, v]) -> v", "The volume of a group of voices, or of \"all\": 0 to 4.", group_volume,
     API_CHANGES},
};

const api_area api_sound = {"Sound", FUNCTIONS, COUNT_OF(FUNCTIONS)};
