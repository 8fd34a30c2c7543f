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

#include <math.h>

#include <unistd.h>

#include "accuracy/report.h"
#include "accuracy/sim.h"
#include "common/quality.h"
#include "json.h"
#include "runtime_program.h"

static char output[OUTPUT_SIZE];

/* ---- the front --------------------------------------------------------------------------------------------------- */

enum { POINTS = 5 };

/* Each point's times are ms − 1, ms, ms + 1 and ms: a spread of a half or one. */
static sweep_result front_of(sweep_point *points, const double (*given)[3])
{
    sweep_result s = {.points = points, .count = POINTS, .moments = 1};
    for (int i = 0; i < POINTS; i++) {
        double ms = given[i][0];
        points[i] = (sweep_point){.at[0] = {.times = {ms - 1, ms, ms + 1, ms},
                                            .rounds = 4,
                                            .errors.flip = given[i][1],
                                            .half_flip = {given[i][1], given[i][1]},
                                            .picture = (uint64_t)given[i][2]}};
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
    p[1].at[0].half_flip[0] = 0.51, p[3].at[0].half_flip[1] = 0.31; /* one half says: no closer than the faster
                                                                       neighbour */
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
    /* What was timed again counts as it was then. */
    p[1].again_ms = 41, p[0].again_ms = 4, p[0].again_spread = 0.5;
    assert_int_equal(sweep_choose(&s, 40), 2);
    assert_int_equal(sweep_choose(&s, 5), 0);
}

/* A sweep that took a slow setting for one of no time, and a fast one for one of 20 s. */
static void a_budget_is_timed_again_before_it_is_told(void **unused)
{
    (void)unused;
    enum { CHEAP, SLOW, COUNT };
    daft_error error;
    daft_engine_def engine_def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&engine_def, &error);
    daft_scene *scene = daft_scene_create(engine, &error);
    assert_true(daft_scene_load(scene, DAFT_ROOT "/assets/scenes/hello.scene", &error));
    sweep_point p[COUNT] = {
        [CHEAP] = {.quality = daft_preset_quality(DAFT_PRESET_DRAFT), .ms = 20000, .errors.flip = 0.5},
        [SLOW] = {.quality = daft_preset_quality(DAFT_PRESET_GAME), .ms = 1e-4, .errors.flip = 0.1}};
    p[CHEAP].on_front = p[SLOW].on_front = true;
    p[CHEAP].same_as = p[SLOW].same_as = p[CHEAP].beaten_by = p[SLOW].beaten_by = -1;
    p[SLOW].quality.samples = 16;
    sweep_result s = {.points = p, .count = COUNT, .moments = 1};
    s.def = (sweep_def){.engine = engine, .scene = scene, .view = daft_default_view(), .width = 320, .height = 200};
    s.def.seconds = 3600, s.def.view.camera = daft_scene_camera(scene, 1);
    assert_int_equal(sweep_choose(&s, 1e-3), SLOW);
    assert_true(sweep_confirm(&s, 1e-3, &error));
    assert_true(p[SLOW].again_ms > 1e-3); /* a millionth of a second: nothing keeps it */
    assert_int_equal(sweep_choose(&s, 1e-3), -1);
    assert_true(sweep_confirm(&s, 1e5, &error));
    assert_int_equal(sweep_choose(&s, 1e5), SLOW);
    assert_true(p[CHEAP].again_ms > 0 && p[CHEAP].again_ms < p[SLOW].again_ms);
    const double between = sqrt(p[CHEAP].again_ms * p[SLOW].again_ms);
    assert_true(sweep_confirm(&s, between, &error));
    assert_int_equal(sweep_choose(&s, between), CHEAP);
    s.moved_on = true; /* the game is elsewhere: what it takes there says nothing */
    assert_true(sweep_confirm(&s, between, &error));
    assert_true(p[CHEAP].again_ms == 0 && p[SLOW].again_ms == 0);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

/* A game's figures are means over its moments, and the worst tile of all. */
static void moments_are_averaged(void **unused)
{
    (void)unused;
    sweep_point p = {.at = {{.times = {10, 10}, .rounds = 2, .errors = {.rmse = 0.1, .flip = 0.2, .worst = 0.5}},
                            {.times = {20, 24}, .rounds = 2, .errors = {.rmse = 0.1, .flip = 0.4, .worst = 0.3}}}};
    p.at[0].temporal = 0.02;
    sweep_result s = {.points = &p, .count = 1, .moments = 2};
    sweep_judge(&s);
    assert_true(fabs(p.ms - 16) < 1e-9 && fabs(p.spread - 1) < 1e-9 && fabs(p.errors.flip - 0.3) < 1e-9);
    assert_true(p.errors.worst == 0.5 && fabs(p.errors.rmse - 0.1) < 1e-9 && fabs(p.temporal - 0.01) < 1e-9);
    assert_true(fabs(p.errors.psnr - 20) < 1e-6);
}

/* A machine that becomes twice as slow and fast again, for all settings alike: each has its own time and a small
 * spread, and ones that are a tenth apart are told apart. */
static void what_slows_all_alike_is_taken_out(void **unused)
{
    (void)unused;
    enum { MANY = 40 };
    static sweep_point p[MANY];
    sweep_result s = {.points = p, .count = MANY, .moments = 1};
    uint64_t state = 99;
    for (int i = 0; i < MANY; i++) {
        sweep_measure *m = &p[i].at[0];
        m->rounds = SWEEP_ROUNDS, m->picture = (uint64_t)i;
        m->errors.flip = m->half_flip[0] = m->half_flip[1] = 1 - 0.01 * i; /* each dearer one is closer */
        for (int round = 0; round < SWEEP_ROUNDS; round++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            const double noise = 1 + 0.01 * ((double)(state >> 11) * 0x1p-53 - 0.5);
            m->times[round] = 10 * pow(1.1, i) * (round < 5 || round > 11 ? 1 : 2) * noise;
        }
    }
    sweep_judge(&s);
    for (int i = 0; i < MANY; i++) {
        assert_true(p[i].on_front && p[i].spread < 0.01 * p[i].ms);
        if (i > 0) assert_true(fabs(p[i].ms / p[i - 1].ms - 1.1) < 0.01);
    }
}

/* ---- advice ---------------------------------------------------------------------------------------------------- */

static void advice_is_options_of_daft_render(void **unused)
{
    (void)unused;
    static const struct {
        const char *knob, *setting, *says;
    } cases[] = {
        {"quality", "high", "--quality high --size 64x48"},
        {"antialiasing", "samples=4,edge_samples=0", "--quality game --knobs samples=4,edge_samples=0 --size 64x48"},
        {"scale", "scale=0.5,upscale=bicubic", "--quality game --knobs scale=0.5,upscale=bicubic --size 64x48"},
        {"all", "scale=0.75,min_weight=1/64", "--quality game --knobs scale=0.75,min_weight=1/64 --size 64x48"}};
    sweep_result s = {.def = {.preset = DAFT_PRESET_GAME, .width = 64, .height = 48}};
    char picture[] = "/tmp/daft-cost-XXXXXX.png";
    int file = mkstemps(picture, 4);
    assert_true(file >= 0);
    close(file);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char options[SENTENCE];
        sweep_point p = {.knob = cases[i].knob};
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
    daft_quality q = daft_preset_quality(DAFT_PRESET_GAME);
    assert_true(quality_parse("samples=4,shadows=0,min_weight=1/64,visibility=fast,scale=0.5,denoise=off", &q, &error));
    assert_true(q.samples == 4 && !q.shadows && !q.denoise && q.min_weight == 1.0f / 64 && q.scale == 0.5f);
    assert_int_equal(q.visibility, DAFT_INTERSECT_FAST);
    for (size_t k = 0; k < KNOBS; k++) /* what a sweep tries can be read */
        for (size_t i = 0; i < knob_count(knob_at(k)); i++)
            if (!quality_parse(knob_at(k)->settings[i], &q, &error)) fail_msg("%s", error.message);
}

/* A sweep tries every knob that there is. */
static void every_knob_is_swept(void **unused)
{
    (void)unused;
    uint32_t count;
    const daft_field *fields = daft_fields(DAFT_STRUCT_QUALITY, &count);
    for (uint32_t f = 0; f < count; f++) {
        bool tried = false;
        for (size_t k = 0; k < KNOBS; k++)
            for (size_t i = 0; i < knob_count(knob_at(k)); i++)
                tried |= strstr(knob_at(k)->settings[i], fields[f].name) != NULL;
        if (!tried) fail_msg("%s is not tried", fields[f].name);
    }
}

static void wrong_knobs_are_named(void **unused)
{
    (void)unused;
    static const struct {
        const char *list, *says;
    } wrong[] = {{"smaples=4", "did you mean 'samples'?"},
                 {"samples", "NAME=VALUE expected"},
                 {"samples=3", "knob samples: '3' is none of its values (1, 4, 8 or 16)"},
                 {"samples=", "'' is none"},
                 {"shadows=0.5", "knob shadows"},
                 {"mirror_depth=33", "knob mirror_depth"},
                 {"mirror_depth=nan", "knob mirror_depth"},
                 {"min_weight=1/0", "knob min_weight"},
                 {"scale=0", "knob scale"},
                 {"visibility=quick", "knob visibility: 'quick' is none of its values (exact, watertight or fast)"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        daft_error error;
        daft_quality q = daft_preset_quality(DAFT_PRESET_GAME), before = q;
        assert_false(quality_parse(wrong[i].list, &q, &error));
        assert_says(error.message, wrong[i].says);
        assert_memory_equal(&q, &before, sizeof q);
    }
}

/* What the scene asks for gives way to a preset, and both to single knobs. */
static void wishes_are_joined(void **unused)
{
    (void)unused;
    const quality_wish none = {.preset = QUALITY_OF_SCENE}, high = {DAFT_PRESET_HIGH, NULL},
                       both = {DAFT_PRESET_HIGH, "samples=16"};
    assert_int_equal(quality_choose(&none, NULL).edge_samples, 4);
    assert_int_equal(quality_choose(&high, NULL).edge_samples, 16);
    assert_int_equal(quality_choose(&high, NULL).samples, 1);
    assert_int_equal(quality_choose(&both, NULL).samples, 16);
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
    assert_says(output, "timed again at the end");
    char *csv = read_report(folder, "points.csv"), *json = read_report(folder, "report.json");
    char *page = read_report(folder, "index.html");
    assert_true(strncmp(csv, "scene,knob,setting,ms,ms_spread,rmse,psnr,ssim,flip,on_front\n", 61) == 0);
    assert_says(csv, "assets/scenes/hello.scene,quality,game,");
    const char *end = json_value(json);
    assert_non_null(end);
    assert_int_equal(*json_blanks(end), 0);
    assert_says(json, "\"budget_kept\":true");
    assert_says(json, "\"ms_again\":");
    assert_says(page, "</html>");
    assert_says(page, "<svg");
    assert_says(page, "What a picture of quality game is made of");
    assert_says(page, "visibility=fast: ");
    assert_says(json, "\"effect\":\"shadow\"");
    assert_null(strstr(page, "://")); /* nothing comes from a network */
    free(csv), free(json), free(page);
    remove_report(folder);
}

/* Where there is time, nothing is left out: every setting of every knob, every preset, and combinations; where there is
 * none, what is left is as right, and it says how much is missing. */
static void time_decides_how_much_is_measured(void **unused)
{
    (void)unused;
    daft_error error;
    daft_engine_def engine_def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&engine_def, &error);
    daft_scene *scene = daft_scene_create(engine, &error);
    assert_true(daft_scene_load(scene, DAFT_ROOT "/assets/scenes/hello.scene", &error));
    sweep_def def = {.engine = engine,
                     .scene = scene,
                     .view = daft_default_view(),
                     .preset = DAFT_PRESET_GAME,
                     .width = 48,
                     .height = 32,
                     .seconds = 3600,
                     .quick = true};
    def.view.camera = daft_scene_camera(scene, 1);
    sweep_result all;
    assert_true(sweep_run(&all, &def, &error));
    size_t settings = 0, cells = 0;
    for (size_t k = 0; k < KNOBS; k++) settings += knob_count(knob_at(k));
    for (size_t i = 0; i < all.count; i++) cells += strcmp(all.points[i].knob, "all") == 0;
    assert_int_equal(all.dropped, 0);
    assert_true(cells > 1);
    assert_int_equal(all.count, 4 + settings + cells);
    sweep_free(&all);
    def.seconds = 1e-9;
    assert_true(sweep_run(&all, &def, &error));
    assert_true(all.dropped > 0 && all.count > all.preset && all.points[all.preset].ms > 0);
    sweep_free(&all);
    def.seconds = 3600, def.knob = knob_named("antialiasing");
    assert_true(sweep_run(&all, &def, &error));
    assert_int_equal(all.count, 1 + knob_count(def.knob));
    sweep_free(&all);
    /* A user's own settings, whatever time there is. */
    char text[] = "samples=4,edge_samples=0;tree=bvh";
    knob_row own;
    assert_true(knob_own(text, &own, &error));
    def.seconds = 1, def.knob = &own;
    assert_true(sweep_run(&all, &def, &error));
    assert_int_equal(all.count, 3);
    assert_string_equal(all.points[1].setting, "samples=4,edge_samples=0");
    assert_true(all.points[1].quality.samples == 4 && all.points[2].ms > 0);
    sweep_free(&all);
    /* What is held fast is so in all pictures, and not swept. */
    def.seconds = 3600, def.knob = NULL, def.fixed = "shadows=off,samples=1,edge_samples=0";
    assert_true(sweep_run(&all, &def, &error));
    for (size_t i = 0; i < all.count; i++) {
        const sweep_point *p = &all.points[i];
        assert_true(!p->quality.shadows && p->quality.samples == 1 && p->quality.edge_samples == 0);
        assert_null(strstr(p->setting, "shadows=on"));
        assert_true(strcmp(p->knob, "antialiasing") != 0 || strcmp(p->setting, "samples=1,edge_samples=0") == 0);
    }
    sweep_free(&all);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

static void a_simulation_is_measured(void **unused)
{
    (void)unused;
    char folder[32];
    make_folder(folder);
    assert_status(run_daft(output, "cost marble --sim --quick --at 2 -o %s", folder), 0, output);
    assert_says(output, "substeps=16,rate=60");
    assert_says(output, "The reference takes 3840 steps a second");
    char *csv = read_report(folder, "points.csv"), *json = read_report(folder, "report.json");
    char *page = read_report(folder, "index.html");
    assert_says(csv, "marble,physics,\"substeps=4,rate=60\",");
    const char *end = json_value(json);
    assert_non_null(end);
    assert_int_equal(*json_blanks(end), 0);
    assert_says(page, "</html>");
    free(csv), free(json), free(page);
    remove_report(folder);
}

/* Finer settings end nearer to the reference: a ball that falls and rolls. */
static bool stay(void *user, daft_error *error)
{
    (void)user, (void)error;
    return true;
}

static void finer_simulations_come_closer(void **unused)
{
    (void)unused;
    daft_error error;
    daft_engine_def engine_def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&engine_def, &error);
    daft_scene *scene = daft_scene_create(engine, &error);
    sim_result all;
    const sim_def def = {scene, 1, stay, NULL, 1};
    assert_false(sim_run(&all, &def, &error)); /* nothing moves */
    assert_says(error.message, "nothing to simulate");
    daft_entity_def ground = daft_default_entity_def(), ball = daft_default_entity_def();
    ground.shape = DAFT_SHAPE_BOX, ground.size = (daft_vec3){20, 1, 20}, ground.body = DAFT_BODY_STATIC;
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 0.5f, ball.body = DAFT_BODY_DYNAMIC;
    ball.position = (daft_dvec3){0, 1.3, 0};
    assert_true(daft_entity_create(scene, &ground, &error).id);
    const daft_entity thrown = daft_entity_create(scene, &ball, &error);
    assert_true(daft_entity_set_velocity(scene, thrown, (daft_vec3){3, 0, 0}, (daft_vec3){0, 0, 0}, &error));
    assert_int_equal(daft_scene_moving(scene, NULL, 0), 1);
    if (!sim_run(&all, &def, &error)) fail_msg("%s", error.message);
    print_message("coarsest: %g m, finest: %g m, floor %g m\n", all.settings[0].position, all.settings[10].position,
                  all.floor);
    assert_true(all.settings[10].position < all.settings[0].position);
    assert_true(all.settings[0].position > all.floor);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

/* The switch marks what is counted, and nothing where visibility is exact. */
static void wrong_pixels_are_red(void **unused)
{
    (void)unused;
    const int size = 4;
    uint8_t mask[16] = {0}, pixels[64] = {0};
    mask[5] = 1;
    wrong_paint(mask, size, size, pixels);
    assert_true(pixels[4 * 5] == 255 && pixels[4 * 5 + 1] == 0 && pixels[4 * 6] == 255 && pixels[4 * 15] == 0);
    char picture[] = "/tmp/daft-cost-XXXXXX.png";
    int file = mkstemps(picture, 4);
    assert_true(file >= 0);
    close(file);
    int status = run_daft(output, "render assets/scenes/hello.scene -o %s --size 64x48 --wrong", picture);
    assert_status(status, 0, output);
    assert_says(output, "daft: 0 of 3072 pixels see another triangle");
    unlink(picture);
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
                 {2, "cost a.scene --settings 'samples=8;samples=3'", "--settings: knob samples: '3'"},
                 {2, "cost a.scene --settings 'samples=8;'", "--settings: a setting is empty"},
                 {2, "cost a.scene --settings samples=8 --knob scale", "--settings: without --knob"},
                 {2, "cost a.scene --sim", "--sim: a game expected"},
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
                                       cmocka_unit_test(a_budget_is_timed_again_before_it_is_told),
                                       cmocka_unit_test(advice_is_options_of_daft_render),
                                       cmocka_unit_test(knobs_are_read_by_name),
                                       cmocka_unit_test(wrong_knobs_are_named),
                                       cmocka_unit_test(every_knob_is_swept),
                                       cmocka_unit_test(wishes_are_joined),
                                       cmocka_unit_test(moments_are_averaged),
                                       cmocka_unit_test(what_slows_all_alike_is_taken_out),
                                       cmocka_unit_test(a_report_holds_what_is_promised),
                                       cmocka_unit_test(time_decides_how_much_is_measured),
                                       cmocka_unit_test(a_simulation_is_measured),
                                       cmocka_unit_test(finer_simulations_come_closer),
                                       cmocka_unit_test(wrong_pixels_are_red),
                                       cmocka_unit_test(bad_input_is_told_plainly)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
