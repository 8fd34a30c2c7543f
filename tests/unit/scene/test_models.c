/* Models in formats that Assimp reads: hierarchies, mirrored parts, skins, materials, pictures inside; files by content
 * and not by name; damaged ones. */
#include "scene_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static char folder[64];

static int open_folder(void **state)
{
    snprintf(folder, sizeof folder, "/tmp/daft-models-XXXXXX");
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

static const char *put_text(const char *name, const char *text) { return put(name, text, strlen(text)); }

/* NULL where this build or system has no Assimp: the test is skipped. */
static const daft_trimesh *load(fixture *f, const char *path)
{
    daft_error error;
    daft_mesh mesh = daft_mesh_load(f->scene, path, &error);
    if (!mesh.id && error.code == DAFT_ERROR_UNSUPPORTED) {
        print_message("skipped: %s\n", error.message);
        skip();
    }
    if (!mesh.id) fail_msg("%s", error.message);
    return &daft_mesh_find(f->scene, mesh, &error)->mesh;
}

/* Volume by the divergence theorem: positive where triangles look outwards. */
static double volume(const daft_trimesh *mesh)
{
    double sum = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        daft_dvec3 p[3];
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t v = mesh->indices[3 * t + k];
            p[k] = daft_dv3((double)mesh->x[v], (double)mesh->y[v], (double)mesh->z[v]);
        }
        sum += daft_ddot(p[0], daft_dcross(p[1], p[2])) / 6;
    }
    return sum;
}

/* A tetrahedron from the origin along the axes, volume 1/6, and a node that has it twice: as it is, and mirrored and
 * moved. The buffer: four positions, twelve 16-bit indices. */
static const char *const PYRAMID =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"name\":\"root\",\"children\":[1,2],\"scale\":[2,2,2]},{\"name\":\"one\",\"mesh\":0},"
    "{\"name\":\"other\",\"mesh\":0,\"scale\":[-1,1,1],\"translation\":[-3,0,0]}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}],"
    "\"materials\":[{\"name\":\"brass\",\"emissiveFactor\":[0,0.25,0],\"pbrMetallicRoughness\":"
    "{\"baseColorFactor\":[0.5,0.25,0.125,1],\"metallicFactor\":0,\"roughnessFactor\":0.5%s}}],%s"
    "\"buffers\":[{\"byteLength\":72,\"uri\":\"%s\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":24}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,"
    "1,1]},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}]}";

static void put_buffer(void)
{
    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint16_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    uint8_t bytes[72];
    memcpy(bytes, positions, 48), memcpy(bytes + 48, indices, 24);
    put("pyramid.bin", bytes, sizeof bytes);
}

static void hierarchies_are_flattened_and_mirrored_parts_face_outwards(void **state)
{
    fixture *f = *state;
    char text[4000];
    put_buffer();
    snprintf(text, sizeof text, PYRAMID, "", "", "pyramid.bin");
    const daft_trimesh *mesh = load(f, put_text("pyramid.gltf", text));
    assert_int_equal(mesh->triangle_count, 8);
    assert_int_equal(mesh->vertex_count, 8);
    assert_true(mesh->low.x == -8 && mesh->high.x == 2 && mesh->low.y == 0 && mesh->high.z == 2);
    assert_true(fabs(volume(mesh) - 2 * 8.0 / 6) < 1e-5);
    for (uint32_t t = 0; t < mesh->triangle_count; t++) /* normals look where the triangle does */
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t *i = &mesh->indices[3 * t];
            const daft_vec3 a = daft_v3(mesh->x[i[0]], mesh->y[i[0]], mesh->z[i[0]]),
                            b = daft_v3(mesh->x[i[1]], mesh->y[i[1]], mesh->z[i[1]]),
                            c = daft_v3(mesh->x[i[2]], mesh->y[i[2]], mesh->z[i[2]]);
            const daft_vec3 n = mesh->normals[mesh->normal_indices ? mesh->normal_indices[3 * t + k] : i[k]];
            assert_true(daft_dot(n, daft_cross(daft_sub(b, a), daft_sub(c, a))) > 0);
        }
    assert_int_equal(f->warnings, 0);
}

static void materials_come_along(void **state)
{
    fixture *f = *state;
    daft_error error;
    char text[4000], name[64];
    put_buffer();
    snprintf(text, sizeof text, PYRAMID, "", "", "pyramid.bin");
    load(f, put_text("pyramid.gltf", text));
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    def.mesh = daft_mesh_load(f->scene, put_text("pyramid.gltf", text), &error);
    assert_true(daft_entity_create(f->scene, &def, &error).id != 0);
    daft_ray_hit hit;
    assert_true(
        daft_scene_cast_ray(f->scene, daft_dv3(0.1, 0.1, -5), daft_v3(0, 0, 1), 100, (daft_entity){0}, &hit, &error));
    assert_string_equal(daft_material_name(f->scene, hit.material, name, sizeof name), "brass");
    daft_material_def look;
    assert_true(daft_material_get(f->scene, hit.material, &look, &error));
    assert_true(fabsf(look.diffuse.x - 0.5f) < 1e-6f && fabsf(look.diffuse.z - 0.125f) < 1e-6f);
    assert_true(fabsf(look.emission.y - 0.25f) < 1e-6f && look.shading == DAFT_SHADING_PHYSICAL);
    assert_true(look.roughness == 0.5f && look.alpha_mode == DAFT_ALPHA_OPAQUE);
    assert_true(look.transmission == 0 && look.diffuse_map.id == 0);
    const uint32_t files = daft_scene_file_count(f->scene);
    assert_true(files == 1 && strstr(daft_scene_get_file(f->scene, 0), "pyramid.gltf"));
}

