/* The points of a tile against one light: the order of work. Lanes are points where they are measured (step 2), and the
 * eight boxes of a node where trees are walked; the tests of triangles are in the other kernels of this room.
 *
 *   1. The box around all shadow rays goes down the tree over instances. Mostly nothing is there.
 *   2. The points that face the light are measured in view space: their extent in the light's picture.
 *   3. The tree over instances is walked with that extent. Where it meets few instances, their bounds say which
 *      points' rays meet them, and only these points are kept. Where it meets many, all points are kept, and step 5
 *      marks those behind an instance's bounds.
 *   4. Points go into blocks of 16 (blocks_kernel.c). The blocks' boxes in the picture are the grid that occluders are
 *      looked up in: fine where the points are dense, coarse where they are not, wherever the light stands.
 *   5. Each instance is walked down to the triangles before a block (mesh_kernel.c), or met as a sphere
 *      (sphere_kernel.c).
 *
 * Where no frustum holds the tile's points, because the light is among them, they are divided among the six faces of a
 * cube around it, and each face is a pencil. */
#include "raster/samples/samples.h"

#define TINY 1e-36f

enum {
    FEW_OCCLUDERS = 8, /* each is asked which points are under it, before blocks are made */
    FEW_LOOKS = 64     /* nodes and instances are looked at; then the occluders count as many */
};

/* To sort the points of a large patch takes as long as some tests of it. Among many instances it would be met by too
 * many. */
#define STRAY_OF_FEW  6.0f
#define STRAY_OF_MANY 2.0f

/* A tile's points and one light. */
typedef struct cast {
    const daft_samples *samples;
    const daft_apex *light;
    const daft_tlas *tlas;
    uint32_t flag, only;   /* of the occluders; the only one, or DAFT_NOTHING */
    const uint32_t *asked; /* bits of the points */
    light_view view;
    picture_map frame_map; /* frame space to view space */
    daft_vec3 low, high;   /* of the points, in frame space */
    bool inverses_known;
    uint32_t sole; /* the instance that all the points lie on, on the side that faces the light; or DAFT_NOTHING */
    uint32_t occluder_count; /* beyond DAFT_MAX_OCCLUDERS: more than are remembered */
    struct {
        uint32_t number;
        picture_box box;
    } occluder[DAFT_MAX_OCCLUDERS];
    uint32_t under[DAFT_SAMPLES_WORDS];
    float inverse[3][DAFT_SAMPLES_ROOM]; /* one over the rays' directions */
    uint32_t own[DAFT_SAMPLES_ROOM];
} cast;

DAFT_INLINE vbits bits_at(const uint32_t *bits, uint32_t i) { return bits[i / 32] >> (i % 32) & DAFT_ALL_LANES; }

DAFT_INLINE vf3 load3(const daft_points3 *a, uint32_t i)
{
    return (vf3){vf_load(&a->x[i]), vf_load(&a->y[i]), vf_load(&a->z[i])};
}

DAFT_INLINE vf3 minus(vf3 a, daft_vec3 b) { return (vf3){a.x - vf_set(b.x), a.y - vf_set(b.y), a.z - vf_set(b.z)}; }

/* ---- view space ---- */

static void set_axes(daft_pencil *view, daft_vec3 z)
{
    daft_vec3 min = fabsf(z.y) < 0.7f ? daft_v3(0, 1, 0) : daft_v3(1, 0, 0);
    view->right = daft_normalize(daft_cross(z, min)), view->up = daft_cross(view->right, z), view->forward = z;
}

/* DAFT_VL asked points from i on; in place of the others, `stand_in`, which is one of the asked. */
DAFT_INLINE vf3 asked_points(const daft_samples *b, vbits in, uint32_t i, daft_vec3 stand_in)
{
    vm used = vm_from_bits(in);
    vf3 p = load3(&b->origin, i);
    return (vf3){vf_if_then_else(used, p.x, vf_set(stand_in.x)), vf_if_then_else(used, p.y, vf_set(stand_in.y)),
                 vf_if_then_else(used, p.z, vf_set(stand_in.z))};
}

/* The first point whose bit is set: there is one. */
static uint32_t first_of(const uint32_t *bits)
{
    uint32_t word = 0;
    while (bits[word] == 0) word++;
    return word * 32 + (uint32_t)__builtin_ctz(bits[word]);
}

