/* Only what the picture calls for: counters prove that nothing is done for effects that nobody sees. What is seen is
 * worked out here from the depths of the picture, by the geometry of each scene. */
#include "daft.h"

#include "math/vec.h"
#include "support_content.h"

enum { WIDTH = 240, HEIGHT = 135, PIXELS = WIDTH * HEIGHT };

typedef struct stage {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    float depth[PIXELS];
    daft_entity entity[PIXELS];
} stage;

static stage *stage_make(int threads)
{
    stage *s = calloc(1, sizeof *s);
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads;
    s->engine = daft_engine_create(&def, NULL);
    s->scene = daft_scene_create(s->engine, NULL);
    s->image = daft_image_create(s->engine, WIDTH, HEIGHT, NULL);
    assert_true(s->scene && s->image);
    s->view = daft_default_view();
    s->view.aov = (daft_aov){.depth = s->depth, .entity = s->entity};
    s->view.camera = daft_camera_look_at(daft_dv3(-8, 6, 2), daft_dv3(0, 0, 0), 1.2f);
    return s;
}

static void stage_drop(stage *s)
{
    daft_image_destroy(s->image);
    daft_scene_destroy(s->scene);
    daft_engine_destroy(s->engine);
    free(s);
}

static const daft_counters *draw(stage *s)
{
    daft_error error = {0};
    if (!daft_render(s->scene, &s->view, s->image, &error)) fail_msg("%s", error.message);
    return daft_scene_counters(s->scene);
}

static daft_entity add(stage *s, const daft_entity_def *def)
{
    daft_error error = {0};
    daft_entity entity = daft_entity_create(s->scene, def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

/* Its upper side is the plane y = 0. */
static daft_entity add_floor(stage *s)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = daft_v3(40, 1, 40), def.position = daft_dv3(0, -0.5, 0);
    return add(s, &def);
}

static daft_entity add_ball(stage *s, daft_dvec3 at, float radius, daft_material material)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = radius, def.position = at, def.material = material;
    return add(s, &def);
}

static daft_mesh make_tetrahedron(stage *s)
{
    static const daft_vec3 corners[4] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    static const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = corners, def.vertex_count = 4, def.indices = indices, def.triangle_count = 4;
    daft_mesh mesh = daft_mesh_create(s->scene, &def, NULL);
    assert_true(mesh.id);
    return mesh;
}

static void add_light(stage *s, daft_light_kind kind, daft_dvec3 at, daft_vec3 direction)
{
    daft_light_def def = daft_default_light_def();
    def.kind = kind, def.position = at, def.direction = direction;
    assert_true(daft_light_create(s->scene, &def, NULL).id);
}

static void assert_nothing_done(const daft_effect *effect)
{
    assert_false(effect->ran);
    assert_true(effect->rays == 0 && effect->tiles == 0 && effect->bytes == 0 && effect->ms == 0);
    assert_non_null(effect->why);
}

/* ---- shadows ---- */

static void without_lights_no_shadow_ray(void **unused)
{
    (void)unused;
    for (daft_preset quality = DAFT_PRESET_DRAFT; quality <= DAFT_PRESET_REFERENCE; quality++) {
        stage *s = stage_make(2);
        daft_material_def mirror = daft_default_material_def();
        mirror.mirror = 0.7f; /* what is seen in it casts none either */
        add_floor(s);
        add_ball(s, daft_dv3(0, 1, 0), 1, daft_material_create(s->scene, &mirror, NULL));
        s->view.quality = daft_preset_quality(quality);
        const daft_counters *c = draw(s);
        assert_true(c->shadow_rays == 0 && c->shadow_points_kept == 0);
        assert_nothing_done(&c->effects[DAFT_EFFECT_SHADOW]);
        assert_nothing_done(&c->effects[DAFT_EFFECT_LIGHTING]);
        assert_int_equal(c->effects[DAFT_EFFECT_REFLECTION].ran, quality != DAFT_PRESET_DRAFT);
        stage_drop(s);
    }
}

