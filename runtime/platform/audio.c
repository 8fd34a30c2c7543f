/* SDL2_mixer knows one output for the whole process, so there is one here. Its thread takes frames out of a ring that
 * the game's thread fills. Where there is no loudspeaker, files are decoded with SDL's dummy output. */
#include "platform/audio.h"

#include "common/util.h"
#include "platform/flac.h"

#include <SDL.h>
#include <SDL_mixer.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    RING = 16384,              /* frames, a power of two */
    WAITING = SOUND_RATE / 10, /* more than this is not let wait */
    AHEAD = 3 * SOUND_TICK,    /* silence at the beginning, so that ticks may come unevenly */
    DEVICE = 1024              /* frames that the output takes at once */
};

static struct {
    bool open, speaks;
    int loudness; /* of 256 */
    int16_t frames[2 * RING];
    _Atomic uint32_t put, taken; /* frames so far */
} output;

static void feed(void *unused, Uint8 *to, int bytes)
{
    (void)unused;
    const uint32_t wanted = (uint32_t)bytes / 4, taken = atomic_load_explicit(&output.taken, memory_order_relaxed);
    const uint32_t there = atomic_load_explicit(&output.put, memory_order_acquire) - taken;
    const uint32_t some = wanted < there ? wanted : there;
    for (uint32_t i = 0; i < some; i++) memcpy(to + (size_t)4 * i, &output.frames[(size_t)2 * ((taken + i) % RING)], 4);
    memset(to + (size_t)4 * some, 0, (size_t)4 * (wanted - some));
    atomic_store_explicit(&output.taken, taken + some, memory_order_release);
}

bool audio_load_decoders(void)
{
    Mix_Init(MIX_INIT_OGG | MIX_INIT_FLAC | MIX_INIT_MP3); /* a format that is not there says so when it is decoded */
    return true;
}

static bool open_output(bool speaks, daft_error *error)
{
    if (output.open) return true;
    if (!speaks) SDL_SetHint(SDL_HINT_AUDIODRIVER, "dummy");
    bool good = SDL_InitSubSystem(SDL_INIT_AUDIO) == 0;
    if (good && Mix_OpenAudioDevice(SOUND_RATE, AUDIO_S16SYS, 2, DEVICE, NULL, 0) != 0) {
        SDL_QuitSubSystem(SDL_INIT_AUDIO);
        good = false;
    }
    if (!good) return fail(error, DAFT_ERROR_UNSUPPORTED, "no sound: %s", SDL_GetError());
    audio_load_decoders();
    Mix_AllocateChannels(0);
    output.open = true, output.speaks = speaks;
    return true;
}

/* Without any output ALSA's library tells the terminal at length. */
static bool has_loudspeaker(void)
{
#if defined(__linux__)
    const char *const names[] = {"SDL_AUDIODRIVER", "PULSE_SERVER", "PIPEWIRE_REMOTE"};
    const char *const sockets[] = {"pulse/native", "pipewire-0"};
    const char *folder = getenv("XDG_RUNTIME_DIR");
    char path[PATH_SIZE];
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (getenv(names[i])) return true;
    for (size_t i = 0; folder && i < COUNT_OF(sockets); i++)
        if (path_join(path, sizeof path, folder, sockets[i]) && access(path, F_OK) == 0) return true;
    return access("/dev/snd", F_OK) == 0 || access("/dev/dsp", F_OK) == 0;
#else
    return true;
#endif
}

bool audio_open(daft_error *error)
{
    static const int16_t silence[2 * AHEAD];
    output.loudness = 256;
    if (!has_loudspeaker()) return fail(error, DAFT_ERROR_UNSUPPORTED, "no sound: there is no loudspeaker");
    if (!open_output(true, error)) return false;
    audio_play(silence, AHEAD);
    Mix_HookMusic(feed, NULL);
    return true;
}

void audio_play(const int16_t *frames, uint32_t count)
{
    if (!output.speaks) return;
    const uint32_t put = atomic_load_explicit(&output.put, memory_order_relaxed);
    const uint32_t waits = put - atomic_load_explicit(&output.taken, memory_order_acquire);
    if (waits > WAITING || count > RING - waits) return;
    for (uint32_t i = 0; i < 2 * count; i++)
        output.frames[(2 * put + i) % (2 * RING)] = (int16_t)(frames[i] * output.loudness / 256);
    atomic_store_explicit(&output.put, put + count, memory_order_release);
}

