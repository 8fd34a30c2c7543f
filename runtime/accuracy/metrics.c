/* RMSE and PSNR in linear light, SSIM, the worst tile. */
#include "accuracy/metrics.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double metrics_to_linear(uint8_t encoded)
{
    double e = encoded / 255.0;
    return e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4);
}

uint8_t metrics_to_srgb(double linear)
{
    double l = fmin(fmax(linear, 0), 1);
    double e = l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;
    return (uint8_t)(e * 255 + 0.5);
}

double metrics_rmse(const uint8_t *a, const uint8_t *b, int width, int height)
{
    double linear[256], sum = 0;
    for (int i = 0; i < 256; i++) linear[i] = metrics_to_linear((uint8_t)i);
    size_t pixels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < pixels; i++) {
        for (size_t c = 4 * i; c < 4 * i + 3; c++) {
            double difference = linear[a[c]] - linear[b[c]];
            sum += difference * difference;
        }
    }
    return sqrt(sum / (3 * (double)pixels));
}

double metrics_psnr(double rmse) { return rmse > 0 ? -20 * log10(rmse) : INFINITY; }

/* ---- SSIM -------------------------------------------------------------------------------------------------------- */

enum { WINDOW = 11, MOMENTS = 5 }; /* moments: means of a, b, a², b², ab */

typedef struct ssim_rows {
    double weight[WINDOW];
    double *column; /* the moments of each column, over the window's rows */
} ssim_rows;

static void make_window(double weight[WINDOW])
{
    double sum = 0;
    for (int i = 0; i < WINDOW; i++) sum += weight[i] = exp(-(i - 5) * (i - 5) / (2 * 1.5 * 1.5));
    for (int i = 0; i < WINDOW; i++) weight[i] /= sum;
}

static double luma(const uint8_t *p) { return (0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2]) / 255; }

static void sum_columns(const ssim_rows *s, const uint8_t *a, const uint8_t *b, int width, int top)
{
    memset(s->column, 0, (size_t)width * MOMENTS * sizeof *s->column);
    for (int row = 0; row < WINDOW; row++) {
        for (int x = 0; x < width; x++) {
            size_t at = 4 * ((size_t)(top + row) * (size_t)width + (size_t)x);
            double p = luma(a + at), q = luma(b + at), w = s->weight[row], *m = s->column + (ptrdiff_t)MOMENTS * x;
            m[0] += w * p, m[1] += w * q, m[2] += w * p * p, m[3] += w * q * q, m[4] += w * p * q;
        }
    }
}

static double ssim_at(const ssim_rows *s, int left)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double m[MOMENTS] = {0};
    for (int i = 0; i < WINDOW; i++)
        for (int k = 0; k < MOMENTS; k++) m[k] += s->weight[i] * s->column[MOMENTS * (left + i) + k];
    double var_a = m[2] - m[0] * m[0], var_b = m[3] - m[1] * m[1], both = m[4] - m[0] * m[1];
    return (2 * m[0] * m[1] + c1) * (2 * both + c2) / ((m[0] * m[0] + m[1] * m[1] + c1) * (var_a + var_b + c2));
}

bool metrics_ssim(const uint8_t *a, const uint8_t *b, int width, int height, double *out, daft_error *error)
{
    *out = metrics_rmse(a, b, width, height) > 0 ? (double)NAN : 1;
    if (width < WINDOW || height < WINDOW) return true;
    ssim_rows s = {.column = malloc((size_t)width * MOMENTS * sizeof(double))};
    if (!s.column) return fail(error, DAFT_ERROR_MEMORY, "out of memory to compare pictures");
    make_window(s.weight);
    double sum = 0;
    for (int top = 0; top + WINDOW <= height; top++) {
        sum_columns(&s, a, b, width, top);
        for (int left = 0; left + WINDOW <= width; left++) sum += ssim_at(&s, left);
    }
    free(s.column);
    *out = sum / ((double)(width - WINDOW + 1) * (height - WINDOW + 1));
    return true;
}

/* ---- all of them ------------------------------------------------------------------------------------------------- */

static double tile_mean(const float *map, int width, int height, int x0, int y0)
{
    int x1 = x0 + METRICS_TILE < width ? x0 + METRICS_TILE : width;
    int y1 = y0 + METRICS_TILE < height ? y0 + METRICS_TILE : height;
    double sum = 0;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) sum += (double)map[(size_t)y * (size_t)width + (size_t)x];
    return sum / ((double)(x1 - x0) * (y1 - y0));
}

static double mean_of(const float *map, int width, int height)
{
    double sum = 0;
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++) sum += (double)map[i];
    return sum / ((double)width * height);
}

double metrics_worst_tile(const float *map, int width, int height)
{
    double worst = 0;
    for (int y = 0; y < height; y += METRICS_TILE)
        for (int x = 0; x < width; x += METRICS_TILE) worst = fmax(worst, tile_mean(map, width, height, x, y));
    return worst;
}

bool metrics_compare(const uint8_t *picture, const uint8_t *reference, int width, int height, float *map,
                     picture_errors *out, daft_error *error)
{
    float *own = map ? NULL : malloc((size_t)width * (size_t)height * sizeof *own);
    if (!map && !own) return fail(error, DAFT_ERROR_MEMORY, "out of memory to compare pictures");
    float *flip = map ? map : own;
    out->rmse = metrics_rmse(picture, reference, width, height);
    out->psnr = metrics_psnr(out->rmse);
    bool good = metrics_ssim(picture, reference, width, height, &out->ssim, error) &&
                metrics_flip(picture, reference, width, height, METRICS_PPD, flip, error);
    if (good) out->flip = mean_of(flip, width, height), out->worst = metrics_worst_tile(flip, width, height);
    free(own);
    return good;
}
