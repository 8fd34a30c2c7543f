/* daft.h under misuse. Each of its functions, from the table that is made from its declarations: with NULL for each
 * pointer, handles that are none, stale, foreign or never were, numbers that are not finite, wrong cookies, counts that
 * are negative or huge, one at a time and at random; and from inside each callback. What cannot be accepted fails with
 * a message and leaves the scene as it was; nothing crashes, which is what the sanitizers are to see. */
#include "calls.h"

#include "fixtures.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    calls_folder_make(folder);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    calls_folder_remove(folder);
    return 0;
}

/* ---- one bad argument at a time ---- */

/* What the call came back with is what the worst of its arguments asks for. */
static void assert_answer(const caller *c, const call *what, bool reported)
{
    if (c->said == VERDICT_GOOD || c->said == VERDICT_ODD) return;
    if (what->reports && c->succeeded)
        fail_msg("%s takes a bad %s (argument %d, variant %d)", what->function, c->name, c->argument, c->variant);
    if (!what->reports && c->object_missing && c->succeeded) fail_msg("%s succeeds without its object", what->function);
    if (!what->reports || !reported) return;
    bool told = c->error.code != DAFT_OK && c->error.message[0];
    bool argument = c->said == VERDICT_BAD || c->error.code == DAFT_ERROR_ARGUMENT;
    if (!told || !argument)
        fail_msg("%s, argument %d, variant %d: error %d '%s'", what->function, c->argument, c->variant,
                 (int)c->error.code, c->error.message);
}

static void try_variant(size_t index, int argument, int variant, bool reported, bool *more)
{
    static caller c;
    c = (caller){.folder = folder, .no_error = !reported};
    caller_open(&c);
    uint64_t before = daft_scene_hash(c.scene);
    caller_choose(&c, argument, variant);
    caller_make(&c, index);
    assert_answer(&c, &CALLS[index], reported);
    bool failed = CALLS[index].reports && !c.succeeded;
    if (failed && daft_scene_hash(c.scene) != before)
        fail_msg("%s, argument %d, variant %d: it fails and changes the scene: %s", c.function, argument, variant,
                 c.error.message);
    *more = c.variants_left;
    caller_close(&c);
}

static void each_bad_argument_is_refused(void **state)
{
    (void)state;
    size_t tried = 0;
    for (size_t i = 0; i < CALL_COUNT; i++)
        for (int argument = 0; argument < CALLS[i].arguments; argument++) {
            bool more = true;
            for (int variant = 0; more; variant++, tried++) {
                try_variant(i, argument, variant, true, &more);
                if (CALLS[i].reports) try_variant(i, argument, variant, false, &more);
            }
        }
    print_message("%zu functions, %zu calls with a bad argument\n", CALL_COUNT, tried);
    assert_true(CALL_COUNT > 100 && tried > 2000);
}

/* So that a call above fails for the argument that is bad. Rays and volumes may miss. */
static void good_arguments_are_taken(void **state)
{
    (void)state;
    for (size_t i = 0; i < CALL_COUNT; i++) {
        caller c = {.folder = folder};
        caller_open(&c);
        caller_make(&c, i);
        if (CALLS[i].reports && c.error.code != DAFT_OK && c.said == VERDICT_GOOD)
            fail_msg("%s: error %d '%s'", CALLS[i].function, (int)c.error.code, c.error.message);
        caller_close(&c);
    }
}

/* ---- any arguments, any order ---- */

static void random_calls_do_no_harm(void **state)
{
    (void)state;
    fixture_seed(1);
    static uint8_t bytes[1 << 16];
    /* Half of all arguments are good, so that calls get far. */
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = random_bits() & 1 ? (uint8_t)random_bits() : 0;
    static caller c;
    c = (caller){.folder = folder};
    caller_open(&c);
    caller_feed(&c, bytes, sizeof bytes);
    while (c.byte_count > 2) {
        c.bytes += 2, c.byte_count -= 2;
        caller_make(&c, random_bits() % CALL_COUNT);
    }
    daft_view view = daft_default_view();
    daft_error error;
    assert_true(daft_scene_step(c.scene, 1.0f / 60, &error));
    assert_true(daft_render(c.scene, &view, c.image, &error));
    caller_close(&c);
}

/* ---- from inside callbacks ---- */

typedef struct nest {
    caller c;
    size_t index;
    int armed; /* how many calls of the callback are still to call */
    bool called;
} nest;

