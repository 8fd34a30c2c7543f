/* OBJ files: every form of statement, the rules for what is wrong, materials and normals. */
#include "obj_fixture.h"

static void corner_forms(void **unused)
{
    (void)unused;
    static const char *const faces[] = {"f 1 2 3",
                                        "f 1/1 2/2 3/3",
                                        "f 1//1 2//1 3//1",
                                        "f 1/1/1 2/2/1 3/3/1",
                                        "f -4 -3 -2",
                                        "f -4/-3/-1 -3/-2/-1 -2/-1/-1",
                                        "f 1/ 2// 3",
                                        "f 1/1 2//1 3",
                                        "f\t1\t2\t3 # comment",
                                        "  f  1  2  3  ",
                                        "f 1 2 \\\n3",
                                        "f 1 \\\r\n2 3",
                                        "f +1 +2 +3"};
    for (size_t i = 0; i < DAFT_COUNT_OF(faces); i++) {
        char text[512];
        snprintf(text, sizeof text, SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 2\n%s", faces[i]);
        daft_obj obj = parse(text);
        assert_int_equal(obj.mesh.triangle_count, 1);
        const uint32_t expected[3] = {0, 1, 2};
        assert_memory_equal(obj.mesh.indices, expected, sizeof expected);
        assert_int_equal(warnings.count, 0);
        check_mesh(&obj);
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t n = obj.mesh.normal_indices ? obj.mesh.normal_indices[k] : obj.mesh.indices[k];
            assert_true(obj.mesh.normals[n].z > 0.999f);
        }
        free_obj(&obj);
    }
}

static void corners_without_uv_stay_without(void **unused)
{
    (void)unused;
    daft_obj obj = parse(SQUARE "vt .1 .2\nvt .3 .4 .5\nvt .6\nf 1/2 2 3/3\nf 1/0 3/1 4/-1\n");
    const uint32_t expected[6] = {1, DAFT_NO_UV, 2, DAFT_NO_UV, 0, 2};
    assert_memory_equal(obj.mesh.uv_indices, expected, sizeof expected);
    assert_true(obj.mesh.uvs[1].y == .4f && obj.mesh.uvs[2].x == .6f && obj.mesh.uvs[2].y == 0);
    assert_int_equal(warnings.count, 0);
    check_mesh(&obj);
    free_obj(&obj);
}

static void index_lists_that_repeat_the_vertices_cost_nothing(void **unused)
{
    (void)unused;
    daft_obj obj = parse(SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n"
                                "f 1/1/1 2/2/2 3/3/3 4/4/4\n");
    assert_null(obj.mesh.uv_indices);
    assert_null(obj.mesh.normal_indices);
    assert_null(obj.mesh.slots);
    check_mesh(&obj);
    free_obj(&obj);
}

static void lines_end_in_every_way(void **unused)
{
    (void)unused;
    static const char text[] =
        "# cube\nv 0 0 0 1.0\nv 1 0 0 .5 .5 .5\n\nv 1 1 0\nv 0 1 0\n  \nusemtl a \nf 1 2 \\\n 3 4\no x\nf 1 2 3";
    daft_obj first = parse(text);
    assert_int_equal(first.mesh.triangle_count, 3);
    for (int form = 1; form < 6; form++) {
        char other[512] = "";
        size_t used = 0;
        if (form & 1) used = (size_t)snprintf(other, sizeof other, "\xEF\xBB\xBF");
        for (const char *p = text; *p; p++) {
            if (*p != '\n' || form < 2) {
                other[used++] = *p;
                continue;
            }
            other[used++] = '\r';
            if (form < 4) other[used++] = '\n';
        }
        if (form == 5) other[used++] = '\r';
        other[used] = 0;
        counting keep = memory;
        daft_obj obj = parse(other);
        assert_int_equal(obj.mesh.triangle_count, 3);
        assert_memory_equal(obj.mesh.indices, first.mesh.indices, 9 * sizeof(uint32_t));
        assert_memory_equal(obj.mesh.y, first.mesh.y, 4 * sizeof(float));
        free_obj(&obj);
        memory = keep;
    }
    free_obj(&first);
}

/* ---- what is wrong ---- */

