/* Reads whole files; joins paths. */
#include "base/base.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static char *read_open(const daft_allocator *allocator, FILE *file, const char *path, size_t expected, size_t *size,
                       daft_error *error)
{
    size_t capacity = expected + 1, used = 0;
    char *bytes = daft_alloc(allocator, capacity, 1);
    if (!bytes) {
        daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for a file of %zu bytes", expected);
        return NULL;
    }
    for (;;) {
        used += fread(bytes + used, 1, capacity - used - 1, file);
        if (ferror(file)) {
            daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot read: %s", strerror(errno));
            break;
        }
        if (feof(file)) {
            bytes[used] = 0;
            *size = used;
            return bytes;
        }
        if (used + 1 == capacity && !daft_grow(allocator, &bytes, &capacity, capacity + 1, used, 1)) {
            daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory after %zu bytes", used);
            break;
        }
    }
    daft_release(allocator, bytes);
    return NULL;
}

char *daft_file_read(const daft_allocator *allocator, const char *path, size_t *size, daft_error *error)
{
    struct stat status;
    if (stat(path, &status) != 0) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open: %s", strerror(errno));
        return NULL;
    }
    if (S_ISDIR(status.st_mode)) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is a directory, not a file");
        return NULL;
    }
    /* A scene from elsewhere may name any file; /dev/zero never ends. */
    if (S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode)) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is a device, not a file");
        return NULL;
    }
    FILE *file = fopen(path, "rb");
    if (!file) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open: %s", strerror(errno));
        return NULL;
    }
    char *bytes = read_open(allocator, file, path, status.st_size > 0 ? (size_t)status.st_size + 1 : 4096, size, error);
    fclose(file);
    return bytes;
}

bool daft_path_beside(const char *base, const char *path, char *out, size_t size)
{
    const char *slash = path[0] == '/' ? NULL : strrchr(base, '/');
    int folder = slash ? (int)(slash - base) + 1 : 0;
    int written = snprintf(out, size, "%.*s%s", folder, base, path);
    return written >= 0 && (size_t)written < size;
}

bool daft_file_exists(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && !S_ISDIR(status.st_mode);
}