static void call_inside(nest *n)
{
    if (n->armed <= 0) return;
    n->armed--;
    n->called = n->c.nested = true;
    const call *what = &CALLS[n->index];
    caller_choose(&n->c, -1, 0);
    caller_make(&n->c, n->index);
    if (what->changes && what->reports &&
        (n->c.succeeded || n->c.error.code != DAFT_ERROR_ARGUMENT || !strstr(n->c.error.message, "inside a callback")))
        fail_msg("%s from inside a callback: error %d '%s'", what->function, (int)n->c.error.code, n->c.error.message);
    n->c.nested = false;
}

static bool on_progress(void *user, float done)
{
    (void)done;
    call_inside(user);
    return true;
}

static void on_warning(void *user, const daft_error *warning)
{
    (void)warning;
    call_inside(user);
}

static void on_problem(void *user, daft_severity severity, const daft_error *problem)
{
    (void)severity, (void)problem;
    call_inside(user);
}

static void *on_allocate(void *user, size_t size, size_t alignment)
{
    nest *n = user;
    if (CALLS[n->index].changes) call_inside(n); /* it may call nothing else */
    return aligned_alloc(alignment, (size + alignment - 1) & ~(alignment - 1));
}

static void on_release(void *user, void *pointer)
{
    nest *n = user;
    if (CALLS[n->index].changes) call_inside(n);
    free(pointer);
}

static void inside_progress(nest *n)
{
    daft_view view = daft_default_view();
    view.progress = on_progress, view.progress_user = n;
    n->c.drawing = true;
    assert_true(daft_render(n->c.scene, &view, n->c.image, NULL));
    n->c.drawing = false;
}

static void inside_warning(nest *n)
{
    n->c.warn = on_warning, n->c.warn_user = n;
    daft_scene_set_ambient(n->c.scene, (daft_vec3){-1, 0, 0});
    daft_scene_set_gravity(n->c.scene, (daft_vec3){INFINITY, 0, 0});
}

/* In the middle of loading: there is no such texture. */
static void inside_warning_of_load(nest *n)
{
    char path[128];
    n->c.warn = on_warning, n->c.warn_user = n;
    snprintf(path, sizeof path, "%s/lost.mtl", folder);
    assert_int_not_equal(daft_material_load(n->c.scene, path, NULL).id, 0);
}

static void inside_problem(nest *n)
{
    assert_true(daft_check_file(n->c.engine, "/no/such.scene", on_problem, n, NULL));
}

static void inside_allocator(nest *n)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.body = DAFT_BODY_DYNAMIC;
    assert_int_not_equal(daft_entity_create(n->c.scene, &def, NULL).id, 0);
}

typedef struct door {
    const char *name;
    void (*open)(nest *n);
    bool own_allocator;
} door;

static const door DOORS[] = {{"progress", inside_progress, false},
                             {"warning", inside_warning, false},
                             {"warning while loading", inside_warning_of_load, false},
                             {"problem", inside_problem, false},
                             {"allocator", inside_allocator, true}};

static void try_inside(const door *through, size_t index)
{
    static nest n;
    n = (nest){.index = index, .c.folder = folder};
    if (through->own_allocator) n.c.allocator = (daft_allocator){&n, on_allocate, on_release};
    caller_open(&n.c);
    n.armed = 2;
    through->open(&n);
    n.armed = 0;
    if (!through->own_allocator) assert_true(n.called);
    caller_mend(&n.c);
    daft_view view = daft_default_view();
    assert_true(daft_scene_step(n.c.scene, 1.0f / 60, NULL));
    assert_true(daft_render(n.c.scene, &view, n.c.image, NULL));
    caller_close(&n.c);
}

static void callbacks_cannot_change_what_is_in_use(void **state)
{
    const door *through = *state;
    for (size_t i = 0; i < CALL_COUNT; i++) try_inside(through, i);
}

int main(void)
{
    struct CMUnitTest tests[3 + sizeof DOORS / sizeof DOORS[0]] = {
        cmocka_unit_test(good_arguments_are_taken),
        cmocka_unit_test(each_bad_argument_is_refused),
        cmocka_unit_test(random_calls_do_no_harm),
    };
    for (size_t i = 0; i < sizeof DOORS / sizeof DOORS[0]; i++)
        tests[3 + i] =
            (struct CMUnitTest){DOORS[i].name, callbacks_cannot_change_what_is_in_use, NULL, NULL, (void *)&DOORS[i]};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
