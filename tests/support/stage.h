/* A small picture of a scene that a test fills: its light, depths and normals. */
#ifndef TESTS_STAGE_H
#define TESTS_STAGE_H

#include "daft.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 200, HEIGHT = 136, PIXELS = WIDTH * HEIGHT };

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    daft_vec3 color[PIXELS];
    float depth[PIXELS];
    daft_vec3 normal[PIXELS];
} stage;

static inline stage *stage_make_with(const daft_engine_def *given)
{
    stage *s = calloc(1, sizeof *s);
    assert_non_null(s);
    daft_engine_def def = *given;
    daft_error error = {0};
    assert_non_null(s->engine = daft_engine_create(&def, &error));
    assert_non_null(s->scene = daft_scene_create(s->engine, &error));
    assert_non_null(s->image = daft_image_create(s->engine, WIDTH, HEIGHT, &error));
    s->view = daft_default_view();
    s->view.aov = (daft_aov){.color = s->color, .depth = s->depth, .normal = s->normal};
    return s;
}

static inline stage *stage_make(int threads, const char *isa)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads, def.isa = isa;
    return stage_make_with(&def);
}

static inline void stage_drop(stage *s)
{
    daft_history_destroy(s->view.history);
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

static inline const daft_counters *draw(stage *s)
{
    daft_error error = {0};
    if (!daft_render(s->scene, &s->view, s->image, &error)) fail_msg("%s", error.message);
    return daft_scene_counters(s->scene);
}

static inline double distance(const daft_vec3 *a, const daft_vec3 *b)
{
    double sum = 0;
    for (int i = 0; i < PIXELS; i++) {
        const float u[3] = {a[i].x, a[i].y, a[i].z}, v[3] = {b[i].x, b[i].y, b[i].z};
        for (int c = 0; c < 3; c++) {
            const double gap = fmin(1, (double)u[c]) - fmin(1, (double)v[c]);
            sum += gap * gap;
        }
    }
    return sqrt(sum / (3 * PIXELS));
}

#endif
