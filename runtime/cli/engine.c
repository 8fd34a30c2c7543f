/* What several commands open: the engine and the font. */
#include "cli/commands.h"

#include "common/util.h"

#include <stdio.h>

static void print_warning(void *unused, const daft_error *warning)
{
    (void)unused;
    char text[1200];
    fprintf(stderr, "warning: %s\n", daft_error_text(warning, text, sizeof text));
}

daft_engine *open_engine(int threads, const char *isa, daft_accel accel)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads;
    def.isa = isa;
    def.accel = accel;
    def.warn = print_warning;
    daft_error error;
    daft_engine *engine = daft_engine_create(&def, &error);
    if (!engine) report(&error);
    return engine;
}

font *open_font(const home *where, daft_error *error)
{
    char path[PATH_SIZE];
    if (path_join(path, sizeof path, where->assets, "fonts/daft.ttf")) return font_open(path, error);
    fail(error, DAFT_ERROR_IO, "the path of assets/ is too long");
    return NULL;
}
