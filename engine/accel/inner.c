/* Balls inside a mesh (inner.h), chosen one by one: each is the one that covers most of what those before leave of the inside
 * as seen along the three axes. The grid says about how large a ball in each cell may be; the one that is taken is moved
 * away from the nearest triangle as long as that lets it grow, and ends where the nearest triangle, found through the tree, says. */
#include "accel/find_inner.h"
#include "accel/find_sides.h"

enum {
    CANDIDATES = 768,
    STEPS = 8,         /* of moving away */
    TRIES = 2 * DAFT_INNER_BALLS,
    WORK_A_TRIANGLE = 8
};
#define LEAST_GAIN 0.004 /* of what the first ball covers: less is not worth looking at */

void daft_inner_drop(daft_bvh *bvh)
{
    daft_release(&bvh->allocator, bvh->inner);
    bvh->inner = NULL;
}

/* ---- the nearest triangle ---- */

/* The point of the triangle that is nearest to p: Ericson, "Real-Time Collision Detection", 5.1.5. */
static daft_dvec3 nearest_of(const daft_dvec3 c[3], daft_dvec3 p)
{
    daft_dvec3 ab = daft_dsub(c[1], c[0]), ac = daft_dsub(c[2], c[0]);
    daft_dvec3 ap = daft_dsub(p, c[0]), bp = daft_dsub(p, c[1]), cp = daft_dsub(p, c[2]);
    double d1 = daft_ddot(ab, ap), d2 = daft_ddot(ac, ap), d3 = daft_ddot(ab, bp), d4 = daft_ddot(ac, bp);
    double d5 = daft_ddot(ab, cp), d6 = daft_ddot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return c[0];
    if (d3 >= 0 && d4 <= d3) return c[1];
    double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return daft_dadd(c[0], daft_dscale(ab, d1 / (d1 - d3)));
    if (d6 >= 0 && d5 <= d6) return c[2];
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return daft_dadd(c[0], daft_dscale(ac, d2 / (d2 - d6)));
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return daft_dadd(c[1], daft_dscale(daft_dsub(c[2], c[1]), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    double sum = 1 / (va + vb + vc);
    return daft_dadd(c[0], daft_dadd(daft_dscale(ab, vb * sum), daft_dscale(ac, vc * sum)));
}

typedef struct nearest {
    daft_dvec3 from, place;
    double square; /* of the distance */
} nearest;

typedef struct chooser {
    daft_inner_search *s;
    uint64_t work; /* nodes and blocks left to look at */
    uint64_t covered[3][DAFT_GRID]; /* along each axis: rows of bits */
} chooser;

static void meet_block(nearest *n, const daft_block *block)
{
    for (int i = 0; i < DAFT_BLOCK; i++) {
        daft_dvec3 c[3];
        for (int k = 0; k < 3; k++)
            c[k] = daft_dv3((double)block->corner[k][0][i], (double)block->corner[k][1][i], (double)block->corner[k][2][i]);
        daft_dvec3 place = nearest_of(c, n->from), d = daft_dsub(n->from, place);
        double square = daft_ddot(d, d);
        if (square < n->square) n->square = square, n->place = place;
    }
}

typedef struct entry {
    uint32_t child;
    double square;
} entry;

/* The children of a node, the nearest last, where they are nearer than what is known. */
static int push_children(entry *stack, int top, const daft_node *node, const double p[3], double least)
{
    int base = top;
    for (int i = 0; i < DAFT_WIDTH; i++) {
        double square = 0;
        if (node->child[i] == DAFT_CHILD_NONE) continue;
        for (int k = 0; k < 3; k++) {
            double d = fmax(fmax((double)node->bounds[k][i] - p[k], p[k] - (double)node->bounds[k + 3][i]), 0);
            square += d * d;
        }
        if (square >= least) continue;
        int at = top++;
        for (; at > base && stack[at - 1].square < square; at--) stack[at] = stack[at - 1];
        stack[at] = (entry){node->child[i], square};
    }
    return top;
}

/* False: that was too much work. n->square: no triangle further away counts. */
static bool find_nearest(chooser *c, nearest *n)
{
    const daft_bvh *bvh = c->s->bvh;
    const double p[3] = {n->from.x, n->from.y, n->from.z};
    entry stack[DAFT_STACK];
    int top = 0;
    stack[top++] = (entry){0, 0};
    while (top > 0) {
        entry at = stack[--top];
        if (at.square >= n->square) continue;
        uint32_t blocks = (at.child & 3) + 1;
        if (c->work < blocks) return false;
        if (!(at.child & DAFT_CHILD_LEAF)) {
            c->work--;
            top = push_children(stack, top, &bvh->nodes.items[at.child], p, n->square);
            continue;
        }
        c->work -= blocks;
        for (uint32_t i = 0; i < blocks; i++) meet_block(n, &bvh->blocks[((at.child & ~DAFT_CHILD_LEAF) >> 2) + i]);
    }
    return true;
}

/* As near as a cap's box is. */
static void meet_caps(nearest *n, const daft_inner *caps)
{
    const double p[3] = {n->from.x, n->from.y, n->from.z};
    for (uint32_t i = 0; i < caps->cap_count; i++) {
        double place[3], square = 0;
        for (int k = 0; k < 3; k++) {
            place[k] = fmin(fmax(p[k], (double)caps->caps.bounds[k][i]), (double)caps->caps.bounds[3 + k][i]);
            square += (p[k] - place[k]) * (p[k] - place[k]);
        }
        if (square < n->square) n->square = square, n->place = daft_dv3(place[0], place[1], place[2]);
    }
}

/* ---- a ball ---- */

typedef struct ball {
    daft_dvec3 centre;
    double radius;
} ball;

/* How far it is from a point in a float's place to what is nearest, up to `most`. Negative: too much work. */
static double room_at(chooser *c, daft_dvec3 *point, double most, daft_dvec3 *from)
{
    *point = daft_to_double(daft_to_float(*point));
    nearest n = {.from = *point, .place = *point, .square = most * most};
    if (!find_nearest(c, &n)) return -1;
    meet_caps(&n, c->s->out);
    *from = n.place;
    return sqrt(n.square);
}

/* Moves from the cell's middle away from what is nearest. */
static ball grow(chooser *c, uint32_t cell)
{
    const daft_inner_search *s = c->s;
    daft_dvec3 from;
    ball best = {.centre = daft_cell_middle(s, cell)};
    double step = s->cell, most = (s->depth[cell] / 3.0 + 2) * s->cell;
    best.radius = room_at(c, &best.centre, most, &from);
    for (int i = 0; i < STEPS && best.radius > 0; i++) {
        daft_dvec3 place, way = daft_dsub(best.centre, from), to = daft_dadd(best.centre, daft_dscale(way, step / best.radius));
        double room = room_at(c, &to, best.radius + step, &place);
        if (room < 0) break;
        if (room > best.radius)
            best = (ball){to, room}, from = place;
        else
            step *= 0.5;
    }
    best.radius = best.radius * (1 - 0x1p-20) - s->pad;
    return best;
}

/* ---- what it covers ---- */

/* Bits of a row of cells whose middles are within a ball's circle, `up` cells from its middle. */
static uint64_t circle_row(double middle, double radius, double up)
{
    double half = sqrt(fmax(radius * radius - up * up, 0)), low = ceil(middle - half), high = floor(middle + half);
    if (low < 0) low = 0;
    if (high > DAFT_GRID - 1) high = DAFT_GRID - 1;
    if (low > high) return 0;
    return (~(uint64_t)0 >> (DAFT_GRID - 1 - (int)(high - low))) << (int)low;
}

/* The cells of the three pictures that a ball would add, in cells' units; `take` adds them. */
static uint32_t covers(chooser *c, const double at[3], double radius, bool take)
{
    uint32_t gain = 0;
    for (int k = 0; k < 3; k++) {
        double x = at[(k + 1) % 3], y = at[(k + 2) % 3];
        int low = (int)fmax(ceil(y - radius), 0), high = (int)fmin(floor(y + radius), DAFT_GRID - 1);
        for (int row = low; row <= high; row++) {
            uint64_t bits = circle_row(x, radius, row - y);
            gain += (uint32_t)__builtin_popcountll(bits & ~c->covered[k][row]);
            if (take) c->covered[k][row] |= bits;
        }
    }
    return gain;
}

/* A ball of its own radius, or of a cell as the grid has it. */
static uint32_t gain_of(chooser *c, const ball *b, bool take)
{
    const daft_inner_search *s = c->s;
    const double at[3] = {(b->centre.x - s->low[0]) / s->cell - 0.5, (b->centre.y - s->low[1]) / s->cell - 0.5,
                          (b->centre.z - s->low[2]) / s->cell - 0.5};
    return covers(c, at, b->radius / s->cell, take);
}

/* ---- the choice ---- */

static bool is_ridge(const daft_inner_search *s, uint32_t cell)
{
    const uint32_t step[3] = {1, s->size[0], s->size[0] * s->size[1]};
    uint16_t depth = s->depth[cell];
    if (!depth) return false;
    for (int k = 0; k < 3; k++)
        if (s->depth[cell + step[k]] > depth || s->depth[cell - step[k]] > depth) return false;
    return true;
}

/* The deepest of the cells that are no less deep than those beside them. */
static uint32_t list_candidates(const daft_inner_search *s, uint32_t list[CANDIDATES])
{
    uint32_t tally[4 * DAFT_GRID] = {0}, count = 0, kept = 0, least = DAFT_COUNT_OF(tally);
    for (uint32_t i = 0; i < s->cell_count; i++)
        if (is_ridge(s, i)) tally[daft_min_u(s->depth[i], DAFT_COUNT_OF(tally) - 1)]++;
    while (least > 1 && count + tally[least - 1] <= CANDIDATES) count += tally[--least];
    for (uint32_t i = 0; i < s->cell_count; i++)
        if (is_ridge(s, i) && s->depth[i] >= least) list[kept++] = i;
    return kept;
}

static void choose(chooser *c, const uint32_t *list, uint32_t count)
{
    const daft_inner_search *s = c->s;
    daft_inner *out = s->out;
    double least = 0;
    bool gone[CANDIDATES] = {false};
    for (int tries = 0; tries < TRIES && out->count < DAFT_INNER_BALLS; tries++) {
        uint32_t best = 0, most = 0;
        for (uint32_t i = 0; i < count; i++) {
            const ball b = {daft_cell_middle(s, list[i]), (s->depth[list[i]] / 3.0 - 0.25) * s->cell};
            uint32_t gain = gone[i] ? 0 : gain_of(c, &b, false);
            if (gain > most) most = gain, best = i;
        }
        if (most <= least) return;
        least = fmax(least, most * LEAST_GAIN);
        gone[best] = true;
        const ball b = grow(c, list[best]);
        if (!(b.radius > 0) || !gain_of(c, &b, true)) continue;
        out->centre[0][out->count] = (float)b.centre.x, out->centre[1][out->count] = (float)b.centre.y;
        out->centre[2][out->count] = (float)b.centre.z;
        out->radius[out->count++] = (float)(b.radius * (1 - 0x1p-20));
    }
}

static bool find(daft_inner_search *s)
{
    uint32_t list[CANDIDATES];
    bool done = daft_inner_close(s) && daft_inner_fill(s);
    if (done) {
        chooser c = {.s = s, .work = WORK_A_TRIANGLE * (uint64_t)s->mesh->triangle_count + 16384};
        choose(&c, list, list_candidates(s, list));
    }
    daft_release(s->allocator, s->depth);
    return done && s->out->count > 0;
}

bool daft_bvh_find_inner(daft_bvh *bvh, const daft_trimesh *mesh)
{
    if (bvh->inner) return true;
    if (bvh->nodes.count == 0) return false;
    bvh->inner = daft_alloc_zero(&bvh->allocator, 1, sizeof *bvh->inner);
    if (!bvh->inner) return false;
    for (int i = 0; i < DAFT_INNER_BALLS; i++) bvh->inner->radius[i] = -INFINITY;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < DAFT_INNER_CAPS; i++) bvh->inner->caps.bounds[k][i] = INFINITY, bvh->inner->caps.bounds[3 + k][i] = -INFINITY;
    daft_inner_search s = {.allocator = &bvh->allocator, .mesh = mesh, .bvh = bvh, .pad = daft_sides_pad(mesh), .out = bvh->inner};
    if (!find(&s)) daft_inner_drop(bvh);
    return bvh->inner != NULL;
}
