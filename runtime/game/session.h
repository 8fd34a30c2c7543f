/* session: plays one game on a platform: the loop with its clock, what the program's own keys do (Esc, F1, F12, R), the
 * picture's size, recordings, hashes, pictures to files, and figures. The same code runs with and without a window. */
#ifndef RUNTIME_GAME_SESSION_H
#define RUNTIME_GAME_SESSION_H

#include "game/game.h"
#include "platform/platform.h"
#include "common/progress.h"
#include "common/stats.h"

typedef struct session_def {
    platform *screen;
    daft_engine *engine;
    const home *where;
    font *face;
    daft_quality quality;
    double scale;    /* pixels of the picture to pixels of the window */
    bool fixed_size; /* the picture is as large as the window, however large that is */
    uint64_t seed;
    uint64_t ticks;              /* end after so many; 0: the recording's end, or never */
    bool hash;                   /* print a line every 60 ticks and at the end */
    bool every_frame;            /* draw each frame, though nobody looks */
    bool progress;               /* a bar on stderr */
    const char *record, *replay; /* files, or NULL */
    const char *shot;            /* a picture's file, or NULL */
    uint64_t shot_tick;          /* after so many ticks; 0: at the end */
    const char *stats;           /* figures as JSON, or NULL */
} session_def;

typedef enum session_end {
    SESSION_DONE,   /* the ticks or the recording came to their end, or the game quit */
    SESSION_LEFT,   /* Esc */
    SESSION_CLOSED, /* the window was closed */
    SESSION_FAILED  /* *error, or the script's message on stderr when error->code is DAFT_OK */
} session_end;

session_end session_play(const session_def *def, const game_info *info, daft_error *error);

/* The size of the picture for a window: scaled, and never more than 1920 by 1080 pixels unless that is asked for. */
void session_picture_size(const session_def *def, int *width, int *height);
/* Makes *picture that large, unless it is already. */
bool session_fit_picture(const session_def *def, daft_image **picture, daft_error *error);
/* The platform's mouse position as HUD units. */
void session_scale_mouse(platform *screen, input_event *event);

#endif
