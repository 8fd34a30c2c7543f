/* Writing zip archives (PKWARE's APPNOTE 6.3, without its 64-bit forms). */
#include "files/archive.h"

#include "common/util.h"
#include "files/pack.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#ifdef DAFT_HAS_ZLIB
#include <zlib.h>
#endif

enum { DEFLATED = 8 };

typedef struct entry {
    char *name;
    uint64_t offset;
    uint32_t packed, size, crc, mode;
    int method;
} entry;

struct archive {
    archive_def def;
    uint64_t written, directory; /* bytes of the file; where the directory begins */
    uint64_t total;              /* bytes of all files */
    entry *entries;
    size_t count, capacity;
};

archive *archive_open(const archive_def *def, daft_error *error)
{
    archive *self = calloc(1, sizeof *self);
    if (self)
        *self = (archive){.def = *def, .written = def->begin};
    else
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
    return self;
}

void archive_close(archive *self)
{
    for (size_t i = 0; self && i < self->count; i++) free(self->entries[i].name);
    if (self) free(self->entries);
    free(self);
}

size_t archive_count(const archive *self) { return self->count; }

/* ---- records ---- */

static void put(archive *self, const void *bytes, size_t size)
{
    self->def.put(self->def.user, bytes, size);
    self->written += size;
}

static uint8_t *put_number(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) *at++ = (uint8_t)(value >> 8 * i);
    return at;
}

/* What the headers of a file share: version 2.0, names in UTF-8, method, 1980-01-01 0:00, sums and sizes. */
static uint8_t *put_shared(uint8_t *at, const entry *e)
{
    at = put_number(put_number(put_number(at, 20, 2), 0x0800, 2), (uint64_t)e->method, 2);
    at = put_number(put_number(at, 0, 2), 0x0021, 2);
    at = put_number(put_number(put_number(at, e->crc, 4), e->packed, 4), e->size, 4);
    return put_number(put_number(at, strlen(e->name), 2), 0, 2);
}

void archive_put_directory(archive *self)
{
    self->directory = self->written;
    for (size_t i = 0; i < self->count; i++) {
        const entry *e = &self->entries[i];
        uint8_t head[46], *at = put_number(put_number(head, 0x02014b50, 4), 0x0314, 2); /* made on Unix */
        at = put_number(put_shared(at, e), 0, 6);
        at = put_number(put_number(at, (uint64_t)(0100000 | e->mode) << 16, 4), e->offset, 4);
        put(self, head, (size_t)(at - head));
        put(self, e->name, strlen(e->name));
    }
}

void archive_put_end(archive *self, const char *comment)
{
    uint8_t end[22], *at = put_number(put_number(end, 0x06054b50, 4), 0, 4);
    at = put_number(put_number(at, self->count, 2), self->count, 2);
    at = put_number(put_number(at, self->written - self->directory, 4), self->directory, 4);
    at = put_number(at, strlen(comment), 2);
    put(self, end, (size_t)(at - end));
    put(self, comment, strlen(comment));
}

/* ---- files ---- */

/* *out from malloc; NULL: the bytes are to be stored, since deflating gains nothing, or more than readers take, or
 * there is no zlib. False: out of memory. */
static bool deflate_bytes(const void *bytes, size_t size, uint8_t **out, size_t *out_size)
{
    *out = NULL;
#ifdef DAFT_HAS_ZLIB
    z_stream z = {0};
    if (size < 2) return true;
    uint8_t *to = malloc(size);
    if (!to) return false;
    if (deflateInit2(&z, Z_DEFAULT_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY) != Z_OK) {
        free(to);
        return false;
    }
    z.next_in = (z_const Bytef *)(uintptr_t)bytes, z.avail_in = (uInt)size;
    z.next_out = to, z.avail_out = (uInt)size - 1;
    const bool whole = deflate(&z, Z_FINISH) == Z_STREAM_END;
    const bool readable = size <= PACK_SMALL || size / PACK_RATIO < z.total_out;
    deflateEnd(&z);
    if (whole && readable)
        *out = to, *out_size = z.total_out;
    else
        free(to);
#else
    (void)bytes, (void)size, (void)out_size;
#endif
    return true;
}

static entry *new_entry(archive *self, const char *name, daft_error *error)
{
    if (self->count == self->capacity) {
        const size_t more = self->capacity ? 2 * self->capacity : 64;
        entry *entries = realloc(self->entries, more * sizeof *entries);
        if (entries) self->entries = entries, self->capacity = more;
    }
    entry *e = self->count < self->capacity ? &self->entries[self->count] : NULL;
    if (e) *e = (entry){.name = strdup(name)};
    if (e && e->name) {
        self->count++;
        return e;
    }
    fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
    return NULL;
}

