/* MTL files: every statement, the options of maps, the rules for what is wrong, damaged files. */
#include "geometry/mesh.h"
#include "support_content.h"

static counting memory;
static memo warnings;
static daft_mtl_list list;

static bool read_bytes(const char *bytes, size_t size, daft_error *error)
{
    const char *path = write_test_file("a.mtl", bytes, size);
    daft_allocator allocator = counting_allocator(&memory);
    daft_log log = memo_log(&warnings);
    list = (daft_mtl_list){0};
    return daft_mtl_load(&allocator, NULL, path, &log, &list, error);
}

static void done(void)
{
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    daft_mtl_list_free(&allocator, &list);
    assert_int_equal(memory.live, 0);
}

static const daft_mtl *read_text(const char *text)
{
    daft_error error;
    char shown[1100];
    if (!read_bytes(text, strlen(text), &error)) fail_msg("%s", daft_error_text(&error, shown, sizeof shown));
    return list.items;
}

static void refuse(const char *text, const char *message)
{
    daft_error error;
    char shown[1100];
    if (read_bytes(text, strlen(text), &error)) fail_msg("accepted: %s", text);
    assert_int_equal(list.count, 0);
    done();
    assert_contains(daft_error_text(&error, shown, sizeof shown), message);
}

static bool is_color(daft_vec3 c, float r, float g, float b) { return c.x == r && c.y == g && c.z == b; }

static void all_properties(void **unused)
{
    (void)unused;
    const daft_mtl *m =
        read_text("# exported\r\n newmtl  two words \r\n\tKa .1 .2 .3\r\nKd 1 0 .5 # red\r\nKs .25\r\nKe 9 8 7\r\n"
                  "Ns 96.5\r\nNi 1.45\r\nd 0.25\r\nillum 5\r\nmap_Kd  textures\\wood one.png \r\n"
                  "newmtl b\r\nkd 1 1 1\r\nTr 0.25\r\nTf 1 .5 1\r\nmap_Ks x.png\r\nPr 0.5\r\nbump -bm 2 b.png");
    assert_int_equal(list.count, 2);
    assert_int_equal(warnings.count, 0);
    assert_string_equal(m[0].name, "two words");
    assert_true(is_color(m[0].ambient, .1f, .2f, .3f) && is_color(m[0].diffuse, 1, 0, .5f));
    assert_true(is_color(m[0].specular, .25f, .25f, .25f) && is_color(m[0].emission, 9, 8, 7));
    assert_true(m[0].shininess == 96.5f && m[0].index == 1.45f && m[0].opacity == .25f && m[0].illum == 5);
    assert_string_equal(m[0].diffuse_map, test_path("textures/wood one.png"));
    assert_int_equal(m[0].diffuse_map_line, 11);
    assert_int_equal(m[0].diffuse_map_column, 9);
    assert_true(m[1].opacity == .75f && is_color(m[1].ambient, 1, 1, 1));
    assert_true(m[1].has_filter && is_color(m[1].filter, 1, .5f, 1) && !m[0].has_filter &&
                is_color(m[0].filter, 1, 1, 1));
    assert_string_equal(m[1].diffuse_map, "");
    done();
}

static void defaults(void **unused)
{
    (void)unused;
    daft_mtl m = daft_mtl_default();
    assert_true(is_color(m.diffuse, .8f, .8f, .8f) && m.illum == 2 && m.opacity == 1 && !m.diffuse_map[0]);
    const daft_mtl *read = read_text("newmtl a");
    assert_true(is_color(read->diffuse, .8f, .8f, .8f) && is_color(read->specular, 0, 0, 0) && read->opacity == 1);
    done();
}

