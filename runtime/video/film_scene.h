/* film_scene: the pictures of a scene, seen by a camera that stands. */
#ifndef RUNTIME_VIDEO_FILM_SCENE_H
#define RUNTIME_VIDEO_FILM_SCENE_H

#include "video/source.h"

typedef struct film_scene {
    frame_source source;
    daft_scene *scene;
    daft_view view;
} film_scene;

/* Loads the file; `camera` counts its cameras from 0. On failure nothing is left open. */
bool film_scene_open(film_scene *self, daft_engine *engine, const char *path, uint32_t camera, daft_quality quality,
                     daft_error *error);
void film_scene_close(film_scene *self);

#endif