bool archive_add(archive *self, const char *name, const void *bytes, size_t size, uint32_t mode, daft_error *error)
{
    if (!pack_name_is_good(name)) return fail_at(error, name, 0, 0, "is not a name that a packed file may have");
    if (self->count == PACK_FILES) return fail_at(error, self->def.path, 0, 0, "holds more than 10000 files");
    size_t packed = size;
    uint8_t *small = NULL;
    if (self->def.deflate && !deflate_bytes(bytes, size, &small, &packed))
        return fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
    entry *e = NULL;
    if (self->total + size > PACK_BYTES)
        fail_at(error, self->def.path, 0, 0, "holds more than 1 GiB of files");
    else
        e = new_entry(self, name, error);
    if (e) {
        uint8_t head[30];
        self->total += size;
        e->offset = self->written, e->mode = mode, e->method = small ? DEFLATED : 0;
        e->packed = (uint32_t)packed, e->size = (uint32_t)size, e->crc = pack_crc(bytes, size);
        put(self, head, (size_t)(put_shared(put_number(head, 0x04034b50, 4), e) - head));
        put(self, name, strlen(name));
        put(self, small ? small : bytes, packed);
    }
    free(small);
    return e != NULL;
}

/* ---- folders ---- */

typedef struct listing {
    const daft_files *files;
    const char *top; /* the folder of the disk that `files` stands for */
    bool (*leave)(const char *name);
    char **names; /* beneath `top` */
    size_t count, capacity;
    const char *folder; /* that is being listed */
    int depth;
    bool failed; /* *error says why */
    daft_error *error;
} listing;

static void list(listing *l, const char *folder);

static bool keep(listing *l, const char *name)
{
    if (l->count == l->capacity) {
        const size_t more = l->capacity ? 2 * l->capacity : 64;
        char **names = realloc(l->names, more * sizeof *names);
        if (!names) return fail(l->error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
        l->names = names, l->capacity = more;
    }
    l->names[l->count] = strdup(name);
    return l->names[l->count++] || fail(l->error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
}

/* One name of the folder l->folder. */
static void look_at(void *user, const char *name)
{
    listing *l = user;
    struct stat status;
    char inner[PATH_SIZE], path[2 * PATH_SIZE];
    if (l->failed) return;
    const int length = snprintf(inner, sizeof inner, "%s%s%s", l->folder, l->folder[0] ? "/" : "", name);
    const bool fits = length > 0 && (size_t)length < sizeof inner && path_join(path, sizeof path, l->top, inner);
    if (!fits) {
        l->failed = !fail_at(l->error, inner, 0, 0, "the path is too long");
    } else if (l->leave && l->leave(inner)) {
        return;
    } else if (lstat(path, &status) == 0 && S_ISDIR(status.st_mode)) {
        list(l, inner);
    } else {
        l->failed = !keep(l, inner);
    }
}

static void list(listing *l, const char *folder)
{
    enum { DEEPEST = 16 };
    const char *above = l->folder;
    if (l->depth == DEEPEST) {
        l->failed = !fail_at(l->error, folder, 0, 0, "folders are more than %d deep", (int)DEEPEST);
        return;
    }
    l->depth++;
    l->folder = folder;
    if (!daft_files_list(l->files, folder, look_at, l) && !l->failed)
        l->failed = !fail_at(l->error, folder[0] ? folder : l->top, 0, 0, "the folder cannot be read");
    l->folder = above;
    l->depth--;
}

static int by_name(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

static bool add_one(archive *self, const daft_files *files, const char *name, const char *prefix, daft_error *error)
{
    char inside[2 * PATH_SIZE];
    size_t size;
    snprintf(inside, sizeof inside, "%s%s", prefix, name);
    void *bytes = daft_read_file(files, name, &size, error);
    const bool good = bytes && archive_add(self, inside, bytes, size, 0644, error);
    free(bytes);
    return good;
}

bool archive_add_folder(archive *self, const daft_files *files, const char *folder, const char *prefix,
                        bool (*leave)(const char *name), daft_error *error)
{
    listing l = {.files = files, .top = folder, .leave = leave, .folder = "", .error = error};
    list(&l, "");
    if (!l.failed && l.count > 1) qsort(l.names, l.count, sizeof *l.names, by_name);
    bool good = !l.failed;
    for (size_t i = 0; good && i < l.count; i++) good = add_one(self, files, l.names[i], prefix, error);
    for (size_t i = 0; i < l.count; i++) free(l.names[i]);
    free(l.names);
    return good;
}