static void errors_say_where(void **unused)
{
    (void)unused;
    refuse("", "a.obj: the file is empty");
    refuse(" \n\t\r\n# nothing\n", "a.obj: the file is empty");
    refuse("\x89PNG\r\n\x1a\n", "a.obj:1:1: not an OBJ file");
    refuse("hello world\n", "a.obj:1:1: not an OBJ file: nothing in it is known, from 'hello' on");
    refuse("\xFF\xFEv\n", "a.obj:1:1: this text is UTF-16: save it as UTF-8");
    refuse("f 1 2 3\n", "a.obj:1:1: no face of the file can be used: it names a vertex that does not exist");
    refuse(SQUARE "f 1 2 x\n", "a.obj:5:1: no face of the file can be used: a corner of it cannot be read");
}

/* What is left out, with the first warning; the square's other triangle stays. */
static void bad_lines_are_left_out(void **unused)
{
    (void)unused;
    static const struct {
        const char *line, *warning;
        uint32_t triangles;
    } cases[] = {{"v 1 x 0", "a.obj:5:5: 'x' is not a number: the line is left out", 1},
                 {"v 1 0", "a.obj:5:6: 'v' needs more numbers than this: the line is left out", 1},
                 {"v 1 0 0.1.2", "a.obj:5:7: '0.1.2' is not a number", 1},
                 {"v 1 2 3 4 oops", "a.obj:5:11: 'oops' is not a number", 1},
                 {"v 1 2 \x01\xff", "a.obj:5:7: '?\?' is not a number", 1},
                 {"vn 1 2", "a.obj:5:7: 'vn' needs more numbers", 1},
                 {"vt", "a.obj:5:3: 'vt' needs more numbers", 1},
                 {"f 1 2 99", "a.obj:5:1: the face is left out: it names a vertex that does not exist", 1},
                 {"f 1/1/1   \\\n 5000000000//7 3", "it names a vertex that does not exist", 1},
                 {"f 1 2 99999999999999999999999", "it names a vertex that does not exist", 1},
                 {"f 1 2 x", "a.obj:5:7: 'x' is not a corner of a face", 1},
                 {"f 1 2 3.5", "a.obj:5:7: '3.5' is not a corner", 1},
                 {"f 1 2 3/1/1/1", "a.obj:5:7: '3/1/1/1' is not a corner", 1},
                 {"f 1 2 /3", "a.obj:5:7: '/3' is not a corner", 1},
                 {"f 1/x 2 3", "a.obj:5:3: '1/x' is not a corner", 1}};
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        char text[256];
        snprintf(text, sizeof text, SQUARE "%s\nf 1 3 4\n", cases[i].line);
        daft_obj obj = parse(text);
        assert_int_equal(obj.mesh.triangle_count, cases[i].triangles);
        if (!memo_has(&warnings, cases[i].warning)) fail_msg("%s: %s", cases[i].line, warnings.text[0]);
        check_mesh(&obj);
        free_obj(&obj);
    }
}

/* A lost vertex, uv or normal keeps its number: faces behind it mean what they meant. */
static void lost_lines_keep_their_numbers(void **unused)
{
    (void)unused;
    daft_obj obj = parse("v 0 0 0\nv 7 7\nv 1 0 0\nv 0 1 0\nvt\nvt 0.25 0.5\nvn 1\nvn 0 0 1\n"
                         "f 1/2/2 3/2/2 4/2/2\nf 1 2 3\nf -1 -2 -4\n");
    assert_int_equal(obj.mesh.triangle_count, 2);
    assert_true(area(&obj.mesh, 0, 2) == 1);
    assert_true(obj.mesh.uvs[obj.mesh.uv_indices[0]].x == 0.25f);
    assert_true(memo_has(&warnings, "a vertex of it is not finite"));
    check_mesh(&obj);
    free_obj(&obj);
}

/* However many there are, time is linear: places are not looked for once nobody is told. */
static void a_million_bad_lines_take_no_time(void **unused)
{
    (void)unused;
    enum { LINES = 300000 };
    char *text = malloc(64 + 12 * LINES), *end = text;
    end += sprintf(end, "%s", SQUARE "f 1 2 3\n");
    for (int i = 0; i < LINES; i++) end += sprintf(end, i % 2 ? "f 1 2 x\n" : "v 0 0 y\n");
    daft_obj obj;
    daft_error error;
    assert_true(parse_bytes(text, (size_t)(end - text), &obj, &error));
    assert_int_equal(obj.mesh.triangle_count, 1);
    free_obj(&obj);
    free(text);
}

static void errors_about_the_only_faces(void **unused)
{
    (void)unused;
    refuse("f -4 -3 -2",
           "a.obj:1:3: no face of the file can be used: a negative index reaches before the first vertex");
    refuse(SQUARE "f 1\nf 1 2\n", "a.obj:5:1: no face of the file can be used: it has fewer than 3 corners");
    refuse(SQUARE "f\n", "fewer than 3 corners");
    refuse(SQUARE "\nf 1 1 2\n", "a.obj:6:1: no face of the file can be used: it has fewer than 3 different vertices");
    refuse("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
           "a.obj:4:1: no face of the file can be used: a vertex of it is not finite");
}

