/* Opens and reads files; joins paths. See files.h. */
#include "base/files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined(__has_include)
#if __has_include(<linux/openat2.h>) && defined(SYS_openat2)
#include <linux/openat2.h>
#define HAS_OPENAT2 1
#endif
#endif

#ifndef O_PATH
#define O_PATH O_RDONLY /* of folders: elsewhere than on Linux, they must be readable */
#endif

/* Opening a pipe that nobody writes to returns at once with O_NONBLOCK; what the file is follows from fstat. */
enum { OPEN_FLAGS = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, LONGEST_PATH = 4096, MAX_ROOTS = 16 };

/* A scene that somebody was sent may name anything: a sparse file of a terabyte takes no room on a disk. */
static const uint64_t MAX_BYTES = (uint64_t)2 << 30;

typedef struct root {
    char *folder;
    size_t length;  /* of `folder`, without slashes at its end */
    int descriptor; /* -1: `read` has the files */
    daft_read_callback *read;
    daft_list_callback *list;
    void *user;
} root;

struct daft_files {
    daft_allocator allocator;
    uint64_t max_bytes;
    uint32_t count;
    root roots[MAX_ROOTS];
};

/* ---- paths ---- */

bool daft_path_beside(const char *base, const char *path, char *out, size_t size)
{
    const char *slash = path[0] == '/' ? NULL : strrchr(base, '/');
    int folder = slash ? (int)(slash - base) + 1 : 0;
    int written = snprintf(out, size, "%.*s%s", folder, base, path);
    return written >= 0 && (size_t)written < size;
}

static bool is_part(const char *part, size_t length, const char *what)
{
    return length == strlen(what) && memcmp(part, what, length) == 0;
}

bool daft_path_normalize(const char *path, char *out, size_t size)
{
    size_t used = 0;
    for (const char *part = path; *part;) {
        size_t length = strcspn(part, "/");
        if (is_part(part, length, "..")) {
            if (used == 0) return false;
            while (used > 0 && out[--used] != '/') continue;
        } else if (length > 0 && !is_part(part, length, ".")) {
            if (used + length + 2 > size) return false;
            if (used > 0) out[used++] = '/';
            memcpy(out + used, part, length);
            used += length;
        }
        part += length + (part[length] == '/');
    }
    out[used] = 0;
    return true;
}

/* The part of `path` beneath the root's folder, or NULL. */
static const char *beneath(const root *r, const char *path)
{
    if (strncmp(path, r->folder, r->length) != 0) return NULL;
    return path[r->length] == '/' || path[r->length] == 0 ? path + r->length + (path[r->length] == '/') : NULL;
}

/* Which roots a path may lie in: those from *first to *last. */
static const char *choose_roots(const daft_files *files, const char *path, uint32_t *first, uint32_t *last)
{
    for (uint32_t i = 0; i < files->count; i++) {
        const char *inner = beneath(&files->roots[i], path);
        if (!inner) continue;
        *first = i, *last = i + 1;
        return inner;
    }
    *first = 0, *last = files->count;
    return path[0] == '/' ? NULL : path;
}

static bool lead_outside(daft_error *error, const char *path)
{
    return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "leads outside the folders that its files may be in");
}

/* ---- opening ---- */

int daft_open_walking(int folder, const char *path, int flags)
{
    char part[NAME_MAX + 1];
    int at = folder;
    for (;;) {
        size_t length = strcspn(path, "/");
        bool is_last = path[length] == 0;
        int next = -1;
        if (length < sizeof part) {
            memcpy(part, path, length);
            part[length] = 0;
            next = openat(at, part, is_last ? flags | O_NOFOLLOW : O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        } else {
            errno = ENAMETOOLONG;
        }
        int number = errno;
        if (at != folder) close(at);
        errno = number;
        if (next < 0 || is_last) return next;
        at = next;
        path += length + 1;
    }
}

static int open_beneath(int folder, const char *path, int flags)
{
#ifdef HAS_OPENAT2
    struct open_how how = {.flags = (unsigned)flags, .resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS};
    int file = (int)syscall(SYS_openat2, folder, path, &how, sizeof how);
    /* A system without the call, a filter that does not know it, and a tree that is being moved: the walk decides. */
    if (file >= 0 || (errno != ENOSYS && errno != EPERM && errno != EINVAL && errno != EAGAIN)) return file;
#endif
    return daft_open_walking(folder, path, flags);
}

static const char *kind_of(mode_t mode)
{
    if (S_ISDIR(mode)) return "is a directory, not a file";
    if (S_ISCHR(mode) || S_ISBLK(mode)) return "is a device, not a file";
    if (S_ISFIFO(mode)) return "is a pipe, not a file";
    return S_ISSOCK(mode) ? "is a socket, not a file" : "is not a regular file";
}

/* An open file, or one that a callback has. */
typedef struct opened {
    const root *from; /* of a callback; NULL: a file of the disk */
    int file;
    uint64_t size;
    char inner[LONGEST_PATH]; /* the path beneath its root */
} opened;

static bool check_size(const daft_files *files, const char *path, uint64_t size, daft_error *error)
{
    uint64_t max = files ? files->max_bytes : MAX_BYTES;
    return size <= max || daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0,
                                       "is larger than the %llu bytes that a file may have", (unsigned long long)max);
}

