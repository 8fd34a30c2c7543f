/* draw: a picture of the content: shaded, or a channel of it in colours, with or without edges. */
#ifndef RUNTIME_VIEW_PICTURE_DRAW_H
#define RUNTIME_VIEW_PICTURE_DRAW_H

#include "common/quality.h"
#include "view/picture/content.h"

typedef enum view_channel {
    VIEW_PICTURE,
    VIEW_DEPTH,
    VIEW_NORMAL,
    VIEW_ALBEDO,
    VIEW_ENTITY,
    VIEW_TRIANGLE,
    VIEW_MOTION,
    VIEW_COST
} view_channel;

/* Switches of the window beside DAFT_WITHOUT_…: knobs of the view. */
enum { VIEW_WITHOUT_SHADOWS = 1 << 16, VIEW_WITHOUT_MIRRORS = 1 << 17 };

/* What is drawn, and how. */
typedef struct view_look {
    daft_camera camera;
    quality_wish quality;
    uint32_t without; /* DAFT_WITHOUT_… and VIEW_WITHOUT_… */
    view_channel channel;
    bool wires;
} view_look;

/* What a pixel sees, for channels and edges; arrays as large as the picture. All zero: none yet. */
typedef struct pixel_channels {
    int width, height;
    daft_aov arrays;
    daft_history *history; /* of the pictures that were shown */
} pixel_channels;

/* Camera, knobs and what is left out. `scene` NULL: one that asks for no quality. */
void draw_set_view(const view_look *look, const daft_scene *scene, daft_view *view);
bool draw_scene(daft_scene *scene, const view_look *look, pixel_channels *channels, daft_image *target,
                daft_error *error);
void draw_free(pixel_channels *channels);

/* Where a picture lies in the window: pixels of the window to one of the picture, and the picture's point that is in
 * the middle, as fractions of its sides. */
typedef struct picture_place {
    double zoom, x, y;
} picture_place;

/* All of it in the middle, never enlarged. */
picture_place draw_fit(const daft_image *picture, int width, int height);
void draw_picture(const daft_image *picture, const picture_place *place, daft_image *target);

#endif
