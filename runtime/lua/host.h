/* host: one Lua 5.4 state that runs one game: its files, its callbacks, its errors.
 *
 * The game may set daft.load(), daft.update(dt), daft.draw(), daft.keypressed(key), daft.keyreleased(key) and
 * daft.textinput(letter), and for live reload daft.keep() and daft.reload(old).
 * It runs in a sandbox in which the same input gives the same game everywhere: no clock, no files, no addresses; random
 * numbers from a seed; pairs() in a fixed order; sin and its kin from libdaft and not from libm.
 *
 * Promises: a script's error is a message and a trace, never a crash; longjmp never crosses a frame of libdaft, which
 * calls nothing here back. A call that runs too long is stopped (watchdog.h), also in handlers, __close and coroutines,
 * and memory is bounded. */
#ifndef RUNTIME_HOST_H
#define RUNTIME_HOST_H

#include "hud/canvas.h"
#include "files/home.h"
#include "platform/actions.h"
#include "common/trace.h"
#include "lua/failure.h"
#include "lua/profile.h"
#include "lua/watchdog.h"
#include "sound/cache.h"

#include <lua.h>
#include <stdatomic.h>

typedef struct api_function api_function;
typedef struct saves saves;
typedef struct particle_system particle_system;
typedef struct trial trial;

/* xoshiro256**: Blackman & Vigna 2018. */
typedef struct random_state {
    uint64_t s[4];
} random_state;

enum { HOST_MESSAGE = FAILURE_MESSAGE };

typedef struct host_def {
    const daft_files *files; /* the game's: see game_source */
    const char *folder;      /* the game's */
    const char *scripts;     /* the folder scripts/ */
    const char *name;        /* the game's, in messages */
    daft_engine *engine;
    const daft_allocator *memory; /* for all that the scripts hold; NULL: malloc. Must stay */
    sound_cache *sounds;          /* of another host on the same engine and memory, to share what both have; or NULL */
    daft_scene *scene;
    input *keys;
    const key_map *map; /* the player's keys, to show them; or NULL */
    platform *keyboard; /* the player's; or NULL */
    font *face;
    saves *saves;     /* what the game keeps: files/saves.h */
    tracer *spans;    /* of calls into the scripts; or NULL */
    profile *profile; /* notes which lines take the time; or NULL; must outlive the host */
    uint64_t seed;
    uint64_t instructions; /* one call may run so many, about; 0: only time counts */
    double seconds;        /* one call may take; 0: WATCHDOG_SECONDS */
    /* Of each module of scripts/ as it is required; or NULL. */
    void (*required)(void *user, const char *name, const char *text, size_t size);
    int (*asked)(void *user); /* whether the game is to stop: see watchdog_def. May be NULL */
    /* What the script prints, piece by piece: on stdout too. May be NULL. */
    void (*printed)(void *user, const char *text, size_t size);
    bool quiet; /* what it prints goes nowhere: it has been printed before */
    void *user;
    /* Takes each font that the scripts open, and closes it when they are long gone; NULL: it closes with its handle. */
    void (*keep_font)(void *keeper, font *face);
    void *keeper;
} host_def;

/* What the game wishes of its window (tables/window.c). */
typedef struct window_wish {
    uint32_t changes;  /* calls so far; 0: it wishes nothing */
    char title[128];   /* empty: the game's */
    int width, height; /* points; 0: as it is */
    int full_screen;   /* -1: as it is */
    daft_image *icon;  /* the host's; NULL: as it is */
} window_wish;