/* Where the ray of a pixel is after its depth, from the camera. */
static daft_dvec3 point_of(const stage *s, int at)
{
    const daft_camera *camera = &s->view.camera;
    double cy = daft_cos((double)camera->yaw), sy = daft_sin((double)camera->yaw), cp = daft_cos((double)camera->pitch),
           sp = daft_sin((double)camera->pitch);
    daft_dvec3 forward = daft_dv3(cp * cy, -sp, cp * sy), right = daft_dv3(-sy, 0, cy),
               up = daft_dcross(right, forward);
    double focal = WIDTH / 2.0 / daft_tan((double)camera->fov / 2);
    daft_dvec3 ray =
        daft_dadd(daft_dscale(right, at % WIDTH + 0.5 - WIDTH / 2.0),
                  daft_dadd(daft_dscale(up, HEIGHT / 2.0 - at / WIDTH - 0.5), daft_dscale(forward, focal)));
    return daft_dadd(camera->position, daft_dscale(ray, (double)s->depth[at] / sqrt(daft_ddot(ray, ray))));
}

/* How many pixels see the floor within a square around (x, z). */
static uint64_t floor_within(const stage *s, daft_entity floor, double x, double z, double half)
{
    uint64_t count = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (s->entity[i].id != floor.id) continue;
        daft_dvec3 p = point_of(s, i);
        assert_true(fabs(p.y) < 1e-3);
        count += fabs(p.x - x) <= half && fabs(p.z - z) <= half;
    }
    return count;
}

/* Under the sun at noon, the bounds of an instance are the square below it. A ball also has points of its own; they
 * face the sun or lie in its own shade, and it is convex, so none of them is kept. */
static void only_points_under_an_occluders_bounds_are_tested(void **unused)
{
    (void)unused;
    for (int shape = 0; shape < 2; shape++) {
        stage *s = stage_make(2);
        daft_entity floor = add_floor(s);
        add_light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(0, -1, 0));
        if (shape == 0) {
            add_ball(s, daft_dv3(1, 3, -1), 1, (daft_material){0});
        } else {
            daft_entity_def def = daft_default_entity_def();
            def.shape = DAFT_SHAPE_MESH, def.mesh = make_tetrahedron(s), def.position = daft_dv3(1, 3, -1);
            add(s, &def);
        }
        const daft_counters *c = draw(s);
        uint64_t under = floor_within(s, floor, 1, -1, 1), around = floor_within(s, floor, 1, -1, 1.5);
        uint64_t own = 0; /* points of the mesh, which may lie in its shadow */
        for (int i = 0; shape == 1 && i < PIXELS; i++) own += s->entity[i].id && s->entity[i].id != floor.id;
        assert_true(under > 300 && around < PIXELS / 4);
        assert_int_equal(c->shadow_points_kept, c->shadow_rays);
        print_message("%llu kept; %llu of the floor under the bounds, %llu around them, %llu of its own\n",
                      (unsigned long long)c->shadow_points_kept, (unsigned long long)under, (unsigned long long)around,
                      (unsigned long long)own);
        assert_true(c->shadow_points_kept >= under * 3 / 4); /* a ball's round shadow is 78 % of its square */
        assert_true(c->shadow_points_kept <= around + own);
        stage_drop(s);
    }
}

/* Off to the side, behind the light, under the floor: nothing that could hide the light from a point that is seen. */
static void occluders_elsewhere_are_never_tested(void **unused)
{
    (void)unused;
    const daft_dvec3 balls[] = {{0, 3, 60}, {0, 14, 0}, {3, -5, 3}};
    for (size_t i = 0; i < sizeof balls / sizeof balls[0]; i++) {
        stage *s = stage_make(1);
        add_floor(s);
        if (i == 1)
            add_light(s, DAFT_LIGHT_POINT, daft_dv3(0, 7, 0), daft_v3(0, -1, 0));
        else
            add_light(s, DAFT_LIGHT_SUN, daft_dv3(0, 0, 0), daft_v3(0, -1, 0));
        add_ball(s, balls[i], 1, (daft_material){0});
        const daft_counters *c = draw(s);
        assert_true(c->effects[DAFT_EFFECT_LIGHTING].ran);
        assert_true(c->shadow_rays == 0 && c->shadow_points_kept == 0);
        assert_false(c->effects[DAFT_EFFECT_SHADOW].ran);
        stage_drop(s);
    }
}

/* ---- mirrors ---- */

