/* knobs: the settings of daft_quality that a sweep tries. What they mean is in the rows of daft_quality. */
#ifndef RUNTIME_ACCURACY_KNOBS_H
#define RUNTIME_ACCURACY_KNOBS_H

#include "daft.h"

enum { KNOBS = 14, KNOB_SETTINGS = 10 };

typedef struct knob_row {
    const char *name, *doc;
    const char *settings[KNOB_SETTINGS]; /* as --knobs takes them, cheapest first; NULL after the last */
} knob_row;

const knob_row *knob_at(size_t index);
/* NULL: there is none of that name. */
const knob_row *knob_named(const char *name);
size_t knob_count(const knob_row *knob);
/* A row of a user's own settings, "samples=8;edge_samples=16", of which each may set several knobs, apart by commas.
 * The row keeps pointers into `text`, which it cuts. False: see the error. */
bool knob_own(char *text, knob_row *out, daft_error *error);
/* Whether the setting casts camera rays one by one: slow where there is much to hit. */
bool knob_is_by_rays(const char *setting);

#endif
