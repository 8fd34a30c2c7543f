/* game: one tick of a game, and what plays it again, holds it in time and shows what it is.
 * Public headers: game.h agree.h xray.h fingerprint.h recording.h loop.h governor.h ear.h pause.h relive.h timeline.h
 * heap.h. recording.h reads and writes input, loop.h is the fixed time step, and game.h (this) runs one game, tick by
 * tick, without a window or a clock. One tick stores the poses for interpolation, applies the input (live or recorded),
 * runs lines of Lua that somebody typed, calls daft.keypressed and daft.keyreleased, then daft.update(1/60), then steps
 * the simulation. Promises: the same recording gives the same ticks. After a script error the game stops and keeps the
 * message until it is reloaded. Callbacks, steps and pictures that take too long are errors of that kind
 * (lua/watchdog.h). */
#ifndef RUNTIME_GAME_GAME_H
#define RUNTIME_GAME_GAME_H

#include "common/quality.h"
#include "files/source.h"
#include "lua/host.h"
#include "game/governor.h"
#include "game/recording.h"

#include <stdatomic.h>

typedef struct game_def {
    const home *where;
    const game_info *info;
    const game_source *source; /* its files; must outlive the game. NULL: game_open opens them */
    daft_engine *engine;       /* loads from the game's files until game_close */
    /* As in host_def; NULL: malloc, and fonts close with their handles. */
    const daft_allocator *memory;
    void (*keep_font)(void *keeper, font *face);
    void *keeper;
    sound_cache *sounds; /* as in host_def */
    font *face;
    quality_wish quality; /* QUALITY_OF_SCENE: what the game asks for */
    uint64_t seed;
    recording *replay;        /* or NULL; must outlive the game */
    recorder *record;         /* or NULL; must outlive the game */
    const char *handed;       /* for daft.reload, after daft.load; or NULL. Must outlive game_open */
    struct trail *trail;      /* of what happens, to do it again (relive.h); or NULL; must outlive the game */
    tracer *spans;            /* of what takes time; or NULL; must outlive the game */
    daft_history *history;    /* of pictures that follow each other on a screen; or NULL; must outlive the game */
    const key_map *map;       /* the player's keys, for the game to show; or NULL; must outlive the game */
    platform *keyboard;       /* the player's, for what is printed on its keys; or NULL; must outlive the game */
    saves *saves;             /* what the game keeps; must outlive it. NULL: as long as it runs */
    const governor *governor; /* chooses knobs of pictures; or NULL; must outlive the game */
    profile *profile;         /* of the scripts' lines; or NULL; must outlive the game */
    double seconds;           /* one call into the game may take; 0: WATCHDOG_SECONDS */
    void (*required)(void *user, const char *name, const char *text, size_t size); /* as in host_def; or NULL */
    int (*asked)(void *user); /* whether the game is to stop: see watchdog_def. May be NULL */
    /* Each tick's sound, SOUND_TICK frames, left and right by turns; NULL: nobody listens, and nothing is mixed. */
    void (*heard)(void *user, const int16_t *frames);
    /* What the script prints, piece by piece; what a line of Lua came to that ran. May be NULL. */
    void (*printed)(void *user, const char *text, size_t size);
    bool quiet; /* it prints nowhere: it has printed before */
    void (*answered)(void *user, const char *line, const char *answer, bool good);
    void *user;
} game_def;

enum { GAME_LINES = 16 };

typedef struct game_state {
    game_def def;
    game_source own;  /* where the definition has no source */
    saves *own_saves; /* likewise */
    daft_scene *scene;
    host scripts;
    input keys;
    char *lines[GAME_LINES]; /* of Lua, for the next tick */
    size_t line_count;
    uint64_t ticks; /* since game_open; a restart does not reset it */
    /* When something last came to an end, a tick or a picture; and whether a picture is at work. For the watchdog's
     * thread. */
    _Atomic uint64_t alive_ns;
    atomic_bool rendering;
    bool failed; /* scripts.failure holds the error */
    bool over;   /* daft.quit was called */
} game_state;

/* Runs main.lua and daft.load. False only when out of memory; a script error gives a game with `failed` set. */
bool game_open(game_state *state, const game_def *def, daft_error *error);
void game_close(game_state *state);
/* Starts the game again: for R on the error screen, and for daft.restart. */
bool game_reload(game_state *state, daft_error *error);

/* Runs a line of Lua (lua/statement.h) as the next tick begins. False: it is none, too many wait, the game has failed
 * or a recording plays, whose game it would change. */
bool game_run_line(game_state *state, const char *text);
/* False when the game has failed, now or before. */
bool game_tick(game_state *state);
/* Renders the scene and runs daft.draw over it; alpha interpolates between the last two ticks. False when the game has
 * failed. */
bool game_draw(game_state *state, daft_image *picture, float alpha);
/* The first half of it: the scene alone. */
bool game_render(game_state *state, daft_image *picture, float alpha);
/* Shows the scene as game_render would draw it to someone else, who draws something of it. False when the game has
 * failed, or with the error that `look` gave. */
bool game_show(game_state *state, float alpha, bool (*look)(void *user, daft_scene *, const daft_view *, daft_error *),
               void *user, daft_error *error);
/* The second: runs daft.draw over the picture. */
bool game_draw_over(game_state *state, daft_image *picture);
uint64_t game_hash(const game_state *state);
/* True while the recording has ticks left. */
bool game_is_replaying(const game_state *state);

#endif