static void map_options(void **unused)
{
    (void)unused;
    static const struct {
        const char *line, *name;
    } maps[] = {{"-texres 512 input.jpg", "input.jpg"},
                {"-o 0.1 diffuse.jpg", "diffuse.jpg"},
                {"-s 1 2 diffuse.jpg", "diffuse.jpg"},
                {"-t 0.1 0.2 0.3 x.png", "x.png"},
                {"-t 0.1 0.2 0.3 4", "4"},
                {"-o 1 2nd.png", "2nd.png"},
                {"-mm 0.1 0.3 x.png", "x.png"},
                {"-blendu on -blendv off -clamp on -cc off x y.png", "x y.png"},
                {"-type cube_left -imfchan r -colorspace sRGB -boost 2 -bm -1.5 x.png", "x.png"},
                {"x.png -bm 1.5", "x.png"},
                {"x one.png   -o 1 2 -clamp on", "x one.png"},
                {"x -bm y.png", "x -bm y.png"},
                {"a-b -c.png", "a-b -c.png"},
                {"\"quoted name.png\"", "quoted name.png"},
                {".\\sub\\x.png", "./sub/x.png"}};
    for (size_t i = 0; i < DAFT_COUNT_OF(maps); i++) {
        char text[256];
        snprintf(text, sizeof text, "newmtl a\nmap_Kd %s\nKd 1 1 1\n", maps[i].line);
        const daft_mtl *m = read_text(text);
        assert_string_equal(m->diffuse_map, test_path(maps[i].name));
        assert_int_equal(warnings.count, 0);
        done();
    }
    const daft_mtl *m = read_text("newmtl a\nmap_Kd /abs/x.png\nnewmtl b\nmap_Kd -what 1 2 y.png\n");
    assert_string_equal(m[0].diffuse_map, "/abs/x.png");
    assert_string_equal(m[1].diffuse_map, test_path("y.png"));
    assert_true(memo_has(&warnings, "a.mtl:4:8: unknown map option '-what' is skipped"));
    done();
}

static void paths_of_other_machines(void **unused)
{
    (void)unused;
    write_test_text("there.png", "x");
    const daft_mtl *m =
        read_text("newmtl a\nmap_Kd C:\\artist\\there.png\nnewmtl b\nmap_Kd C:\\artist\\not there.png\n");
    assert_string_equal(m[0].diffuse_map, test_path("there.png"));
    assert_string_equal(m[1].diffuse_map, test_path("C:/artist/not there.png"));
    done();
}

static void d_wins_over_tr(void **unused)
{
    (void)unused;
    const daft_mtl *m =
        read_text("newmtl a\nd 0.75\nTr 0.5\nnewmtl b\nTr 0.5\nd 0.75\nnewmtl c\nd 1\nTr 0\nnewmtl e\nd -halo .5");
    assert_true(m[0].opacity == .75f && m[1].opacity == .75f && m[2].opacity == 1 && m[3].opacity == .5f);
    assert_int_equal(warnings.count, 2);
    assert_contains(warnings.text[0], "a.mtl:3:1: d and Tr contradict each other: d is used");
    assert_contains(warnings.text[1], "a.mtl:6:1: ");
    done();
}

static void out_of_range_is_cut(void **unused)
{
    (void)unused;
    const daft_mtl *m =
        read_text("newmtl a\nd 2\nNs 5000\nKd -1 0 0\nillum 77\nKs 1 1 1 1\nfoo\nfoo\nKa xyz 1 1 1\nNi 0");
    assert_true(m->opacity == 1 && m->shininess == 1000 && is_color(m->diffuse, 0, 0, 0) && m->illum == 10);
    assert_true(m->index > 0);
    assert_true(memo_has(&warnings, "a.mtl:2:1: 2 is out of range, and is taken as 1"));
    assert_true(memo_has(&warnings, "a.mtl:6:10: '1' is more than is needed here"));
    assert_true(memo_has(&warnings, "a.mtl:7:1: unknown statement 'foo'"));
    assert_true(memo_has(&warnings, "a.mtl:9:4: colours given as 'xyz' are skipped"));
    assert_int_equal(warnings.count, 8);
    done();
}

