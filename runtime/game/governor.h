/* The governor: keeps the frames of a game under a time by what their pictures cost, never by the game itself.
 *
 * It stands on one of a few rungs, each a set of knobs. Those that it climbs are its ladder: at first a usual one, and
 * once the rungs have been surveyed (session/survey.c) their front, the rungs of which none that is cheaper comes
 * closer to the reference. The work of each frame goes in; where too many are over the time it steps down, to the first
 * rung that is expected to keep it, and where the next rung is expected to keep it with room to spare, it steps up.
 * What a rung costs beside the next it learns from the frames before and after each change; all these figures may be
 * kept for the next time. Promises: at most one change a second; reads no clock, so the same figures give the same
 * rungs. */
#ifndef RUNTIME_GAME_GOVERNOR_H
#define RUNTIME_GAME_GOVERNOR_H

#include "daft.h"

enum { GOVERNOR_RUNGS = 14, GOVERNOR_FRAMES = 60 };

/* Knobs of a rung; the rest is the quality's. Rungs below the quality's own lower them, those above raise them. */
typedef struct governor_rung {
    const char *name;
    double scale;     /* sides of the picture, relative to what is shown */
    int edge_samples; /* as in daft_quality */
    int mirror_depth;
    bool sampled;        /* soft shadows, ambient occlusion and rough mirrors */
    bool sharp;          /* textures that are blurred at a flat angle otherwise */
    float edge_contrast; /* of the sixteen samples that it adds; 0: it adds none */
} governor_rung;

/* What is known of the rungs. */
typedef struct governor_costs {
    double cost[GOVERNOR_RUNGS];  /* of a frame, relative to that of the quality itself */
    double error[GOVERNOR_RUNGS]; /* mean FLIP against a better picture; NAN: not surveyed */
} governor_costs;

typedef struct governor {
    double target_ms;
    int rung;
    governor_costs known;
    int ladder[GOVERNOR_RUNGS], rungs; /* the rungs that it climbs, cheapest first, and how many they are */
    const char *why;                   /* of the last change, for people */
    uint64_t changes;
    /* inner: */
    double recent[GOVERNOR_FRAMES]; /* milliseconds of the frames on this rung, the latest at `frames` - 1 */
    uint64_t frames;                /* on this rung */
    double since_ms;                /* since the last change */
    double hold_ms;                 /* after which it may step up again */
    double before_ms;               /* a frame's on the rung before, until it is known what the change did; else 0 */
    int before;                     /* that rung */
} governor;

const governor_rung *governor_rung_at(int rung);
/* The rung that draws just what the quality says. */
int governor_full(void);
/* `costs`: of an earlier time, or NULL. Begins on the rung of the quality itself. */
void governor_begin(governor *g, double target_ms, const governor_costs *costs);
/* Whether all rungs have been surveyed. */
bool governor_is_surveyed(const governor *g);
/* The costs and errors of all rungs, measured: the ladder is their front from here on. */
void governor_survey(governor *g, const governor_costs *costs);
/* After each frame: what it took to update and draw, and the time since the frame before. True: another rung. */
bool governor_frame(governor *g, double work_ms, double turn_ms);
/* The 95th percentile of the last frames on this rung, at most GOVERNOR_FRAMES, but for those that are slow for another
 * reason than their picture; 0 before the first. */
double governor_slow_ms(const governor *g);
/* The quality's knobs as on a rung. */
void governor_set(int rung, daft_quality *quality);
/* Lowers the view's knobs to the rung's, or raises them above the quality itself; leaves them where `g` is NULL. */
void governor_apply(const governor *g, daft_view *view);

#endif
