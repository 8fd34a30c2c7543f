/* The pictures of a scene. */
#include "video/film_scene.h"

#include "common/util.h"

#include <stdlib.h>

static frame_result draw(frame_source *source, double time, bool wanted, daft_image *target, daft_error *error)
{
    film_scene *self = (film_scene *)source;
    if (!wanted) return FRAME_DRAWN;
    if (self->count > 0 && !daft_path_camera(self->points, self->count, self->pace, time, &self->view.camera, error))
        return FRAME_FAILED;
    return daft_render(self->scene, &self->view, target, error) ? FRAME_DRAWN : FRAME_FAILED;
}

static bool take_path(film_scene *self, daft_error *error)
{
    self->count = daft_scene_path_count(self->scene);
    self->points = calloc(self->count, sizeof *self->points);
    if (!self->points) return fail(error, DAFT_ERROR_MEMORY, "out of memory for the camera path");
    for (uint32_t i = 0; i < self->count; i++)
        if (!daft_scene_get_checkpoint(self->scene, i, &self->points[i], error)) return false;
    self->seconds = self->points[self->count - 1].time;
    return true;
}

static bool load(film_scene *self, const film_scene_def *def, daft_error *error)
{
    if (!daft_scene_load(self->scene, def->path, error)) return false;
    if (def->camera < 0 && daft_scene_path_count(self->scene) > 0) return take_path(self, error);
    uint32_t count = daft_scene_camera_count(self->scene), camera = def->camera < 0 ? 0 : (uint32_t)def->camera;
    if (camera < count) return daft_scene_get_camera(self->scene, camera, &self->view.camera, error);
    if (camera == 0) return true;
    return fail(error, DAFT_ERROR_ARGUMENT, "--camera %u: %s has %u camera%s, counted from 0", camera, def->path, count,
                count == 1 ? "" : "s");
}

bool film_scene_open(film_scene *self, const film_scene_def *def, daft_error *error)
{
    *self = (film_scene){.source = {.draw = draw, .any_order = true}, .view = daft_default_view(), .pace = def->pace};
    self->scene = daft_scene_create(def->engine, error);
    if (self->scene && load(self, def, error)) {
        self->view.quality = quality_choose(&def->quality, self->scene);
        return true;
    }
    film_scene_close(self);
    return false;
}

void film_scene_close(film_scene *self)
{
    daft_scene_destroy(self->scene);
    free(self->points);
}
