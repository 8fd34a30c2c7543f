/* An engine, a scene and a picture of it in bytes, which a test fills and draws. stage.h is the one that keeps light,
 * depths and normals, too. */
#ifndef TESTS_PICTURE_STAGE_H
#define TESTS_PICTURE_STAGE_H

#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view; /* daft_default_view: the test places the camera */
} stage;

static inline stage stage_open(const daft_engine_def *def, int width, int height)
{
    stage s;
    daft_error error = {0};
    s.engine = daft_engine_create(def, &error);
    if (!s.engine) fail_msg("%s", error.message);
    s.scene = daft_scene_create(s.engine, &error);
    s.image = daft_image_create(s.engine, width, height, &error);
    assert_true(s.scene && s.image);
    s.view = daft_default_view();
    return s;
}

static inline void stage_free(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
}

/* rgba: 4 bytes a pixel, or NULL. */
static inline const daft_counters *draw(stage *s, uint8_t *rgba)
{
    daft_error error = {0};
    if (!daft_render(s->scene, &s->view, s->image, &error)) fail_msg("%s", error.message);
    const size_t pixels = (size_t)daft_image_width(s->image) * (size_t)daft_image_height(s->image);
    if (rgba) memcpy(rgba, daft_image_pixels(s->image), 4 * pixels);
    return daft_scene_counters(s->scene);
}

#endif
