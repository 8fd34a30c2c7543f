/* accuracy/probe: which settings stand beside those at hand, what they change in a picture, and that probing changes
 * nothing. */
#include "accuracy/probe.h"
#include "common/quality.h"

#include "support_content.h"

#include <math.h>

enum { WIDTH = 256, HEIGHT = 160, STEPS = 2 * KNOBS * 6 };

typedef struct world {
    daft_engine *engine;
    daft_scene *scene;
    daft_view view;
    probe p;
} world;

/* Two mirrors and a wall on a floor, under a lamp that is a point. */
static void open_world(world *w)
{
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    *w = (world){.engine = daft_engine_create(&def, &error)};
    assert_non_null(w->engine);
    w->scene = daft_scene_create(w->engine, &error);
    assert_non_null(w->scene);
    assert_true(daft_scene_load(w->scene, DAFT_ROOT "/assets/scenes/hello.scene", &error));
    w->view = daft_default_view();
    w->view.camera = daft_scene_camera(w->scene, 1);
    probe_begin(&w->p, w->engine);
}

static void close_world(world *w)
{
    probe_end(&w->p);
    daft_scene_destroy(w->scene);
    daft_engine_destroy(w->engine);
}

static void steps(world *w, int count)
{
    daft_error error;
    for (int i = 0; i < count; i++) assert_true(probe_step(&w->p, w->scene, &w->view, WIDTH, HEIGHT, &error));
}

static const probe_row *row_named(const world *w, const char *name)
{
    for (size_t k = 0; k < KNOBS; k++)
        if (strcmp(w->p.rows[k].knob->name, name) == 0) return &w->p.rows[k];
    fail_msg("no knob %s", name);
    return NULL;
}

static void check_text(const char *text, const char *expected)
{
    if (expected)
        assert_string_equal(text, expected);
    else
        assert_null(text);
}

static void settings_beside_those_at_hand(void **unused)
{
    (void)unused;
    static const struct {
        const char *knob, *now, *cheaper, *better;
    } rows[] = {
        {"scale", "scale=1", "scale=0.75,upscale=bicubic", NULL},
        {"visibility", "visibility=exact", "visibility=watertight", NULL},
        {"antialiasing", "samples=1,edge_samples=4", "samples=1,edge_samples=0",
         "samples=1,edge_samples=16,edge_contrast=2"},
        {"shadows", "shadows=on", "shadows=off", NULL},
        {"mirror_depth", "mirror_depth=2", "mirror_depth=1", "mirror_depth=4"},
        {"texture_filter", "texture_filter=trilinear", "texture_filter=mipmap", "texture_filter=anisotropic4"},
    };
    world w;
    open_world(&w);
    steps(&w, 1);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const probe_row *row = row_named(&w, rows[i].knob);
        check_text(row->now, rows[i].now);
        check_text(row->cheaper.setting, rows[i].cheaper);
        check_text(row->better.setting, rows[i].better);
    }
    w.view.quality.mirror_depth = 5; /* none of the table's */
    steps(&w, 1);
    assert_null(row_named(&w, "mirror_depth")->now);
    assert_null(row_named(&w, "mirror_depth")->better.setting);
    close_world(&w);
}

/* Each setting has its turn; what the scene calls for changes the picture, and what it does not call for does not. */
static void what_settings_change(void **unused)
{
    (void)unused;
    world w;
    double ms, uncertain, change;
    open_world(&w);
    assert_false(probe_sum(&w.p.rows[0].cheaper, &ms, &uncertain, &change));
    steps(&w, STEPS);
    for (size_t k = 0; k < KNOBS; k++) {
        const probe_figure *sides[] = {&w.p.rows[k].cheaper, &w.p.rows[k].better};
        for (int i = 0; i < 2; i++) {
            if (!sides[i]->setting || knob_is_by_rays(sides[i]->setting)) continue;
            assert_true(sides[i]->count >= 4);
            assert_true(probe_sum(sides[i], &ms, &uncertain, &change));
            assert_true(isfinite(ms) && uncertain >= 0 && change >= 0 && change < 1);
        }
    }
    static const struct {
        const char *knob;
        bool better, changes;
    } known[] = {{"antialiasing", false, true},      {"shadows", false, true}, {"scale", false, true},
                 {"glossy_samples", true, false},    /* nothing is rough, */
                 {"occlusion_samples", true, false}, /* no occlusion is asked for, */
                 {"refraction_depth", true, false}}; /* and nothing is clear */
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const probe_row *row = row_named(&w, known[i].knob);
        const probe_figure *f = known[i].better ? &row->better : &row->cheaper;
        if (!f->setting) continue;
        assert_true(probe_sum(f, &ms, &uncertain, &change));
        if ((change > 0) != known[i].changes) fail_msg("%s %s: FLIP %g", known[i].knob, f->setting, change);
    }
    close_world(&w);
}

/* A picture is the same after probing, and what stood still is not drawn again. */
static void probing_changes_nothing(void **unused)
{
    (void)unused;
    world w;
    daft_error error;
    open_world(&w);
    daft_image *image = daft_image_create(w.engine, WIDTH, HEIGHT, &error);
    const size_t bytes = 4 * (size_t)WIDTH * HEIGHT;
    w.view.history = daft_history_create(w.engine, &error);
    const uint64_t state = daft_scene_hash(w.scene);
    assert_true(daft_render(w.scene, &w.view, image, &error));
    const uint64_t before = daft_hash(daft_image_pixels(image), bytes, 0);
    steps(&w, 2 * KNOBS);
    assert_true(daft_render(w.scene, &w.view, image, &error));
    assert_int_equal(daft_scene_counters(w.scene)->tiles_drawn, 0);
    assert_true(daft_hash(daft_image_pixels(image), bytes, 0) == before);
    assert_true(daft_scene_hash(w.scene) == state);
    daft_history_destroy(w.view.history);
    daft_image_destroy(image);
    close_world(&w);
}

static void figures_are_the_middle_of_the_latest(void **unused)
{
    (void)unused;
    probe_figure f = {.setting = "samples=4", .count = 8};
    const float given[8] = {2, 900, 1, 2, 3, 2, -50, 2};
    double ms, uncertain, change;
    memcpy(f.ms, given, sizeof given);
    for (int i = 0; i < 8; i++) f.change[i] = 0.25f * (float)(i % 2);
    assert_true(probe_sum(&f, &ms, &uncertain, &change));
    assert_true(ms == 2 && uncertain == 0 && change == 0.125);
}

/* Rows of tiles of a turn: as often one as another. */
static void rows_are_taken_evenly(void **unused)
{
    (void)unused;
    for (int rows = 1; rows < 40; rows++) {
        int times[40] = {0};
        for (uint32_t turn = 0; turn < 40u * (uint32_t)rows; turn++) {
            const int row = probe_row_of(turn, rows);
            assert_true(row >= 0 && row < rows);
            times[row]++;
        }
        for (int i = 0; i < rows; i++) assert_true(times[i] >= 36 && times[i] <= 44);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(settings_beside_those_at_hand), cmocka_unit_test(what_settings_change),
        cmocka_unit_test(probing_changes_nothing),       cmocka_unit_test(figures_are_the_middle_of_the_latest),
        cmocka_unit_test(rows_are_taken_evenly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
