/* platform: a window, its events and its clock; or none. The rest of the runtime does not know which: headless is a
 * back end (platform_null.c), not an `if`. The null platform's clock moves by one update with each frame, so that a
 * game runs as fast as it can; it never asks for a picture by itself. */
#ifndef RUNTIME_PLATFORM_PLATFORM_H
#define RUNTIME_PLATFORM_PLATFORM_H

#include "daft.h"
#include "platform/input.h"

typedef enum platform_event_kind {
    PLATFORM_INPUT, /* a key, the mouse (x, y in shares of the window's width and height) or the wheel */
    PLATFORM_FOCUS_LOST,
    PLATFORM_CLOSE
} platform_event_kind;

typedef struct platform_event {
    platform_event_kind kind;
    input_event input;
} platform_event;

typedef struct platform platform;

struct platform {
    bool headless;
    void (*close)(platform *self);
    bool (*poll)(platform *self, platform_event *out);         /* false: no more for now */
    void (*get_size)(platform *self, int *width, int *height); /* of the window in pixels */
    bool (*wants_frame)(platform *self);                       /* whether anybody would see a picture now */
    bool (*present)(platform *self, const daft_image *picture, daft_error *error);
    void (*end_frame)(platform *self); /* after each turn of the loop, with a picture or without */
    uint64_t (*now_ns)(platform *self);
    void (*set_title)(platform *self, const char *title);
    void (*grab_mouse)(platform *self, bool grab); /* hidden, kept in the window; gives motions instead of places */
};

/* NULL with a message when there is no display or the window cannot be made. */
platform *platform_open_sdl(const char *title, int width, int height, daft_error *error);
platform *platform_open_null(int width, int height, daft_error *error);

#endif
