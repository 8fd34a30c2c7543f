/* sweep: pictures drawn with many settings: what each takes, and how far it is from the reference.
 *
 * First each knob with the rest at the preset, then all together: the grid of those knobs that change the picture, of
 * which knobs with the smallest effect are left out until the grid is small enough. Settings take turns, so that a
 * machine that slows down slows all of them. A game is measured at several moments of its demo; its figures are means
 * over them. */
#ifndef RUNTIME_ACCURACY_SWEEP_H
#define RUNTIME_ACCURACY_SWEEP_H

#include "accuracy/knobs.h"
#include "accuracy/metrics.h"

enum { SWEEP_ROUNDS = 15, SWEEP_POINTS = 128, SWEEP_MOMENTS = 4, SETTING_TEXT = 240 };

/* Of a setting, at one moment. */
typedef struct sweep_measure {
    double times[SWEEP_ROUNDS]; /* milliseconds */
    int rounds;
    double ms; /* their median, without what slowed all settings of a round alike */
    picture_errors errors;
    double half_flip[2]; /* mean FLIP against each half of the reference */
    double temporal;     /* how differently it changes from one tick to the next: see sweep_point */
    uint64_t picture;    /* hash of its bytes */
} sweep_measure;

typedef struct sweep_point {
    const char *knob; /* "quality", a knob's name, or "all" */
    char setting[SETTING_TEXT];
    daft_quality quality;
    sweep_measure at[SWEEP_MOMENTS];
    /* Means over the moments, the worst tile of all: */
    double ms, spread; /* of a moment: median; half of the distance between the quartiles, of the extremes below four
                          rounds */
    double again_ms, again_spread; /* the same as ms and spread, by sweep_confirm; 0: it did not time this one */
    picture_errors errors;
    double half_flip[2];
    /* The mean over the pixels of |FLIP from one tick to the next - the same of the reference|: what flickers. */
    double temporal;
    uint64_t picture;
    uint8_t *pixels; /* RGBA at the shown size, of the moment that is shown */
    int same_as;     /* the setting that has the same pictures and equal times, and speaks for this one; -1: none */
    int beaten_by;   /* the setting that is better on one axis and not worse on the other, beyond noise; -1: none */
    bool on_front;   /* neither of these */
} sweep_point;

typedef struct sweep_def {
    daft_engine *engine;
    daft_scene *scene;
    daft_view view; /* of a scene: its camera; the quality is the preset's */
    daft_preset preset;
    const char *fixed; /* knobs that every picture has so, the reference too, "occlusion_samples=0"; checked; NULL: none
                        */
    int width, height;
    double seconds;       /* of wall time that all of it may take */
    bool quick;           /* a smaller grid and a smaller reference */
    const knob_row *knob; /* the only one to sweep, of the table or the user's own, without combinations; NULL: all */
    int moments;          /* of a game; 0: the scene stands */
    /* Takes the game to its next moment. */
    bool (*next)(void *user, daft_error *error);
    void *user;
} sweep_def;

/* Pixels that see something else than with exact visibility. */
typedef struct sweep_wrong {
    const char *setting;
    size_t count;
    uint8_t *mask; /* a byte a pixel */
} sweep_wrong;

enum { SWEEP_WRONG = 2 };

typedef struct sweep_result {
    sweep_def def;
    sweep_point *points;
    size_t count;
    int moments;                    /* measured; 1 for a scene */
    bool moved_on;                  /* the game stands at a moment for which there was no time */
    size_t dropped;                 /* settings that there was no time for */
    double ray_seconds;             /* of one picture of the preset by camera rays one by one */
    size_t preset;                  /* the point that is the preset itself */
    uint8_t *reference;             /* RGBA at the shown size, of the moment that is shown */
    int reference_samples[2];       /* per pixel, of each half, at the moment that had the fewest */
    picture_errors floor;           /* the reference's halves against each other, means over the moments */
    daft_counters counters;         /* of a picture of the preset at the moment that is shown */
    sweep_wrong wrong[SWEEP_WRONG]; /* at the moment that is shown */
    struct sweep_work *work;        /* while it runs */
} sweep_result;

/* On failure nothing is left to free. */
bool sweep_run(sweep_result *self, const sweep_def *def, daft_error *error);
void sweep_free(sweep_result *self);
/* Sums up the points over the moments, and says which are the same, beaten, and on the front. */
void sweep_judge(sweep_result *self);
/* Whether all settings draw the same picture. */
bool sweep_all_same(const sweep_result *self);
/* The point with the smallest FLIP whose median and spread lie within the budget; -1: none. Times are those of
 * sweep_confirm, where it took some. */
int sweep_choose(const sweep_result *self, double budget_ms);
/* confirm.c: times what the budget buys, and its neighbours on the front, again, until sweep_choose gives one that was
 * timed now; takes an eighth of def.seconds, and a few pictures of each further choice. For the time after sweep_run,
 * while engine and scene are as they were. Forgets what it found before. */
bool sweep_confirm(sweep_result *self, double budget_ms, daft_error *error);
/* Median of some times, which it sorts; spread as in sweep_point. */
double sweep_median(double *times, int count, double *spread);
/* Whether the spreads of two points overlap. */
bool sweep_equal_times(const sweep_point *a, const sweep_point *b);

/* wrong.c: marks the pixels that see another triangle than with exact visibility. mask: width·height bytes, 1 where
 * wrong. */
bool wrong_find(daft_engine *engine, daft_scene *scene, const daft_view *view, int width, int height, uint8_t *mask,
                size_t *count, daft_error *error);
/* Puts a red dot over each of them. */
void wrong_paint(const uint8_t *mask, int width, int height, uint8_t *pixels);

#endif
