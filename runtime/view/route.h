/* route: the checkpoints of a camera path, and their place in a .scene file. */
#ifndef RUNTIME_VIEW_ROUTE_H
#define RUNTIME_VIEW_ROUTE_H

#include "daft.h"

#include <stdio.h>

enum { ROUTE_POINTS = 1000 };

typedef struct route {
    daft_checkpoint *points; /* ROUTE_POINTS of them; NULL: none yet */
    uint32_t count;
    bool unsaved;
} route;

/* The scene's own. */
bool route_load(route *r, daft_scene *scene, daft_error *error);
/* After the last one, by as many seconds as the way there is long, at `speed` metres a second; at least half of one. */
bool route_add(route *r, const daft_camera *camera, double speed, daft_error *error);
void route_remove(route *r, uint32_t index);
/* Makes the way to the checkpoint longer by so many seconds, and all later ones later; at least a tenth of one is left.
 */
void route_delay(route *r, uint32_t index, double seconds);
/* Replaces the `path` items of the file, which stays as it is on failure. */
bool route_save(route *r, const daft_scene *scene, const char *path, daft_error *error);
/* The `path` items, a line each. */
void route_print(const route *r, FILE *out);
void route_free(route *r);

#endif