void audio_volume(double volume) { output.loudness = (int)(256 * volume); }

void audio_close(void)
{
    if (!output.open) return;
    Mix_HookMusic(NULL, NULL);
    Mix_CloseAudio();
    Mix_Quit();
    SDL_QuitSubSystem(SDL_INIT_AUDIO);
    output.open = output.speaks = false;
}

/* ---- files ---- */

/* SDL2_mixer reads more than these, by code that nobody has hardened against strangers' files. */
static bool is_known(const uint8_t *b, size_t size)
{
    static const uint8_t flac[] = {0x7f, 'F', 'L', 'A', 'C'}; /* in Ogg: unread here, and unchecked by flac_seconds */
    if (size < 12) return false;
    if (memcmp(b, "OggS", 4) == 0) return size < 28 + sizeof flac || memcmp(b + 28, flac, sizeof flac) != 0;
    if (memcmp(b, "RIFF", 4) == 0) return memcmp(b + 8, "WAVE", 4) == 0;
    return flac_is(b, size) || memcmp(b, "ID3", 3) == 0 || (b[0] == 0xff && (b[1] & 0xe0) == 0xe0);
}

/* Seconds: of FLAC by its frames, else what the file says of itself, before anything is decoded. 0: the error says why
 * it cannot be told, or is too long. */
static double length_of(const void *bytes, size_t size, const char *name, daft_error *error)
{
    if (flac_is(bytes, size)) return flac_seconds(bytes, size, SOUND_SECONDS, name, error);
    Mix_Music *music = Mix_LoadMUS_RW(SDL_RWFromConstMem(bytes, (int)size), 1);
    const double seconds = music ? Mix_MusicDuration(music) : 0;
    if (music) Mix_FreeMusic(music);
    if (!(seconds > 0)) return fail_at(error, name, 0, 0, "the sound is broken, or has no length");
    if (seconds > SOUND_SECONDS) return fail_at(error, name, 0, 0, "the sound is longer than 10 minutes");
    return seconds;
}

static bool is_mono(const int16_t *frames, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (frames[(size_t)2 * i] != frames[(size_t)2 * i + 1]) return false;
    return true;
}

static sound *copy_of(daft_engine *engine, const daft_allocator *memory, const Mix_Chunk *chunk, daft_error *error)
{
    const int16_t *frames = (const int16_t *)(const void *)chunk->abuf;
    const uint32_t count = chunk->alen / 4;
    const int channels = is_mono(frames, count) ? 1 : 2;
    sound *s = sound_create(engine, memory, channels, count, error);
    for (uint32_t i = 0; s && i < count; i++)
        for (int k = 0; k < channels; k++)
            s->samples[i * (uint32_t)channels + (uint32_t)k] = frames[(size_t)2 * i + (size_t)k];
    return s;
}

static sound *refuse(daft_error *error, const char *name, const char *why)
{
    fail_at(error, name, 0, 0, "%s", why);
    return NULL;
}

sound *audio_decode(daft_engine *engine, const daft_allocator *memory, const void *bytes, size_t size, const char *name,
                    daft_error *error)
{
    if (size > INT_MAX || !is_known(bytes, size)) return refuse(error, name, "this is no WAV, OGG, FLAC or MP3 file");
    if (!open_output(false, error)) return NULL;
    const double seconds = length_of(bytes, size, name, error);
    if (seconds == 0) return NULL;
    const uint64_t room = (uint64_t)((seconds + 1) * SOUND_RATE) * 4; /* while both are in memory */
    if (!daft_engine_reserve(engine, room)) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a sound of %.1f s", seconds);
        return NULL;
    }
    Mix_Chunk *chunk = Mix_LoadWAV_RW(SDL_RWFromConstMem(bytes, (int)size), 1);
    sound *s = chunk ? copy_of(engine, memory, chunk, error) : refuse(error, name, "the sound is broken");
    if (chunk) Mix_FreeChunk(chunk);
    daft_engine_unreserve(engine, room);
    return s;
}
