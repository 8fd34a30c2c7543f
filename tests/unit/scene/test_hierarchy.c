/* scene: transforms in the world, parents that change, children, and entities that scene files name. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static daft_quat random_turn(void)
{
    daft_quat q = {uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1), uniform_f(-1, 1)};
    return daft_quat_normalize(q);
}

static daft_entity make(fixture *f, daft_entity parent, daft_vec3 scale, double far)
{
    daft_entity_def def = daft_default_entity_def();
    def.parent = parent;
    def.position = daft_dv3(uniform(-far, far), uniform(-far, far), uniform(-far, far));
    def.rotation = random_turn();
    def.scale = scale;
    return daft_entity_create(f->scene, &def, NULL);
}

/* One scale for all axes, of either sign. */
static daft_vec3 even_scale(void)
{
    float s = uniform_f(0.3, 3);
    if (uniform(0, 1) < 0.3) s = -s;
    return daft_v3(s, s, s);
}

static daft_daffine world_at(fixture *f, daft_entity entity, float alpha)
{
    f->scene->walk = ++f->engine->revision;
    return daft_entity_world(f->scene, daft_handle_index(entity.id), alpha)->world;
}

/* Where the corners of a metre's cube go. Rotations are floats: 1e-6 of the size. */
static void assert_same_map(const daft_daffine *a, const daft_daffine *b, double far)
{
    for (int i = 0; i < 9; i++) assert_true(fabs(a->m[i] - b->m[i]) < 2e-5 * (1 + fabs(a->m[i])));
    for (int i = 0; i < 3; i++) assert_true(fabs(a->t[i] - b->t[i]) < 1e-5 + far * 1e-6);
}

/* A chain of two parents, each moved in this tick: what hangs on another entity stands where it stood, now and in the
 * picture between the last tick and this one. */
static void a_new_parent_keeps_the_pose(void **state)
{
    fixture *f = *state;
    random_state = 42;
    for (int round = 0; round < 200; round++) {
        const double far = round % 2 ? 1e4 : 10;
        daft_entity top = make(f, (daft_entity){0}, even_scale(), far), low = make(f, top, even_scale(), 10);
        daft_entity other = make(f, (daft_entity){0}, even_scale(), far);
        /* Any scale of its own: nothing is sheared where the parents' are even. */
        const daft_vec3 own = daft_v3(uniform_f(0.3, 3), uniform_f(0.3, 3), -uniform_f(0.3, 3));
        daft_entity e = make(f, low, own, 10), child = make(f, e, daft_v3(1, 1, 1), 3);
        daft_scene_begin_tick(f->scene);
        move_to(f->scene, top, uniform(-far, far), false);
        move_to(f->scene, e, 4, false);
        move_to(f->scene, other, 7, false);
        daft_daffine now = world_at(f, e, 1), before = world_at(f, e, 0), child_now = world_at(f, child, 1);
        daft_entity to = round % 3 ? other : (daft_entity){0};
        daft_error error;
        assert_true(daft_entity_set_parent(f->scene, e, to, &error));
        assert_int_equal(daft_entity_get_parent(f->scene, e).id, to.id);
        daft_daffine after = world_at(f, e, 1), glide = world_at(f, e, 0), child_after = world_at(f, child, 1);
        assert_same_map(&now, &after, far);
        assert_same_map(&before, &glide, far);
        assert_same_map(&child_now, &child_after, far);
        daft_transform world;
        assert_true(daft_entity_get_world_transform(f->scene, e, &world, &error));
        daft_daffine told = daft_daffine_from(&world);
        assert_same_map(&after, &told, far);
        assert_true(daft_entity_destroy(f->scene, top, NULL) && daft_entity_destroy(f->scene, other, NULL));
        if (daft_entity_is_valid(f->scene, e)) daft_entity_destroy(f->scene, e, NULL);
    }
    assert_int_equal(daft_entity_count(f->scene), 0);
}

