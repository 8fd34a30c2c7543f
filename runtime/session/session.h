/* session: plays one game on a platform: the loop with its clock, what the program's own keys do (Esc, F1, F3, F5,
 * F6, F12; R, C and E where a script has failed), the picture's size, recordings, hashes, pictures to files, and
 * figures. The same code runs with and without a window. Promises: Esc and the window's close button work at any time,
 * also while a callback does not come back; whatever ends the program early, the recording is saved up to the tick that
 * had begun. Public headers: session.h menu.h costs.h. */
#ifndef RUNTIME_SESSION_H
#define RUNTIME_SESSION_H

#include "game/game.h"
#include "platform/editor.h"
#include "platform/platform.h"
#include "common/progress.h"
#include "common/stats.h"

typedef struct session_def {
    platform *screen;
    daft_engine *engine;
    const home *where;
    const game_source *source; /* the game's files; NULL: the session opens them */
    font *face;
    quality_wish quality;
    double scale;     /* resolution of the picture relative to the window */
    double target_ms; /* that a frame may take, by pictures that cost less; 0: any; below 0: as the game says, or 1/60 s
                       */
    const char *saves; /* folder of what games keep, or NULL: nothing outlasts the session */
    const char *costs; /* folder that remembers what pictures cost, or NULL */
    bool fixed_size;   /* the picture has exactly the size of the window */
    uint64_t seed;
    uint64_t ticks;              /* end after so many; 0: the recording's end, or never */
    bool hash;                   /* print a line every 60 ticks and at the end */
    bool every_frame;            /* draw every frame when headless too */
    bool progress;               /* a bar on stderr */
    const char *record, *replay; /* files, or NULL */
    bool strict;                 /* a replay of a changed game, or one that does not do what was recorded, fails */
    double speed;                /* of a replay: 1 is the recorded one, INFINITY as fast as it goes; 0: not said */
    bool replay_inside;          /* the replay is one of the game's files, not of the user's */
    const char *shot;            /* file of a picture, or NULL */
    uint64_t shot_tick;          /* after so many ticks; 0: at the end */
    const char *stats;           /* file for times and counters as JSON, or NULL */
    const char *trace;           /* file of what took how long (common/trace.h), or NULL */
    const char *profile;         /* file for a table of the lines of Lua that take the time, or NULL */
    const char *sound;           /* WAV file of all that sounds, or NULL */
    bool speaks;                 /* through the loudspeaker */
    double seconds;              /* one call into the game may take; 0: WATCHDOG_SECONDS */
    bool stays;                  /* the window stays after the session: for a menu */
    bool pauses;                 /* Esc opens the pause menu; else it leaves */
    bool watches;                /* files of the game that are saved take effect while it runs */
    const char *settings;        /* folder of the player's settings, or NULL */
    editor *editor;              /* for E on the error screen, or NULL */
} session_def;

typedef enum session_end {
    SESSION_DONE,   /* ticks or recording ended, or the game quit */
    SESSION_LEFT,   /* Esc */
    SESSION_CLOSED, /* the window was closed */
    SESSION_FAILED  /* *error, or the script's message on stderr when error->code is DAFT_OK */
} session_end;

session_end session_play(const session_def *def, const game_info *info, daft_error *error);

/* The size of the picture for the window: scaled, at most 1920x1080 unless fixed_size is set. */
void session_picture_size(const session_def *def, int *width, int *height);
/* Replaces *picture when its size differs from that. */
bool session_fit_picture(const session_def *def, daft_image **picture, daft_error *error);
/* Converts the platform's mouse position to HUD units. */
void session_scale_mouse(platform *screen, input_event *event);

#endif
