/* Clips: poses against matrices in double, the same bits everywhere, times and blends, what is never computed, and
 * files that are wrong. The model is a bar of five rings along +y with a skin of two joints, hip at the origin and knee
 * at y = 1, whose weights are y/2 for the knee; one morph target that moves the top ring; and a box that hangs on the
 * knee without a skin. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static char folder[64];

static int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-clips-XXXXXX");
    return mkdtemp(folder) ? set_up(state) : -1;
}

static int close_folder(void **state)
{
    char command[100];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return tear_down(state) | system(command);
}

static const char *path_of(const char *name)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* ---- the model ---- */

enum { RINGS = 5, BAR = 4 * RINGS, BAR_INDICES = 24 * (RINGS - 1) };
static const double HALF = 0.70710678118654752;

typedef struct blob {
    uint8_t bytes[8192];
    size_t used;
    char views[4096], accessors[4096];
    int count;
} blob;

/* An accessor; `type`: "SCALAR", "VEC3", …; 5126: float, 5123: 16 bits, 5121: 8 bits. */
static int put(blob *b, const void *data, size_t size, int component, const char *type, size_t count, const char *more)
{
    memcpy(b->bytes + b->used, data, size);
    const size_t view = strlen(b->views), accessor = strlen(b->accessors);
    snprintf(b->views + view, sizeof b->views - view, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}",
             b->count ? "," : "", b->used, size);
    snprintf(b->accessors + accessor, sizeof b->accessors - accessor,
             "%s{\"bufferView\":%d,\"componentType\":%d,\"type\":\"%s\",\"count\":%zu%s}", b->count ? "," : "",
             b->count, component, type, count, more);
    b->used = (b->used + size + 3) / 4 * 4;
    return b->count++;
}

static void put_bar(blob *b, float bad_weight)
{
    static const float around[4][2] = {{0.2f, 0.2f}, {0.2f, -0.2f}, {-0.2f, -0.2f}, {-0.2f, 0.2f}};
    float p[BAR][3], weights[BAR][4] = {{0}}, shift[BAR][3] = {{0}};
    uint8_t joints[BAR][4] = {{0}};
    uint16_t indices[BAR_INDICES];
    size_t n = 0;
    for (int i = 0; i < BAR; i++) {
        const float y = 0.5f * (float)(i / 4);
        p[i][0] = around[i % 4][0], p[i][1] = y, p[i][2] = around[i % 4][1];
        joints[i][1] = 1, weights[i][0] = 1 - y / 2, weights[i][1] = y / 2;
        if (i / 4 == RINGS - 1) shift[i][0] = 1;
    }
    if (bad_weight != 0) weights[3][0] = bad_weight;
    for (int r = 0; r + 1 < RINGS; r++)
        for (int k = 0; k < 4; k++) {
            const uint16_t a = (uint16_t)(4 * r + k), c = (uint16_t)(4 * r + (k + 1) % 4), up = 4;
            const uint16_t six[6] = {a, c, (uint16_t)(c + up), a, (uint16_t)(c + up), (uint16_t)(a + up)};
            memcpy(indices + n, six, sizeof six), n += 6;
        }
    put(b, p, sizeof p, 5126, "VEC3", BAR, ",\"min\":[-0.2,0,-0.2],\"max\":[0.2,2,0.2]");
    put(b, joints, sizeof joints, 5121, "VEC4", BAR, "");
    put(b, weights, sizeof weights, 5126, "VEC4", BAR, "");
    put(b, shift, sizeof shift, 5126, "VEC3", BAR, ",\"min\":[0,0,0],\"max\":[1,0,0]");
    put(b, indices, sizeof indices, 5123, "SCALAR", n, "");
}

/* Clips: "bend", 1 s: the knee turns by 90 degrees about z, the hip goes 1 m along x, the target's weight goes to 1;
 * "sway", 2 s: the hip turns by 90 degrees about x. */
