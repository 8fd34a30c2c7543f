/* OBJ files: every form of statement, the rules for what is wrong, the hard files of other loaders, damaged files, and
 * an allocator that fails at every call. */
#include "geometry/mesh.h"
#include "support_content.h"

static counting memory;
static memo warnings;

static bool parse_bytes(const char *text, size_t size, daft_obj *obj, daft_error *error)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_log log = memo_log(&warnings);
    return daft_obj_parse(&allocator, NULL, "a.obj", text, size, &log, obj, error);
}

static void free_obj(daft_obj *obj)
{
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    daft_obj_free(&allocator, obj);
    assert_int_equal(memory.live, 0);
}

static daft_obj parse(const char *text)
{
    daft_obj obj;
    daft_error error;
    char shown[1100];
    if (!parse_bytes(text, strlen(text), &obj, &error)) fail_msg("%s", daft_error_text(&error, shown, sizeof shown));
    return obj;
}

/* The text must fail to load with this message, and leave nothing behind. */
static void refuse(const char *text, const char *message)
{
    daft_obj obj;
    daft_error error;
    char shown[1100];
    if (parse_bytes(text, strlen(text), &obj, &error)) fail_msg("accepted: %s", text);
    assert_int_equal(memory.live, 0);
    assert_int_equal(error.code, DAFT_ERROR_SYNTAX);
    assert_contains(daft_error_text(&error, shown, sizeof shown), message);
}

static daft_dvec3 corner(const daft_trimesh *mesh, uint32_t triangle, uint32_t k)
{
    uint32_t v = mesh->indices[3 * triangle + k];
    return daft_dv3((double)mesh->x[v], (double)mesh->y[v], (double)mesh->z[v]);
}

static daft_dvec3 vector_area(const daft_trimesh *mesh, uint32_t triangle)
{
    daft_dvec3 a = corner(mesh, triangle, 0);
    daft_dvec3 ab = daft_dsub(corner(mesh, triangle, 1), a), ac = daft_dsub(corner(mesh, triangle, 2), a);
    return daft_dscale(daft_dcross(ab, ac), 0.5);
}

/* Plain area of triangles first .. first+count-1. */
static double area(const daft_trimesh *mesh, uint32_t first, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = first; i < first + count; i++) {
        daft_dvec3 v = vector_area(mesh, i);
        sum += sqrt(daft_ddot(v, v));
    }
    return sum;
}

/* What mesh.h promises of every mesh. */
static void check_mesh(const daft_obj *obj)
{
    const daft_trimesh *m = &obj->mesh;
    for (uint32_t i = 0; i < m->vertex_count; i++)
        assert_true(isfinite(m->x[i]) && isfinite(m->y[i]) && isfinite(m->z[i]));
    for (uint32_t i = m->vertex_count; i % 16; i++) assert_true(m->x[i] == 0 && m->y[i] == 0 && m->z[i] == 0);
    for (uint32_t i = 0; i < m->normal_count; i++) {
        float length = daft_length(m->normals[i]);
        assert_true(length > 0.9999f && length < 1.0001f);
    }
    for (uint32_t i = 0; i < m->uv_count; i++) assert_true(isfinite(m->uvs[i].x) && isfinite(m->uvs[i].y));
    assert_true(m->uvs || !m->uv_indices);
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        assert_true(m->indices[i] < m->vertex_count);
        assert_true(m->indices[i] != m->indices[i % 3 == 2 ? i - 2 : i + 1]);
        uint32_t normal = m->normal_indices ? m->normal_indices[i] : m->indices[i];
        assert_true(normal < m->normal_count);
        uint32_t uv = m->uv_indices ? m->uv_indices[i] : m->indices[i];
        assert_true(!m->uvs || uv == DAFT_NO_UV || uv < m->uv_count);
    }
    for (uint32_t i = 0; m->slots && i < m->triangle_count; i++) assert_true(m->slots[i] < obj->slots.count);
    assert_true(obj->slots.count > 0);
    assert_true(m->triangle_count == 0 ? m->low.x > m->high.x : m->low.x <= m->high.x);
    assert_true(daft_trimesh_bytes(m) >= 12 * (size_t)m->triangle_count);
}

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

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

/* ---- polygons ---- */

