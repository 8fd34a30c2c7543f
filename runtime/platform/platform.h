/* platform: a window with its events and clock (sdl.c), or none (null.c), behind one table of functions; the state of
 * keys and mouse (input.h); the loudspeaker and sound files (audio.h); and what the process gives away once the window
 * is open (seal.h). Headless is a back end, not an `if`. Public headers: platform.h input.h actions.h audio.h seal.h
 * editor.h */
#ifndef RUNTIME_PLATFORM_PLATFORM_H
#define RUNTIME_PLATFORM_PLATFORM_H

#include "daft.h"
#include "platform/input.h"

typedef enum platform_event_kind {
    PLATFORM_INPUT,      /* a key, the mouse (x, y as fractions of the window) or the wheel */
    PLATFORM_FOCUS_LOST, /* or a gamepad was pulled out: what is held is let go */
    PLATFORM_CONSOLE,    /* the key left of 1 went down, whatever stands on it; its letter is not told */
    PLATFORM_DROP,       /* a file was dropped on the window: `path` */
    PLATFORM_CLOSE
} platform_event_kind;

enum { PLATFORM_PATH = 1024 };

typedef struct platform_event {
    platform_event_kind kind;
    input_event input;
    char path[PLATFORM_PATH]; /* of a dropped file; longer ones are not told */
} platform_event;

typedef struct platform platform;

struct platform {
    bool headless;
    void (*close)(platform *self);
    bool (*poll)(platform *self, platform_event *out);         /* false: the queue is empty */
    void (*get_size)(platform *self, int *width, int *height); /* of the window in pixels */
    bool (*wants_frame)(platform *self);                       /* false while the window is hidden */
    bool (*present)(platform *self, const daft_image *picture, daft_error *error);
    void (*end_frame)(platform *self); /* after each turn of the loop */
    uint64_t (*now_ns)(platform *self);
    void (*set_title)(platform *self, const char *title);
    /* In points of the screen, as the system grants them, while it does not fill the screen; NULL: it has none. */
    void (*set_size)(platform *self, int width, int height);
    void (*set_icon)(platform *self, daft_image *icon); /* NULL: nobody would see it */
    bool (*copy)(platform *self, const char *text);     /* to the clipboard; NULL: there is none */
    /* From the clipboard: at most size - 1 bytes. False: it holds no text. NULL: there is none. */
    bool (*paste)(platform *self, char *out, size_t size);
    /* 1 or 0: the window fills the screen from now on, or not; -1: only asks. Whether it does. NULL: it never does. */
    bool (*full_screen)(platform *self, int wish);
    void (*rumble)(platform *self, float strength, double seconds); /* of gamepads, 0 to 1; NULL: none can */
    /* What is printed on the key in the place that a US keyboard names so: "Q" on a French one for "a". False: it is
     * not known. NULL: there is no keyboard. */
    bool (*key_label)(platform *self, const char *key, char *out, size_t size);
    void (*grab_mouse)(platform *self, bool grab); /* hides and confines the mouse; events become relative motions */
    /* The window goes from sight. From any thread once leave_waits was true. */
    void (*hide)(platform *self);
    /* From any thread, while the thread of the others does something else: whether Esc or the window's close button
     * waits in the queue, where it stays. NULL, or never true, where only one thread may look. */
    bool (*leave_waits)(platform *self);
};

/* NULL with a message when there is no display or the window cannot be made. */
platform *platform_open_sdl(const char *title, int width, int height, daft_error *error);
/* No window: no events, and a clock that advances by 1/rate s with each frame, so a game runs as fast as possible. */
platform *platform_open_null(int width, int height, int rate, daft_error *error);

#endif
