/* What the tests of hard scenes share: a stage with a scene and a picture of any size, short makers for what stands on
 * it, and ways to compare two pictures. Everything goes through daft.h, as a user's program does. */
#ifndef DAFT_HARD_SCENES_H
#define DAFT_HARD_SCENES_H

#include "daft.h"

#include "base/base.h"
#include "math/simd/dispatch.h"
#include "math/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    int width, height, pixels;
    float *depth;
    daft_vec3 *normal;
    daft_entity *entity;
    uint32_t *triangle;
} stage;

__attribute__((unused)) static stage *stage_make(int width, int height, const char *isa, int threads)
{
    stage *s = calloc(1, sizeof *s);
    daft_error error = {0};
    daft_engine_def def = daft_default_engine_def();
    def.isa = isa, def.threads = threads;
    s->engine = daft_engine_create(&def, &error);
    if (!s->engine) fail_msg("%s", error.message);
    s->scene = daft_scene_create(s->engine, &error);
    s->image = daft_image_create(s->engine, width, height, &error);
    assert_true(s->scene && s->image);
    s->width = width, s->height = height, s->pixels = width * height;
    size_t n = (size_t)s->pixels;
    s->depth = malloc(n * sizeof *s->depth), s->normal = malloc(n * sizeof *s->normal);
    s->entity = malloc(n * sizeof *s->entity), s->triangle = malloc(n * sizeof *s->triangle);
    s->view = daft_default_view();
    s->view.quality.edge_samples = 0; /* truths are known of a pixel's middle */
    s->view.aov = (daft_aov){.depth = s->depth, .normal = s->normal, .entity = s->entity, .triangle = s->triangle};
    return s;
}

__attribute__((unused)) static void stage_drop(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s->depth), free(s->normal), free(s->entity), free(s->triangle);
    free(s);
}

__attribute__((unused)) static const daft_counters *draw(stage *s)
{
    daft_error error = {0};
    if (!daft_render(s->scene, &s->view, s->image, &error)) fail_msg("%s", error.message);
    /* DAFT_PICTURES=folder: keeps what was drawn, to be looked at. */
    static int number;
    char path[512];
    const char *folder = getenv("DAFT_PICTURES");
    if (folder) {
        snprintf(path, sizeof path, "%s/%04d.png", folder, number++);
        if (!daft_image_write(s->image, path, &error)) fail_msg("%s", error.message);
    }
    return daft_scene_counters(s->scene);
}

__attribute__((unused)) static const uint8_t *pixel(const stage *s, int x, int y)
{
    return daft_image_pixels(s->image) + 4 * (y * s->width + x);
}

__attribute__((unused)) static daft_entity add(stage *s, daft_entity_def def)
{
    daft_error error = {0};
    daft_entity entity = daft_entity_create(s->scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

__attribute__((unused)) static daft_entity_def box(daft_dvec3 position, daft_vec3 size, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.position = position, def.size = size, def.material = material;
    return def;
}

__attribute__((unused)) static daft_entity_def sphere(daft_dvec3 position, float radius, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.position = position, def.radius = radius, def.material = material;
    return def;
}

__attribute__((unused)) static daft_entity_def instance(daft_mesh mesh, daft_dvec3 position, float scale,
                                                        daft_quat rotation, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = position, def.material = material;
    def.rotation = rotation, def.scale = daft_v3(scale, scale, scale);
    return def;
}

__attribute__((unused)) static daft_material matte(stage *s, daft_vec3 color, float mirror)
{
    daft_material_def def = daft_default_material_def();
    def.diffuse = def.ambient = color;
    def.specular = daft_v3(0, 0, 0), def.mirror = mirror;
    daft_material out = daft_material_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

__attribute__((unused)) static daft_light sun(stage *s, daft_vec3 direction, float brightness)
{
    daft_light_def def = daft_default_light_def();
    def.kind = DAFT_LIGHT_SUN, def.direction = direction, def.color = daft_v3(brightness, brightness, brightness);
    daft_light out = daft_light_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

__attribute__((unused)) static daft_light source(stage *s, daft_dvec3 position, float brightness)
{
    daft_light_def def = daft_default_light_def();
    def.position = position, def.color = daft_v3(brightness, brightness, brightness);
    daft_light out = daft_light_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

/* The direction of a pixel's ray, any length, as the camera of the view sees it. */
__attribute__((unused)) static daft_dvec3 pixel_ray(const stage *s, int x, int y)
{
    const daft_camera *c = &s->view.camera;
    double f = s->width / 2.0 / daft_tan((double)c->fov / 2), px = x + 0.5 - s->width / 2.0,
           py = s->height / 2.0 - y - 0.5;
    double cp = daft_cos((double)c->pitch), sp = daft_sin((double)c->pitch), cy = daft_cos((double)c->yaw),
           sy = daft_sin((double)c->yaw);
    daft_dvec3 forward = daft_dv3(cp * cy, -sp, cp * sy), right = daft_dv3(-sy, 0, cy),
               up = daft_dcross(right, forward);
    return daft_dadd(daft_dscale(right, px), daft_dadd(daft_dscale(up, py), daft_dscale(forward, f)));
}

typedef struct picture {
    int pixels;
    uint8_t *rgba;
    daft_entity *entity;
    uint32_t *triangle;
} picture;

/* A copy of what was last drawn. */
__attribute__((unused)) static picture picture_take(const stage *s)
{
    size_t n = (size_t)s->pixels;
    picture p = {s->pixels, malloc(4 * n), malloc(n * sizeof *p.entity), malloc(n * sizeof *p.triangle)};
    memcpy(p.rgba, daft_image_pixels(s->image), 4 * n);
    memcpy(p.entity, s->entity, n * sizeof *p.entity);
    memcpy(p.triangle, s->triangle, n * sizeof *p.triangle);
    return p;
}

__attribute__((unused)) static void picture_drop(picture *p) { free(p->rgba), free(p->entity), free(p->triangle); }

/* Pixels that differ by more than one step in some channel. */
__attribute__((unused)) static int far_apart(const picture *p, const stage *s)
{
    const uint8_t *now = daft_image_pixels(s->image);
    int count = 0;
    for (int i = 0; i < s->pixels; i++) {
        int most = 0;
        for (int k = 0; k < 3; k++) most = daft_max_i(most, abs(p->rgba[4 * i + k] - now[4 * i + k]));
        count += most > 1;
    }
    return count;
}

/* Pixels that see another thing, or another triangle of it. */
__attribute__((unused)) static int others_seen(const picture *p, const stage *s)
{
    int count = 0;
    for (int i = 0; i < s->pixels; i++) count += p->entity[i].id != s->entity[i].id || p->triangle[i] != s->triangle[i];
    return count;
}

__attribute__((unused)) static uint64_t picture_hash(const stage *s)
{
    return daft_hash(daft_image_pixels(s->image), 4 * (size_t)s->pixels, 0);
}

#endif
