/* Files of a pack on the disk. */
#include "stub/unpack.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#define TEMPORARY ".unpack-"

enum { LONG_PATH = 2 * PATH_SIZE };

static bool io_failure(daft_error *error, const char *path)
{
    return fail(error, DAFT_ERROR_IO, "%s: %s", path, strerror(errno));
}

/* ---- one after the other ---- */

static bool write_all(int file, const char *bytes, size_t size)
{
    while (size > 0) {
        const ssize_t done = write(file, bytes, size);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) return false;
        bytes += done, size -= (size_t)done;
    }
    return true;
}

static bool make_parents(char *path, size_t skipped)
{
    for (char *at = path + skipped + 1; *at; at++) {
        if (*at != '/') continue;
        *at = 0;
        const bool made = mkdir(path, 0700) == 0 || errno == EEXIST;
        *at = '/';
        if (!made) return false;
    }
    return true;
}

static bool write_file(const char *folder, const pack_file *file, const char *bytes, daft_error *error)
{
    char path[LONG_PATH];
    if (!path_join(path, sizeof path, folder, file->name))
        return fail(error, DAFT_ERROR_IO, "%s: the path is too long", folder);
    const int flags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
    const int out = make_parents(path, strlen(folder)) ? open(path, flags, file->runs ? 0700 : 0600) : -1;
    if (out < 0) return io_failure(error, path);
    const bool written = write_all(out, bytes, (size_t)file->size);
    const int why = errno;
    const bool closed = close(out) == 0;
    if (written && closed) return true;
    if (!written) errno = why;
    return io_failure(error, path);
}

static bool unpack_file(pack *from, const char *folder, const pack_file *file, daft_error *error)
{
    char *bytes = malloc((size_t)file->size + 1);
    if (!bytes) return fail(error, DAFT_ERROR_MEMORY, "out of memory");
    *error = (daft_error){0};
    const bool read = pack_read(from, file->name, bytes, file->size, error) == (int64_t)file->size;
    if (!read) fail(error, DAFT_ERROR_SYNTAX, "'%s' in it is damaged", file->name);
    const bool good = read && write_file(folder, file, bytes, error);
    free(bytes);
    return good;
}

/* Programs that lie where none may be started are of no use. */
static bool may_run(const char *folder, daft_error *error)
{
    struct statvfs status;
    if (statvfs(folder, &status) != 0) return io_failure(error, folder);
    return !(status.f_flag & ST_NOEXEC) || fail(error, DAFT_ERROR_IO, "%s: no program may be started there", folder);
}

bool unpack_into(pack *from, const char *folder, daft_error *error)
{
    if (!may_run(folder, error)) return false;
    for (size_t i = 0; i < pack_count(from); i++) {
        const pack_file file = pack_file_at(from, i);
        if (!unpack_file(from, folder, &file, error)) return false;
    }
    return true;
}

static int remove_one(const char *path, const struct stat *status, int type, struct FTW *where)
{
    (void)status, (void)type, (void)where;
    remove(path);
    return 0;
}

void unpack_remove(const char *folder)
{
    enum { DESCRIPTORS = 16 };
    nftw(folder, remove_one, DESCRIPTORS, FTW_DEPTH | FTW_PHYS);
}

/* ---- once ---- */

static bool is_own_folder(const char *path)
{
    struct stat status;
    return lstat(path, &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid();
}

bool unpack_is_there(const pack *from, const char *top, const char *name)
{
    char folder[LONG_PATH], path[2 * LONG_PATH];
    if (!path_join(folder, sizeof folder, top, name) || !is_own_folder(folder)) return false;
    for (size_t i = 0; i < pack_count(from); i++) {
        const pack_file file = pack_file_at(from, i);
        struct stat status;
        if (!path_join(path, sizeof path, folder, file.name) || lstat(path, &status) != 0) return false;
        if (!S_ISREG(status.st_mode) || (uint64_t)status.st_size != file.size) return false;
    }
    return true;
}

/* A folder that its maker holds locked is being filled; one of the last minute may be locked in a moment. */
static void remove_stale(const char *path)
{
    enum { SECONDS = 60 };
    struct stat status;
    const int folder = open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) return;
    const bool old = fstat(folder, &status) == 0 && status.st_mtime + SECONDS < time(NULL);
    if (old && flock(folder, LOCK_EX | LOCK_NB) == 0) unpack_remove(path);
    close(folder);
}

static void remove_left_over(const char *top)
{
    char path[LONG_PATH];
    DIR *list = opendir(top);
    if (!list) return;
    for (struct dirent *entry; (entry = readdir(list));)
        if (strncmp(entry->d_name, TEMPORARY, strlen(TEMPORARY)) == 0 &&
            path_join(path, sizeof path, top, entry->d_name))
            remove_stale(path);
    closedir(list);
}

/* Gives what was unpacked its name. Another process may have been faster; what has the name and is not whole, since
 * somebody removed some of its files, makes way. */
static bool put_in_place(pack *from, const char *made, const char *top, const char *name, daft_error *error)
{
    char folder[LONG_PATH], aside[LONG_PATH];
    path_join(folder, sizeof folder, top, name);
    if (rename(made, folder) == 0) return true;
    if (errno != EEXIST && errno != ENOTEMPTY && errno != ENOTDIR) return io_failure(error, folder);
    if (unpack_is_there(from, top, name)) {
        unpack_remove(made);
        return true;
    }
    path_join(aside, sizeof aside, top, TEMPORARY "XXXXXX");
    if (!mkdtemp(aside)) return io_failure(error, aside);
    const bool good = rename(folder, aside) == 0 && rename(made, folder) == 0;
    if (!good) io_failure(error, folder);
    unpack_remove(aside);
    return good;
}

bool unpack_once(pack *from, const char *top, const char *name, daft_error *error)
{
    char made[LONG_PATH];
    if (unpack_is_there(from, top, name)) return true;
    remove_left_over(top);
    if (!path_join(made, sizeof made, top, TEMPORARY "XXXXXX"))
        return fail(error, DAFT_ERROR_IO, "%s: the path is too long", top);
    if (!mkdtemp(made)) return io_failure(error, top);
    const int folder = open(made, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    bool good = folder >= 0 && flock(folder, LOCK_EX | LOCK_NB) == 0;
    if (!good) io_failure(error, made);
    good = good && unpack_into(from, made, error);
    if (good) syncfs(folder); /* a name that outlasts a crash has its files */
    good = good && put_in_place(from, made, top, name, error);
    if (folder >= 0) close(folder);
    if (!good) unpack_remove(made);
    return good;
}
