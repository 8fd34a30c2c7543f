/* The sky as light: spherical harmonics of what comes from it, and what light a tone curve shows as white. */
#include "math/trig.h"
#include "shade/shade.h"

/* ---- sums over directions ---- */

enum { BLOCKS = 512 }; /* columns, or a cube's rows and columns, that are told apart */

typedef struct projection {
    double whole, sum[DAFT_HARMONICS][3]; /* whole: of the solid angles */
} projection;

/* Light from around a direction of length 1, times its solid angle. */
static void add_light(projection *p, daft_dvec3 d, const double light[3])
{
    const double basis[DAFT_HARMONICS] = {
        1, d.x, d.y, d.z, d.x * d.y, d.y * d.z, d.x * d.z, 3 * d.z * d.z - 1, d.x * d.x - d.y * d.y};
    for (int k = 0; k < DAFT_HARMONICS; k++)
        for (int c = 0; c < 3; c++) p->sum[k][c] += basis[k] * light[c];
}

/* The norms of the harmonics, squared, times Lambert's 1, 2/3, 1/4, times 4 pi. */
static void finish(const projection *p, daft_vec3 out[DAFT_HARMONICS])
{
    static const double FACTORS[DAFT_HARMONICS] = {1, 2, 2, 2, 3.75, 3.75, 3.75, 0.3125, 0.9375};
    for (int k = 0; k < DAFT_HARMONICS; k++) {
        const double f = FACTORS[k] / p->whole;
        out[k] = daft_v3((float)(p->sum[k][0] * f), (float)(p->sum[k][1] * f), (float)(p->sum[k][2] * f));
    }
}

static void add_texels(const float *texels, int count, double sum[3])
{
    for (int i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) sum[c] += (double)texels[3 * i + c];
}

/* ---- the kinds of sky ---- */

/* Texels of a row are added up in blocks, so that a tall image's directions are few. */
static void project_image(const daft_sky_image *image, projection *p)
{
    const int blocks = daft_min_i(image->width, BLOCKS);
    double cosine[BLOCKS], sine[BLOCKS];
    for (int b = 0; b < blocks; b++) {
        const double turn = 2 * DAFT_PI * ((b + 0.5) / blocks - 0.5);
        cosine[b] = daft_cos(turn), sine[b] = daft_sin(turn);
    }
    for (int y = 0; y < image->height; y++) {
        const double top = daft_sin(DAFT_PI * (0.5 - (double)y / image->height)),
                     bottom = daft_sin(DAFT_PI * (0.5 - (y + 1.0) / image->height)),
                     rise = DAFT_PI * (0.5 - (y + 0.5) / image->height), across = daft_cos(rise), up = daft_sin(rise);
        const double each = 2 * DAFT_PI * (top - bottom) / image->width; /* of a texel */
        const float *row = image->texels + 3 * (size_t)y * (size_t)image->width;
        for (int b = 0; b < blocks; b++) {
            const int first = (int)((int64_t)image->width * b / blocks),
                      end = (int)((int64_t)image->width * (b + 1) / blocks);
            double light[3] = {0};
            add_texels(row + 3 * (size_t)first, end - first, light);
            for (int c = 0; c < 3; c++) light[c] *= each;
            add_light(p, (daft_dvec3){across * cosine[b], up, across * sine[b]}, light);
        }
    }
    p->whole += 4 * DAFT_PI;
}

static void project_block(const daft_sky_image *image, int face, int left, int top, int right, int bottom,
                          projection *p)
{
    const int side = image->width - 2;
    const daft_dvec3 d = daft_cube_direction(face, 0.5 * (left + right) / side, 0.5 * (top + bottom) / side);
    const double length2 = daft_ddot(d, d), length = sqrt(length2), each = 1 / (length2 * length);
    double light[3] = {0};
    for (int y = top; y < bottom; y++)
        add_texels(image->texels +
                       3 * ((size_t)(face * image->width + y + 1) * (size_t)image->width + (size_t)left + 1),
                   right - left, light);
    for (int c = 0; c < 3; c++) light[c] *= each;
    add_light(p, daft_dscale(d, 1 / length), light);
    p->whole += each * (right - left) * (bottom - top);
}

static void project_cube(const daft_sky_image *image, projection *p)
{
    const int side = image->width - 2, blocks = daft_min_i(side, BLOCKS / 2);
    for (int face = 0; face < 6; face++)
        for (int y = 0; y < blocks; y++)
            for (int x = 0; x < blocks; x++)
                project_block(image, face, side * x / blocks, side * y / blocks, side * (x + 1) / blocks,
                              side * (y + 1) / blocks, p);
}

/* It depends on the height alone, and on its root: in steps of the root, of which all is a polynomial. */
static void project_gradient(const daft_sky *sky, projection *p)
{
    enum { STEPS = 1024 };
    const double h[3] = {(double)sky->horizon.x, (double)sky->horizon.y, (double)sky->horizon.z},
                 z[3] = {(double)sky->zenith.x, (double)sky->zenith.y, (double)sky->zenith.z};
    for (int i = 0; i < 2 * STEPS; i++) {
        const double root = (i % STEPS + 0.5) / STEPS, y = i < STEPS ? root * root : -root * root;
        const double angle = 2 * DAFT_PI * 2 * root / STEPS, shade = y < 0 ? 1 + y / 3 : 1, across = 1 - y * y;
        double light[3];
        for (int c = 0; c < 3; c++) {
            light[c] = angle * shade * (h[c] + (z[c] - h[c]) * root);
            /* means around the axis: of z² and x² half of what is not y² */
            p->sum[0][c] += light[c], p->sum[2][c] += light[c] * y;
            p->sum[7][c] += light[c] * (1.5 * across - 1), p->sum[8][c] += light[c] * (0.5 * across - y * y);
        }
    }
    p->whole += 4 * DAFT_PI;
}

void daft_sky_irradiance(const daft_sky *sky, daft_vec3 harmonics[DAFT_HARMONICS])
{
    projection p = {0};
    switch (sky->kind) {
    case DAFT_SKY_COLOR:
        p.whole = 1;
        for (int c = 0; c < 3; c++) p.sum[0][c] = (double)daft_v3_at(sky->zenith, c);
        break;
    case DAFT_SKY_GRADIENT: project_gradient(sky, &p); break;
    case DAFT_SKY_IMAGE: project_image(sky->image, &p); break;
    case DAFT_SKY_CUBE: project_cube(sky->image, &p); break;
    }
    finish(&p, harmonics);
}

/* Where the curves of tone_kernel.c end. */
float daft_tone_white(const daft_tone *tone)
{
    static const double WHITE[] = {[DAFT_TONE_NONE] = 1, [DAFT_TONE_ACES] = 10.02, [DAFT_TONE_AGX] = 16.292};
    return (float)(WHITE[tone->curve] * daft_exp2(-(double)tone->ev));
}
