/* daft check, daft_check_file and daft_mesh_check: each kind of odd input is told of, at its place, and what is sound
 * is left in peace. */
#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

#include "runtime_program.h"

static char output[OUTPUT_SIZE];
static char folder[64];

#define MAX_FILES 64
static char files[MAX_FILES][160];
static size_t file_count;

static int set_up(void **unused)
{
    (void)unused;
    snprintf(folder, sizeof folder, "/tmp/daft-check-%d", (int)getpid());
    file_count = 0;
    return mkdir(folder, 0700);
}

static int tear_down(void **unused)
{
    (void)unused;
    while (file_count > 0) remove(files[--file_count]);
    return rmdir(folder);
}

static char *remember(const char *name)
{
    assert_true(file_count < MAX_FILES);
    char *path = files[file_count++];
    snprintf(path, sizeof files[0], "%s/%s", folder, name);
    return path;
}

static const char *put(const char *name, const char *text)
{
    const char *path = remember(name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    return path;
}

static void make_folder(const char *name) { assert_int_equal(mkdir(remember(name), 0700), 0); }

static void expect(const char *arguments, int status, const char *says)
{
    char wanted[512];
    snprintf(wanted, sizeof wanted, "%s", says);
    int got = run_daft(output, "check %s", arguments);
    assert_status(got, status, output);
    assert_says(output, wanted);
}

/* Checks one file of the folder, and wants "FILE:place: text" for each text. */
static void expect_file(const char *name, const char *text, int status, const char *const *says, size_t count)
{
    const char *path = put(name, text);
    int got = run_daft(output, "check %s", path);
    for (size_t i = 0; i < count; i++) {
        char wanted[600];
        snprintf(wanted, sizeof wanted, "%s%s", path, says[i]);
        assert_says(output, wanted);
    }
    assert_status(got, status, output);
}
#define EXPECT_FILE(name, text, status, ...)                                                                           \
    do {                                                                                                               \
        const char *const list[] = {__VA_ARGS__};                                                                      \
        expect_file(name, text, status, list, sizeof list / sizeof list[0]);                                           \
    } while (0)

/* A tetrahedron that faces outward. */
#define SOLID "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

static void a_sound_mesh_is_left_in_peace(void **unused)
{
    (void)unused;
    const char *path = put("solid.obj", SOLID);
    int status = run_daft(output, "check %s", path);
    assert_status(status, 0, output);
    assert_string_equal(output, "1 file checked: 0 errors, 0 warnings\n");
}

static void odd_meshes_are_told_with_their_lines(void **unused)
{
    (void)unused;
    EXPECT_FILE("nan.obj", SOLID "v 1 nan 2\nf 1 2 5\n", 0, ":9:1: warning: the vertex is not finite",
                ":10:1: warning: the face is left out: a vertex of it is not finite");
    assert_says(output, "1 file checked: 0 errors, 2 warnings");
    EXPECT_FILE("inf.obj", "v 0 0 0\nv 1 0 0\nv 1e99 1 0\nv 0 1 0\nf 1 2 4\n", 0,
                ":3:1: warning: the vertex is not finite");
    EXPECT_FILE("far.obj", SOLID "v 1e20 0 0\n", 0, ":9:1: warning: the vertex is more than 1e15 from the origin",
                ": note: vertices that no triangle uses: 1");
    EXPECT_FILE("area.obj", SOLID "v 2 0 0\nv 3 0 0\nv 4 0 0\nf 5 6 7\nf 1 1 2\n", 0,
                ":12:1: warning: the face has a triangle without area", ":13:1: warning: the face is left out");
    EXPECT_FILE("twice.obj", SOLID "f 2 1 3\n", 0, ":9:1: warning: the face covers one with the same corners",
                ":5:1: note: 3 edges are shared by more than two triangles");
    EXPECT_FILE("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 3\n", 0,
                ":5:1: note: 3 open edges: the mesh is not closed");
    EXPECT_FILE("turned.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n", 0,
                ":5:1: warning: 1 edge lies between triangles that face opposite ways");
    EXPECT_FILE("places.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 0 1 -0\nv 1 1 0\nf 1 2 3\nf 4 6 5\n", 0,
                ": note: vertices in the place of an earlier one: 2", ":7:1: note: 4 open edges");
    EXPECT_FILE("normal.obj",
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn 0 0 5\nvt 2 nan\nvt 1e9 0\n"
                "f 1/1/1 2/2/2 3/2/2\n",
                0, ":4:1: warning: the normal has no direction", ": note: 1 of 2 normals are not of length 1",
                ":6:1: warning: the texture coordinate is not finite",
                ":7:1: warning: the texture coordinate is beyond 10,000 repeats");
    EXPECT_FILE("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 1,
                ":4:1: error: no face of the file can be used: it names a vertex that does not exist");
    EXPECT_FILE("empty.obj", "v 0 0 0\n", 0, ":1:1: warning: the file has no faces: the mesh is empty");
    EXPECT_FILE("nothing.obj", "", 1, ": error: the file is empty, not an OBJ mesh");
}

static void places_are_few_and_the_rest_is_counted(void **unused)
{
    (void)unused;
    char text[4096] = SOLID;
    for (int i = 0; i < 20; i++) strcat(text, "v nan 0 0\n");
    const char *path = put("many.obj", text);
    int status = run_daft(output, "check %s", path);
    assert_status(status, 0, output);
    assert_says(output, "many.obj:9:1: warning");
    assert_says(output, "many.obj:13:1: warning");
    assert_null(strstr(output, "many.obj:14:1"));
    assert_says(output, "many.obj: warning: and 15 more: 20 vertices are not finite");
}

static void odd_materials_are_told(void **unused)
{
    (void)unused;
    EXPECT_FILE("paint.mtl", "newmtl red\nKd 1 0 0\nmap_Kd nothing.png\nnewmtl blue\nKd 0 0 1\nnewmtl red\nNs 5000\n",
                0, ":3:8: warning: a checker stands in for the texture", ": warning: the material 'red' is there twice",
                ":7:1: warning: 5000 is out of range, and is taken as 1000");
    EXPECT_FILE("cube.mtl", "newmtl a\nrefl -type cube_top a.png\nrefl -type cube_left a.png\n", 0,
                ":3:1: warning: the cube that is mirrored lacks cube_right, cube_bottom, cube_front, cube_back");
    EXPECT_FILE("six.mtl",
                "newmtl a\nrefl -type cube_top a.png\nrefl -type cube_left b.png\nrefl -type cube_right c.png\n"
                "refl -type cube_bottom d.png\nrefl -type cube_front e.png\nrefl -type cube_back f.png\n",
                0, ":4:23: warning: the cube that is mirrored is left out: ");
    EXPECT_FILE("bad.mtl", "newmtl red\nKd 1 nan 0\n", 0,
                ":2:6: warning: a finite number is needed here: the line is left out");
    EXPECT_FILE("painted.obj", "mtllib paint.mtl\nusemtl blue\n" SOLID, 0,
                ":1:8: note: materials that no face uses, 2 of 3: red, red");
    EXPECT_FILE("unpainted.obj", "mtllib none.mtl\nusemtl blue\n" SOLID, 0,
                ":1:8: warning: no such material file: 'none.mtl'");
    EXPECT_FILE("green.obj", "mtllib paint.mtl\nusemtl green\n" SOLID, 0,
                ":2:8: warning: no material file defines 'green'");
}

static void every_bad_line_of_a_scene_is_told(void **unused)
{
    (void)unused;
    put("solid.obj", SOLID);
    put("red.mtl", "newmtl red\nKd 1 0 0\n");
    EXPECT_FILE("bad.scene",
                "camera 0 0\nlihgt 1 2 3 1 1 1\nsphere 0 0 0 0 red.mtl\nsphere 0 0 0 -1 red.mtl\n"
                "sphere 0 0 0 nan red.mtl\nmesh none.obj 0 0 0\nmesh solid.obj 0 0 0 0\nsun 0 0 0 1 1 1\n"
                "spot 0 0 0 0 0 0 1 1 1\nspot 0 0 0 0 1 0 1 1 1 0\nspot 0 0 0 0 1 0 1 1 1 20 30\n",
                1, ":1:11: error: expected z", ":2:1: error: unknown item 'lihgt'",
                ":3:14: error: r is 0; it must be finite and above", ":4:14: error: r is -1",
                ":5:14: error: expected r (a number), 'nan' came", ":6:6: error: ", ":7:22: error: scale is 0",
                ":8:5: error: direction is 0, 0, 0", ":9:12: error: direction is 0, 0, 0", ":10:24: error: angle is 0",
                ":11:27: error: inner is 30; it must be at most 20, the number before it");
    assert_says(output, "1 file checked: 11 errors, 0 warnings");
}

static void odd_scenes_are_told(void **unused)
{
    (void)unused;
    put("solid.obj", SOLID);
    put("red.mtl", "newmtl red\nKd 1 0 0\n");
    EXPECT_FILE("inside.scene", "sphere 0 0 0 2 red.mtl\ncamera 0 1 0\nlight 0 0 1 1 1 1\nlight 9 9 9 0 0 0\n", 0,
                ":2:1: warning: the camera is inside the sphere of ", ":3:1: warning: the light is inside the sphere",
                ":4:1: note: a black light lights nothing");
    EXPECT_FILE("dull.scene", "camera 9 0 0\nsphere 0 0 0 2 red.mtl lights=true\nrectangle 0 0 1 1 0 0 1 1 1 1 1\n", 0,
                ":2:16: note: it has 'lights', but its material gives off no light",
                ":3:1: warning: the light is inside the sphere");
    EXPECT_FILE("dark.scene", "camera 9 9 9\nmesh solid.obj 0 0 0 4 lights=true\nlight 9 8 9 1 1 1\n", 0,
                ":2:6: note: it has 'lights', but its material gives off no light");
    EXPECT_FILE("mesh.scene", "camera 0.5 0.5 0.5\nmesh solid.obj 0 0 0 4\nlight 5 5 5 1 1 1\n", 0,
                ":1:1: warning: the camera is inside the mesh of ");
    put("beside.scene", "camera 3.5 3.5 3.5\nmesh solid.obj 0 0 0 4\nlight 5 5 5 1 1 1\n");
    expect(files[file_count - 1], 0, "1 file checked: 0 errors, 0 warnings\n");
    assert_null(strstr(output, "beside.scene:"));
    EXPECT_FILE("twins.scene",
                "camera 9 0 0\nlight 9 9 9 1 1 1\nmesh solid.obj 1 2 3\nmesh solid.obj 1 2 3.5\nmesh solid.obj 1 2 3\n",
                0, ":5:6: warning: the same is in the same place already: ");
    EXPECT_FILE("spare.scene",
                "camera 9 0 0\nlight 9 9 9 1 1 1\nmaterial spare\nmaterial red\nmesh solid.obj 0 0 0 material red\n", 0,
                ":3:1: note: no mesh or sphere uses the material");
    assert_null(strstr(output, ":4:1:"));
    EXPECT_FILE("mirror.scene", "camera 9 0 0\nlight 9 9 9 1 1 1\nmesh solid.obj 0 0 0 -1\n", 0,
                ":3:6: note: a negative scale mirrors the mesh");
    EXPECT_FILE("tiny.scene", "camera 9 0 0\nlight 9 9 9 1 1 1\nmesh solid.obj 0 0 0 1e-42\n", 0,
                ":3:6: warning: it is not drawn");
    EXPECT_FILE("large.scene",
                "camera 9 0 0\nlight 9 9 9 1 1 1\nsphere 0 1e20 0 1e15 red.mtl\nsphere 9 9 0 1e-20 red.mtl\n", 0,
                ":3:22: warning: it is not drawn", ":4:20: warning: it is not drawn");
    EXPECT_FILE("black.scene", "ambient 0 0 0\nsphere 5 0 0 1 red.mtl\n", 0, ": note: no camera",
                ": warning: no light, and no ambient light: everything is black");
}

static void odd_glass_is_told(void **unused)
{
    (void)unused;
    put("glass.mtl", "newmtl a\nillum 7\nNi 1.5\nTf .5 .5 1\nnewmtl b\nd 0.3\nNi 1.45\nTf 0 0 0\n");
    expect(files[file_count - 1], 0, "1 file checked: 0 errors, 0 warnings\n");
    EXPECT_FILE("flat.mtl", "newmtl a\nillum 7\n", 0,
                ": note: the material 'a' should bend light (illum 7), but its Ni is 1");
    EXPECT_FILE("dark.mtl", "newmtl a\nillum 4\nd 0.5\nTf 0 0 0\n", 0,
                ": warning: the material 'a' should let light through (illum 4), but its Tf is black");
    EXPECT_FILE("gone.mtl", "newmtl a\nTr 1\n", 0, ": warning: the material 'a' lets all light through");
    EXPECT_FILE("bad.mtl", "newmtl a\nNi 0\nTf 2 0 -1\nNi 11\n", 0, ":2:1: warning: 0 is no index of refraction",
                ":3:1: warning: 2 is out of range, and is taken as 1", ":3:1: warning: -1 is out of range",
                ":4:1: warning: 11 is out of range, and is taken as 10");
    put("lens.mtl", "newmtl lens\nillum 7\nNi 1.5\n");
    EXPECT_FILE("open.obj", "mtllib lens.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl lens\nf 1 2 3\n", 0,
                ": warning: light is bent where it enters, and the mesh is not closed");
}

static void scripts_are_read(void **unused)
{
    (void)unused;
    put("course.lua", "return {}\n");
    put("good.lua", "-- mesh = \"nothing.obj\"\n--[[ texture = \"nothing\" ]]\nlocal c = require \"course\"\n"
                    "local m = { mesh = \"meshes/gem.obj\", texture = \"checker\" }\nlocal texture = \"any value\"\n"
                    "local name = \"level\" .. \".obj\"\nlocal s = [[ \"x.obj\" ]] .. 'it\\'s.obj'\n");
    expect(files[file_count - 1], 0, "1 file checked: 0 errors, 0 warnings\n");
    EXPECT_FILE("syntax.lua", "local a = 1\nlocal b = = 2\n", 1, ":2: error: unexpected symbol near '='");
    EXPECT_FILE("names.lua",
                "require(\"nowhere\")\ndaft.entity { mesh = \"no/such.obj\" }\nlocal t = { texture = 'brickk' }\n"
                "daft.scene \"levels/one.scene\"\n",
                1, ":1:9: error: there is no module 'nowhere.lua'", ":2:22: error: there is no file 'no/such.obj'",
                ":3:23: error: there is no file 'brickk'", ":4:12: warning: there is no file 'levels/one.scene'");
}

static void games_are_checked_and_run(void **unused)
{
    (void)unused;
    make_folder("game");
    put("game/main.lua", "local level = require 'level'\nfunction daft.update()\n  level.go()\nend\n");
    put("game/level.lua", "return { go = function()\n  error('fell')\nend }\n");
    put("game/demo.rec", "daft-recording 1\ngame other\nrate 60\nseed 1\nend 10\n");
    put("game/cut.rec", "daft-recording 1\ngame game\n");
    put("game/thing.obj", "v 0 0\n");
    char path[128];
    snprintf(path, sizeof path, "%s/game", folder);
    expect(path, 1, "/game/level.lua:2: error: fell");
    assert_says(output, "/game/demo.rec: warning: a recording of the game 'other', in the folder of 'game'");
    assert_says(output, "/game/cut.rec:4:1: error: the 'end' line is missing");
    assert_says(output, "/game/thing.obj:1:6: warning: 'v' needs more numbers than this: the line is left out");
    assert_says(output, "5 files checked: 2 errors, 4 warnings\n");
    expect("marble", 0, " 0 errors, 0 warnings");
    expect("assets games scripts", 0, " 0 errors, ");
}

static void folders_are_walked(void **unused)
{
    (void)unused;
    make_folder("a");
    put("a/one.obj", "f 1 2 3\n");
    make_folder("a/b");
    put("a/b/two.obj", "\nf 1 2 3\n");
    put("a/b/notes.txt", "nothing of ours\n");
    put("a/b/picture.png", "no picture");
    expect(folder, 1, "/a/b/picture.png: error: ");
    assert_says(output, "/a/one.obj:1:1: error: ");
    assert_says(output, "/a/b/two.obj:2:1: error: ");
    assert_says(output, "3 files checked: 3 errors, 2 warnings");
    make_folder("c");
    char path[128];
    snprintf(path, sizeof path, "%s/c", folder);
    expect(path, 0, "/c: note: nothing in the folder can be checked");
    expect("/no/such/folder", 1, "there is no game '/no/such/folder'");
    expect("no/such.obj", 1, "no/such.obj: error: there is no such file");
}

static void strict_counts_warnings_and_json_lists_them(void **unused)
{
    (void)unused;
    const char *path = put("area.obj", SOLID "v 2 0 0\nf 1 2 5\n");
    char arguments[400], text[1024] = "";
    snprintf(arguments, sizeof arguments, "--strict %s", path);
    expect(arguments, 1, "warning");
    snprintf(arguments, sizeof arguments, "%s --json %s", path, remember("out.json"));
    expect(arguments, 0, "0 errors, 1 warning\n");
    FILE *file = fopen(files[file_count - 1], "r");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    fclose(file);
    assert_true(strncmp(text, "[\n  {\"file\": \"", 14) == 0);
    assert_says(text, "area.obj\", \"line\": 10, \"column\": 1, \"severity\": \"warning\", \"text\": \"the face has");
    assert_string_equal(text + strlen(text) - 3, "\n]\n");
    expect("--json /no/such/x.json assets/meshes/gem.obj", 1, "/no/such/x.json");
}

/* ---- the library ---- */

typedef struct found {
    int errors, warnings, notes;
    daft_error last;
} found;

static void on_problem(void *user, daft_severity severity, const daft_error *problem)
{
    found *f = user;
    f->errors += severity == DAFT_SEVERITY_ERROR;
    f->warnings += severity == DAFT_SEVERITY_WARNING;
    f->notes += severity == DAFT_SEVERITY_NOTE;
    f->last = *problem;
}

static void on_warning(void *user, const daft_error *warning)
{
    (void)warning;
    ++*(int *)user;
}

static void files_are_checked_through_the_library(void **unused)
{
    (void)unused;
    int warnings = 0;
    daft_engine_def def = daft_default_engine_def();
    def.warn = on_warning;
    def.warn_user = &warnings;
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_error error;
    found f = {0};
    assert_true(daft_check_file(engine, put("bad.mtl", "\nhello a\n"), on_problem, &f, &error));
    assert_int_equal(f.errors, 1);
    assert_int_equal(f.last.line, 2);
    f = (found){0};
    assert_true(daft_check_file(engine, put("odd.mtl", "newmtl a\nwhat 1\n"), on_problem, &f, &error));
    assert_int_equal(f.errors + 10 * f.warnings, 10);
    assert_int_equal(warnings, 0); /* they go to the caller of the check alone */
    f = (found){0};
    assert_true(daft_check_file(engine, "/no/such.scene", on_problem, &f, &error));
    assert_int_equal(f.errors, 1);
    assert_false(daft_check_file(engine, NULL, on_problem, &f, &error));
    assert_false(daft_check_file(engine, "x.obj", NULL, NULL, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    daft_engine_destroy(engine);
}

static daft_mesh_report report_of(daft_scene *scene, const daft_vec3 *positions, uint32_t vertices,
                                  const uint32_t *indices, uint32_t triangles)
{
    daft_error error;
    daft_mesh_report report = {0};
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions;
    def.vertex_count = vertices;
    def.indices = indices;
    def.triangle_count = triangles;
    daft_mesh mesh = daft_mesh_create(scene, &def, &error);
    if (!mesh.id || !daft_mesh_check(scene, mesh, &report, &error)) fail_msg("%s", error.message);
    return report;
}

static void meshes_are_counted(void **unused)
{
    (void)unused;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_scene *scene = daft_scene_create(engine, NULL);
    const daft_vec3 p[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {2, 0, 0}, {NAN, 0, 0}};
    const uint32_t solid[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    daft_mesh_report r = report_of(scene, p, 4, solid, 4), none = {0};
    assert_memory_equal(&r, &none, sizeof r);
    /* the same closed by a vertex in the place of another one */
    const uint32_t seam[] = {0, 2, 1, 0, 4, 3, 0, 3, 2, 1, 2, 3};
    r = report_of(scene, p, 5, seam, 4);
    assert_int_equal(r.duplicate_vertices, 1);
    assert_int_equal(r.open_edges + r.non_manifold_edges + r.turned_edges, 0);
    const uint32_t two_sided[] = {0, 1, 2, 0, 2, 1};
    r = report_of(scene, p, 3, two_sided, 2);
    assert_memory_equal(&r, &none, sizeof r);
    const uint32_t odd[] = {0, 2, 1, 0, 1, 5, 1, 0, 2, 0, 0, 1, 0, 1, 6};
    r = report_of(scene, p, 7, odd, 5);
    assert_int_equal(r.left_out, 2);
    assert_int_equal(r.without_area, 1);
    assert_int_equal(r.duplicate_triangles, 1);
    assert_int_equal(r.unused_vertices, 3);
    assert_int_equal(r.open_edges, 2);
    assert_int_equal(r.non_manifold_edges, 1);
    r = report_of(scene, p, 0, NULL, 0);
    assert_memory_equal(&r, &none, sizeof r);
    daft_error error;
    assert_false(daft_mesh_check(scene, (daft_mesh){99}, &r, &error));
    assert_int_equal(error.code, DAFT_ERROR_HANDLE);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

/* ---- memory that is out, at every allocation in turn ---- */

static void *scarce_allocate(void *user, size_t size, size_t alignment)
{
    int *left = user;
    if ((*left)-- <= 0) return NULL;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void scarce_release(void *user, void *pointer)
{
    (void)user;
    free(pointer);
}

static void checks_end_well_without_memory(void **unused)
{
    (void)unused;
    put("paint.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    put("solid.obj", "mtllib paint.mtl\nusemtl red\n" SOLID "f 1 2 4\n");
    put("room.scene", "camera 0 0 0\nmesh solid.obj 1 0 0\nsphere 0 0 0 1 paint.mtl\nlihgt\n");
    for (size_t i = 0; i < 3; i++) {
        int left = 1 << 20;
        daft_engine_def def = daft_default_engine_def();
        def.threads = 1;
        def.allocator = (daft_allocator){.user = &left, .allocate = scarce_allocate, .release = scarce_release};
        daft_engine *engine = daft_engine_create(&def, NULL);
        assert_non_null(engine);
        daft_error error;
        found f;
        int given = 0;
        for (bool done = false; !done; given++) {
            f = (found){0};
            left = given;
            done = daft_check_file(engine, files[file_count - 1 - i], on_problem, &f, &error);
            if (!done) assert_int_equal(error.code, DAFT_ERROR_MEMORY);
            assert_true(given < 1000);
        }
        assert_true(given > 2);
        assert_int_equal(f.errors, i == 0);
        left = 1 << 20;
        daft_engine_destroy(engine);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_sound_mesh_is_left_in_peace, set_up, tear_down),
        cmocka_unit_test_setup_teardown(odd_meshes_are_told_with_their_lines, set_up, tear_down),
        cmocka_unit_test_setup_teardown(places_are_few_and_the_rest_is_counted, set_up, tear_down),
        cmocka_unit_test_setup_teardown(odd_materials_are_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(every_bad_line_of_a_scene_is_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(odd_scenes_are_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(odd_glass_is_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(scripts_are_read, set_up, tear_down),
        cmocka_unit_test_setup_teardown(games_are_checked_and_run, set_up, tear_down),
        cmocka_unit_test_setup_teardown(folders_are_walked, set_up, tear_down),
        cmocka_unit_test_setup_teardown(strict_counts_warnings_and_json_lists_them, set_up, tear_down),
        cmocka_unit_test_setup_teardown(files_are_checked_through_the_library, set_up, tear_down),
        cmocka_unit_test_setup_teardown(checks_end_well_without_memory, set_up, tear_down),
        cmocka_unit_test(meshes_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
