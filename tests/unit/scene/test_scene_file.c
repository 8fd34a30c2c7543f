/* .scene files: what each line means, and that every mistake is told with its line and column and changes nothing. */
#include "math/trig.h"
#include "scene/scene.h"
#include "scene/format/items.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

typedef struct fixture {
    daft_engine *engine;
    daft_scene *scene;
    char folder[64];
    int warnings;
    daft_error last_warning;
    long live, allocations, fail_at; /* of the engine's allocator; fail_at 0: never */
} fixture;

static void on_warning(void *user, const daft_error *warning)
{
    fixture *f = user;
    f->warnings++;
    f->last_warning = *warning;
}

static void *counted_allocate(void *user, size_t size, size_t alignment)
{
    fixture *f = user;
    if (++f->allocations == f->fail_at) return NULL;
    void *memory = aligned_alloc(alignment, (size + alignment - 1) & ~(alignment - 1));
    f->live += memory != NULL;
    return memory;
}

static void counted_release(void *user, void *pointer)
{
    fixture *f = user;
    f->live -= pointer != NULL;
    free(pointer);
}

static const char *path_of(const fixture *f, const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", f->folder, name);
    return path;
}

static void write_bytes(const fixture *f, const char *name, const void *bytes, size_t size)
{
    FILE *file = fopen(path_of(f, name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static void write_text(const fixture *f, const char *name, const char *text)
{
    write_bytes(f, name, text, strlen(text));
}

static const char TRIANGLE[] =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\n";
static const char MATERIALS[] = "newmtl red\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 50\nillum 2\nmap_Kd missing.png\n"
                                "newmtl shiny one\nKa 0 0 0\nKd 0 0 0\nKs 0.8 0.4 0\nNs 100\nillum 3\n"
                                "newmtl matt\nKd 0 0 1\nKs 1 1 1\nillum 1\nd 0.5\n";

static void set_up_engine(fixture *f)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    def.warn = on_warning;
    def.warn_user = f;
    def.allocator = (daft_allocator){.user = f, .allocate = counted_allocate, .release = counted_release};
    f->engine = daft_engine_create(&def, NULL);
    f->scene = daft_scene_create(f->engine, NULL);
}

static int set_up(void **state)
{
    static fixture f;
    f = (fixture){0};
    *state = &f;
    strcpy(f.folder, "/tmp/daft-test-XXXXXX");
    if (!mkdtemp(f.folder)) return -1;
    mkdir(path_of(&f, "sub folder"), 0777);
    write_text(&f, "t.obj", TRIANGLE);
    write_text(&f, "m.mtl", MATERIALS);
    write_text(&f, "sub folder/t.obj", TRIANGLE);
    write_text(&f, "sub folder/m.mtl", MATERIALS);
    write_bytes(&f, "sky.tga", "\0\0\2\0\0\0\0\0\0\0\0\0\2\0\1\0\x18\0\0\0\xff\xff\0\0", 24);
    set_up_engine(&f);
    return f.scene ? 0 : -1;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    daft_scene_destroy(f->scene);
    daft_engine_destroy(f->engine);
    assert_int_equal(f->live, 0);
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", f->folder);
    return system(command);
}

static bool load(fixture *f, const char *text, daft_error *error)
{
    write_text(f, "s.scene", text);
    return daft_scene_load(f->scene, path_of(f, "s.scene"), error);
}

static void load_good(fixture *f, const char *text)
{
    daft_error error;
    char buffer[1100];
    if (!load(f, text, &error)) fail_msg("%s", daft_error_text(&error, buffer, sizeof buffer));
}

static const daft_entity_item *entity(const fixture *f, uint32_t index) { return &f->scene->entities[index]; }
static double degrees(double radians) { return radians * 180 / DAFT_PI; }

/* ---- good files ---- */

/* Options follow an item's numbers and paths; what is optional there may be left out before them. */
static void items_have_options(void **state)
{
    fixture *f = *state;
    load_good(f, "camera 0 0 0 roll=90\ncamera 0 0 0 10 20 roll=-45 # leans left\nlight 0 1 0 1 1 1 shadow=off\n"
                 "spot 0 1 0 0 -1 0 1 1 1 40 shadow=false\nsun 0 -1 0 1 1 1 shadow=on\n"
                 "sphere 0 0 0 1 m.mtl visible=no\nmesh t.obj 0 0 0 2 shadow=no visible=yes\n");
    daft_camera camera;
    assert_true(daft_scene_get_camera(f->scene, 0, &camera, NULL) && fabs(degrees((double)camera.roll) - 90) < 1e-4);
    assert_true(daft_scene_get_camera(f->scene, 1, &camera, NULL) && fabs(degrees((double)camera.roll) + 45) < 1e-4);
    assert_true(fabs(degrees((double)camera.yaw) - 20) < 1e-4);
    assert_false(f->scene->lights[0].casts_shadow || f->scene->lights[1].casts_shadow);
    assert_true(f->scene->lights[2].casts_shadow && fabs(degrees((double)f->scene->lights[1].outer_angle) - 40) < 1e-4);
    assert_true(!entity(f, 0)->def.visible && entity(f, 0)->def.casts_shadow);
    assert_true(entity(f, 1)->def.visible && !entity(f, 1)->def.casts_shadow && entity(f, 1)->def.scale.x == 2);
}

static void every_line_means_what_the_manual_says(void **state)
{
    fixture *f = *state;
    load_good(f, "# a comment\n"
                 "camera 1 2.5 -3e0 10 -20 60 # trailing\r\n"
                 "\n"
                 "  camera 0 0 0\t30 40\n"
                 "camera +1 .5 1.\n"
                 "skybox sky.tga\n"
                 "light 1 2 3 0.5 1 2\n"
                 "sun 0 -2 0 1 1 0.9\n"
                 "spot 1 2 3 0 -2 0 1 1 1\n"
                 "spot 1 2 3 0 -2 0 1 1 1 40\n"
                 "spot 1 2 3 0 -2 0 1 1 1 180 90\n"
                 "ambient 0.1 0.2 0.3#comment after a number\n"
                 "sphere 4 5 6 0.25 m.mtl\n"
                 "sphere 4 5 6 7 \"m.mtl#shiny one\"\n"
                 "mesh t.obj 1 2 3\n"
                 "mesh \"sub folder/t.obj\" 0 0 0 -2\n"
                 "mesh t.obj 0 0 0 2 90 0 90");
    daft_camera camera;
    assert_int_equal(daft_scene_camera_count(f->scene), 3);
    assert_true(daft_scene_get_camera(f->scene, 0, &camera, NULL));
    assert_true(camera.position.x == 1 && camera.position.y == 2.5 && camera.position.z == -3);
    assert_true(fabs(degrees((double)camera.pitch) - 10) < 1e-5 && fabs(degrees((double)camera.yaw) + 20) < 1e-5);
    assert_true(fabs(degrees((double)camera.fov) - 60) < 1e-5 && camera.roll == 0);
    assert_memory_equal(&f->scene->camera, &camera, sizeof camera); /* the first is the one that is set */
    assert_true(daft_scene_get_camera(f->scene, 1, &camera, NULL));
    assert_true(fabs(degrees((double)camera.pitch) - 30) < 1e-5 && fabs(degrees((double)camera.fov) - 90) < 1e-5);
    assert_true(daft_scene_get_camera(f->scene, 2, &camera, NULL) && camera.position.y == 0.5);
    assert_false(daft_scene_get_camera(f->scene, 3, &camera, NULL));
    assert_int_equal(f->scene->sky.kind, DAFT_SKY_IMAGE);
    assert_int_equal(f->scene->light_slots.live, 5);
    assert_true(f->scene->lights[0].kind == DAFT_LIGHT_POINT && f->scene->lights[0].color.z == 2);
    assert_true(f->scene->lights[1].kind == DAFT_LIGHT_SUN && f->scene->lights[1].direction.y == -2);
    const double cones[3][2] = {{22.5, 30}, {30, 40}, {90, 180}}; /* degrees, from the axis */
    for (int i = 0; i < 3; i++) {
        const daft_light_def *spot = &f->scene->lights[2 + i];
        assert_true(spot->kind == DAFT_LIGHT_SPOT && spot->position.z == 3 && spot->direction.y == -2);
        assert_true(fabs(degrees((double)spot->inner_angle) - cones[i][0]) < 1e-4);
        assert_true(fabs(degrees((double)spot->outer_angle) - cones[i][1]) < 1e-4);
    }
    assert_true(f->scene->ambient.y == 0.2f);
    assert_int_equal(daft_entity_count(f->scene), 5);
    assert_true(entity(f, 0)->def.shape == DAFT_SHAPE_SPHERE && entity(f, 0)->def.radius == 0.25f);
    assert_true(entity(f, 2)->def.mesh.id == entity(f, 4)->def.mesh.id); /* one path, one mesh */
    assert_true(entity(f, 2)->def.mesh.id != entity(f, 3)->def.mesh.id);
    assert_true(entity(f, 3)->now.scale.x == -2 && entity(f, 2)->now.scale.x == 1);
    /* about X then Z: +Y goes to +Z and stays; +X stays and goes to +Y; +Z goes to -Y and then to +X */
    daft_daffine map = daft_daffine_from(&entity(f, 4)->now);
    const double want[9] = {0, 0, 2, 2, 0, 0, 0, 2, 0};
    for (int i = 0; i < 9; i++) assert_true(fabs(map.m[i] - want[i]) < 1e-6);
}

/* The manual has the form of every item, as messages show it. */
static void every_form_is_in_the_manual(void **state)
{
    fixture *f = *state;
    size_t size, i = 0;
    daft_error error;
    char *page = daft_file_read(f->scene->allocator, NULL, DAFT_ROOT "/docs/reference/scene-files.md", &size, &error);
    assert_non_null(page);
    char form[128], cell[160];
    for (; daft_scene_item_form(i, form, sizeof form); i++) {
        snprintf(cell, sizeof cell, "| `%s` |", form);
        if (!strstr(page, cell)) fail_msg("scene-files.md lacks %s", cell);
    }
    assert_true(i >= 9);
    daft_release(f->scene->allocator, page);
}

static void materials_keep_their_meaning(void **state)
{
    fixture *f = *state;
    load_good(f, "sphere 0 0 0 1 m.mtl\nsphere 0 0 0 1 \"m.mtl#shiny one\"\nsphere 0 0 0 1 m.mtl#matt\n"
                 "sphere 0 0 0 1 m.mtl#red\nmesh t.obj 0 0 0\n");
    daft_material_def def;
    assert_true(daft_material_get(f->scene, entity(f, 0)->def.material, &def, NULL));
    assert_true(def.diffuse.x == 1 && def.specular.x == 0.5f && def.mirror == 0 && def.shininess == 50);
    assert_true(f->scene->assets.textures[def.diffuse_map.id - 1].missing);
    assert_true(daft_material_get(f->scene, entity(f, 1)->def.material, &def, NULL));
    assert_true(def.mirror == 0.8f && def.mirror_tint.x == 1 && def.mirror_tint.y == 0.5f && def.mirror_tint.z == 0);
    assert_true(def.specular.x == 0.8f);
    assert_true(daft_material_get(f->scene, entity(f, 2)->def.material, &def, NULL));
    assert_true(def.specular.x == 0 && def.mirror == 0 && def.diffuse.z == 1);
    /* the missing texture is told once, where the MTL names it, though three materials ask for it */
    assert_int_equal(f->warnings, 1);
    assert_int_equal(f->last_warning.line, 6);
    assert_int_equal(f->last_warning.column, 8);
    assert_string_equal(f->last_warning.file, path_of(f, "m.mtl"));
    assert_non_null(strstr(f->last_warning.message, "missing.png"));
    assert_true(def.transmission == 0.5f && def.refractive_index == 1);
    daft_error error;
    daft_texture texture = daft_texture_load(f->scene, path_of(f, "missing.png"), &error);
    assert_int_equal(texture.id, 0); /* asked for by itself it is an error */
    assert_int_equal(error.code, DAFT_ERROR_IO);
    load_good(f, "mesh \"sub folder/t.obj\" 0 0 0"); /* through an OBJ it is the MTL that is named, too */
    assert_int_equal(f->warnings, 2);
    assert_string_equal(f->last_warning.file, path_of(f, "sub folder/m.mtl"));
    daft_material again = daft_material_load(f->scene, path_of(f, "m.mtl"), &error);
    assert_int_equal(again.id, entity(f, 0)->def.material.id);
    assert_int_equal(daft_material_load(f->scene, path_of(f, "m.mtl#blue"), &error).id, 0);
    assert_non_null(strstr(error.message, "no material 'blue'; it has red, shiny one, matt"));
}

/* material NAME option=value: the same fields as in Lua, for meshes and spheres, also above the line that says it. */
static void materials_have_names(void **state)
{
    fixture *f = *state;
    load_good(f, "mesh t.obj 0 0 0 2 material ruby\nmesh t.obj 0 0 0\nsphere 0 0 0 1 gold name=ball\n"
                 "material ruby color=0.9,0.1,0.2 emission=0.5 texture=sky.tga texture_wrap=mirror "
                 "normal_texture=sky.tga refractive_index=1.7 alpha=blend\n"
                 "material gold shading=physical metallic=1 roughness=0.25 occlusion_texture=sky.tga "
                 "occlusion_strength=0.5\n");
    daft_material_def def, plain = daft_default_material_def();
    char name[16];
    assert_true(daft_material_get(f->scene, entity(f, 0)->def.material, &def, NULL));
    assert_string_equal(daft_material_name(f->scene, entity(f, 0)->def.material, name, sizeof name), "ruby");
    assert_true(def.diffuse.x == 0.9f && def.diffuse.y == 0.1f && def.diffuse.z == 0.2f);
    assert_true(def.emission.x == 0.5f && def.emission.y == 0.5f && def.emission.z == 0.5f);
    assert_true(def.map_wrap == 2 && def.alpha_mode == DAFT_ALPHA_BLEND && def.refractive_index == 1.7f);
    assert_true(def.diffuse_map.id && def.diffuse_map.id == def.normal_map.id && !def.bump_map.id);
    assert_true(def.shininess == plain.shininess && def.specular.x == plain.specular.x);
    assert_int_equal(entity(f, 1)->def.material.id, 0); /* the mesh's own */
    assert_true(daft_material_get(f->scene, entity(f, 2)->def.material, &def, NULL));
    assert_true(def.shading == DAFT_SHADING_PHYSICAL && def.metallic == 1 && def.roughness == 0.25f);
    assert_true(def.occlusion_map.id && def.occlusion_strength == 0.5f && plain.occlusion_strength == 1);
}

/* material NAME { … } over several lines says what one line does. */
static void materials_have_blocks(void **state)
{
    fixture *f = *state;
    load_good(f, "material line color=0.9,0.1,0.2 emission=0.5 texture=sky.tga mirror=0.25\n"
                 "material block { # red\n  color=0.9,0.1,0.2\n\n  emission=0.5 texture=sky.tga\t# a comment\r\n"
                 "mirror=0.25\n}  # done\nmaterial short { mirror=0.5 }\nmaterial bare {\n}\n"
                 "sphere 0 0 0 1 line\nsphere 3 0 0 1 block\nsphere 6 0 0 1 short\nsphere 9 0 0 1 bare\n");
    daft_material_def line, block;
    assert_true(daft_material_get(f->scene, entity(f, 0)->def.material, &line, NULL));
    assert_true(daft_material_get(f->scene, entity(f, 1)->def.material, &block, NULL));
    assert_memory_equal(&line, &block, sizeof line);
    assert_true(daft_material_get(f->scene, entity(f, 2)->def.material, &block, NULL));
    assert_true(block.mirror == 0.5f);
    assert_true(daft_material_get(f->scene, entity(f, 3)->def.material, &block, NULL));
    assert_true(block.mirror == 0);
}

/* Every field of a material can be said in a .scene file as in Lua. */
static void materials_have_all_fields(void **state)
{
    (void)state;
    uint32_t count;
    const daft_field *fields = daft_fields(DAFT_STRUCT_MATERIAL_DEF, &count);
    assert_true(count > 30);
    for (uint32_t i = 0; i < count; i++)
        if (fields[i].lua) assert_string_equal(fields[i].lua, fields[i].scene ? fields[i].scene : "none");
}

static void areas_are_read(void **state)
{
    fixture *f = *state;
    load_good(f, "rectangle 1 2 3 0 -1 0 2 0.5 4 3 2 turn=90 range=7 shadow=false\n"
                 "sun 0 -1 0 1 1 1 disc=0.3 visible=true\nsphere 0 5 0 1 m.mtl lights=true\nsphere 0 9 0 1 m.mtl\n"
                 "mesh t.obj 0 0 0 lights=true\nmesh t.obj 0 0 0 2 lights\n");
    const daft_light_def *r = &f->scene->lights[0];
    assert_true(r->kind == DAFT_LIGHT_RECTANGLE && r->position.z == 3 && r->direction.y == -1 && r->color.z == 2);
    assert_true(r->size.x == 2 && r->size.y == 0.5f && r->range == 7 && !r->casts_shadow);
    assert_true(fabs(degrees((double)r->turn) - 90) < 1e-4);
    assert_true(f->scene->lights[1].visible && entity(f, 0)->def.lights && !entity(f, 1)->def.lights);
    assert_true(entity(f, 2)->def.lights && !entity(f, 3)->def.lights); /* the word means those of its file */
    assert_int_equal(f->scene->glowing, 2);
    const daft_entity made = {daft_slots_handle(&f->scene->entity_slots, 0)};
    assert_true(daft_entity_destroy(f->scene, made, NULL) && f->scene->glowing == 1);
}

/* What d, Tf, Ni and illum make of light that passes. Exporters write Ni and Tf beside any model: only 4, 6, 7, 9 mean
 * it. */
static void glass_keeps_its_meaning(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *lines;
        float transmission, tint, index, mirror;
    } rows[] = {{"illum 2\nNi 1.5\nTf 0 0 0", 0, 1, 1, 0},
                {"illum 2\nNi 1.5\nd 0.25\nTf 1 .5 1", .75f, 1, 1, 0},
                {"illum 7\nNi 1.5\nKs 1", 1, 1, 1.5f, 0},
                {"illum 6\nNi 1.33\nTf 1 0.5 0.25", 1, .5f, 1.33f, 0},
                {"illum 7\nNi 1.5\nd 0.5\nKs .5", .5f, 1, 1.5f, .25f},
                {"illum 6\nd 1\nTf 0 0 0", 0, 0, 1, 0},
                {"illum 4\nNi 1.5\nKs 1", 0, 1, 1.5f, 1},
                {"illum 4\nNi 1.5\nTr 0.5\nTf 1 .25 1", .5f, .25f, 1.5f, 0},
                {"illum 9\nNi 1.4\nTf .9 .8 .7", 1, .8f, 1.4f, 0},
                {"illum 3\nNi 9\nKs 1\nTr 0.5", .5f, 1, 1, .5f}};
    for (size_t i = 0; i < DAFT_COUNT_OF(rows); i++) {
        char text[256], name[32];
        snprintf(text, sizeof text, "newmtl a\n%s\n", rows[i].lines);
        snprintf(name, sizeof name, "glass%zu.mtl", i);
        write_text(f, name, text);
        daft_material_def def;
        daft_material material = daft_material_load(f->scene, path_of(f, name), NULL);
        assert_true(material.id && daft_material_get(f->scene, material, &def, NULL));
        if (def.transmission != rows[i].transmission || def.transmission_tint.y != rows[i].tint ||
            def.refractive_index != rows[i].index || def.mirror != rows[i].mirror)
            fail_msg("%s: %g %g %g %g", rows[i].lines, (double)def.transmission, (double)def.transmission_tint.y,
                     (double)def.refractive_index, (double)def.mirror);
    }
}

static void includes_are_relative_to_their_file(void **state)
{
    fixture *f = *state;
    write_text(f, "sub folder/inner.scene", "mesh t.obj 0 0 0\ncamera 9 9 9\n");
    write_text(f, "empty.scene", "# nothing\n");
    load_good(f, "include \"sub folder/inner.scene\"\ninclude \"sub folder/inner.scene\"\ncamera 1 1 1");
    assert_int_equal(daft_entity_count(f->scene), 2);
    assert_int_equal(daft_scene_camera_count(f->scene), 3);
    assert_true(daft_scene_camera(f->scene, 1).position.x == 9);
    /* a second load adds; the camera in use stays */
    load_good(f, "camera 5 5 5\nlight 0 0 0 1 1 1\n");
    assert_int_equal(daft_scene_camera_count(f->scene), 4);
    assert_true(daft_scene_camera(f->scene, 1).position.x == 9);
}

static void byte_order_mark_is_skipped(void **state)
{
    fixture *f = *state;
    daft_error error;
    load_good(f, "\xef\xbb\xbf"
                 "camera 1 2 3");
    assert_false(load(f,
                      "\xef\xbb\xbf"
                      "camra 1 2 3",
                      &error));
    assert_int_equal(error.column, 1);
}

/* ---- bad files ---- */

static const struct {
    const char *text;
    int line, column;
    const char *says;
} BAD[] = {
    {"camera 0 0 0\nspher 0 0 0 1 m.mtl\n", 2, 1,
     "unknown item 'spher'; known are camera, skybox, light, sphere, mesh"},
    {"camera 0 0\n", 1, 11, "expected z, but the line ends"},
    {"camera 0 0 x\n", 1, 12, "expected z (a number), 'x' came"},
    {"camera 0 0 0 1\n", 1, 15, "expected yaw"},
    {"camera 0 0 0 1 2 3 4\n", 1, 20, "unexpected '4'"},
    {"camera 0 0 0 1 2 180\n", 1, 18, "fov is 180; it must be between 5.72958e-05 and 179.995 degrees"},
    {"camera 0 0 0 1 2 0\n", 1, 18, "fov is 0"},
    {"camera 0 nan 0\n", 1, 10, "'nan' came"},
    {"camera 0 inf 0\n", 1, 10, "'inf' came"},
    {"camera 0 0x10 0\n", 1, 10, "'0x10' came"},
    {"camera 0 1e999 0\n", 1, 10, "y is 1e999; it must be finite"},
    {"camera 1,5 0 0\n", 1, 8, "'1,5' came"},
    {"camera 0 0 0 1e8 0\n", 1, 14, "pitch is 1e8"},
    {"light 1 2 3 1 1\n", 1, 16, "expected b"},
    {"  light 1 2 3 1 -1 1\n", 1, 17, "g is -1; it must be finite and 0 or more"},
    {"light 1 2 3 1 1e39 1\n", 1, 15, "g is 1e39"},
    {"sphere 1 2 3 0 m.mtl\n", 1, 14, "r is 0; it must be finite and above 0"},
    {"sphere 1 2 3 -1 m.mtl\n", 1, 14, "r is -1"},
    {"sphere 1 2 3 1\n", 1, 15, "expected the path of an .mtl file"},
    {"sphere 1 2 3 1 m.mtl x\n", 1, 22, "unexpected 'x'; the form is: sphere x y z r material_path"},
    {"sphere 1 2 3 1 no.mtl\n", 1, 16, "no.mtl: cannot open: No such file"},
    {"sphere 1 2 3 1 m.mtl#none\n", 1, 16, "no material 'none'"},
    {"sphere 1 2 3 1 \"m.mtl\n", 1, 16, "the quote is not closed"},
    {"sphere 1 2 3 1 \"m.mtl\"x\n", 1, 23, "expected a blank after the closing quote"},
    {"sphere 1 2 3 1 \"\"\n", 1, 16, "but it is empty"},
    {"mesh no.obj 0 0 0\n", 1, 6, "no.obj: cannot open"},
    {"mesh . 0 0 0\n", 1, 6, "is a directory"},
    {"mesh t.obj 0 0 0 0\n", 1, 18, "scale is 0; it must not be 0"},
    {"mesh t.obj 0 0 0 1 90\n", 1, 22, "expected rot_y"},
    {"mesh t.obj 0 0 0 1 0 0 0 0\n", 1, 26, "unexpected '0'"},
    {"light 1 2 3 1 1 1 shadow=perhaps\n", 1, 19, "shadow is 'perhaps'; it must be true or false"},
    {"light 1 2 3 1 1 1 shdow=off\n", 1, 19, "unknown option 'shdow'; known are shadow, radius, range"},
    {"rectangle 1 2 3 0 -1 0 1 0 1 1 1\n", 1, 26, "height is 0; it must be between 1e-06 and 1e+06 m"},
    {"rectangle 1 2 3 0 0 0 1 1 1 1 1\n", 1, 17, "direction is 0, 0, 0; it must have a length"},
    {"rectangle 1 2 3 0 -1 0 1 1 1 1 1 radius=1\n", 1, 34, "unknown option 'radius'; known are shadow, range, turn"},
    {"light 1 2 3 1 1 1 shadow\n", 1, 19, "unexpected 'shadow'"},
    {"light 1 2 3 shadow=off\n", 1, 13, "expected r (a number)"},
    {"camera 0 0 0 roll=1,2\n", 1, 14, "roll is '1,2'; it must be a number"},
    {"camera 0 0 0 roll=1e9\n", 1, 14, "roll is 1e+09; it must be between -5.72958e+07 and 5.72958e+07 degrees"},
    {"ambient 1 1 1 shadow=off\n", 1, 15, "unexpected 'shadow=off'"},
    {"mesh\n", 1, 5, "expected the path of a mesh"},
    {"skybox no.png\n", 1, 8, "no.png"},
    {"skybox sky.tga sky.tga\n", 1, 23, "expected the path of an image of the cube, but the line ends"},
    {"skybox a a a a a a sky.tga\n", 1, 20,
     "unexpected 'sky.tga'; the form is: skybox path [left top bottom front back]"},
    {"sun 0 0 0 1 1 1\n", 1, 5, "direction is 0, 0, 0; it must have a length"},
    {"spot 0 0 0 0 0 0 1 1 1\n", 1, 12, "direction is 0, 0, 0"},
    {"spot 0 0 0 0 1 0 1 1 1 0\n", 1, 24, "angle is 0; it must be above 0 and at most 180 degrees"},
    {"spot 0 0 0 0 1 0 1 1 1 181\n", 1, 24, "angle is 181"},
    {"spot 0 0 0 0 1 0 1 1 1 20 -1\n", 1, 27, "inner is -1; it must be between 0 and 180 degrees"},
    {"spot 0 0 0 0 1 0 1 1 1 20 30\n", 1, 27, "inner is 30; it must be at most 20, the number before it"},
    {"sphere 1 2 3 1e-60 m.mtl\n", 1, 14, "r is 1e-60; it must be finite and above 0"},
    {"material\n", 1, 9, "expected the name of the material"},
    {"material m colr=1,0,0\n", 1, 12, "unknown option 'colr': did you mean 'color'?"},
    {"material m qqqqqqqq=1\n", 1, 12, "unknown option 'qqqqqqqq'; known are ambient, color, specular"},
    {"material m mirror=2\n", 1, 12, "mirror is 2; it must be between 0 and 1"},
    {"material m alpha=some\n", 1, 12, "alpha is 'some'; it must be opaque, mask or blend"},
    {"material m texture=no.png\n", 1, 20, "no.png"},
    {"material m texture=\n", 1, 20, "the path of texture is empty"},
    {"material m {\n  colr=1,0,0\n}\n", 2, 3, "unknown option 'colr': did you mean 'color'?"},
    {"material m {\n\n  mirror=1 mirror=2\n}\n", 3, 12, "mirror is 2; it must be between 0 and 1"},
    {"material m { texture=sky.tga\n bump_texture=no.png }\n", 2, 15, "no.png"},
    {"material m {\n  color 1 0 0\n}\n", 2, 3, "expected an option, name=value, or }, but 'color' came"},
    {"material m {\n  mirror=1\n", 3, 1, "the file ends, but the { of line 1 is not closed by a }"},
    {"material m {\n} mirror=1\n", 2, 3, "unexpected 'mirror=1'"},
    {"material m{\n}\n", 1, 11, "expected a name and a blank before the {"},
    {"material {\n}\n", 1, 10, "expected a name and a blank before the {"},
    {"mesh t.obj 0 0 0 {\n}\n", 1, 18, "expected scale (a number), '{' came"},
    {"mesh t.obj 0 0 0 material ruby\n", 1, 27, "there is no material 'ruby'"},
    {"mesh t.obj 0 0 0 material\n", 1, 26, "expected the name of a material"},
    {"material a\nmesh t.obj 0 0 0 material a material a\n", 2, 29, "there is a material already"},
    {"ambient 1 1\n", 1, 12, "expected b"},
    {"ambient 1 -1 1\n", 1, 11, "g is -1; it must be finite and 0 or more"},
    {"include no.scene\n", 1, 9, "no.scene: cannot open"},
    {"camera 0 0 0\ninclude s.scene\n", 2, 9, "s.scene includes itself"},
    {"", 1, 1, "no item in the file"},
    {"# only\n\n# comments\n", 4, 1, "no item in the file"},
    {"\x01\x02 0 0\n", 1, 1, "unknown item '?\?'"},
    {"light 0 0 0 1 1 1\nmesh t.obj 0 0 0\nskybox sky.tga\ncamera 9 9 9\nsphere 0 0 0 1 m.mtl\nx\n", 6, 1,
     "unknown item 'x'"},
};

static void every_mistake_has_its_place(void **state)
{
    fixture *f = *state;
    load_good(f, "camera 1 2 3\nlight 0 5 0 1 1 1\nsphere 0 0 0 1 \"m.mtl#shiny one\"\n");
    uint64_t before = daft_scene_hash(f->scene);
    daft_assets_mark assets = daft_assets_remember(f->scene);
    char path[256];
    strcpy(path, path_of(f, "s.scene"));
    for (size_t i = 0; i < DAFT_COUNT_OF(BAD); i++) {
        daft_error error;
        char text[1100];
        if (load(f, BAD[i].text, &error)) fail_msg("accepted: %s", BAD[i].text);
        daft_error_text(&error, text, sizeof text);
        if (error.line != BAD[i].line || error.column != BAD[i].column || !strstr(error.message, BAD[i].says))
            fail_msg("wanted %d:%d %s\n     got %s", BAD[i].line, BAD[i].column, BAD[i].says, text);
        assert_string_equal(error.file, path);
        assert_true(daft_scene_hash(f->scene) == before);
        daft_assets_mark after = daft_assets_remember(f->scene);
        assert_memory_equal(&after, &assets, sizeof assets);
        assert_int_equal(daft_scene_camera_count(f->scene), 1);
        assert_int_equal(f->scene->sky.kind, DAFT_SKY_COLOR);
    }
    /* what failed leaves nothing behind that would spoil the next load */
    load_good(f, "mesh t.obj 0 0 0\nskybox sky.tga\nsphere 0 0 0 1 m.mtl\n");
}

static uint32_t live_assets(const fixture *f)
{
    const daft_slots *lists[] = {&f->scene->assets.material_slots, &f->scene->assets.texture_slots,
                                 &f->scene->assets.mesh_slots};
    uint32_t live = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(lists); i++)
        for (uint32_t k = 0; k < lists[i]->count; k++) live += lists[i]->items[k].live;
    return live;
}

