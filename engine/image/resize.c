/* Enlarging a picture, by tables of four neighbours and their weights for rows and columns. Works on the bytes as they
 * are, as a window does. */
#include "image/resize.h"

#include <math.h>

#include "base/parallel.h"

enum { TAPS = DAFT_RESIZE_TAPS, BAND = 16 /* rows of a task */ };

typedef struct resize_job {
    daft_resize plan;
    const daft_resize_kernels *kernels;
    float *mixed; /* a row for each worker */
    size_t row;   /* floats */
} resize_job;

typedef struct resize_tap {
    int base; /* the pixel before the place; -1: the place is in the first half of the first */
    double weight[TAPS];
} resize_tap;

static resize_tap make_tap(int i, int size, int from, daft_upscale how)
{
    const double x = (i + 0.5) * from / size - 0.5, base = floor(x), f = x - base;
    resize_tap tap = {(int)base, {0, 1 - f, f, 0}};
    double *weight = tap.weight;
    if (how == DAFT_UPSCALE_NEAREST) weight[1] = f < 0.5, weight[2] = !(f < 0.5);
    if (how == DAFT_UPSCALE_BICUBIC) { /* Catmull, Rom 1974 */
        weight[0] = f * (-0.5 + f * (1 - 0.5 * f));
        weight[1] = 1 + f * f * (-2.5 + 1.5 * f);
        weight[3] = f * f * (-0.5 + 0.5 * f);
        weight[2] = 1 - weight[0] - weight[1] - weight[3];
    }
    return tap;
}

static int clamp_index(int i, int count) { return i < 0 ? 0 : i >= count ? count - 1 : i; }

static void plan_rows(daft_resize_row *rows, int count, int from, daft_upscale how)
{
    for (int y = 0; y < count; y++) {
        const resize_tap tap = make_tap(y, count, from, how);
        for (int k = 0; k < TAPS; k++) {
            rows[y].at[k] = clamp_index(tap.base - 1 + k, from);
            rows[y].weight[k] = (float)tap.weight[k];
        }
    }
}

static void plan_pairs(daft_resize_pair *pairs, int count, int from, daft_upscale how)
{
    for (int x = 0; x < count + count % 2; x++) {
        const resize_tap tap = make_tap(clamp_index(x, count), count, from, how);
        daft_resize_pair *pair = &pairs[x / 2];
        pair->at[x % 2] = tap.base - 1 + DAFT_RESIZE_PAD;
        for (int k = 0; k < TAPS; k++)
            for (int c = 0; c < 4; c++) pair->weight[k][4 * (x % 2) + c] = (float)tap.weight[k];
    }
}

static void enlarge_band(void *context, uint32_t task, uint32_t worker)
{
    const resize_job *j = context;
    const int first = (int)task * BAND, height = j->plan.to->height;
    j->kernels->enlarge(&j->plan, first, first + BAND < height ? first + BAND : height, j->mixed + worker * j->row);
}

static size_t row_floats(const daft_image *from) { return 4 * ((size_t)from->width + 2 * DAFT_RESIZE_PAD); }

size_t daft_image_enlarge_bytes(const daft_image *from, const daft_image *to, int workers)
{
    return (size_t)to->height * sizeof(daft_resize_row) + ((size_t)to->width + 1) / 2 * sizeof(daft_resize_pair) +
           (size_t)workers * row_floats(from) * sizeof(float);
}

void daft_image_enlarge(const daft_image *from, daft_image *to, daft_upscale how, void *scratch, int workers, int isa)
{
    static const daft_resize_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_resize);
    daft_resize_row *rows = scratch;
    daft_resize_pair *pairs = (daft_resize_pair *)(void *)(rows + to->height);
    const daft_resize plan = {
        .from = from, .to = to, .wide = how == DAFT_UPSCALE_BICUBIC, .rows = rows, .pairs = pairs};
    resize_job j = {.plan = plan, .kernels = TABLE[isa], .row = row_floats(from)};
    j.mixed = (float *)(void *)(pairs + (to->width + 1) / 2);
    plan_rows(rows, to->height, from->height, how);
    plan_pairs(pairs, to->width, from->width, how);
    daft_parallel_for(workers, (uint32_t)(to->height + BAND - 1) / BAND, enlarge_band, &j);
}