/* Writes a polygon of `count` points in a tilted plane far from the origin. */
static daft_obj parse_polygon(const double (*points)[2], int count)
{
    size_t size = 0, room = 100 * (size_t)count + 16;
    char *text = malloc(room);
    assert_non_null(text);
    for (int i = 0; i < count; i++) {
        double u = points[i][0], v = points[i][1];
        size += (size_t)snprintf(text + size, room - size, "v %.9g %.9g %.9g\n", 64 + u, v - 32, 16 + u / 2 + v / 4);
    }
    size += (size_t)snprintf(text + size, room - size, "f");
    for (int i = 0; i < count; i++) size += (size_t)snprintf(text + size, room - size, " %d", i + 1);
    daft_obj obj;
    daft_error error;
    assert_true(parse_bytes(text, size, &obj, &error));
    free(text);
    check_mesh(&obj);
    return obj;
}

/* Every triangle must face as the polygon does, and their areas must add up to the polygon's. */
static void check_polygon(const double (*points)[2], int count)
{
    daft_obj obj = parse_polygon(points, count);
    double twice = 0, tilt = sqrt(1 + 0.25 + 0.0625);
    for (int i = 0, j = count - 1; i < count; j = i++)
        twice += points[j][0] * points[i][1] - points[j][1] * points[i][0];
    double expected = fabs(twice) / 2 * tilt;
    assert_int_equal(warnings.count, 0);
    double sum = area(&obj.mesh, 0, obj.mesh.triangle_count);
    if (fabs(sum - expected) > 1e-4 * expected) fail_msg("%d corners: area %g, not %g", count, sum, expected);
    assert_true(obj.mesh.triangle_count <= (uint32_t)count - 2);
    free_obj(&obj);
}

static void polygons_keep_their_area(void **unused)
{
    (void)unused;
    static const double arrow[4][2] = {{0, 0}, {4, 1}, {0, 2}, {1, 1}}, arrow2[4][2] = {{1, 1}, {0, 0}, {4, 1}, {0, 2}};
    static const double l[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    static const double backwards[6][2] = {{0, 3}, {1, 3}, {1, 1}, {2, 1}, {2, 0}, {0, 0}};
    static const double collinear[7][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}};
    static const double comb[12][2] = {{0, 0}, {6, 0}, {6, 3}, {5, 3}, {5, 1}, {4, 1},
                                       {4, 3}, {3, 3}, {3, 1}, {2, 1}, {2, 3}, {0, 3}};
    static const double holed[10][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}};
    check_polygon(arrow, 4);
    check_polygon(arrow2, 4);
    check_polygon(l, 6);
    check_polygon(backwards, 6);
    check_polygon(collinear, 7);
    check_polygon(comb, 12);
    check_polygon(holed, 10);
}

/* Stars with a random radius at every corner, and spirals: nearly every other corner is reflex. */
static void large_polygons_keep_their_area(void **unused)
{
    (void)unused;
    static double points[12000][2];
    print_message("seed %llu\n", (unsigned long long)random_state);
    static const int counts[] = {5, 6, 7, 8, 12, 50, 333, 3000, 12000};
    for (size_t k = 0; k < DAFT_COUNT_OF(counts); k++) {
        int count = counts[k];
        for (int repeat = 0; repeat < (count < 100 ? 200 : 1); repeat++) {
            for (int i = 0; i < count; i++) {
                double angle = 2 * DAFT_PI * i / count, radius = 5 + random_below(1000) / 100.0;
                points[i][0] = cos(angle) * radius, points[i][1] = sin(angle) * radius;
            }
            check_polygon((const double(*)[2])points, count);
        }
    }
    for (int i = 0; i < 1000; i++) { /* a spiral strip: out along one side, back along the other */
        double angle = 0.05 * (i < 500 ? i : 999 - i), radius = 4 + angle + (i < 500 ? 0 : 1);
        points[i][0] = cos(angle) * radius, points[i][1] = sin(angle) * radius;
    }
    check_polygon((const double(*)[2])points, 1000);
    for (int i = 0; i < 12000; i++)
        points[i][0] = cos(2 * DAFT_PI * i / 12000) * 9, points[i][1] = sin(2 * DAFT_PI * i / 12000) * 9;
    check_polygon((const double(*)[2])points, 12000);
}

