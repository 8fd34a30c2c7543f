/* Reading zip archives (PKWARE's APPNOTE 6.3, without its 64-bit and encrypted forms). */
#include "files/pack.h"

#include "common/util.h"

#include <stdlib.h>
#include <string.h>

#ifdef DAFT_HAS_ZLIB
#include <zlib.h>
#endif

enum { END_SIZE = 22, CENTRAL_SIZE = 46, LOCAL_SIZE = 30, STORED = 0, DEFLATED = 8, MAX_COMMENT = 65535 };
static const uint32_t END_MARK = 0x06054b50, CENTRAL_MARK = 0x02014b50, LOCAL_MARK = 0x04034b50;

typedef struct entry {
    char *name;
    const uint8_t *data;
    uint64_t packed, size;
    uint32_t crc;
    int method;
    bool runs;
} entry;

struct pack {
    const uint8_t *bytes;
    size_t size, directory; /* where the central directory begins */
    const char *path;
    entry *entries; /* sorted by name */
    size_t count;
};

static uint32_t get2(const uint8_t *at) { return (uint32_t)at[0] | (uint32_t)at[1] << 8; }
static uint32_t get4(const uint8_t *at) { return get2(at) | get2(at + 2) << 16; }

uint32_t pack_crc(const void *bytes, size_t size)
{
    /* Four bits at a time, of the polynomial 0xedb88320. */
    static const uint32_t NIBBLE[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                        0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                        0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    uint32_t crc = ~0u;
    const uint8_t *at = bytes;
    for (size_t i = 0; i < size; i++) {
        crc = NIBBLE[(crc ^ at[i]) & 15] ^ crc >> 4;
        crc = NIBBLE[(crc ^ (uint32_t)at[i] >> 4) & 15] ^ crc >> 4;
    }
    return ~crc;
}

bool pack_name_is_good(const char *name)
{
    size_t length = strlen(name);
    if (length == 0 || length > PACK_NAME || name[0] == '/' || strchr(name, '\\') || strchr(name, ':')) return false;
    for (const char *part = name; part;) {
        size_t size = strcspn(part, "/");
        bool dots = (size == 1 && part[0] == '.') || (size == 2 && part[0] == '.' && part[1] == '.');
        if (size == 0 || dots) return false;
        part = part[size] ? part + size + 1 : NULL;
    }
    for (const char *at = name; *at; at++)
        if ((unsigned char)*at < 32 || *at == 127) return false;
    return true;
}

/* ---- opening ---- */

static bool bad(const pack *p, const char *name, const char *what, daft_error *error)
{
    return name ? fail(error, DAFT_ERROR_SYNTAX, "%s: '%.200s' %s", p->path, name, what)
                : fail(error, DAFT_ERROR_SYNTAX, "%s: %s", p->path, what);
}

/* The end record, after which the file may have a comment. */
static const uint8_t *find_end(const pack *p)
{
    for (size_t comment = 0; comment <= MAX_COMMENT && comment + END_SIZE <= p->size; comment++) {
        const uint8_t *at = p->bytes + p->size - END_SIZE - comment;
        if (get4(at) == END_MARK && get2(at + 20) == comment) return at;
    }
    return NULL;
}

/* By the attributes that Unix programs write; the others have no links. */
static bool is_plain(const uint8_t *central)
{
    enum { UNIX = 3, TYPE = 0170000, REGULAR = 0100000, FOLDER = 0040000 };
    uint32_t type = get4(central + 38) >> 16 & TYPE;
    return central[5] != UNIX || type == 0 || type == REGULAR || type == FOLDER;
}

static bool runs(const uint8_t *central)
{
    enum { UNIX = 3 };
    return central[5] == UNIX && (get4(central + 38) >> 16 & 0100) != 0;
}

/* Where the file's bytes are: behind its local header, whose name must be the same. */
static bool find_data(const pack *p, const uint8_t *central, entry *out, daft_error *error)
{
    uint64_t at = get4(central + 42), length = get2(central + 28);
    if (at + LOCAL_SIZE > p->directory || get4(p->bytes + at) != LOCAL_MARK)
        return bad(p, out->name, "has no header of its own", error);
    const uint8_t *local = p->bytes + at;
    at += LOCAL_SIZE + get2(local + 26) + get2(local + 28);
    if (at + out->packed > p->directory) return bad(p, out->name, "reaches beyond the archive's files", error);
    if (get2(local + 26) != length || memcmp(local + LOCAL_SIZE, central + CENTRAL_SIZE, length) != 0)
        return bad(p, out->name, "has another name in its own header", error);
    out->data = p->bytes + at;
    return true;
}

static bool check_entry(const pack *p, const uint8_t *central, const entry *e, daft_error *error)
{
    enum { ENCRYPTED = 1 | 64 };
    if (!pack_name_is_good(e->name)) return bad(p, e->name, "is not a name that a packed file may have", error);
    if (!is_plain(central)) return bad(p, e->name, "is a link or a device, not a file", error);
    if (get2(central + 8) & ENCRYPTED) return bad(p, e->name, "is encrypted", error);
    if (e->method != STORED && e->method != DEFLATED)
        return bad(p, e->name, "is compressed in a way that is not supported: store or deflate it", error);
    if (e->method == STORED && e->packed != e->size) return bad(p, e->name, "has two sizes", error);
    if (e->size > PACK_SMALL && e->size / PACK_RATIO > e->packed)
        return bad(p, e->name, "would grow more than 200 times", error);
    return true;
}

/* Reads one record of the directory. Folders are left out. */
static bool read_entry(pack *p, const uint8_t *central, daft_error *error)
{
    size_t length = get2(central + 28);
    entry *e = &p->entries[p->count];
    *e = (entry){.packed = get4(central + 20),
                 .size = get4(central + 24),
                 .crc = get4(central + 16),
                 .runs = runs(central),
                 .method = (int)get2(central + 10)};
    e->name = malloc(length + 1);
    if (!e->name) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
    p->count++; /* pack_close frees the name */
    memcpy(e->name, central + CENTRAL_SIZE, length);
    e->name[length] = 0;
    bool folder = length > 0 && e->name[length - 1] == '/' && e->size == 0;
    if (folder) e->name[length - 1] = 0;
    if (strlen(e->name) != length - folder) return bad(p, NULL, "a name has a zero byte in it", error);
    if (!check_entry(p, central, e, error) || (!folder && !find_data(p, central, e, error))) return false;
    if (folder) free(e->name), p->count--;
    return true;
}

static int by_name(const void *a, const void *b) { return strcmp(((const entry *)a)->name, ((const entry *)b)->name); }

/* What no single file shows: all together, and no two of a name. Files that overlap are more than the archive holds. */
static bool check_all(pack *p, daft_error *error)
{
    uint64_t size = 0, packed = 0;
    if (p->count > 1) qsort(p->entries, p->count, sizeof *p->entries, by_name);
    for (size_t i = 0; i < p->count; i++) {
        const entry *e = &p->entries[i];
        size += e->size;
        packed += e->packed + LOCAL_SIZE + strlen(e->name);
        if (i > 0 && strcmp(e[-1].name, e->name) == 0) return bad(p, e->name, "is there twice", error);
    }
    if (size > PACK_BYTES) return bad(p, NULL, "holds more than 1 GiB of files", error);
    return packed <= p->directory || bad(p, NULL, "its files overlap", error);
}

static bool read_directory(pack *p, const uint8_t *end, daft_error *error)
{
    size_t records = get2(end + 10), at = get4(end + 16), stop = (size_t)(end - p->bytes);
    if (get4(end + 4) != 0 || get2(end + 8) != records) return bad(p, NULL, "is one of several parts", error);
    if (at > stop || get4(end + 12) != stop - at) return bad(p, NULL, "its directory is not where it should be", error);
    if (records > PACK_FILES) return bad(p, NULL, "holds more than 10000 files", error);
    p->directory = at;
    p->entries = calloc(records + 1, sizeof *p->entries);
    if (!p->entries) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
    for (size_t i = 0; i < records; i++) {
        const uint8_t *central = p->bytes + at;
        if (stop - at < CENTRAL_SIZE || get4(central) != CENTRAL_MARK)
            return bad(p, NULL, "its directory is damaged", error);
        size_t length = CENTRAL_SIZE + (size_t)get2(central + 28) + get2(central + 30) + get2(central + 32);
        if (stop - at < length) return bad(p, NULL, "its directory is damaged", error);
        if (!read_entry(p, central, error)) return false;
        at += length;
    }
    return at == stop ? check_all(p, error) : bad(p, NULL, "its directory is damaged", error);
}

pack *pack_open(const void *bytes, size_t size, const char *path, daft_error *error)
{
    pack *p = calloc(1, sizeof *p);
    if (!p) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
        return NULL;
    }
    *p = (pack){.bytes = bytes, .size = size, .path = path};
    const uint8_t *end = find_end(p);
    if (end ? read_directory(p, end, error) : bad(p, NULL, "is not a packed game (a zip archive)", error)) return p;
    pack_close(p);
    return NULL;
}

