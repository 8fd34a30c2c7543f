/* A window and gamepads by SDL2; screen.c puts the pictures into it. F11 and Alt+Enter concern only the window and are
 * handled here. */
#include "platform/platform.h"

#include "common/util.h"
#include "platform/screen.h"

#include <SDL.h>
#include <ctype.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct sdl_platform {
    platform face;
    SDL_Window *window;
    screen shows;
    pthread_mutex_t lock; /* around every use of SDL: leave_waits_sdl comes from another thread */
    SDL_GameController *pads[4];
    bool grabbed;
    char typed[SDL_TEXTINPUTEVENT_TEXT_SIZE]; /* letters that are still to be told, from */
    const char *typed_next;                   /* here on; NULL: none */
    bool console;                             /* the last key to go down was that of the console */
    bool any_thread;                          /* this display's events may be fetched on any thread, one at a time */
    uint64_t last_frame_ns;
} sdl_platform;

/* The platform, with its lock taken; every use of it ends with unlock. */
static sdl_platform *lock(platform *self)
{
    sdl_platform *sdl = (sdl_platform *)self;
    pthread_mutex_lock(&sdl->lock);
    return sdl;
}

static void unlock(sdl_platform *sdl) { pthread_mutex_unlock(&sdl->lock); }

static void close_sdl(platform *self)
{
    sdl_platform *sdl = (sdl_platform *)self;
    for (size_t i = 0; i < COUNT_OF(sdl->pads); i++)
        if (sdl->pads[i]) SDL_GameControllerClose(sdl->pads[i]);
    screen_close(&sdl->shows);
    if (sdl->window) SDL_DestroyWindow(sdl->window);
    SDL_Quit();
    pthread_mutex_destroy(&sdl->lock);
    free(sdl);
}

static int find_key(const char *name)
{
    char lower[32];
    size_t length = 0;
    for (; name[length] && length + 1 < sizeof lower; length++)
        lower[length] = (char)tolower((unsigned char)name[length]);
    lower[length] = 0;
    return input_key_find(lower);
}

/* By its label on this keyboard, or by its place where that is unknown: other alphabets. */
static int letter_of(const SDL_Keysym *symbol)
{
    const int key = find_key(SDL_GetKeyName(symbol->sym));
    return key >= 0 ? key : find_key(SDL_GetScancodeName(symbol->scancode));
}

/* What prints a sign by its place, so that W A S D are where a hand expects them; what does not by what it is here, so
 * that who has swapped Esc and Caps Lock finds them swapped. */
static int key_of(const SDL_Keysym *symbol)
{
    const bool prints = symbol->sym > SDLK_SPACE && symbol->sym < SDLK_DELETE;
    const bool foreign = symbol->sym > SDLK_DELETE && !(symbol->sym & SDLK_SCANCODE_MASK);
    const int key = prints || foreign ? find_key(SDL_GetScancodeName(symbol->scancode)) : -1;
    return key >= 0 ? key : letter_of(symbol);
}

static bool key_label_sdl(platform *self, const char *key, char *out, size_t size)
{
    sdl_platform *sdl = lock(self);
    const SDL_Scancode place = SDL_GetScancodeFromName(key);
    const char *label = SDL_GetKeyName(SDL_GetKeyFromScancode(place));
    const bool known = place != SDL_SCANCODE_UNKNOWN && label[0];
    if (known) snprintf(out, size, "%s", label);
    unlock(sdl);
    return known;
}

/* Left is 1, middle 2, right 3, as in SDL. */
static int button_of(Uint8 button)
{
    char name[16];
    snprintf(name, sizeof name, "mouse%u", (unsigned)button);
    return input_key_find(name);
}

static bool is_full_screen(sdl_platform *sdl)
{
    return (SDL_GetWindowFlags(sdl->window) & SDL_WINDOW_FULLSCREEN_DESKTOP) != 0;
}

static void toggle_fullscreen(sdl_platform *sdl)
{
    SDL_SetWindowFullscreen(sdl->window, is_full_screen(sdl) ? 0 : SDL_WINDOW_FULLSCREEN_DESKTOP);
}

static bool full_screen_sdl(platform *self, int wish)
{
    sdl_platform *sdl = lock(self);
    if (wish >= 0 && is_full_screen(sdl) != (wish > 0)) toggle_fullscreen(sdl);
    const bool full = is_full_screen(sdl);
    unlock(sdl);
    return full;
}

static bool key_event(sdl_platform *sdl, const SDL_KeyboardEvent *event, input_event *out)
{
    if (event->repeat) return false;
    bool down = event->type == SDL_KEYDOWN;
    SDL_Keycode key = event->keysym.sym;
    if (down && (key == SDLK_F11 || (key == SDLK_RETURN && (event->keysym.mod & KMOD_ALT)))) {
        toggle_fullscreen(sdl);
        return false;
    }
    *out = (input_event){
        .kind = INPUT_KEY, .key = key_of(&event->keysym), .letter = 1 + letter_of(&event->keysym), .down = down};
    return out->key >= 0;
}

