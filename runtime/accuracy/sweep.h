/* sweep: one picture drawn with many settings: what each takes, and how far it is from the reference.
 *
 * First each knob with the rest at the preset, then all together: the grid of those knobs that change the picture, of
 * which knobs with the smallest effect are left out until the grid is small enough. Settings take turns, so that a
 * machine that slows down slows all of them. */
#ifndef RUNTIME_ACCURACY_SWEEP_H
#define RUNTIME_ACCURACY_SWEEP_H

#include "accuracy/knobs.h"
#include "accuracy/metrics.h"

enum { SWEEP_ROUNDS = 15, SWEEP_POINTS = 128, SETTING_TEXT = 160 };

typedef struct sweep_point {
    const char *knob; /* "quality", a knob's name, or "all" */
    char setting[SETTING_TEXT];
    knob_set set;
    double times[SWEEP_ROUNDS]; /* milliseconds */
    int rounds;
    double ms, spread; /* median; half of the distance between the quartiles, of the extremes below four rounds */
    picture_errors errors;
    double half_flip[2]; /* mean FLIP against each half of the reference */
    uint8_t *pixels;     /* RGBA at the shown size */
    uint64_t picture;    /* their hash */
    int same_as;         /* the setting that has the same picture and equal times, and speaks for this one; -1: none */
    int beaten_by;       /* the setting that is better on one axis and not worse on the other, beyond noise; -1: none */
    bool on_front;       /* neither of these */
} sweep_point;

typedef struct sweep_def {
    daft_engine *engine;
    daft_scene *scene;
    daft_view view; /* camera, alpha and quality: the preset */
    int width, height;
    double seconds; /* of wall time that all of it may take */
    bool quick;     /* a smaller grid and a smaller reference */
} sweep_def;

typedef struct sweep_result {
    sweep_def def;
    sweep_point *points;
    size_t count;
    size_t dropped;                 /* settings that there was no time for */
    double ray_seconds;             /* of one picture of the preset by camera rays one by one */
    size_t preset;                  /* the point that is the preset itself */
    uint8_t *reference, *halves[2]; /* RGBA at the shown size */
    int reference_samples[2];       /* per pixel, of each half */
    picture_errors floor;           /* the reference's halves against each other */
    uint64_t began_ns;
    daft_image *targets[4]; /* that settings draw to, one of each size */
    double seen_from;       /* x of the last timed picture's camera, metres */
} sweep_result;

/* On failure nothing is left to free. */
bool sweep_run(sweep_result *self, const sweep_def *def, daft_error *error);
void sweep_free(sweep_result *self);
/* Sums up the times of the points, and says which are the same, beaten, and on the front. */
void sweep_judge(sweep_result *self);
/* Pixels of a side that a setting draws. */
int sweep_side(int side, double scale);
/* Whether all settings draw the same picture. */
bool sweep_all_same(const sweep_result *self);
/* The point with the smallest FLIP whose median and spread lie within the budget; -1: none. */
int sweep_choose(const sweep_result *self, double budget_ms);
/* Whether the spreads of two points overlap. */
bool sweep_equal_times(const sweep_point *a, const sweep_point *b);

#endif
