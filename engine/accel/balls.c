/* Balls around blocks, and blocks that are worth one. A leaf's triangles come as the builder has left them; halved along
 * what parts them most, down to blocks, near ones that look the same way come together. */
#include "accel/balls.h"

#include <float.h>

enum { STEPS = 32, FEATURES = 6, CORNERS = 3 * DAFT_BLOCK, MOST = DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK };

/* How much two normals that are opposite count, in sizes of the leaf. Measured on crowds of cows: between 0 and 2 it is about the same. */
#define NORMALS_WEIGHT 0.5f

static daft_dvec3 corner_of(const daft_block *block, int corner, uint32_t lane)
{
    const float(*c)[DAFT_BLOCK] = block->corner[corner];
    return daft_dv3((double)c[0][lane], (double)c[1][lane], (double)c[2][lane]);
}

/* ---- blocks ---- */

typedef struct item {
    float at[FEATURES]; /* the middle, then the weighted normal */
    float corner[3][3];
    uint32_t triangle;
} item;

static void item_make(const daft_block *block, uint32_t lane, item *out)
{
    daft_dvec3 a = corner_of(block, 0, lane), b = corner_of(block, 1, lane), c = corner_of(block, 2, lane);
    daft_dvec3 n = daft_dcross(daft_dsub(b, a), daft_dsub(c, a)), sum = daft_dadd(a, daft_dadd(b, c));
    double length = sqrt(daft_ddot(n, n)), inverse = length > 0 && length <= DBL_MAX ? 1 / length : 0;
    const double at[FEATURES] = {sum.x / 3, sum.y / 3, sum.z / 3, n.x * inverse, n.y * inverse, n.z * inverse};
    for (int k = 0; k < FEATURES; k++) out->at[k] = (float)at[k];
    for (int k = 0; k < 3; k++)
        for (int axis = 0; axis < 3; axis++) out->corner[k][axis] = block->corner[k][axis][lane];
    out->triangle = block->triangle[lane];
}

static float extent(const item *items, uint32_t count, int k)
{
    float low = INFINITY, high = -INFINITY;
    for (uint32_t i = 0; i < count; i++) low = fminf(low, items[i].at[k]), high = fmaxf(high, items[i].at[k]);
    return high - low;
}

static void sort_along(item *items, uint32_t count, int k)
{
    for (uint32_t i = 1; i < count; i++) {
        item moved = items[i];
        uint32_t at = i;
        for (; at && items[at - 1].at[k] > moved.at[k]; at--) items[at] = items[at - 1];
        items[at] = moved;
    }
}

/* Halves that are whole blocks; at most two deep. */
static void halve(item *items, uint32_t count)
{
    if (count <= DAFT_BLOCK) return;
    int widest = 0;
    float most = -1;
    for (int k = 0; k < FEATURES; k++) {
        float wide = extent(items, count, k);
        if (wide > most) most = wide, widest = k;
    }
    sort_along(items, count, widest);
    uint32_t half = (count + DAFT_BLOCK - 1) / DAFT_BLOCK / 2 * DAFT_BLOCK;
    halve(items, half);
    halve(items + half, count - half);
}

static void regroup(daft_block *blocks, uint32_t block_count)
{
    item items[MOST];
    uint32_t count = 0;
    for (uint32_t i = 0; i < block_count * DAFT_BLOCK; i++)
        if (blocks[i / DAFT_BLOCK].triangle[i % DAFT_BLOCK] != DAFT_NO_TRIANGLE)
            item_make(&blocks[i / DAFT_BLOCK], i % DAFT_BLOCK, &items[count++]);
    float size = fmaxf(extent(items, count, 0), fmaxf(extent(items, count, 1), extent(items, count, 2)));
    for (uint32_t i = 0; i < count; i++)
        for (int k = 3; k < FEATURES; k++) items[i].at[k] *= NORMALS_WEIGHT * size;
    halve(items, count);
    for (uint32_t i = 0; i < block_count * DAFT_BLOCK; i++) {
        const item *from = &items[daft_min_u(i, count - 1)];
        daft_block *block = &blocks[i / DAFT_BLOCK];
        block->triangle[i % DAFT_BLOCK] = i < count ? from->triangle : DAFT_NO_TRIANGLE;
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++) block->corner[k][axis][i % DAFT_BLOCK] = from->corner[k][axis];
    }
}