static void mirrors_out_of_sight_cast_no_ray(void **unused)
{
    (void)unused;
    stage *s = stage_make(2);
    daft_material_def mirror = daft_default_material_def();
    mirror.mirror = 0.9f;
    daft_material shiny = daft_material_create(s->scene, &mirror, NULL);
    add_floor(s);
    add_ball(s, daft_dv3(-30, 20, 8), 2, shiny); /* behind the camera */
    add_ball(s, daft_dv3(2, -4, 0), 2, shiny);   /* under the floor */
    const daft_counters *c = draw(s);
    assert_int_equal(c->reflection_rays, 0);
    assert_nothing_done(&c->effects[DAFT_EFFECT_REFLECTION]);
    add_ball(s, daft_dv3(0, 1, 0), 1, shiny);
    assert_true(draw(s)->reflection_rays > 100);
    stage_drop(s);
}

/* What is sampled is filtered in planes of the whole picture: a rough mirror behind the camera and a soft light whose
 * range ends before anything that is seen take none, and both do once they are in sight. */
static void sampled_light_out_of_sight_takes_no_planes(void **unused)
{
    (void)unused;
    enum { PLANE = 4 * PIXELS };
    for (int soft = 0; soft < 2; soft++) {
        stage *s = stage_make(2);
        s->view.aov = (daft_aov){0};
        add_floor(s);
        daft_material_def rough = daft_default_material_def();
        daft_light_def lamp = daft_default_light_def();
        rough.mirror = 0.9f, rough.roughness = 0.4f;
        lamp.position = daft_dv3(0, 4, 0), lamp.range = 2, lamp.radius = 0.2f;
        const daft_material shiny = daft_material_create(s->scene, &rough, NULL);
        const daft_light light = soft ? daft_light_create(s->scene, &lamp, NULL) : (daft_light){0};
        if (!soft) add_ball(s, daft_dv3(-30, 20, 8), 2, shiny); /* behind the camera */
        s->view.quality.denoise = false;
        draw(s);
        const uint64_t before = daft_engine_memory(s->engine).used;
        s->view.quality.denoise = true;
        assert_nothing_done(&draw(s)->effects[DAFT_EFFECT_DENOISE]);
        assert_true(daft_engine_memory(s->engine).used < before + 3 * PLANE);
        lamp.range = 20;
        if (soft) assert_true(daft_light_set(s->scene, light, &lamp, NULL));
        if (!soft) add_ball(s, daft_dv3(0, 1, 0), 1, shiny);
        assert_true(draw(s)->effects[DAFT_EFFECT_DENOISE].ran);
        assert_true(daft_engine_memory(s->engine).used > before + 6 * PLANE);
        stage_drop(s);
    }
}

/* ---- meshes ---- */

/* Frames, moves, other cameras, lights, materials and rays leave the trees of meshes as they are. */
static void a_mesh_that_keeps_its_shape_is_built_once(void **unused)
{
    (void)unused;
    stage *s = stage_make(2);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = make_tetrahedron(s);
    daft_entity first = add(s, &def);
    def.position = daft_dv3(3, 2, 0);
    add(s, &def);
    assert_int_equal(draw(s)->mesh_builds, 1);
    for (int i = 0; i < 5; i++) {
        daft_transform moved = {daft_dv3(i, 1, -i), daft_quat_normalize((daft_quat){1, (float)i, 2, 3}),
                                daft_v3(1, 1 + (float)i, 1)};
        daft_scene_begin_tick(s->scene);
        assert_true(daft_entity_set_transform(s->scene, first, &moved, false, NULL));
        assert_true(daft_scene_step(s->scene, 1.0f / 60, NULL));
        daft_material_def material = daft_default_material_def();
        assert_true(daft_entity_set_material(s->scene, first, daft_material_create(s->scene, &material, NULL), NULL));
        add_light(s, DAFT_LIGHT_POINT, daft_dv3(i, 9, 0), daft_v3(0, -1, 0));
        daft_ray_hit hit;
        daft_scene_cast_ray(s->scene, daft_dv3(0, 9, 0), daft_v3(0, -1, 0), 100, (daft_entity){0}, &hit, NULL);
        s->view.camera = daft_camera_look_at(daft_dv3(-8 + i, 6, 2), daft_dv3(0, 0, 0), 1.2f);
        assert_int_equal(draw(s)->mesh_builds, 1);
    }
    stage_drop(s);
}

/* ---- what has not moved ---- */