/* Outlines that cross themselves have no right answer; they must end soon, with the signed area kept. */
static void tangled_polygons_end(void **unused)
{
    (void)unused;
    static double points[3000][2];
    for (int i = 0; i < 3000; i++) points[i][0] = random_below(1000) / 64.0, points[i][1] = random_below(1000) / 64.0;
    daft_obj obj = parse_polygon((const double(*)[2])points, 3000);
    double twice = 0;
    for (int i = 0, j = 2999; i < 3000; j = i++) twice += points[j][0] * points[i][1] - points[j][1] * points[i][0];
    daft_dvec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < obj.mesh.triangle_count; i++) sum = daft_dadd(sum, vector_area(&obj.mesh, i));
    assert_true(fabs(sum.z - twice / 2) < 1e-3 * 256 * 3000);
    free_obj(&obj);
}

/* ---- materials ---- */

static daft_obj load(const char *path)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_log log = memo_log(&warnings);
    daft_obj obj;
    daft_error error;
    char shown[1100];
    if (!daft_obj_load(&allocator, NULL, path, &log, &obj, &error))
        fail_msg("%s", daft_error_text(&error, shown, sizeof shown));
    check_mesh(&obj);
    return obj;
}

static daft_obj load_text(const char *name, const char *text) { return load(write_test_text(name, text)); }

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

/* ---- files of others ---- */

static void real_models(void **unused)
{
    (void)unused;
    static const struct {
        const char *name;
        uint32_t vertices, triangles, slots;
        bool uvs;
    } models[] = {
        {"models/cow.obj", 2903, 5804, 1, false},         {"models/teapot.obj", 3644, 6320, 1, false},
        {"models/suzanne.obj", 507, 968, 1, false},       {"models/fandisk.obj", 6475, 12946, 1, false},
        {"models/hand/hand.OBJ", 4406, 8808, 1, true},    {"models/stanford-bunny.obj", 35947, 69451, 1, false},
        {"models/spider/spider.obj", 762, 1368, 4, true}, {"models/legocar/legocar.obj", 5968, 10992, 8, true},
        {"models/plane/plane.obj", 3446, 2564, 1, true},  {"models/spot/spot_quadrangulated.obj", 2930, 5856, 1, true},
        {"models/nefertiti.obj", 49971, 99938, 1, false}};
    for (size_t i = 0; i < DAFT_COUNT_OF(models); i++) {
        const char *path = shared_file(models[i].name);
        if (!path) continue;
        daft_obj obj = load(path);
        assert_int_equal(warnings.count, 0);
        assert_int_equal(obj.mesh.vertex_count, models[i].vertices);
        assert_int_equal(obj.mesh.triangle_count, models[i].triangles);
        assert_int_equal(obj.slots.count, models[i].slots);
        assert_int_equal(obj.mesh.uvs != NULL, models[i].uvs);
        if (strstr(path, "hand.OBJ")) assert_contains(obj.slots.items[0].diffuse_map, "/hand/hand_mapNew.jpg");
        if (strstr(path, "spider")) assert_contains(obj.slots.items[0].diffuse_map, "/spider/./");
        free_obj(&obj);
    }
}

