/* refine: the picture at quality `reference`, a few rows at a time, while nothing moves. */
#ifndef RUNTIME_VIEW_PICTURE_REFINE_H
#define RUNTIME_VIEW_PICTURE_REFINE_H

#include "view/picture/draw.h"

/* Whether the user wants something, so that a piece of work should be dropped. */
typedef bool refine_asked(void *user);

typedef struct refinement {
    int pass;             /* quality high, then reference */
    int row;              /* the next one to be drawn; the picture's height: done */
    int rows;             /* in one go, a multiple of 32 */
    double squares, sums; /* of differences to the picture before, and how many */
    daft_image *fine;     /* of the picture's size, or NULL */
} refinement;

/* From the top again: the picture has changed. */
void refine_restart(refinement *r);
typedef struct refine_job {
    daft_engine *engine;
    daft_scene *scene;
    const view_look *look;
    daft_image *picture;
    refine_asked *asked; /* looked at between tiles */
    void *user;
} refine_job;

/* Draws the next rows into the picture, about 15 ms' worth. False with error->code DAFT_OK: all is done, or somebody
 * has asked for something else. */
bool refine_step(refinement *r, const refine_job *job, daft_error *error);
bool refine_is_done(const refinement *r);
daft_preset refine_quality(const refinement *r); /* of the pass that is drawn */
/* How far the whole picture still is from the one that this pass draws: root of the mean square over pixels, 0..1 of
 * white in sRGB. The rows that are done are exact; of the others it is taken that they are as wrong as those were.
 * Below 0: not known. */
double refine_error(const refinement *r, int height);
void refine_free(refinement *r);

#endif