static daft_vec3 first_point(const daft_samples *b, const uint32_t *bits)
{
    uint32_t i = first_of(bits);
    return daft_v3(b->origin.x[i], b->origin.y[i], b->origin.z[i]);
}

static float widen(float low, float high)
{
    return (high - low) * 1e-5f + (fabsf(low) + fabsf(high)) * 0x1p-20f + TINY;
}

/* The extent of the points. False: some lie beside or behind the light, and no picture plane holds them all. */
static bool measure(light_view *l, const daft_samples *b, const uint32_t *bits)
{
    const vf inf = vf_set(INFINITY);
    const daft_vec3 first = first_point(b, bits);
    vf lu = inf, lv = inf, ld = inf, hu = -inf, hv = -inf, hd = -inf, ax = vf_set(0), ay = ax;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vbits in = bits_at(bits, i);
        if (!in) continue;
        vf3 p = to_view_space(&l->pencil, asked_points(b, in, i, first));
        const picture_place seen = picture_of(l, p);
        lu = vf_min(seen.u, lu), hu = vf_max(seen.u, hu), lv = vf_min(seen.v, lv), hv = vf_max(seen.v, hv);
        ld = vf_min(p.z, ld), hd = vf_max(p.z, hd);
        ax = vf_max(vf_abs(p.x), ax), ay = vf_max(vf_abs(p.y), ay);
    }
    l->low_u = vf_reduce_min(lu), l->high_u = vf_reduce_max(hu), l->low_v = vf_reduce_min(lv),
    l->high_v = vf_reduce_max(hv);
    l->near = vf_reduce_min(ld), l->far = vf_reduce_max(hd), l->max_x = vf_reduce_max(ax), l->max_y = vf_reduce_max(ay);
    l->max_z = l->pencil.parallel ? 1 : fmaxf(fabsf(l->near + l->pencil.away), fabsf(l->far + l->pencil.away));
    l->slack_u = widen(l->low_u, l->high_u), l->slack_v = widen(l->low_v, l->high_v);
    l->size = l->max_x + l->max_y + fmaxf(fabsf(l->near), fabsf(l->far));
    if (l->pencil.parallel) return true;
    float near = l->near + l->pencil.away, off = l->size / near * 0x1p-21f; /* coordinates are off by a few 2^-24 of the
                                                                               largest */
    l->slack_u += off, l->slack_v += off;
    return near > 0 && fmaxf(l->max_x, l->max_y) < 8 * near;
}

/* ---- which points lie under something's bounds ---- */

DAFT_INLINE vf3 direction_to(const daft_apex *light, vf3 p)
{
    vf3 to = {vf_set(light->at.x), vf_set(light->at.y), vf_set(light->at.z)};
    return light->infinite ? to : (vf3){to.x - p.x, to.y - p.y, to.z - p.z};
}

static void know_inverses(cast *c)
{
    const daft_samples *b = c->samples;
    const vf one = vf_set(1);
    if (c->inverses_known) return;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vf3 d = direction_to(c->light, load3(&b->origin, i));
        vf_store(&c->inverse[0][i], one / d.x), vf_store(&c->inverse[1][i], one / d.y),
            vf_store(&c->inverse[2][i], one / d.z);
    }
    c->inverses_known = true;
}

static void set_extent(cast *c, daft_vec3 low, daft_vec3 high)
{
    c->low = low, c->high = high;
    daft_vec3 max = daft_max3(daft_neg(c->low), c->high);
    c->view.reach = fabsf(max.x) + fabsf(max.y) + fabsf(max.z);
}

/* The points' extent; which triangles cannot shadow the points that lie on them, and whether all points lie on one
 * instance's. */
