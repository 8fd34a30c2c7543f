/* Fuzzing: each target is one function that takes any bytes as the input of one door of the engine and comes back. It
 * aborts (FUZZ_CHECK) when a promise is broken; crashes, leaks and undefined behaviour are the sanitizers' to find.
 * The same functions run under libFuzzer (main.c; ./daft test --fuzz) and over the seeds and the corpus of past crashes
 * in every test run (tests/fuzz/test_corpus.c). They keep nothing from one call to the next that could change a result.
 */
#ifndef DAFT_FUZZ_H
#define DAFT_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "daft.h"

typedef int fuzz_input(const uint8_t *data, size_t size);

fuzz_input obj_input;   /* an OBJ file, from memory */
fuzz_input mtl_input;   /* an MTL file, from memory */
fuzz_input scene_input; /* a .scene file beside a mesh, a material, a picture and another scene; then a picture of it */
fuzz_input image_input; /* an image file: as a picture, a texture and a sky */
fuzz_input render_input;    /* calls of daft.h, then pictures, rays and ticks */
fuzz_input lua_input;       /* main.lua of a game */
fuzz_input recording_input; /* a recording of a game's input */
fuzz_input pack_input;      /* a packed game */
fuzz_input calls_input;     /* calls of any function of daft.h, with any arguments */
fuzz_input state_input;     /* a saved state of bodies, or changes of a good one */
fuzz_input font_input;      /* a TrueType file; then text of it */

typedef struct fuzz_target {
    const char *name;
    fuzz_input *input;
    double seconds; /* of the processor, under sanitizers: an input that takes longer is a finding */
    bool sealed;    /* opens nothing but the fuzzer's folder, assets/ and scripts/ */
} fuzz_target;

enum { FUZZ_TARGET_COUNT = 11 };
extern const fuzz_target FUZZ_TARGETS[FUZZ_TARGET_COUNT];

/* Runs an input of the target, and aborts where it takes too long or, where the target is sealed, opens another file.
 */
int fuzz_run(const fuzz_target *target, const uint8_t *data, size_t size);

#define FUZZ_CHECK(condition)                                                                                          \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                    \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

/* Every error has a code and a message that fits and ends; a success has neither. */
void fuzz_check_error(bool good, const daft_error *error);

/* The folder that has assets/ and scripts/: the checkout, or where that is gone, daft/ beside the program. */
const char *fuzz_root(void);
/* A folder of this process with small assets: thing.obj, paint.mtl, picture.png, other.scene, self.scene (includes
 * itself). Made at the first call, removed when the process ends. */
const char *fuzz_folder(void);
/* Writes a file there and returns its path, which the next call overwrites. */
const char *fuzz_write(const char *name, const void *data, size_t size);

#endif