/* Glass by KHR_materials_transmission, and wine by KHR_materials_volume beside it. */
static void bodies_that_transmit_come_along(void **state)
{
    fixture *f = *state;
    daft_error error;
    char text[4000];
    for (int volume = 0; volume < 2; volume++) {
        put_buffer();
        snprintf(text, sizeof text, PYRAMID,
                 volume ? "},\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1},"
                          "\"KHR_materials_volume\":{\"thicknessFactor\":0.1,\"attenuationDistance\":0.25,"
                          "\"attenuationColor\":[0.75,0.125,0.25]}"
                        : "},\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.75}",
                 "\"extensionsUsed\":[\"KHR_materials_transmission\",\"KHR_materials_volume\"],", "pyramid.bin");
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_MESH;
        def.mesh = daft_mesh_load(f->scene, put_text(volume ? "wine.gltf" : "pane.gltf", text), &error);
        const daft_entity entity = daft_entity_create(f->scene, &def, &error);
        assert_true(entity.id != 0);
        daft_ray_hit hit;
        daft_material_def look;
        assert_true(daft_scene_cast_ray(f->scene, daft_dv3(0.1, 0.1, -5), daft_v3(0, 0, 1), 100, (daft_entity){0}, &hit,
                                        &error));
        assert_true(daft_material_get(f->scene, hit.material, &look, &error));
        assert_true(daft_entity_destroy(f->scene, entity, &error));
        const daft_vec3 tint = volume ? daft_v3(0.75f, 0.125f, 0.25f) : daft_v3(0.5f, 0.25f, 0.125f);
        assert_true(look.transmission == (volume ? 1 : 0.75f) && look.tint_distance == (volume ? 0.25f : 0));
        assert_true(look.refractive_index == (volume ? 1.5f : 1) && look.shading == DAFT_SHADING_PHONG);
        assert_true(memcmp(&look.transmission_tint, &tint, sizeof tint) == 0 && look.mirror == 0);
    }
}

/* A picture in the file: a red PNG of one pixel. */
static void pictures_within_are_used(void **state)
{
    fixture *f = *state;
    daft_error error;
    char text[4000];
    put_buffer();
    snprintf(text, sizeof text, PYRAMID, ",\"baseColorTexture\":{\"index\":0}",
             "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"data:image/png;base64,"
             "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC\"}],",
             "pyramid.bin");
    load(f, put_text("red.gltf", text));
    assert_int_equal(f->warnings, 0);
    assert_int_equal(f->scene->assets.texture_slots.live, 1);
    const daft_texture_data *map = &f->scene->assets.textures[0];
    for (uint32_t i = 0; i < f->scene->assets.texture_slots.count; i++) map = &f->scene->assets.textures[i];
    assert_true(map->width[0] == 1 && map->texels[0][0] == 255 && map->texels[0][1] == 0);
    (void)error;
}

/* An STL that calls itself OBJ, and a PLY. */
static void files_are_what_they_hold(void **state)
{
    fixture *f = *state;
    const daft_trimesh *mesh =
        load(f, put_text("liar.obj", "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                     "vertex 0 1 0\nendloop\nendfacet\nendsolid one\n"));
    assert_int_equal(mesh->triangle_count, 1);
    mesh = load(
        f, put_text("quad.ply",
                    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"));
    assert_true(mesh->triangle_count == 2 && mesh->vertex_count == 4);
    mesh = load(f, put_text("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    assert_int_equal(mesh->triangle_count, 1);
}

static void what_is_missing_or_broken_is_told(void **state)
{
    fixture *f = *state;
    daft_error error;
    char text[4000];
    snprintf(text, sizeof text, PYRAMID, "", "", "nowhere.bin");
    assert_int_equal(daft_mesh_load(f->scene, put_text("lost.gltf", text), &error).id, 0);
    if (error.code == DAFT_ERROR_UNSUPPORTED) skip();
    assert_true(error.code == DAFT_ERROR_SYNTAX && strstr(error.file, "lost.gltf") && error.message[0]);
    assert_int_equal(daft_mesh_load(f->scene, put_text("cut.glb", "glTF\2\0\0\0"), &error).id, 0);
    assert_true(error.code == DAFT_ERROR_SYNTAX && error.message[0]);
    assert_int_equal(f->scene->assets.mesh_slots.live, 0);
}

/* Skins stand as the file has them. */
static void a_skinned_model_stands_upright(void **state)
{
    fixture *f = *state;
    const char *path = DAFT_ROOT "/../shared/data/gltf/greenman.glb";
    if (access(path, R_OK) != 0) {
        print_message("skipped: %s is not there\n", path);
        skip();
    }
    const daft_trimesh *mesh = load(f, path);
    const daft_vec3 size = daft_sub(mesh->high, mesh->low);
    assert_true(mesh->triangle_count > 100);
    if (!(size.y > 0.5f * size.x && size.x > size.z))
        fail_msg("%g x %g x %g", (double)size.x, (double)size.y, (double)size.z);
}

int main(void)
{
    if (!READS_BY_LIBRARY) return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(hierarchies_are_flattened_and_mirrored_parts_face_outwards, open_folder,
                                        close_folder),
        cmocka_unit_test_setup_teardown(bodies_that_transmit_come_along, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(materials_come_along, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(pictures_within_are_used, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(files_are_what_they_hold, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(what_is_missing_or_broken_is_told, open_folder, close_folder),
        cmocka_unit_test_setup_teardown(a_skinned_model_stands_upright, open_folder, close_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
