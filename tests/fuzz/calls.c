/* Any bytes as calls of every function of daft.h, in any order, with arguments that are good, odd or bad: handles of
 * things that are gone, numbers that are not finite, wrong cookies, NULLs. Then a tick and a picture. */
#include "fuzz.h"

#include "calls.h"

#include <string.h>

enum { CALLS_AT_MOST = 300 };

/* Those that wait for the disk say nothing new. */
static bool waits_for_disk(const char *function)
{
    return strstr(function, "_write") != NULL && strstr(function, "_writer_put") == NULL;
}

static char folder[64];

static void remove_folder(void) { calls_folder_remove(folder); }

static const char *get_folder(void)
{
    if (folder[0]) return folder;
    calls_folder_make(folder);
    atexit(remove_folder);
    return folder;
}

int calls_input(const uint8_t *data, size_t size)
{
    static caller c;
    c = (caller){.folder = get_folder()};
    caller_open(&c);
    caller_feed(&c, data, size);
    for (int i = 0; i < CALLS_AT_MOST && c.byte_count > 1; i++) {
        size_t index = *c.bytes % CALL_COUNT;
        c.bytes++, c.byte_count--;
        if (!waits_for_disk(CALLS[index].function)) caller_make(&c, index);
        if (CALLS[index].reports && !c.succeeded && c.error.code != DAFT_OK) fuzz_check_error(false, &c.error);
    }
    daft_view view = daft_default_view();
    daft_error error = {0};
    FUZZ_CHECK(daft_scene_step(c.scene, 1.0f / 60, &error));
    FUZZ_CHECK(daft_render(c.scene, &view, c.image, &error));
    caller_close(&c);
    return 0;
}
