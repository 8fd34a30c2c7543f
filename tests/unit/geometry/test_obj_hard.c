/* OBJ files: polygons of every shape, the hard files of other loaders, damaged files, and an allocator that fails at
 * every call. */
#include "obj_fixture.h"

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
        cmocka_unit_test(polygons_keep_their_area),       cmocka_unit_test(large_polygons_keep_their_area),
        cmocka_unit_test(tangled_polygons_end),           cmocka_unit_test(real_models),
        cmocka_unit_test(files_that_break_other_loaders), cmocka_unit_test(each_hard_polygon_keeps_its_area),
        cmocka_unit_test(damaged_files_never_crash),      cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
