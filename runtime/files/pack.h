/* pack: a game in one file, FILE.daft: a zip archive with main.lua at its top, as `daft pack` writes it or any other
 * program. It is read in place, file by file; nothing is unpacked to the disk.
 *
 * Before a byte is inflated the whole archive is looked at, and refused where it holds a link or anything else that is
 * no file, a name that is absolute or has "..", two files of one name, files that overlap, or more than a game may
 * be: PACK_FILES files, PACK_BYTES in all, PACK_RATIO times the bytes that the archive has for a file. */
#ifndef RUNTIME_FILES_PACK_H
#define RUNTIME_FILES_PACK_H

#include "daft.h"

#include "files/sha256.h"

enum { PACK_FILES = 10000, PACK_NAME = 512, PACK_RATIO = 200, PACK_SMALL = 65536 /* bytes that any file may have */ };
static const uint64_t PACK_BYTES = (uint64_t)1 << 30;

typedef struct pack pack;

/* `bytes` must outlive the pack; `path` is for messages. NULL: *error says what is wrong with it. */
pack *pack_open(const void *bytes, size_t size, const char *path, daft_error *error);
void pack_close(pack *p); /* NULL is fine */
/* A daft_read_callback and a daft_list_callback; user: the pack. */
int64_t pack_read(void *user, const char *path, void *bytes, uint64_t capacity, daft_error *error);
void pack_list(void *user, const char *folder, daft_name_callback *found, void *found_user);

/* All files, sorted by name. */
typedef struct pack_file {
    const char *name; /* the pack's */
    uint64_t size;
    bool runs; /* by its mode, a program */
} pack_file;
size_t pack_count(const pack *p);
pack_file pack_file_at(const pack *p, size_t index);

/* Whether a file of this name may be in a pack. */
bool pack_name_is_good(const char *name);
uint32_t pack_crc(const void *bytes, size_t size);

#endif
