/* cost: what accuracy costs: the quality presets, and later the metrics and the price list.
 * Promises: a preset is data; nothing else in the engine switches on its name. */
#ifndef DAFT_COST_H
#define DAFT_COST_H

#include "base/base.h"

typedef struct daft_preset {
    const char *name;
    int samples;      /* per pixel */
    int reflections;  /* mirror bounces followed; 0: none */
    int refractions;  /* surfaces that a path which passes through some may meet */
    float least_weight; /* mirrored and refracted rays whose share of a pixel is less in all colours are not cast */
    bool shadows;
    bool reference;   /* camera rays alone through the BVH */
} daft_preset;

const daft_preset *daft_quality_preset(daft_quality quality);

#endif
