/* archive: writes zip archives that are the same to the bit for the same files: times are the first that archives know,
 * and files are stored as they are, or deflated where that is asked for, by whatever zlib this system has. */
#ifndef RUNTIME_FILES_ARCHIVE_H
#define RUNTIME_FILES_ARCHIVE_H

#include "daft.h"

typedef struct archive archive;

typedef struct archive_def {
    void (*put)(void *user, const void *bytes, size_t size);
    void *user;
    uint64_t begin;   /* bytes of the file before the archive */
    bool deflate;     /* where this program has zlib */
    const char *path; /* for messages */
} archive_def;

/* NULL when out of memory. */
archive *archive_open(const archive_def *def, daft_error *error);
void archive_close(archive *self); /* NULL is fine */
/* `mode`: the file's permissions, as in 0644. The name is one that pack_name_is_good takes. */
bool archive_add(archive *self, const char *name, const void *bytes, size_t size, uint32_t mode, daft_error *error);
/* Adds what lies in the first root of `files`, with `prefix` before each name, sorted by name: all but names that begin
 * with a dot, and those that `leave` is true for (NULL: none). */
bool archive_add_folder(archive *self, const daft_files *files, const char *folder, const char *prefix,
                        bool (*leave)(const char *name), daft_error *error);
size_t archive_count(const archive *self); /* files */
/* What comes after the files: the directory, and then the end, with a comment of less than 64 kB. */
void archive_put_directory(archive *self);
void archive_put_end(archive *self, const char *comment);

#endif