static void what_has_not_moved_stays_in_place(void **unused)
{
    (void)unused;
    stage *s = stage_make(2);
    daft_material_def def = daft_default_material_def();
    daft_material plain = daft_material_create(s->scene, &def, NULL);
    add_floor(s);
    daft_entity ball = add_ball(s, daft_dv3(0, 1, 0), 1, plain);
    add_light(s, DAFT_LIGHT_POINT, daft_dv3(3, 9, 0), daft_v3(0, -1, 0));
    for (int i = 0; i < 3; i++) assert_int_equal(draw(s)->instance_updates, 1);
    daft_ray_hit hit;
    daft_scene_cast_ray(s->scene, daft_dv3(0, 9, 0), daft_v3(0, -1, 0), 100, (daft_entity){0}, &hit, NULL);
    daft_scene_set_ambient(s->scene, daft_v3(0.5f, 0.5f, 0.5f));
    s->view.camera = daft_camera_look_at(daft_dv3(-8, 6, 2), daft_dv3(1, 0, 0), 1); /* from where it is */
    for (int i = 0; i < 3; i++) {
        daft_scene_begin_tick(s->scene);
        s->view.alpha = 0.25f * (float)i;
        assert_int_equal(draw(s)->instance_updates, 1);
    }
    daft_transform place;
    assert_true(daft_entity_get_transform(s->scene, ball, &place, NULL));
    place.position.x = 2;
    assert_true(daft_entity_set_transform(s->scene, ball, &place, false, NULL));
    assert_int_equal(draw(s)->instance_updates, 2);
    assert_int_equal(draw(s)->instance_updates, 2);
    s->view.alpha = 0.75f;
    assert_int_equal(draw(s)->instance_updates, 3); /* it is between two places */
    daft_scene_begin_tick(s->scene);
    for (int i = 0; i < 2; i++) assert_int_equal(draw(s)->instance_updates, 4); /* and has arrived */
    s->view.camera.position.z += 1e-6;
    assert_int_equal(draw(s)->instance_updates, 5);
    def.transmission = 1; /* it hides no light any more */
    assert_true(daft_material_set(s->scene, plain, &def, NULL));
    assert_int_equal(draw(s)->instance_updates, 6);
    assert_true(daft_entity_set_material(s->scene, ball, plain, NULL));
    assert_int_equal(draw(s)->instance_updates, 6); /* it had that already */
    assert_true(daft_entity_destroy(s->scene, ball, NULL));
    assert_int_equal(draw(s)->instance_updates, 7);
    stage_drop(s);
}

/* Everything that a game may change, in two scenes at once. */
enum { TWINS = 2, ENTITIES = 24, MATERIALS = 3 };
typedef struct twins {
    stage *stage[TWINS];
    daft_entity entity[TWINS][ENTITIES], toggled[TWINS];
    daft_material material[TWINS][MATERIALS];
    daft_mesh mesh[TWINS];
} twins;

static daft_dvec3 random_place(void)
{
    return daft_dv3(0.01 * random_below(1000) - 5, 0.01 * random_below(300), 0.01 * random_below(1000) - 5);
}

static daft_material_def random_material(void)
{
    daft_material_def def = daft_default_material_def();
    def.diffuse = daft_v3(0.1f * (float)random_below(10), 0.5f, 0.2f);
    if (random_below(3) == 0) def.transmission = 0.1f * (float)random_below(11);
    return def;
}

static daft_entity_def random_thing(void)
{
    daft_entity_def def = daft_default_entity_def();
    uint32_t kind = random_below(3);
    def.shape = kind == 0 ? DAFT_SHAPE_SPHERE : kind == 1 ? DAFT_SHAPE_BOX : DAFT_SHAPE_MESH;
    def.radius = 0.3f, def.position = random_place();
    return def;
}

static void twins_make(twins *t)
{
    for (int i = 0; i < TWINS; i++) {
        stage *s = t->stage[i] = stage_make(2);
        add_light(s, DAFT_LIGHT_POINT, daft_dv3(3, 9, 0), daft_v3(0, -1, 0));
        add_floor(s);
        t->toggled[i] = add_ball(s, daft_dv3(0, 3, 0), 0.2f, (daft_material){0});
        t->mesh[i] = make_tetrahedron(s);
        for (int k = 0; k < ENTITIES; k++) t->entity[i][k] = (daft_entity){0};
    }
    for (int k = 0; k < MATERIALS; k++) {
        daft_material_def def = random_material();
        for (int i = 0; i < TWINS; i++) t->material[i][k] = daft_material_create(t->stage[i]->scene, &def, NULL);
    }
}

