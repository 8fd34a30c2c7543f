/* writer: the one safe way out. Every file that the engine or the program writes appears whole or not at all.
 *
 * Bytes go to a temporary file in the folder of the final name (random name, O_EXCL and O_NOFOLLOW). daft_writer_commit
 * flushes it to the disk, renames it over the final name and flushes the folder; until then the old file stays as it
 * was. A killed process leaves the temporary file behind; the next writer in that folder removes it: a temporary file
 * is locked (flock) for as long as its process lives. Promises: errors stick, so callers may check at the end; nothing
 * but a regular file is ever replaced. Writing, committing
 * and abandoning are public: daft.h has them. */
#ifndef DAFT_WRITER_H
#define DAFT_WRITER_H

#include "base/base.h"

/* Opens a temporary file beside `path`. NULL: *error says why. Fails where `path` is a folder, a device, a pipe or a
 * socket. The final file keeps the permissions of the one it replaces, else it gets those of the umask. */
daft_writer *daft_writer_open(const daft_allocator *allocator, const char *path, daft_error *error);

/* Appends text. */
void daft_writer_print(daft_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
