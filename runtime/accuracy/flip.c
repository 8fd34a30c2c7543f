/* LDR-FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images"). Each picture goes to an
 * opponent space (YCxCz), is blurred by what the eye cannot see at this distance, and is compared in CIELAB (Hunt
 * adjusted, HyAB distance); where edges or points of the luminance differ, the difference of colour counts for more.
 *
 * All filters are separable. Beyond the picture its border goes on. Section numbers are the paper's. */
#include "accuracy/metrics.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RADIUS = 64, TAPS = 2 * RADIUS + 1 }; /* largest filter: 400 pixels a degree need 55 */

typedef struct flip_filter {
    int radius;
    float tap[TAPS];
} flip_filter;

/* The filters of one distance. The blur of blue–yellow is the sum of two Gaussians. */
typedef struct flip_filters {
    flip_filter luma, red_green, blue_wide, blue_narrow;
    float wide_weight; /* of blue_wide; the rest is blue_narrow's */
    flip_filter bell, edge, point;
} flip_filters;

struct flip_picture {
    int width, height;
    size_t pixels;
    float *lab[3]; /* as the eye sees them at the distance */
    float *edges, *points;
    float planes[]; /* the five above */
};

/* What is needed while a picture is prepared. */
typedef struct flip_work {
    int width, height;
    size_t pixels;
    float *opponent[3]; /* Y, Cx, Cz */
    float *temp, *temp2;
    float *row; /* with its border on both sides */
} flip_work;

enum { PICTURE_PLANES = 5, WORK_PLANES = 5 };

/* ---- colour ------------------------------------------------------------------------------------------------------ */

typedef struct triple {
    double x, y, z;
} triple;

static const triple WHITE = {0.950428545, 1.0, 1.088900371}; /* D65 */

static triple to_xyz(triple c)
{
    return (triple){(10135552 * c.x + 8788810 * c.y + 4435075 * c.z) / 24577794,
                    (2613072 * c.x + 8788810 * c.y + 887015 * c.z) / 12288897,
                    (1425312 * c.x + 8788810 * c.y + 70074185 * c.z) / 73733382};
}

static double unit(double x) { return fmin(fmax(x, 0), 1); }

static triple to_rgb_clamped(triple c)
{
    return (triple){unit(3.241003275 * c.x - 1.537398934 * c.y - 0.498615861 * c.z),
                    unit(-0.969224334 * c.x + 1.875930071 * c.y + 0.041554224 * c.z),
                    unit(0.055639423 * c.x - 0.204011202 * c.y + 1.057148933 * c.z)};
}