static void measure_points(cast *c)
{
    const daft_samples *b = c->samples;
    uint32_t first = first_of(c->asked);
    vbits apart = 0;
    const daft_vec3 stand_in = first_point(b, c->asked);
    const vi none = vi_set((int32_t)DAFT_NO_TRIANGLE), one = vi_set((int32_t)b->instance[first]);
    vf3 low = {vf_set(stand_in.x), vf_set(stand_in.y), vf_set(stand_in.z)}, high = low;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vbits in = bits_at(c->asked, i);
        vi_store(&c->own[i], none);
        if (!in) continue;
        vm faces = vf_lt(vf_set(0), vf3_dot(load3(&b->outward, i), direction_to(c->light, load3(&b->origin, i))));
        vi own = vi_if_then_else(faces, vi_load(&b->triangle[i]), none);
        vi_store(&c->own[i], own);
        apart |= in & ~(vbits_from_mask(vi_eq(vi_load(&b->instance[i]), one)) & ~vbits_from_mask(vi_eq(own, none)));
        vf3 p = asked_points(b, in, i, stand_in);
        low.x = vf_min(p.x, low.x), high.x = vf_max(p.x, high.x);
        low.y = vf_min(p.y, low.y), high.y = vf_max(p.y, high.y);
        low.z = vf_min(p.z, low.z), high.z = vf_max(p.z, high.z);
    }
    c->sole = apart ? DAFT_NOTHING : b->instance[first];
    set_extent(c, daft_v3(vf_reduce_min(low.x), vf_reduce_min(low.y), vf_reduce_min(low.z)),
               daft_v3(vf_reduce_max(high.x), vf_reduce_max(high.y), vf_reduce_max(high.z)));
}

typedef struct bound {
    daft_vec3 low, high;
} bound;

/* The bound is grown by 2^-20 of what there is in coordinates: over the roundings of rays, planes and distances, each a
 * few 2^-24 of them. */
static bound grown_bound(const cast *c, const daft_instance *s)
{
    daft_vec3 h = daft_max3(daft_neg(s->low), s->high);
    float pad = (c->view.reach + fabsf(h.x) + fabsf(h.y) + fabsf(h.z)) * 0x1p-20f;
    daft_vec3 by = daft_v3(pad, pad, pad);
    return (bound){daft_sub(s->low, by), daft_add(s->high, by)};
}

/* Whether rays from between the points' corners have left the bound on one axis before they come to it on another.
 * Along an axis they go between `slow` and `fast` of their length, towards the light. */
static bool rays_apart(const cast *c, const bound *s)
{
    const daft_apex *light = c->light;
    const float to[3] = {light->at.x, light->at.y, light->at.z};
    float enter = 0, leave = light->infinite ? INFINITY : 1;
    for (int k = 0; k < 3; k++) {
        float low = daft_v3_at(c->low, k), high = daft_v3_at(c->high, k), before = daft_v3_at(s->low, k) - high,
              past = daft_v3_at(s->high, k) - low;
        float slow = light->infinite ? to[k] : to[k] - high, fast = light->infinite ? to[k] : to[k] - low;
        if (fast < 0) { /* the same seen from the other side */
            float other = -slow;
            slow = -fast, fast = other;
            before = low - daft_v3_at(s->high, k), past = high - daft_v3_at(s->low, k);
        }
        if (!(slow > 0)) continue;
        enter = fmaxf(enter, before / fast), leave = fminf(leave, past / slow);
    }
    return enter * (1 - 1e-5f) > leave * (1 + 1e-5f);
}

/* Whether all the rays stay clear of the bound, as far as the box around them tells. */
static bool rays_clear(const cast *c, const bound *s)
{
    const daft_apex *light = c->light;
    const float to[3] = {light->at.x, light->at.y, light->at.z}, low[3] = {c->low.x, c->low.y, c->low.z},
                high[3] = {c->high.x, c->high.y, c->high.z};
    for (int k = 0; k < 3; k++) {
        float from = light->infinite ? (to[k] < 0 ? -INFINITY : low[k]) : fminf(low[k], to[k]);
        float end = light->infinite ? (to[k] > 0 ? INFINITY : high[k]) : fmaxf(high[k], to[k]);
        if (daft_v3_at(s->high, k) < from || daft_v3_at(s->low, k) > end) return true;
    }
    return rays_apart(c, s);
}

/* Whether the rays may meet the instance in its bound: neither a convex instance nor a flat one shadows its own points.
 */
static bool may_shadow(const cast *c, uint32_t number, bound *box)
{
    const daft_instance *s = &c->tlas->instances[number];
    if (number == c->sole && (s->flags & DAFT_INSTANCE_CONVEX || is_flat(s))) return false;
    *box = grown_bound(c, s);
    return !rays_clear(c, box);
}

