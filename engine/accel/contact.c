/* Triangles that come near others: where a corner that moves by the pad may bring another triangle through this one, the
 * winding number behind it is not sure.
 *
 * Pairs are found through the mesh's own tree, leaf by leaf; a leaf marks only its own triangles, so that the marks are the same for any
 * number of threads. A pair is kept apart
 * - where it shares no corner, by a plane that leaves a gap of more than two pads between the two;
 * - where it shares one, by a plane through it that leaves the others' corners more than two pads on either side;
 * - where it shares an edge, by an angle that four pads at both far corners cannot close.
 * A leaf with very many pairs is given up: its triangles count as touched. So time is bounded by the number of leaves; and
 * where a sample of them has many, the whole mesh is. */
#include "accel/find_sides.h"
#include "math/simd/ops.h"

#include <string.h>

enum {
    NODES_A_TASK = 16,
    LEAF_WORK = 1024,   /* nodes, blocks and pairs that are looked at for a leaf; some 190 where triangles lie side by side */
    USUAL_WORK = 512,   /* on average over a sample, for the mesh to be worth it */
    SAMPLES = 128       /* nodes; and what has fewer than eight times as many takes no time that matters */
};

typedef struct pair {
    daft_dvec3 a[3], b[3]; /* corners of either; those that are shared come first, in the same order */
    uint32_t shared;
} pair;

static void swap(daft_dvec3 *a, daft_dvec3 *b)
{
    daft_dvec3 was = *a;
    *a = *b, *b = was;
}

/* False: they are the same triangle, or share all corners. */
static void pair_make(const daft_side_search *s, uint32_t t, uint32_t u, pair *out)
{
    const uint32_t *place = s->adjacency.place, *ti = &s->mesh->indices[3 * (size_t)t], *ui = &s->mesh->indices[3 * (size_t)u];
    uint32_t a[3] = {place[ti[0]], place[ti[1]], place[ti[2]]}, b[3] = {place[ui[0]], place[ui[1]], place[ui[2]]};
    for (uint32_t k = 0; k < 3; k++) out->a[k] = daft_corner_of(s->mesh, t, k), out->b[k] = daft_corner_of(s->mesh, u, k);
    out->shared = 0;
    for (uint32_t i = 0; i < 3; i++)
        for (uint32_t j = out->shared; j < 3; j++) {
            if (a[i] != b[j]) continue;
            uint32_t to = out->shared++, id = a[i];
            swap(&out->a[to], &out->a[i]), a[i] = a[to], a[to] = id;
            swap(&out->b[to], &out->b[j]), b[j] = b[to], b[to] = id;
            break;
        }
}

/* Whether all of a's corners from `first` on are further along n than all of b's, by more than the gap, or less. */
static bool splits(const pair *p, uint32_t first, daft_dvec3 n, double gap)
{
    double a_low = INFINITY, a_high = -INFINITY, b_low = INFINITY, b_high = -INFINITY;
    for (uint32_t k = first; k < 3; k++) {
        double a = daft_ddot(n, p->a[k]), b = daft_ddot(n, p->b[k]);
        a_low = fmin(a_low, a), a_high = fmax(a_high, a);
        b_low = fmin(b_low, b), b_high = fmax(b_high, b);
    }
    double least = gap * sqrt(daft_ddot(n, n)), between = fmax(a_low - b_high, b_low - a_high);
    return between > least;
}

static daft_dvec3 middle_of(const daft_dvec3 p[3])
{
    return daft_dscale(daft_dadd(daft_dadd(p[0], p[1]), p[2]), 1.0 / 3);
}

static daft_dvec3 normal_of(const daft_dvec3 p[3])
{
    return daft_dcross(daft_dsub(p[1], p[0]), daft_dsub(p[2], p[0]));
}

/* The planes that part two triangles, if any does: along their normals, across their edges in their own planes, and along
 * pairs of edges. */
static bool apart(const pair *p, double gap)
{
    daft_dvec3 n = normal_of(p->a), m = normal_of(p->b);
    if (splits(p, 0, daft_dsub(middle_of(p->a), middle_of(p->b)), gap) || splits(p, 0, n, gap) || splits(p, 0, m, gap)) return true;
    for (int i = 0; i < 3; i++) {
        daft_dvec3 e = daft_dsub(p->a[(i + 1) % 3], p->a[i]), f = daft_dsub(p->b[(i + 1) % 3], p->b[i]);
        if (splits(p, 0, daft_dcross(n, e), gap) || splits(p, 0, daft_dcross(m, f), gap)) return true;
        for (int j = 0; j < 3; j++)
            if (splits(p, 0, daft_dcross(e, daft_dsub(p->b[(j + 1) % 3], p->b[j])), gap)) return true;
    }
    return false;
}

static daft_dvec3 unit(daft_dvec3 v)
{
    double length = sqrt(daft_ddot(v, v));
    return length > 0 ? daft_dscale(v, 1 / length) : v;
}

