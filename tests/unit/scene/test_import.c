/* What Assimp does not say of glTF files: splines and steps between keys, against Hermite's formula in double; cameras
 * and lights, where nodes hang them and as bright as they say. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static char folder[64];

static int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-import-XXXXXX");
    return mkdtemp(folder) ? set_up(state) : -1;
}

static int close_folder(void **state)
{
    char command[100];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return tear_down(state) | system(command);
}

static const char *put(const char *name, const void *bytes, size_t size)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_true(daft_write_file(path, bytes, size, NULL));
    return path;
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

/* ---- a triangle that moves ---- */

enum { KEYS = 4, TARGETS = 2 };
static const float TIMES[KEYS] = {0.25f, 0.5f, 1.5f, 2};
static const float CORNERS[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}};
static const float SHIFTS[TARGETS][3][3] = {{{0, 0, 1}, {0, 0, 0}, {0, 2, 0}}, {{1, 0, 0}, {0, 0.5f, 0}, {0, 0, 0}}};

/* Of arriving at each key, of the key, of leaving it. */
typedef struct motion {
    float translation[KEYS][3][3], rotation[KEYS][3][4], weights[KEYS][3][TARGETS];
    float steps[KEYS][3];
} motion;

static motion make_motion(void)
{
    motion m;
    float *all = (float *)&m;
    uint64_t state = 20261127;
    for (size_t i = 0; i < sizeof m / sizeof(float); i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        all[i] = (float)((double)(state >> 40) / (1 << 23) - 1);
    }
    for (int k = 0; k < KEYS; k++) {
        float *q = m.rotation[k][1];
        const float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int i = 0; i < 4; i++) q[i] /= length;
    }
    return m;
}

typedef struct blob {
    uint8_t bytes[4096];
    size_t used;
    char views[2048], accessors[2048];
    int count;
} blob;

/* `more`: of the view, `bounds`: of the accessor. */
static void add(blob *b, const void *data, size_t size, const char *type, size_t count, const char *more,
                const char *bounds)
{
    const size_t view = strlen(b->views), accessor = strlen(b->accessors);
    memcpy(b->bytes + b->used, data, size);
    snprintf(b->views + view, sizeof b->views - view, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu%s}",
             b->count ? "," : "", b->used, size, more);
    snprintf(b->accessors + accessor, sizeof b->accessors - accessor,
             "%s{\"bufferView\":%d,\"componentType\":5126,\"type\":\"%s\",\"count\":%zu%s}", b->count ? "," : "",
             b->count, type, count, bounds);
    b->used += size, b->count++;
}

static const char *const SCENE =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[1,0]}],"
    "\"nodes\":[{\"name\":\"part \\u00e9\",\"mesh\":0},{\"name\":\"empty\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1},{\"POSITION\":2}]}],"
    "\"weights\":[0,0]}],"
    "\"animations\":[{\"name\":\"spline\",\"samplers\":["
    "{\"input\":3,\"output\":4,\"interpolation\":\"CUBICSPLINE\"},"
    "{\"input\":3,\"output\":5,\"interpolation\":\"CUBICSPLINE\"},"
    "{\"input\":3,\"output\":6,\"interpolation\":\"CUBICSPLINE\"}],"
    "\"channels\":[{\"sampler\":2,\"target\":{\"node\":0,\"path\":\"weights\"}},"
    "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}},"
    "{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"rotation\"}}]},"
    "{\"name\":\"step\",\"samplers\":[{\"input\":3,\"output\":7,\"interpolation\":\"STEP\"}],"
    "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}],"
    "\"buffers\":[{\"byteLength\":%zu%s}],\"bufferViews\":[%s],\"accessors\":[%s]}";

static void base64(const uint8_t *bytes, size_t size, char *out)
{
    static const char LETTERS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const uint32_t three = (uint32_t)bytes[i] << 16 | (uint32_t)(i + 1 < size ? bytes[i + 1] : 0) << 8 |
                               (uint32_t)(i + 2 < size ? bytes[i + 2] : 0);
        for (int k = 0; k < 4; k++) *out++ = LETTERS[three >> (18 - 6 * k) & 63];
        if (i + 2 >= size) out[-1] = '=';
        if (i + 1 >= size) out[-2] = '=';
    }
    *out = 0;
}

