/* runtime: keys by their places, whatever is printed on them; and gamepads, by one that SDL pretends there is: plugged
 * in while the window is open, its buttons, sticks and dead zone, and pulled out while it holds something. */
#include "platform/platform.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <SDL.h>
#include <math.h>

/* All that has happened, applied to `keys`. Whether something was let go. */
static bool take(platform *screen, input *keys)
{
    bool lost = false;
    platform_event event;
    SDL_JoystickUpdate();
    while (screen->poll(screen, &event)) {
        lost |= event.kind == PLATFORM_FOCUS_LOST;
        if (event.kind == PLATFORM_INPUT) input_push(keys, &event.input);
    }
    if (lost) input_push_release_all(keys);
    input_begin_tick(keys);
    input_apply_queue(keys);
    return lost;
}

static float stick(const input *keys, const char *name) { return keys->stick[input_stick_find(name)]; }
static bool down(const input *keys, const char *name) { return keys->down[input_key_find(name)]; }

static void a_gamepad_is_keys_and_sticks(void **unused)
{
    (void)unused;
    daft_error error;
    input keys = {0};
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    platform *screen = platform_open_sdl("gamepad", 320, 180, &error);
    if (!screen) fail_msg("%s", error.message);
    int number = SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, SDL_CONTROLLER_AXIS_MAX,
                                           SDL_CONTROLLER_BUTTON_MAX, 0);
    if (number < 0) { /* an SDL before 2.0.14 */
        screen->close(screen);
        skip();
    }
    take(screen, &keys); /* it is found, */
    take(screen, &keys); /* and opened */
    SDL_Joystick *pad = SDL_JoystickOpen(number);
    assert_non_null(pad);
    SDL_JoystickSetVirtualButton(pad, SDL_CONTROLLER_BUTTON_A, 1);
    SDL_JoystickSetVirtualButton(pad, SDL_CONTROLLER_BUTTON_DPAD_LEFT, 1);
    SDL_JoystickSetVirtualAxis(pad, SDL_CONTROLLER_AXIS_LEFTX, 32767);
    SDL_JoystickSetVirtualAxis(pad, SDL_CONTROLLER_AXIS_LEFTY, -32768);
    SDL_JoystickSetVirtualAxis(pad, SDL_CONTROLLER_AXIS_RIGHTX, 3000); /* within the dead zone */
    SDL_JoystickSetVirtualAxis(pad, SDL_CONTROLLER_AXIS_RIGHTY, 16384);
    assert_false(take(screen, &keys));
    assert_true(down(&keys, "pad a") && down(&keys, "pad left") && !down(&keys, "pad b"));
    assert_true(keys.pressed[input_key_find("pad a")]);
    assert_true(stick(&keys, "left x") == 1 && stick(&keys, "left y") == -1 && stick(&keys, "right x") == 0);
    assert_true(fabsf(stick(&keys, "right y") - 0.35f / 0.85f) < 1e-3f);
    SDL_JoystickSetVirtualButton(pad, SDL_CONTROLLER_BUTTON_A, 0);
    SDL_JoystickSetVirtualAxis(pad, SDL_CONTROLLER_AXIS_RIGHTY, 0);
    take(screen, &keys);
    assert_true(!down(&keys, "pad a") && keys.released[input_key_find("pad a")] && stick(&keys, "right y") == 0);
    SDL_JoystickClose(pad);
    SDL_JoystickDetachVirtual(number);
    assert_true(take(screen, &keys)); /* what it held is let go */
    assert_true(!down(&keys, "pad left") && stick(&keys, "left x") == 0);
    screen->close(screen);
}

/* What the window hears when the key with this sign on it, in this place, is pressed. */
static input_event pressed(platform *screen, SDL_Keycode sign, SDL_Scancode place)
{
    SDL_Event event = {.key = {.type = SDL_KEYDOWN, .state = SDL_PRESSED, .keysym = {.scancode = place, .sym = sign}}};
    platform_event out;
    input_event heard = {.kind = INPUT_WHEEL};
    SDL_PushEvent(&event);
    while (screen->poll(screen, &out)) /* to the end: SDL marks it */
        if (out.kind == PLATFORM_INPUT && out.input.kind == INPUT_KEY) heard = out.input;
    assert_int_equal(heard.kind, INPUT_KEY);
    return heard;
}

/* On a French keyboard, a Russian one, and one whose Caps Lock is Esc. */
static void keys_are_places(void **unused)
{
    (void)unused;
    static const struct {
        SDL_Keycode sign;
        SDL_Scancode place;
        const char *key, *letter;
    } CASES[] = {{SDLK_q, SDL_SCANCODE_A, "a", "q"},
                 {SDLK_z, SDL_SCANCODE_W, "w", "z"},
                 {SDLK_AMPERSAND, SDL_SCANCODE_1, "1", "1"},
                 {SDLK_m, SDL_SCANCODE_SEMICOLON, ";", "m"},
                 {0x444, SDL_SCANCODE_A, "a", "a"},
                 {SDLK_ESCAPE, SDL_SCANCODE_CAPSLOCK, "escape", "escape"},
                 {SDLK_LEFT, SDL_SCANCODE_LEFT, "left", "left"},
                 {SDLK_SPACE, SDL_SCANCODE_SPACE, "space", "space"},
                 {SDLK_KP_5, SDL_SCANCODE_KP_5, "keypad 5", "keypad 5"}};
    daft_error error;
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    platform *screen = platform_open_sdl("keys", 320, 180, &error);
    if (!screen) fail_msg("%s", error.message);
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        const input_event event = pressed(screen, CASES[i].sign, CASES[i].place);
        assert_string_equal(input_key_name(event.key), CASES[i].key);
        assert_string_equal(input_key_name(input_letter(&event)), CASES[i].letter);
    }
    char label[32];
    assert_true(screen->key_label(screen, "left shift", label, sizeof label));
    assert_string_equal(label, "Left Shift");
    assert_true(screen->key_label(screen, "a", label, sizeof label));
    assert_string_equal(label, "A"); /* without a display the keyboard is a US one */
    assert_false(screen->key_label(screen, "mouse1", label, sizeof label));
    screen->close(screen);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_gamepad_is_keys_and_sticks),
                                       cmocka_unit_test(keys_are_places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