/* Whether the far corners of a and b lie more than the gap on either side of the plane through the shared corner, normal n. */
static bool splits_cone(const pair *p, daft_dvec3 n, double gap)
{
    double least = gap * sqrt(daft_ddot(n, n)), at = daft_ddot(n, p->a[0]);
    double a1 = daft_ddot(n, p->a[1]) - at, a2 = daft_ddot(n, p->a[2]) - at;
    double b1 = at - daft_ddot(n, p->b[1]), b2 = at - daft_ddot(n, p->b[2]);
    return (a1 > least && a2 > least && b1 > least && b2 > least) || (a1 < -least && a2 < -least && b1 < -least && b2 < -least);
}

/* As seen from the corner, the triangles are two arcs of a sphere. The circle that parts them best has as its normal the
 * point nearest to the origin of the hull of a's ends and b's, negated: of unit length, so that is one of them, or half-way
 * between two, or across the plane of three. */
static bool apart_at_corner(const pair *p, double gap)
{
    daft_dvec3 end[4], n = {0, 0, 0};
    for (int k = 0; k < 4; k++) {
        end[k] = k < 2 ? daft_dsub(p->a[k + 1], p->a[0]) : daft_dsub(p->b[0], p->b[k - 1]);
        n = daft_dadd(n, end[k]);
    }
    if (splits_cone(p, n, gap)) return true;
    for (int k = 0; k < 4; k++) end[k] = unit(end[k]);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < i; j++)
            if (splits_cone(p, daft_dadd(end[i], end[j]), gap)) return true;
    for (int i = 0; i < 4; i++) {
        daft_dvec3 a = end[(i + 1) % 4], b = end[(i + 2) % 4], c = end[(i + 3) % 4];
        if (splits_cone(p, daft_dcross(daft_dsub(b, a), daft_dsub(c, a)), gap) || splits_cone(p, end[i], gap)) return true;
    }
    return false;
}

/* How far, as an angle, the plane of the edge u, v and a corner turns about the edge at most when all move by the pad; the
 * corner's direction across the edge goes to *across, unit. */
static double turn_of(daft_dvec3 u, daft_dvec3 v, daft_dvec3 corner, double pad, daft_dvec3 *across)
{
    daft_dvec3 edge = daft_dsub(v, u), to = daft_dsub(corner, u);
    double square = daft_ddot(edge, edge), along = daft_ddot(to, edge) / square;
    daft_dvec3 height = daft_dsub(to, daft_dscale(edge, along));
    double length = sqrt(daft_ddot(height, height)), moved = pad * (2 + 2 * fabs(along));
    *across = daft_dscale(height, 1 / length);
    return moved / length;
}

static bool apart_at_edge(const pair *p, double pad)
{
    daft_dvec3 a, b;
    double turn = turn_of(p->a[0], p->a[1], p->a[2], pad, &a), other = turn_of(p->b[0], p->b[1], p->b[2], pad, &b);
    if (!(turn < 0.25 && other < 0.25)) return false;
    if (daft_ddot(a, b) <= 0) return true;
    daft_dvec3 sine = daft_dcross(a, b);
    double least = 2 * (turn + other);
    return daft_ddot(sine, sine) > least * least;
}

static bool are_apart(const daft_side_search *s, uint32_t t, uint32_t u)
{
    pair p;
    pair_make(s, t, u, &p);
    switch (p.shared) {
    case 0: return apart(&p, 2 * s->pad);
    case 1: return apart_at_corner(&p, 2 * s->pad);
    case 2: return apart_at_edge(&p, s->pad);
    default: return false;
    }
}

/* ---- pairs ---- */

typedef struct block_box {
    v4 low[3], high[3]; /* lanes: triangles */
} block_box;

static block_box box_of(const daft_block *block)
{
    block_box box;
    for (int k = 0; k < 3; k++) {
        v4 a = v4_load(block->corner[0][k]), b = v4_load(block->corner[1][k]), c = v4_load(block->corner[2][k]);
        box.low[k] = v4_min(v4_min(a, b), c), box.high[k] = v4_max(v4_max(a, b), c);
    }
    return box;
}

/* A leaf at work: its triangles, their boxes grown by the gap, and which are not marked. */
typedef struct leaf {
    const daft_side_search *search;
    uint32_t triangle[DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK];
    float low[3][DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK], high[3][DAFT_MAX_LEAF_BLOCKS * DAFT_BLOCK];
    float all_low[3], all_high[3];
    uint32_t open; /* bits */
    int work;      /* left */
} leaf;

static float grown(float value, double by) { return (float)((double)value + by * (1 + 0x1p-10) + fabs((double)value) * copysign(0x1p-22, by)); }

static void leaf_begin(const daft_side_search *s, const daft_block *blocks, uint32_t count, leaf *out)
{
    *out = (leaf){.search = s, .work = LEAF_WORK};
    for (int k = 0; k < 3; k++) out->all_low[k] = INFINITY, out->all_high[k] = -INFINITY;
    for (uint32_t i = 0; i < count * DAFT_BLOCK; i++) {
        const daft_block *block = &blocks[i / DAFT_BLOCK];
        uint32_t lane = i % DAFT_BLOCK, triangle = out->triangle[i] = block->triangle[lane];
        if (triangle == DAFT_NO_TRIANGLE || __atomic_load_n(&s->marks[triangle], __ATOMIC_RELAXED) == DAFT_SIDES_DOUBLE) continue;
        out->open |= 1u << i;
        for (int k = 0; k < 3; k++) {
            float a = block->corner[0][k][lane], b = block->corner[1][k][lane], c = block->corner[2][k][lane];
            out->low[k][i] = grown(fminf(fminf(a, b), c), -2 * s->pad), out->high[k][i] = grown(fmaxf(fmaxf(a, b), c), 2 * s->pad);
            out->all_low[k] = fminf(out->all_low[k], out->low[k][i]), out->all_high[k] = fmaxf(out->all_high[k], out->high[k][i]);
        }
    }
}

