/* film_scene: the pictures of a scene, seen by the camera of its path, or by one that stands. */
#ifndef RUNTIME_VIDEO_FILM_SCENE_H
#define RUNTIME_VIDEO_FILM_SCENE_H

#include "common/quality.h"
#include "video/source.h"

typedef struct film_scene {
    frame_source source;
    daft_scene *scene;
    daft_view view;
    daft_checkpoint *points; /* of the path */
    uint32_t count;          /* 0: the camera stands */
    daft_pace pace;
    double seconds; /* of the path */
} film_scene;

typedef struct film_scene_def {
    daft_engine *engine;
    const char *path;
    long camera; /* of the file's cameras, from 0; below 0: the path, or the first where there is none */
    daft_pace pace;
    quality_wish quality;
} film_scene_def;

/* Loads the file. On failure nothing is left open. */
bool film_scene_open(film_scene *self, const film_scene_def *def, daft_error *error);
void film_scene_close(film_scene *self);

#endif
