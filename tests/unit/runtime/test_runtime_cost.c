/* runtime: daft cost: which settings are on the front and which a budget buys, the files it writes, what it refuses. */
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

#include <unistd.h>

#include "accuracy/report.h"
#include "json.h"
#include "runtime_program.h"

static char output[OUTPUT_SIZE];

/* ---- the front --------------------------------------------------------------------------------------------------- */

enum { POINTS = 5 };

/* Each point's times are ms − 1, ms, ms + 1 and ms: a spread of a half or one. */
static sweep_result front_of(sweep_point *points, const double (*given)[3])
{
    sweep_result s = {.points = points, .count = POINTS};
    for (int i = 0; i < POINTS; i++) {
        double ms = given[i][0];
        points[i] = (sweep_point){.times = {ms - 1, ms, ms + 1, ms},
                                  .rounds = 4,
                                  .errors.flip = given[i][1],
                                  .half_flip = {given[i][1], given[i][1]},
                                  .picture = (uint64_t)given[i][2]};
    }
    return s;
}

static void the_front_is_what_no_other_beats(void **unused)
{
    (void)unused;
    sweep_point p[POINTS];
    /* ms, FLIP, picture: cheap; better; slower than that and worse; the same picture as `better` in equal time; slow */
    const double given[POINTS][3] = {{10, 0.5, 1}, {20, 0.2, 2}, {30, 0.4, 3}, {20.2, 0.2, 2}, {90, 0.1, 4}};
    sweep_result s = front_of(p, given);
    sweep_judge(&s);
    assert_true(p[0].on_front && p[1].on_front && p[4].on_front);
    assert_false(p[2].on_front || p[3].on_front);
    assert_int_equal(p[2].beaten_by, 1);
    assert_int_equal(p[3].same_as, 1);
    assert_true(p[0].ms > 9.99 && p[0].ms < 10.01);
    assert_true(sweep_equal_times(&p[1], &p[3]));
    assert_false(sweep_equal_times(&p[0], &p[1]));
    assert_false(sweep_all_same(&s));
}

static void what_the_halves_disagree_on_is_equal(void **unused)
{
    (void)unused;
    sweep_point p[POINTS];
    const double given[POINTS][3] = {{10, 0.5, 1}, {20, 0.45, 2}, {30, 0.3, 3}, {60, 0.29, 4}, {90, 0.1, 5}};
    sweep_result s = front_of(p, given);
    sweep_judge(&s);
    for (int i = 0; i < POINTS; i++) assert_true(p[i].on_front);
    p[1].half_flip[0] = 0.51, p[3].half_flip[1] = 0.31; /* one half says: no closer than the faster neighbour */
    sweep_judge(&s);
    assert_int_equal(p[1].beaten_by, 0);
    assert_int_equal(p[3].beaten_by, 2);
    assert_true(p[0].on_front && p[2].on_front && p[4].on_front);
}

static void a_budget_buys_the_least_error_within_it(void **unused)
{
    (void)unused;
    sweep_point p[POINTS];
    const double given[POINTS][3] = {{10, 0.5, 1}, {20, 0.2, 2}, {30, 0.4, 3}, {20.2, 0.2, 2}, {90, 0.1, 4}};
    sweep_result s = front_of(p, given);
    sweep_judge(&s);
    assert_int_equal(sweep_choose(&s, 16), 0);
    assert_int_equal(sweep_choose(&s, 40), 1);
    assert_int_equal(sweep_choose(&s, 20), 0); /* the median keeps it, its spread does not */
    assert_int_equal(sweep_choose(&s, 1000), 4);
    assert_int_equal(sweep_choose(&s, 5), -1);
}

/* ---- advice ---------------------------------------------------------------------------------------------------- */

static void advice_is_options_of_daft_render(void **unused)
{
    (void)unused;
    static const struct {
        const char *knob, *setting, *says;
        double scale;
    } cases[] = {
        {"quality", "high", "--quality high --size 64x48", 1},
        {"samples", "samples=4", "--quality game --knobs samples=4 --size 64x48", 1},
        {"scale", "scale=0.5", "--quality game --size 32x24", 0.5},
        {"all", "shadows=0,scale=0.5,samples=4", "--quality game --knobs shadows=0,samples=4 --size 32x24", 0.5},
        {"all", "scale=0.75,min_weight=1/64", "--quality game --knobs min_weight=1/64 --size 48x36", 0.75}};
    sweep_result s = {.def = {.view = daft_default_view(), .width = 64, .height = 48}};
    char picture[] = "/tmp/daft-cost-XXXXXX.png";
    int file = mkstemps(picture, 4);
    assert_true(file >= 0);
    close(file);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char options[SENTENCE];
        sweep_point p = {.knob = cases[i].knob, .set.scale = cases[i].scale};
        snprintf(p.setting, sizeof p.setting, "%s", cases[i].setting);
        report_command(&s, &p, options, sizeof options);
        assert_string_equal(options, cases[i].says);
        assert_status(run_daft(output, "render assets/scenes/hello.scene -o %s %s", picture, options), 0, output);
    }
    unlink(picture);
}

/* ---- knobs ------------------------------------------------------------------------------------------------------- */

