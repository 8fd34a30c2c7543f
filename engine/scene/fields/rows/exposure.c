/* Exposure and tone curve: the same names in C, .scene files and Lua. */
#include "scene/fields/fields.h"

static const char *const CURVES[] = {"none", "aces", "agx"};

static const daft_field ROWS[] = {
    DAFT_ROW(daft_exposure, ev, .lua = "ev", .scene = "ev", .unit = "stops", FROM(-24, 24),
             .doc = "Light is times 2^ev; where it is metered, so much brighter than it would be"),
    DAFT_ROW(daft_exposure, automatic, .lua = "auto",
             .doc = "Whether light is metered: the picture's mean of log2 luminance becomes middle grey, 0.18"),
    DAFT_CHOICE_ROW(daft_exposure, curve, CURVES, .lua = "curve", .scene = "curve",
                    .doc = "How light that is brighter than white is shown: as white, or by a film's curve"),
};

const daft_field_list daft_exposure_fields = DAFT_FIELD_LIST(daft_exposure, ROWS);
