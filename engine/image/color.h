/* sRGB bytes and linear light, by table: for whole images. */
#ifndef DAFT_COLOR_H
#define DAFT_COLOR_H

#include "image/image.h"

/* 6 KB; made on the stack of whoever converts many pixels (the engine keeps no globals). */
typedef struct daft_srgb_table {
    float linear[256];       /* of each byte */
    float threshold[257];    /* byte b stands for threshold[b] <= light < threshold[b + 1] */
    uint8_t guess[4096 + 1]; /* the byte of light i/4096: at most a few steps below the right one */
} daft_srgb_table;

/* The texels of the equirectangular image of a cube, RGBA. */
void daft_cube_unroll(const daft_sky_image *cube, int width, int height, uint8_t *texels);

void daft_srgb_table_make(daft_srgb_table *table);

/* The byte whose encoded value is nearest; halves round up. Below 0 and NaN: 0. */
static inline uint8_t daft_srgb_byte(const daft_srgb_table *table, float linear)
{
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    unsigned byte = table->guess[(unsigned)(linear * 4096)];
    while (linear >= table->threshold[byte + 1]) byte++;
    return (uint8_t)byte;
}

#endif