/* A key of the keyboard, of which that left of 1 is the console's, by its place. */
static bool keyboard_event(sdl_platform *sdl, const SDL_KeyboardEvent *event, platform_event *out)
{
    const bool down = event->type == SDL_KEYDOWN, console = event->keysym.scancode == SDL_SCANCODE_GRAVE;
    if (down) sdl->console = console;
    if (!console) return key_event(sdl, event, &out->input);
    out->kind = PLATFORM_CONSOLE;
    return down && !event->repeat;
}

static bool mouse_event(sdl_platform *sdl, const SDL_Event *event, input_event *out)
{
    int width, height;
    SDL_GetWindowSize(sdl->window, &width, &height);
    switch (event->type) {
    case SDL_MOUSEMOTION:
        *out = (input_event){.kind = INPUT_MOVE,
                             .x = (float)event->motion.x / (float)width,
                             .y = (float)event->motion.y / (float)height};
        if (sdl->grabbed)
            *out = (input_event){.kind = INPUT_MOTION,
                                 .x = (float)event->motion.xrel / (float)width,
                                 .y = (float)event->motion.yrel / (float)height};
        return true;
    case SDL_MOUSEWHEEL:
        *out = (input_event){.kind = INPUT_WHEEL, .x = (float)event->wheel.x, .y = (float)event->wheel.y};
        return true;
    default:
        *out = (input_event){
            .kind = INPUT_KEY, .key = button_of(event->button.button), .down = event->type == SDL_MOUSEBUTTONDOWN};
        return out->key >= 0;
    }
}

/* ---- gamepads ---- */

static void plug_in(sdl_platform *sdl, int number)
{
    for (size_t i = 0; i < COUNT_OF(sdl->pads); i++) {
        if (sdl->pads[i]) continue;
        sdl->pads[i] = SDL_GameControllerOpen(number);
        return;
    }
}

/* What it held is let go, as when the window loses the focus. */
static bool pull_out(sdl_platform *sdl, SDL_JoystickID id)
{
    SDL_GameController *pad = SDL_GameControllerFromInstanceID(id);
    for (size_t i = 0; pad && i < COUNT_OF(sdl->pads); i++) {
        if (sdl->pads[i] != pad) continue;
        SDL_GameControllerClose(pad);
        sdl->pads[i] = NULL;
        return true;
    }
    return false;
}

static bool pad_button(const SDL_ControllerButtonEvent *event, input_event *out)
{
    if (event->button > SDL_CONTROLLER_BUTTON_DPAD_RIGHT) return false;
    *out = (input_event){
        .kind = INPUT_KEY, .key = input_key_find("pad a") + event->button, .down = event->state == SDL_PRESSED};
    return true;
}

/* Near its middle a stick says nothing: few rest exactly there. */
static bool pad_axis(const SDL_ControllerAxisEvent *event, input_event *out)
{
    const float dead = 0.15f, value = (float)event->value / 32767;
    float x = fabsf(value) <= dead ? 0 : (fabsf(value) - dead) / (1 - dead);
    if (event->axis >= INPUT_STICKS) return false;
    *out = (input_event){.kind = INPUT_STICK, .key = event->axis, .x = copysignf(x < 1 ? x : 1, value)};
    if (x == 0) out->x = 0;
    return true;
}

static bool pad_event(sdl_platform *sdl, const SDL_Event *event, platform_event *out)
{
    switch (event->type) {
    case SDL_CONTROLLERDEVICEADDED: plug_in(sdl, event->cdevice.which); return false;
    case SDL_CONTROLLERDEVICEREMOVED: out->kind = PLATFORM_FOCUS_LOST; return pull_out(sdl, event->cdevice.which);
    case SDL_CONTROLLERBUTTONDOWN:
    case SDL_CONTROLLERBUTTONUP: return pad_button(&event->cbutton, &out->input);
    case SDL_CONTROLLERAXISMOTION: return pad_axis(&event->caxis, &out->input);
    default: return false;
    }
}

static bool drop_event(const SDL_DropEvent *event, platform_event *out)
{
    int length = snprintf(out->path, sizeof out->path, "%s", event->file);
    SDL_free(event->file);
    out->kind = PLATFORM_DROP;
    return length > 0 && (size_t)length < sizeof out->path;
}

/* One letter of those that came together. */
static bool typed_event(sdl_platform *sdl, input_event *out)
{
    while (sdl->typed_next) {
        const uint32_t code = utf8_next(&sdl->typed_next);
        if (code == 0) sdl->typed_next = NULL;
        *out = (input_event){.kind = INPUT_TEXT, .key = (int)code};
        if (input_is_text(out->key) && code != 0xFFFD) return true;
    }
    return false;
}