static const struct {
    const char *name;
    int triangles;       /* -1: an error */
    double area;         /* 0: not checked */
    const char *message; /* part of a warning or of the error */
} hard_files[] = {
    {"models/invalid-relative-vertex-index.obj", -1, 0, ":1:3: no face of the file can be used"},
    {"models/invalid-relative-texture-index.obj", -1, 0, "it names a vertex that does not exist"},
    {"models/invalid-face-definition.obj", -1, 0, "fewer than 3 corners"},
    {"models/issue-140-zero-face-idx.obj", 1, 0.5, ":16:3: the face is left out"},
    {"models/issue-161-inconsistent-f.obj", 12, 6, NULL},
    {"models/issue-235-usemtl-then-o.obj", 2, 4, NULL},
    {"models/issue-244-mtl-searchpaths.obj", 2, 4, "no such material file"},
    {"models/issue-246-usemtl-whitespace.obj", 1, 2, NULL},
    {"models/issue-248-texres-texopt.obj", 12, 24, NULL},
    {"models/issue-295-trianguation-failure.obj", 28, 14, NULL},
    {"models/issue-319-002.obj", 14, 3.0679 + 14.9700 + 1.5458, NULL},
    {"models/issue-330.obj", 3, 0, NULL},
    {"models/issue-356-leading-spaces-newmtl.obj", 0, 0, "no faces"},
    {"models/issue-95-2.obj", 1, 0, NULL},
    {"models/leading-decimal-dot-issue-201.obj", 1, 0, NULL},
    {"models/mtl filename with whitespace issue46.obj", 12, 24,
     "no such material file: 'invalid-file-without-spaces.mtl'"},
    {"models/mtllib-multiple-files-issue-112.obj", 1, 0, "'invalid-file-aaa.mtl', 'invalid-file-bbb.mtl'"},
    {"models/texture-filename-with-whitespace.obj", 12, 24, NULL},
    {"models/texture-options-issue-85.obj", 1, 0, NULL},
    {"models/colorspace-issue-184.obj", 1, 0, NULL},
    {"models/norm-texopt.obj", 1, 0, NULL},
    {"models/pbr-mat-ext.obj", 2, 0, NULL},
    {"models/cube-vertex-w-component.obj", 12, 24, NULL},
    {"models/cube-vertexcol.obj", 12, 24, NULL},
    {"models/skin-weight.obj", 12, 24, NULL},
    {"models/line-prim.obj", 0, 0, "no faces"},
    {"models/points-prim.obj", 0, 0, "no faces"},
    {"models/test-nan.obj", 34, 0, "not finite"},
    {"fuzzer/regressions/clusterfuzz-testcase-minimized-fuzz_ParseFromString-4877060179886080", 0, 0, "no faces"},
    {"fuzzer/afl/id_000040_sig_11_src_000271_op_havoc_rep_64", -1, 0, "no face of the file can be used"},
    {"fuzzer/afl/id_000053_sig_11_src_000352_op_havoc_rep_16", -1, 0, "no face of the file can be used"},
    {"fuzzer/afl/id_000058_sig_11_src_000382_op_havoc_rep_32", -1, 0, "no face of the file can be used"},
    {"fuzzer/afl/id_000067_sig_11_src_000518_op_havoc_rep_8", -1, 0, "no face of the file can be used"},
};

static void files_that_break_other_loaders(void **unused)
{
    (void)unused;
    for (size_t i = 0; i < DAFT_COUNT_OF(hard_files); i++) {
        char name[256], shown[1100];
        snprintf(name, sizeof name, "obj_hard/%s", hard_files[i].name);
        const char *path = data_file(name);
        daft_allocator allocator = counting_allocator(&memory);
        daft_log log = memo_log(&warnings);
        daft_obj obj;
        daft_error error;
        bool loaded = daft_obj_load(&allocator, NULL, path, &log, &obj, &error);
        if (!loaded) daft_error_text(&error, shown, sizeof shown);
        if (loaded != (hard_files[i].triangles >= 0)) fail_msg("%s: %s", name, loaded ? "loaded" : shown);
        if (!loaded) {
            assert_contains(shown, hard_files[i].message);
            assert_int_equal(memory.live, 0);
            continue;
        }
        check_mesh(&obj);
        if (hard_files[i].message && !memo_has(&warnings, hard_files[i].message)) fail_msg("%s: no warning", name);
        if ((int)obj.mesh.triangle_count != hard_files[i].triangles)
            fail_msg("%s: %u triangles", name, obj.mesh.triangle_count);
        double sum = area(&obj.mesh, 0, obj.mesh.triangle_count), expected = hard_files[i].area;
        if (expected > 0 && fabs(sum - expected) > 2e-4) fail_msg("%s: area %.5f, not %.5f", name, sum, expected);
        free_obj(&obj);
    }
}

static void each_hard_polygon_keeps_its_area(void **unused)
{
    (void)unused;
    daft_obj obj = load(data_file("obj_hard/models/issue-319-002.obj"));
    assert_true(fabs(area(&obj.mesh, 0, 5) - 3.0679) < 1e-4 && fabs(area(&obj.mesh, 5, 6) - 14.97) < 1e-4);
    assert_true(fabs(area(&obj.mesh, 11, 3) - 1.5458) < 1e-4);
    free_obj(&obj);
    obj = load(data_file("obj_hard/models/issue-295-trianguation-failure.obj"));
    for (uint32_t i = 0; i < 14; i++) assert_true(area(&obj.mesh, 2 * i, 2) == 1);
    free_obj(&obj);
}