/* The bytes of a GLB: text and binary in chunks. */
static size_t make_glb(const char *text, const blob *b, uint8_t *out)
{
    const size_t length = (strlen(text) + 3) / 4 * 4, size = 12 + 8 + length + 8 + b->used;
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)size, (uint32_t)length, 0x4e4f534a},
                   next[2] = {(uint32_t)b->used, 0x004e4942};
    memcpy(out, head, sizeof head);
    memset(out + 20, ' ', length), memcpy(out + 20, text, strlen(text));
    memcpy(out + 20 + length, next, 8), memcpy(out + 28 + length, b->bytes, b->used);
    return size;
}

/* `how`: "bin" a file beside it, "uri" in the text, "glb" in a chunk. */
static const char *write_model(const motion *m, const char *how, const char *more)
{
    static char text[20000], uri[8000];
    static uint8_t bytes[24000];
    blob b = {0};
    const char *any = ",\"min\":[-9,-9,-9],\"max\":[9,9,9]";
    add(&b, CORNERS, sizeof CORNERS, "VEC3", 3, "", any);
    for (int i = 0; i < TARGETS; i++) add(&b, SHIFTS[i], sizeof SHIFTS[i], "VEC3", 3, "", any);
    add(&b, TIMES, sizeof TIMES, "SCALAR", KEYS, "", ",\"min\":[0.25],\"max\":[2]");
    add(&b, m->translation, sizeof m->translation, "VEC3", 3 * KEYS, more, "");
    add(&b, m->rotation, sizeof m->rotation, "VEC4", 3 * KEYS, "", "");
    add(&b, m->weights, sizeof m->weights, "SCALAR", 3 * KEYS * TARGETS, "", "");
    add(&b, m->steps, sizeof m->steps, "VEC3", KEYS, "", "");
    uri[0] = 0;
    if (strcmp(how, "bin") == 0) snprintf(uri, sizeof uri, ",\"uri\":\"moves.bin\"");
    if (strcmp(how, "uri") == 0) {
        static char digits[7000];
        base64(b.bytes, b.used, digits);
        snprintf(uri, sizeof uri, ",\"uri\":\"data:application/octet-stream;base64,%s\"", digits);
    }
    snprintf(text, sizeof text, SCENE, b.used, uri, b.views, b.accessors);
    put("moves.bin", b.bytes, b.used);
    return strcmp(how, "glb") == 0 ? put("moves.glb", bytes, make_glb(text, &b, bytes))
                                   : put("moves.gltf", text, strlen(text));
}

/* ---- the truth ---- */

/* glTF 2.0, appendix C: `keys` are of `width` numbers three times. */
static void hermite(const float *keys, int width, double time, double out[4])
{
    int k = 0;
    while (k + 2 < KEYS && time >= (double)TIMES[k + 1]) k++;
    const double from = (double)TIMES[k], length = (double)TIMES[k + 1] - from,
                 t = fmin(fmax((time - from) / length, 0), 1), t2 = t * t, t3 = t2 * t;
    const float *a = keys + (size_t)(3 * width * k), *b = a + (size_t)(3 * width);
    for (int i = 0; i < width; i++)
        out[i] = (2 * t3 - 3 * t2 + 1) * (double)a[width + i] + length * (t3 - 2 * t2 + t) * (double)a[2 * width + i] +
                 (-2 * t3 + 3 * t2) * (double)b[width + i] + length * (t3 - t2) * (double)b[i];
}

static daft_dvec3 turned(const double given[4], daft_dvec3 p)
{
    const double length = sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2] + given[3] * given[3]);
    const daft_dvec3 u = daft_dscale(daft_dv3(given[0], given[1], given[2]), 1 / length);
    const daft_dvec3 c = daft_dadd(daft_dcross(u, p), daft_dscale(p, given[3] / length));
    return daft_dadd(p, daft_dscale(daft_dcross(u, c), 2));
}

static daft_dvec3 expected(const motion *m, bool step, double time, int corner)
{
    double q[4], w[4], t[4];
    const float *c = CORNERS[corner];
    daft_dvec3 p = daft_dv3((double)c[0], (double)c[1], (double)c[2]);
    if (step) {
        int k = 0;
        while (k + 1 < KEYS && time >= (double)TIMES[k + 1]) k++;
        return daft_dadd(p, daft_dv3((double)m->steps[k][0], (double)m->steps[k][1], (double)m->steps[k][2]));
    }
    hermite(m->weights[0][0], TARGETS, time, w);
    hermite(m->rotation[0][0], 4, time, q);
    hermite(m->translation[0][0], 3, time, t);
    for (int i = 0; i < TARGETS; i++) {
        const float *s = SHIFTS[i][corner];
        p = daft_dadd(p, daft_dscale(daft_dv3((double)s[0], (double)s[1], (double)s[2]), w[i]));
    }
    return daft_dadd(turned(q, p), daft_dv3(t[0], t[1], t[2]));
}

