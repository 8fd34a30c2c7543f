/* probe: what other settings would cost and change in the frame at hand.
 *
 * A measure draws the frame twice more, by the quality at hand and by another setting, and compares a few tiles of the
 * two, other ones each time. (Bands of the picture would take less, but antialiasing and denoising draw the rows around
 * a band, too: their prices would be wrong.) What counts is the latest measures of each setting: the figures follow the
 * game. Promises: the scene stays as it is, and so does what the next picture may reuse. */
#ifndef RUNTIME_ACCURACY_PROBE_H
#define RUNTIME_ACCURACY_PROBE_H

#include "accuracy/knobs.h"

/* Measures of a setting that count; sides of the window, in pixels. */
enum { PROBE_MEASURES = 16, PROBE_WIDTH = 192, PROBE_HEIGHT = 32 };

typedef struct probe_figure {
    const char *setting;          /* as --knobs takes it; NULL: there is none */
    float ms[PROBE_MEASURES];     /* of a whole frame, beyond that of the quality at hand */
    float change[PROBE_MEASURES]; /* mean FLIP of the window: how differently it looks */
    uint32_t count;               /* measures since the quality at hand was chosen */
} probe_figure;

typedef struct probe_row {
    const knob_row *knob;
    const char *now; /* its setting at hand; NULL: none of the knob's */
    probe_figure cheaper, better;
} probe_row;

typedef struct probe {
    daft_engine *engine;
    daft_image *now, *other;
    daft_quality quality; /* at hand */
    probe_row rows[KNOBS];
    uint32_t turn;
} probe;

/* Nothing is allocated before the first step. */
void probe_begin(probe *self, daft_engine *engine);
void probe_end(probe *self);
/* One measure, of the next setting in turn, of a picture of that size. Another quality than before begins anew. */
bool probe_step(probe *self, daft_scene *scene, const daft_view *view, int width, int height, daft_error *error);
/* The mean of the middle half of what counts, its uncertainty (the standard error), and the mean change. False: it has
 * not been measured yet. */
bool probe_sum(const probe_figure *figure, double *ms, double *uncertain, double *change);
/* Mean FLIP between a window of two pictures of one size, PROBE_WIDTH by PROBE_HEIGHT pixels from the row `top` on. */
bool probe_compare(const daft_image *a, const daft_image *b, int top, uint32_t turn, double *change, daft_error *error);
/* The row of tiles, of so many, that a turn looks at: in the long run each as often as the others. */
int probe_row_of(uint32_t turn, int rows);

#endif
