/* Walks an instance's BVH for one tile, by the screen boxes of eight nodes at a time. A node is culled when its box
 * lies beside the tile, between the rays of its pixels, or behind the nearest hits of all pixels that it covers. The
 * blocks of triangles in leaves are set up and drawn DAFT_VL / 4 at a time.
 *
 * Where triangles are large, nodes are visited front to back, one by one, so that more of them turn out to be hidden.
 * Where there is a triangle or more to a pixel, they are visited in groups, without a branch for a single node: there,
 * mispredicted branches would cost more than the arithmetic. */
#include "raster/boxes.h"
#include "raster/grid/hidden.h"

enum {
    GROUP = 16, /* nodes */
    FRESH = GROUP * DAFT_WIDTH,
    CROWDED = 1024, /* so many wait: no more groups; what one node leads to adds DAFT_STACK at most */
    WAITING = CROWDED + FRESH + DAFT_STACK,
    ORDERS = 4,        /* distances that are told apart within a group */
    FEW_LEAVES = 12,   /* drawn together: instances hide much of themselves */
    NEAR_BLOCKS = 4096 /* so many, 640 KB, stay in the nearer caches without a prefetch */
};

/* A node or leaf to be looked at. */
typedef struct visit {
    uint32_t child;
    float nearest;   /* no w in it is larger */
    uint32_t pixels; /* rays of the tile: x0 | x1 << 8 | y0 << 16 | y1 << 24 */
} visit;

/* Visits by lanes; room for a register from the last one on. */
typedef struct fresh_list {
    uint32_t count;
    uint32_t child[FRESH + DAFT_VL], pixels[FRESH + DAFT_VL];
    float nearest[FRESH + DAFT_VL];
} fresh_list;

/* What a group leads to. */
typedef struct fresh {
    fresh_list leaves, nodes;
    vf min, max; /* over the lanes: of the nodes' nearest */
} fresh;

/* Nodes that wait for their turn, the last one first. */
typedef struct node_stack {
    uint32_t count;
    uint32_t child[WAITING + DAFT_VL], pixels[WAITING + DAFT_VL];
    float nearest[WAITING + DAFT_VL];
} node_stack;

/* An instance's map to the tile: x and y come out in pixels times z. */
typedef struct walk {
    daft_tile_job *job;
    daft_queue *queue;
    const daft_view_instance *view;
    node_map map;
    node_map clip; /* to distances along the clipping plane's normal, as x; only where the job clips */
    uint32_t leaf_count, leaves[DAFT_LEAVES_ROOM + 16]; /* that wait, in groups: their codes */
    uint32_t block_count, blocks[DAFT_LEAVES_ROOM * DAFT_MAX_LEAF_BLOCKS + DAFT_VL];
} walk;

/* ---- what is hidden ---- */

_Static_assert(DAFT_CELLS_X == 8, "a row of cells is one register of eight floats");

static void refresh_cell(daft_tile_job *j, uint32_t x, uint32_t y)
{
    const float *w = &j->w_low[y * DAFT_CELL * DAFT_TILE_STRIDE + x * DAFT_CELL];
    v4 min = v4_min(v4_min(v4_load(w), v4_load(w + DAFT_TILE_STRIDE)),
                    v4_min(v4_load(w + 2 * DAFT_TILE_STRIDE), v4_load(w + 3 * DAFT_TILE_STRIDE)));
    float a = min[0] < min[1] ? min[0] : min[1], b = min[2] < min[3] ? min[2] : min[3];
    j->farthest[y][x] = a < b ? a : b;
}

bool DAFT_KERNEL(daft_cells_hidden)(daft_tile_job *j, uint32_t pixels, float min)
{
    uint32_t x0 = pixels & 255, x1 = pixels >> 8 & 255, y0 = pixels >> 16 & 255, last = (pixels >> 24) / DAFT_CELL;
    v8 nearest = v8_set(min);
    uint32_t columns = (2u << x1 / DAFT_CELL) - (1u << x0 / DAFT_CELL);
    for (uint32_t y = y0 / DAFT_CELL; y <= last; y++) {
        uint32_t open = v8_le_bits(v8_load(j->farthest[y]), nearest) & columns;
        if (!open) continue;
        if (open & ~j->stale[y]) return false;
        for (uint32_t left = open; left; left &= left - 1) refresh_cell(j, (uint32_t)__builtin_ctz(left), y);
        j->stale[y] &= ~open;
        if (v8_le_bits(v8_load(j->farthest[y]), nearest) & open) return false;
    }
    return true;
}