/* ---- clips ---- */

static daft_entity make(daft_scene *scene, daft_mesh mesh)
{
    daft_entity_def def = daft_default_entity_def();
    daft_error error;
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh;
    const daft_entity entity = daft_entity_create(scene, &def, &error);
    if (!entity.id) fail_msg("%s", error.message);
    return entity;
}

/* What rays meet at a time of a clip. */
static const daft_trimesh *pose(daft_scene *scene, daft_entity entity, uint32_t clip, double time)
{
    daft_play_def def = daft_default_play_def();
    daft_ray_hit hit;
    def.clip = clip, def.loop = false;
    assert_true(daft_entity_play(scene, entity, &def, NULL));
    assert_true(daft_entity_set_animation_time(scene, entity, time, NULL));
    daft_scene_cast_ray(scene, daft_dv3(0, -100, 0), daft_v3(0, -1, 0), 1, (daft_entity){0}, &hit, NULL);
    return &daft_animated_shown(scene->entities[daft_handle_index(entity.id)].animated, true)->mesh;
}

static double error_of(const daft_trimesh *m, const motion *moves, bool step, double time)
{
    double worst = 0;
    for (int corner = 0; corner < 3; corner++) {
        const daft_dvec3 got = daft_dv3((double)m->x[corner], (double)m->y[corner], (double)m->z[corner]),
                         off = daft_dsub(got, expected(moves, step, time, corner));
        worst = fmax(worst, sqrt(daft_ddot(off, off)));
    }
    return worst;
}

static void splines_and_steps_are_what_gltf_says(void **state)
{
    fixture *f = *state;
    static const char *const HOW[] = {"bin", "uri", "glb"};
    const motion moves = make_motion();
    for (size_t how = 0; how < DAFT_COUNT_OF(HOW); how++) {
        daft_scene *scene = daft_scene_create(f->engine, NULL);
        const daft_mesh mesh = load(scene, write_model(&moves, HOW[how], ""));
        const daft_entity e = make(scene, mesh);
        double worst = 0;
        for (uint32_t clip = 0; clip < 2; clip++) {
            daft_clip_info info;
            assert_true(daft_mesh_get_clip(scene, mesh, clip, &info, NULL) && info.duration == 2);
            for (int i = 0; i <= 400; i++) {
                const double time = i / 200.0;
                const daft_trimesh *m = pose(scene, e, clip, time);
                worst = fmax(worst, error_of(m, &moves, clip == 1, time));
                assert_true(m->low.x >= info.low.x && m->high.x <= info.high.x && m->low.y >= info.low.y &&
                            m->high.y <= info.high.y && m->low.z >= info.low.z && m->high.z <= info.high.z);
            }
        }
        print_message("%s: off by %.2g at most\n", HOW[how], worst);
        assert_true(worst < 5e-6);
        daft_scene_destroy(scene);
    }
    assert_int_equal(f->warnings, 0);
}

/* Packed in a way that is not read: straight between the keys, and told so. */
static void splines_that_cannot_be_read_are_told(void **state)
{
    fixture *f = *state;
    const motion moves = make_motion();
    const daft_mesh mesh = load(f->scene, write_model(&moves, "bin", ",\"extensions\":{\"OTHER\":{}}"));
    assert_true(f->warnings == 1 && strstr(f->last_warning.message, "the clip 'spline' goes straight between keys"));
    const daft_entity e = make(f->scene, mesh);
    assert_true(error_of(pose(f->scene, e, 0, 0.5), &moves, false, 0.5) < 5e-6); /* at a key */
    assert_true(error_of(pose(f->scene, e, 0, 1), &moves, false, 1) > 1e-3);
}

/* ---- cameras and lights ---- */

/* A lamp that two nodes share, below a node that is moved, turned by 90 degrees about y and twice as large; a spot, a
 * sun, two cameras and one that is no perspective one. */
