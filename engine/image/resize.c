/* Enlarging a picture: columns first, then rows, each by a table of four neighbours and their weights. Works on the
 * bytes as they are, as a window does. */
#include "image/image.h"

#include <math.h>

#include "base/parallel.h"

enum { TAPS = 4, ONE = 256, FINE = 64 /* steps of a byte between the two passes */, ROWS = 16 /* of a task */ };

typedef struct resize_tap {
    int at[TAPS], weight[TAPS]; /* the middle two are the pixels on either side */
} resize_tap;

typedef struct resize_job {
    const daft_image *from;
    daft_image *to;
    daft_upscale how;
    resize_tap *columns, *rows;
    int16_t *wide; /* the rows of `from` at the width of `to` */
} resize_job;

static int clamp_index(int i, int count) { return i < 0 ? 0 : i >= count ? count - 1 : i; }

static resize_tap make_tap(int i, int size, int from, daft_upscale how)
{
    const double x = (i + 0.5) * from / size - 0.5, base = floor(x);
    double f = x - base, weight[TAPS] = {0, 1 - f, f, 0};
    if (how == DAFT_UPSCALE_NEAREST) weight[1] = f < 0.5, weight[2] = !(f < 0.5);
    if (how == DAFT_UPSCALE_BICUBIC) { /* Catmull, Rom 1974 */
        weight[0] = f * (-0.5 + f * (1 - 0.5 * f));
        weight[1] = 1 + f * f * (-2.5 + 1.5 * f);
        weight[3] = f * f * (-0.5 + 0.5 * f);
    }
    resize_tap tap;
    for (int k = 0; k < TAPS; k++) {
        tap.at[k] = clamp_index((int)base - 1 + k, from);
        tap.weight[k] = (int)floor(weight[k] * ONE + 0.5);
    }
    tap.weight[2] = ONE - tap.weight[0] - tap.weight[1] - tap.weight[3];
    return tap;
}

/* Between the two in the middle: nothing rings. */
static int mix(const resize_tap *tap, int a, int b, int c, int d)
{
    const int sum = (a * tap->weight[0] + b * tap->weight[1] + c * tap->weight[2] + d * tap->weight[3]) / ONE;
    const int low = b < c ? b : c, high = b < c ? c : b;
    return sum < low ? low : sum > high ? high : sum;
}

static void widen_row(const resize_job *j, int y)
{
    const uint8_t *row = j->from->pixels + (size_t)y * (size_t)j->from->width * 4;
    int16_t *out = j->wide + (size_t)y * (size_t)j->to->width * 4;
    for (int x = 0; x < j->to->width; x++) {
        const resize_tap *tap = &j->columns[x];
        const uint8_t *p[TAPS];
        for (int k = 0; k < TAPS; k++) p[k] = row + 4 * tap->at[k];
        for (int c = 0; c < 4; c++)
            out[4 * x + c] = (int16_t)mix(tap, p[0][c] * FINE, p[1][c] * FINE, p[2][c] * FINE, p[3][c] * FINE);
    }
}

static void stack_row(const resize_job *j, int y)
{
    const size_t bytes = (size_t)j->to->width * 4;
    const resize_tap tap = j->rows[y];
    const int16_t *p[TAPS];
    uint8_t *out = j->to->pixels + (size_t)y * bytes;
    for (int k = 0; k < TAPS; k++) p[k] = j->wide + (size_t)tap.at[k] * bytes;
    for (size_t i = 0; i < bytes; i++)
        out[i] = (uint8_t)((mix(&tap, p[0][i], p[1][i], p[2][i], p[3][i]) + FINE / 2) / FINE);
}

static void widen_task(void *context, uint32_t task, uint32_t worker)
{
    (void)worker;
    const resize_job *j = context;
    for (int y = (int)task * ROWS; y < ((int)task + 1) * ROWS && y < j->from->height; y++) widen_row(j, y);
}

static void stack_task(void *context, uint32_t task, uint32_t worker)
{
    (void)worker;
    const resize_job *j = context;
    for (int y = (int)task * ROWS; y < ((int)task + 1) * ROWS && y < j->to->height; y++) stack_row(j, y);
}

size_t daft_image_enlarge_bytes(const daft_image *from, const daft_image *to)
{
    return ((size_t)to->width + (size_t)to->height) * sizeof(resize_tap) +
           (size_t)to->width * (size_t)from->height * 4 * sizeof(int16_t);
}

void daft_image_enlarge(const daft_image *from, daft_image *to, daft_upscale how, void *scratch, int workers)
{
    resize_job j = {.from = from, .to = to, .how = how, .columns = scratch};
    j.rows = j.columns + to->width;
    j.wide = (int16_t *)(void *)(j.rows + to->height);
    for (int x = 0; x < to->width; x++) j.columns[x] = make_tap(x, to->width, from->width, how);
    for (int y = 0; y < to->height; y++) j.rows[y] = make_tap(y, to->height, from->height, how);
    daft_parallel_for(workers, (uint32_t)(from->height + ROWS - 1) / ROWS, widen_task, &j);
    daft_parallel_for(workers, (uint32_t)(to->height + ROWS - 1) / ROWS, stack_task, &j);
}
