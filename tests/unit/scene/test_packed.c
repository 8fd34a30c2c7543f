/* glTF files whose numbers are packed as bytes and 16 bits: the model is that of the same numbers as floats, whether in
 * a text or a GLB; what is broken anywhere is told. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static char folder[64];

static int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-packed-XXXXXX");
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

/* ---- a model, packed or not ---- */

enum { POINTS = 6, KEYS = 3, BYTE = 5120, UBYTE = 5121, SHORT = 5122, USHORT = 5123, FLOAT = 5126 };

typedef struct blob {
    uint8_t bytes[4096];
    size_t used;
    char views[2048], accessors[2048];
    int count;
} blob;

static size_t size_of(int type) { return type < SHORT ? 1 : type < FLOAT ? 2 : 4; }

static double largest(int type) { return type == BYTE ? 127 : type == UBYTE ? 255 : type == SHORT ? 32767 : 65535; }

/* Whole numbers of the type that stand for -1..1, `width` of them an item; or, unless `packed`, what they stand for.
 * Items begin at multiples of four bytes, as glTF wants it. */
static void add(blob *b, bool packed, int type, const char *kind, int width, int count, const int *numbers)
{
    const int kept = packed ? type : FLOAT;
    const size_t size = size_of(kept), stride = (size * (size_t)width + 3) / 4 * 4, from = b->used;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < width; k++) {
            const int n = numbers[i * width + k];
            const float real = (float)fmax((float)n / (float)largest(type), -1);
            uint8_t *at = b->bytes + from + (size_t)i * stride + (size_t)k * size;
            if (kept == FLOAT)
                memcpy(at, &real, 4);
            else
                memcpy(at, &n, size); /* little-endian, as the file */
        }
    b->used += stride * (size_t)count;
    const size_t view = strlen(b->views), accessor = strlen(b->accessors);
    snprintf(b->views + view, sizeof b->views - view,
             "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu}", b->count ? "," : "", from,
             b->used - from, stride);
    snprintf(b->accessors + accessor, sizeof b->accessors - accessor,
             "%s{ \"bufferView\" : %d, \"componentType\":%d,\"type\":\"%s\",\"count\":%d%s}", b->count ? "," : "",
             b->count, kept, kind, count, kept == FLOAT ? "" : ",\"normalized\":true");
    b->count++;
}

static void add_raw(blob *b, const void *data, size_t size, int type, const char *kind, int count, const char *more)
{
    const size_t view = strlen(b->views), accessor = strlen(b->accessors);
    memcpy(b->bytes + b->used, data, size);
    snprintf(b->views + view, sizeof b->views - view, ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", b->used,
             size);
    snprintf(b->accessors + accessor, sizeof b->accessors - accessor,
             ",{\"bufferView\":%d,\"componentType\":%d,\"type\":\"%s\",\"count\":%d%s}", b->count, type, kind, count,
             more);
    b->used += (size + 3) / 4 * 4, b->count++;
}

static void fill(blob *b, bool packed)
{
    static const int positions[POINTS * 3] = {0,     0, 0,     32767, 0,     0,      32767, 20000, 100,
                                              32767, 5, 20000, 0,     32767, -32768, 0,     12345, 7};
    static const int normals[POINTS * 3] = {127, 0, 0, 0, 127, 0, 0, 0, 127, -128, 0, 0, 0, -127, 0, 90, 90, 0};
    static const int corners[POINTS * 2] = {0, 0, 65535, 0, 65535, 65535, 12345, 1, 2, 54321, 40000, 30000};
    static const int weights[POINTS * 4] = {255, 0,   0, 0, 0,  255, 0,   0, 128, 127, 0,  0,
                                            1,   254, 0, 0, 55, 100, 100, 0, 85,  85,  85, 0};
    static const int turns[KEYS * 4] = {0, 0, 0, 32767, 23170, 0, 0, 23170, 0, -23170, 0, 23170};
    static const uint8_t joints[POINTS][4] = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0},
                                              {0, 1, 0, 0}, {1, 0, 2, 0}, {0, 1, 2, 0}};
    static const float times[KEYS] = {0, 0.5f, 1};
    static const uint16_t indices[] = {0, 1, 2, 3, 4, 5};
    add(b, packed, SHORT, "VEC3", 3, POINTS, positions);
    add(b, packed, BYTE, "VEC3", 3, POINTS, normals);
    add(b, packed, USHORT, "VEC2", 2, POINTS, corners);
    add(b, packed, UBYTE, "VEC4", 4, POINTS, weights);
    add(b, packed, SHORT, "VEC4", 4, KEYS, turns);
    add_raw(b, joints, sizeof joints, UBYTE, "VEC4", POINTS, "");
    add_raw(b, times, sizeof times, FLOAT, "SCALAR", KEYS, ",\"min\":[0],\"max\":[1]");
    add_raw(b, indices, sizeof indices, USHORT, "SCALAR", POINTS, "");
}