/* ---- nodes and leaves ---- */

void DAFT_KERNEL(daft_queue_draw)(daft_tile_job *job, daft_queue *queue)
{
    daft_pencil_batch batch;
    if (DAFT_KERNEL(daft_queue_setup)(job, queue, &batch)) DAFT_KERNEL(daft_batch_draw)(job, &batch);
}

/* At once if they are large or many: they may hide others. */
static void draw_blocks(walk *w)
{
    daft_pencil_batch batch;
    if (!w->block_count) return;
    if (DAFT_KERNEL(daft_blocks_setup)(w->job, w->view, w->blocks, w->block_count, w->queue, &batch))
        DAFT_KERNEL(daft_batch_draw)(w->job, &batch);
    w->block_count = 0;
    while (w->queue->count >= DAFT_VL) DAFT_KERNEL(daft_queue_draw)(w->job, w->queue);
}

/* The pixels of boxes along one axis; gives the lanes that have any. Boxes that reach behind the camera are out where
 * all that is in front of it lies beside the tile. */
DAFT_INLINE vbits box_span(vf_range at, const node_depths *z, float last, float widen, vi *first, vi *end)
{
    vbits beside = node_beside(at, z, -widen, last + widen);
    vf_range over = node_slopes(at, z);
    vf zero = vf_set(0), slack = vf_set(widen), end_of_all = vf_set(last);
    vf a = over.low - slack, b = over.high + slack;
    a = vf_max(vf_if_then_else(z->front, a, zero), zero),
    b = vf_min(vf_if_then_else(z->front, b, end_of_all), end_of_all);
    vf whole = vf_convert_to(vi_convert_to(a));
    whole = whole + vf_if_then_else(vf_lt(whole, a), vf_set(1), zero);
    *first = vi_convert_to(whole), *end = vi_convert_to(b);
    return vbits_from_mask(vm_and(vf_le(zero, b), vf_le(whole, b))) & ~beside;
}

DAFT_INLINE node_pair pair_make(const walk *w, uint32_t first, uint32_t second, int part)
{
    const daft_node *nodes = w->view->bvh->nodes.items;
    return (node_pair){&nodes[first], &nodes[second], part};
}

DAFT_INLINE vi child_load(const node_pair *n)
{
    return (vi)vf_load_eights((const float *)(const void *)n->first->child,
                              (const float *)(const void *)n->second->child, n->part);
}

/* pad: the error of a moved vertex, by axes. Where the instance begins to be seen lies as far from the plane. */
static void clip_begin(walk *w, const float pad[3])
{
    const daft_affine *map = &w->view->to_view;
    const daft_clip *c = &w->job->raster->clip;
    const float n[3] = {c->normal.x, c->normal.y, c->normal.z};
    float m[9] = {0}, t[3] = {0}, error[3] = {0};
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) m[i] += n[k] * map->m[3 * k + i];
        t[0] += n[k] * map->t[k], error[0] += fabsf(n[k]) * pad[k];
        w->job->clip[k] = n[k];
    }
    w->job->clip[3] = c->away + (w->view->index == c->owner ? 2 * error[0] : -error[0]);
    node_map_make(&w->clip, m, t, error);
}

static void walk_begin(walk *w, daft_tile_job *job, const daft_view_instance *view, daft_queue *queue)
{
    const daft_affine *map = &view->to_view;
    const daft_vec3 from = view->mesh->low, until = view->mesh->high;
    const float low[3] = {from.x, from.y, from.z}, high[3] = {until.x, until.y, until.z}, focal = job->pencil.focal;
    w->job = job, w->view = view, w->queue = queue, w->leaf_count = w->block_count = 0;
    float pad[3];
    for (int k = 0; k < 3; k++) {
        float size = fabsf(map->t[k]);
        for (int i = 0; i < 3; i++) size += fabsf(map->m[3 * k + i]) * fmaxf(fabsf(low[i]), fabsf(high[i]));
        pad[k] = size * 0x1p-20f;
    }
    if (job->clips) clip_begin(w, pad);
    pad[0] = pad[0] * focal + pad[2] * fabsf(job->left);
    pad[1] = pad[1] * focal + pad[2] * fabsf(job->top);
    /* column = focal·x/z - left and row = top - focal·y/z, so their multiples by z are linear in the point. */
    float m[9], t[3];
    for (int i = 0; i < 4; i++) {
        const float x = i < 3 ? map->m[i] : map->t[0], y = i < 3 ? map->m[3 + i] : map->t[1],
                    z = i < 3 ? map->m[6 + i] : map->t[2];
        const float row[3] = {x * focal - z * job->left, z * job->top - y * focal, z};
        for (int k = 0; k < 3; k++) *(i < 3 ? &m[3 * k + i] : &t[k]) = row[k];
    }
    node_map_make(&w->map, m, t, pad);
}