static void the_world_transform_is_set_through_parents(void **state)
{
    fixture *f = *state;
    random_state = 7;
    daft_entity top = make(f, (daft_entity){0}, daft_v3(2, 2, 2), 1e5), e = make(f, top, daft_v3(1, 1, 1), 10);
    daft_transform wish = {daft_dv3(5, 6, 7), random_turn(), daft_v3(1, 2, 3)}, got;
    assert_true(daft_entity_set_world_transform(f->scene, e, &wish, true, NULL));
    assert_true(daft_entity_get_world_transform(f->scene, e, &got, NULL));
    daft_daffine a = daft_daffine_from(&wish), b = daft_daffine_from(&got);
    assert_same_map(&a, &b, 1e5);
    assert_true(fabsf(transform_of(f->scene, e).scale.y - 1) < 1e-6f);
    /* An entity without a parent gives back the bits that it was given. */
    assert_true(daft_entity_get_world_transform(f->scene, top, &got, NULL));
    daft_transform local = transform_of(f->scene, top);
    assert_memory_equal(&got, &local, sizeof got);
    /* Sheared by an uneven parent, its X axis keeps its direction. */
    daft_transform squashed = {.rotation = {0, 0, 0, 1}, .scale = {3, 1, 1}};
    assert_true(daft_entity_set_transform(f->scene, top, &squashed, true, NULL));
    const daft_transform leaning = {.rotation = {0, 0, sinf(0.3f), cosf(0.3f)}, .scale = {1, 1, 1}};
    assert_true(daft_entity_set_transform(f->scene, e, &leaning, true, NULL));
    assert_true(daft_entity_get_world_transform(f->scene, e, &got, NULL));
    const daft_vec3 x = daft_quat_rotate(got.rotation, daft_v3(1, 0, 0));
    assert_true(fabsf(x.y / x.x - tanf(0.6f) / 3) < 1e-5f);
}