static bool holds_points(const cast *c, const bound *s)
{
    daft_vec3 low = daft_min3(s->low, c->low), high = daft_max3(s->high, c->high);
    return low.x == s->low.x && low.y == s->low.y && low.z == s->low.z && high.x == s->high.x && high.y == s->high.y &&
           high.z == s->high.z;
}

typedef struct slab {
    vf near, far;
} slab;

/* A product that is NaN, of a plane through the point and a direction along it, says nothing. */
DAFT_INLINE void slab_axis(slab *s, vf low, vf high, vf p, vf inverse)
{
    vf a = (low - p) * inverse, b = (high - p) * inverse;
    s->near = vf_max(vf_min(a, b), s->near);
    s->far = vf_min(vf_max(a, b), s->far);
}

/* The bits of the DAFT_VL points from i on whose rays meet the bound. */
DAFT_INLINE vbits rays_meet(const cast *c, const bound *s, uint32_t i)
{
    const daft_points3 *p = &c->samples->origin;
    slab t = {vf_set(0), vf_set(c->light->infinite ? INFINITY : 1.00001f)};
    slab_axis(&t, vf_set(s->low.x), vf_set(s->high.x), vf_load(&p->x[i]), vf_load(&c->inverse[0][i]));
    slab_axis(&t, vf_set(s->low.y), vf_set(s->high.y), vf_load(&p->y[i]), vf_load(&c->inverse[1][i]));
    slab_axis(&t, vf_set(s->low.z), vf_set(s->high.z), vf_load(&p->z[i]), vf_load(&c->inverse[2][i]));
    return vbits_from_mask(vf_le(t.near, t.far));
}

/* Marks the points whose ray to the light meets the bound; gives whether there is one. Neither a convex instance nor a
 * flat one shadows its own points. */
static bool mark_under(cast *c, const bound *box, const daft_instance *s, uint32_t number)
{
    const daft_samples *b = c->samples;
    bool any = false, convex = s->flags & DAFT_INSTANCE_CONVEX, flat = is_flat(s), all = holds_points(c, box);
    if (!all) know_inverses(c);
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vbits in = bits_at(c->asked, i);
        if (!in) continue;
        if (!all) in &= rays_meet(c, box, i);
        if (convex || flat) {
            vbits on = vbits_from_mask(vi_eq(vi_load(&b->instance[i]), vi_set((int32_t)number)));
            in &= ~(convex ? on : on & ~vbits_from_mask(vi_eq(vi_load(&c->own[i]), vi_set((int32_t)DAFT_NO_TRIANGLE))));
        }
        c->under[i / 32] |= in << (i % 32);
        any |= in != 0;
    }
    return any;
}

/* Remembers the instance, one of a node's children, if points may lie under it. */
static void remember(cast *c, uint32_t number, const node_boxes *boxes, int i)
{
    bound box;
    if (!may_shadow(c, number, &box)) return;
    if (c->occluder_count < DAFT_MAX_OCCLUDERS) {
        c->occluder[c->occluder_count].number = number;
        c->occluder[c->occluder_count].box = node_child(boxes, i);
    }
    c->occluder_count++;
}

/* Marks the points under the instances that are remembered, and forgets those that have none. */
static void mark_occluders(cast *c)
{
    uint32_t kept = 0;
    memset(c->under, 0, sizeof c->under);
    for (uint32_t i = 0; i < c->occluder_count; i++) {
        const daft_instance *s = &c->tlas->instances[c->occluder[i].number];
        const bound box = grown_bound(c, s);
        if (mark_under(c, &box, s, c->occluder[i].number)) c->occluder[kept++] = c->occluder[i];
    }
    c->occluder_count = kept;
}

/* The one instance that is asked for, as the only child of a node. */
static void find_one(cast *c)
{
    const daft_instance *s = &c->tlas->instances[c->only];
    const float low[3] = {s->low.x, s->low.y, s->low.z}, high[3] = {s->high.x, s->high.y, s->high.z};
    daft_node node;
    node_boxes boxes;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < DAFT_WIDTH; i++)
            node.bounds[k][i] = i ? INFINITY : low[k], node.bounds[3 + k][i] = i ? -INFINITY : high[k];
    if (DAFT_KERNEL(daft_node_project)(&c->view, &c->frame_map, &node, &boxes) & 1) remember(c, c->only, &boxes, 0);
}