/* Takes the descriptor, whose opening may have failed. */
static bool take_file(opened *out, int file, const daft_files *files, const char *path, daft_error *error)
{
    struct stat status;
    out->file = file;
    if (file < 0 && errno == ENXIO) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is a socket, not a file");
    if (file < 0 && files && errno == ELOOP)
        return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "is a symbolic link, or lies behind one");
    if (file < 0 || fstat(file, &status) != 0)
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open: %s", strerror(errno));
    else if (!S_ISREG(status.st_mode))
        daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "%s", kind_of(status.st_mode));
    else if (check_size(files, path, (uint64_t)status.st_size, error)) {
        out->size = (uint64_t)status.st_size;
        return true;
    }
    if (file >= 0) close(file);
    return false;
}

static bool open_called(opened *out, const root *r, const daft_files *files, const char *path, daft_error *error)
{
    daft_error why = {0};
    int64_t size = r->read(r->user, out->inner, NULL, 0, &why);
    if (size < 0 && why.code) return daft_fail_at(error, why.code, path, 0, 0, "%s", why.message);
    if (size < 0) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot open: %s", strerror(ENOENT));
    out->from = r;
    out->size = (uint64_t)size;
    return check_size(files, path, out->size, error);
}

static bool open_in(opened *out, const root *r, const daft_files *files, const char *path, daft_error *error)
{
    if (r->read) return open_called(out, r, files, path, error);
    const char *inner = out->inner[0] ? out->inner : ".";
    return take_file(out, open_beneath(r->descriptor, inner, OPEN_FLAGS), files, path, error);
}

/* A relative path is found in the first root that has it; the message is that of the first root. */
static bool open_any(opened *out, const daft_files *files, const char *path, daft_error *error)
{
    out->from = NULL;
    if (!files) return take_file(out, open(path, OPEN_FLAGS), NULL, path, error);
    uint32_t first, last;
    const char *inner = choose_roots(files, path, &first, &last);
    if (!inner || !daft_path_normalize(inner, out->inner, sizeof out->inner)) return lead_outside(error, path);
    for (uint32_t i = first; i < last; i++)
        if (open_in(out, &files->roots[i], files, path, i == first ? error : NULL)) {
            daft_error_clear(error);
            return true;
        }
    return false;
}

static void close_any(const opened *it)
{
    if (!it->from) close(it->file);
}

/* ---- reading ---- */

/* What it held when it was opened, however it grows meanwhile. */
static bool read_disk(int file, char *bytes, size_t size, const char *path, daft_error *error)
{
    for (size_t used = 0; used < size;) {
        ssize_t done = read(file, bytes + used, size - used);
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "cannot read: %s", strerror(errno));
        if (done == 0) return daft_fail_at(error, DAFT_ERROR_IO, path, 0, 0, "became shorter while it was read");
        used += (size_t)done;
    }
    return true;
}

static bool read_bytes(const opened *it, char *bytes, const char *path, daft_error *error)
{
    daft_error why = {0};
    if (!it->from) return read_disk(it->file, bytes, (size_t)it->size, path, error);
    if (it->from->read(it->from->user, it->inner, bytes, it->size, &why) == (int64_t)it->size) return true;
    return daft_fail_at(error, why.code ? why.code : DAFT_ERROR_IO, path, 0, 0, "%s",
                        why.code ? why.message : "changed while it was read");
}

char *daft_file_read(const daft_allocator *allocator, const daft_files *files, const char *path, size_t *size,
                     daft_error *error)
{
    opened it;
    if (!open_any(&it, files, path, error)) return NULL;
    *size = (size_t)it.size;
    char *bytes = daft_alloc(allocator, *size + 1, 1);
    if (!bytes) daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for a file of %zu bytes", *size);
    if (bytes && !read_bytes(&it, bytes, path, error)) {
        daft_release(allocator, bytes);
        bytes = NULL;
    }
    close_any(&it);
    if (bytes) bytes[*size] = 0;
    return bytes;
}

bool daft_file_exists(const daft_files *files, const char *path)
{
    opened it;
    if (!open_any(&it, files, path, NULL)) return false;
    close_any(&it);
    return true;
}

bool daft_file_identify(const daft_files *files, const char *path, daft_file_id *out)
{
    opened it;
    struct stat status;
    if (!open_any(&it, files, path, NULL)) return false;
    bool known = it.from || fstat(it.file, &status) == 0;
    if (it.from)
        *out = (daft_file_id){(uint64_t)(uintptr_t)it.from, daft_hash(it.inner, strlen(it.inner), 0), it.size, 0, 0};
    else if (known)
        *out = (daft_file_id){(uint64_t)status.st_dev, (uint64_t)status.st_ino, (uint64_t)status.st_size,
                              (uint64_t)status.st_mtim.tv_sec, (uint64_t)status.st_mtim.tv_nsec};
    close_any(&it);
    return known;
}