static bool next_event(sdl_platform *sdl, platform_event *out)
{
    out->kind = PLATFORM_INPUT;
    if (typed_event(sdl, &out->input)) return true;
    for (SDL_Event event; SDL_PollEvent(&event);) {
        out->kind = PLATFORM_INPUT;
        switch (event.type) {
        case SDL_QUIT: out->kind = PLATFORM_CLOSE; return true;
        case SDL_WINDOWEVENT:
            if (event.window.event != SDL_WINDOWEVENT_FOCUS_LOST) break;
            out->kind = PLATFORM_FOCUS_LOST;
            return true;
        case SDL_KEYDOWN:
        case SDL_KEYUP:
            if (keyboard_event(sdl, &event.key, out)) return true;
            break;
        case SDL_TEXTINPUT:
            if (sdl->console) break;
            memcpy(sdl->typed, event.text.text, sizeof sdl->typed);
            sdl->typed[sizeof sdl->typed - 1] = 0, sdl->typed_next = sdl->typed;
            if (typed_event(sdl, &out->input)) return true;
            break;
        case SDL_MOUSEMOTION:
        case SDL_MOUSEWHEEL:
        case SDL_MOUSEBUTTONDOWN:
        case SDL_MOUSEBUTTONUP:
            if (mouse_event(sdl, &event, &out->input)) return true;
            break;
        case SDL_CONTROLLERDEVICEADDED:
        case SDL_CONTROLLERDEVICEREMOVED:
        case SDL_CONTROLLERBUTTONDOWN:
        case SDL_CONTROLLERBUTTONUP:
        case SDL_CONTROLLERAXISMOTION:
            if (pad_event(sdl, &event, out)) return true;
            break;
        case SDL_DROPFILE:
            if (drop_event(&event.drop, out)) return true;
            break;
        default: break;
        }
    }
    return false;
}

static bool poll_sdl(platform *self, platform_event *out)
{
    sdl_platform *sdl = lock(self);
    bool found = next_event(sdl, out);
    unlock(sdl);
    return found;
}

static bool leave_waits_sdl(platform *self)
{
    enum { MOST_KEYS = 128 };
    sdl_platform *sdl = (sdl_platform *)self;
    SDL_Event keys[MOST_KEYS];
    if (!sdl->any_thread || pthread_mutex_trylock(&sdl->lock) != 0) return false;
    SDL_PumpEvents();
    int count = SDL_PeepEvents(keys, MOST_KEYS, SDL_PEEKEVENT, SDL_KEYDOWN, SDL_KEYDOWN);
    bool waits = SDL_HasEvent(SDL_QUIT);
    for (int i = 0; i < count; i++) waits |= keys[i].key.keysym.sym == SDLK_ESCAPE;
    unlock(sdl);
    return waits;
}

static void hide_sdl(platform *self)
{
    enum { TRIES_MS = 50 }; /* the other thread may hang in SDL */
    sdl_platform *sdl = (sdl_platform *)self;
    for (int i = 0; pthread_mutex_trylock(&sdl->lock) != 0; i++) {
        if (i == TRIES_MS) return;
        SDL_Delay(1);
    }
    SDL_HideWindow(sdl->window);
    unlock(sdl);
}

static void size_sdl(platform *self, int *width, int *height)
{
    sdl_platform *sdl = lock(self);
    if (!screen_size(&sdl->shows, width, height)) *width = 1280, *height = 720;
    unlock(sdl);
    if (*width < 1) *width = 1;
    if (*height < 1) *height = 1;
}

static bool wants_frame_sdl(platform *self)
{
    sdl_platform *sdl = lock(self);
    bool seen = !(SDL_GetWindowFlags(sdl->window) & (SDL_WINDOW_MINIMIZED | SDL_WINDOW_HIDDEN));
    unlock(sdl);
    return seen;
}

static bool present_sdl(platform *self, const daft_image *picture, daft_error *error)
{
    sdl_platform *sdl = lock(self);
    bool good = screen_show(&sdl->shows, picture, error);
    unlock(sdl);
    return good;
}

/* Without vertical sync, limits the loop to 60 pictures a second. */
static void end_frame_sdl(platform *self)
{
    sdl_platform *sdl = (sdl_platform *)self;
    const uint64_t frame = 1000000000u / 60;
    uint64_t passed = clock_now_ns() - sdl->last_frame_ns;
    if ((!sdl->shows.vsync || !wants_frame_sdl(self)) && passed + 1000000u < frame)
        SDL_Delay((Uint32)((frame - passed) / 1000000u));
    sdl->last_frame_ns = clock_now_ns();
}

static uint64_t now_sdl(platform *self)
{
    (void)self;
    return clock_now_ns();
}