/* The bytes of the file; they stay until the next one. */
static const void *make_model(bool packed, bool glb, size_t *size)
{
    static const char SCENE[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu%s}],\"scene\":0,\"scenes\":[{\"nodes\":[0,1]"
        "}],\"nodes\":[{\"name\":\"skinned\",\"mesh\":0,\"skin\":0},{\"name\":\"a\",\"children\":[2]},{\"name\":\"b\","
        "\"children\":[3]},{\"name\":\"c\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
        "\"TEXCOORD_0\":2,\"WEIGHTS_0\":3,\"JOINTS_0\":5},\"indices\":7}]}],\"skins\":[{\"joints\":[1,2,3]}],"
        "\"bufferViews\":[%s ] , \"animations\":[{\"name\":\"turn\",\"samplers\":[{\"input\":6,\"output\":4}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}}]}],\"accessors\":[%s]}";
    static char text[8192];
    static uint8_t bytes[16384];
    blob b = {0};
    fill(&b, packed);
    *size =
        (size_t)snprintf(text, sizeof text, SCENE, b.used, glb ? "" : ",\"uri\":\"packed.bin\"", b.views, b.accessors);
    if (!glb) {
        put("packed.bin", b.bytes, b.used);
        return text;
    }
    const size_t length = (*size + 3) / 4 * 4, all = 28 + length + b.used;
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)all, (uint32_t)length, 0x4e4f534a},
                   next[2] = {(uint32_t)b.used, 0x004e4942};
    memcpy(bytes, head, sizeof head), memset(bytes + 20, ' ', length), memcpy(bytes + 20, text, *size);
    memcpy(bytes + 20 + length, next, 8), memcpy(bytes + 28 + length, b.bytes, b.used);
    *size = all;
    return bytes;
}

/* Skips where this build or system has no Assimp. */
static const daft_mesh_item *load(fixture *f, const char *path)
{
    daft_error error;
    const daft_mesh mesh = daft_mesh_load(f->scene, path, &error);
    if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) skip();
    if (!mesh.id) fail_msg("%s", error.message);
    return f->scene->assets.meshes[daft_asset_index(mesh.id)];
}

/* ---- the tests ---- */

static void packed_numbers_are_what_they_stand_for(void **state)
{
    static const char *const NAMES[] = {"floats.gltf", "packed.gltf", "floats.glb", "packed.glb"};
    fixture *f = *state;
    const daft_mesh_item *all[4];
    for (int i = 0; i < 4; i++) {
        size_t size;
        const void *bytes = make_model(i % 2, i >= 2, &size);
        all[i] = load(f, put(NAMES[i], bytes, size));
    }
    const daft_mesh_item *a = all[0];
    assert_non_null(a->rig);
    assert_int_equal(a->mesh.vertex_count, POINTS);
    /* The third point hangs on two joints by halves: what is read as bits of floats has it on one. */
    double least = 1;
    for (int i = 0; i < POINTS; i++) least = fmin(least, (double)a->rig->vertices.weights[0][i]);
    assert_true(least < 0.6);
    for (int i = 1; i < 4; i++) {
        const daft_mesh_item *b = all[i];
        assert_int_equal(b->mesh.vertex_count, POINTS);
        assert_memory_equal(a->mesh.x, b->mesh.x, POINTS * sizeof(float));
        assert_memory_equal(a->mesh.z, b->mesh.z, POINTS * sizeof(float));
        assert_memory_equal(a->mesh.uvs, b->mesh.uvs, a->mesh.uv_count * sizeof *a->mesh.uvs);
        assert_int_equal(a->rig->normals.count, b->rig->normals.count);
        assert_memory_equal(a->rig->normals.x, b->rig->normals.x, a->rig->normals.count * sizeof(float));
        for (int k = 0; k < DAFT_RIG_WEIGHTS; k++) {
            assert_memory_equal(a->rig->vertices.weights[k], b->rig->vertices.weights[k], POINTS * sizeof(float));
            assert_memory_equal(a->rig->vertices.joints[k], b->rig->vertices.joints[k], POINTS * sizeof(int32_t));
        }
        const daft_rig_clip *x = a->rig->clips, *y = b->rig->clips;
        uint32_t turns = 0;
        assert_int_equal(x->track_count, y->track_count);
        for (uint32_t k = 0; k < x->track_count; k++) {
            const daft_rig_track *t = &x->tracks[k];
            turns += t->channel == DAFT_RIG_ROTATION && t->count == KEYS;
            assert_memory_equal(t->values, y->tracks[k].values, t->count * daft_rig_width(t->channel) * sizeof(float));
        }
        assert_int_equal(turns, 1);
    }
    assert_int_equal(f->warnings, 0);
}

/* Cut off anywhere, or with a letter that is another: a model or a message. */
static void broken_files_are_told(void **state)
{
    fixture *f = *state;
    char text[16384];
    daft_error error;
    for (int glb = 0; glb < 2; glb++) {
        size_t size;
        const char *bytes = make_model(true, glb, &size);
        load(f, put(glb ? "whole.glb" : "whole.gltf", bytes, size));
        for (size_t i = 0; i < size; i += 7) {
            char name[40];
            memcpy(text, bytes, size);
            if (i % 2 == 0) text[i] = "]}[{\",:0"[i / 2 % 8];
            snprintf(name, sizeof name, "broken%zu.%s", i, glb ? "glb" : "gltf");
            const char *path = put(name, text, i % 2 ? i : size);
            const daft_mesh mesh = daft_mesh_load(f->scene, path, &error);
            assert_true(mesh.id || error.message[0]);
            unlink(path);
        }
    }
}

/* Assimp would look for the matrices. */
static void a_skin_of_nothing_is_told(void **state)
{
    static const char TEXT[] = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                               "\"nodes\":[{\"mesh\":0,\"skin\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{}}]"
                               "}],\"skins\":[{\"joints\":[0]}]}";
    fixture *f = *state;
    daft_error error;
    const daft_mesh mesh = daft_mesh_load(f->scene, put("nothing.gltf", TEXT, sizeof TEXT - 1), &error);
    if (error.code == DAFT_ERROR_UNSUPPORTED) skip();
    assert_true(!mesh.id && strstr(error.message, "a skin without numbers"));
}

int main(void)
{
    if (!READS_BY_LIBRARY) return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(packed_numbers_are_what_they_stand_for, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(broken_files_are_told, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(a_skin_of_nothing_is_told, open_folder, close_folder)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