/* Children in the tile. */
typedef struct boxes {
    vi child, pixels;
    vf nearest;
    vbits some;
} boxes;

/* Comparisons are written so that a NaN, from an overflow, leaves a box in. */
DAFT_INLINE boxes children(const walk *w, const node_pair *n)
{
    vi x0, x1, y0, y1, child = child_load(n);
    vf_range along = node_axis(&w->map, 2, n);
    node_depths z = node_depths_of(along.low, along.high);
    vbits x = box_span(node_axis(&w->map, 0, n), &z, w->job->last_x, w->job->slack, &x0, &x1);
    vbits y = box_span(node_axis(&w->map, 1, n), &z, w->job->last_y, w->job->slack, &y0, &y1);
    vbits out =
        vbits_from_mask(vf_le(z.far, vf_set(0))) | vbits_from_mask(vi_eq(child, vi_set((int32_t)DAFT_CHILD_NONE)));
    if (w->job->clips) out |= vbits_from_mask(vf_le(node_axis(&w->clip, 0, n).high, vf_set(w->job->clip[3])));
    return (boxes){child, x0 | x1 << 8 | y0 << 16 | y1 << 24,
                   vf_if_then_else(z.front, z.inverse_near * vf_set(1 + 0x1p-20f), vf_set(INFINITY)), x & y & ~out};
}

/* What a visit will read first: trees of large meshes do not stay in the nearer caches. */
DAFT_INLINE void prefetch(const daft_bvh *bvh, uint32_t child)
{
    bool leaf = child & DAFT_CHILD_LEAF;
    const char *at =
        leaf ? (const char *)&bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2] : (const char *)&bvh->nodes.items[child];
    int bytes = leaf ? (int)((child & 3) + 1) * (int)sizeof(daft_block) : 256;
    for (int i = 0; i < bytes; i += 64) __builtin_prefetch(at + i);
}

static void prefetch_all(const daft_bvh *bvh, const fresh_list *list)
{
    for (uint32_t i = 0; i < list->count; i++) prefetch(bvh, list->child[i]);
}

/* ---- one node after the other ---- */

/* Pushes the children that may be seen, the nearest last. */
static int push_children(walk *w, uint32_t node, visit *stack, int top)
{
    int first = top;
    w->job->counters->nodes++;
    for (int part = 0; part < DAFT_EIGHT_PARTS; part++) {
        node_pair same = pair_make(w, node, node, part);
        boxes b = children(w, &same);
        for (uint32_t some = b.some & ((1u << DAFT_WIDTH) - 1); some; some &= some - 1) {
            int i = __builtin_ctz(some), at = top;
            visit v = {(uint32_t)b.child[i], b.nearest[i], (uint32_t)b.pixels[i]};
            for (; at > first && stack[at - 1].nearest > v.nearest; at--) stack[at] = stack[at - 1];
            stack[at] = v;
            top++;
            prefetch(w->view->bvh, v.child);
        }
    }
    return top;
}

static void add_leaf(walk *w, uint32_t child)
{
    uint32_t block = (child & ~DAFT_CHILD_LEAF) >> 2;
    for (uint32_t count = (child & 3) + 1; count; count--) {
        w->blocks[w->block_count++] = block++;
        if (w->block_count == DAFT_BATCH_BLOCKS) draw_blocks(w);
    }
}