void pack_close(pack *p)
{
    for (size_t i = 0; p && i < p->count; i++) free(p->entries[i].name);
    if (p) free(p->entries);
    free(p);
}

/* ---- reading ---- */

static bool unpack(const entry *e, void *bytes)
{
    if (e->method == STORED) {
        if (e->size) memcpy(bytes, e->data, (size_t)e->size);
        return true;
    }
#ifdef DAFT_HAS_ZLIB
    uint8_t none;
    z_stream z = {.next_in = (z_const Bytef *)(uintptr_t)e->data,
                  .avail_in = (uInt)e->packed,
                  .next_out = e->size ? bytes : &none,
                  .avail_out = (uInt)e->size};
    if (inflateInit2(&z, -MAX_WBITS) != Z_OK) return false; /* without a header, as in archives */
    int status = inflate(&z, Z_FINISH);
    inflateEnd(&z);
    return status == Z_STREAM_END && z.total_out == e->size;
#else
    return false;
#endif
}

static const entry *find(const pack *p, const char *name)
{
    const entry key = {.name = (char *)(uintptr_t)name};
    return p->count ? bsearch(&key, p->entries, p->count, sizeof key, by_name) : NULL;
}

int64_t pack_read(void *user, const char *path, void *bytes, uint64_t capacity, daft_error *error)
{
    const entry *e = find(user, path);
    if (!e) return -1;
    if (capacity < e->size || !bytes) return (int64_t)e->size;
#ifndef DAFT_HAS_ZLIB
    if (e->method == DEFLATED) {
        fail(error, DAFT_ERROR_UNSUPPORTED, "is compressed, and this program was built without zlib");
        return -1;
    }
#endif
    if (unpack(e, bytes) && pack_crc(bytes, (size_t)e->size) == e->crc) return (int64_t)e->size;
    fail(error, DAFT_ERROR_SYNTAX, "is damaged in its archive");
    return -1;
}

void pack_list(void *user, const char *folder, daft_name_callback *found, void *found_user)
{
    const pack *p = user;
    size_t length = strlen(folder);
    for (size_t i = 0; i < p->count; i++) {
        const char *name = p->entries[i].name;
        if (length > 0 && (strncmp(name, folder, length) != 0 || name[length] != '/')) continue;
        name += length > 0 ? length + 1 : 0;
        if (!strchr(name, '/')) found(found_user, name);
    }
}

size_t pack_count(const pack *p) { return p->count; }

pack_file pack_file_at(const pack *p, size_t index)
{
    const entry *e = &p->entries[index];
    return (pack_file){.name = e->name, .size = e->size, .runs = e->runs};
}
