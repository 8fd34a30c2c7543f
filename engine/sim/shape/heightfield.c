/* Height fields: the samples, and least and greatest heights of blocks of cells in halving levels for sweeps and rays.
 */
#include "sim/shape/shape.h"

#include <string.h>

enum { BLOCK = 8, MAX_SAMPLES = 16384 };

static bool check(const float *heights, uint32_t columns, uint32_t rows, float spacing_x, float spacing_z,
                  daft_error *error)
{
    if (columns < 2 || rows < 2 || columns > MAX_SAMPLES || rows > MAX_SAMPLES)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a height field of %u by %u samples; it takes 2 to %d", columns,
                         rows, MAX_SAMPLES);
    if (!(spacing_x >= 1e-4f && spacing_x <= 1e5f && spacing_z >= 1e-4f && spacing_z <= 1e5f))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "a height field with samples %g and %g m apart; it takes 1e-4 to 1e5", (double)spacing_x,
                         (double)spacing_z);
    for (size_t i = 0; i < (size_t)columns * rows; i++)
        if (fabsf(heights[i]) > DAFT_SHAPE_MAX_SIZE)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "height %zu of a height field is %g; the most is %g", i,
                             (double)heights[i], (double)DAFT_SHAPE_MAX_SIZE);
    return true;
}

/* Widens range[2] by a cell, unless it is a hole. NaN in range: nothing yet. */
static void add_cell(const daft_height_field *f, uint32_t column, uint32_t row, float range[2])
{
    const float *h = f->heights + (size_t)row * f->columns + column;
    const float corner[4] = {h[0], h[1], h[f->columns], h[f->columns + 1]};
    float low = corner[0], high = corner[0];
    for (int i = 0; i < 4; i++) {
        if (!isfinite(corner[i])) return;
        low = corner[i] < low ? corner[i] : low;
        high = corner[i] > high ? corner[i] : high;
    }
    if (!(range[0] <= low)) range[0] = low;
    if (!(range[1] >= high)) range[1] = high;
}

static void fill_first_level(daft_height_field *f)
{
    for (uint32_t bz = 0; bz < f->level_rows[0]; bz++)
        for (uint32_t bx = 0; bx < f->level_columns[0]; bx++) {
            float *range = f->ranges + 2 * (size_t)(bz * f->level_columns[0] + bx);
            range[0] = range[1] = NAN;
            for (uint32_t r = bz * BLOCK; r < (bz + 1) * BLOCK && r < f->rows - 1; r++)
                for (uint32_t c = bx * BLOCK; c < (bx + 1) * BLOCK && c < f->columns - 1; c++) add_cell(f, c, r, range);
        }
}

static void fill_level(daft_height_field *f, uint32_t level)
{
    const float *finer = f->ranges + 2 * (size_t)f->level_first[level - 1];
    uint32_t wide = f->level_columns[level - 1], deep = f->level_rows[level - 1];
    for (uint32_t bz = 0; bz < f->level_rows[level]; bz++)
        for (uint32_t bx = 0; bx < f->level_columns[level]; bx++) {
            float *range = f->ranges + 2 * (size_t)(f->level_first[level] + bz * f->level_columns[level] + bx);
            range[0] = range[1] = NAN;
            for (uint32_t i = 0; i < 4; i++) {
                uint32_t x = 2 * bx + (i & 1), z = 2 * bz + (i >> 1);
                if (x >= wide || z >= deep) continue;
                const float *part = finer + 2 * (size_t)(z * wide + x);
                if (isnan(part[0])) continue;
                if (!(range[0] <= part[0])) range[0] = part[0];
                if (!(range[1] >= part[1])) range[1] = part[1];
            }
        }
}

/* Gives how many blocks there are in all. */
static uint32_t lay_levels(daft_height_field *f)
{
    uint32_t x = (f->columns - 1 + BLOCK - 1) / BLOCK, z = (f->rows - 1 + BLOCK - 1) / BLOCK, total = 0;
    for (f->levels = 0;;) {
        f->level_first[f->levels] = total;
        f->level_columns[f->levels] = x, f->level_rows[f->levels] = z;
        total += x * z;
        f->levels++;
        if (x == 1 && z == 1) return total;
        x = (x + 1) / 2, z = (z + 1) / 2;
    }
}

daft_height_field *daft_height_field_create(const daft_allocator *allocator, const float *heights, uint32_t columns,
                                            uint32_t rows, float spacing_x, float spacing_z, daft_error *error)
{
    if (!check(heights, columns, rows, spacing_x, spacing_z, error)) return NULL;
    daft_height_field *f = daft_alloc_zero(allocator, 1, sizeof *f);
    size_t samples = (size_t)columns * rows;
    if (f) {
        f->allocator = *allocator;
        f->columns = columns, f->rows = rows, f->spacing_x = spacing_x, f->spacing_z = spacing_z;
        f->heights = daft_alloc(allocator, samples, sizeof(float));
        f->ranges = daft_alloc(allocator, lay_levels(f), 2 * sizeof(float));
    }
    if (!f || !f->heights || !f->ranges) {
        daft_height_field_free(f);
        daft_fail_memory(error, "a height field");
        return NULL;
    }
    memcpy(f->heights, heights, samples * sizeof *heights);
    fill_first_level(f);
    for (uint32_t level = 1; level < f->levels; level++) fill_level(f, level);
    const float *all = f->ranges + 2 * (size_t)f->level_first[f->levels - 1];
    f->low = isnan(all[0]) ? INFINITY : all[0];
    f->high = isnan(all[0]) ? -INFINITY : all[1];
    return f;
}

void daft_height_field_free(daft_height_field *field)
{
    if (!field) return;
    daft_allocator allocator = field->allocator;
    daft_release(&allocator, field->heights);
    daft_release(&allocator, field->ranges);
    daft_release(&allocator, field);
}
