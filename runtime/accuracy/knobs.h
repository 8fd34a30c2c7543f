/* knobs: what a picture may cost, by name. The names are those of daft_view's fields; `scale` is the program's own. */
#ifndef RUNTIME_ACCURACY_KNOBS_H
#define RUNTIME_ACCURACY_KNOBS_H

#include "daft.h"

/* A choice of all knobs. */
typedef struct knob_set {
    daft_view view;
    double scale; /* sides of the drawn picture, relative to the shown one, 0.1 to 1 */
} knob_set;

typedef struct knob_row {
    const char *name, *doc;
    double values[6]; /* that a sweep tries, cheapest first */
    size_t count;
} knob_row;

enum { KNOBS = 13 };
const knob_row *knob_at(size_t index);

/* Whether the setting casts camera rays one by one. */
bool knob_is_by_rays(size_t index, double value);
void knob_apply(knob_set *set, size_t index, double value);
/* "samples=4". Returns `out`. */
enum { KNOB_TEXT = 48 };
char *knob_print(char out[KNOB_TEXT], size_t index, double value);
/* Reads "samples=4,shadows=0" into the set. Fails where a name or a value is none. */
bool knobs_parse(const char *list, knob_set *out, daft_error *error);

#endif
