/* What the tests of degenerate input share: a stage of sound entities, pictures of it with all that a pixel can tell,
 * and what must hold for each. Everything goes through daft.h. */
#ifndef DAFT_DEGENERATE_H
#define DAFT_DEGENERATE_H

#include "daft.h"

#include "math/simd/dispatch.h"
#include "math/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <float.h>

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT };

static const daft_preset QUALITIES[] = {DAFT_PRESET_DRAFT, DAFT_PRESET_GAME, DAFT_PRESET_HIGH, DAFT_PRESET_REFERENCE};
enum { QUALITY_COUNT = 4 };

typedef struct picture {
    uint8_t pixels[4 * PIXELS];
    float depth[PIXELS];
    daft_vec3 normal[PIXELS];
    daft_entity entity[PIXELS];
    uint32_t triangle[PIXELS];
} picture;

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_entity floor, ball, chrome, block, falling;
    int warnings;
    daft_error last_warning;
} stage;

static void on_warning(void *user, const daft_error *warning)
{
    stage *s = user;
    s->warnings++;
    s->last_warning = *warning;
}

__attribute__((unused)) static daft_entity add(stage *s, daft_entity_def def)
{
    daft_error error = {0};
    daft_entity entity = daft_entity_create(s->scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

__attribute__((unused)) static daft_entity_def sphere(daft_dvec3 position, float radius)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.position = position, def.radius = radius;
    return def;
}

__attribute__((unused)) static daft_entity_def box(daft_dvec3 position, daft_vec3 size)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.position = position, def.size = size;
    return def;
}

__attribute__((unused)) static daft_entity_def thing(daft_mesh mesh, daft_dvec3 position)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = position;
    return def;
}

__attribute__((unused)) static daft_mesh mesh_of(stage *s, const daft_vec3 *positions, uint32_t vertices,
                                                 const uint32_t *indices, uint32_t triangles)
{
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.vertex_count = vertices, def.indices = indices, def.triangle_count = triangles;
    daft_error error = {0};
    daft_mesh mesh = daft_mesh_create(s->scene, &def, &error);
    if (!mesh.id) fail_msg("%s", error.message);
    return mesh;
}

__attribute__((unused)) static daft_light light(stage *s, daft_light_kind kind, daft_dvec3 position,
                                                daft_vec3 direction, float color)
{
    daft_light_def def = daft_default_light_def();
    def.kind = kind, def.position = position, def.direction = direction, def.color = daft_v3(color, color, color);
    daft_error error = {0};
    daft_light made = daft_light_create(s->scene, &def, &error);
    if (!made.id) fail_msg("%s", error.message);
    return made;
}

static stage *stage_bare(const char *isa)
{
    stage *s = calloc(1, sizeof *s);
    daft_error error = {0};
    daft_engine_def def = daft_default_engine_def();
    def.isa = isa, def.threads = 2, def.warn = on_warning, def.warn_user = s;
    s->engine = daft_engine_create(&def, &error);
    s->scene = s->engine ? daft_scene_create(s->engine, &error) : NULL;
    s->image = s->scene ? daft_image_create(s->engine, WIDTH, HEIGHT, &error) : NULL;
    if (!s->image) fail_msg("%s", error.message);
    return s;
}

/* A floor, a ball, a mirror that sees the whole room, a block and a ball that falls; a sun and a light. The camera is
 * at the origin and looks along +X. */
__attribute__((unused)) static stage *stage_make_on(const char *isa)
{
    stage *s = stage_bare(isa);
    daft_material_def mirror = daft_default_material_def();
    mirror.mirror = 0.8f;
    daft_entity_def chrome = sphere(daft_dv3(7, 0.3, -2), 1.2f), falling = sphere(daft_dv3(5, 2, 1), 0.3f);
    chrome.material = daft_material_create(s->scene, &mirror, NULL);
    falling.body = DAFT_BODY_DYNAMIC;
    daft_entity_def floor = box(daft_dv3(5, -2, 0), daft_v3(14, 1, 14));
    floor.body = DAFT_BODY_STATIC;
    s->floor = add(s, floor);
    s->ball = add(s, sphere(daft_dv3(5, 0, 1.5), 1));
    s->chrome = add(s, chrome);
    s->block = add(s, box(daft_dv3(8, 0, 0.5), daft_v3(1, 2, 1)));
    s->falling = add(s, falling);
    daft_scene_set_sky_gradient(s->scene, daft_v3(0.2f, 0.3f, 0.8f), daft_v3(0.8f, 0.8f, 0.9f));
    light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(1, -2, 0.5f), 0.6f);
    light(s, DAFT_LIGHT_POINT, daft_dv3(2, 5, -1), daft_v3(0, -1, 0), 0.3f);
    return s;
}

__attribute__((unused)) static stage *stage_make(void) { return stage_make_on(NULL); }

__attribute__((unused)) static void stage_drop(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

static int edge_samples = -1; /* of the pictures that are drawn; below 0: the quality's */

__attribute__((unused)) static picture *draw_from(stage *s, daft_preset quality, daft_camera camera)
{
    picture *p = calloc(1, sizeof *p);
    daft_view view = daft_default_view();
    view.quality = daft_preset_quality(quality);
    if (quality == DAFT_PRESET_REFERENCE) view.quality.samples = 4; /* 16 are slow, and show nothing more here */
    if (edge_samples >= 0) view.quality.edge_samples = edge_samples;
    view.camera = camera;
    view.aov = (daft_aov){.depth = p->depth, .normal = p->normal, .entity = p->entity, .triangle = p->triangle};
    daft_error error = {0};
    if (!daft_render(s->scene, &view, s->image, &error)) fail_msg("%s", error.message);
    memcpy(p->pixels, daft_image_pixels(s->image), sizeof p->pixels);
    return p;
}

__attribute__((unused)) static picture *draw(stage *s, daft_preset quality)
{
    return draw_from(s, quality, daft_default_camera());
}

/* Depths above zero, infinite in the sky alone; normals of length 1, zero in the sky alone. */
__attribute__((unused)) static void assert_sound(const char *name, const float *depth, const daft_vec3 *normal,
                                                 const daft_entity *entity, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        daft_vec3 n = normal[i];
        bool sky = entity[i].id == 0;
        if (!(depth[i] >= 0) || (sky != (isinf(depth[i]) != 0)))
            fail_msg("%s: pixel %zu has depth %g", name, i, (double)depth[i]);
        float length = sqrtf(daft_dot(n, n));
        if (!(fabsf(length - (sky ? 0 : 1)) < 1e-4f))
            fail_msg("%s: pixel %zu has the normal %g %g %g", name, i, (double)n.x, (double)n.y, (double)n.z);
    }
}

__attribute__((unused)) static void assert_picture_sound(const char *name, const picture *p)
{
    assert_sound(name, p->depth, p->normal, p->entity, PIXELS);
}

__attribute__((unused)) static void assert_same(const char *name, const picture *a, const picture *b)
{
    for (size_t i = 0; i < PIXELS; i++)
        if (memcmp(a->pixels + 4 * i, b->pixels + 4 * i, 4) != 0 || memcmp(&a->depth[i], &b->depth[i], 4) != 0 ||
            memcmp(&a->normal[i], &b->normal[i], sizeof a->normal[i]) != 0 || a->entity[i].id != b->entity[i].id ||
            a->triangle[i] != b->triangle[i])
            fail_msg("%s: pixel %zu, %zu is another: entity 0x%x depth %g, it was 0x%x, %g", name, i % WIDTH, i / WIDTH,
                     b->entity[i].id, (double)b->depth[i], a->entity[i].id, (double)a->depth[i]);
}

#endif
