/* writer: the one safe way out. Every file that the engine or the program writes appears whole or not at all.
 *
 * Bytes go to a temporary file in the folder of the final name (random name, O_EXCL and O_NOFOLLOW). daft_writer_commit
 * flushes it to the disk, renames it over the final name and flushes the folder; until then the old file stays as it
 * was. A killed process leaves the temporary file behind; the next writer in that folder removes it: a temporary file
 * is locked (flock) for as long as its process lives. Promises: errors stick, so callers may check at the end; nothing
 * but a regular file is ever replaced. daft_write_file (daft.h) does all of it for bytes in memory. */
#ifndef DAFT_WRITER_H
#define DAFT_WRITER_H

#include "base/base.h"

typedef struct daft_writer daft_writer;

/* Opens a temporary file beside `path`. NULL: *error says why. Fails where `path` is a folder, a device, a pipe or a
 * socket. The final file keeps the permissions of the one it replaces, else it gets those of the umask. */
daft_writer *daft_writer_open(const daft_allocator *allocator, const char *path, daft_error *error);

/* Appends. After a failure both do nothing; daft_writer_commit tells. */
void daft_writer_put(daft_writer *writer, const void *bytes, size_t size);
void daft_writer_print(daft_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Writes over earlier bytes, for headers with sizes: the writer's position stays at the end. offset + size is within
 * what has been written. */
void daft_writer_put_at(daft_writer *writer, uint64_t offset, const void *bytes, size_t size);

/* Puts the file into place and frees the writer. False: the old file is as it was, and nothing else is left behind. */
bool daft_writer_commit(daft_writer *writer, daft_error *error);

/* Drops what was written and frees the writer. NULL is fine. */
void daft_writer_abandon(daft_writer *writer);

#endif
