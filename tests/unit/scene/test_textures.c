/* Textures: a file is read once, however many names reach it, and anew once it has changed; images of all sizes, and
 * what is none. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static char folder[64];

static int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-textures-XXXXXX");
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
    static char path[4][300];
    static unsigned turn;
    char *out = path[turn++ % 4];
    snprintf(out, sizeof path[0], "%s/%s", folder, name);
    return out;
}

/* A TGA file of one colour. */
static const char *put_picture(const char *name, int width, int height, uint8_t grey)
{
    const size_t texels = 3 * (size_t)width * (size_t)height;
    uint8_t *bytes = calloc(18 + texels, 1);
    bytes[2] = 2, bytes[12] = (uint8_t)width, bytes[13] = (uint8_t)(width >> 8), bytes[14] = (uint8_t)height,
    bytes[15] = (uint8_t)(height >> 8), bytes[16] = 24;
    memset(bytes + 18, grey, texels);
    assert_true(daft_write_file(path_of(name), bytes, 18 + texels, NULL));
    free(bytes);
    return path_of(name);
}

static daft_texture load(fixture *f, const char *path)
{
    daft_error error;
    const daft_texture texture = daft_texture_load(f->scene, path, &error);
    if (!texture.id) fail_msg("%s", error.message);
    return texture;
}

static uint32_t loaded(const fixture *f) { return f->scene->assets.texture_slots.live; }

static bool is_noted(const fixture *f, const char *path)
{
    for (uint32_t i = 0; i < daft_scene_file_count(f->scene); i++)
        if (strcmp(daft_scene_get_file(f->scene, i), path) == 0) return true;
    return false;
}

static void one_file_of_many_names_is_read_once(void **state)
{
    fixture *f = *state;
    char command[300], text[300];
    put_picture("brick.tga", 4, 4, 100);
    snprintf(command, sizeof command, "cd %s && mkdir sub && ln -s brick.tga link.tga && ln -s .. sub/up", folder);
    assert_int_equal(system(command), 0);
    const daft_texture first = load(f, path_of("brick.tga"));
    const char *const names[] = {"./brick.tga", "sub/../brick.tga", "link.tga", "sub/up/brick.tga"};
    for (size_t i = 0; i < DAFT_COUNT_OF(names); i++) {
        assert_int_equal(load(f, path_of(names[i])).id, first.id);
        assert_true(is_noted(f, path_of(names[i]))); /* so that a change of the link is seen, too */
    }
    assert_int_equal(loaded(f), 1);
    /* by a model's material, from another folder */
    snprintf(text, sizeof text, "newmtl one\nmap_Kd ../link.tga\nnewmtl two\nmap_Kd -texres 2 ../brick.tga\n");
    assert_true(daft_write_file(path_of("sub/m.mtl"), text, strlen(text), NULL));
    snprintf(text, sizeof text, "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one\nf 1 2 3\nusemtl two\nf 3 2 1\n");
    assert_true(daft_write_file(path_of("sub/m.obj"), text, strlen(text), NULL));
    daft_error error;
    if (!daft_mesh_load(f->scene, path_of("sub/m.obj"), &error).id) fail_msg("%s", error.message);
    assert_int_equal(loaded(f), 2); /* `two` is another picture: half as large */
    assert_int_equal(f->warnings, 0);
}

/* glTF's materials take the same way, where this build reads them. */
static void models_of_other_formats_share_it(void **state)
{
    if (!READS_BY_LIBRARY) skip();
    fixture *f = *state;
    daft_error error;
    const char *text =
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
        "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"grey.tga\"}],"
        "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}]}";
    load(f, put_picture("grey.tga", 2, 2, 50));
    assert_true(daft_write_file(path_of("m.gltf"), text, strlen(text), NULL));
    char other[400];
    snprintf(other, sizeof other, "%s/../%s/m.gltf", folder, strrchr(folder, '/') + 1);
    const daft_mesh mesh = daft_mesh_load(f->scene, other, &error);
    if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) skip();
    if (!mesh.id) fail_msg("%s", error.message);
    assert_int_equal(loaded(f), 1);
}

static void a_changed_file_is_another(void **state)
{
    fixture *f = *state;
    put_picture("a.tga", 2, 2, 10), put_picture("same.tga", 2, 2, 10);
    const daft_texture first = load(f, path_of("a.tga"));
    assert_true(load(f, path_of("same.tga")).id != first.id); /* another file, though its bytes are equal */
    put_picture("a.tga", 2, 2, 200);
    assert_int_equal(load(f, path_of("a.tga")).id, first.id); /* a name keeps what it was read as */
    const daft_texture now = load(f, path_of("./a.tga"));
    assert_true(now.id != first.id);
    assert_int_equal(f->scene->assets.textures[daft_asset_index(now.id)].texels[0][0], 200);
    assert_int_equal(loaded(f), 3);
}

static void sizes_and_what_is_none(void **state)
{
    fixture *f = *state;
    daft_error error;
    static const int sizes[][2] = {{1, 1}, {16384, 1}, {1, 16384}, {257, 3}};
    for (size_t i = 0; i < DAFT_COUNT_OF(sizes); i++) {
        char name[40];
        snprintf(name, sizeof name, "size%zu.tga", i);
        const daft_texture texture = load(f, put_picture(name, sizes[i][0], sizes[i][1], 7));
        const daft_texture_data *data = &f->scene->assets.textures[daft_asset_index(texture.id)];
        assert_true(data->width[0] == sizes[i][0] && data->height[0] == sizes[i][1]);
        assert_true(data->width[data->levels - 1] == 1 && data->height[data->levels - 1] == 1);
    }
    assert_false(daft_texture_load(f->scene, put_picture("wide.tga", 16385, 1, 7), &error).id);
    assert_non_null(strstr(error.message, "16384 a side is the most"));
    assert_true(daft_write_file(path_of("text.png"), "this is no image", 16, NULL));
    assert_false(daft_texture_load(f->scene, path_of("text.png"), &error).id);
    assert_true(error.code == DAFT_ERROR_SYNTAX && strstr(error.message, "cannot decode the image"));
    assert_false(daft_texture_load(f->scene, path_of("none.png"), &error).id);
    assert_true(error.code == DAFT_ERROR_IO && strstr(error.message, "cannot open"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(one_file_of_many_names_is_read_once, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(models_of_other_formats_share_it, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(a_changed_file_is_another, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(sizes_and_what_is_none, open_folder, close_folder)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
