/* Every function of daft.h, called with chosen arguments. calls.awk reads the declarations and writes one call for
 * each; calls.c has the good arguments and the bad ones of each type. A new function is in the table by being declared;
 * a new type of argument needs its give_TYPE() in calls.c.
 *
 * In a table (caller_choose) all arguments but one are good. From bytes (caller_feed) each argument is whatever the
 * bytes say: fuzz/api.c. */
#ifndef DAFT_CALLS_H
#define DAFT_CALLS_H

#include "daft.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum verdict {
    VERDICT_GOOD, /* the call takes it */
    VERDICT_ODD,  /* it may or may not; nothing breaks */
    VERDICT_BAD,  /* the call fails with DAFT_ERROR_HANDLE or another error */
    VERDICT_WRONG /* the call fails with DAFT_ERROR_ARGUMENT */
} verdict;

enum { POOL = 16, LIST = 8 };

/* Handles of one kind: the first is what good calls get. `foreign`: as another scene's handle may look, whose number
 * can be that of one of this scene's. */
typedef struct pool {
    uint32_t ids[POOL];
    uint32_t count, stale, foreign;
} pool;

typedef struct caller {
    /* The world: */
    daft_engine *engine;
    daft_scene *scene;
    const char *paths[6];
    daft_image *image;
    daft_history *history;
    daft_files *files;   /* of `folder` */
    daft_writer *writer; /* of the one call that asked for it */
    pool entities, meshes, textures, materials, lights, joints, characters;
    void *saved; /* daft_scene_save_bodies of the scene as it was built */
    size_t saved_size;
    const char *folder; /* of calls_folder_make */
    int warnings;
    daft_allocator allocator; /* of the engine; all zero: malloc */
    daft_warning_callback *warn;
    void *warn_user;
    bool nested;  /* inside a callback: a scene that is destroyed there still stands */
    bool drawing; /* inside progress: so does the image */

    /* The choice: */
    int argument, variant; /* this argument takes this variant; -1: all are good */
    bool variants_left;    /* the chosen argument has a variant after this one */
    const uint8_t *bytes;  /* where every argument is chosen by bytes: those that are left */
    size_t byte_count;
    bool no_error; /* the error is NULL */

    /* What was given and came back: */
    int at;                      /* the argument that is asked for */
    const char *function, *name; /* and its name */
    verdict said;                /* the worst of all arguments */
    bool object_missing;         /* NULL in place of an engine, scene or image */
    daft_struct which;           /* the daft_struct among the arguments */
    size_t size;                 /* of the bytes among the arguments */
    bool succeeded;              /* it gave back true, a pointer, a handle or a count that is not 0 */
    daft_error error;
    _Alignas(16) char value[4096]; /* structs in and out */
    _Alignas(16) char output[4096];
    char text[256], path[512];
} caller;

typedef struct call {
    const char *function;
    void (*make)(caller *c);
    int arguments;
    bool reports; /* takes a daft_error */
    bool changes; /* is refused from inside a callback: takes a scene or an engine, and is no …_get_… */
} call;

extern const call CALLS[];
extern const size_t CALL_COUNT;

/* A folder with a file of each kind that is loaded, for `folder`. */
void calls_folder_make(char folder[64]);
void calls_folder_remove(const char *folder);

/* Builds the world: an engine and a scene with one or more of everything. */
void caller_open(caller *c);
void caller_close(caller *c);
/* All arguments good but `argument`. -1: all good. */
void caller_choose(caller *c, int argument, int variant);
void caller_feed(caller *c, const uint8_t *bytes, size_t count);
/* Calls CALLS[index] once, and mends the world. */
void caller_make(caller *c, size_t index);
/* Makes anew what a call has destroyed. Those from inside a callback leave this to the caller. */
void caller_mend(caller *c);

#endif
