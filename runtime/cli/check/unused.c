/* Files of a game that nothing names: not its scripts, nor its scenes, materials and meshes. */
#include "cli/check/check.h"

#include "common/util.h"

#include <stdlib.h>
#include <string.h>

typedef struct text {
    const char *path;
    char *bytes;
    size_t size;
} text;

static bool has_any(const char *path, const char *const *extensions, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (has_extension(path, extensions[i])) return true;
    return false;
}

/* What may name other files. */
static bool names_files(const char *path)
{
    static const char *const EXTENSIONS[] = {".lua", ".scene", ".mtl", ".obj", ".gltf"};
    return has_any(path, EXTENSIONS, COUNT_OF(EXTENSIONS));
}

/* What is loaded by its name. main.lua, tests and what they look at are not. */
static bool is_asset(const checker *c, const char *path)
{
    static const char *const OTHERS[] = {".lua", ".rec"};
    const size_t length = strlen(c->path);
    return !has_any(path, OTHERS, COUNT_OF(OTHERS)) &&
           !(strncmp(path, c->path, length) == 0 && strncmp(path + length, "/tests/", 7) == 0);
}

/* The name without folder and extension, as scripts may give it. */
static void stem_of(const char *path, char *out, size_t size)
{
    path_base_name(path, out, size);
    char *dot = strrchr(out, '.');
    if (dot && dot != out) *dot = 0;
}

static bool is_named(const text *texts, size_t count, const char *path)
{
    char stem[256];
    stem_of(path, stem, sizeof stem);
    for (size_t i = 0; i < count; i++)
        if (strcmp(texts[i].path, path) != 0 && memmem(texts[i].bytes, texts[i].size, stem, strlen(stem))) return true;
    return false;
}

/* The texts of all files that may name others; those that cannot be read have been reported. */
static size_t read_texts(const checker *c, text *out)
{
    size_t count = 0;
    for (size_t i = 0; i < c->own_count; i++) {
        daft_error error;
        text *t = &out[count];
        if (!names_files(c->own[i])) continue;
        t->path = c->own[i];
        t->bytes = daft_read_file(c->game.files, c->own[i], &t->size, &error);
        count += t->bytes != NULL;
    }
    return count;
}

void check_unused(checker *c)
{
    text *texts = calloc(c->own_count + 1, sizeof *texts);
    size_t count = texts ? read_texts(c, texts) : 0;
    for (size_t i = 0; texts && i < c->own_count; i++)
        if (is_asset(c, c->own[i]) && !is_named(texts, count, c->own[i]))
            check_add(c, DAFT_SEVERITY_NOTE, c->own[i], 0, 0,
                      "no script or scene of the game names this file (names put together from parts are not seen)");
    for (size_t i = 0; i < count; i++) free(texts[i].bytes);
    free(texts);
}
