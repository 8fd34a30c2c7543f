/* Reads whole files; joins paths. */
#include "base/base.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Opening a pipe that nobody writes to returns at once with O_NONBLOCK; what the file is follows from fstat. */
enum { OPEN_FLAGS = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC };

/* A scene that somebody was sent may name anything: a sparse file of a terabyte takes no room on a disk. */
static const uint64_t MAX_BYTES = (uint64_t)2 << 30;

static const char *kind_of(mode_t mode)
{
    if (S_ISDIR(mode)) return "is a directory, not a file";
    if (S_ISCHR(mode) || S_ISBLK(mode)) return "is a device, not a file";
    if (S_ISFIFO(mode)) return "is a pipe, not a file";
    return S_ISSOCK(mode) ? "is a socket, not a file" : "is not a regular file";
}

/* Opens a regular file of at most MAX_BYTES. -1: *error says why not. */
static int open_regular(const char *path, size_t *size, daft_error *error)
{
    struct stat status;
    int file = open(path, OPEN_FLAGS);
    if (file < 0 && errno == ENXIO) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is a socket, not a file");
        return -1;
    }
    if (file < 0 || fstat(file, &status) != 0) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open: %s", strerror(errno));
    } else if (!S_ISREG(status.st_mode)) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "%s", kind_of(status.st_mode));
    } else if ((uint64_t)status.st_size > MAX_BYTES) {
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is larger than the %llu bytes that a file may have",
                     (unsigned long long)MAX_BYTES);
    } else {
        *size = (size_t)status.st_size;
        return file;
    }
    if (file >= 0) close(file);
    return -1;
}

/* What it held when it was opened, however it grows meanwhile. */
static bool read_bytes(int file, char *bytes, size_t size, const char *path, daft_error *error)
{
    for (size_t used = 0; used < size;) {
        ssize_t done = read(file, bytes + used, size - used);
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot read: %s", strerror(errno));
        if (done == 0) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "became shorter while it was read");
        used += (size_t)done;
    }
    bytes[size] = 0;
    return true;
}

char *daft_file_read(const daft_allocator *allocator, const char *path, size_t *size, daft_error *error)
{
    int file = open_regular(path, size, error);
    if (file < 0) return NULL;
    char *bytes = daft_alloc(allocator, *size + 1, 1);
    if (!bytes) daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for a file of %zu bytes", *size);
    if (bytes && !read_bytes(file, bytes, *size, path, error)) {
        daft_release(allocator, bytes);
        bytes = NULL;
    }
    close(file);
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
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}