/* The material keeps what the other lines say. */
static void bad_lines_are_left_out(void **unused)
{
    (void)unused;
    static const char *const cases[][2] = {
        {"Kd 1 0", "a.mtl:2:7: 'Kd' needs more numbers"},
        {"Kd", "a.mtl:2:3: 'Kd' needs more numbers"},
        {"Kd 1 zero 0", "a.mtl:2:6: 'zero' is not a number: the line is left out"},
        {"Ns 1,5", "a.mtl:2:4: '1,5' is not a number"},
        {"Ke nan 0 0", "a.mtl:2:4: a finite number is needed"},
        {"d 1e99", "a.mtl:2:3: a finite number is needed"},
        {"Tf x", "a.mtl:2:4: 'x' is not a number"},
        {"illum", "'illum' needs more numbers"},
        {"map_Kd ", "a.mtl:2:1: the map has no file name"},
        {"map_Kd -bm x.png", "a.mtl:2:12: the map option before this lacks its value"},
        {"map_Kd -clamp", "lacks its value"},
        {"newmtl ", "a.mtl:2:1: this material has no name"}};
    for (size_t i = 0; i < DAFT_COUNT_OF(cases); i++) {
        char text[200];
        snprintf(text, sizeof text, "newmtl a\n%s\nKs 0.5 0.5 0.5\n", cases[i][0]);
        read_text(text);
        assert_true(list.items[list.count - 1].specular.x == 0.5f);
        if (!memo_has(&warnings, cases[i][1])) fail_msg("%s: %s", cases[i][0], warnings.text[0]);
        done();
    }
    read_text("\xEF\xBB\xBF# c\rKd 1 0 0\rnewmtl a\r");
    assert_true(memo_has(&warnings, "a.mtl:2:1: 'Kd' before the first newmtl"));
    done();
}

/* Every map and option that is drawn. */
static void maps_are_read(void **unused)
{
    (void)unused;
    const daft_mtl *m = read_text("newmtl a\nmap_Ka ka.png\nmap_Kd -s 2 3 -o .5 .25 -clamp on kd.png\nmap_Ks ks.png\n"
                                  "map_Ke ke.png\nmap_Ns -imfchan r ns.png\nmap_d d.png\nmap_Bump -bm 2.5 b.png\n"
                                  "norm n.png\nmap_Pr -mm .25 .5 pr.png\nmap_Pm -texres 256 pm.png\nPr .5\nPm .75\n"
                                  "refl -type sphere -s 9 9 -mm 0 .5 r.png\nrefl -type cube_top up.png\n"
                                  "refl -type cube_left l.png\nrefl -type cube_right ri.png\n"
                                  "refl -type cube_bottom bo.png\nrefl -type cube_back ba.png\n"
                                  "refl -type cube_front f.png\n"
                                  "map_ao -mm .4 .6 ao.png\n"
                                  "newmtl b\nKd 1 1 1\n");
    static const char *const names[DAFT_MTL_MAPS] = {
        [DAFT_MTL_AMBIENT] = "ka.png",   [DAFT_MTL_SPECULAR] = "ks.png",  [DAFT_MTL_EMISSION] = "ke.png",
        [DAFT_MTL_SHININESS] = "ns.png", [DAFT_MTL_ALPHA] = "d.png",      [DAFT_MTL_BUMP] = "b.png",
        [DAFT_MTL_NORMAL] = "n.png",     [DAFT_MTL_ROUGHNESS] = "pr.png", [DAFT_MTL_METALLIC] = "pm.png",
        [DAFT_MTL_REFLECTION] = "r.png", [DAFT_MTL_CUBE] = "ri.png",      [DAFT_MTL_CUBE + 1] = "l.png",
        [DAFT_MTL_CUBE + 2] = "up.png",  [DAFT_MTL_CUBE + 3] = "bo.png",  [DAFT_MTL_CUBE + 4] = "f.png",
        [DAFT_MTL_CUBE_END] = "ba.png",  [DAFT_MTL_OCCLUSION] = "ao.png"};
    assert_int_equal(warnings.count, 0);
    assert_non_null(m->maps);
    for (int i = 0; i < DAFT_MTL_MAPS; i++) assert_string_equal(m->maps->map[i].path, test_path(names[i]));
    assert_string_equal(m->diffuse_map, test_path("kd.png"));
    assert_true(m->scale.x == 2 && m->scale.y == 3 && m->offset.x == .5f && m->offset.y == .25f);
    assert_true(m->wrap == DAFT_WRAP_CLAMP && m->bump == 2.5f && m->physical && m->metallic == .75f);
    assert_int_equal(m->maps->map[DAFT_MTL_SHININESS].change.channel, 'r');
    assert_true(m->maps->map[DAFT_MTL_ROUGHNESS].change.base == .25f);
    assert_true(m->maps->map[DAFT_MTL_ROUGHNESS].change.gain == .5f);
    assert_int_equal(m->maps->map[DAFT_MTL_METALLIC].change.most, 256);
    assert_true(m->maps->map[DAFT_MTL_OCCLUSION].change.base == .4f && m->occlusion == 1);
    assert_true(m->alpha_mode == DAFT_ALPHA_MASK && is_color(m->specular, 1, 1, 1));
    assert_true(m[1].maps == NULL && m[1].scale.x == 1 && !m[1].physical && m[1].alpha_mode == DAFT_ALPHA_OPAQUE);
    done();
    m = read_text("newmtl a\nmap_Kd a.png\nbump -s 2 2 b.png\n");
    assert_true(m->scale.x == 1 && memo_has(&warnings, "a.mtl:3:1: all maps of a material lie as its map_Kd"));
    done();
}