/* Remembers the instances that points lie under, and marks these points. False: there may be more than `most` such
 * instances, or more than `looks` had to be looked at, and it is not known which points are under something. */
static bool find_occluders(cast *c, uint32_t max, uint32_t looks)
{
    uint32_t stack[DAFT_STACK], looked = 0;
    int top = 0;
    c->occluder_count = 0;
    if (c->only != DAFT_NOTHING)
        find_one(c);
    else
        stack[top++] = 0;
    while (top > 0 && c->occluder_count <= max) {
        if (looked++ > looks) return false;
        node_boxes boxes;
        const daft_node *node = &c->tlas->nodes.items[stack[--top]];
        for (uint32_t in = DAFT_KERNEL(daft_node_project)(&c->view, &c->frame_map, node, &boxes); in; in &= in - 1) {
            int i = __builtin_ctz(in);
            uint32_t child = node->child[i], number = child & ~DAFT_CHILD_LEAF;
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF))
                stack[top++] = child;
            else if (looked++, c->tlas->instances[number].flags & c->flag)
                remember(c, number, &boxes, i);
        }
    }
    if (c->occluder_count > max) return false;
    mark_occluders(c);
    return true;
}

/* ---- the tile ---- */

static block_set all_blocks(const shadow_points *p)
{
    block_set all = {{0}};
    for (uint32_t b = 0; b < p->count; b++) all.bits[b / 64] |= (uint64_t)(p->used[b] != 0) << (b % 64);
    return all;
}

static occluder occluder_of(const cast *c, uint32_t number, shadow_points *points)
{
    const daft_instance *s = &c->tlas->instances[number];
    return (occluder){.view = &c->view,
                      .light = c->light,
                      .samples = c->samples,
                      .instance = s,
                      .number = number,
                      .convex = s->flags & DAFT_INSTANCE_CONVEX,
                      .flat = is_flat(s),
                      .points = points};
}

static void cast_one(const occluder *one, const block_set *behind)
{
    if (one->instance->mesh)
        DAFT_KERNEL(daft_mesh_shadow)(one, behind);
    else
        DAFT_KERNEL(daft_sphere_occluder_shadow)(one, behind);
}

static void cast_remembered(const cast *c, shadow_points *points)
{
    const block_set all = all_blocks(points);
    block_set behind;
    for (uint32_t i = 0; i < c->occluder_count && points->live; i++) {
        const occluder one = occluder_of(c, c->occluder[i].number, points);
        if (blocks_narrow(&c->occluder[i].box, points, &all, &behind)) cast_one(&one, &behind);
    }
}

/* Whether the box is behind all of the picture: then it says little about a instance that is large or slants. */
static bool covers(const picture_box *box, const light_view *l)
{
    return box->low_u <= l->low_u && box->high_u >= l->high_u && box->low_v <= l->low_v && box->high_v >= l->high_v;
}

/* Those of a block's points whose bits are set in `bits`, by their place in the batch. */
static uint32_t bits_of_block(const shadow_points *p, uint32_t b, uint32_t in, const uint32_t *bits)
{
    for (uint32_t left = in; left; left &= left - 1) {
        uint32_t at = p->source[b * SHADOW_BLOCK + (uint32_t)__builtin_ctz(left)];
        if (!(bits[at / 32] >> (at % 32) & 1)) in &= ~(left & -left);
    }
    return in;
}

/* Marks the points of the blocks that lie behind the sphere's box, but for its own where it cannot shadow them. Takes
 * the blocks out of `behind` that have none; false: none has. */
static bool mark_behind(cast *c, const occluder *one, const picture_box *box, block_set *behind)
{
    shadow_points *p = one->points;
    bool slow = covers(box, &c->view);
    if (slow) {
        bound around;
        memset(c->under, 0, sizeof c->under);
        if (!may_shadow(c, one->number, &around) || !mark_under(c, &around, one->instance, one->number)) return false;
    }
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left), in = points_behind(box, p, b);
            for (uint32_t k = 0; one->convex && k < SHADOW_BLOCK; k += DAFT_VL)
                in &= ~(lie_on(one, DAFT_NO_TRIANGLE, b * SHADOW_BLOCK + k) << k);
            if (slow) in = bits_of_block(p, b, in, c->under);
            p->under[b] |= in;
            if (!in) behind->bits[word] &= ~(left & -left);
        }
    return !set_is_empty(behind);
}

