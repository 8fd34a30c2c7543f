/* The files of one game. */
#include "common/source.h"

bool source_open(game_source *out, const home *where, const game_info *game, daft_error *error)
{
    *out = (game_source){0};
    daft_root roots[3];
    daft_files_def def = daft_default_files_def();
    def.roots = roots;
    def.max_file_bytes = (uint64_t)512 << 20; /* half of the memory that a game may hold */
    roots[def.root_count++] = (daft_root){.folder = game->folder};
    if (path_is_folder(where->assets)) roots[def.root_count++] = (daft_root){.folder = where->assets};
    roots[def.root_count++] = (daft_root){.folder = where->scripts};
    out->files = daft_files_create(&def, error);
    return out->files != NULL;
}

void source_close(game_source *source)
{
    daft_files_destroy(source->files);
    source->files = NULL;
}
