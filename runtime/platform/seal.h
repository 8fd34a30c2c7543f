/* seal: takes from the process what a game does not need, by Landlock and a seccomp filter, where the system has them.
 *
 * A second wall behind the Lua sandbox and the loader (engine/base/files.h), for the day that one of these has a hole.
 * It is set up once the window is open, and cannot be undone: afterwards the calling thread and those it starts open
 * files for reading only where `readable` says and make and replace files only in the folders of `writable`; no thread
 * of the process opens a socket, starts a program or a process, looks into or signals another one, or reaches the calls
 * of the kernel that games have no use for (io_uring, bpf, mounts, keys, …): those fail with EPERM. What is open stays
 * open.
 *
 * Landlock concerns a thread and its children: threads that stand already, such as those of the window system and the
 * one that waits for signals, keep their files (Linux with Landlock ABI 8 can seal them too, and then it is done). None
 * of them runs what a game says. The engine's workers and the watchdog start later, and are sealed. */
#ifndef RUNTIME_PLATFORM_SEAL_H
#define RUNTIME_PLATFORM_SEAL_H

#include "daft.h"

enum { SEAL_PATHS = 16 };

/* Paths that are NULL, or are not there, are skipped. */
typedef struct seal_def {
    const char *readable[SEAL_PATHS]; /* files, and folders with what is in them */
    const char *writable[SEAL_PATHS]; /* folders: what is in them can be listed, made and replaced, but not read */
    bool window;                      /* what the window system may yet read is readable too */
} seal_def;

/* What the system has. */
typedef struct seal_ability {
    int landlock; /* the version of its interface; 0: none */
    bool seccomp;
    const char *obstacle; /* why neither is used here although the system may have them; or NULL */
} seal_ability;

seal_ability seal_look(void);
/* Sets up what there is. False: something that there is cannot be set up, and the rest is. */
bool seal_process(const seal_def *def, daft_error *error);
/* Some lines about what the system has and what that keeps away, on stdout. */
void seal_print_status(void);

#endif