static void draw_singly(walk *w)
{
    visit stack[DAFT_STACK];
    int top = push_children(w, 0, stack, 0);
    while (top) {
        visit v = stack[--top];
        if (hidden(w->job, v.pixels, v.nearest)) continue;
        if (v.child & DAFT_CHILD_LEAF)
            add_leaf(w, v.child);
        else
            top = push_children(w, v.child, stack, top);
    }
    draw_blocks(w);
}

/* ---- in groups ---- */

DAFT_INLINE void add_to_list(fresh_list *list, const boxes *b, vbits lanes)
{
    uint32_t at = list->count;
    vi_compress_store(&list->child[at], lanes, b->child);
    vi_compress_store(&list->pixels[at], lanes, b->pixels);
    vf_compress_store(&list->nearest[at], lanes, b->nearest);
    list->count = at + (uint32_t)__builtin_popcount(lanes);
}

/* The children of up to DAFT_EIGHTS nodes. */
DAFT_INLINE void add_children(const walk *w, const uint32_t *nodes, uint32_t count, fresh *out)
{
    vbits there = vbits_first_n((int)(count * DAFT_WIDTH));
    for (int part = 0; part < DAFT_EIGHT_PARTS; part++) {
        node_pair two = pair_make(w, nodes[0], nodes[count > 1], part);
        boxes b = children(w, &two);
        b.some &= there;
        vbits leaves = b.some & vbits_from_mask(vi_lt(b.child, vi_set(0))), inner = b.some & ~leaves;
        vm m = vm_from_bits(inner);
        out->min = vf_min(out->min, vf_if_then_else(m, b.nearest, vf_set(INFINITY)));
        out->max = vf_max(out->max, vf_if_then_else(m, b.nearest, vf_set(0)));
        add_to_list(&out->leaves, &b, leaves);
        add_to_list(&out->nodes, &b, inner);
    }
}

/* Onto the stack, the nearest last: roughly, by the leading bits of their w, a positive float being in the order of its
 * bits. */
static void push_nodes(const fresh *all, node_stack *s)
{
    const fresh_list *f = &all->nodes;
    int32_t near[FRESH + DAFT_VL], order[FRESH + DAFT_VL]; /* near: one of ORDERS */
    float low = vf_reduce_min(all->min), high = vf_reduce_max(all->max);
    uint32_t min, max, count = 0;
    memcpy(&min, &low, sizeof min), memcpy(&max, &high, sizeof max);
    uint32_t range = max - min, shift = range < ORDERS ? 0 : 30 - (uint32_t)__builtin_clz(range);
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        vf w = vf_if_then_else(vm_from_bits(vbits_first_n((int)(f->count - i))), vf_load(&f->nearest[i]), vf_set(low));
        vi_store(&near[i], ((vi)w - vi_set((int32_t)min)) >> (int)shift);
    }
    for (int k = 0; k < ORDERS; k++)
        for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
            vbits these = vbits_from_mask(vi_eq(vi_load(&near[i]), vi_set(k))) & vbits_first_n((int)(f->count - i));
            vi_compress_store(&order[count], these, vi_iota() + vi_set((int32_t)i));
            count += (uint32_t)__builtin_popcount(these);
        }
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        vi at = vi_if_then_else(vm_from_bits(vbits_first_n((int)(f->count - i))), vi_load(&order[i]), vi_set(0));
        vi_store(&s->child[s->count + i], vi_gather_index(f->child, at));
        vi_store(&s->pixels[s->count + i], vi_gather_index(f->pixels, at));
        vf_store(&s->nearest[s->count + i], vf_gather_index(f->nearest, at));
    }
    s->count += f->count;
}

/* ---- leaves in groups ---- */

static void list_blocks(walk *w)
{
    vi slot = vi_iota() & vi_set(3), leaf = vi_iota() >> 2;
    for (uint32_t i = 0; i < w->leaf_count; i += DAFT_VL / 4) {
        const uint32_t *code = &w->leaves[i];
        vi codes = (vi)vf_table_lookup16((const float *)(const void *)code, leaf);
        uint32_t some = daft_min_u(w->leaf_count - i, DAFT_VL / 4);
        vbits lanes = vbits_first_n((int)(4 * some)) & ~vbits_from_mask(vi_lt(codes & vi_set(3), slot));
        vi_compress_store(&w->blocks[w->block_count], lanes, ((codes & vi_set(INT32_MAX)) >> 2) + slot);
        w->block_count += (uint32_t)__builtin_popcount(lanes);
    }
}

