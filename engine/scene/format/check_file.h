/* The parts of daft_check_file. */
#ifndef DAFT_CHECK_FILE_H
#define DAFT_CHECK_FILE_H

#include "scene/scene.h"

/* A .scene file and the meshes that it names. False: not the file's fault, see *error. */
bool daft_check_scene(daft_engine *engine, const char *path, const daft_problems *problems, daft_error *error);

#endif
