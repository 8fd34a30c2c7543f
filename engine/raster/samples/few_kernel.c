/* Shadow test of few points against a mesh. Rays are moved to the mesh's own space with points as lanes; then each
 * point's ray walks the BVH alone, with eight boxes or DAFT_VL triangles as lanes. mesh_kernel.c has the definition of
 * what hides a point. Among 1,000 instances of a mesh, shadow rays take half as long again without this, 0.94 of the
 * peer's speed instead of 1.4; single meshes and scenes take no longer. */
#include "math/simd/ops.h"
#include "raster/samples/setup.h"

enum {
    FEW_POINTS = 64, /* at a time */
    FEW_LEAVES = 24  /* leaves before their triangles are tested */
};

/* Points one by one, not in blocks; sets of them are bits. */
typedef struct few_points {
    uint32_t count;
    uint64_t live; /* those that are still lit */
    _Alignas(64) float u[FEW_POINTS + DAFT_VL], v[FEW_POINTS + DAFT_VL], depth[FEW_POINTS + DAFT_VL];
    _Alignas(64) float from[3][FEW_POINTS + DAFT_VL], inverse[3][FEW_POINTS + DAFT_VL]; /* object space: places, and one
                                                                                         * over the rays to the light */
    bool alike;                 /* along each axis all rays go up, or all down: */
    uint32_t first[3], last[3]; /* which of a node's two planes, row of its low or high bounds, the rays enter by and
                                 * leave by; where not alike, either way round */
    float first_pad[3], last_pad[3];   /* what is added to these rows */
    uint32_t at[FEW_POINTS + DAFT_VL]; /* among the blocks' */
} few_points;

/* Places in view space become such in object space, and their rays to the light are set. */
static void few_rays(const mesh_occluder *m, few_points *f)
{
    const float *b = m->back.m, *t = m->back.t, away = m->c.view->pencil.away;
    vbits up[3] = {0}, down[3] = {0};
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        vf x = vf_load(&f->from[0][i]), y = vf_load(&f->from[1][i]), z = vf_load(&f->depth[i]);
        for (int k = 0; k < 3; k++) {
            vf across = vf_set(b[3 * k]) * x + vf_set(b[3 * k + 1]) * y;
            vf direction = m->c.view->pencil.parallel ? vf_set(-b[3 * k + 2])
                                                      : -(across + vf_set(b[3 * k + 2]) * (z + vf_set(away)));
            vf_store(&f->from[k][i], across + vf_set(b[3 * k + 2]) * z + vf_set(t[k]));
            vf_store(&f->inverse[k][i], inverse_of(direction));
            vbits some = vbits_first_n((int)(f->count - i)),
                  falls = vbits_from_mask(vf_lt(inverse_of(direction), vf_set(0)));
            down[k] |= falls & some, up[k] |= ~falls & some;
        }
    }
    f->alike = true;
    for (int k = 0; k < 3; k++) {
        f->alike = f->alike && !(up[k] && down[k]);
        f->first[k] = (uint32_t)(down[k] ? 3 + k : k), f->last[k] = (uint32_t)(down[k] ? k : 3 + k);
        f->first_pad[k] = down[k] ? m->pad[k] : -m->pad[k], f->last_pad[k] = -f->first_pad[k];
    }
}

/* Some of a block's points go after those there are. */
DAFT_INLINE void few_add(const shadow_points *p, const block_points *some, few_points *out)
{
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        uint32_t at = some->block * SHADOW_BLOCK + k, count = out->count;
        vf depth = vf_load(&p->depth[at]);
        vbits lit = some->points >> k & vbits_from_mask(vf_lt(vf_set(-INFINITY), depth));
        vf_compress_store(&out->u[count], lit, vf_load(&p->u[at])),
            vf_compress_store(&out->v[count], lit, vf_load(&p->v[at]));
        vf_compress_store(&out->from[0][count], lit, vf_load(&p->x[at])),
            vf_compress_store(&out->from[1][count], lit, vf_load(&p->y[at]));
        vf_compress_store(&out->depth[count], lit, depth);
        vi_compress_store(&out->at[count], lit, vi_iota() + vi_set((int32_t)at));
        out->count += (uint32_t)__builtin_popcount(lit);
    }
}

/* The triangles whose box a point lies behind. */
DAFT_INLINE vbits triangles_over(const lanes *t, const few_points *f, uint32_t i)
{
    vf u = vf_set(f->u[i]), v = vf_set(f->v[i]);
    vm in = vm_and(vm_and(vf_le(vf_load(t->low_u), u), vf_le(u, vf_load(t->high_u))),
                   vm_and(vf_le(vf_load(t->low_v), v), vf_le(v, vf_load(t->high_v))));
    return vbits_from_mask(vm_and(in, vf_le(vf_load(t->near), vf_set(f->depth[i]))));
}