static void impossible_parents_are_refused(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_entity none = {0};
    daft_entity top = make(f, none, daft_v3(1, 1, 1), 1), low = make(f, top, daft_v3(1, 1, 1), 1);
    uint64_t before = daft_scene_hash(f->scene);
    assert_false(daft_entity_set_parent(f->scene, top, low, &error));
    assert_non_null(strstr(error.message, "its children"));
    assert_false(daft_entity_set_parent(f->scene, top, top, &error));
    daft_entity flat = make(f, none, daft_v3(1, 0, 1), 1);
    assert_false(daft_entity_set_parent(f->scene, top, flat, &error));
    assert_non_null(strstr(error.message, "scale is 0"));
    daft_entity long_one = make(f, none, daft_v3(1, 2, 1), 1), joint = make(f, none, daft_v3(1, 1, 1), 1);
    make_sphere(f->scene, 0, 0, 0, 1, joint);
    assert_false(daft_entity_set_parent(f->scene, joint, long_one, &error));
    assert_non_null(strstr(error.message, "sphere"));
    assert_true(daft_entity_destroy(f->scene, flat, NULL) && daft_entity_destroy(f->scene, long_one, NULL) &&
                daft_entity_destroy(f->scene, joint, NULL));
    assert_false(daft_entity_set_parent(f->scene, top, flat, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    assert_true(daft_scene_hash(f->scene) == before);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.body = DAFT_BODY_DYNAMIC;
    daft_entity body = daft_entity_create(f->scene, &def, NULL);
    assert_false(daft_entity_set_parent(f->scene, body, top, &error));
    assert_non_null(strstr(error.message, "body"));
    /* The state's hash tells parents apart. */
    assert_true(daft_entity_destroy(f->scene, body, NULL));
    assert_true(daft_entity_set_parent(f->scene, low, none, &error));
    assert_true(daft_scene_hash(f->scene) != before);
}

static void children_come_in_their_order(void **state)
{
    fixture *f = *state;
    daft_entity none = {0}, top = make(f, none, daft_v3(1, 1, 1), 1), child[5], list[5];
    for (int i = 0; i < 5; i++) child[i] = make(f, i == 2 ? none : top, daft_v3(1, 1, 1), 1);
    assert_true(daft_entity_set_parent(f->scene, child[2], top, NULL));
    assert_true(daft_entity_destroy(f->scene, child[1], NULL));
    assert_true(daft_entity_set_parent(f->scene, child[0], none, NULL));
    assert_int_equal(daft_entity_children(f->scene, top, NULL, 0), 3);
    assert_int_equal(daft_entity_children(f->scene, top, list, 2), 3);
    assert_true(list[0].id == child[3].id && list[1].id == child[4].id);
    assert_int_equal(daft_entity_children(f->scene, top, list, 5), 3);
    assert_int_equal(list[2].id, child[2].id);
    assert_int_equal(daft_entity_children(f->scene, child[1], list, 5), 0);
    assert_int_equal(daft_entity_get_parent(f->scene, child[0]).id, 0);
}

static void rays_of_a_camera_meet_its_axes(void **state)
{
    (void)state;
    random_state = 3;
    for (int i = 0; i < 100; i++) {
        daft_camera c = daft_default_camera();
        c.yaw = uniform_f(-4, 4), c.pitch = uniform_f(-1.5, 1.5), c.roll = uniform_f(-3, 3),
        c.fov = uniform_f(0.2, 2.5);
        daft_vec3 right, up, forward, ray = daft_camera_ray(&c, 0.5, 0.5, 0.5);
        daft_camera_axes(&c, &right, &up, &forward);
        assert_true(daft_dot(ray, forward) > 1 - 1e-6f);
        ray = daft_camera_ray(&c, 1, 0.5, 0.5);
        assert_true(fabsf(daft_dot(ray, right) - sinf(c.fov / 2)) < 1e-5f && fabsf(daft_dot(ray, up)) < 1e-5f);
        ray = daft_camera_ray(&c, 0.5, 0, 0.5);
        assert_true(fabsf(daft_dot(ray, up) / daft_dot(ray, forward) - 0.5f * tanf(c.fov / 2)) < 1e-4f);
        assert_true(fabsf(daft_length(ray) - 1) < 1e-6f);
    }
}

/* ---- names in scene files ---- */

static bool load_text(fixture *f, const char *text, daft_error *error)
{
    char path[] = "/tmp/daft-names-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
    close(file);
    const bool good = daft_scene_load(f->scene, path, error);
    unlink(path);
    return good;
}

static void scene_files_name_entities(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_named_entity named;
    char text[1000];
    static const char *const mesh = DAFT_ROOT "/assets/meshes/slab.obj", *const mtl =
                                                                             DAFT_ROOT "/assets/meshes/meshes.mtl";
    snprintf(text, sizeof text,
             "mesh %s 1 0 0 name=table\nsphere 0 0 0 1 %s\nsphere 0 3 0 1 %s shadow=false name=ball\n", mesh, mtl, mtl);
    assert_true(load_text(f, text, &error));
    assert_int_equal(daft_scene_named_count(f->scene), 2);
    assert_true(daft_scene_get_named(f->scene, 1, &named, &error));
    assert_string_equal(named.name, "ball");
    assert_true(transform_of(f->scene, named.entity).position.y == 3);
    assert_false(daft_scene_get_named(f->scene, 2, &named, &error));
    assert_non_null(strstr(error.message, "name 2 of 2"));
    /* A file that fails leaves no names. */
    snprintf(text, sizeof text, "mesh %s 1 0 0 name=chair\nsphere 0 0 0 1 no.mtl name=ball\n", mesh);
    assert_false(load_text(f, text, &error));
    assert_false(load_text(f, "camera 0 0 0 name=eye\n", &error));
    assert_non_null(strstr(error.message, "unknown option 'name'"));
    snprintf(text, sizeof text, "mesh %s 1 0 0 name=\n", mesh);
    assert_false(load_text(f, text, &error));
    assert_non_null(strstr(error.message, "the name is empty"));
    snprintf(text, sizeof text, "mesh %s 1 0 0 nam=x\n", mesh);
    assert_false(load_text(f, text, &error));
    assert_non_null(strstr(error.message, "known are name, "));
    assert_int_equal(daft_scene_named_count(f->scene), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_new_parent_keeps_the_pose),
        TEST(the_world_transform_is_set_through_parents),
        TEST(impossible_parents_are_refused),
        TEST(children_come_in_their_order),
        cmocka_unit_test(rays_of_a_camera_meet_its_axes),
        TEST(scene_files_name_entities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
