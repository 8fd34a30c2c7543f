/* bands: one picture that several processes draw, in bands of whole rows. */
#ifndef RUNTIME_MANY_BANDS_H
#define RUNTIME_MANY_BANDS_H

#include "many/many.h"

/* Draws the view of the scene, which is the same in all processes, as is the size of their targets. In process 0 the
 * target and view->aov then hold the whole picture, or it is false with the message; in the others it is true once they
 * are no longer needed. Calls view->progress in process 0. */
bool bands_render(many *all, daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error);

#endif
