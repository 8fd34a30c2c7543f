/* Places of triangles with alpha in their materials' masks (accel.h), and their holes before the camera: pixels that
 * meet one see what lies behind. Such a place gives a pixel nothing of its own light and all of what is behind; without
 * this a ray would go on from there, to the next hole maybe. Where the cells do not tell, and the material has a
 * cutoff, the texture is read as the pixel's filter does (shade/texture_kernel.c), and what surely lies under the
 * cutoff is passed over, too. What is no sure hole is a hit as any other, and told apart when it is shaded. */
#ifndef DAFT_HOLES_H
#define DAFT_HOLES_H

#include "raster/raster.h"

/* A triangle's texture coordinates, rows counted from the top: at its first corner, and what the others add. */
typedef struct daft_mask_triangle {
    const daft_mask *mask;
    float u, v, u1, v1, u2, v2;
    float left_u, left_v; /* what coordinates may be off by beside their own roundings */
    float most;           /* and weights of the corners */
} daft_mask_triangle;

static inline const daft_mask *daft_mask_of(const daft_instance *s, uint32_t triangle)
{
    return s->masks ? &s->masks[s->mesh->slots ? s->mesh->slots[triangle] : 0] : NULL;
}

/* Of a mask with cells. */
daft_mask_triangle daft_mask_triangle_of(const daft_mask *mask, const daft_trimesh *mesh, uint32_t triangle);

/* A tile as holes need it. */
typedef struct daft_hole_view {
    float left, top, focal; /* the ray of its first pixel, before it is turned */
    float turn;             /* daft_pencil's */
    float own;              /* the picture's focal length: its own pixels count, of which a fine tile's are fractions */
    float side;             /* rays of a row */
    float slant;            /* the largest length of a ray, its part forwards being 1 */
    const daft_texture_data *textures; /* the raster's */
} daft_hole_view;
/* Of rays of the pencil, from (x, y) on. */
daft_hole_view daft_hole_view_of(const daft_raster *raster, const daft_pencil *pencil, int x, int y, int side);

/* Texture coordinates are u / s and v / s, each an affine function of columns and rows of the tile: the value at its
 * first pixel, what a column adds, and a row. */
typedef struct daft_holes {
    bool known, none; /* the caller's: whether this is set up, and whether that found none */
    daft_mask_triangle on;
    float s[3], u[3], v[3];
    float turn;
    float off_s, off_u, off_v;          /* what these are off by */
    float least_s[1 << DAFT_MASK_BITS]; /* by cells: from where on pixels are no larger than these say */
    /* Texels that a pixel is as large as: area · |d|² / (s² · max(|s| / |d|, grazing)) of the ray d, whose parts are
     * left + column, top - row and focal. */
    const daft_texture_data *texture; /* of alpha; NULL: cells alone tell */
    float area, grazing, left, top, focal2;
} daft_holes;

/* Seen at less than this cosine, a pixel's patch is as large as at this: as render/points/surface_kernel.c has it. */
#define DAFT_HOLE_GRAZING 0.01f
/* How much alpha must be under the cutoff, beside what coordinates are off by: levels and filters round. */
#define DAFT_HOLE_MARGIN 0x1p-10f
/* Texels of the finest level alone are read where a pixel's area is no larger: 2^(1/2). */
#define DAFT_HOLE_FINEST 1.414f

/* False: it has none, or is too small in the picture to ask. */
bool daft_holes_make(const daft_hole_view *view, const daft_view_instance *instance, uint32_t triangle,
                     daft_holes *out);
/* Whether the pixel is in one. raster/grid/holes_kernel.c does the same in lanes, bit for bit. */
bool daft_in_hole(const daft_holes *h, int column, int row);

#endif