/* ---- damage ---- */

static const char specimen[] =
    "# specimen\r\nmtllib x.mtl\no thing\n" SQUARE
    "v .5 .5 1e0 1\nv nan 0 0\nvt 0 0\nvt 1 0 0\nvt 1.0 1.0\nvn 0 0 1\nvn 0 1 0\n"
    "g a\nusemtl one\ns 1\nf 1/1/1 2/2/1 3/3/1 4/1/1\nf 1//2 2//2 5//2\ns off\nusemtl two\nf -5 -4 -3 -2\nf 2 3 \\\n "
    "5\n"
    "f 3/1 4/2 5/3\nl 1 2\nf 1 2 3 4 5\nv 2 2 2\nv -3.25e-2 123456789.123456789 7\nf 6 7 8\nf 7 2 8 1 3\n";

static void damaged_files_never_crash(void **unused)
{
    (void)unused;
    print_message("seed %llu\n", (unsigned long long)random_state);
    int loaded = 0;
    for (int run = 0; run < 20000; run++) {
        char text[sizeof specimen + 64];
        size_t size = sizeof specimen - 1;
        memcpy(text, specimen, size);
        for (uint32_t edit = random_below(6) + 1; edit > 0 && size > 2; edit--) {
            size_t at = random_below((uint32_t)size);
            static const char alphabet[] = "0123456789-+./\\ \n\rvftne#\0\xff";
            uint32_t kind = random_below(4);
            if (kind == 0) text[at] = (char)random_below(256);
            if (kind == 1) text[at] = alphabet[random_below(sizeof alphabet - 1)];
            if (kind == 2) memmove(text + at, text + at + 1, --size - at);
            if (kind == 3 && size < sizeof specimen + 60) {
                memmove(text + at + 1, text + at, size++ - at);
                text[at] = alphabet[random_below(sizeof alphabet - 1)];
            }
        }
        if (random_below(8) == 0) size = random_below((uint32_t)size);
        char *exact = malloc(size + 1); /* so that the address sanitizer sees a read behind the end */
        assert_non_null(exact);
        memcpy(exact, text, size);
        exact[size] = 0;
        daft_obj obj;
        daft_error error;
        if (parse_bytes(exact, size, &obj, &error)) {
            check_mesh(&obj);
            free_obj(&obj);
            loaded++;
        }
        assert_int_equal(memory.live, 0);
        free(exact);
    }
    print_message("%d of 20000 still load\n", loaded);
}

static void memory_may_run_out_anywhere(void **unused)
{
    (void)unused;
    write_test_text("x.mtl", "newmtl one\nKd 1 0 0\nmap_Kd x.png\nnewmtl two\n");
    const char *path = write_test_file("x.obj", specimen, sizeof specimen - 1);
    for (long fail_at = 0;; fail_at++) {
        daft_allocator allocator = counting_allocator(&memory);
        memory.fail_at = fail_at;
        daft_obj obj;
        daft_error error;
        bool loaded = daft_obj_load(&allocator, NULL, path, NULL, &obj, &error);
        if (!loaded) assert_int_equal(error.code, DAFT_ERROR_MEMORY);
        if (loaded) daft_obj_free(&allocator, &obj);
        assert_int_equal(memory.live, 0);
        if (memory.calls <= fail_at) {
            assert_true(loaded);
            print_message("%ld allocations\n", fail_at);
            return;
        }
    }
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
        cmocka_unit_test(polygons_keep_their_area),
        cmocka_unit_test(large_polygons_keep_their_area),
        cmocka_unit_test(tangled_polygons_end),
        cmocka_unit_test(materials_are_found),
        cmocka_unit_test(missing_materials_warn_once),
        cmocka_unit_test(an_error_in_the_material_file_is_an_error),
        cmocka_unit_test(smoothing_follows_the_file),
        cmocka_unit_test(normals_may_come_later),
        cmocka_unit_test(normals_of_the_file_are_repaired),
        cmocka_unit_test(real_models),
        cmocka_unit_test(files_that_break_other_loaders),
        cmocka_unit_test(each_hard_polygon_keeps_its_area),
        cmocka_unit_test(damaged_files_never_crash),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