/* A cube lacks nothing, or is none. */
static void cubes_are_whole(void **unused)
{
    (void)unused;
    const daft_mtl *m = read_text("newmtl a\nKd 1 1 1\n  refl -type cube_top t.png\nrefl -type cube_left l.png\n"
                                  "refl -type cube_front f.png\nnewmtl b\nrefl -type cube_side s.png\n");
    assert_int_equal(warnings.count, 2);
    assert_true(memo_has(&warnings, "a.mtl:5:1: the cube that is mirrored lacks cube_right, cube_bottom, cube_back: "));
    assert_true(memo_has(&warnings, "a.mtl:7:1: a side of a cube is cube_right, cube_left, cube_top, cube_bottom, "));
    for (int i = 0; i < 6; i++) assert_int_equal(m->maps->map[DAFT_MTL_CUBE + i].path[0], 0);
    done();
}

static void errors_say_where(void **unused)
{
    (void)unused;
    refuse("", "a.mtl: the file is empty");
    refuse(" \r\n\t\n", "a.mtl: the file is empty");
    refuse("\x89PNG\r\n", "a.mtl:1:1: not an MTL file");
    refuse("\xFE\xFFn", "a.mtl:1:1: this text is UTF-16: save it as UTF-8");
    daft_error error;
    daft_allocator allocator = counting_allocator(&memory);
    assert_false(daft_mtl_load(&allocator, NULL, test_path("none.mtl"), NULL, &list, &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_contains(error.file, "none.mtl");
    assert_false(daft_mtl_load(&allocator, NULL, test_folder, NULL, &list, &error));
    assert_contains(error.message, "directory");
    done();
}

static void comments_alone_are_no_material(void **unused)
{
    (void)unused;
    read_text("# Material Count: 0\n");
    assert_int_equal(list.count, 0);
    assert_int_equal(warnings.count, 1);
    done();
}

static void a_failure_keeps_the_list(void **unused)
{
    (void)unused;
    read_text("newmtl a\nnewmtl b\n");
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    const char *path = write_test_text("bad.mtl", "hello world\nthis is no material\n");
    assert_false(daft_mtl_load(&allocator, NULL, path, NULL, &list, NULL));
    assert_int_equal(list.count, 2);
    assert_string_equal(list.items[1].name, "b");
    path = write_test_text("good.mtl", "newmtl c\n");
    assert_true(daft_mtl_load(&allocator, NULL, path, NULL, &list, NULL));
    assert_int_equal(list.count, 3);
    assert_string_equal(list.items[2].name, "c");
    done();
}

static void hard_files(void **unused)
{
    (void)unused;
    static const struct {
        const char *name, *map;
        size_t count;
        int warnings;
    } files[] = {{"issue-248-texres-texopt.mtl", "/input.jpg", 5, 0},
                 {"norm-texopt.mtl", "", 1, 0},
                 {"texture-options-issue-85.mtl", "/diffuse.jpg", 3, 1},
                 {"colorspace-issue-184.mtl", "/diffuse.jpg", 1, 1},
                 {"issue-246-usemtl-whitespace.mtl", "", 1, 0},
                 {"issue-356-leading-spaces-newmtl.mtl", "", 1, 0},
                 {"issue-95-2.mtl", "", 1, 0},
                 {"tr-and-d-issue-43.mtl", "", 2, 2},
                 {"pbr-mat-ext.mtl", "", 1, 0},
                 {"texture-filename-with-whitespace.mtl", "/texture 01.png", 5, 0},
                 {"mtllib-multiple-files-issue-112.mtl", "/tmp.png", 1, 0}};
    for (size_t i = 0; i < DAFT_COUNT_OF(files); i++) {
        char name[256];
        snprintf(name, sizeof name, "obj_hard/models/%s", files[i].name);
        const char *path = data_file(name);
        daft_allocator allocator = counting_allocator(&memory);
        daft_log log = memo_log(&warnings);
        list = (daft_mtl_list){0};
        assert_true(daft_mtl_load(&allocator, NULL, path, &log, &list, NULL));
        assert_int_equal(list.count, files[i].count);
        assert_int_equal(warnings.count, files[i].warnings);
        const char *map = list.items[0].diffuse_map, *slash = strrchr(map, '/');
        assert_string_equal(slash ? slash : "", files[i].map);
        done();
    }
}

static void damaged_files_never_crash(void **unused)
{
    (void)unused;
    static const char specimen[] =
        "newmtl a\nKa 1 1 1\nKd .5 0.25 1e-1\nKs 0\nNs 10\nd -halo 1\nTr 0\nillum 2\nmap_Kd -s 1 1 1 -bm 2 "
        "x y.png -o 1\nbump b.png\nnewmtl b \\\n\nKe 0 0 0\nTf xyz 1 1 1\nmap_Kd \"q.png\"\n";
    print_message("seed %llu\n", (unsigned long long)random_state);
    for (int run = 0; run < 3000; run++) {
        char text[sizeof specimen];
        size_t size = sizeof specimen - 1;
        memcpy(text, specimen, size);
        for (uint32_t edit = random_below(5) + 1; edit > 0; edit--) {
            size_t at = random_below((uint32_t)size);
            if (random_below(2))
                text[at] = random_below(2) ? (char)random_below(256) : "0-.\\ \n#\""[random_below(8)];
            else
                memmove(text + at, text + at + 1, --size - at);
        }
        daft_error error;
        read_bytes(text, size, &error);
        for (size_t i = 0; i < list.count; i++) {
            const daft_mtl *m = &list.items[i];
            assert_true(daft_finite3(m->diffuse) && m->opacity >= 0 && m->opacity <= 1 && isfinite(m->shininess));
        }
        done();
    }
}

static void media(void **unused)
{
    (void)unused;
    const daft_mtl *m = read_text("newmtl wine\nTf 0.7 0.1 0.2\ntint_distance 0.02\nmedium_priority 3\nillum 7\n");
    assert_true(list.count == 1 && m->tint_distance == 0.02f && m->priority == 3);
    done();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_properties),
        cmocka_unit_test(defaults),
        cmocka_unit_test(map_options),
        cmocka_unit_test(maps_are_read),
        cmocka_unit_test(paths_of_other_machines),
        cmocka_unit_test(d_wins_over_tr),
        cmocka_unit_test(out_of_range_is_cut),
        cmocka_unit_test(cubes_are_whole),
        cmocka_unit_test(errors_say_where),
        cmocka_unit_test(bad_lines_are_left_out),
        cmocka_unit_test(comments_alone_are_no_material),
        cmocka_unit_test(a_failure_keeps_the_list),
        cmocka_unit_test(media),
        cmocka_unit_test(hard_files),
        cmocka_unit_test(damaged_files_never_crash),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