/* ---- public ---- */

daft_files_def daft_default_files_def(void)
{
    return (daft_files_def){.cookie = DAFT_COOKIE, .max_file_bytes = MAX_BYTES};
}

static bool open_root(daft_files *files, const daft_root *from, daft_error *error)
{
    root *r = &files->roots[files->count];
    if (!from->folder) return daft_fail(error, DAFT_ERROR_ARGUMENT, "the folder of root %u is NULL", files->count);
    *r = (root){.descriptor = -1, .read = from->read, .list = from->list, .user = from->user};
    r->folder = daft_copy_string(&files->allocator, from->folder);
    if (!r->folder) return daft_fail_memory(error, "a folder's name");
    files->count++;
    for (r->length = strlen(r->folder); r->length > 0 && r->folder[r->length - 1] == '/';) r->length--;
    if (r->read) return true;
    r->descriptor = open(from->folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
    return r->descriptor >= 0 ||
           daft_fail_at(error, DAFT_ERROR_IO, from->folder, 0, 0, "cannot open the folder: %s", strerror(errno));
}

static bool check_def(const daft_files_def *def, daft_error *error)
{
    if (!def) return daft_fail(error, DAFT_ERROR_ARGUMENT, "def is NULL");
    if (def->cookie != DAFT_COOKIE)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "the definition did not come from daft_default_files_def");
    if (def->root_count > MAX_ROOTS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "%u roots; there may be %d", def->root_count, MAX_ROOTS);
    return !def->root_count || def->roots || daft_fail(error, DAFT_ERROR_ARGUMENT, "roots is NULL");
}

daft_files *daft_files_create(const daft_files_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!check_def(def, error)) return NULL;
    daft_allocator allocator = daft_malloc_allocator();
    daft_files *files = daft_alloc_zero(&allocator, 1, sizeof *files);
    if (!files) {
        daft_fail_memory(error, "a set of folders");
        return NULL;
    }
    files->allocator = allocator;
    files->max_bytes = def->max_file_bytes && def->max_file_bytes < MAX_BYTES ? def->max_file_bytes : MAX_BYTES;
    for (uint32_t i = 0; i < def->root_count; i++)
        if (!open_root(files, &def->roots[i], error)) {
            daft_files_destroy(files);
            return NULL;
        }
    return files;
}

void daft_files_destroy(daft_files *files)
{
    if (!files) return;
    daft_allocator allocator = files->allocator;
    for (uint32_t i = 0; i < files->count; i++) {
        if (files->roots[i].descriptor >= 0) close(files->roots[i].descriptor);
        daft_release(&allocator, files->roots[i].folder);
    }
    daft_release(&allocator, files);
}

void *daft_read_file(const daft_files *files, const char *path, size_t *size, daft_error *error)
{
    daft_error_clear(error);
    size_t unused;
    daft_allocator allocator = daft_malloc_allocator();
    if (path) return daft_file_read(&allocator, files, path, size ? size : &unused, error);
    daft_fail(error, DAFT_ERROR_ARGUMENT, "path is NULL");
    return NULL;
}

bool daft_files_find(const daft_files *files, const char *name, char *path, size_t size)
{
    opened it;
    if (!files || !name || !path || name[0] == '/' || !daft_path_normalize(name, it.inner, sizeof it.inner))
        return false;
    for (uint32_t i = 0; i < files->count; i++) {
        const root *r = &files->roots[i];
        it.from = NULL;
        if (!open_in(&it, r, files, name, NULL)) continue;
        close_any(&it);
        int written = snprintf(path, size, "%.*s/%s", (int)r->length, r->folder, it.inner);
        return written >= 0 && (size_t)written < size;
    }
    return false;
}

/* False: the folder is there, but cannot be read to its end. */
static bool list_disk(const root *r, const char *folder, daft_name_callback *found, void *user)
{
    int file = open_beneath(r->descriptor, folder[0] ? folder : ".", O_RDONLY | O_DIRECTORY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return errno == ENOENT || errno == ENOTDIR;
    DIR *entries = fdopendir(file);
    if (!entries) {
        close(file);
        return false;
    }
    errno = 0;
    for (struct dirent *entry; (entry = readdir(entries)); errno = 0)
        if (entry->d_name[0] != '.') found(user, entry->d_name);
    bool whole = errno == 0;
    closedir(entries);
    return whole;
}

bool daft_files_list(const daft_files *files, const char *folder, daft_name_callback *found, void *user)
{
    char inner[LONGEST_PATH];
    if (!files || !folder || !found || folder[0] == '/' || !daft_path_normalize(folder, inner, sizeof inner))
        return false;
    bool whole = true;
    for (uint32_t i = 0; i < files->count; i++) {
        const root *r = &files->roots[i];
        if (!r->read)
            whole &= list_disk(r, inner, found, user);
        else if (r->list)
            r->list(r->user, inner, found, user);
    }
    return whole;
}