static void bad_faces_are_dropped_with_a_warning(void **unused)
{
    (void)unused;
    static const struct {
        const char *line, *warning;
    } cases[] = {{"f 0 1 2", "a.obj:7:3: the face is left out: vertex index 0"},
                 {"f 1 -9 2", "a.obj:7:5: the face is left out: a negative index reaches"},
                 {"f 1 2", "a.obj:7:1: the face is left out: it has fewer than 3 corners"},
                 {"f 1 2 2", "a.obj:7:1: the face is left out: it has fewer than 3 different"},
                 {"f 1 2 1 2 1", "a.obj:7:1: the face is left out: it has fewer than 3 different"},
                 {"f 1 2 5", "a.obj:7:1: the face is left out: a vertex of it is not finite"},
                 {"f 1 2 3 5 4", "a.obj:7:1: the face is left out: a vertex of it is not finite"}};
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        char text[256];
        snprintf(text, sizeof text, SQUARE "v 0 1e39 0\nf 1 2 3\n%s\nf 1 3 4\n", cases[i].line);
        daft_obj obj = parse(text);
        assert_int_equal(obj.mesh.triangle_count, 2);
        assert_int_equal(warnings.count, 1);
        assert_contains(warnings.text[0], cases[i].warning);
        assert_true(area(&obj.mesh, 0, 2) == 1);
        check_mesh(&obj);
        free_obj(&obj);
    }
}

static void warnings_are_few(void **unused)
{
    (void)unused;
    daft_obj obj = parse(SQUARE "vt 0 0\nvn 0 0 1\nfoo 1\nfoo 2\nbar\nv 1 2 3 4 5\nf 1/7/8 2/1/1 3/-5/-6\ns what\n");
    assert_int_equal(warnings.count, 8);
    assert_true(memo_has(&warnings, "a.obj:7:1: unknown statement 'foo' is skipped"));
    assert_true(memo_has(&warnings, "a.obj:9:1: unknown statement 'bar' is skipped"));
    assert_true(memo_has(&warnings, "a.obj:10:3: 'v' has 5 numbers"));
    assert_true(memo_has(&warnings, "a.obj:11:15: texture coordinate -5 reaches before the first"));
    assert_true(memo_has(&warnings, "texture coordinate 7 does not exist (the file has 1)"));
    assert_true(memo_has(&warnings, "normal 8 does not exist (the file has 1)"));
    check_mesh(&obj);
    free_obj(&obj);
    char many[4096] = SQUARE "f 1 2 3\n";
    for (int i = 0; i < 100; i++) strcat(many, "f 1 2\nf 0 0 0\nf 1 1 1\n");
    obj = parse(many);
    assert_int_equal(warnings.count, 11);
    assert_string_equal(warnings.text[10], "a.obj: and 290 more warnings");
    free_obj(&obj);
}

static void files_without_faces_load_empty(void **unused)
{
    (void)unused;
    static const char *const texts[] = {"v 0 0 0\np 1\n", SQUARE "l 1 2 3\n", "o thing\n", "usemtl x\n", "vt 0 0"};
    for (size_t i = 0; i < DAFT_COUNT_OF(texts); i++) {
        daft_obj obj = parse(texts[i]);
        assert_int_equal(obj.mesh.triangle_count, 0);
        assert_int_equal(warnings.count, 1);
        assert_contains(warnings.text[0], "the file has no faces");
        check_mesh(&obj);
        free_obj(&obj);
    }
}

/* ---- materials ---- */

