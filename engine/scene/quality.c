/* What a scene asks of those who draw it, and pictures that are drawn smaller than they are shown. */
#include "scene/scene.h"

#include <math.h>
#include <string.h>

bool daft_scene_set_quality(daft_scene *scene, const daft_quality *quality, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_struct_check(DAFT_STRUCT_QUALITY, quality, error)) return false;
    scene->quality = *quality;
    return true;
}

daft_quality daft_scene_quality(const daft_scene *scene)
{
    return scene ? scene->quality : daft_preset_quality(DAFT_PRESET_GAME);
}

static int side(int shown, float scale)
{
    const int drawn = (int)floor((double)shown * (double)scale + 0.5);
    return drawn < 1 ? 1 : drawn;
}

/* Makes room for `bytes` in scene->scratch. */
static bool need_scratch(daft_scene *scene, size_t bytes, daft_error *error)
{
    if (bytes <= scene->scratch_size) return true;
    daft_release(scene->allocator, scene->scratch);
    scene->scratch = daft_alloc(scene->allocator, bytes, 1);
    scene->scratch_size = scene->scratch ? bytes : 0;
    return scene->scratch || daft_fail_memory(error, "enlarging a picture");
}

/* The image of that size that is drawn to; kept, since the next picture mostly has the same. */
static daft_image *small_of(daft_scene *scene, int width, int height, daft_error *error)
{
    daft_image *small = scene->small;
    if (small && small->width == width && small->height == height) return small;
    if (small) daft_image_destroy(small);
    return scene->small = daft_image_create(scene->engine, width, height, error);
}

bool daft_render_small(daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error)
{
    const float scale = view->quality.scale;
    const int width = side(target->width, scale), height = side(target->height, scale);
    const daft_aov none = {0};
    if (memcmp(&view->aov, &none, sizeof none) != 0 || view->first_row != 0 || view->row_count != 0)
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "quality.scale is %g; it must be 1 where a view has channels or is a band of the picture",
                         (double)scale);
    daft_view inner = *view;
    inner.quality.scale = 1;
    daft_image *small = small_of(scene, width, height, error);
    if (!small || !need_scratch(scene, daft_image_enlarge_bytes(small, target, scene->engine->threads), error))
        return false;
    target->drawing = true;
    const bool drawn = daft_render(scene, &inner, small, error);
    target->drawing = false;
    if (drawn)
        daft_image_enlarge(small, target, view->quality.upscale, scene->scratch, scene->engine->threads,
                           scene->engine->isa);
    return drawn;
}

void daft_scaled_free(daft_scene *scene)
{
    if (scene->small) daft_image_destroy(scene->small);
    daft_release(scene->allocator, scene->scratch);
}
