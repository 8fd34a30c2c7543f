/* accuracy: what accuracy costs. How far a picture is from its reference.
 * Promises: the errors are those of the published definitions, tested against other implementations of them.
 * Public headers: metrics.h knobs.h sweep.h report.h sim.h probe.h Inner headers: plot.h */
#ifndef RUNTIME_ACCURACY_METRICS_H
#define RUNTIME_ACCURACY_METRICS_H

#include "daft.h"

/* How far a picture is from its reference. Both are RGBA bytes in sRGB; alpha does not count. */
typedef struct picture_errors {
    double rmse;  /* root of the mean squared difference of R, G and B in linear light; 0 to 1 */
    double psnr;  /* -20·log10(rmse), decibels; infinite where the pictures are equal */
    double ssim;  /* mean structural similarity of luma; 1: equal */
    double flip;  /* mean LDR-FLIP; 0: equal, 1: as far as can be */
    double worst; /* the largest mean FLIP of a 32×32 tile */
} picture_errors;

/* Pixels per degree of the eye at which FLIP looks: a display 0.7 m wide with 3,840 pixels from 0.7 m, as the authors'
 * own tool takes it. */
#define METRICS_PPD 67.0206432765823

enum { METRICS_TILE = 32 }; /* pixels a side */

/* map: the FLIP of each pixel, width·height floats, or NULL. Fails only where memory does. */
bool metrics_compare(const uint8_t *picture, const uint8_t *reference, int width, int height, float *map,
                     picture_errors *out, daft_error *error);

double metrics_rmse(const uint8_t *a, const uint8_t *b, int width, int height);
double metrics_psnr(double rmse);
/* Wang, Bovik, Sheikh, Simoncelli 2004: 11×11 Gaussian window of deviation 1.5, K1 = 0.01, K2 = 0.03, of luma (BT.601)
 * of the bytes; the mean over all windows that lie in the picture. 1 for equal pictures that are smaller than a window,
 * else NaN for such. */
bool metrics_ssim(const uint8_t *a, const uint8_t *b, int width, int height, double *out, daft_error *error);
/* Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020: FLIP. Fills map; the error is its mean. */
bool metrics_flip(const uint8_t *picture, const uint8_t *reference, int width, int height, double ppd, float *map,
                  daft_error *error);
/* The same in two steps, for a picture that is compared with several. NULL: see the error. */
typedef struct flip_picture flip_picture;
flip_picture *flip_prepare(const uint8_t *rgba, int width, int height, double ppd, daft_error *error);
void flip_free(flip_picture *picture); /* NULL is fine */
/* Two pictures of one size. Fills map, unless it is NULL, and returns its mean. */
double flip_compare(const flip_picture *a, const flip_picture *b, float *map);
/* The largest mean of a METRICS_TILE × METRICS_TILE tile of a map. */
double metrics_worst_tile(const float *map, int width, int height);

/* Bytes of sRGB to linear light, 0 to 1, and the nearest byte of linear light. */
double metrics_to_linear(uint8_t encoded);
uint8_t metrics_to_srgb(double linear);

#endif
