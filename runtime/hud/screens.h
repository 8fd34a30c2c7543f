/* screens: the error screen, and the overlay with frame times (F1). */
#ifndef RUNTIME_HUD_SCREENS_H
#define RUNTIME_HUD_SCREENS_H

#include "hud/canvas.h"

/* Darkens the picture and draws title, message, stack trace and the keys that help. */
void screen_error(const canvas *target, font *face, const char *game, const char *message, const char *trace);

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
