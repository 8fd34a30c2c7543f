/* viewer: the state of the window. */
#ifndef RUNTIME_VIEW_VIEWER_H
#define RUNTIME_VIEW_VIEWER_H

#include "view/picture/content.h"
#include "view/picture/draw.h"
#include "view/fly.h"
#include "job/job.h"
#include "view/keys.h"
#include "view/picture/refine.h"
#include "view/route.h"
#include "view/screen.h"
#include "view/view.h"

enum { VIEW_TEXT = 700 };

typedef struct viewer {
    const view_def *def;
    content content;
    flight flight;
    picture_place place; /* of a picture */
    view_look look;
    bool plan, keys, leaves;
    bool changed; /* the picture is to be drawn again */
    bool repaint; /* only what stands over it */
    bool rests;   /* there was nothing to do in this turn */
    input input;
    platform_event early[16]; /* taken while the picture was refined */
    size_t early_count;
    /* The mouse, in fractions of the window. */
    double mouse_x, mouse_y, press_x, press_y;
    bool drags;       /* a button is held and the mouse has moved far enough for that */
    bool hit;         /* the cursor has hit something: */
    daft_dvec3 point; /* in the world */
    char found[VIEW_TEXT], notice[VIEW_TEXT];
    bool notice_bad;
    uint64_t notice_until, checked_ns, now_ns, moved_ns;
    uint64_t seen_stamp; /* of the file, at the last look */
    daft_image *picture, *shown;
    route route;
    job *job; /* a snapshot or a film that is being made, or NULL */
    uint64_t job_shown_ns;
    int make_size; /* of snapshots and films: the choice of make.c */
    daft_pace pace;
    pixel_channels channels;
    refinement refinement;
    double frame_ms;        /* of pictures while moving, smoothed */
    daft_counters counters; /* of the last picture while moving */
} viewer;

void viewer_say(viewer *v, bool bad, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Whether an event has come; it is kept for the next turn. */
bool viewer_is_asked(void *viewer);
double viewer_aspect(const viewer *v); /* height of the window / width */

/* What lies under the cursor, into v->found (pick.c). */
void pick(viewer *v);
/* The point of a scene under the cursor. */
bool pick_point(viewer *v, daft_ray_hit *hit);

/* Snapshots and films (make.c). */
void make_start(viewer *v, bool film);
void make_change_size(viewer *v);
void make_change_pace(viewer *v);
void make_watch(viewer *v);
void make_describe(const viewer *v, char out[VIEW_TEXT]);
void make_leave(viewer *v);

/* Where a point of the world is in the picture, as fractions from the top left. False: outside (show.c). */
bool viewer_project(const viewer *v, daft_dvec3 point, float *x, float *y);
/* Draws what has changed, or refines the picture, and shows it (show.c). */
bool show(viewer *v, daft_error *error);

#endif