static const char *const LIT =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
    "{\"type\":\"point\",\"intensity\":40,\"color\":[1,0.5,0.25],\"range\":20},"
    "{\"type\":\"spot\",\"intensity\":80,\"spot\":{\"innerConeAngle\":0.25,\"outerConeAngle\":0.5}},"
    "{\"type\":\"directional\",\"intensity\":3}]}},"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}},"
    "{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"aspectRatio\":1.5,\"znear\":0.1,\"zfar\":10}},"
    "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,\"znear\":0.1,\"zfar\":10}}],"
    "\"nodes\":[{\"name\":\"root\",\"mesh\":0,\"children\":[1,3,4,5,6,7]},"
    "{\"name\":\"arm\",\"translation\":[1,2,3],\"rotation\":[0,0.70710678118654752,0,0.70710678118654752],"
    "\"scale\":[2,2,2],\"children\":[2,8]},"
    "{\"name\":\"lamp\",\"translation\":[0,0,-1],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
    "{\"name\":\"spot\",\"translation\":[0,4,0],\"rotation\":[-0.70710678118654752,0,0,0.70710678118654752],"
    "\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
    "{\"name\":\"sun\",\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},"
    "{\"name\":\"other lamp\",\"translation\":[5,0,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
    "{\"name\":\"front\",\"translation\":[0,1,6],\"camera\":0},"
    "{\"name\":\"flat\",\"camera\":2},"
    "{\"name\":\"side\",\"camera\":1,\"rotation\":[0,0,0.38268343236508977,0.92387953251128674]}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"corners.bin\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,"
    "\"min\":[0,0,0],\"max\":[1,1,0.5]}]}";

static const char *write_lit(void)
{
    put("corners.bin", CORNERS, sizeof CORNERS);
    return put("lit.gltf", LIT, strlen(LIT));
}

static bool near3(daft_dvec3 a, double x, double y, double z)
{
    return fabs(a.x - x) < 1e-5 && fabs(a.y - y) < 1e-5 && fabs(a.z - z) < 1e-5;
}

static daft_light_def light_named(daft_scene *scene, daft_mesh mesh, const char *name, const daft_transform *at)
{
    daft_mesh_light one;
    for (uint32_t i = 0; daft_mesh_get_light(scene, mesh, i, at, &one, NULL); i++)
        if (strcmp(one.name, name) == 0) return one.light;
    fail_msg("no light '%s'", name);
    return daft_default_light_def();
}

static void lights_stand_where_their_nodes_do(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load(f->scene, write_lit());
    daft_mesh_info info;
    assert_true(daft_mesh_get_info(f->scene, mesh, &info, NULL) && info.light_count == 4 && info.camera_count == 2);
    assert_true(f->warnings == 1 && strstr(f->last_warning.message, "camera 'flat' is no perspective one"));
    const daft_light_def lamp = light_named(f->scene, mesh, "lamp", NULL),
                         other = light_named(f->scene, mesh, "other lamp", NULL),
                         spot = light_named(f->scene, mesh, "spot", NULL),
                         sun = light_named(f->scene, mesh, "sun", NULL);
    assert_true(lamp.kind == DAFT_LIGHT_POINT && lamp.inverse_square && lamp.range == 20);
    assert_true(near3(lamp.position, -1, 2, 3) && near3(other.position, 5, 0, 0)); /* -z, turned, is -x */
    assert_true(near3(daft_to_double(lamp.color), 40 / DAFT_PI, 20 / DAFT_PI, 10 / DAFT_PI));
    assert_true(spot.kind == DAFT_LIGHT_SPOT && near3(spot.position, 0, 4, 0));
    assert_true(near3(daft_to_double(spot.direction), 0, -1, 0));
    assert_true(spot.inner_angle == 0.25f && spot.outer_angle == 0.5f && spot.range == 0);
    assert_true(sun.kind == DAFT_LIGHT_SUN && !sun.inverse_square && near3(daft_to_double(sun.direction), 0, 0, -1));
    assert_true(fabsf(sun.color.x - (float)(3 / DAFT_PI)) < 1e-6f);
    const daft_transform at = {{0, 0, 10}, {0, 1, 0, 0}, {2, 2, 2}}; /* half a turn about y */
    assert_true(near3(light_named(f->scene, mesh, "lamp", &at).position, 2, 4, 4));
    assert_true(near3(daft_to_double(light_named(f->scene, mesh, "sun", &at).direction), 0, 0, 1));
}

