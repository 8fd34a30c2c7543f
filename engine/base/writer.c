/* The safe writer: a temporary file, flushed, then renamed. See writer.h. */
#include "base/writer.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PREFIX ".daft-"
#define SUFFIX ".tmp"

enum {
    BUFFER = 1 << 16,
    NAME_SIZE = sizeof PREFIX + 16 + sizeof SUFFIX, /* 64 random bits in hexadecimal: short enough beside any name */
    TRIES = 16,
    STALE_SECONDS = 10 /* older than this, an unlocked file is not one that is being made */
};

struct daft_writer {
    daft_allocator allocator;
    char *path;
    const char *name; /* of the final file, in its folder */
    int folder, file; /* descriptors; -1: none */
    char temporary[NAME_SIZE];
    int failure;   /* errno of the first failure; 0: none */
    uint64_t size; /* bytes so far */
    size_t used;   /* of them in `buffer` */
    char buffer[BUFFER];
};

static bool cannot_write(daft_error *error, const char *path, int number)
{
    return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot write: %s", strerror(number));
}

static bool is_temporary(const char *name)
{
    size_t length = strlen(name);
    return length == NAME_SIZE - 2 && memcmp(name, PREFIX, sizeof PREFIX - 1) == 0 &&
           strcmp(name + length - (sizeof SUFFIX - 1), SUFFIX) == 0;
}

/* Removes a temporary file whose process is gone: its lock is free. */
static void remove_stale(int folder, const char *name)
{
    struct stat status;
    int file = openat(folder, name, O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return;
    bool old = fstat(file, &status) == 0 && S_ISREG(status.st_mode) && time(NULL) - status.st_mtime > STALE_SECONDS;
    if (old && flock(file, LOCK_EX | LOCK_NB) == 0) unlinkat(folder, name, 0);
    close(file);
}

static void remove_left_over(int folder)
{
    int copy = openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *list = copy < 0 ? NULL : fdopendir(copy);
    if (!list) {
        if (copy >= 0) close(copy);
        return;
    }
    for (struct dirent *entry; (entry = readdir(list));)
        if (is_temporary(entry->d_name)) remove_stale(folder, entry->d_name);
    closedir(list);
}

/* The name of an open file, where the system can tell. */
static bool name_of(int file, char *out, size_t size)
{
#if defined(F_GETPATH) /* macOS; at most PATH_MAX bytes, 1024 there */
    return size >= 1024 && fcntl(file, F_GETPATH, out) == 0;
#else
    char link[32];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, out, size - 1);
    if (length > 0) out[length] = 0;
    return length > 0;
#endif
}

void daft_remove_temporaries(void)
{
    enum { MOST_FILES = 4096, LONGEST = 4096 };
    char path[LONGEST];
    for (int file = 0; file < MOST_FILES; file++) {
        const char *slash = name_of(file, path, sizeof path) ? strrchr(path, '/') : NULL;
        if (slash && is_temporary(slash + 1)) unlink(path);
    }
}

/* The folder that `path` lies in. -1: errno says why. */
static int open_folder(const daft_allocator *allocator, const char *path, size_t length)
{
    if (length == 0) return open(".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    char *folder = daft_alloc(allocator, length + 1, 1);
    if (!folder) {
        errno = ENOMEM;
        return -1;
    }
    memcpy(folder, path, length);
    folder[length] = 0;
    int descriptor = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int number = errno;
    daft_release(allocator, folder);
    errno = number;
    return descriptor;
}

static bool make_temporary(daft_writer *writer, mode_t mode)
{
    for (int i = 0; i < TRIES; i++) {
        uint64_t number;
        if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) return false;
        snprintf(writer->temporary, sizeof writer->temporary, PREFIX "%016llx" SUFFIX, (unsigned long long)number);
        writer->file =
            openat(writer->folder, writer->temporary, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        if (writer->file >= 0)
            return flock(writer->file, LOCK_EX | LOCK_NB) == 0 || errno == ENOLCK || errno == ENOTSUP;
        if (errno != EEXIST) return false;
    }
    return false;
}

/* Whether `name` may be replaced, and the permissions that the new file takes over; *mode stays where there is none. */
static const char *refusal(int folder, const char *name, mode_t *mode, bool *exists)
{
    struct stat status;
    *exists = fstatat(folder, name, &status, AT_SYMLINK_NOFOLLOW) == 0;
    if (!*exists) return NULL;
    if (S_ISDIR(status.st_mode)) return "is a folder, not a file";
    if (S_ISLNK(status.st_mode)) return "is a symbolic link: name the file it leads to";
    if (!S_ISREG(status.st_mode)) return "is not a regular file";
    *mode = status.st_mode & 0777;
    return NULL;
}

static bool open_beside(daft_writer *writer, const char *path, daft_error *error)
{
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    mode_t mode = 0666;
    bool exists;
    writer->path = daft_copy_string(&writer->allocator, path);
    if (!writer->path) return daft_fail_memory(error, "a file name");
    writer->name = writer->path + length;
    if (!writer->name[0]) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is a folder, not a file");
    writer->folder = open_folder(&writer->allocator, path, length);
    if (writer->folder < 0 && errno == ENOMEM) return daft_fail_memory(error, "a file name");
    if (writer->folder < 0)
        return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open for writing: %s", strerror(errno));
    const char *why = refusal(writer->folder, writer->name, &mode, &exists);
    if (why) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "%s", why);
    remove_left_over(writer->folder);
    if (!make_temporary(writer, mode))
        return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open for writing: %s", strerror(errno));
    if (exists) fchmod(writer->file, mode); /* the umask does not change a file that was there */
    return true;
}

