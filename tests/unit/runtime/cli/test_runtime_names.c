/* daft check on code that does not run: names that nothing has are told, with their lines, and right ones are not;
 * files that nothing names are noted. */
#include "runtime_program.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

static char output[OUTPUT_SIZE];
static char folder[] = "/tmp/daft-names-XXXXXX";

static void write_text(const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* A game in which `body` is a function that nobody calls. Returns the exit status of daft check. */
static int check_body(const char *body)
{
    char text[2000];
    snprintf(text, sizeof text,
             "local M = {}\nSETTING = 3\nfunction M:own(x) return self end\nlocal function never(ball, ...)\n%s\nend\n"
             "function daft.keypressed(key) if key == 'zz' then never() end end\n",
             body);
    write_text("main.lua", text);
    return run_daft(output, "check --strict '%s'", folder);
}

static void names_that_nothing_has_are_told(void **unused)
{
    (void)unused;
    static const struct {
        const char *body, *said;
    } cases[] = {
        {"prnt('x')", "main.lua:5: warning: nothing sets the global 'prnt': did you mean 'print'?"},
        {"return SETING", "nothing sets the global 'SETING': did you mean 'SETTING'?"},
        {"local x = 1\nfor i = 1, x do print(undefined_thing) end",
         "main.lua:6: warning: nothing sets the global 'undefined_thing'"},
        {"return function() return function() prnt() end end", "main.lua:5: warning: nothing sets the global 'prnt'"},
        {"daft.light.snu { direction = {0, -1, 0} }",
         "main.lua:5: error: daft.light has no 'snu': did you mean 'sun'?"},
        {"local d = daft\nd.raycst()", "main.lua:6: error: daft has no 'raycst': did you mean 'raycast'?"},
        {"daft.updat = function() end", "error: daft has no 'updat': did you mean 'update'?"},
        {"daft.input.mouse.wheeel()", "error: daft.input.mouse has no 'wheeel': did you mean 'wheel'?"},
        {"daft.entity { sphere = 1,\n  postion = {1, 2, 3} }",
         "main.lua:6: error: daft.entity: its table: there is no 'postion': did you mean 'position'?"},
        {"daft.entity { visible = SETTING == 3 and true or false,\n frction = 2 }",
         "main.lua:6: error: daft.entity: its table: there is no 'frction'"},
        {"ball:puhs(1, 2, 3)", "warning: nothing has a method 'puhs': did you mean 'push'?"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_status(check_body(cases[i].body), 1, output);
        assert_says(output, cases[i].said);
        if (!strstr(output, ": 1 error, 0 warnings") && !strstr(output, ": 0 errors, 1 warning"))
            fail_msg("one problem expected:\n%s", output);
    }
}

static void right_code_is_left_alone(void **unused)
{
    (void)unused;
    static const char *const bodies[] = {
        "ball:push(1, 2, 3) return M:own(('x'):upper())",
        "local f = daft.entity\nlocal t = { foo = 1 }\nf(t)",
        "local d = M if SETTING then d = daft end return d.anything",
        "local d = daft while SETTING do if d.own then d = M end end",
        "daft.camera.look { from = {0, 0, 0}, at = ball, fov = 1, teleport = true }",
        "local prnt = print prnt('x', ...) local _ENV = { foo = 1 } return foo",
        "M.later = M.other M.puhs = print M:puhs() wait(1) wait_until(never) return daft.load, daft.draw",
        "daft.material { color = '#fff' } daft.light.sun { direction = {0, -1, 0} } daft.sound { wave = 'sine' }",
        "local t = {} t.x, t.y = 1, 2 daft.text('a', t.x, t.y, { size = 1 }) return math.pi, string.format, utf8, _G"};
    for (size_t i = 0; i < sizeof bodies / sizeof bodies[0]; i++) {
        assert_status(check_body(bodies[i]), 0, output);
        assert_says(output, "0 errors, 0 warnings");
    }
}

static void files_that_nothing_names_are_noted(void **unused)
{
    (void)unused;
    write_text("bell.wav", "RIFF");
    write_text("horn.wav", "RIFF");
    assert_status(check_body("return daft.sound('bell.wav')"), 0, output);
    assert_says(output, "horn.wav: note: no script or scene of the game names this file");
    assert_null(strstr(output, "bell.wav: note"));
}

static int make_folder(void **unused)
{
    (void)unused;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **unused)
{
    (void)unused;
    char command[256];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(names_that_nothing_has_are_told),
                                       cmocka_unit_test(right_code_is_left_alone),
                                       cmocka_unit_test(files_that_nothing_names_are_noted)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
