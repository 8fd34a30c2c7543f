/* runtime: the command line: exit statuses, messages that help, and what `daft render` writes. */
#include "daft.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <sys/stat.h>
#include <unistd.h>

#if defined(DAFT_HAS_OPENEXR)
#include <openexr.h>
#endif

#include "json.h"
#include "runtime_program.h"

static char output[OUTPUT_SIZE];

static void wrong_usage_is_status_2_with_a_hint(void **unused)
{
    (void)unused;
    static const struct {
        const char *arguments, *says;
    } wrong[] = {{"", "usage: daft COMMAND"},
                 {"plya", "did you mean 'play'?"},
                 {"frobnicate", "there is no command 'frobnicate'"},
                 {"render", "SCENE|SNAPSHOT is missing"},
                 {"render a.scene", "-o IMG is missing"},
                 {"render a.scene b.scene -o c.png", "'b.scene' is one operand too many"},
                 {"render a.scene -o", "--output: IMG is missing"},
                 {"render a.scene -o c.gif", "ends in .png, .ppm or .exr"},
                 {"render a.scene -o c.png --szie 10x10", "did you mean '--size'?"},
                 {"render a.scene -o c.png --size 10", "WIDTHxHEIGHT expected"},
                 {"render a.scene -o c.png --size 0x10", "each from 1 to 16384"},
                 {"render a.scene -o c.png --size 10x10x10", "got '10x10x10'"},
                 {"render a.scene -o c.png --size 99999999999999999999x1", "WIDTHxHEIGHT expected"},
                 {"render a.scene -o c.png --size", "--size: WxH is missing"},
                 {"render a.scene -o c.png --size --explain", "--size: WxH is missing"},
                 {"render a.scene -o c.png --quality hihg", "did you mean 'high'?"},
                 {"render a.scene -o c.png --quality=", "one of draft, game, high, reference"},
                 {"render a.scene -o c.png --threads -1", "a whole number from 0 to 64 expected, got '-1'"},
                 {"render a.scene -o c.png --threads two", "got 'two'"},
                 {"render a.scene -o c.png --camera 1.5", "got '1.5'"},
                 {"render a.scene -o c.png --isa avx1024", "one of plain, sse2, avx2, avx512"},
                 {"render a.scene -o c.png --aov depth,nromal", "did you mean 'normal'?"},
                 {"render a.scene -o c.png --aov depth,", "albedo, motion, cost expected, got ''"},
                 {"render a.scene -o c.png --aov", "--aov: LIST is missing"},
                 {"render a.scene -o c.png --aov motion", "nothing moves in one picture; --at SECONDS"},
                 {"render a.scene -o c.png --at 1 --camera 0", "the camera is that of the path"},
                 {"render a.scene -o c.jpg", "ends in .png, .ppm or .exr expected"},
                 {"render a.scene -o c.png --explain=yes", "--explain takes no value"},
                 {"render README.md -o c.png", "neither a .scene nor a mesh"},
                 {"scan a.scene", "-o FILE is missing"},
                 {"scan a.scene -o a.xyz", "ends in .ply or .pcd"},
                 {"scan a.scene -o a.ply --pattern rays", "spinning or grid expected"},
                 {"scan a.scene -o a.ply --returns second", "one of first, last, both"},
                 {"scan a.scene -o a.ply --rows 0", "a whole number from 1 to 4096"},
                 {"play a b", "'b' is one operand too many"},
                 {"play --ticks 0", "a whole number from 1"},
                 {"play --ticks 12x", "got '12x'"},
                 {"play --headles", "did you mean '--headless'?"},
                 {"play --scale nan", "--scale: a number"},
                 {"play --shot-tick 5", "--shot FILE is missing"},
                 {"play -z", "there is no option '-z'"},
                 {"help fields daft_lamp", "nothing has the name 'daft_lamp'"},
                 {"check", "PATH... is missing"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        int status = run_daft(output, "%s", wrong[i].arguments);
        if (status != 2) fail_msg("daft %s: exit status %d\n%s", wrong[i].arguments, status, output);
        assert_says(output, wrong[i].says);
        if (wrong[i].arguments[0]) assert_says(output, "Try 'daft");
    }
}

static void bad_input_is_status_1_with_a_message(void **unused)
{
    (void)unused;
    static const struct {
        const char *arguments, *says;
    } bad[] = {
        {"render no/such.scene -o /tmp/daft-x.png", "no/such.scene"},
        {"render no/such.obj -o /tmp/daft-x.png", "no/such.obj"},
        {"render assets -o /tmp/daft-x.png", "assets"},
        {"render assets/scenes/hello.scene --size 8x8 -o /no/such/folder/x.png", "/no/such/folder/x.png"},
        {"render assets/scenes/hello.scene --size 8x8 -o /tmp/daft-x.png --camera 99", "counted from 0"},
        {"render assets/scenes/hello.scene --size 8x8 -o /tmp/daft-x.png --stats /no/such/x.json", "/no/such/x.json"},
        {"play no_such_game --headless", "there is no game 'no_such_game'; games/ has:"},
        {"play mrable --headless", "did you mean 'marble'?"},
        {"play assets --headless", "there is no main.lua"},
        {"play tests/games/bot --headless --replay no/such.rec", "no/such.rec"},
        {"play tests/games/bot --headless --replay CMakeLists.txt", "CMakeLists.txt:1:1: 'daft-recording 1' expected"},
        {"play tests/games/bot --headless --record /no/such/x.rec", "/no/such/x.rec"},
        {"play tests/games/bot --headless --ticks 1 --shot /no/such/x.png", "/no/such/x.png"},
        {"play tests/games/bot --headless --ticks 5 --shot /tmp/daft-x.png --shot-tick 9", "the game ended at tick 5"},
        {"check no/such.obj", "no/such.obj"},
        {"check tests/games/broken_load", "broken_load/main.lua:2: error: daft.entity: position"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        int status = run_daft(output, "%s", bad[i].arguments);
        if (status != 1) fail_msg("daft %s: exit status %d\n%s", bad[i].arguments, status, output);
        assert_says(output, bad[i].says);
    }
    unlink("/tmp/daft-x.png");
}

static void a_mesh_without_faces_is_refused(void **unused)
{
    (void)unused;
    char path[64];
    snprintf(path, sizeof path, "/tmp/daft-faceless-%d.obj", (int)getpid());
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("v 0 0 0\nv 1 0 0\n", file);
    assert_int_equal(fclose(file), 0);
    int status = run_daft(output, "render %s -o /tmp/daft-faceless.png --size 8x8", path);
    unlink(path);
    assert_status(status, 1, output);
    assert_says(output, ".obj: the mesh has no triangles to draw");
}

static void help_is_status_0(void **unused)
{
    (void)unused;
    static const char *const helps[] = {"help",
                                        "--help",
                                        "-h",
                                        "--version",
                                        "help lua",
                                        "help fields",
                                        "help fields daft_light_def",
                                        "play --help",
                                        "render -h",
                                        "check --help",
                                        "help play",
                                        "help render"};
    for (size_t i = 0; i < sizeof helps / sizeof helps[0]; i++) {
        int status = run_daft(output, "%s", helps[i]);
        assert_status(status, 0, output);
        assert_true(strlen(output) > 8);
    }
    run_daft(output, "--version");
    assert_string_equal(output, "daft 0.1.0\n");
    run_daft(output, "render --help");
    assert_says(output, "counted from 0");
    run_daft(output, "help lua");
    assert_says(output, "daft.raycast(from, direction");
    assert_says(output, "entity:push(x, y, z)");
}

static void help_lua_prints_one_function_or_all_of_a_type(void **unused)
{
    (void)unused;
    assert_status(run_daft(output, "help lua daft.raycast"), 0, output);
    assert_says(output, "daft.raycast(from, direction");
    assert_null(strstr(output, "daft.gravity"));
    assert_status(run_daft(output, "help lua push"), 0, output);
    assert_says(output, "entity:push(x, y, z)");
    assert_status(run_daft(output, "help lua joint"), 0, output);
    assert_says(output, "joint:force()");
    assert_says(output, "daft.joint{...}");
    assert_status(run_daft(output, "help lua racast"), 2, output);
    assert_says(output, "did you mean 'raycast'?");
}

static void annotations_have_the_types_of_arguments_and_results(void **unused)
{
    (void)unused;
    assert_status(run_daft(output, "help annotations"), 0, output);
    static const char *const lines[] = {
        "---@param from daft.place\n---@param direction daft.vector\n---@param max_distance? number\n"
        "---@param ignore? daft.entity\n---@param hit? daft.hit|table\n---@return daft.hit|nil\n"
        "function daft.raycast(from, direction, max_distance, ignore, hit) end",
        "---@param options daft.entity.options\n---@return daft.entity\nfunction daft.entity(options) end",
        "---@field body? \"none\"|\"static\"|\"kinematic\"|\"dynamic\"",
        "---@return daft.entity|nil\n---@return \"ground\"|\"slope\"|\"air\"|\"crushed\"\n",
        "---@overload fun(): number, number\ndaft.input.mouse = {}"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) assert_says(output, lines[i]);
}

static void stats_are_json_with_the_promised_names(void **unused)
{
    (void)unused;
    int status = run_daft(
        output,
        "render assets/scenes/hello.scene -o /tmp/daft-stats.png --size 64x36 --threads 2 --repeat 3 --stats -");
    assert_status(status, 0, output);
    const char *end = json_value(output);
    if (!end || *json_blanks(end)) fail_msg("not JSON:\n%s", output);
    static const char *const names[] = {"\"width\": 64", "\"height\": 36", "\"threads\": 2", "\"isa\": \"",
                                        "\"frame_ms\"",  "\"median\"",     "\"p95\"",        "\"rays\"",
                                        "\"camera\"",    "\"shadow\"",     "\"reflection\"", "\"refraction\"",
                                        "\"query\"",     "\"effects\"",    "\"ran\"",        "\"why\"",
                                        "\"tiles\"",     "\"bytes\"",      "\"ms\"",         "\"frames\": 3"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) assert_says(output, names[i]);
    unlink("/tmp/daft-stats.png");
}

static void explain_prints_the_plan_and_nothing_draws_a_bar_in_a_pipe(void **unused)
{
    (void)unused;
    int status = run_daft(output, "render assets/scenes/hello.scene -o /tmp/daft-plan.png --size 64x36 --explain");
    assert_status(status, 0, output);
    assert_says(output, "visibility");
    assert_says(output, "why");
    assert_null(strchr(output, '\r'));
    unlink("/tmp/daft-plan.png");
}

/* The same picture for any number of threads and any instruction set, and of the size that was asked for. */
static void pictures_do_not_depend_on_threads(void **unused)
{
    (void)unused;
    static const char *const ways[] = {"--threads 1", "--threads 2", "--threads 3 --isa " DAFT_NARROWEST_ISA};
    char first[4 * 97 * 55], path[64];
    snprintf(path, sizeof path, "/tmp/daft-threads-%d.png", (int)getpid());
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    for (size_t i = 0; i < 3; i++) {
        int status = run_daft(output, "render assets/scenes/hello.scene -o %s --size 97x55 %s", path, ways[i]);
        assert_status(status, 0, output);
        daft_error error;
        daft_image *image = daft_image_load(engine, path, &error);
        assert_non_null(image);
        assert_int_equal(daft_image_width(image), 97);
        assert_int_equal(daft_image_height(image), 55);
        if (i == 0) memcpy(first, daft_image_pixels(image), sizeof first);
        assert_memory_equal(first, daft_image_pixels(image), sizeof first);
        daft_image_destroy(image);
    }
    daft_engine_destroy(engine);
    unlink(path);
}

/* ---- AOVs ---- */

enum { AOV_WIDTH = 61, AOV_HEIGHT = 35, AOV_PIXELS = AOV_WIDTH * AOV_HEIGHT };

/* Reads a PFM of the size above; the rows are turned, so that the top one is first. */
static void read_pfm(const char *path, const char *magic, size_t channels, float *out)
{
    char head[64], wanted[64];
    FILE *file = fopen(path, "rb");
    if (!file) fail_msg("there is no %s", path);
    int length = snprintf(wanted, sizeof wanted, "%s\n%d %d\n-1.0\n", magic, AOV_WIDTH, AOV_HEIGHT);
    assert_int_equal(fread(head, 1, (size_t)length, file), length);
    assert_memory_equal(head, wanted, (size_t)length);
    for (size_t y = AOV_HEIGHT; y-- > 0;)
        assert_int_equal(fread(out + y * AOV_WIDTH * channels, sizeof(float), AOV_WIDTH * channels, file),
                         AOV_WIDTH * channels);
    assert_int_equal(fgetc(file), EOF);
    fclose(file);
}

static void assert_numbers(daft_engine *engine, const char *path, const uint32_t *numbers)
{
    daft_image *image = daft_image_load(engine, path, NULL);
    assert_non_null(image);
    assert_int_equal(daft_image_width(image), AOV_WIDTH);
    assert_int_equal(daft_image_height(image), AOV_HEIGHT);
    const uint8_t *p = daft_image_pixels(image);
    for (size_t i = 0; i < AOV_PIXELS; i++)
        assert_int_equal(p[4 * i] | (uint32_t)p[4 * i + 1] << 8 | (uint32_t)p[4 * i + 2] << 16, numbers[i]);
    daft_image_destroy(image);
}

/* The files hold what the library says of the same view, bit for bit. */
static void aov_files_hold_what_the_library_says(void **unused)
{
    (void)unused;
    static float depth[AOV_PIXELS], got[3 * AOV_PIXELS];
    static daft_vec3 normal[AOV_PIXELS];
    static daft_entity entity[AOV_PIXELS];
    static uint32_t triangle[AOV_PIXELS];
    char stem[64], path[96];
    snprintf(stem, sizeof stem, "/tmp/daft-aov-%d", (int)getpid());
    int status =
        run_daft(output, "render assets/scenes/temple.scene -o %s.png --size %dx%d --aov triangle,depth,normal,id",
                 stem, AOV_WIDTH, AOV_HEIGHT);
    assert_status(status, 0, output);

    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_scene *scene = daft_scene_create(engine, NULL);
    daft_image *image = daft_image_create(engine, AOV_WIDTH, AOV_HEIGHT, NULL);
    assert_true(daft_scene_load(scene, DAFT_ROOT "/assets/scenes/temple.scene", NULL));
    daft_view view = daft_default_view();
    view.aov = (daft_aov){.depth = depth, .normal = normal, .entity = entity, .triangle = triangle};
    assert_true(daft_scene_get_camera(scene, 0, &view.camera, NULL));
    assert_true(daft_render(scene, &view, image, NULL));

    snprintf(path, sizeof path, "%s.depth.pfm", stem);
    read_pfm(path, "Pf", 1, got);
    assert_memory_equal(got, depth, sizeof depth);
    unlink(path);
    snprintf(path, sizeof path, "%s.normal.pfm", stem);
    read_pfm(path, "PF", 3, got);
    assert_memory_equal(got, normal, sizeof normal);
    unlink(path);
    snprintf(path, sizeof path, "%s.id.png", stem);
    assert_numbers(engine, path, &entity[0].id);
    unlink(path);
    snprintf(path, sizeof path, "%s.triangle.png", stem);
    assert_numbers(engine, path, triangle);
    unlink(path);
    snprintf(path, sizeof path, "%s.png", stem);
    assert_int_equal(unlink(path), 0);
    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

#if defined(DAFT_HAS_OPENEXR)
/* One channel of a file, read through OpenEXR's C library. */
static void read_layer(const char *path, const char *name, uint32_t out[AOV_PIXELS])
{
    exr_context_t file;
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    int32_t rows;
    assert_int_equal(exr_start_read(&file, path, &how), EXR_ERR_SUCCESS);
    assert_int_equal(exr_get_scanlines_per_chunk(file, 0, &rows), EXR_ERR_SUCCESS);
    int found = 0;
    for (int y = 0; y < AOV_HEIGHT; y += rows) {
        exr_chunk_info_t chunk;
        exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
        assert_int_equal(exr_read_scanline_chunk_info(file, 0, y, &chunk), EXR_ERR_SUCCESS);
        assert_int_equal(exr_decoding_initialize(file, 0, &chunk, &decoder), EXR_ERR_SUCCESS);
        for (int i = 0; i < decoder.channel_count; i++) {
            exr_coding_channel_info_t *c = &decoder.channels[i];
            if (strcmp(c->channel_name, name) != 0) continue;
            c->decode_to_ptr = (uint8_t *)&out[y * AOV_WIDTH];
            c->user_pixel_stride = 4, c->user_line_stride = 4 * AOV_WIDTH, c->user_bytes_per_element = 4;
            found++;
        }
        assert_int_equal(exr_decoding_choose_default_routines(file, 0, &decoder), EXR_ERR_SUCCESS);
        assert_int_equal(exr_decoding_run(file, 0, &decoder), EXR_ERR_SUCCESS);
        exr_decoding_destroy(file, &decoder);
    }
    assert_true(found > 0);
    exr_finish(&file);
}

/* Layers hold what the files beside a PNG do, and R is the linear light of the picture. */
static void exr_layers_hold_what_the_files_do(void **unused)
{
    (void)unused;
    static float pfm[3 * AOV_PIXELS];
    static uint32_t layer[AOV_PIXELS];
    const struct {
        const char *name, *layer, *head;
        size_t floats, at;
    } all[] = {{"depth", "depth.Z", "Pf", 1, 0},
               {"normal", "normal.Y", "PF", 3, 1},
               {"color", "R", "PF", 3, 0},
               {"albedo", "albedo.B", "PF", 3, 2},
               {"motion", "motion.X", "PF", 3, 0}};
    char stem[64], path[96];
    snprintf(stem, sizeof stem, "/tmp/daft-exr-%d", (int)getpid());
    const char *formats[] = {"png", "exr"};
    for (int i = 0; i < 2; i++)
        assert_status(run_daft(output,
                               "render assets/scenes/town.scene -o %s.%s --size %dx%d --at 2 --aov "
                               "depth,normal,color,albedo,motion,id,cost",
                               stem, formats[i], AOV_WIDTH, AOV_HEIGHT),
                      0, output);
    snprintf(path, sizeof path, "%s.exr", stem);
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        char beside[96];
        snprintf(beside, sizeof beside, "%s.%s.pfm", stem, all[i].name);
        read_pfm(beside, all[i].head, all[i].floats, pfm);
        read_layer(path, all[i].layer, layer);
        for (size_t k = 0; k < AOV_PIXELS; k++) assert_memory_equal(&layer[k], &pfm[all[i].floats * k + all[i].at], 4);
        unlink(beside);
    }
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    const char *numbers[] = {"id", "cost"}, *layers[] = {"entity.id", "cost.rays"};
    for (int i = 0; i < 2; i++) {
        char beside[96];
        snprintf(beside, sizeof beside, "%s.%s.png", stem, numbers[i]);
        read_layer(path, layers[i], layer);
        assert_numbers(engine, beside, layer);
        unlink(beside);
    }
    daft_engine_destroy(engine);
    unlink(path);
    snprintf(path, sizeof path, "%s.png", stem);
    assert_int_equal(unlink(path), 0);
    assert_status(run_daft(output, "render assets/scenes/hello.scene -o /no/such/folder/a.exr --size 32x18"), 1,
                  output);
    assert_says(output, "/no/such/folder/a.exr: ");
}
#endif

static void aov_writes_what_is_asked_for_and_says_what_it_cannot(void **unused)
{
    (void)unused;
    char path[96];
    int status = run_daft(output, "render assets/scenes/hello.scene -o /tmp/daft-aov-one.ppm --size 32x18 --aov depth");
    assert_status(status, 0, output);
    snprintf(path, sizeof path, "/tmp/daft-aov-one.normal.pfm");
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(unlink("/tmp/daft-aov-one.depth.pfm"), 0);
    assert_int_equal(mkdir("/tmp/daft-aov-one.normal.pfm", 0700), 0);
    status = run_daft(output, "render assets/scenes/hello.scene -o /tmp/daft-aov-one.ppm --size 32x18 --aov normal");
    assert_status(status, 1, output);
    assert_says(output, "/tmp/daft-aov-one.normal.pfm: is a folder, not a file");
    assert_int_equal(rmdir("/tmp/daft-aov-one.normal.pfm"), 0);
    unlink("/tmp/daft-aov-one.ppm");
}

/* A mesh by itself gets a sky, a sun and a camera that has all of it in view. */
static void a_mesh_is_framed(void **unused)
{
    (void)unused;
    static const char *const sizes[] = {"80x45", "45x80"};
    for (size_t i = 0; i < 2; i++) {
        int status =
            run_daft(output, "render assets/meshes/gem.obj -o /tmp/daft-mesh.ppm --size %s --stats -", sizes[i]);
        assert_status(status, 0, output);
        assert_says(output, "\"instances_seen\": 1");
    }
    unlink("/tmp/daft-mesh.ppm");
}

/* ---- scans ---- */

/* The number after `key` in the header of a file of points, whose end is at *body. */
static long header_number(const char *path, const char *key, const char *last, long *body, long *size)
{
    char header[2000] = {0};
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t got = fread(header, 1, sizeof header - 1, file);
    fseek(file, 0, SEEK_END);
    *size = ftell(file);
    fclose(file);
    for (size_t i = 0; i < got; i++) /* behind the header are zeros */
        if (header[i] == 0) header[i] = ' ';
    char *found = strstr(header, key), *end = strstr(header, last);
    if (!found || !end) fail_msg("%s has no '%s' or '%s'", path, key, last);
    *body = end + strlen(last) - header;
    return strtol(found + strlen(key), NULL, 10);
}

static void scans_are_whole_files_of_points(void **unused)
{
    (void)unused;
    enum { FIELDS = 7 * 4 };
    char ply[64], pcd[64];
    long body, size, points;
    snprintf(ply, sizeof ply, "/tmp/daft-scan-%d.ply", (int)getpid());
    snprintf(pcd, sizeof pcd, "/tmp/daft-scan-%d.pcd", (int)getpid());
    int status = run_daft(output, "scan assets/scenes/hello.scene -o %s --rows 16 --columns 90", ply);
    assert_status(status, 0, output);
    assert_says(output, "of 1440 rays");
    points = header_number(ply, "element vertex ", "end_header\n", &body, &size);
    assert_true(points > 50 && points < 1440 && size == body + points * (24 + FIELDS));
    status = run_daft(output, "scan assets/scenes/hello.scene -o %s --rows 16 --columns 90 --threads 1", pcd);
    assert_status(status, 0, output);
    assert_int_equal(header_number(pcd, "POINTS ", "DATA binary\n", &body, &size), points);
    assert_true(size == body + points * (12 + FIELDS));
    status = run_daft(output,
                      "scan assets/scenes/hello.scene -o %s --pattern grid --rows 9 --columns 9 --at 0,50,0 "
                      "--bottom 10 --top 80",
                      ply);
    assert_status(status, 0, output);
    assert_int_equal(header_number(ply, "element vertex ", "end_header\n", &body, &size), 0);
    assert_true(size == body);
    unlink(ply), unlink(pcd);
}

static void bad_scans_are_told(void **unused)
{
    (void)unused;
    char rays[64];
    snprintf(rays, sizeof rays, "/tmp/daft-rays-%d.txt", (int)getpid());
    FILE *file = fopen(rays, "w");
    fputs("# mine\n1 0 0\n0 1\n", file);
    fclose(file);
    const char *const wrong[][2] = {{"--rays /tmp/daft-none.txt", "daft-none.txt"},
                                    {"--at 1,2", "--at is '1,2'"},
                                    {"--min-range 5 --max-range 2", "max_range is 2"},
                                    {"--camera 7", "counted from 0"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        int status = run_daft(output, "scan assets/scenes/hello.scene -o /tmp/daft-bad.ply %s", wrong[i][0]);
        assert_status(status, 1, output);
        assert_says(output, wrong[i][1]);
    }
    int status = run_daft(output, "scan assets/scenes/hello.scene -o /tmp/daft-bad.ply --rays %s", rays);
    assert_status(status, 1, output);
    assert_says(output, ":3:1: three numbers expected");
    assert_true(access("/tmp/daft-bad.ply", F_OK) != 0);
    unlink(rays);
}

static void check_finds_nothing_wrong_with_what_ships(void **unused)
{
    (void)unused;
    int status =
        run_daft(output, "check assets/scenes/*.scene assets/meshes/*.obj assets/textures/*.png marble toppler");
    assert_status(status, 0, output);
    assert_says(output, ": 0 errors, 0 warnings");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage_is_status_2_with_a_hint),
        cmocka_unit_test(bad_input_is_status_1_with_a_message),
        cmocka_unit_test(a_mesh_without_faces_is_refused),
        cmocka_unit_test(help_is_status_0),
        cmocka_unit_test(help_lua_prints_one_function_or_all_of_a_type),
        cmocka_unit_test(annotations_have_the_types_of_arguments_and_results),
        cmocka_unit_test(stats_are_json_with_the_promised_names),
        cmocka_unit_test(explain_prints_the_plan_and_nothing_draws_a_bar_in_a_pipe),
        cmocka_unit_test(pictures_do_not_depend_on_threads),
        cmocka_unit_test(aov_files_hold_what_the_library_says),
        cmocka_unit_test(aov_writes_what_is_asked_for_and_says_what_it_cannot),
#if defined(DAFT_HAS_OPENEXR)
        cmocka_unit_test(exr_layers_hold_what_the_files_do),
#endif
        cmocka_unit_test(a_mesh_is_framed),
        cmocka_unit_test(scans_are_whole_files_of_points),
        cmocka_unit_test(bad_scans_are_told),
        cmocka_unit_test(check_finds_nothing_wrong_with_what_ships)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
