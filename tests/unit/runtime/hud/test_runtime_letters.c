/* runtime: letters in 3D: closed, with the area that the same letters have when they are drawn, and shared in Lua. */
#include "hud/letters.h"
#include "cli/commands.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include "runtime_program.h"

static char output[OUTPUT_SIZE];
static font *face;
static daft_engine *engine;
static daft_scene *scene;

static int open_face(void **unused)
{
    (void)unused;
    home where;
    daft_error error;
    const daft_engine_def def = daft_default_engine_def();
    if (!home_find(&where, &error)) return -1;
    face = open_font(&where, &error);
    engine = daft_engine_create(&def, &error);
    scene = daft_scene_create(engine, &error);
    return face && scene ? 0 : -1;
}

static int close_face(void **unused)
{
    (void)unused;
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    font_close(face);
    return 0;
}

static daft_mesh solid_of(const letters *l, daft_error *error)
{
    daft_extrude_def def = daft_default_extrude_def();
    def.points = l->points, def.counts = l->counts;
    def.point_count = l->point_count, def.contour_count = l->contour_count;
    return daft_mesh_extrude(scene, &def, error);
}

/* Pixels of the letter as it is drawn, by stb_truetype. */
static double drawn_area(const char *text, float size)
{
    enum { WIDTH = 1024, HEIGHT = 1024 };
    static uint8_t pixels[4 * WIDTH * HEIGHT];
    memset(pixels, 0, sizeof pixels);
    const canvas target = {.pixels = pixels, .width = WIDTH, .height = HEIGHT, .unit = 1};
    const text_style style = {size, {255, 255, 255, 255}, TEXT_LEFT, false};
    text_draw(&target, face, text, 300, 200, &style);
    double sum = 0;
    for (size_t i = 0; i < sizeof pixels; i += 4) sum += pixels[i] / 255.0;
    return sum;
}

/* Of the front, by rays through it: a slow count that knows nothing of triangles' order. */
static double front_area(daft_mesh mesh, const daft_mesh_info *info)
{
    enum { STEPS = 80 };
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = mesh;
    daft_entity entity = daft_entity_create(scene, &def, NULL);
    const double width = (double)(info->high.x - info->low.x), height = (double)(info->high.y - info->low.y);
    int hits = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        const double x = (double)info->low.x + width * (i % STEPS + 0.5) / STEPS,
                     y = (double)info->low.y + height * (i / STEPS + 0.5) / STEPS;
        daft_ray_hit hit;
        hits += daft_scene_cast_ray(scene, (daft_dvec3){x, y, 5}, (daft_vec3){0, 0, -1}, INFINITY, (daft_entity){0},
                                    &hit, NULL);
    }
    daft_entity_destroy(scene, entity, NULL);
    return width * height * hits / (STEPS * STEPS);
}

/* Every letter of Latin, Greek and Cyrillic: closed, and as large as it is drawn. */
static void every_letter_is_a_solid(void **unused)
{
    (void)unused;
    /* Pixels and metres alike. */
    enum { CAPITAL = 200 };
    int letters_seen = 0;
    const truetype_outline *outline = font_outline(face, 'H');
    float box[4];
    truetype_bounds(outline, box);
    const float line = CAPITAL * (float)font_height(face) / box[3];
    for (uint32_t code = 33; code < 0x460; code++) {
        char text[4] = {(char)code};
        if (code >= 128) text[0] = (char)(0xC0 | code >> 6), text[1] = (char)(0x80 | (code & 63));
        letters l;
        daft_error error;
        daft_mesh_info info;
        daft_mesh_report report;
        assert_true(letters_make(&l, face, text, CAPITAL, TEXT_LEFT, &error));
        if (l.contour_count == 0) continue;
        const daft_mesh mesh = solid_of(&l, &error);
        if (mesh.id == 0) fail_msg("U+%04X: %s", code, error.message);
        assert_true(daft_mesh_check(scene, mesh, &report, &error));
        if (report.open_edges || report.turned_edges || report.duplicate_triangles || report.left_out)
            fail_msg("U+%04X: %u open edges, %u turned", code, report.open_edges, report.turned_edges);
        assert_true(daft_mesh_get_info(scene, mesh, &info, &error));
        if (code % 4 == 0 || code < 127) {
            const double drawn = drawn_area(text, line), solid = front_area(mesh, &info);
            if (fabs(drawn - solid) > 0.06 * drawn + 60)
                fail_msg("U+%04X: %.0f pixels drawn, %.0f of the solid", code, drawn, solid);
        }
        daft_mesh_release(scene, mesh, NULL);
        daft_scene_collect(scene);
        letters_free(&l);
        letters_seen++;
    }
    assert_true(letters_seen > 900);
}

static void lines_stand_on_each_other(void **unused)
{
    (void)unused;
    letters one, two;
    daft_error error;
    assert_true(letters_make(&one, face, "HH", 2, TEXT_LEFT, &error));
    assert_true(letters_make(&two, face, "HH\nHH", 2, TEXT_RIGHT, &error));
    assert_int_equal(two.point_count, 2 * one.point_count);
    float low = 9, high = 0, right = -9;
    for (uint32_t i = 0; i < two.point_count; i++)
        low = fminf(low, two.points[i].y), high = fmaxf(high, two.points[i].y), right = fmaxf(right, two.points[i].x);
    assert_true(fabsf(low) < 0.01f && high > 4 && high < 6.5f && right < 0);
    letters_free(&one);
    letters_free(&two);
}

/* The same text is one mesh while it is held, also after a collection; a mistake says what is wrong. */
static void lua_shares_texts(void **unused)
{
    (void)unused;
    const int status = run_daft(output, "play tests/games/letters --headless --ticks 3");
    assert_status(status, 0, output);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_letter_is_a_solid),
        cmocka_unit_test(lines_stand_on_each_other),
        cmocka_unit_test(lua_shares_texts),
    };
    return cmocka_run_group_tests(tests, open_face, close_face);
}
