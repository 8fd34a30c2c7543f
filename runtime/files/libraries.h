/* libraries: the shared libraries that this process has loaded, and which of them a program has to bring along so that
 * it runs on another machine of this kind.
 *
 * What every desktop has stays where it is, for two reasons: libraries that must fit the kernel, a driver or a server
 * of that machine (the C library, X11, Wayland, OpenGL, ALSA, PulseAudio), and those that the desktop's own libraries,
 * loaded into the same process, need in a version not older than theirs (libstdc++, GLib, D-Bus, zlib). The AppImage
 * project's excludelist tells where others learnt which these are. All else is brought along. */
#ifndef RUNTIME_FILES_LIBRARIES_H
#define RUNTIME_FILES_LIBRARIES_H

#include "common/util.h"

enum { LIBRARIES = 512 };

typedef struct library {
    char name[64]; /* as those that need it name it: libSDL2-2.0.so.0 */
    char path[PATH_SIZE];
} library;

typedef struct libraries {
    library carried[LIBRARIES];     /* sorted by name */
    const char *desktop[LIBRARIES]; /* names of those of a desktop that these and the program need, sorted */
    size_t carried_count, desktop_count;
    int glibc; /* the minor number of version 2 that these and the program need; 0: another C library */
} libraries;

/* Models of other formats than OBJ take Assimp, which is loaded when it is needed: now. */
bool libraries_load_assimp(daft_error *error);
/* False: this is not Linux, or a library is not where it should be. It may be large: 600 kB. */
bool libraries_find(libraries *out, daft_error *error);
/* Whether every desktop has the library. */
bool libraries_desktop_has(const char *name);

#endif