static void set_title_sdl(platform *self, const char *title)
{
    sdl_platform *sdl = lock(self);
    SDL_SetWindowTitle(sdl->window, title);
    unlock(sdl);
}

static void resize_sdl(platform *self, int width, int height)
{
    sdl_platform *sdl = lock(self);
    SDL_SetWindowSize(sdl->window, width, height);
    unlock(sdl);
}

static void set_icon_sdl(platform *self, daft_image *icon)
{
    const int width = daft_image_width(icon), height = daft_image_height(icon);
    sdl_platform *sdl = lock(self);
    SDL_Surface *surface = SDL_CreateRGBSurfaceWithFormatFrom(daft_image_pixels(icon), width, height, 32, 4 * width,
                                                              SDL_PIXELFORMAT_RGBA32);
    if (surface) SDL_SetWindowIcon(sdl->window, surface);
    SDL_FreeSurface(surface);
    unlock(sdl);
}

static bool copy_sdl(platform *self, const char *text)
{
    sdl_platform *sdl = lock(self);
    const bool good = SDL_SetClipboardText(text) == 0;
    unlock(sdl);
    return good;
}

static bool paste_sdl(platform *self, char *out, size_t size)
{
    sdl_platform *sdl = lock(self);
    char *text = SDL_HasClipboardText() ? SDL_GetClipboardText() : NULL;
    if (text) snprintf(out, size, "%s", text);
    SDL_free(text);
    unlock(sdl);
    return text != NULL;
}

static void rumble_sdl(platform *self, float strength, double seconds)
{
    sdl_platform *sdl = lock(self);
    const Uint16 force = (Uint16)(strength * 65535);
    for (size_t i = 0; i < COUNT_OF(sdl->pads); i++)
        if (sdl->pads[i]) SDL_GameControllerRumble(sdl->pads[i], force, force, (Uint32)(seconds * 1000));
    unlock(sdl);
}

static void grab_sdl(platform *self, bool grab)
{
    sdl_platform *sdl = lock(self);
    sdl->grabbed = SDL_SetRelativeMouseMode(grab ? SDL_TRUE : SDL_FALSE) == 0 && grab;
    unlock(sdl);
}

/* On Linux SDL may draw on a console that nobody watches: without a display server there is no window. */
static bool has_display(void)
{
#if defined(__linux__) || defined(__FreeBSD__)
    const char *const names[] = {"DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        const char *value = getenv(names[i]);
        if (value && value[0]) return true;
    }
    return false;
#else
    return true;
#endif
}

static bool open_window(sdl_platform *sdl, const char *title, int width, int height)
{
    SDL_SetHint(SDL_HINT_VIDEO_X11_NET_WM_BYPASS_COMPOSITOR, "0");
    if (SDL_InitSubSystem(SDL_INIT_VIDEO) != 0) return false;
    SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER); /* without gamepads it goes on */
    sdl->window = SDL_CreateWindow(title, SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, width, height,
                                   SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI);
    if (!sdl->window) return false;
    SDL_SetWindowMinimumSize(sdl->window, 320, 180);
    if (!screen_open(&sdl->shows, sdl->window)) return false;
    /* Elsewhere the system hands events to the thread that made the window. */
    const char *driver = SDL_GetCurrentVideoDriver();
    sdl->any_thread = driver && (strcmp(driver, "x11") == 0 || strcmp(driver, "wayland") == 0);
    return true;
}

platform *platform_open_sdl(const char *title, int width, int height, daft_error *error)
{
    if (!has_display()) {
        fail(error, DAFT_ERROR_UNSUPPORTED, "neither DISPLAY nor WAYLAND_DISPLAY is set");
        return NULL;
    }
    sdl_platform *sdl = calloc(1, sizeof *sdl);
    if (!sdl) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory");
        return NULL;
    }
    sdl->face = (platform){.close = close_sdl,
                           .poll = poll_sdl,
                           .get_size = size_sdl,
                           .wants_frame = wants_frame_sdl,
                           .present = present_sdl,
                           .end_frame = end_frame_sdl,
                           .now_ns = now_sdl,
                           .set_title = set_title_sdl,
                           .set_size = resize_sdl,
                           .set_icon = set_icon_sdl,
                           .copy = copy_sdl,
                           .paste = paste_sdl,
                           .full_screen = full_screen_sdl,
                           .rumble = rumble_sdl,
                           .key_label = key_label_sdl,
                           .grab_mouse = grab_sdl,
                           .hide = hide_sdl,
                           .leave_waits = leave_waits_sdl};
    pthread_mutex_init(&sdl->lock, NULL);
    if (!open_window(sdl, title, width, height)) {
        fail(error, DAFT_ERROR_UNSUPPORTED, "%s", SDL_GetError());
        close_sdl(&sdl->face);
        return NULL;
    }
    return &sdl->face;
}