static void touch(leaf *l, uint32_t i)
{
    l->open &= ~(1u << i);
    __atomic_store_n(&l->search->marks[l->triangle[i]], DAFT_SIDES_TOUCHED, __ATOMIC_RELAXED);
}

static uint32_t met_by(const leaf *l, uint32_t i, const block_box *box)
{
    v4i met = {-1, -1, -1, -1};
    for (int k = 0; k < 3; k++)
        met &= (v4i)(box->low[k] <= v4_set(l->high[k][i])) & (v4i)(v4_set(l->low[k][i]) <= box->high[k]);
    return (uint32_t)(met[0] & 1) | (uint32_t)(met[1] & 2) | (uint32_t)(met[2] & 4) | (uint32_t)(met[3] & 8);
}

static void meet_block(leaf *l, const daft_block *block)
{
    block_box box = box_of(block);
    l->work--;
    for (uint32_t open = l->open; open; open &= open - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(open);
        for (uint32_t met = met_by(l, i, &box); met; met &= met - 1) {
            uint32_t other = block->triangle[__builtin_ctz(met)];
            if (other == DAFT_NO_TRIANGLE || other == l->triangle[i]) continue;
            if (l->search->adjacency.across[3 * (size_t)other] == DAFT_ACROSS_NONE) continue; /* no ray hits it */
            l->work--;
            if (are_apart(l->search, l->triangle[i], other)) continue;
            touch(l, i);
            break;
        }
    }
}

/* Everything that the leaf's box meets. */
static void meet_all(leaf *l)
{
    const daft_bvh *bvh = l->search->bvh;
    const float *low = l->all_low, *high = l->all_high;
    uint32_t stack[DAFT_STACK];
    int top = 0;
    stack[top++] = 0;
    while (top > 0 && l->open && l->work > 0) {
        uint32_t child = stack[--top];
        if (child & DAFT_CHILD_LEAF) {
            const daft_block *block = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
            for (uint32_t k = 0; k <= (child & 3); k++) meet_block(l, &block[k]);
            continue;
        }
        const daft_node *node = &bvh->nodes.items[child];
        l->work--;
        for (int i = 0; i < DAFT_WIDTH; i++) {
            bool meets = node->child[i] != DAFT_CHILD_NONE;
            for (int k = 0; k < 3; k++)
                meets = meets && node->bounds[k][i] <= high[k] && low[k] <= node->bounds[k + 3][i];
            if (meets) stack[top++] = node->child[i];
        }
    }
    if (l->work > 0) return;
    for (; l->open; l->open &= l->open - 1) touch(l, (uint32_t)__builtin_ctz(l->open));
}

/* The leaves of a node; gives how many, and adds up what was done for them. */
static int mark_node(const daft_side_search *s, size_t n, uint64_t *work)
{
    int count = 0;
    for (int i = 0; i < DAFT_WIDTH; i++) {
        uint32_t child = s->bvh->nodes.items[n].child[i];
        if (child == DAFT_CHILD_NONE || !(child & DAFT_CHILD_LEAF)) continue;
        leaf l;
        leaf_begin(s, &s->bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2], (child & 3) + 1, &l);
        if (l.open) meet_all(&l);
        *work += (uint64_t)(LEAF_WORK - l.work), count++;
    }
    return count;
}

static bool is_crowded(const daft_side_search *s)
{
    size_t nodes = s->bvh->nodes.count;
    uint64_t leaves = 0, work = 0;
    for (size_t k = 0; k < SAMPLES; k++) leaves += (uint64_t)mark_node(s, k * nodes / SAMPLES, &work);
    return work > USUAL_WORK * leaves;
}

static void mark_leaves(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const daft_side_search *s = context;
    size_t end = daft_min_u((index + 1) * NODES_A_TASK, (uint32_t)s->bvh->nodes.count);
    uint64_t work = 0;
    for (size_t n = (size_t)index * NODES_A_TASK; n < end; n++) mark_node(s, n, &work);
}

void daft_sides_mark_contacts(daft_side_search *search, int threads)
{
    if (search->bvh->nodes.count > 8 * SAMPLES && is_crowded(search)) {
        memset(search->marks, DAFT_SIDES_TOUCHED, search->mesh->triangle_count);
        return;
    }
    uint32_t tasks = ((uint32_t)search->bvh->nodes.count + NODES_A_TASK - 1) / NODES_A_TASK;
    daft_parallel_for(tasks < 8 ? 1 : threads, tasks, mark_leaves, search);
}