typedef struct entry {
    uint32_t node;
    block_set behind;
} entry;

/* Instances with the TLAS's boxes of them, and the blocks behind these. */
enum { MET = 16, MESHES = 256, PARTS = 2048 };
typedef struct met_instances {
    uint32_t count, number[MET + DAFT_WIDTH];
    picture_box box[MET + DAFT_WIDTH];
    block_set behind[MET + DAFT_WIDTH];
} met_instances;

/* Meshes, and the points that their triangles may hide, block by block. */
typedef struct mesh_queue {
    uint32_t count, number[MESHES], first[MESHES + 1];
    block_points parts[PARTS];
} mesh_queue;

/* A worker's: nothing of it outlives a call. */
typedef struct light_scratch {
    cast cast;
    shadow_points points;
    block_scratch blocks;
    met_instances met;
    mesh_queue mesh_queue;
} light_scratch;

static void cast_queued(const cast *c, mesh_queue *list, shadow_points *points)
{
    for (uint32_t i = 0; i < list->count && points->live; i++) {
        const occluder one = occluder_of(c, list->number[i], points);
        block_points *some = &list->parts[list->first[i]];
        uint32_t kept = 0;
        for (uint32_t k = 0; k < list->first[i + 1] - list->first[i]; k++) {
            some[kept] = (block_points){some[k].block, some[k].points & lit_points(points, some[k].block)};
            kept += some[kept].points != 0;
        }
        if (kept) DAFT_KERNEL(daft_mesh_shadow_of)(&one, some, kept);
    }
    list->count = 0;
}

static void meet_mesh(const cast *c, const occluder *one, const picture_box *box, const block_set *behind,
                      mesh_queue *list)
{
    shadow_points *p = one->points;
    uint32_t first = list->first[list->count];
    block_points *some = &list->parts[first];
    uint32_t count = DAFT_KERNEL(daft_mesh_candidates)(one, box, behind, some);
    if (!count) return;
    list->number[list->count] = one->number;
    list->first[++list->count] = first + count;
    if (list->count == MESHES || first + count + SHADOW_BLOCKS > PARTS) cast_queued(c, list, p);
}

static void cast_met(cast *c, met_instances *met, mesh_queue *list, shadow_points *points)
{
    for (uint32_t i = 0; i < met->count && points->live; i++) {
        const occluder one = occluder_of(c, met->number[i], points);
        if (!(one.instance->flags & c->flag)) continue;
        if (one.instance->mesh) {
            meet_mesh(c, &one, &met->box[i], &met->behind[i], list);
            continue;
        }
        DAFT_KERNEL(daft_sphere_occluder_box)(&c->view, one.instance, &met->box[i]);
        if (mark_behind(c, &one, &met->box[i], &met->behind[i]))
            DAFT_KERNEL(daft_sphere_occluder_shadow)(&one, &met->behind[i]);
    }
    met->count = 0;
}

/* What is put aside comes from far: it is on its way before it is needed. */
DAFT_INLINE void fetch_lines(const void *from, size_t size)
{
    for (size_t line = 0; line < size; line += 64) __builtin_prefetch((const char *)from + line);
}

/* Among many instances: walks their tree with all the blocks, and marks the points under each. */
static void cast_all(cast *c, light_scratch *scratch)
{
    entry stack[DAFT_STACK];
    shadow_points *points = &scratch->points;
    met_instances *met = &scratch->met;
    mesh_queue *list = &scratch->mesh_queue;
    int top = 0;
    met->count = list->count = list->first[0] = 0;
    stack[top++] = (entry){0, all_blocks(points)};
    while (top > 0 && points->live) {
        node_boxes boxes;
        block_set next[DAFT_WIDTH];
        const entry at = stack[--top];
        const daft_node *node = &c->tlas->nodes.items[at.node];
        uint32_t in = DAFT_KERNEL(daft_node_project)(&c->view, &c->frame_map, node, &boxes);
        if (in) in = children_narrow(&boxes, in, points, &at.behind, next);
        for (; in; in &= in - 1) {
            int i = __builtin_ctz(in);
            uint32_t child = node->child[i], number = child & ~DAFT_CHILD_LEAF;
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF)) {
                fetch_lines(&c->tlas->nodes.items[child], sizeof *node);
                stack[top++] = (entry){child, next[i]};
                continue;
            }
            const picture_box box = node_child(&boxes, i);
            fetch_lines(&c->tlas->instances[number], sizeof *c->tlas->instances);
            met->number[met->count] = number, met->box[met->count] = box, met->behind[met->count++] = next[i];
        }
        if (met->count >= MET) cast_met(c, met, list, points);
    }
    cast_met(c, met, list, points);
    cast_queued(c, list, points);
}