DAFT_INLINE vf edges_at(const lanes *t, int k, vf3 d)
{
    return vf_load(t->nx[k]) * d.x + vf_load(t->ny[k]) * d.y + vf_load(t->nz[k]) * d.z;
}

/* Whether one of the triangles hides the point: hide_points, with triangles for lanes. */
static bool point_hidden(const mesh_occluder *m, const lanes *t, const leaf *const *leaves, vbits triangles,
                         uint32_t at)
{
    const occluder *c = &m->c;
    const shadow_points *p = c->points;
    const vf3 d = {vf_set(p->x[at]), vf_set(p->y[at]), vf_set(p->z[at])};
    vf e0 = edges_at(t, 0, d), e1 = edges_at(t, 1, d), e2 = edges_at(t, 2, d);
    vf min = vf_min(e0, vf_min(e1, e2)), max = vf_max(e0, vf_max(e1, e2)), wide = vf_load(t->wide);
    vbits side = vbits_from_mask(vm_or(vf_le(-wide, min), vf_le(max, wide))) & triangles;
    if (!side) return false;
    bool on = p->instance[at] == c->number, apart = c->convex || c->flat;
    if (on && !apart) side &= ~vbits_from_mask(vi_eq(vi_load(t->triangle), vi_set((int32_t)p->own[at])));
    if (!side) return false;
    vf bound = vf_load(t->bound), rounding = vf_load(t->rounding), limit = vf_set(p->depth[at]);
    vm sure = vm_or(vf_le(-bound, min), vf_le(max, bound));
    vf inverse = vf_set(1) / (e0 + e1 + e2);
    vf depth = (e0 * vf_load(t->depth[0]) + e1 * vf_load(t->depth[1]) + e2 * vf_load(t->depth[2])) * inverse;
    vf error = vf_abs(vf_load(t->slack) * inverse) + rounding;
    vf behind = rounding + vf_set(c->view->pencil.away * 0x1p-20f + p->end[at]);
    if (vbits_from_mask(vm_and(sure, vm_and(vf_lt(depth + error, limit), vf_lt(behind, depth)))) & side) return true;
    if (on && (c->convex || (c->flat && p->own[at] != DAFT_NO_TRIANGLE))) return false;
    const vm past = vf_lt(depth + error, vf_set(p->end[at] - c->view->pencil.away * 0x1p-20f));
    side &= ~vbits_from_mask(past);
    for (vbits doubt = side & vbits_from_mask(vf_lt(depth - error, limit)); doubt; doubt &= doubt - 1) {
        int i = __builtin_ctz(doubt);
        if (DAFT_KERNEL(daft_stands_between)(c, leaves[i / DAFT_BLOCK]->block, i % DAFT_BLOCK, p->source[at]))
            return true;
    }
    return false;
}

static void few_darken(const mesh_occluder *m, few_points *f, uint32_t i)
{
    shadow_points *p = m->c.points;
    f->live &= ~((uint64_t)1 << i);
    p->depth[f->at[i]] = -INFINITY;
    block_darkened(p, f->at[i] / SHADOW_BLOCK);
}

/* Which points lie behind which triangles' boxes is found first, so that no branch hangs on it. */
static void few_test(const mesh_occluder *m, few_points *f, const leaf *const *leaves, uint32_t blocks)
{
    lanes t;
    uint32_t count = 0, point[FEW_POINTS + 1];
    vbits triangles[FEW_POINTS + 1];
    uint64_t behind = 0;
    for (uint32_t k = 0; k < DAFT_VL / 4; k++) behind |= leaves[k]->behind.bits[0];
    behind &= f->live;
    if (!behind) return;
    view_corners moved = corners_move(m, leaves);
    vbits live = lanes_name(leaves, blocks, &t);
    lanes_place(m, &moved, &t);
    if (!m->before) live &= lanes_met(m, &moved, &t);
    for (; behind; behind &= behind - 1) {
        point[count] = (uint32_t)__builtin_ctzll(behind);
        triangles[count] = triangles_over(&t, f, point[count]) & live;
        count += triangles[count] != 0;
    }
    if (!count) return;
    lanes_setup(m, &moved, false, &t);
    for (uint32_t k = 0; k < count; k++)
        if (point_hidden(m, &t, leaves, triangles[k], f->at[point[k]])) few_darken(m, f, point[k]);
}

/* `node`: a child, leaf or not, and which of the points lie behind it. */
typedef struct few_entry {
    uint32_t node;
    uint64_t behind;
} few_entry;

