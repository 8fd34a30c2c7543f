/* Names, sizes and times of the files, as one number. */
#include "files/watch.h"

#include "common/util.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { DEEPEST = 8, MOST = 4096 };
/* Between two looks; the second one at something new; and where there are so many files that a look takes long. */
static const uint64_t EVERY_NS = 12000000, SOON_NS = 10000000, SELDOM_NS = 200000000;

/* What games load. Recordings and the like are written beside them while they run. */
static bool is_loaded(const char *name)
{
    static const char *const ENDS[] = {".lua", ".scene", ".obj", ".mtl",  ".png",  ".jpg", ".jpeg", ".hdr", ".bmp",
                                       ".tga", ".gif",   ".ppm", ".gltf", ".glb",  ".bin", ".fbx",  ".dae", ".ply",
                                       ".stl", ".3ds",   ".wav", ".ogg",  ".flac", ".mp3", ".ttf"};
    if (strncmp(name, "daft-", 5) == 0) return false; /* F12 */
    for (size_t i = 0; i < COUNT_OF(ENDS); i++)
        if (has_extension(name, ENDS[i])) return true;
    return false;
}

static uint64_t hash_of(const char *path, const struct stat *status)
{
    const int64_t parts[3] = {(int64_t)status->st_size, (int64_t)status->st_mtim.tv_sec,
                              (int64_t)status->st_mtim.tv_nsec};
    return daft_hash(parts, sizeof parts, daft_hash(path, strlen(path), 1));
}

/* A sum, since folders list their files in any order. */
static uint64_t look(const char *folder, int depth, int *left)
{
    uint64_t sum = 0;
    DIR *list = opendir(folder);
    for (struct dirent *item; list && *left > 0 && (item = readdir(list));) {
        char path[PATH_SIZE];
        struct stat status;
        if (item->d_name[0] == '.' || !path_join(path, sizeof path, folder, item->d_name)) continue;
        --*left;
        if (stat(path, &status) != 0) continue;
        if (S_ISDIR(status.st_mode) && depth < DEEPEST)
            sum += look(path, depth + 1, left);
        else if (S_ISREG(status.st_mode) && is_loaded(item->d_name))
            sum += hash_of(path, &status);
    }
    if (list) closedir(list);
    return sum;
}

static uint64_t look_once(const watch *self)
{
    int left = MOST;
    return self->folder ? look(self->folder, 0, &left) : 0;
}

void watch_begin(watch *self, const char *folder)
{
    *self = (watch){.folder = folder, .every_ns = EVERY_NS};
    self->known = self->last = look_once(self);
}

bool watch_changed(watch *self, uint64_t now_ns)
{
    const uint64_t wait = self->last != self->known ? SOON_NS : self->every_ns;
    if (!self->folder || now_ns - self->looked_ns < wait) return false;
    const uint64_t began = clock_now_ns(), now = look_once(self), before = self->last;
    const uint64_t least = 100 * (clock_now_ns() - began);
    self->every_ns = least < EVERY_NS ? EVERY_NS : least < SELDOM_NS ? least : SELDOM_NS;
    self->looked_ns = now_ns, self->last = now;
    if (now != before || now == self->known) return false;
    self->known = now;
    return true;
}
