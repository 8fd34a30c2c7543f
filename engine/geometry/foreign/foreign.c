/* Whether a file is one for Assimp. */
#include "geometry/foreign/foreign.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

/* ---- what a file is ---- */

static bool begins(const void *bytes, size_t size, const char *mark)
{
    return size >= strlen(mark) && memcmp(bytes, mark, strlen(mark)) == 0;
}

static bool contains(const char *text, size_t size, const char *mark)
{
    const size_t length = strlen(mark);
    for (size_t i = 0; i + length <= size; i++)
        if (memcmp(text + i, mark, length) == 0) return true;
    return false;
}

/* Triangles of 50 bytes after 84 of header, the last four of which say how many. */
static bool is_binary_stl(const uint8_t *b, size_t size)
{
    if (size < 84) return false;
    const uint64_t count = b[80] | (uint64_t)b[81] << 8 | (uint64_t)b[82] << 16 | (uint64_t)b[83] << 24;
    return count > 0 && size == 84 + 50 * count;
}

/* Formats that do not say what they are. */
static const char *by_name(const char *path)
{
    static const char *const known[] = {"3ds", "dae", "blend",   "lwo", "lxo", "ase", "x",   "ms3d",
                                        "md2", "md3", "md5mesh", "b3d", "ac",  "off", "ifc", "3mf",
                                        "dxf", "cob", "iqm",     "x3d", "fbx", "stl", "ply"};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < DAFT_COUNT_OF(known); i++)
        if (strcasecmp(dot + 1, known[i]) == 0) return known[i];
    return NULL;
}

const char *daft_foreign_format(const char *path, const void *bytes, size_t size)
{
    const char *text = bytes;
    const size_t head = size < 4096 ? size : 4096;
    size_t blanks = 0;
    while (blanks < head && isspace((unsigned char)text[blanks])) blanks++;
    if (begins(bytes, size, "glTF")) return "glb";
    if (begins(bytes, size, "Kaydara FBX Binary") || begins(bytes, size, "; FBX")) return "fbx";
    if (begins(bytes, size, "ply\n") || begins(bytes, size, "ply\r")) return "ply";
    if (is_binary_stl(bytes, size) || (begins(bytes, size, "solid") && contains(text, head, "facet"))) return "stl";
    if (blanks < head && text[blanks] == '{' && contains(text, size, "\"asset\"")) return "gltf";
    if (contains(text, head, "<COLLADA")) return "dae";
    return by_name(path);
}

bool daft_model_load(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                     daft_obj *out, daft_error *error)
{
    size_t size;
    char *bytes = daft_file_read(allocator, files, path, &size, error);
    if (!bytes) return false;
    if (!daft_foreign_format(path, bytes, size))
        return daft_obj_take(allocator, files, path, bytes, size, log, out, error);
    bool good = daft_foreign_parse(allocator, files, path, bytes, size, log, out, error);
    daft_release(allocator, bytes);
    return good;
}
