/* The pictures of a scene. */
#include "video/film_scene.h"

#include "common/util.h"

static frame_result draw(frame_source *source, double time, bool wanted, daft_image *target, daft_error *error)
{
    film_scene *self = (film_scene *)source;
    (void)time;
    return !wanted || daft_render(self->scene, &self->view, target, error) ? FRAME_DRAWN : FRAME_FAILED;
}

static bool load(film_scene *self, const char *path, uint32_t camera, daft_error *error)
{
    if (!daft_scene_load(self->scene, path, error)) return false;
    uint32_t count = daft_scene_camera_count(self->scene);
    if (camera < count) return daft_scene_get_camera(self->scene, camera, &self->view.camera, error);
    if (camera == 0) return true;
    return fail(error, DAFT_ERROR_ARGUMENT, "--camera %u: %s has %u camera%s, counted from 0", camera, path, count,
                count == 1 ? "" : "s");
}

bool film_scene_open(film_scene *self, daft_engine *engine, const char *path, uint32_t camera, daft_quality quality,
                     daft_error *error)
{
    *self = (film_scene){.source.draw = draw, .view = daft_default_view()};
    self->view.quality = quality;
    self->scene = daft_scene_create(engine, error);
    if (self->scene && load(self, path, camera, error)) return true;
    film_scene_close(self);
    return false;
}

void film_scene_close(film_scene *self) { daft_scene_destroy(self->scene); }
