/* files: the one way in. Every file that the library reads is opened here: by a daft_files, which keeps to its roots,
 * or without one (NULL), where paths are the user's own and lead anywhere.
 *
 * A path belongs to the root whose folder it begins with; a relative one that begins with none is looked for in all of
 * them, in order. What follows the root is put into normal form, in which nothing leads above the root, and then opened
 * by openat2 (RESOLVE_BENEATH, RESOLVE_NO_SYMLINKS), or where the system lacks it part by part, without following
 * links. Promises: only regular files are opened, without waiting; never more is read than a file held when it was
 * opened. */
#ifndef DAFT_FILES_H
#define DAFT_FILES_H

#include "base/base.h"

/* Reads a whole file into memory, as long as it was when it was opened, and appends a zero byte that *size does not
 * count. Anything but a regular file within the size limit fails with a message that names it. Release with
 * daft_release. */
char *daft_file_read(const daft_allocator *allocator, const daft_files *files, const char *path, size_t *size,
                     daft_error *error);
/* Whether daft_file_read would find a regular file. */
bool daft_file_exists(const daft_files *files, const char *path);
/* What tells one file from another, whatever the path that leads to it, and from what it was before it changed. */
typedef struct daft_file_id {
    uint64_t device, number;
    uint64_t size, seconds, nanoseconds; /* when it was modified; of a callback's file 0 */
} daft_file_id;
static inline bool daft_file_id_equal(const daft_file_id *a, const daft_file_id *b)
{
    return a->device == b->device && a->number == b->number && a->size == b->size && a->seconds == b->seconds &&
           a->nanoseconds == b->nanoseconds;
}
bool daft_file_identify(const daft_files *files, const char *path, daft_file_id *out);
/* Joins the folder of `base` (a file's path) and `path` (unchanged when absolute) into out. False if it is too long. */
bool daft_path_beside(const char *base, const char *path, char *out, size_t size);
/* Removes "." and "", and each ".." with the part before it. False where it leads above its start, or is too long. */
bool daft_path_normalize(const char *path, char *out, size_t size);
/* Opens beneath a folder without openat2, for a path in normal form. -1: errno says why; ELOOP: a part is a link. */
int daft_open_walking(int folder, const char *path, int flags);

#endif
