/* runtime: the figures of frames that F1 shows as bars, and where panels go. */
#include "hud/graph.h"
#include "tools/panels.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static frame_graph graph;

static void add(double update, double picture, double scene, double shadow, double total)
{
    static daft_counters counters;
    counters.frame_ms = scene;
    counters.effects[DAFT_EFFECT_SHADOW] = (daft_effect){.name = "shadow", .ran = true, .ms = shadow};
    counters.effects[DAFT_EFFECT_FOG] = (daft_effect){.name = "fog", .ran = false, .ms = 99};
    graph_add_update(&graph, update);
    graph_add_picture(&graph, picture, &counters);
    graph_end_frame(&graph, total);
}

/* Compared with all frames ever told, of which the last GRAPH_FRAMES count. */
static void the_worst_is_that_of_the_last_frames(void **unused)
{
    (void)unused;
    enum { ALL = 1000 };
    float told[ALL];
    uint32_t random = 7;
    graph = (frame_graph){0};
    assert_null(graph_worst(&graph));
    for (int i = 0; i < ALL; i++) {
        random = random * 1664525u + 1013904223u;
        told[i] = 1 + (float)(random >> 16) / 1000;
        add(0.25, 0.5, 0.5, 0.25, (double)told[i]);
        float worst = 0;
        for (int k = i < GRAPH_FRAMES ? 0 : i - GRAPH_FRAMES + 1; k <= i; k++)
            worst = told[k] > worst ? told[k] : worst;
        assert_true(graph_worst(&graph)->total == worst);
        assert_true(graph_worst(&graph)->update == 0.25f && graph_worst(&graph)->picture == 0.5f);
    }
}

static void the_largest_parts_are_told(void **unused)
{
    (void)unused;
    char text[GRAPH_TEXT];
    graph = (frame_graph){0};
    add(3, 20, 15, 11, 40);
    assert_string_equal(graph_describe(&graph, graph_worst(&graph), text),
                        "waiting 17.0, shadow 11.0, texts and panels 5.0");
    graph = (frame_graph){0};
    add(6, 0.5, 0.5, 0.25, 6.5);
    assert_string_equal(graph_describe(&graph, graph_worst(&graph), text), "updates 6.0, shadow 0.2");
    graph = (frame_graph){0};
    add(6, 20, 15, 11, 0); /* a frame that says nothing leaves nothing behind */
    add(1, 2, 2, 2, 4.5);
    assert_int_equal(graph.count, 1);
    assert_string_equal(graph_describe(&graph, graph_worst(&graph), text), "shadow 2.0, waiting 1.5, updates 1.0");
}

static void panels_cover_neither_text_nor_each_other(void **unused)
{
    (void)unused;
    static canvas_marks marks;
    static uint8_t pixels[4 * 1280 * 720];
    canvas over = {.pixels = pixels, .width = 1280, .height = 720, .unit = 1};
    panels placed = {.marks = &marks};
    panels_place(&placed, &over, 300, 600);
    assert_true(over.origin_x == 0 && over.origin_y == 0);
    panels_place(&placed, &over, 500, 200);
    assert_true(over.origin_x == 300 && over.origin_y == 0);
    for (int i = 0; i < 5; i++) marks.at[i][20] = true; /* text at x = 400, y = 0 to 100 */
    placed.count = 1;
    panels_place(&placed, &over, 500, 200);
    assert_true(over.origin_x > 420 && over.origin_y == 0);
    for (int i = 0; i < MARK_COLUMNS; i++) marks.at[1][i] = true; /* all along the upper edge */
    placed.count = 1;
    panels_place(&placed, &over, 500, 200);
    assert_true(over.origin_x >= 300 && over.origin_y == 520);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_worst_is_that_of_the_last_frames),
                                       cmocka_unit_test(the_largest_parts_are_told),
                                       cmocka_unit_test(panels_cover_neither_text_nor_each_other)};
    return cmocka_run_group_tests_name("runtime graph", tests, NULL, NULL);
}