void daft_blocks_regroup(daft_bvh *bvh)
{
    for (size_t n = 0; n < bvh->nodes.count; n++)
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = bvh->nodes.items[n].child[i];
            if (child == DAFT_CHILD_NONE || !(child & DAFT_CHILD_LEAF) || !(child & 3)) continue;
            regroup(&bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], (child & 3) + 1);
        }
}

/* ---- balls ---- */

/* How far the farthest corner is. */
static double farthest(const daft_block *blocks, uint32_t count, daft_dvec3 from, daft_dvec3 *corner)
{
    double most = -1;
    *corner = from;
    for (uint32_t b = 0; b < count; b++)
        for (uint32_t i = 0; i < CORNERS; i++) {
            daft_dvec3 p = corner_of(&blocks[b], (int)(i / DAFT_BLOCK), i % DAFT_BLOCK), d = daft_dsub(p, from);
            double square = daft_ddot(d, d);
            if (square > most) most = square, *corner = p;
        }
    return sqrt(fmax(most, 0));
}

/* The mean of the corners, moved towards the farthest one, ever less (Badoiu and Clarkson, "Smaller Core-Sets for Balls", 2003). */
static daft_dvec3 middle_of(const daft_block *blocks, uint32_t count, int steps)
{
    daft_dvec3 middle = {0, 0, 0}, far, best;
    for (uint32_t b = 0; b < count; b++)
        for (uint32_t i = 0; i < CORNERS; i++)
            middle = daft_dadd(middle, daft_dscale(corner_of(&blocks[b], (int)(i / DAFT_BLOCK), i % DAFT_BLOCK), 1.0 / (CORNERS * count)));
    double least = farthest(blocks, count, middle, &far);
    best = middle;
    for (int step = 1; step <= steps; step++) {
        middle = daft_dadd(middle, daft_dscale(daft_dsub(far, middle), 1.0 / (step + 1)));
        double radius = farthest(blocks, count, middle, &far);
        if (radius < least) least = radius, best = middle;
    }
    return best;
}

static uint16_t units(double length, double unit, double round)
{
    return (uint16_t)fmin(fmax(length / unit + round, 0), UINT16_MAX);
}

/* Centres are at most 32768 units from the low corner on each axis, and radii at most the diagonal of that cube: both fit. */
void daft_ball_around(const daft_balls *balls, const daft_block *blocks, uint32_t count, int steps, daft_ball *out)
{
    double unit = (double)balls->unit;
    daft_dvec3 low = daft_to_double(balls->low), middle = daft_dsub(middle_of(blocks, count, steps), low), far;
    out->centre[0] = units(middle.x, unit, 0.5), out->centre[1] = units(middle.y, unit, 0.5), out->centre[2] = units(middle.z, unit, 0.5);
    daft_dvec3 centre = daft_dv3(out->centre[0], out->centre[1], out->centre[2]);
    out->radius = units(farthest(blocks, count, daft_dadd(low, daft_dscale(centre, unit)), &far), unit, 1.01);
}

bool daft_balls_make(const daft_bvh *bvh, const daft_trimesh *mesh, daft_balls *out)
{
    *out = (daft_balls){.low = mesh->low};
    daft_dvec3 size = daft_dsub(daft_to_double(mesh->high), daft_to_double(mesh->low));
    out->unit = fmaxf((float)(fmax(size.x, fmax(size.y, size.z)) / 32767), FLT_MIN); /* over a part in 32768, in spite of rounding */
    out->items = daft_alloc_zero(&bvh->allocator, bvh->block_count + DAFT_MAX_LEAF_BLOCKS, sizeof *out->items);
    if (!out->items) return false;
    for (size_t b = 0; b < bvh->block_count; b++) daft_ball_around(out, &bvh->blocks[b], 1, STEPS, &out->items[b]);
    return true;
}
