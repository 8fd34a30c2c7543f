/* The files of one game. */
#include "files/source.h"

#include <stdlib.h>

/* Half of the memory that a game may hold. */
static const uint64_t MAX_FILE = (uint64_t)512 << 20;

static bool open_pack(game_source *out, const game_info *game, daft_error *error)
{
    size_t size;
    sha256 hash;
    out->bytes = daft_read_file(NULL, game->folder, &size, error);
    if (!out->bytes) return false;
    sha256_begin(&hash);
    sha256_add(&hash, out->bytes, size);
    sha256_end(&hash, out->hash);
    out->packed = pack_open(out->bytes, size, game->folder, error);
    return out->packed != NULL;
}

static daft_root own_root(const game_source *source, const game_info *game)
{
    daft_root root = {.folder = game->folder};
    if (source->packed) root.read = pack_read, root.list = pack_list, root.user = source->packed;
    return root;
}

bool source_open_alone(game_source *out, const game_info *game, daft_error *error)
{
    *out = (game_source){0};
    bool good = !game->packed || open_pack(out, game, error);
    daft_root root = own_root(out, game);
    daft_files_def def = daft_default_files_def();
    def.roots = &root, def.root_count = 1, def.max_file_bytes = MAX_FILE;
    out->own = good ? daft_files_create(&def, error) : NULL;
    if (!out->own) source_close(out);
    return out->own != NULL;
}

bool source_open(game_source *out, const home *where, const game_info *game, daft_error *error)
{
    if (!source_open_alone(out, game, error)) return false;
    daft_root roots[3];
    daft_files_def def = daft_default_files_def();
    def.roots = roots, def.max_file_bytes = MAX_FILE;
    roots[def.root_count++] = own_root(out, game);
    if (path_is_folder(where->assets)) roots[def.root_count++] = (daft_root){.folder = where->assets};
    roots[def.root_count++] = (daft_root){.folder = where->scripts};
    out->files = daft_files_create(&def, error);
    if (!out->files) source_close(out);
    return out->files != NULL;
}

void source_close(game_source *source)
{
    daft_files_destroy(source->files);
    daft_files_destroy(source->own);
    pack_close(source->packed);
    free(source->bytes);
    *source = (game_source){0};
}
