/* Names in the order of their bytes, folder by folder. */
#include "files/content.h"

#include "common/util.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { DEPTH = 8, NAMES = 1 << 16 };

typedef struct name_list {
    char **names;
    size_t count, capacity;
    bool lost;
} name_list;

static bool is_recording(const char *name)
{
    const char *const ends[] = {".rec", ".rec.part", ".rec.part-old"};
    const size_t length = strlen(name);
    for (size_t i = 0; i < COUNT_OF(ends); i++) {
        const size_t end = strlen(ends[i]);
        if (length >= end && strcmp(name + length - end, ends[i]) == 0) return true;
    }
    return false;
}

static void keep(void *user, const char *name)
{
    name_list *list = user;
    if (is_recording(name) || list->lost) return;
    if (list->count == list->capacity) {
        const size_t more = list->capacity ? 2 * list->capacity : 64;
        char **grown = more <= NAMES ? realloc(list->names, more * sizeof *grown) : NULL;
        list->lost = !grown;
        if (!grown) return;
        list->names = grown, list->capacity = more;
    }
    list->names[list->count] = strdup(name);
    list->lost = !list->names[list->count];
    list->count += !list->lost;
}

static int compare(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

typedef struct walk {
    const daft_files *files;
    const char *root;
    sha256 hash;
} walk;

static bool add_folder(walk *w, const char *folder, int depth, daft_error *error);

/* A file that cannot be opened is an error and no folder: a hash without it would tell of a game that was changed. */
static bool is_file(const walk *w, const char *name, char path[PATH_SIZE])
{
    struct stat status;
    return daft_files_find(w->files, name, path, PATH_SIZE) || (lstat(path, &status) == 0 && S_ISREG(status.st_mode));
}

static bool add_name(walk *w, const char *name, int depth, daft_error *error)
{
    char path[PATH_SIZE];
    if (snprintf(path, sizeof path, "%s/%s", w->root, name) >= (int)sizeof path) return true;
    if (!is_file(w, name, path)) return add_folder(w, name, depth + 1, error);
    size_t size;
    char *bytes = daft_read_file(w->files, path, &size, error);
    if (!bytes) return false;
    const uint64_t length = size;
    sha256_add(&w->hash, name, strlen(name) + 1);
    sha256_add(&w->hash, &length, sizeof length);
    sha256_add(&w->hash, bytes, size);
    free(bytes);
    return true;
}

static bool add_folder(walk *w, const char *folder, int depth, daft_error *error)
{
    name_list list = {0};
    if (depth > DEPTH) return true;
    bool good = daft_files_list(w->files, folder, keep, &list) ||
                fail_at(error, folder[0] ? folder : w->root, 0, 0, "cannot read the folder");
    good = good && (!list.lost || fail(error, DAFT_ERROR_MEMORY, "out of memory for the names of a game's files"));
    if (list.count > 0) qsort(list.names, list.count, sizeof *list.names, compare);
    for (size_t i = 0; i < list.count; i++) {
        char name[PATH_SIZE];
        const bool fits = snprintf(name, sizeof name, folder[0] ? "%s/%s" : "%s%s", folder, list.names[i]) < PATH_SIZE;
        const bool twice = i > 0 && strcmp(list.names[i], list.names[i - 1]) == 0;
        good = good && (!fits || twice || add_name(w, name, depth, error));
    }
    for (size_t i = 0; i < list.count; i++) free(list.names[i]);
    free(list.names);
    return good;
}

bool content_hash(const game_source *source, const game_info *game, char out[SHA256_TEXT], daft_error *error)
{
    walk w = {.files = source->own, .root = game->folder};
    sha256_begin(&w.hash);
    const bool good = add_folder(&w, "", 0, error);
    sha256_end(&w.hash, out);
    return good;
}