/* The leaves that wait, each step for all of them before the next: how many a step leaves is hard to predict, and steps
 * are long; a wrong guess in between would wait for their ends. */
static void draw_leaves(walk *w)
{
    list_blocks(w);
    daft_small *small = &w->queue->small;
    small->view = w->view;
    DAFT_KERNEL(daft_blocks_project)(w->job, w->view, w->blocks, w->block_count, w->queue);
    DAFT_KERNEL(daft_small_hits)(w->job, small, &w->queue->hits);
    DAFT_KERNEL(daft_hits_draw)(w->job, small, &w->queue->hits);
    w->leaf_count = w->block_count = 0;
    while (w->queue->count >= DAFT_VL) DAFT_KERNEL(daft_queue_draw)(w->job, w->queue);
}

/* Leaves that are not hidden. Their order counts for little, since many are drawn together. They are drawn once the
 * next ones are met: until then they are on their way from memory. */
static void add_leaves(walk *w, const fresh_list *f)
{
    bool far = w->view->bvh->block_count > NEAR_BLOCKS;
    if (w->leaf_count >= FEW_LEAVES) draw_leaves(w);
    for (uint32_t i = 0; i < f->count; i += DAFT_VL) {
        vbits lanes = vbits_first_n((int)(f->count - i));
        vi pixels = vi_if_then_else(vm_from_bits(lanes), vi_load(&f->pixels[i]), vi_set(0));
        lanes &= ~hidden_lanes(w->job, pixels, vf_load(&f->nearest[i]), lanes);
        vi_compress_store(&w->leaves[w->leaf_count], lanes, vi_load(&f->child[i]));
        for (uint32_t more = (uint32_t)__builtin_popcount(lanes); more; more--, w->leaf_count++)
            if (far) prefetch(w->view->bvh, w->leaves[w->leaf_count]);
        if (w->leaf_count >= DAFT_LEAVES) draw_leaves(w);
    }
}

/* Takes up to GROUP nodes off the stack and leaves those that are hidden. Gives how many are left. */
static uint32_t take_group(walk *w, node_stack *s, uint32_t group[GROUP + DAFT_VL])
{
    uint32_t some = s->count > CROWDED ? 1 : daft_min_u(s->count, GROUP), count = 0;
    s->count -= some;
    for (uint32_t i = 0; i < some; i += DAFT_VL) {
        vbits lanes = vbits_first_n((int)(some - i));
        vi pixels = vi_if_then_else(vm_from_bits(lanes), vi_load(&s->pixels[s->count + i]), vi_set(0));
        lanes &= ~hidden_lanes(w->job, pixels, vf_load(&s->nearest[s->count + i]), lanes);
        vi_compress_store(&group[count], lanes, vi_load(&s->child[s->count + i]));
        count += (uint32_t)__builtin_popcount(lanes);
    }
    return count;
}

static void draw_grouped(walk *w)
{
    node_stack queue;
    fresh f;
    uint32_t group[GROUP + DAFT_VL] = {0};
    queue.count = 0;
    for (uint32_t count = 1; count || queue.count; count = take_group(w, &queue, group)) {
        f.leaves.count = f.nodes.count = 0, f.min = vf_set(INFINITY), f.max = vf_set(0);
        for (uint32_t i = 0; i < count; i += DAFT_EIGHTS) add_children(w, &group[i], count - i, &f);
        w->job->counters->nodes += count;
        if (w->view->bvh->block_count > NEAR_BLOCKS) prefetch_all(w->view->bvh, &f.nodes);
        add_leaves(w, &f.leaves);
        push_nodes(&f, &queue);
    }
    draw_leaves(w);
}

void DAFT_KERNEL(daft_mesh_draw)(daft_tile_job *job, const daft_view_instance *view, daft_queue *queue)
{
    walk w;
    walk_begin(&w, job, view, queue);
    if (view->dense)
        draw_grouped(&w);
    else
        draw_singly(&w);
}

bool DAFT_KERNEL(daft_pixels_hidden)(daft_tile_job *job, int x0, int x1, int y0, int y1, float nearest)
{
    return hidden(job, (uint32_t)(x0 | x1 << 8 | y0 << 16) | (uint32_t)y1 << 24, nearest);
}