daft_writer *daft_writer_open(const daft_allocator *allocator, const char *path, daft_error *error)
{
    daft_writer *writer = daft_alloc(allocator, 1, sizeof *writer);
    if (!writer) {
        daft_fail_memory(error, "writing a file");
        return NULL;
    }
    memset(writer, 0, offsetof(daft_writer, buffer));
    writer->allocator = *allocator;
    writer->folder = writer->file = -1;
    if (open_beside(writer, path, error)) return writer;
    daft_writer_abandon(writer);
    return NULL;
}

static void write_all(daft_writer *writer, const char *bytes, size_t size)
{
    while (size > 0 && !writer->failure) {
        ssize_t done = write(writer->file, bytes, size);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) {
            writer->failure = done < 0 ? errno : EIO;
            return;
        }
        bytes += done, size -= (size_t)done;
    }
}

static void flush(daft_writer *writer)
{
    write_all(writer, writer->buffer, writer->used);
    writer->used = 0;
}

void daft_writer_put(daft_writer *writer, const void *bytes, size_t size)
{
    if (!writer || !bytes || size == 0) return;
    writer->size += size;
    if (size > BUFFER - writer->used) flush(writer);
    if (size > BUFFER) {
        write_all(writer, bytes, size);
        return;
    }
    memcpy(writer->buffer + writer->used, bytes, size);
    writer->used += size;
}

void daft_writer_print(daft_writer *writer, const char *format, ...)
{
    char text[1024], *long_text = NULL;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (length >= (int)sizeof text && (long_text = daft_alloc(&writer->allocator, (size_t)length + 1, 1))) {
        va_start(arguments, format);
        vsnprintf(long_text, (size_t)length + 1, format, arguments);
        va_end(arguments);
    }
    if (length < 0 || (length >= (int)sizeof text && !long_text)) {
        if (!writer->failure) writer->failure = ENOMEM;
    } else {
        daft_writer_put(writer, long_text ? long_text : text, (size_t)length);
    }
    daft_release(&writer->allocator, long_text);
}

void daft_writer_put_at(daft_writer *writer, uint64_t offset, const void *bytes, size_t size)
{
    if (!writer || !bytes || size == 0) return;
    flush(writer);
    if (!writer->failure && (offset > writer->size || size > writer->size - offset)) writer->failure = EINVAL;
    const char *at = bytes;
    while (size > 0 && !writer->failure) {
        ssize_t done = pwrite(writer->file, at, size, (off_t)offset);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) writer->failure = done < 0 ? errno : EIO;
        if (done > 0) at += done, offset += (uint64_t)done, size -= (size_t)done;
    }
}

/* fsync of a folder tells the disk about the new name; file systems that cannot say so. */
static bool sync_folder(int folder) { return fsync(folder) == 0 || errno == EINVAL || errno == ENOTSUP; }

bool daft_writer_commit(daft_writer *writer, daft_error *error)
{
    if (!writer) return daft_fail(error, DAFT_ERROR_ARGUMENT, "no file is being written");
    flush(writer);
    if (!writer->failure && fsync(writer->file) != 0) writer->failure = errno;
    if (!writer->failure && renameat(writer->folder, writer->temporary, writer->folder, writer->name) != 0)
        writer->failure = errno;
    bool placed = writer->failure == 0;
    if (placed) writer->temporary[0] = 0;
    if (placed && !sync_folder(writer->folder)) writer->failure = errno;
    bool good = writer->failure == 0 || cannot_write(error, writer->path, writer->failure);
    daft_writer_abandon(writer);
    return good;
}

void daft_writer_abandon(daft_writer *writer)
{
    if (!writer) return;
    if (writer->file >= 0 && writer->temporary[0]) unlinkat(writer->folder, writer->temporary, 0);
    if (writer->file >= 0) close(writer->file);
    if (writer->folder >= 0) close(writer->folder);
    daft_allocator allocator = writer->allocator;
    daft_release(&allocator, writer->path);
    daft_release(&allocator, writer);
}

daft_writer *daft_writer_begin(const char *path, daft_error *error)
{
    if (!path || !path[0]) {
        daft_fail(error, DAFT_ERROR_ARGUMENT, "no file name to write to");
        return NULL;
    }
    daft_allocator allocator = daft_malloc_allocator();
    return daft_writer_open(&allocator, path, error);
}

bool daft_write_file(const char *path, const void *bytes, size_t size, daft_error *error)
{
    if (!bytes && size > 0) return daft_fail(error, DAFT_ERROR_ARGUMENT, "no bytes to write");
    daft_writer *writer = daft_writer_begin(path, error);
    if (!writer) return false;
    if (size > 0) daft_writer_put(writer, bytes, size);
    return daft_writer_commit(writer, error);
}
