/* quality: which knobs a picture is drawn with: what the scene asks for or a preset, and single values over it. */
#ifndef RUNTIME_COMMON_QUALITY_H
#define RUNTIME_COMMON_QUALITY_H

#include "daft.h"

#define QUALITY_OF_SCENE ((daft_preset)-1)

typedef struct quality_wish {
    daft_preset preset; /* QUALITY_OF_SCENE: what the scene asks for */
    const char *knobs;  /* "samples=4,shadows=off", as quality_parse reads them; NULL: none */
} quality_wish;

/* Sets what the list names. A number may be a fraction: min_weight=1/64. Fails where a name or a value is none; the
 * quality is then as it was. */
bool quality_parse(const char *list, daft_quality *quality, daft_error *error);
/* Whether all knobs of two are the same. */
bool quality_equal(const daft_quality *a, const daft_quality *b);
/* The knobs have been checked. `scene` NULL: one that asks for nothing. */
daft_quality quality_choose(const quality_wish *wish, const daft_scene *scene);

#endif
