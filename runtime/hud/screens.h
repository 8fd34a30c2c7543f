/* screens: the error screen, and the overlay with frame times (F1). */
#ifndef RUNTIME_HUD_SCREENS_H
#define RUNTIME_HUD_SCREENS_H

#include "hud/canvas.h"

/* Why a game has stopped. Texts of lines; those but the first two may be empty. */
typedef struct error_report {
    const char *game, *message;
    const char *source; /* the line that failed begins with '>' */
    const char *trace;
    const char *values;
    const char *keys; /* what the player may press */
} error_report;

/* Darkens the picture and draws all of it: message, source, then stack and values side by side. */
void screen_error(const canvas *target, font *face, const error_report *report);

/* A line or some over the lower edge. `wrong`: of a mistake. */
void screen_notice(const canvas *target, font *face, const char *text, bool wrong);

typedef struct overlay_figures {
    double frames_per_second, frame_ms, update_ms;
    uint64_t dropped; /* updates dropped since the start */
    const daft_counters *counters;
    daft_sim_counters simulation; /* of the last tick */
    daft_memory memory;
    const char *quality; /* what keeps frames in time, and why; or NULL */
    double slow_ms;      /* the 95th percentile of frames, with it */
} overlay_figures;

void screen_overlay(const canvas *target, font *face, const overlay_figures *figures);

#endif