static triple to_opponent(triple rgb)
{
    triple c = to_xyz(rgb);
    double x = c.x / WHITE.x, y = c.y / WHITE.y, z = c.z / WHITE.z;
    return (triple){116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

static triple from_opponent(triple o)
{
    double y = (o.x + 16) / 116;
    return (triple){(y + o.y / 500) * WHITE.x, y * WHITE.y, (y - o.z / 200) * WHITE.z};
}

static double lab_curve(double t)
{
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
}

/* CIELAB with chroma scaled by lightness, as Hunt found the eye to do. */
static triple to_lab_hunt(triple rgb)
{
    triple c = to_xyz(rgb);
    double x = lab_curve(c.x / WHITE.x), y = lab_curve(c.y / WHITE.y), z = lab_curve(c.z / WHITE.z);
    double l = 116 * y - 16;
    return (triple){l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
}

static double hyab(triple a, triple b) { return fabs(a.x - b.x) + hypot(a.y - b.y, a.z - b.z); }

/* ---- filters ----------------------------------------------------------------------------------------------------- */

static void scale_to_one(flip_filter *f)
{
    float above = 0, below = 0;
    for (int i = 0; i <= 2 * f->radius; i++) *(f->tap[i] > 0 ? &above : &below) += fabsf(f->tap[i]);
    for (int i = 0; i <= 2 * f->radius; i++) f->tap[i] /= f->tap[i] > 0 ? above : below > 0 ? below : 1;
}

/* exp(-pi²·d²/b), d in degrees (4.1.1). Returns the sum over the whole square of the filter before scaling. */
static double make_blur(flip_filter *f, int radius, double b, double ppd)
{
    double sum = 0;
    f->radius = radius;
    for (int i = -radius; i <= radius; i++) {
        double tap = exp(-M_PI * M_PI * (i / ppd) * (i / ppd) / b);
        f->tap[i + radius] = (float)tap;
        sum += tap;
    }
    scale_to_one(f);
    return sum * sum;
}

/* A Gaussian and its first and second derivatives, of an edge 0.082 degrees wide (4.2). */
static void make_features(flip_filters *f, double ppd)
{
    double deviation = 0.5 * 0.082 * ppd;
    int radius = (int)ceil(3 * deviation);
    f->bell.radius = f->edge.radius = f->point.radius = radius;
    for (int i = -radius; i <= radius; i++) {
        double bell = exp(-i * i / (2 * deviation * deviation));
        f->bell.tap[i + radius] = (float)bell;
        f->edge.tap[i + radius] = (float)(-i * bell);
        f->point.tap[i + radius] = (float)((i * i / (deviation * deviation) - 1) * bell);
    }
    scale_to_one(&f->bell);
    scale_to_one(&f->edge);
    scale_to_one(&f->point);
}

static void make_filters(flip_filters *f, double ppd)
{
    const double luma = 0.0047, red_green = 0.0053, wide = 0.04, narrow = 0.025, wide_a = 34.1, narrow_a = 13.5;
    int radius = (int)ceil(3 * sqrt(wide / (2 * M_PI * M_PI)) * ppd);
    make_blur(&f->luma, radius, luma, ppd);
    make_blur(&f->red_green, radius, red_green, ppd);
    double of_wide = wide_a * sqrt(M_PI / wide) * make_blur(&f->blue_wide, radius, wide, ppd);
    double of_narrow = narrow_a * sqrt(M_PI / narrow) * make_blur(&f->blue_narrow, radius, narrow, ppd);
    f->wide_weight = (float)(of_wide / (of_wide + of_narrow));
    make_features(f, ppd);
}

static int clamp_to(int i, int count) { return i < 0 ? 0 : i >= count ? count - 1 : i; }

static void filter_rows(const flip_work *w, const flip_filter *f, const float *in, float *out)
{
    memset(out, 0, w->pixels * sizeof *out);
    for (int y = 0; y < w->height; y++) {
        const float *from = in + (size_t)y * (size_t)w->width;
        float *to = out + (size_t)y * (size_t)w->width;
        for (int x = -f->radius; x < w->width + f->radius; x++) w->row[x + f->radius] = from[clamp_to(x, w->width)];
        for (int i = 0; i <= 2 * f->radius; i++) {
            const float *at = w->row + i, tap = f->tap[i];
            for (int x = 0; x < w->width; x++) to[x] += tap * at[x];
        }
    }
}

static void filter_columns(const flip_work *w, const flip_filter *f, const float *in, float *out)
{
    memset(out, 0, w->pixels * sizeof *out);
    for (int y = 0; y < w->height; y++) {
        float *to = out + (size_t)y * (size_t)w->width;
        for (int i = -f->radius; i <= f->radius; i++) {
            const float *row = in + (size_t)clamp_to(y + i, w->height) * (size_t)w->width, tap = f->tap[i + f->radius];
            for (int x = 0; x < w->width; x++) to[x] += tap * row[x];
        }
    }
}

static void filter(const flip_work *w, const flip_filter *across, const flip_filter *down, const float *in, float *out)
{
    filter_rows(w, across, in, w->temp);
    filter_columns(w, down, w->temp, out);
}

/* ---- a picture --------------------------------------------------------------------------------------------------- */

static void load_opponent(flip_work *w, const uint8_t *rgba)
{
    double linear[256];
    for (int i = 0; i < 256; i++) linear[i] = metrics_to_linear((uint8_t)i);
    for (size_t i = 0; i < w->pixels; i++) {
        const uint8_t *p = rgba + 4 * i;
        triple o = to_opponent((triple){linear[p[0]], linear[p[1]], linear[p[2]]});
        w->opponent[0][i] = (float)o.x, w->opponent[1][i] = (float)o.y, w->opponent[2][i] = (float)o.z;
    }
}

/* How strong the feature is at each pixel: the length of its responses across and down. `luma` is 0 to 1. */
static void find_feature(const flip_work *w, const flip_filters *f, const flip_filter *feature, const float *luma,
                         float *out)
{
    filter(w, feature, &f->bell, luma, out);
    filter(w, &f->bell, feature, luma, w->temp2);
    for (size_t i = 0; i < w->pixels; i++) out[i] = hypotf(out[i], w->temp2[i]);
}

static void find_features(const flip_work *w, const flip_filters *f, flip_picture *out)
{
    float *luma = out->lab[0]; /* free until the colours are ready */
    for (size_t i = 0; i < w->pixels; i++) luma[i] = (w->opponent[0][i] + 16) / 116;
    find_feature(w, f, &f->edge, luma, out->edges);
    find_feature(w, f, &f->point, luma, out->points);
}

static void find_colours(const flip_work *w, const flip_filters *f, float *const lab[3])
{
    filter(w, &f->luma, &f->luma, w->opponent[0], lab[0]);
    filter(w, &f->red_green, &f->red_green, w->opponent[1], lab[1]);
    filter(w, &f->blue_wide, &f->blue_wide, w->opponent[2], lab[2]);
    filter(w, &f->blue_narrow, &f->blue_narrow, w->opponent[2], w->temp2);
    for (size_t i = 0; i < w->pixels; i++) {
        float blue = f->wide_weight * lab[2][i] + (1 - f->wide_weight) * w->temp2[i];
        triple o = {(double)lab[0][i], (double)lab[1][i], (double)blue};
        triple c = to_lab_hunt(to_rgb_clamped(from_opponent(o)));
        lab[0][i] = (float)c.x, lab[1][i] = (float)c.y, lab[2][i] = (float)c.z;
    }
}

static void give_planes(flip_picture *p)
{
    float **all[PICTURE_PLANES] = {&p->lab[0], &p->lab[1], &p->lab[2], &p->edges, &p->points};
    for (size_t i = 0; i < PICTURE_PLANES; i++) *all[i] = p->planes + i * p->pixels;
}

static bool begin_work(flip_work *w, int width, int height)
{
    *w = (flip_work){.width = width, .height = height, .pixels = (size_t)width * (size_t)height};
    float *planes = calloc(w->pixels * WORK_PLANES + (size_t)width + TAPS, sizeof *planes);
    if (!planes) return false;
    float **all[WORK_PLANES] = {&w->opponent[0], &w->opponent[1], &w->opponent[2], &w->temp, &w->temp2};
    for (size_t i = 0; i < WORK_PLANES; i++) *all[i] = planes + i * w->pixels;
    w->row = planes + WORK_PLANES * w->pixels;
    return true;
}

flip_picture *flip_prepare(const uint8_t *rgba, int width, int height, double ppd, daft_error *error)
{
    flip_work w;
    flip_filters filters;
    if (!(ppd >= 1 && ppd <= 400)) {
        fail(error, DAFT_ERROR_ARGUMENT, "pixels per degree: 1 to 400 expected");
        return NULL;
    }
    const size_t pixels = (size_t)width * (size_t)height;
    flip_picture *p = malloc(sizeof *p + pixels * PICTURE_PLANES * sizeof(float));
    if (!p || !begin_work(&w, width, height)) {
        free(p);
        fail(error, DAFT_ERROR_MEMORY, "out of memory to compare pictures");
        return NULL;
    }
    p->width = width, p->height = height, p->pixels = pixels;
    give_planes(p);
    make_filters(&filters, ppd);
    load_opponent(&w, rgba);
    find_features(&w, &filters, p);
    find_colours(&w, &filters, p->lab);
    free(w.opponent[0]);
    return p;
}

void flip_free(flip_picture *picture) { free(picture); }

/* ---- the difference ---------------------------------------------------------------------------------------------- */

/* Small differences up to 0.4 of the largest are spread over 0 to 0.95 (4.1.4). `largest`: green to blue. */
static double spread_colour(double distance, double largest)
{
    const double knee = 0.4, top = 0.95;
    double power = pow(distance, 0.7);
    if (power < knee * largest) return top / (knee * largest) * power;
    return top + (power - knee * largest) / (largest - knee * largest) * (1 - top);
}

static double feature_difference(const flip_picture *a, const flip_picture *b, size_t i)
{
    double edge = fabs((double)a->edges[i] - (double)b->edges[i]);
    double point = fabs((double)a->points[i] - (double)b->points[i]);
    return unit(sqrt(fmax(edge, point) / M_SQRT2));
}

static triple colour_of(const flip_picture *p, size_t i)
{
    return (triple){(double)p->lab[0][i], (double)p->lab[1][i], (double)p->lab[2][i]};
}

double flip_compare(const flip_picture *a, const flip_picture *b, float *map)
{
    const double largest = pow(hyab(to_lab_hunt((triple){0, 1, 0}), to_lab_hunt((triple){0, 0, 1})), 0.7);
    double sum = 0;
    for (size_t i = 0; i < a->pixels; i++) {
        const double colour = spread_colour(hyab(colour_of(a, i), colour_of(b, i)), largest);
        const float flip = colour > 0 ? (float)pow(colour, 1 - feature_difference(a, b, i)) : 0;
        if (map) map[i] = flip;
        sum += (double)flip;
    }
    return sum / (double)a->pixels;
}

bool metrics_flip(const uint8_t *picture, const uint8_t *reference, int width, int height, double ppd, float *map,
                  daft_error *error)
{
    flip_picture *a = flip_prepare(picture, width, height, ppd, error);
    flip_picture *b = a ? flip_prepare(reference, width, height, ppd, error) : NULL;
    if (b) flip_compare(a, b, map);
    flip_free(a);
    flip_free(b);
    return b != NULL;
}