static void materials_are_found(void **unused)
{
    (void)unused;
    write_test_text("a.mtl", "newmtl red\nKd 1 0 0\nnewmtl two words\nKd 0 1 0\n");
    write_test_text("name with  blanks.mtl", "newmtl blue\nKd 0 0 1\n");
    daft_obj obj = load_text("m.obj", "mtllib nope.mtl a.mtl name\\ with\\ \\ blanks.mtl\n" SQUARE
                                      "f 1 2 3\nusemtl  two words \ng part\nf 1 3 4\no next\nf 2 3 4\nusemtl unused\n"
                                      "usemtl blue\nf 1 2 4\nusemtl two words\nf 1 2 3\n");
    assert_int_equal(obj.slots.count, 3);
    assert_string_equal(obj.slots.items[0].name, "");
    assert_string_equal(obj.slots.items[1].name, "two words");
    assert_true(obj.slots.items[1].diffuse.y == 1 && obj.slots.items[2].diffuse.z == 1 &&
                obj.slots.items[0].diffuse.x == .8f);
    const uint16_t expected[5] = {0, 1, 1, 2, 1};
    assert_memory_equal(obj.mesh.slots, expected, sizeof expected);
    assert_int_equal(warnings.count, 1);
    assert_contains(warnings.text[0], "m.obj:1:8: no such material file: 'nope.mtl'");
    free_obj(&obj);

    static const char *const lines[] = {"mtllib name with  blanks.mtl",
                                        "mtllib .\\a.mtl\\\n name\\ with\\ \\ blanks.mtl",
                                        "mtllib C:\\models\\a.mtl name\\ with\\ \\ blanks.mtl # both",
                                        "mtllib a.mtl\nmtllib a.mtl\nmtllib name with  blanks.mtl\t"};
    for (size_t i = 0; i < DAFT_COUNT_OF(lines); i++) {
        char text[512];
        snprintf(text, sizeof text, "usemtl blue\n" SQUARE "f 1 2 3\n%s\n", lines[i]);
        obj = load_text("m.obj", text);
        assert_int_equal(warnings.count, 0);
        assert_true(obj.slots.count == 1 && obj.slots.items[0].diffuse.z == 1);
        free_obj(&obj);
    }
}

static void missing_materials_warn_once(void **unused)
{
    (void)unused;
    daft_obj obj = load_text("m.obj", "mtllib gone.mtl\n" SQUARE "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n");
    assert_int_equal(warnings.count, 1);
    assert_contains(warnings.text[0], "no such material file: 'gone.mtl'");
    assert_int_equal(obj.slots.count, 2);
    free_obj(&obj);
    obj = load_text("m.obj", SQUARE "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n");
    assert_int_equal(warnings.count, 1);
    assert_contains(warnings.text[0], "m.obj:5:8: no material file defines 'a' and 1 more: the default is used");
    free_obj(&obj);
}

static void an_error_in_the_material_file_is_an_error(void **unused)
{
    (void)unused;
    write_test_text("bad.mtl", "\nhello world\n");
    const char *path = write_test_text("b.obj", "mtllib bad.mtl\n" SQUARE "f 1 2 3\n");
    daft_allocator allocator = counting_allocator(&memory);
    daft_obj obj;
    daft_error error;
    assert_false(daft_obj_load(&allocator, NULL, path, NULL, &obj, &error));
    assert_contains(error.file, "bad.mtl");
    assert_true(error.line == 2 && error.column == 1);
    assert_int_equal(memory.live, 0);
    assert_false(daft_obj_load(&allocator, NULL, test_folder, NULL, &obj, &error));
    assert_contains(error.message, "is a directory");
    assert_false(daft_obj_load(&allocator, NULL, test_path("none.obj"), NULL, &obj, NULL));
    assert_int_equal(memory.live, 0);
}

/* ---- normals ---- */

static daft_vec3 normal_at(const daft_trimesh *mesh, uint32_t at)
{
    return mesh->normals[mesh->normal_indices ? mesh->normal_indices[at] : mesh->indices[at]];
}

static void smoothing_follows_the_file(void **unused)
{
    (void)unused;
    /* two faces that meet at 30 degrees along the edge 2-3 */
#define ROOF "v -1 0 0\nv 0 0 1\nv 0 0 -1\nv 0.866 -0.5 0\n"
    daft_obj obj = parse(ROOF "f 1 2 3\nf 2 4 3\n");
    assert_true(daft_dot(normal_at(&obj.mesh, 1), normal_at(&obj.mesh, 3)) > 0.99999f);
    free_obj(&obj);
    static const char *const split[] = {"s off\nf 1 2 3\nf 2 4 3\n", "s 0\nf 1 2 3\nf 2 4 3\n",
                                        "s 1\nf 1 2 3\ns 2\nf 2 4 3\n"};
    for (size_t i = 0; i < DAFT_COUNT_OF(split); i++) {
        char text[256];
        snprintf(text, sizeof text, ROOF "%s", split[i]);
        obj = parse(text);
        assert_true(daft_dot(normal_at(&obj.mesh, 1), normal_at(&obj.mesh, 3)) < 0.9f);
        assert_true(fabsf(normal_at(&obj.mesh, 0).y) > 0.9999f);
        free_obj(&obj);
    }
}