/* The asked points form one pencil, whose light's axes and extent are set. Gives the number of points under something.
 */
static uint32_t cast_pencil(light_scratch *scratch, uint32_t *bits)
{
    cast *c = &scratch->cast;
    shadow_points *points = &scratch->points;
    uint32_t count = 0;
    c->frame_map = view_map_of(&c->view, c->tlas->nodes.items);
    bool few = find_occluders(c, FEW_OCCLUDERS, FEW_LOOKS);
    if (few) {
        for (uint32_t word = 0; word < DAFT_SAMPLES_WORDS; word++)
            count += (uint32_t)__builtin_popcount(c->under[word]);
    }
    if (few && c->occluder_count == 0) return count;
    DAFT_KERNEL(daft_shadow_blocks)
    (&c->view, c->samples, c->own, few ? c->under : c->asked, few ? STRAY_OF_FEW : STRAY_OF_MANY, &scratch->blocks,
     points);
    if (few) {
        cast_remembered(c, points);
    } else {
        cast_all(c, scratch);
        for (uint32_t b = 0; b < points->count; b++) count += (uint32_t)__builtin_popcount(points->under[b]);
    }
    DAFT_KERNEL(daft_shadow_dark)(points, bits);
    return count;
}

/* The points on a face of the cube around the light: those whose largest difference is on this axis, with this sign.
 * Points at the light itself are on none. */
static bool take_face(const cast *c, const uint32_t *asked, int face, uint32_t *out)
{
    const daft_samples *b = c->samples;
    const vf zero = vf_set(0);
    uint32_t any = 0;
    memset(out, 0, DAFT_SAMPLES_WORDS * sizeof out[0]);
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vbits in = bits_at(asked, i);
        if (!in) continue;
        vf3 d = minus(load3(&b->origin, i), c->view.pencil.origin);
        vf ax = vf_abs(d.x), ay = vf_abs(d.y), az = vf_abs(d.z);
        vm on_x = vm_and(vf_le(ay, ax), vf_le(az, ax)), on_y = vm_and(vm_not(on_x), vf_le(az, ay));
        vm on_z = vm_not(vm_or(on_x, on_y));
        vf along = face / 2 == 0 ? d.x : face / 2 == 1 ? d.y : d.z;
        vm on = face / 2 == 0 ? on_x : face / 2 == 1 ? on_y : on_z;
        in &= vbits_from_mask(vm_and(on, face % 2 ? vf_lt(along, zero) : vf_lt(zero, along)));
        out[i / 32] |= in << (i % 32);
        any |= in;
    }
    return any != 0;
}

