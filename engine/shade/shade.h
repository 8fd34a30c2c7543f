/* shade: what a surface does with light: materials, lamps, sky, and the arithmetic of Lambert and Phong over batches.
 * Promises: linear light; the same bits on every instruction set. */
#ifndef DAFT_SHADE_H
#define DAFT_SHADE_H

#include "base/base.h"
#include "image/image.h"
#include "math/vec.h"

#define DAFT_NO_TEXTURE UINT32_MAX

/* A material as the kernels read it. */
typedef struct daft_surface {
    daft_vec3 ambient, diffuse, specular, emission, mirror; /* mirror: share times tint */
    float shininess;
    uint32_t texture; /* index into the snapshot's textures, or DAFT_NO_TEXTURE */
    daft_vec2 map_scale;
} daft_surface;

typedef struct daft_lamp {
    bool sun;
    bool casts_shadow;
    daft_vec3 position;  /* point, frame space */
    daft_vec3 to_light;  /* sun: unit, against its direction */
    daft_vec3 color;
} daft_lamp;

typedef enum daft_sky_kind { DAFT_SKY_COLOR = 0, DAFT_SKY_GRADIENT, DAFT_SKY_IMAGE } daft_sky_kind;

typedef struct daft_sky {
    daft_sky_kind kind;
    daft_vec3 zenith, horizon; /* colour: zenith alone */
    const daft_sky_image *image;
} daft_sky;

#endif