static bool same_bytes(const void *a, const void *b, size_t size) { return a && b ? memcmp(a, b, size) == 0 : a == b; }

/* A bare mesh has all but the normals that the file does not give, and those come later, bit for bit. */
static void normals_may_come_later(void **unused)
{
    (void)unused;
    static const struct {
        const char *faces;
        bool bare;
    } cases[] = {{"f 1 2 3\nf 2 4 3\n", true},
                 {"s off\nf 1 2 3\nf 2 4 3\n", true},
                 {"s 1\nf 1 2 3\ns 2\nf 2 4 3\n", true},
                 {"s 1\nf 1 2 4 3\nusemtl b\nf 2 4 3\n", true},
                 {"vn 0 0 0\ns 0\nf 1//1 2//1 3//1\nf 2//1 4//1 3//1\n", true},
                 {"vn 0 1 0\nf 1//1 2//1 3//1\nf 2//1 4//1 3//1\n", false},
                 {"vn 0 1 0\ns 1\nf 1//1 2//1 3//1\nf 2 4 3\n", false}};
    daft_allocator allocator = counting_allocator(&memory);
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        char text[256];
        snprintf(text, sizeof text, ROOF "%s", cases[i].faces);
        daft_obj whole = parse(text), bare;
        const char *path = write_test_text("bare.obj", text);
        assert_true(daft_obj_load_triangles(&allocator, NULL, path, NULL, &bare, NULL));
        assert_int_equal(!bare.mesh.normals, cases[i].bare);
        assert_int_equal(!bare.mesh.normal_indices && !bare.mesh.normal_count, cases[i].bare);
        if (cases[i].bare) {
            long live = memory.live;
            memory.fail_at = memory.calls;
            assert_false(daft_obj_smooth(&allocator, &bare, NULL));
            memory.fail_at = -1;
            assert_true(!bare.mesh.normals && !bare.mesh.normal_indices && memory.live == live);
            assert_true(daft_obj_smooth(&allocator, &bare, NULL) && !bare.groups);
        }
        check_mesh(&bare);
        const daft_trimesh *a = &whole.mesh, *b = &bare.mesh;
        size_t corners = 3 * (size_t)a->triangle_count * sizeof(uint32_t);
        assert_true(a->triangle_count == b->triangle_count && a->normal_count == b->normal_count);
        assert_true(same_bytes(a->indices, b->indices, corners) &&
                    same_bytes(a->x, b->x, a->vertex_count * sizeof(float)));
        assert_true(same_bytes(a->normal_indices, b->normal_indices, corners));
        assert_true(same_bytes(a->normals, b->normals, a->normal_count * sizeof *a->normals));
        daft_obj_free(&allocator, &bare);
        free_obj(&whole);
    }
}

static void normals_of_the_file_are_repaired(void **unused)
{
    (void)unused;
    daft_obj obj = parse(SQUARE "vn 0 0 -7\nvn 0 0 0\nvn nan 0 0\nvn 3e38 3e38 0\nf 1//1 2//2 3//3\nf 1//4 3 4//1\n");
    assert_true(normal_at(&obj.mesh, 0).z == -1);
    assert_true(normal_at(&obj.mesh, 1).z == 1 && normal_at(&obj.mesh, 2).z == 1 && normal_at(&obj.mesh, 4).z == 1);
    assert_true(fabsf(normal_at(&obj.mesh, 3).x - 0.70710678f) < 1e-6f);
    check_mesh(&obj);
    free_obj(&obj);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corner_forms),
        cmocka_unit_test(corners_without_uv_stay_without),
        cmocka_unit_test(index_lists_that_repeat_the_vertices_cost_nothing),
        cmocka_unit_test(lines_end_in_every_way),
        cmocka_unit_test(errors_say_where),
        cmocka_unit_test(bad_lines_are_left_out),
        cmocka_unit_test(lost_lines_keep_their_numbers),
        cmocka_unit_test(a_million_bad_lines_take_no_time),
        cmocka_unit_test(errors_about_the_only_faces),
        cmocka_unit_test(bad_faces_are_dropped_with_a_warning),
        cmocka_unit_test(warnings_are_few),
        cmocka_unit_test(files_without_faces_load_empty),
        cmocka_unit_test(materials_are_found),
        cmocka_unit_test(missing_materials_warn_once),
        cmocka_unit_test(an_error_in_the_material_file_is_an_error),
        cmocka_unit_test(smoothing_follows_the_file),
        cmocka_unit_test(normals_may_come_later),
        cmocka_unit_test(normals_of_the_file_are_repaired),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