/* Told once some materials and their images are there already, which go again. */
static void mistakes_leave_no_materials(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *text;
        int line, column;
        const char *says;
    } bad[] = {
        {"material m\nmaterial m\n", 2, 10, "there is a material 'm' already: "},
        {"material ruby texture=sky.tga\nmesh t.obj 0 0 0 material rubi\n", 2, 27,
         "there is no material 'rubi': did you mean 'ruby'?"},
        {"material m texture=sky.tga bump_texture=no.png\n", 1, 41, "no.png"},
        {"material m texture=sky.tga\nsphere 0 0 0 1 n.mtl\n", 2, 16, "n.mtl: cannot open"},
    };
    const uint32_t before = live_assets(f);
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        daft_error error;
        assert_false(load(f, bad[i].text, &error));
        if (error.line != bad[i].line || error.column != bad[i].column || !strstr(error.message, bad[i].says))
            fail_msg("wanted %d:%d %s, got %d:%d %s", bad[i].line, bad[i].column, bad[i].says, error.line, error.column,
                     error.message);
        assert_int_equal(live_assets(f), before);
    }
}

static void mistakes_inside_files_keep_their_own_place(void **state)
{
    fixture *f = *state;
    daft_error error;
    write_text(f, "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    assert_false(load(f, "camera 0 0 0\nmesh bad.obj 0 0 0\n", &error));
    assert_int_equal(error.line, 4);
    assert_non_null(strstr(error.file, "bad.obj"));
    write_text(f, "bad.scene", "camera 0 0 0\nlight 1\n");
    assert_false(load(f, "include bad.scene\n", &error));
    assert_int_equal(error.line, 2);
    assert_int_equal(error.column, 8);
    assert_non_null(strstr(error.file, "bad.scene"));
    write_text(f, "bad.mtl", "\nhello world\n");
    assert_false(load(f, "sphere 0 0 0 1 bad.mtl\n", &error));
    assert_int_equal(error.line, 2);
    assert_non_null(strstr(error.file, "bad.mtl"));
    write_text(f, "bad.png", "this is no picture");
    assert_false(load(f, "skybox bad.png\n", &error));
    assert_non_null(strstr(error.message, "bad.png"));
    assert_int_equal(error.line, 1);
    assert_int_equal(error.column, 8);
}

static void missing_scene_files_are_named(void **state)
{
    fixture *f = *state;
    daft_error error;
    assert_false(daft_scene_load(f->scene, path_of(f, "none.scene"), &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_non_null(strstr(error.file, "none.scene"));
    assert_false(daft_scene_load(f->scene, f->folder, &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_non_null(strstr(error.message, "directory"));
    assert_false(daft_scene_load(f->scene, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
}

static void include_cycles_end(void **state)
{
    fixture *f = *state;
    daft_error error;
    write_text(f, "a.scene", "include b.scene\n");
    write_text(f, "b.scene", "camera 0 0 0\ninclude ./a.scene\n");
    assert_false(daft_scene_load(f->scene, path_of(f, "a.scene"), &error));
    assert_int_equal(error.line, 2);
    assert_non_null(strstr(error.file, "b.scene"));
    assert_non_null(strstr(error.message, "includes itself"));
    for (int i = 0; i < 20; i++) {
        char name[32], text[64];
        snprintf(name, sizeof name, "d%d.scene", i);
        snprintf(text, sizeof text, i < 19 ? "include d%d.scene\n" : "camera 0 0 0\n", i + 1);
        write_text(f, name, text);
    }
    assert_false(daft_scene_load(f->scene, path_of(f, "d0.scene"), &error));
    assert_non_null(strstr(error.message, "more than 16 deep"));
    assert_non_null(strstr(error.file, "d16.scene"));
    assert_true(daft_scene_load(f->scene, path_of(f, "d3.scene"), &error));
}

/* Whatever bytes come, the answer is true or an error with a place, and never a crash (this runs under sanitizers too).
 */
static void garbage_is_survived(void **state)
{
    fixture *f = *state;
    static const char good[] = "camera 1 2 3 4 5 6\nlight 1 2 3 1 1 1 # light\nmesh t.obj 1 2 3 4 5 6 7\n"
                               "sphere 1 2 3 4 \"m.mtl#shiny one\"\nsun 0 1 0 1 1 1\nambient 1 1 1\n";
    static const char bytes[] = "0123456789.-+eE \t\n\r\"#x\0\xff/s";
    uint64_t random = 12345;
    int accepted = 0;
    for (int round = 0; round < 2000; round++) {
        char text[sizeof good];
        memcpy(text, good, sizeof good);
        for (int i = 0; i <= round % 4; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            text[(random >> 33) % (sizeof good - 1)] = bytes[(random >> 20) % sizeof bytes];
        }
        write_bytes(f, "s.scene", text, sizeof good - 1);
        daft_error error;
        bool done = daft_scene_load(f->scene, path_of(f, "s.scene"), &error);
        accepted += done;
        assert_true(done || error.line > 0);
    }
    print_message("%d of 2000 were scenes\n", accepted);
    assert_true(accepted > 100 && accepted < 1900);
}

/* ---- memory ---- */

static void running_out_of_memory_is_an_error(void **state)
{
    fixture *f = *state;
    write_text(f, "s.scene",
               "camera 0 0 0\nskybox sky.tga\nlight 1 1 1 1 1 1\nsphere 0 0 0 1 m.mtl\nmesh t.obj 0 0 0 2 material m\n"
               "material m texture=sky.tga bump_texture=sky.tga\n");
    char path[256];
    strcpy(path, path_of(f, "s.scene"));
    uint64_t empty = daft_scene_hash(f->scene);
    for (long n = 1;; n++) {
        daft_error error;
        f->fail_at = f->allocations + n;
        bool done = daft_scene_load(f->scene, path, &error);
        f->fail_at = 0;
        if (done) {
            print_message("%ld allocations\n", n - 1);
            assert_true(n > 20);
            break;
        }
        assert_int_equal(error.code, DAFT_ERROR_MEMORY);
        assert_true(daft_scene_hash(f->scene) == empty);
        const daft_assets *assets = &f->scene->assets;
        assert_true(assets->mesh_slots.live == 0 && assets->texture_slots.live == 0 &&
                    assets->material_slots.live == 1);
    }
    assert_int_equal(daft_entity_count(f->scene), 2);
}

/* ---- the real thing ---- */

static void hand_scene_loads(void **state)
{
    fixture *f = *state;
    const char *path = DAFT_ROOT "/../shared/data/models/hand/hand.scene";
    if (!daft_file_exists(NULL, path)) {
        print_message("skipped: no %s\n", path);
        skip();
    }
    daft_error error = {0};
    char text[1100];
    if (!daft_scene_load(f->scene, path, &error)) fail_msg("%s", daft_error_text(&error, text, sizeof text));
    assert_int_equal(daft_scene_camera_count(f->scene), 1);
    assert_int_equal(f->scene->light_slots.live, 3);
    assert_int_equal(daft_entity_count(f->scene), 1);
    daft_ray_hit hit;
    daft_camera camera = daft_scene_camera(f->scene, 1);
    assert_true(daft_scene_cast_ray(f->scene, camera.position, daft_v3(1, 0, 0), 10, (daft_entity){0}, &hit, NULL));
    assert_int_equal(f->warnings, 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(areas_are_read),
        TEST(every_line_means_what_the_manual_says),
        TEST(items_have_options),
        TEST(every_form_is_in_the_manual),
        TEST(materials_keep_their_meaning),
        TEST(materials_have_names),
        TEST(materials_have_blocks),
        TEST(materials_have_all_fields),
        TEST(glass_keeps_its_meaning),
        TEST(includes_are_relative_to_their_file),
        TEST(byte_order_mark_is_skipped),
        TEST(every_mistake_has_its_place),
        TEST(mistakes_leave_no_materials),
        TEST(mistakes_inside_files_keep_their_own_place),
        TEST(missing_scene_files_are_named),
        TEST(include_cycles_end),
        TEST(garbage_is_survived),
        TEST(running_out_of_memory_is_an_error),
        TEST(hand_scene_loads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
