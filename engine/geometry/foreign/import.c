/* Finding Assimp, and reading for it. */
#include "geometry/foreign/assimp.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static bool find_all(daft_assimp *a)
{
    void *library = a->library;
    *(void **)&a->import = dlsym(library, "aiImportFileExWithProperties");
    *(void **)&a->release = dlsym(library, "aiReleaseImport");
    *(void **)&a->error = dlsym(library, "aiGetErrorString");
    *(void **)&a->color = dlsym(library, "aiGetMaterialColor");
    *(void **)&a->numbers = dlsym(library, "aiGetMaterialFloatArray");
    *(void **)&a->string = dlsym(library, "aiGetMaterialString");
    *(void **)&a->texture = dlsym(library, "aiGetMaterialTexture");
    return a->import && a->release && a->error && a->color && a->numbers && a->string && a->texture;
}

/* It stays in memory: opening it again costs nothing. */
static bool open_library(daft_assimp *out, const char *path, daft_error *error)
{
    *out = (daft_assimp){.library = dlopen(DAFT_ASSIMP_LIBRARY, RTLD_LAZY | RTLD_LOCAL)};
    if (out->library && find_all(out)) return true;
    return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                        "reading this format takes Assimp, and %s cannot be loaded: install libassimp5 (Debian)",
                        DAFT_ASSIMP_LIBRARY);
}

/* ---- files: the model's bytes are here, others that it names come through the loader ---- */

typedef struct source {
    const daft_allocator *allocator;
    const daft_files *files;
    const char *name; /* of the model, as Assimp is told it */
    const void *bytes;
    size_t size;
} source;

typedef struct handle {
    struct aiFile face;
    const source *from;
    const char *bytes;
    char *own; /* to be released */
    size_t size, at;
} handle;

static size_t read_bytes(struct aiFile *file, char *out, size_t size, size_t count)
{
    handle *h = (handle *)file->UserData;
    const size_t left = h->size - h->at, items = size > 0 ? left / size : 0, taken = count < items ? count : items;
    memcpy(out, h->bytes + h->at, taken * size);
    h->at += taken * size;
    return taken;
}

static size_t write_bytes(struct aiFile *file, const char *bytes, size_t size, size_t count)
{
    (void)file, (void)bytes, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile *file) { return ((handle *)file->UserData)->at; }
static size_t size_of(struct aiFile *file) { return ((handle *)file->UserData)->size; }
static void flush(struct aiFile *file) { (void)file; }

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    handle *h = (handle *)file->UserData;
    const size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? h->at : h->size;
    const size_t to = base + offset; /* offsets back wrap round */
    if (to > h->size) return aiReturn_FAILURE;
    h->at = to;
    return aiReturn_SUCCESS;
}

static struct aiFile *open_file(struct aiFileIO *io, const char *name, const char *mode)
{
    const source *from = (const source *)(const void *)io->UserData;
    size_t size = from->size;
    daft_error ignored;
    char *own = NULL;
    if (mode[0] != 'r') return NULL;
    if (strcmp(name, from->name) != 0 && !(own = daft_file_read(from->allocator, from->files, name, &size, &ignored)))
        return NULL;
    handle *h = daft_alloc_zero(from->allocator, 1, sizeof *h);
    if (!h) {
        daft_release(from->allocator, own);
        return NULL;
    }
    *h = (handle){.face = {.ReadProc = read_bytes,
                           .WriteProc = write_bytes,
                           .TellProc = tell,
                           .FileSizeProc = size_of,
                           .SeekProc = seek,
                           .FlushProc = flush,
                           .UserData = (char *)h},
                  .from = from,
                  .bytes = own ? own : from->bytes,
                  .own = own,
                  .size = size};
    return &h->face;
}

static void close_file(struct aiFileIO *io, struct aiFile *file)
{
    handle *h = (handle *)file->UserData;
    (void)io;
    daft_release(h->from->allocator, h->own);
    daft_release(h->from->allocator, h);
}

/* ---- the import ---- */

/* Assimp adds materials of its own, which no triangle has: what only looks as if it mirrored would cost. */
static bool drop_unused(const daft_foreign *from, daft_obj *made)
{
    const uint32_t count = made->mesh.slot_count;
    uint16_t *number = daft_alloc_zero(from->allocator, (size_t)count + 1, sizeof *number);
    if (!number) return daft_fail_memory(from->error, "a model's materials");
    uint16_t kept = 0;
    for (uint32_t t = 0; t < made->mesh.triangle_count; t++) number[made->mesh.slots[t]] = 1;
    for (uint32_t i = 0; i < count; i++) {
        if (!number[i]) {
            daft_mtl_drop(from->allocator, &made->slots.items[i]);
            continue;
        }
        number[i] = kept;
        made->slots.items[kept++] = made->slots.items[i];
    }
    for (uint32_t t = 0; t < made->mesh.triangle_count; t++) made->mesh.slots[t] = number[made->mesh.slots[t]];
    made->slots.count = made->mesh.slot_count = kept;
    daft_release(from->allocator, number);
    return true;
}

static bool convert(const daft_foreign *from, daft_obj *out)
{
    daft_obj made = {0};
    if (daft_foreign_mesh(from, &made) && daft_foreign_materials(from, &made.slots) && drop_unused(from, &made)) {
        for (size_t i = 0; i < made.slots.count; i++) made.slots.items[i].fades = made.mesh.alphas != NULL;
        *out = made;
        return true;
    }
    daft_obj_free(from->allocator, &made);
    return false;
}

bool daft_foreign_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const void *bytes,
                        size_t size, const daft_log *log, daft_obj *out, daft_error *error)
{
    /* Not LimitBoneWeights: version 5.2 makes NaN of weights that are 0. */
    const unsigned steps =
        aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure | aiProcess_GlobalScale;
    char name[1100];
    daft_assimp assimp;
    if (!open_library(&assimp, path, error)) return false;
    /* Readers are chosen by name: it ends as the bytes say. */
    const char *format = daft_foreign_format(path, bytes, size), *dot = strrchr(path, '.');
    const bool told = dot && format && strcasecmp(dot + 1, format) == 0;
    snprintf(name, sizeof name, "%.1000s%s%s", path, told || !format ? "" : ".", told || !format ? "" : format);
    char *widened;
    const daft_foreign raw = {allocator, files, path, log, &assimp, NULL, error, format, bytes, size};
    if (!daft_gltf_widen(&raw, &widened, &size)) return false;
    if (widened) bytes = widened;
    source from = {allocator, files, name, bytes, size};
    struct aiFileIO io = {open_file, close_file, (char *)&from};
    const struct aiScene *scene = assimp.import(name, steps, &io, NULL);
    bool good = scene && scene->mRootNode;
    if (good) {
        const daft_foreign all = {allocator, files, path, log, &assimp, scene, error, format, bytes, size};
        good = convert(&all, out);
    } else {
        char why[400];
        snprintf(why, sizeof why, "%s", assimp.error());
        for (char *c = why; *c; c++)
            if (*c == '\n') *c = ' ';
        daft_fail_at(error, DAFT_ERROR_SYNTAX, path, 0, 0, "%s", why[0] ? why : "there is nothing in this file");
    }
    if (scene) assimp.release(scene);
    daft_release(allocator, widened);
    return good;
}