/* Open to runtime/lua/ and the game only. */
typedef struct host {
    lua_State *L;
    host_def def;
    random_state random;      /* of the game */
    random_state draw_random; /* of daft.draw, which must not change what the game does */
    uint64_t tick;
    double clock;                   /* ticks of the game's time so far: each counts as much as its scale says */
    double scale, next_scale;       /* of this tick, and from the next one on: daft.time_scale */
    bool still;                     /* the tick before did not step the simulation: nothing happened in it */
    uint32_t streams;               /* of random numbers, made so far */
    canvas *picture;                /* while daft.draw runs */
    canvas_marks texts;             /* where its texts are */
    bool replaying;                 /* daft.input.set does nothing: the recording has what it did */
    bool quit, restart, grab, text; /* wishes of the script; text: to hear of letters that are typed */
    float rumble;                   /* 0 to 1, */
    double rumble_seconds;          /* for so long, from now; 0: nothing is new */
    actions actions;
    window_wish window;
    double target_ms;              /* that a frame may take; 0: any; below 0: the script has not said */
    const api_function *calling;   /* the binding that runs, for messages */
    const struct api_handle *self; /* what it was called on, if it is a method: of its type; until it calls another */
    const char *callback;          /* the callback that runs, for messages */
    uint64_t call_ran;             /* instructions, in steps of WATCH_STEP */
    uint64_t call_limit;           /* of them, for this call; 0: that of the definition */
    watchdog *dog;
    lua_State *_Atomic running; /* the state or coroutine that runs: where a stop is to strike */
    watchdog_state ended;       /* how the last call came to its end; RUNNING: by itself */
    bool stopped;               /* this call: every protected call in the script passes the error on */
    bool long_string;           /* this call wanted a string over HOST_STRING */
    bool asked;                 /* stopped because somebody asked for the end */
    int depth;                  /* of coroutines that are being closed, one within the other */
    uint32_t made;              /* materials and meshes since host_collect last did something, roughly by their size */
    size_t memory, reserved;    /* bytes: Lua holds; are counted for it towards the engine's limit */
    uint32_t pictures;          /* made so far */
    uint32_t tasks;             /* that run or wait, at most */
    particle_system *particles; /* all of them: tables/particles.c */
    uint32_t particle_count;    /* there is room for, in all of them */
    uint32_t systems;           /* of particles, made so far */
    uint32_t indexed;           /* ids in the indices of names and tags (tables/tags.c) */
    uint32_t indexed_kept;      /* the same after they were last swept */
    const char *statement;      /* that runs, and where its answer goes: lua/statement.h; or NULL */
    char *answer;
    trial *trial;                  /* a test of the game runs beside it: lua/trial.h; or NULL */
    mixer mixer;                   /* what sounds */
    sound_cache *cache;            /* the sounds that are there; NULL: there was no memory for it */
    uint32_t sounds, music;        /* made so far; the voice of the music */
    uint32_t fonts, images;        /* made so far */
    char *handed;                  /* what the game hands over to new code, as daft.save writes it; or NULL */
    failure failure;               /* of the last call, if it failed */
    char inner[FAILURE_TRACE / 2]; /* the stack of the coroutine in which an error began that is on its way; or empty */
} host;

/* What a game may hold where nobody says otherwise: the bytes of its scripts, meshes, textures and pictures together.
 */
static const uint64_t HOST_MEMORY = 1000000000;
/* The longest string, in bytes: no operation of Lua on one takes longer than a second. */
static const size_t HOST_STRING = (size_t)64 << 20;

/* Opens a state with the API and runs main.lua. On failure `failure` is filled, and so is the host: call
 * host_close all the same. `state` must not move afterwards. */
bool host_open(host *state, const host_def *def);
void host_close(host *state);

/* Each is true when the game does not have the callback. */
bool host_load(host *state);
/* Frees what the game has made and no longer holds or uses, once that is worth it. Between two callbacks. */
bool host_collect(host *state);
/* Before the tick's callbacks. */
void host_begin_tick(host *state);
bool host_update(host *state, double dt);
/* After them, and after the simulation's step, where there was one. */
void host_end_tick(host *state);
bool host_key(host *state, int key, bool down);
bool host_typed(host *state, int code);
bool host_draw(host *state, const canvas *picture);
/* Whether the game has this callback. */
bool host_has(host *state, const char *callback);
/* For new code that takes its place: leaves in `handed` what daft.keep returns; without that function, its global
 * variables that are plain data. */
bool host_hand_over(host *state);
bool host_reload(host *state, const char *handed);
/* Around drawing the scene: what daft.particles made is seen from this camera, `ahead` seconds of the game after the
 * last tick, and is not there for anybody else. */
void host_show_particles(host *h, const daft_camera *camera, double ahead);
void host_hide_particles(host *h);
/* Moves them by so many seconds of the game: part of host_end_tick. */
void host_step_particles(host *h, double dt);
/* Of the picture in HUD units: within daft.draw of the one that is drawn, else as the input has it. */
float host_width(const host *state);

/* Runs another file of the game, in the same state; and a function, whose name in messages is `shown`. */
bool host_run_file(host *state, const char *file);
bool host_call(host *state, const char *shown, int (*function)(lua_State *L));

/* Stops the call that runs after about so many instructions: after the same one everywhere. */
void host_limit_steps(lua_State *L, uint64_t steps);
/* Whether the call that runs is to end. */
bool host_stopping(const host *state);
/* For library functions that loop in C, every HOST_POLL_STEPS steps: raises an error where the call is to end. */
enum { HOST_POLL_STEPS = 4096 };
void host_poll(lua_State *L);
/* Keeps the stack of a coroutine that has failed, the innermost one's; an empty one once the error has been caught. */
void host_keep_trace(host *state, lua_State *L, lua_State *failed);
void host_forget_trace(host *state);
/* Which state or coroutine runs from now on. */
void host_set_running(host *state, lua_State *L);

void random_seed(random_state *state, uint64_t seed);
uint64_t random_next(random_state *state);

/* Where a file that a game names is: the game's folder first, then assets/. False with a message. */
bool host_find_file(const host *state, const char *name, char *out, size_t size, daft_error *error);

#endif