static uint32_t cast_faces(light_scratch *scratch, uint32_t *bits)
{
    cast *c = &scratch->cast;
    static const daft_vec3 AXIS[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    uint32_t asked[DAFT_SAMPLES_WORDS], on_face[DAFT_SAMPLES_WORDS], count = 0;
    memcpy(asked, bits, sizeof asked);
    c->view.pencil.origin = c->light->at, c->view.pencil.away = 0, c->view.pencil.parallel = false;
    for (int face = 0; face < 6; face++) {
        if (!take_face(c, asked, face, on_face)) continue;
        set_axes(&c->view.pencil, AXIS[face]);
        measure(&c->view, c->samples, on_face);
        c->asked = on_face;
        count += cast_pencil(scratch, bits);
    }
    return count;
}

/* Bits of the children that the box around all the rays meets. */
static uint32_t children_met(const cast *c, const daft_node *node)
{
    const daft_apex *light = c->light;
    const float to[3] = {light->at.x, light->at.y, light->at.z}, low[3] = {c->low.x, c->low.y, c->low.z},
                high[3] = {c->high.x, c->high.y, c->high.z};
    v8 size = v8_set(c->view.reach);
    uint32_t met = 0xff;
    for (int k = 0; k < 3; k++) size = size + v8_max(-v8_load(node->bounds[k]), v8_load(node->bounds[3 + k]));
    size = size * v8_set(0x1p-19f);
    for (int k = 0; k < 3; k++) {
        float from = light->infinite ? (to[k] < 0 ? -INFINITY : low[k]) : fminf(low[k], to[k]);
        float end = light->infinite ? (to[k] > 0 ? INFINITY : high[k]) : fmaxf(high[k], to[k]);
        met &= v8_le_bits(v8_set(from), v8_load(node->bounds[3 + k]) + size) &
               v8_le_bits(v8_load(node->bounds[k]) - size, v8_set(end));
    }
    return met;
}

/* Whether nothing can stand between the points and the light, as far as is known before the light's picture is. */
static bool all_clear(const cast *c)
{
    bound box;
    uint32_t stack[DAFT_STACK], looked = 0;
    int top = 0;
    if (c->only != DAFT_NOTHING) return !may_shadow(c, c->only, &box);
    stack[top++] = 0;
    while (top > 0) {
        if (looked++ > FEW_LOOKS) return false;
        const daft_node *node = &c->tlas->nodes.items[stack[--top]];
        for (uint32_t in = children_met(c, node); in; in &= in - 1) {
            uint32_t child = node->child[__builtin_ctz(in)], number = child & ~DAFT_CHILD_LEAF;
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF))
                stack[top++] = child;
            else if (looked++, c->tlas->instances[number].flags & c->flag && may_shadow(c, number, &box))
                return false;
        }
    }
    return true;
}

/* False: nothing can hide the points. */
static bool cast_begin(cast *c, const daft_samples *points, const daft_apex *light, const daft_tlas *tlas,
                       const uint32_t *bits)
{
    c->samples = points, c->light = light, c->tlas = tlas, c->asked = bits, c->inverses_known = false;
    uint32_t any = 0;
    for (uint32_t word = 0; word < DAFT_SAMPLES_WORDS; word++) any |= bits[word];
    if (tlas->nodes.count == 0 || !any) return false;
    measure_points(c);
    return !all_clear(c);
}

/* Looks at the points from the light. False: no picture holds them all. */
static bool cast_setup(cast *c)
{
    const daft_apex *light = c->light;
    daft_vec3 middle = daft_scale(daft_add(c->low, c->high), 0.5f), axis = daft_sub(middle, light->at);
    c->view.pencil.parallel = light->infinite;
    c->view.pencil.origin = middle;
    c->view.pencil.away = light->infinite ? 0 : daft_length(axis);
    set_axes(&c->view.pencil, light->infinite ? daft_neg(light->at) : daft_normalize(axis));
    return measure(&c->view, c->samples, c->asked);
}

static uint32_t shadows(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas, uint32_t instance,
                        uint32_t bits[DAFT_SAMPLES_WORDS], void *memory)
{
    light_scratch *scratch = memory;
    cast *c = &scratch->cast;
    c->flag = DAFT_INSTANCE_CASTS_SHADOW, c->only = instance;
    if (!cast_begin(c, points, light, tlas, bits)) return 0;
    return cast_setup(c) ? cast_pencil(scratch, bits) : cast_faces(scratch, bits);
}

static uint32_t tints(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas,
                      const uint32_t bits[DAFT_SAMPLES_WORDS], uint32_t out[DAFT_MAX_OCCLUDERS], void *memory)
{
    cast *c = &((light_scratch *)memory)->cast;
    c->flag = DAFT_INSTANCE_TINTS_SHADOW, c->only = DAFT_NOTHING;
    if (!cast_begin(c, points, light, tlas, bits)) return 0;
    if (!cast_setup(c)) return UINT32_MAX;
    c->frame_map = view_map_of(&c->view, c->tlas->nodes.items);
    if (!find_occluders(c, DAFT_MAX_OCCLUDERS, UINT32_MAX)) return UINT32_MAX;
    for (uint32_t i = 0; i < c->occluder_count; i++) out[i] = c->occluder[i].number;
    return c->occluder_count;
}

const daft_sample_kernels DAFT_KERNEL(daft_samples) = {
    .scratch_size = (sizeof(light_scratch) + 63) / 64 * 64, .shadows = shadows, .tints = tints};