static void renew(twins *t, uint32_t k, uint32_t material, const daft_entity_def *made)
{
    for (int i = 0; i < TWINS; i++) {
        daft_entity_def def = *made;
        if (t->entity[i][k].id) assert_true(daft_entity_destroy(t->stage[i]->scene, t->entity[i][k], NULL));
        if (def.shape == DAFT_SHAPE_MESH) def.mesh = t->mesh[i];
        def.material = t->material[i][material];
        t->entity[i][k] = add(t->stage[i], &def);
    }
}

static void change_entity(twins *t, uint32_t k, uint32_t what)
{
    const daft_entity_def def = random_thing();
    uint32_t material = random_below(MATERIALS), visible = random_below(2), teleport = random_below(2);
    if (!t->entity[0][k].id || what == 0) {
        renew(t, k, material, &def);
        return;
    }
    for (int i = 0; i < TWINS; i++) {
        daft_scene *scene = t->stage[i]->scene;
        daft_transform place;
        assert_true(daft_entity_get_transform(scene, t->entity[i][k], &place, NULL));
        place.position = def.position;
        if (what == 1) assert_true(daft_entity_set_transform(scene, t->entity[i][k], &place, teleport, NULL));
        if (what == 2) assert_true(daft_entity_set_visible(scene, t->entity[i][k], visible, NULL));
        if (what == 3) assert_true(daft_entity_set_material(scene, t->entity[i][k], t->material[i][material], NULL));
    }
}

static void change_scene(twins *t, uint32_t what)
{
    const daft_dvec3 from = random_place();
    const daft_material_def def = random_material();
    const float up = 0.1f * (float)random_below(10);
    const daft_vec3 corners[4] = {{1, 1 + up, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    uint32_t material = random_below(MATERIALS);
    for (int i = 0; i < TWINS; i++) {
        stage *s = t->stage[i];
        daft_ray_hit hit;
        if (what == 0)
            s->view.camera = daft_camera_look_at(daft_dv3(from.x - 8, from.y + 3, from.z), daft_dv3(0, 0, 0), 1.2f);
        if (what == 1) s->view.alpha = up;
        if (what == 2) daft_scene_begin_tick(s->scene);
        if (what == 3) daft_scene_cast_ray(s->scene, from, daft_v3(0, -1, 0), 100, (daft_entity){0}, &hit, NULL);
        if (what == 4) assert_true(daft_material_set(s->scene, t->material[i][material], &def, NULL));
        if (what == 5) assert_true(daft_mesh_set_positions(s->scene, t->mesh[i], corners, NULL, 4, NULL));
        if (what == 6) s->view.quality.visibility = material ? DAFT_INTERSECT_FAST : DAFT_INTERSECT_EXACT;
    }
}

/* Pictures are those of a scene of which everything is put into place each time. */
static void what_stays_in_place_looks_the_same(void **unused)
{
    (void)unused;
    twins t;
    uint64_t kept = 0;
    random_state = 20261122;
    twins_make(&t);
    for (int step = 0; step < 300; step++) {
        uint32_t what = random_below(12);
        if (what < 4)
            change_entity(&t, random_below(ENTITIES), what);
        else if (what < 11)
            change_scene(&t, what - 4);
        daft_scene *other = t.stage[1]->scene; /* a change that changes nothing */
        assert_true(daft_entity_set_visible(other, t.toggled[1], false, NULL) &&
                    daft_entity_set_visible(other, t.toggled[1], true, NULL));
        for (int i = 0; i < TWINS; i++) draw(t.stage[i]);
        assert_memory_equal(daft_image_pixels(t.stage[0]->image), daft_image_pixels(t.stage[1]->image), 4 * PIXELS);
        assert_memory_equal(t.stage[0]->depth, t.stage[1]->depth, sizeof t.stage[0]->depth);
        kept = daft_scene_counters(other)->instance_updates - daft_scene_counters(t.stage[0]->scene)->instance_updates;
    }
    assert_true(kept > 60 && kept < 240);
    for (int i = 0; i < TWINS; i++) stage_drop(t.stage[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_lights_no_shadow_ray),
        cmocka_unit_test(only_points_under_an_occluders_bounds_are_tested),
        cmocka_unit_test(occluders_elsewhere_are_never_tested),
        cmocka_unit_test(mirrors_out_of_sight_cast_no_ray),
        cmocka_unit_test(sampled_light_out_of_sight_takes_no_planes),
        cmocka_unit_test(a_mesh_that_keeps_its_shape_is_built_once),
        cmocka_unit_test(what_has_not_moved_stays_in_place),
        cmocka_unit_test(what_stays_in_place_looks_the_same),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