static void put_clips(blob *b)
{
    const float zero[2] = {0, 1}, two[2] = {0, 2}, weights[2] = {0, 1}, moves[2][3] = {{0, 0, 0}, {1, 0, 0}};
    const float bend[2][4] = {{0, 0, 0, 1}, {0, 0, (float)HALF, (float)HALF}};
    const float sway[2][4] = {{0, 0, 0, 1}, {(float)HALF, 0, 0, (float)HALF}};
    const float binds[2][16] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                                {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}};
    put(b, zero, sizeof zero, 5126, "SCALAR", 2, ",\"min\":[0],\"max\":[1]");
    put(b, two, sizeof two, 5126, "SCALAR", 2, ",\"min\":[0],\"max\":[2]");
    put(b, bend, sizeof bend, 5126, "VEC4", 2, "");
    put(b, moves, sizeof moves, 5126, "VEC3", 2, "");
    put(b, weights, sizeof weights, 5126, "SCALAR", 2, "");
    put(b, sway, sizeof sway, 5126, "VEC4", 2, "");
    put(b, binds, sizeof binds, 5126, "MAT4", 2, "");
}

static const char *const SCENE =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"nodes\":[{\"name\":\"bar\",\"mesh\":0,\"skin\":0},{\"name\":\"hip\",\"children\":[2]},"
    "{\"name\":\"knee\",\"translation\":[0,1,0],\"children\":[%s]},{\"name\":\"box\",\"mesh\":1,\"translation\":[0,3,0]"
    "}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2},\"indices\":4,"
    "\"material\":0,"
    "\"targets\":[{\"POSITION\":3}]}],\"weights\":[0]},"
    "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":4,\"material\":0}]}],"
    "\"skins\":[{\"joints\":[%s],\"inverseBindMatrices\":11}],"
    "\"animations\":[{\"name\":\"bend\",\"samplers\":[{\"input\":5,\"output\":7},{\"input\":5,\"output\":8},"
    "{\"input\":5,\"output\":9}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}},"
    "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"translation\"}},"
    "{\"sampler\":2,\"target\":{\"node\":0,\"path\":\"weights\"}}]},"
    "{\"name\":\"sway\",\"samplers\":[{\"input\":6,\"output\":10}],"
    "\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"rotation\"}}]}],"
    "\"buffers\":[{\"byteLength\":%zu,\"uri\":\"%s\"}],\"bufferViews\":[%s],\"accessors\":[%s]}";

static const char *write_model(const char *name, float bad_weight, const char *below_knee, const char *joints,
                               const char *buffer)
{
    static char text[16384];
    blob b = {0};
    put_bar(&b, bad_weight);
    put_clips(&b);
    snprintf(text, sizeof text, SCENE, below_knee, joints, b.used, buffer, b.views, b.accessors);
    assert_true(daft_write_file(path_of("bar.bin"), b.bytes, b.used, NULL));
    assert_true(daft_write_file(path_of(name), text, strlen(text), NULL));
    return path_of(name);
}

/* Skips where this build or system has no Assimp. */
static daft_mesh load(daft_scene *scene, const char *path)
{
    daft_error error;
    const daft_mesh mesh = daft_mesh_load(scene, path, &error);
    if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) skip();
    if (!mesh.id) fail_msg("%s", error.message);
    return mesh;
}

static daft_mesh load_bar(daft_scene *scene) { return load(scene, write_model("bar.gltf", 0, "3", "1,2", "bar.bin")); }

