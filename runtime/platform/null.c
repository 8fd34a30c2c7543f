/* No window: no events, and a clock that advances by one update a frame. */
#include "platform/platform.h"

#include "common/util.h"

#include <stdlib.h>

typedef struct null_platform {
    platform face;
    int width, height;
    uint64_t frames, rate;
} null_platform;

static void close_null(platform *self) { free(self); }

static bool poll_null(platform *self, platform_event *out)
{
    (void)self, (void)out;
    return false;
}

static void size_null(platform *self, int *width, int *height)
{
    *width = ((null_platform *)self)->width;
    *height = ((null_platform *)self)->height;
}

static bool wants_frame_null(platform *self)
{
    (void)self;
    return false;
}

static bool present_null(platform *self, const daft_image *picture, daft_error *error)
{
    (void)self, (void)picture, (void)error;
    return true;
}

static void end_frame_null(platform *self) { ((null_platform *)self)->frames++; }

/* Rounded up, so that exactly one update is due at each frame. */
static uint64_t now_null(platform *self)
{
    const null_platform *null = (null_platform *)self;
    return (null->frames * 1000000000u + null->rate - 1) / null->rate;
}

static void set_title_null(platform *self, const char *title) { (void)self, (void)title; }
static void grab_null(platform *self, bool grab) { (void)self, (void)grab; }
static void hide_null(platform *self) { (void)self; }

platform *platform_open_null(int width, int height, int rate, daft_error *error)
{
    null_platform *made = malloc(sizeof *made);
    if (!made) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory");
        return NULL;
    }
    *made = (null_platform){.face = {.headless = true,
                                     .close = close_null,
                                     .poll = poll_null,
                                     .get_size = size_null,
                                     .wants_frame = wants_frame_null,
                                     .present = present_null,
                                     .end_frame = end_frame_null,
                                     .now_ns = now_null,
                                     .set_title = set_title_null,
                                     .grab_mouse = grab_null,
                                     .hide = hide_null},
                            .width = width,
                            .height = height,
                            .rate = (uint64_t)rate};
    return &made->face;
}
