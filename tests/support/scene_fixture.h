/* What the tests of scene/ share: an engine with a scene that counts its warnings, random numbers, short makers. */
#ifndef DAFT_SCENE_FIXTURE_H
#define DAFT_SCENE_FIXTURE_H

#include "math/trig.h"
#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* Whether Assimp can be used. To MemorySanitizer, what a library that it has not seen writes was never written. */
#if defined(__has_feature)
#if __has_feature(memory_sanitizer)
#define READS_BY_LIBRARY 0
#endif
#endif
#ifndef READS_BY_LIBRARY
#define READS_BY_LIBRARY 1
#endif

/* Assimp 5.2 keeps some of a model that is broken. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libassimp"; }

typedef struct fixture {
    daft_engine *engine;
    daft_scene *scene;
    int warnings;
    daft_error last_warning;
} fixture;

static void on_warning(void *user, const daft_error *warning)
{
    fixture *f = user;
    f->warnings++;
    f->last_warning = *warning;
}

static int set_up(void **state)
{
    static fixture f;
    f = (fixture){0};
    daft_engine_def def = daft_default_engine_def();
    def.threads = 2;
    def.warn = on_warning;
    def.warn_user = &f;
    f.engine = daft_engine_create(&def, NULL);
    f.scene = daft_scene_create(f.engine, NULL);
    *state = &f;
    return f.scene ? 0 : -1;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    daft_scene_destroy(f->scene);
    daft_engine_destroy(f->engine);
    return 0;
}

static uint64_t random_state;
__attribute__((unused)) static double uniform(double low, double high)
{
    random_state ^= random_state << 13, random_state ^= random_state >> 7, random_state ^= random_state << 17;
    return low + (high - low) * (double)(random_state >> 11) * 0x1p-53;
}
__attribute__((unused)) static float uniform_f(double low, double high) { return (float)uniform(low, high); }

__attribute__((unused)) static daft_entity make_sphere(daft_scene *scene, double x, double y, double z, float radius,
                                                       daft_entity parent)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.radius = radius;
    def.position = daft_dv3(x, y, z);
    def.parent = parent;
    daft_entity entity = daft_entity_create(scene, &def, NULL);
    assert_true(entity.id != 0);
    return entity;
}

__attribute__((unused)) static daft_transform transform_of(daft_scene *scene, daft_entity entity)
{
    daft_transform transform;
    assert_true(daft_entity_get_transform(scene, entity, &transform, NULL));
    return transform;
}

__attribute__((unused)) static void move_to(daft_scene *scene, daft_entity entity, double x, bool teleport)
{
    daft_transform transform = transform_of(scene, entity);
    transform.position.x = x;
    assert_true(daft_entity_set_transform(scene, entity, &transform, teleport, NULL));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

#endif