static void knobs_are_read_by_name(void **unused)
{
    (void)unused;
    daft_error error;
    knob_set set = {daft_default_view(), 1};
    assert_true(knobs_parse("samples=4,shadows=0,min_weight=1/64,intersection=fast,scale=0.5", &set, &error));
    assert_int_equal(set.view.samples, 4);
    assert_int_equal(set.view.shadows, 0);
    assert_true(set.view.min_weight == 1.0f / 64);
    assert_int_equal(set.view.intersection, DAFT_INTERSECT_FAST);
    assert_true(set.scale == 0.5);
    for (size_t k = 0; k < KNOBS; k++) { /* what is printed can be read */
        for (size_t i = 0; i < knob_at(k)->count; i++) {
            char text[KNOB_TEXT];
            if (!knobs_parse(knob_print(text, k, knob_at(k)->values[i]), &set, &error)) fail_msg("%s", error.message);
        }
    }
}

static void wrong_knobs_are_named(void **unused)
{
    (void)unused;
    static const struct {
        const char *list, *says;
    } wrong[] = {{"smaples=4", "did you mean 'samples'?"},
                 {"samples", "NAME=VALUE expected"},
                 {"samples=3", "knob samples: '3' is none"},
                 {"samples=", "'' is none"},
                 {"shadows=0.5", "knob shadows"},
                 {"mirror_depth=33", "knob mirror_depth"},
                 {"mirror_depth=nan", "knob mirror_depth"},
                 {"min_weight=1/0", "knob min_weight"},
                 {"scale=0", "knob scale"},
                 {"intersection=quick", "knob intersection"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        daft_error error;
        knob_set set = {daft_default_view(), 1};
        assert_false(knobs_parse(wrong[i].list, &set, &error));
        assert_says(error.message, wrong[i].says);
    }
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

static char *read_text(const char *path)
{
    size_t size;
    daft_error error;
    char *text = daft_read_file(NULL, path, &size, &error);
    if (!text) fail_msg("%s", error.message);
    return text;
}

static void make_folder(char *folder)
{
    strcpy(folder, "/tmp/daft-cost-XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static void remove_report(const char *folder)
{
    static const char *const names[] = {"index.html", "points.csv", "report.json"};
    for (size_t i = 0; i < 3; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        unlink(path);
    }
    if (rmdir(folder) != 0) fail_msg("%s: something else was left in the folder", folder);
}

static char *read_report(const char *folder, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return read_text(path);
}

static void a_report_holds_what_is_promised(void **unused)
{
    (void)unused;
    char folder[32];
    make_folder(folder);
    int status = run_daft(output, "cost assets/scenes/hello.scene --quick --size 64x48 --budget 1000 -o %s", folder);
    assert_status(status, 0, output);
    assert_says(output, "settings that no other beats");
    assert_says(output, "For 1000 ms: --quality");
    char *csv = read_report(folder, "points.csv"), *json = read_report(folder, "report.json");
    char *page = read_report(folder, "index.html");
    assert_true(strncmp(csv, "scene,knob,setting,ms,ms_spread,rmse,psnr,ssim,flip,on_front\n", 61) == 0);
    assert_says(csv, "assets/scenes/hello.scene,quality,reference,");
    for (size_t k = 0; k < KNOBS; k++) assert_says(csv, knob_at(k)->name);
    const char *end = json_value(json);
    assert_non_null(end);
    assert_int_equal(*json_blanks(end), 0);
    assert_says(json, "\"budget_kept\":true");
    assert_says(page, "</html>");
    assert_says(page, "<svg");
    assert_null(strstr(page, "://")); /* nothing comes from a network */
    free(csv), free(json), free(page);
    remove_report(folder);
}

static void bad_input_is_told_plainly(void **unused)
{
    (void)unused;
    char folder[32];
    make_folder(folder);
    static const struct {
        int status;
        const char *arguments, *says;
    } wrong[] = {{2, "cost", "SCENE|GAME is missing"},
                 {2, "cost a.scene --budget 0", "--budget: a number above 0"},
                 {2, "cost a.scene --size 4x4", "each from 16 to 1920"},
                 {1, "cost nowhere.scene", "nowhere.scene"},
                 {1, "cost no_such_game", "no_such_game"},
                 {1, "cost marble --at 86400 --size 16x16", "the game ends before"},
                 {1, "cost assets/scenes/hello.scene --quick --size 16x16 -o /proc/none", "/proc/none"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        bool named = strstr(wrong[i].arguments, " -o ") || wrong[i].status == 2;
        int status = run_daft(output, named ? "%s" : "%s -o %s", wrong[i].arguments, folder);
        assert_status(status, wrong[i].status, output);
        assert_says(output, wrong[i].says);
    }
    remove_report(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_front_is_what_no_other_beats),
                                       cmocka_unit_test(what_the_halves_disagree_on_is_equal),
                                       cmocka_unit_test(a_budget_buys_the_least_error_within_it),
                                       cmocka_unit_test(advice_is_options_of_daft_render),
                                       cmocka_unit_test(knobs_are_read_by_name),
                                       cmocka_unit_test(wrong_knobs_are_named),
                                       cmocka_unit_test(a_report_holds_what_is_promised),
                                       cmocka_unit_test(bad_input_is_told_plainly)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