/* The corners of its picture lie where the file's axes say. */
static void cameras_look_as_their_nodes_do(void **state)
{
    fixture *f = *state;
    const daft_mesh mesh = load(f->scene, write_lit());
    daft_mesh_camera front, side;
    daft_error error;
    assert_true(daft_mesh_get_camera(f->scene, mesh, 0, NULL, &front, NULL));
    assert_true(daft_mesh_get_camera(f->scene, mesh, 1, NULL, &side, NULL));
    assert_string_equal(front.name, "front");
    assert_string_equal(side.name, "side");
    assert_true(near3(front.camera.position, 0, 1, 6) && near3(side.camera.position, 1, 2, 3));
    assert_true(fabs(tan((double)front.camera.fov / 2) - tan(0.4) * 16 / 9) < 1e-6);
    assert_true(fabs(tan((double)side.camera.fov / 2) - tan(0.4) * 1.5) < 1e-6);
    const daft_dvec3 corner = daft_to_double(daft_camera_ray(&front.camera, 1, 0, 9.0 / 16));
    assert_true(near3(daft_dscale(corner, -1 / corner.z), tan(0.4) * 16 / 9, tan(0.4), -1));
    /* it looks along -x, leaning left by 45 degrees: its right is up and back */
    const daft_dvec3 edge = daft_to_double(daft_camera_ray(&side.camera, 1, 0.5, 1 / 1.5));
    const double across = tan(0.4) * 1.5 * sqrt(0.5);
    assert_true(near3(daft_dscale(edge, -1 / edge.x), -1, across, -across));
    assert_false(daft_mesh_get_camera(f->scene, mesh, 2, NULL, &side, &error));
    assert_string_equal(error.message, "camera 2 of a mesh that has 2");
    assert_false(daft_mesh_get_light(f->scene, mesh, 4, NULL, &(daft_mesh_light){0}, &error));
    assert_true(daft_scene_add_camera(f->scene, &front.camera, NULL) && daft_scene_camera_count(f->scene) == 1);
    assert_true(daft_scene_camera(f->scene, 1).fov == front.camera.fov);
}

/* A line of a scene adds what it asks for, and nothing else. */
static void scenes_ask_for_cameras_and_lights(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *words;
        uint32_t cameras, lights;
    } cases[] = {{"", 0, 0}, {"lights", 0, 4}, {"cameras", 2, 0}, {"cameras lights name=lamp shadow=false", 2, 4}};
    load(f->scene, write_lit());
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        char text[200];
        daft_scene *scene = daft_scene_create(f->engine, NULL);
        daft_error error;
        snprintf(text, sizeof text, "camera 1 2 3\nmesh lit.gltf 0 0 10 2 0 180 0 %s\n", cases[i].words);
        if (!daft_scene_load(scene, put("lit.scene", text, strlen(text)), &error)) fail_msg("%s", error.message);
        assert_int_equal(daft_scene_camera_count(scene), 1 + cases[i].cameras);
        assert_int_equal(scene->light_slots.live, cases[i].lights);
        assert_true(daft_scene_camera(scene, 1).position.x == 1);
        uint32_t moved = 0;
        for (uint32_t k = 0; k < cases[i].lights; k++) moved += near3(scene->lights[k].position, 2, 4, 4);
        assert_int_equal(moved, cases[i].lights ? 1 : 0); /* the lamp, turned, twice as far and moved */
        daft_scene_destroy(scene);
    }
}

/* A model of others, where it is there: Blender's default scene. */
static void fbx_has_cameras_and_lights(void **state)
{
    fixture *f = *state;
    const char *path = DAFT_ROOT "/../shared/data/fbx/spider.fbx";
    if (access(path, R_OK) != 0) {
        print_message("skipped: %s is not there\n", path);
        skip();
    }
    const daft_mesh mesh = load(f->scene, path);
    daft_mesh_camera camera;
    daft_mesh_light lamp;
    assert_true(daft_mesh_get_camera(f->scene, mesh, 0, NULL, &camera, NULL));
    assert_true(daft_mesh_get_light(f->scene, mesh, 0, NULL, &lamp, NULL));
    assert_string_equal(camera.name, "Camera");
    assert_string_equal(lamp.name, "Lamp");
    assert_true(fabsf(camera.camera.fov - 0.857556f) < 1e-5f && fabsf(camera.camera.roll) < 0.05f);
    assert_true(lamp.light.kind == DAFT_LIGHT_POINT && lamp.light.inverse_square);
    /* it looks at the origin, nearly */
    const daft_dvec3 p = camera.camera.position, ahead = daft_to_double(daft_camera_ray(&camera.camera, 0.5, 0.5, 1));
    assert_true(-daft_ddot(p, ahead) > 0.95 * sqrt(daft_ddot(p, p)));
}

int main(void)
{
    if (!READS_BY_LIBRARY) return 77;
#define WITH_FOLDER(name) cmocka_unit_test_setup_teardown(name, open_folder, close_folder)
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(splines_and_steps_are_what_gltf_says), WITH_FOLDER(splines_that_cannot_be_read_are_told),
        WITH_FOLDER(lights_stand_where_their_nodes_do),    WITH_FOLDER(cameras_look_as_their_nodes_do),
        WITH_FOLDER(scenes_ask_for_cameras_and_lights),    WITH_FOLDER(fbx_has_cameras_and_lights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
