/* picture: what the window shows: the file (content.h), a picture of it (draw.h), a finer one row by row (refine.h).
 * Public headers: content.h draw.h refine.h
 *
 * content: the file that is shown, and when it has changed on the disk. */
#ifndef RUNTIME_VIEW_PICTURE_CONTENT_H
#define RUNTIME_VIEW_PICTURE_CONTENT_H

#include "common/util.h"

typedef struct content {
    char path[PATH_SIZE];
    daft_scene *scene;    /* of a .scene or a mesh */
    daft_image *image;    /* of a picture; one of the two is NULL */
    daft_camera start;    /* the file's */
    daft_dvec3 low, high; /* of what is drawn; both 0 where there is nothing */
    double size;          /* metres from corner to corner; 0: nothing is drawn */
    uint64_t stamp;       /* of the file and its neighbours, as they were loaded */
} content;

/* camera: of the file's, from 0; below 0: the first. aspect: height of the window / width. On failure *out is not set.
 */
bool content_open(content *out, daft_engine *engine, const char *path, long camera, double aspect, daft_error *error);
void content_close(content *c);
/* A number that changes when the file does, or one that it names: an included scene, a mesh, a material, a picture. */
uint64_t content_stamp(const content *c);

#endif
