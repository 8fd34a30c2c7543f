/* Saves as files: "GAME.NAME.save", a line that says what it is and the text. */
#include "files/saves.h"

#include "common/util.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static const char HEAD[] = "daft-save 1\n";

typedef struct item {
    char name[SAVES_NAME + 1];
    char *text;    /* NULL: nothing */
    bool broken;   /* the file is there and cannot be used */
    bool expected; /* and not yet asked for */
    daft_error error;
} item;

struct saves {
    char folder[PATH_SIZE], game[160]; /* folder: empty: none */
    saves_def def;
    item items[SAVES_COUNT];
    size_t count;
};

static bool is_plain(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

bool saves_is_name(const char *name)
{
    size_t length = 0;
    while (is_plain(name[length])) length++;
    return length > 0 && length <= SAVES_NAME && name[length] == 0;
}

/* As part of a file's name; names that do not fit, or hold other characters, are told apart by their hash. */
static void name_game(const char *game, char *out, size_t size)
{
    size_t length = 0;
    bool same = true;
    for (; game[length] && length < 100; length++) {
        out[length] = is_plain(game[length]) ? game[length] : '_';
        same &= is_plain(game[length]);
    }
    out[length] = 0;
    if (same && !game[length]) return;
    snprintf(out + length, size - length, "-%016llx", (unsigned long long)daft_hash(game, strlen(game), 0));
}

saves *saves_open(const saves_def *def, daft_error *error)
{
    saves *store = calloc(1, sizeof *store);
    if (!store) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for what the game saves");
        return NULL;
    }
    store->def = *def;
    if (def->folder) snprintf(store->folder, sizeof store->folder, "%s", def->folder);
    name_game(def->game ? def->game : "", store->game, sizeof store->game);
    return store;
}

void saves_close(saves *store)
{
    for (size_t i = 0; store && i < store->count; i++) free(store->items[i].text);
    free(store);
}

static bool path_of(const saves *store, const char *name, const char *end, char out[PATH_SIZE])
{
    if (!store->folder[0]) return false;
    const int length = snprintf(out, PATH_SIZE, "%s/%s.%s.save%s", store->folder, store->game, name, end);
    return length > 0 && length < PATH_SIZE;
}

static item *find(saves *store, const char *name)
{
    for (size_t i = 0; i < store->count; i++)
        if (strcmp(store->items[i].name, name) == 0) return &store->items[i];
    return NULL;
}

static item *add(saves *store, const char *name, daft_error *error)
{
    if (store->count == SAVES_COUNT) {
        fail(error, DAFT_ERROR_ARGUMENT, "a game has at most %d saves", SAVES_COUNT);
        return NULL;
    }
    item *fresh = &store->items[store->count++];
    *fresh = (item){0};
    snprintf(fresh->name, sizeof fresh->name, "%s", name);
    return fresh;
}

static bool set(item *to, const char *text, daft_error *error)
{
    char *copy = text ? strdup(text) : NULL;
    if (text && !copy) return fail(error, DAFT_ERROR_MEMORY, "out of memory for what the game saves");
    free(to->text);
    to->text = copy;
    return true;
}

bool saves_expect(saves *store, const char *name, const char *text, daft_error *error)
{
    item *to = find(store, name);
    if ((!to && !(to = add(store, name, error))) || !set(to, text, error)) return false;
    to->expected = true;
    return true;
}

saves *saves_copy(const saves *from, daft_error *error)
{
    saves *copy = saves_open(&(saves_def){.game = from->def.game}, error);
    for (size_t i = 0; copy && i < from->count; i++) {
        if (saves_expect(copy, from->items[i].name, from->items[i].text, error)) continue;
        saves_close(copy);
        return NULL;
    }
    return copy;
}

bool saves_take(saves *store, const saves *from, daft_error *error)
{
    for (size_t i = 0; i < from->count; i++) {
        const item *source = &from->items[i];
        item *to = find(store, source->name);
        if ((!to && !(to = add(store, source->name, error))) || !set(to, source->text, error)) return false;
        to->broken = source->broken, to->expected = source->expected, to->error = source->error;
    }
    return true;
}

saves *saves_clone(const saves *from, daft_error *error)
{
    saves *copy = saves_open(&(saves_def){.game = from->def.game}, error);
    if (copy && saves_take(copy, from, error)) return copy;
    saves_close(copy);
    return NULL;
}

/* The text of a file's bytes, in place; NULL with the message. */
static const char *take_text(char *bytes, size_t size, const char *path, daft_error *error)
{
    const size_t head = sizeof HEAD - 1;
    if (size > SAVES_SIZE + head + 1 || memchr(bytes, 0, size) || size < head || memcmp(bytes, HEAD, head) != 0) {
        fail_at(error, path, 1, 1, "'daft-save 1' expected: this is not what a game saved");
        return NULL;
    }
    char *end = strchr(bytes + head, '\n');
    if (!end || end[1]) {
        fail_at(error, path, 2, 1, "one whole line expected: the file was cut short or changed");
        return NULL;
    }
    *end = 0;
    return bytes + head;
}

static bool read_file(saves *store, item *to, daft_error *error)
{
    char path[PATH_SIZE];
    size_t size;
    if (!path_of(store, to->name, "", path) || !path_is_file(path)) return true;
    char *bytes = daft_read_file(NULL, path, &size, error);
    const char *text = bytes ? take_text(bytes, size, path, error) : NULL;
    const bool good = text && set(to, text, error);
    free(bytes);
    to->broken = !good;
    return good;
}

bool saves_get(saves *store, const char *name, const char **text, daft_error *error)
{
    item *to = find(store, name);
    const bool known = to != NULL;
    *text = NULL;
    if (!to && !(to = add(store, name, error))) return false;
    if (!known && !read_file(store, to, &to->error) && !to->error.code) to->error.code = DAFT_ERROR_IO;
    if ((!known || to->expected) && store->def.told) store->def.told(store->def.user, name, to->text);
    to->expected = false;
    *text = to->text;
    if (to->broken && !to->text) *error = to->error;
    return !to->broken || to->text;
}

void saves_mark_broken(saves *store, const char *name)
{
    item *to = find(store, name);
    if (to) to->broken = true;
}

bool saves_put(saves *store, const char *name, const char *text, daft_error *error)
{
    char path[PATH_SIZE], aside[PATH_SIZE];
    const char *unused;
    if (strlen(text) > SAVES_SIZE)
        return fail(error, DAFT_ERROR_ARGUMENT, "'%s' takes more than a million bytes", name);
    item *to = find(store, name);
    if (!to || to->expected) saves_get(store, name, &unused, error); /* what was there is on record */
    to = find(store, name);
    if (!to || !set(to, text, error)) return false;
    if (!path_of(store, name, "", path)) return true;
    if (to->broken && path_of(store, name, ".broken", aside)) rename(path, aside);
    to->broken = false;
    daft_writer *writer = daft_writer_begin(path, error);
    if (!writer) return false;
    daft_writer_put(writer, HEAD, sizeof HEAD - 1);
    daft_writer_put(writer, text, strlen(text));
    daft_writer_put(writer, "\n", 1);
    return daft_writer_commit(writer, error);
}