static daft_entity make(daft_scene *scene, daft_mesh mesh, double x)
{
    daft_entity_def def = daft_default_entity_def();
    daft_error error;
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh, def.position = daft_dv3(x, 0, 0);
    const daft_entity entity = daft_entity_create(scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

static void play(daft_scene *scene, daft_entity entity, uint32_t clip, float start, float blend, bool loop)
{
    daft_play_def def = daft_default_play_def();
    daft_error error;
    def.clip = clip, def.start = start, def.blend = blend, def.loop = loop;
    if (!daft_entity_play(scene, entity, &def, &error)) fail_msg("%s", error.message);
}

/* The pose that rays meet. */
static const daft_trimesh *pose(daft_scene *scene, daft_entity entity)
{
    daft_ray_hit hit;
    daft_scene_cast_ray(scene, daft_dv3(0, -100, 0), daft_v3(0, -1, 0), 1, (daft_entity){0}, &hit, NULL);
    return &daft_animated_shown(scene->entities[daft_handle_index(entity.id)].animated, true)->mesh;
}

static const daft_trimesh *rest(daft_scene *scene, daft_mesh mesh) { return &daft_mesh_find(scene, mesh, NULL)->mesh; }

/* ---- the truth ---- */

static daft_dvec3 turn_z(daft_dvec3 p, double a)
{
    return daft_dv3(cos(a) * p.x - sin(a) * p.y, sin(a) * p.x + cos(a) * p.y, p.z);
}

/* Where "bend" at time t has a point of the bar (y up to 2), or of the box on the knee (y from 4). */
static daft_dvec3 bend(daft_dvec3 p, double t)
{
    const daft_dvec3 hip = daft_dv3(t, 0, 0), knee = daft_dv3(0, 1, 0);
    const double a = t * DAFT_PI / 2, weight = p.y > 3 ? 1 : p.y / 2;
    if (p.y == 2) p.x += t;
    const daft_dvec3 by_hip = daft_dadd(p, hip);
    const daft_dvec3 by_knee = daft_dadd(daft_dadd(turn_z(daft_dsub(p, knee), a), knee), hip);
    return daft_dadd(daft_dscale(by_hip, 1 - weight), daft_dscale(by_knee, weight));
}

static daft_dvec3 vertex(const daft_trimesh *m, uint32_t v)
{
    return daft_dv3((double)m->x[v], (double)m->y[v], (double)m->z[v]);
}

static void poses_are_those_of_matrices_in_double(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    const daft_trimesh *still = rest(f->scene, mesh);
    assert_int_equal(still->vertex_count, 2 * BAR);
    for (int i = 0; i <= 16; i++) {
        const double t = i / 16.0;
        play(f->scene, e, 0, 0, 0, false);
        assert_true(daft_entity_set_animation_time(f->scene, e, t, NULL));
        const daft_trimesh *m = pose(f->scene, e);
        for (uint32_t v = 0; v < m->vertex_count; v++) {
            const daft_dvec3 want = bend(vertex(still, v), t), off = daft_dsub(vertex(m, v), want);
            if (sqrt(daft_ddot(off, off)) > 2e-6)
                fail_msg("vertex %u at %g: off by %g", v, t, sqrt(daft_ddot(off, off)));
        }
        for (uint32_t k = 0; k < 3 * m->triangle_count; k++) {
            const daft_vec3 n = m->normals[m->normal_indices ? m->normal_indices[k] : m->indices[k]];
            assert_true(fabsf(daft_length(n) - 1) < 1e-6f);
        }
    }
    assert_int_equal(f->warnings, 0);
}

/* The box's normals turn with the knee: by a right angle at the clip's end. */
static void normals_turn_along(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    const daft_trimesh *still = rest(f->scene, mesh);
    uint32_t compared = 0;
    play(f->scene, e, 0, 1, 0, false);
    const daft_trimesh *m = pose(f->scene, e);
    for (uint32_t k = 0; k < 3 * m->triangle_count; k++) {
        const uint32_t at = m->normal_indices ? m->normal_indices[k] : m->indices[k];
        if (vertex(still, m->indices[k]).y < 3) continue;
        const daft_dvec3 want = turn_z(daft_to_double(still->normals[at]), DAFT_PI / 2);
        const daft_dvec3 off = daft_dsub(want, daft_to_double(m->normals[at]));
        assert_true(daft_ddot(off, off) < 1e-10);
        compared++;
    }
    assert_true(compared > 50);
}

static void every_pose_lies_within_its_clips_bounds(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    for (uint32_t clip = 0; clip < 2; clip++) {
        daft_clip_info info;
        assert_true(daft_mesh_get_clip(f->scene, mesh, clip, &info, NULL));
        assert_string_equal(info.name, clip ? "sway" : "bend");
        assert_true(fabs(info.duration - (clip ? 2 : 1)) < 1e-6);
        daft_entity_stop(f->scene, e, NULL);
        play(f->scene, e, clip, 0, 0, false);
        daft_vec3 low = daft_v3(1e9f, 1e9f, 1e9f), high = daft_neg(low);
        for (int i = 0; i <= 777; i++) {
            assert_true(daft_entity_set_animation_time(f->scene, e, info.duration * i / 777, NULL));
            const daft_trimesh *m = pose(f->scene, e);
            low = daft_min3(low, m->low), high = daft_max3(high, m->high);
        }
        assert_true(low.x >= info.low.x && low.y >= info.low.y && low.z >= info.low.z);
        assert_true(high.x <= info.high.x && high.y <= info.high.y && high.z <= info.high.z);
        const daft_vec3 size = daft_sub(high, low), bound = daft_sub(info.high, info.low);
        assert_true(bound.x < 1.5f * size.x + 0.5f && bound.y < 1.5f * size.y + 0.5f); /* and these are of use */
    }
}

/* ---- bits ---- */

static uint64_t bits_of(const char *isa, int threads)
{
    daft_engine_def def = daft_default_engine_def();
    def.isa = isa, def.threads = threads;
    daft_engine *engine = daft_engine_create(&def, NULL);
    if (!engine) return 0; /* this processor or build has it not */
    daft_scene *scene = daft_scene_create(engine, NULL);
    const daft_mesh mesh = load_bar(scene);
    uint64_t hash = 0;
    daft_entity e[3];
    for (int i = 0; i < 3; i++) {
        e[i] = make(scene, mesh, 4 * i);
        play(scene, e[i], i == 1, 0.37f * (float)i + 0.11f, 0, true);
        play(scene, e[i], i != 1, 0.2f, 1, true);
    }
    for (int tick = 0; tick < 20; tick++) {
        daft_scene_begin_tick(scene);
        assert_true(daft_scene_step(scene, 1 / 60.0f, NULL));
    }
    for (int i = 0; i < 3; i++) {
        const daft_trimesh *m = pose(scene, e[i]);
        hash = daft_hash(m->x, m->vertex_count * sizeof(float), hash);
        hash = daft_hash(m->y, m->vertex_count * sizeof(float), hash);
        hash = daft_hash(m->normals, m->normal_count * sizeof *m->normals, hash);
    }
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return hash;
}

static void bits_are_the_same_for_any_isa_and_threads(void **state)
{
    static const char *const names[] = {"plain", "sse2", "avx2", "avx512"};
    (void)state;
    const uint64_t want = bits_of(NULL, 1);
    assert_true(want != 0 && bits_of(NULL, 3) == want);
    for (size_t i = 0; i < DAFT_COUNT_OF(names); i++) {
        const uint64_t got = bits_of(names[i], 2);
        if (got && got != want) fail_msg("%s differs", names[i]);
    }
}

/* ---- only what it calls for ---- */

static void draw(daft_scene *scene, daft_vec3 towards, float alpha)
{
    daft_view view = daft_default_view();
    daft_error error;
    view.camera = daft_camera_look_at(daft_dv3(0, 1, 10), daft_dadd(daft_dv3(0, 1, 10), daft_to_double(towards)), 1);
    view.alpha = alpha;
    daft_image *image = daft_image_create(scene->engine, 64, 48, NULL);
    if (!daft_render(scene, &view, image, &error)) fail_msg("%s", error.message);
    daft_image_destroy(image);
}

static void tick(daft_scene *scene)
{
    daft_scene_begin_tick(scene);
    assert_true(daft_scene_step(scene, 1 / 60.0f, NULL));
}

static void what_does_not_play_or_is_out_of_sight_is_never_posed(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    const daft_counters *c = daft_scene_counters(f->scene);
    const daft_vec3 at = {0, 0, -1}, away = {0, 0, 1};
    for (int i = 0; i < 3; i++) tick(f->scene), draw(f->scene, at, 1);
    assert_true(c->poses == 0 && c->mesh_refits == 0);
    play(f->scene, e, 0, 0, 0, true);
    for (int i = 0; i < 5; i++) tick(f->scene), draw(f->scene, away, 1);
    assert_true(c->poses == 0 && c->poses_unseen == 5);
    for (int i = 0; i < 5; i++) tick(f->scene), draw(f->scene, at, 1);
    assert_true(c->poses == 5 && c->poses_unseen == 5 && c->mesh_refits == 5);
    draw(f->scene, at, 1); /* nothing has changed */
    assert_int_equal(c->poses, 5);
    draw(f->scene, away, 1); /* the list of before has all of it */
    assert_true(c->poses == 5 && c->poses_unseen == 5);
    tick(f->scene), draw(f->scene, away, 1), draw(f->scene, at, 1); /* what was left out is there again */
    assert_true(c->poses == 6 && c->poses_unseen == 6 && c->instances_seen > 0);
    daft_light_def light = daft_default_light_def(); /* whose shadow falls towards where the camera looks */
    light.position = daft_dv3(0, 1, -20);
    assert_true(daft_light_create(f->scene, &light, NULL).id);
    tick(f->scene), draw(f->scene, away, 1);
    assert_int_equal(c->poses_unseen, 6);
    assert_true(daft_entity_stop(f->scene, e, NULL));
    const uint64_t before = c->poses;
    tick(f->scene), draw(f->scene, at, 1);
    assert_true(c->poses == before);
}

/* Pictures that leave something out are those that do not. */
static void pictures_do_not_depend_on_what_is_left_out(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    daft_error error;
    daft_light_def light = daft_default_light_def();
    light.position = daft_dv3(3, 5, 3);
    assert_true(daft_light_create(f->scene, &light, NULL).id);
    daft_entity_def floor = daft_default_entity_def();
    floor.shape = DAFT_SHAPE_BOX, floor.size = daft_v3(60, 1, 60), floor.position = daft_dv3(0, -3, 0);
    assert_true(daft_entity_create(f->scene, &floor, NULL).id);
    for (int i = 0; i < 9; i++) play(f->scene, make(f->scene, mesh, 3 * i - 12), (uint32_t)i % 2, 0.3f, 0, true);
    daft_image *a = daft_image_create(f->engine, 96, 64, NULL), *b = daft_image_create(f->engine, 96, 64, NULL);
    for (int i = 0; i < 12; i++) {
        daft_view view = daft_default_view();
        tick(f->scene);
        view.camera = daft_camera_look_at(daft_dv3(0, 1, 6), daft_dv3(6 * cos(i), 0.5, 6 + 6 * sin(i)), 0.7f);
        assert_true(daft_render(f->scene, &view, a, &error));
        daft_material_def glass = daft_default_material_def(); /* with it, nothing is left out */
        glass.mirror = 1;
        const daft_material m = daft_material_create(f->scene, &glass, NULL);
        daft_scene_touch(f->scene);
        const uint64_t unseen = daft_scene_counters(f->scene)->poses_unseen;
        assert_true(daft_render(f->scene, &view, b, &error));
        assert_true(daft_scene_counters(f->scene)->poses_unseen == unseen);
        assert_memory_equal(daft_image_pixels(a), daft_image_pixels(b), 4 * 96 * 64);
        daft_material_release(f->scene, m, NULL), daft_scene_collect(f->scene);
    }
    assert_true(daft_scene_counters(f->scene)->poses_unseen > 12);
    daft_image_destroy(a), daft_image_destroy(b);
}

/* ---- times ---- */

static daft_animation now(daft_scene *scene, daft_entity e)
{
    daft_animation a;
    daft_error error;
    if (!daft_entity_get_animation(scene, e, &a, &error)) fail_msg("%s", error.message);
    return a;
}

static void clips_loop_end_turn_back_and_pass_over(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    daft_animation a;
    daft_error error;
    assert_true(!daft_entity_get_animation(f->scene, e, &a, &error) && error.code == DAFT_OK);
    play(f->scene, e, 0, 0, 0, true);
    for (int i = 0; i < 90; i++) tick(f->scene);
    assert_true(fabs(now(f->scene, e).time - 0.5) < 1e-5 && now(f->scene, e).playing);
    play(f->scene, e, 1, 0, 0.5f, false); /* passes over in 30 ticks */
    for (int i = 0; i < 15; i++) tick(f->scene);
    assert_true(fabsf(now(f->scene, e).weight - 0.5f) < 1e-5f && now(f->scene, e).clip == 1);
    assert_int_equal(f->scene->animated->track_count, 2);
    for (int i = 0; i < 17; i++) tick(f->scene);
    assert_true(now(f->scene, e).weight == 1 && f->scene->animated->track_count == 1);
    for (int i = 0; i < 120; i++) tick(f->scene);
    assert_true(!now(f->scene, e).playing && fabs(now(f->scene, e).time - 2) < 1e-6);
    const uint64_t revision = f->scene->revision;
    tick(f->scene); /* what has ended changes nothing any more */
    assert_true(f->scene->revision == revision);
    daft_play_def back = daft_default_play_def();
    back.clip = 1, back.speed = -2, back.loop = false;
    assert_true(daft_entity_play(f->scene, e, &back, &error));
    for (int i = 0; i < 30; i++) tick(f->scene);
    assert_true(fabs(now(f->scene, e).time - 1) < 1e-5);
}

/* Half-way between two ticks the picture has the pose of that time. */
static void pictures_show_the_time_between_ticks(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    play(f->scene, e, 0, 0, 0, true);
    for (int i = 0; i < 10; i++) tick(f->scene);
    draw(f->scene, daft_v3(0, 0, -1), 0.25f);
    const daft_animated *a = f->scene->entities[daft_handle_index(e.id)].animated;
    const daft_trimesh *m = &daft_animated_shown(a, false)->mesh, *still = rest(f->scene, mesh);
    for (uint32_t v = 0; v < m->vertex_count; v++) {
        const daft_dvec3 off = daft_dsub(vertex(m, v), bend(vertex(still, v), 9.25 / 60));
        assert_true(daft_ddot(off, off) < 1e-10);
    }
    const double shown = (double)m->x[2 * BAR - 1];
    pose(f->scene, e); /* rays have a pose of their own, that of the last tick */
    assert_true((double)m->x[2 * BAR - 1] == shown);
}

static void the_state_has_the_numbers_and_not_the_pose(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load_bar(f->scene);
    const daft_entity e = make(f->scene, mesh, 0);
    const uint64_t still = daft_scene_hash(f->scene);
    play(f->scene, e, 0, 0, 0, true);
    const uint64_t begun = daft_scene_hash(f->scene);
    tick(f->scene);
    const uint64_t later = daft_scene_hash(f->scene);
    draw(f->scene, daft_v3(0, 0, -1), 0.5f);
    assert_true(still != begun && begun != later && daft_scene_hash(f->scene) == later);
    assert_true(daft_entity_stop(f->scene, e, NULL) && daft_scene_hash(f->scene) == still);
}

/* ---- files ---- */

static void wrong_models_are_told_or_mended(void **state)
{
    fixture *f = *state;
    daft_error error;
    load_bar(f->scene);
    assert_int_equal(f->warnings, 0);
    load(f->scene, write_model("nan.gltf", NAN, "3", "1,2", "bar.bin")); /* Assimp takes it for no weight */
    load(f->scene, write_model("infinite.gltf", INFINITY, "3", "1,2", "bar.bin"));
    assert_true(f->warnings > 0 && strstr(f->last_warning.message, "weight"));
    static const char *const wrong[][3] = {{"3", "1,2", "nowhere.bin"}, /* no buffer */
                                           {"3,1", "1,2", "bar.bin"},   /* a circle */
                                           {"3", "", "bar.bin"},        /* a skin without bones */
                                           {"3,99", "1,2", "bar.bin"}}; /* no such node */
    for (size_t i = 0; i < DAFT_COUNT_OF(wrong); i++) {
        char name[32];
        snprintf(name, sizeof name, "wrong%zu.gltf", i);
        const char *path = write_model(name, 0, wrong[i][0], wrong[i][1], wrong[i][2]);
        if (!daft_mesh_load(f->scene, path, &error).id && !(error.code == DAFT_ERROR_SYNTAX && error.message[0]))
            fail_msg("%zu: %s", i, error.message);
        if (i == 0) assert_int_equal(error.code, DAFT_ERROR_SYNTAX);
    }
}

/* Numbers of the buffer replaced at random: it is refused, or plays with finite vertices. */
static void damaged_buffers_are_refused_or_play(void **state)
{
    fixture *f = *state;
    static const float odd[] = {NAN, INFINITY, -1, 0, 1e38f, -1e-38f, 65536};
    write_model("whole.gltf", 0, "3", "1,2", "hurt.bin");
    blob b = {0};
    put_bar(&b, 0), put_clips(&b);
    random_state = 88172645463325252u;
    for (int round = 0; round < 60; round++) {
        blob hurt = b;
        for (int i = 0; i < 1 + round % 8; i++) {
            const float value = odd[(size_t)uniform(0, 6.999)];
            memcpy(hurt.bytes + 4 * (size_t)uniform(0, (double)b.used / 4 - 1), &value, 4);
        }
        assert_true(daft_write_file(path_of("hurt.bin"), hurt.bytes, hurt.used, NULL));
        daft_scene *scene = daft_scene_create(f->engine, NULL);
        daft_error error;
        daft_mesh_info info = {0};
        const daft_mesh mesh = daft_mesh_load(scene, path_of("whole.gltf"), &error);
        if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) skip();
        if (mesh.id) assert_true(daft_mesh_get_info(scene, mesh, &info, NULL));
        for (uint32_t clip = 0; clip < info.clip_count; clip++) {
            const daft_entity e = make(scene, mesh, 0);
            play(scene, e, clip, 0.4f, 0, true);
            const daft_trimesh *m = pose(scene, e);
            for (uint32_t v = 0; v < m->vertex_count; v++)
                assert_true(isfinite(m->x[v]) && isfinite(m->y[v]) && isfinite(m->z[v]));
            for (uint32_t n = 0; n < m->normal_count; n++) assert_true(fabsf(daft_length(m->normals[n]) - 1) < 1e-5f);
        }
        daft_scene_destroy(scene);
    }
}

static void wrong_calls_are_told(void **state)
{
    fixture *f = *state;
    daft_error error;
    uint32_t clip;
    const daft_mesh mesh = load_bar(f->scene);
    assert_false(daft_mesh_find_clip(f->scene, mesh, "walk", &clip, &error));
    assert_string_equal(error.message, "the mesh has no clip 'walk'; it has bend, sway");
    const daft_entity ball = make_sphere(f->scene, 0, 0, 0, 1, (daft_entity){0});
    daft_play_def def = daft_default_play_def();
    assert_false(daft_entity_play(f->scene, ball, &def, &error));
    assert_true(strstr(error.message, "no mesh"));
    def.clip = 2;
    assert_false(daft_entity_play(f->scene, make(f->scene, mesh, 0), &def, &error));
    assert_string_equal(error.message, "clip is 2; the mesh has 2, counted from 0");
    assert_false(daft_entity_set_animation_time(f->scene, ball, 0, &error));
    daft_vec3 none[1] = {{0, 0, 0}};
    assert_false(daft_mesh_set_positions(f->scene, mesh, none, NULL, 1, &error));
}

static void scene_files_name_a_clip(void **state)
{
    fixture *f = *state;
    daft_error error;
    load_bar(f->scene);
    const char *good = "camera 0 1 9 0 -90\nmesh bar.gltf 0 0 0 1 clip sway\nmesh bar.gltf 3 0 0\n";
    const char *bad = "mesh bar.gltf 0 0 0 clip walk\n";
    assert_true(daft_write_file(path_of("good.scene"), good, strlen(good), NULL));
    if (!daft_scene_load(f->scene, path_of("good.scene"), &error)) fail_msg("%s", error.message);
    assert_true(f->scene->animated && !f->scene->animated->next && f->scene->animated->tracks[0].clip == 1);
    assert_true(daft_write_file(path_of("bad.scene"), bad, strlen(bad), NULL));
    assert_false(daft_scene_load(f->scene, path_of("bad.scene"), &error));
    assert_true(error.line == 1 && error.column == 26 && strstr(error.message, "it has bend, sway"));
}

/* A model of others, where it is there. */
static void a_models_own_clips_play(void **state)
{
    fixture *f = *state;
    const char *path = DAFT_ROOT "/../shared/data/gltf/greenman.glb";
    if (access(path, R_OK) != 0) {
        print_message("skipped: %s is not there\n", path);
        skip();
    }
    const daft_mesh mesh = load(f->scene, path);
    daft_mesh_info info;
    assert_true(daft_mesh_get_info(f->scene, mesh, &info, NULL));
    const daft_entity e = make(f->scene, mesh, 0);
    for (uint32_t clip = 0; clip < info.clip_count; clip++) {
        daft_clip_info c;
        assert_true(daft_mesh_get_clip(f->scene, mesh, clip, &c, NULL));
        play(f->scene, e, clip, (float)c.duration / 3, 0, true);
        const daft_trimesh *m = pose(f->scene, e);
        assert_true(m->low.x >= c.low.x && m->high.x <= c.high.x && m->low.y >= c.low.y && m->high.y <= c.high.y);
        const daft_vec3 size = daft_sub(m->high, m->low), was = daft_sub(info.high, info.low);
        assert_true(daft_length(size) < 3 * daft_length(was) && daft_length(size) > 0.3f * daft_length(was));
    }
}

/* ---- light ---- */

static daft_material glowing(daft_scene *scene)
{
    daft_material_def def = daft_default_material_def();
    def.emission = daft_v3(3, 2, 1);
    const daft_material material = daft_material_create(scene, &def, NULL);
    assert_true(material.id);
    return material;
}

/* As it is seen in the last picture, standing still. */
static daft_entity stand_still(daft_scene *scene, daft_entity entity, daft_material material)
{
    const daft_trimesh *m = &daft_animated_shown(scene->entities[daft_handle_index(entity.id)].animated, false)->mesh;
    daft_vec3 positions[200];
    assert_true(m->vertex_count <= DAFT_COUNT_OF(positions));
    for (uint32_t i = 0; i < m->vertex_count; i++) positions[i] = daft_v3(m->x[i], m->y[i], m->z[i]);
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = positions, mesh.vertex_count = m->vertex_count;
    mesh.indices = m->indices, mesh.triangle_count = m->triangle_count;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = daft_mesh_create(scene, &mesh, NULL), def.lights = true;
    def.material = material;
    const daft_entity still = daft_entity_create(scene, &def, NULL);
    assert_true(still.id);
    return still;
}

static uint32_t lights_of(daft_scene *scene, daft_entity entity, daft_light_source out[DAFT_GLOW_LIGHTS])
{
    uint32_t count;
    assert_true(daft_glow_lights(scene, daft_handle_index(entity.id), 1, daft_dv3(0, 0, 0), out, &count, NULL));
    for (uint32_t i = 0; i < count; i++) out[i].entity = 0;
    return count;
}

/* What plays and glows lights as what stands as it does just then, also where it is out of sight itself. */
static void light_follows_the_pose(void **state)
{
    fixture *f = *state;
    daft_error error;
    daft_image *image = daft_image_create(f->engine, 32, 32, NULL);
    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at(daft_dv3(0, 1, 9), daft_dv3(0, 1, 20), 1);
    const daft_material material = glowing(f->scene);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = load_bar(f->scene), def.material = material, def.lights = true;
    const daft_entity entity = daft_entity_create(f->scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    daft_vec3 before = {-9, -9, -9};
    for (int i = 0; i < 5; i++) {
        daft_light_source own[DAFT_GLOW_LIGHTS], other[DAFT_GLOW_LIGHTS];
        assert_true(daft_entity_stop(f->scene, entity, NULL));
        play(f->scene, entity, 0, 0.2f * (float)i, 0, false);
        if (!daft_render(f->scene, &view, image, &error)) fail_msg("%s", error.message);
        assert_int_equal(daft_scene_counters(f->scene)->poses, i + 1);
        const daft_entity still = stand_still(f->scene, entity, material);
        const uint32_t count = lights_of(f->scene, entity, own);
        assert_true(count > 0);
        assert_int_equal(lights_of(f->scene, still, other), count);
        assert_memory_equal(own, other, count * sizeof *own);
        assert_true(daft_length(daft_sub(own[0].position, before)) > 0.02f);
        before = own[0].position;
        assert_true(daft_entity_destroy(f->scene, still, NULL));
    }
    daft_image_destroy(image);
}

int main(void)
{
    if (!READS_BY_LIBRARY) return 77;
#define WITH_FOLDER(name) cmocka_unit_test_setup_teardown(name, open_folder, close_folder)
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(poses_are_those_of_matrices_in_double),
        WITH_FOLDER(normals_turn_along),
        WITH_FOLDER(every_pose_lies_within_its_clips_bounds),
        WITH_FOLDER(bits_are_the_same_for_any_isa_and_threads),
        WITH_FOLDER(what_does_not_play_or_is_out_of_sight_is_never_posed),
        WITH_FOLDER(pictures_do_not_depend_on_what_is_left_out),
        WITH_FOLDER(clips_loop_end_turn_back_and_pass_over),
        WITH_FOLDER(pictures_show_the_time_between_ticks),
        WITH_FOLDER(the_state_has_the_numbers_and_not_the_pose),
        WITH_FOLDER(wrong_models_are_told_or_mended),
        WITH_FOLDER(damaged_buffers_are_refused_or_play),
        WITH_FOLDER(wrong_calls_are_told),
        WITH_FOLDER(scene_files_name_a_clip),
        WITH_FOLDER(a_models_own_clips_play),
        WITH_FOLDER(light_follows_the_pose),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
