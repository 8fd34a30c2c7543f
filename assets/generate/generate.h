/* The generator of everything in assets/ that is not written by hand: a font, textures, a sky, meshes and their
 * materials. What it makes is committed, so nobody needs it to play; it is here so that nothing in assets/ is of
 * unknown origin. Same program, same libm, same bytes: noise comes from hashes of lattice points, not from a clock. */
#ifndef DAFT_GENERATE_H
#define DAFT_GENERATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* One function for each kind. `root` is the checkout; false after a message on stderr. */
bool generate_font(const char *root);
bool generate_textures(const char *root);
bool generate_sky(const char *root);
bool generate_dusk(const char *root);
bool generate_meshes(const char *root);
bool generate_hard(const char *root);
bool generate_forest(const char *root);
bool generate_hall(const char *root);
bool generate_town(const char *root);
bool generate_studio(const char *root);
bool generate_figure(const char *root);
bool generate_leaves(const char *root);
bool generate_gallery(const char *root);
bool generate_wine(const char *root);
bool generate_neon(const char *root);
bool generate_sculptures(const char *root); /* of the hall */
bool generate_exhibits(const char *root);   /* of the gallery */
bool generate_statues(const char *root);    /* of the gallery */
bool generate_paintings(const char *root);  /* of the gallery */

/* Opens root/path for writing in binary; NULL after a message on stderr. */
FILE *open_output(const char *root, const char *path);
/* Closes it; false (after a message) if any write had failed. */
bool close_output(FILE *file, const char *path);

/* ---- pictures (picture.c) ---- */

typedef struct color {
    double r, g, b; /* sRGB-encoded, 0..1: the generator mixes colours as a painter would see them */
} color;

typedef struct picture {
    int width, height;
    uint8_t *pixels; /* RGB, top row first */
} picture;

/* What a texture is at u, v in 0..1, v = 0 at the bottom. */
typedef color painter(double u, double v);

color rgb(int hex);                    /* 0xrrggbb */
color mix(color a, color b, double t); /* t is clamped to 0..1 */
color shade(color c, double factor);
double clamp01(double x);
double smoothstep(double low, double high, double x);

/* Paints size×size pixels with 3×3 samples each and writes a PNG, or a JPEG where the name ends so. */
bool paint_square(const char *root, const char *path, int size, painter *paint);
bool write_jpeg(const char *root, const char *path, const picture *p, int quality);
/* Radiance RGBE, of linear light, three floats a pixel. */
bool write_hdr(const char *root, const char *path, int width, int height, const float *light);

/* How far a place of the town's cobbles is inside its stone, 0 where two meet; and which stone (town.c). */
double cobble_gap(double u, double v, int *stone_i, int *stone_j);

/* ---- noise (noise.c): all repeat with the given period in lattice cells, so that textures tile ---- */

double hash01(int x, int y, int seed);
/* Gradient noise, about -1..1. x and y in cells. */
double noise(double x, double y, int period, int seed);
/* Sum of `octaves`, each of half the size and half the strength; about -1..1. */
double fractal(double x, double y, int period, int octaves, int seed);
/* The same in three dimensions without a period, for spheres. */
double fractal3(double x, double y, double z, int octaves, int seed);

/* ---- strokes (stroke.c): monoline outlines from a glyph's skeleton ---- */

enum { MAX_POINTS = 2048, MAX_CONTOURS = 32 };

/* A TrueType outline: points with an on-curve mark, contours by their last point. Filled to the right of travel. */
typedef struct outline {
    int count, contours;
    double x[MAX_POINTS], y[MAX_POINTS];
    bool on[MAX_POINTS];
    int last[MAX_CONTOURS];
} outline;

/* Draws the skeleton with a pen of `radius`; the language is described in stroke.c. False if it has an error in it. */
bool stroke_skeleton(const char *skeleton, double radius, outline *out);

typedef struct glyph {
    uint32_t code;
    double left, right; /* side bearings, from the outline's edge */
    const char *skeleton;
} glyph;

extern const glyph font_glyphs[];
extern const int font_glyph_count;

/* clang-format off */
enum {
    MARK_NONE, MARK_GRAVE, MARK_ACUTE, MARK_CIRCUMFLEX, MARK_CARON, MARK_TILDE, MARK_DIAERESIS, MARK_DOT, MARK_RING,
    MARK_MACRON, MARK_BREVE, MARK_DOUBLE_ACUTE, MARK_CEDILLA, MARK_OGONEK, MARKS
};
/* clang-format on */

typedef struct glyph_mark {
    const char *skeleton;
    bool below;
} glyph_mark;

typedef struct composed {
    uint32_t code, base; /* a glyph of font_glyphs */
    int mark;
} composed;

extern const glyph_mark font_marks[MARKS];
extern const composed font_composed[];
extern const int font_composed_count;

#endif
