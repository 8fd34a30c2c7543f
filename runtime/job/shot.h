/* shot: what a snapshot was taken of, and how: a JSON file beside the picture, from which daft render repeats it. */
#ifndef RUNTIME_JOB_SHOT_H
#define RUNTIME_JOB_SHOT_H

#include "common/util.h"

typedef struct shot {
    char scene[PATH_SIZE]; /* .scene or .obj */
    int width, height;
    daft_view view;
} shot;

/* A relative name of the scene is meant from the folder of the JSON file. */
bool shot_write(const shot *self, const char *path, daft_error *error);
bool shot_read(shot *out, const char *path, daft_error *error);

#endif