static void few_flush(const mesh_occluder *m, const few_entry *ends, uint32_t count, few_points *f)
{
    leaf list[(FEW_LEAVES + DAFT_WIDTH) * DAFT_MAX_LEAF_BLOCKS];
    uint32_t blocks = 0;
    for (uint32_t i = 0; i < count; i++) {
        const block_set behind = {{ends[i].behind}};
        blocks = list_leaf(m->c.instance->bvh, ends[i].node, &behind, list, blocks);
    }
    for (uint32_t i = 0; i < blocks; i += DAFT_VL / 4) {
        const leaf *leaves[DAFT_VL / 4];
        for (uint32_t k = 0; k < DAFT_VL / 4; k++) leaves[k] = &list[i + k < blocks ? i + k : i];
        few_test(m, f, leaves, blocks - i);
    }
}

/* Which of the points' rays to the light meet which of a node's children, in `met` as bits for each point: few points
 * cost less so than boxes seen from the light. Gives the bits of the children that some meet. Where all rays go up an
 * axis, or all down, it is known which side of a box they come to first; of an empty box that is infinitely far. */
DAFT_INLINE uint32_t children_met(const mesh_occluder *m, const daft_node *node, const few_points *f, uint64_t from,
                                  uint8_t *met)
{
    uint32_t any = 0;
    v8 first[3], last[3];
    for (int k = 0; k < 3; k++) {
        first[k] = v8_load(node->bounds[f->first[k]]) + v8_set(f->first_pad[k]);
        last[k] = v8_load(node->bounds[f->last[k]]) + v8_set(f->last_pad[k]);
    }
    for (uint64_t left = from; left; left &= left - 1) {
        uint32_t i = (uint32_t)__builtin_ctzll(left);
        v8 near = v8_set(0), far = v8_set(m->c.view->pencil.parallel ? INFINITY : 1.00001f);
        for (int k = 0; k < 3; k++) {
            v8 at = v8_set(f->from[k][i]), inverse = v8_set(f->inverse[k][i]);
            v8 a = (first[k] - at) * inverse, b = (last[k] - at) * inverse;
            near = v8_max(f->alike ? a : v8_min(a, b), near), far = v8_min(f->alike ? b : v8_max(a, b), far);
        }
        uint32_t children = v8_le_bits(near, far * v8_set(1 + 0x1p-20f));
        met[i] = (uint8_t)children;
        any |= children;
    }
    return f->alike ? any : any & v8_le_bits(v8_load(node->bounds[0]), v8_load(node->bounds[3]));
}

/* A node's children that some of the points lie behind: nodes go on the stack, leaves to the list. No branch hangs on
 * which. */
DAFT_INLINE void few_children(const mesh_occluder *m, const few_entry *at, const few_points *f, few_entry *stack,
                              int *top, few_entry *leaves, uint32_t *leaf_count)
{
    const daft_node *node = &m->c.instance->bvh->nodes.items[at->node];
    uint8_t met[FEW_POINTS] = {0};
    for (uint32_t any = children_met(m, node, f, at->behind & f->live, met); any; any &= any - 1) {
        int i = __builtin_ctz(any);
        const few_entry next = {node->child[i], vu8_test_bit(met, f->count, i)};
        bool ends = next.node >> 31;
        stack[*top] = next, leaves[*leaf_count] = next;
        *top += !ends, *leaf_count += ends;
    }
}

static void few_walk(const mesh_occluder *m, few_points *f)
{
    const daft_bvh *bvh = m->c.instance->bvh;
    few_entry stack[DAFT_STACK], ends[FEW_LEAVES + DAFT_WIDTH];
    uint32_t end_count = 0;
    int top = 0;
    stack[top++] = (few_entry){0, f->live};
    while (top > 0) {
        const few_entry at = stack[--top];
        if (!(at.behind & f->live)) continue;
        few_children(m, &at, f, stack, &top, ends, &end_count);
        if (top > 0) fetch_node(bvh, stack[top - 1].node);
        if (end_count < FEW_LEAVES) continue;
        few_flush(m, ends, end_count, f);
        end_count = 0;
    }
    few_flush(m, ends, end_count, f);
}

/* Those that are added so far. */
static void few_cast(const mesh_occluder *m, few_points *f)
{
    if (!f->count) return;
    f->live = ~(uint64_t)0 >> (FEW_POINTS - f->count);
    few_rays(m, f);
    few_walk(m, f);
    f->count = 0;
}

void DAFT_KERNEL(daft_few_shadow)(const mesh_occluder *m, const block_points *points, uint32_t count)
{
    few_points few;
    few.count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (few.count > FEW_POINTS - SHADOW_BLOCK) few_cast(m, &few);
        few_add(m->c.points, &points[i], &few);
    }
    few_cast(m, &few);
}
