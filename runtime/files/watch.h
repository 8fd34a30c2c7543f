/* watch: whether somebody has saved one of a game's files. */
#ifndef RUNTIME_FILES_WATCH_H
#define RUNTIME_FILES_WATCH_H

#include <stdbool.h>
#include <stdint.h>

typedef struct watch {
    const char *folder;
    uint64_t known, last; /* what stood there when it last said so; at the last look */
    uint64_t looked_ns, every_ns;
} watch;

/* `folder` must stay. NULL: nothing ever changes. */
void watch_begin(watch *self, const char *folder);
/* True once for each change of scripts, scenes, meshes, pictures and sounds in the folder and those within it, as soon
 * as two looks find the same: an editor may be at work. Looks 40 times a second, or as often as takes a hundredth of
 * the time; at times that ascend. */
bool watch_changed(watch *self, uint64_t now_ns);

#endif
