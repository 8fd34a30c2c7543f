/* Opens the engine and the font, which several commands need. */
#include "cli/commands.h"

#include "common/util.h"

#include <stdio.h>

static void print_warning(void *unused, const daft_error *warning)
{
    (void)unused;
    char text[1200];
    fprintf(stderr, "warning: %s\n", daft_error_text(warning, text, sizeof text));
}

daft_engine *try_engine(const daft_engine_def *wanted, daft_error *error)
{
    daft_engine_def def = *wanted;
    if (!def.warn) def.warn = print_warning;
    return daft_engine_create(&def, error);
}

daft_engine *open_engine(const daft_engine_def *wanted)
{
    daft_error error;
    daft_engine *engine = try_engine(wanted, &error);
    if (!engine) report(&error);
    return engine;
}

font *open_font(const home *where, daft_error *error)
{
    char path[PATH_SIZE];
    if (path_join(path, sizeof path, where->assets, "fonts/daft.ttf")) return font_open(NULL, NULL, path, path, error);
    fail(error, DAFT_ERROR_IO, "the path of assets/ is too long");
    return NULL;
}
