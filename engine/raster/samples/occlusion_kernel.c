/* The points of a tile against one light: the order of work. Steps 1 to 3 are in cast_kernel.c, the tests of triangles
 * in the other kernels of this room; where lanes occur here, they are points.
 *
 *   1. The box around all shadow rays goes down the tree over instances. Mostly nothing is there.
 *   2. The points that face the light are measured in view space: their extent in the light's picture.
 *   3. The tree over instances is walked with that extent, and what it meets is looked at with all points at once
 *      (shaft_kernel.c): mostly nothing stands between, or some triangle hides all. Where few instances are left, their
 *      bounds say which points' rays meet them, and only these points are kept. Where many are, all points are kept,
 *      and step 5 marks those behind an instance's bounds.
 *   4. Points go into blocks of 16 (blocks_kernel.c). The blocks' boxes in the picture are the grid that occluders are
 *      looked up in: fine where the points are dense, coarse where they are not, wherever the light stands.
 *   5. Each instance is walked down to the triangles before a block (mesh_kernel.c), or met as a sphere
 *      (sphere_kernel.c).
 *
 * Where no frustum holds the tile's points, because the light is among them, they are divided among the six faces of a
 * cube around it, and each face is a pencil. */
#include "raster/samples/cast.h"

enum { FEW_OCCLUDERS = 8 }; /* each is asked which points are under it, before blocks are made */

/* To sort the points of a large square takes as long as some tests of it. Among many instances it would be met by too
 * many. */
#define STRAY_OF_FEW  6.0f
#define STRAY_OF_MANY 2.0f

/* ---- the tile ---- */

static block_set all_blocks(const shadow_points *p)
{
    block_set all = {{0}};
    for (uint32_t b = 0; b < p->count; b++) all.bits[b / 64] |= (uint64_t)(p->used[b] != 0) << (b % 64);
    return all;
}

/* Of spheres with alpha nothing is known before rays meet them. */
static void leave_blocks_open(const occluder *one, const block_set *behind)
{
    const shadow_points *p = one->points;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1) {
            const uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left);
            for (uint32_t in = lit_points(p, b); in; in &= in - 1)
                leave_open(one, p->source[b * SHADOW_BLOCK + (uint32_t)__builtin_ctz(in)]);
        }
}

static void cast_one(const occluder *one, const block_set *behind)
{
    if (one->instance->mesh)
        DAFT_KERNEL(daft_mesh_shadow)(one, behind);
    else if (one->filtered)
        leave_blocks_open(one, behind);
    else
        DAFT_KERNEL(daft_sphere_occluder_shadow)(one, behind);
}

/* Of a mesh all whose triangles that may hide points are known. */
static void cast_known(const occluder *one, const block_set *behind, const daft_block *const *blocks, uint32_t count)
{
    DAFT_KERNEL(daft_mesh_shadow_by)(one, behind, blocks, count);
}

static void cast_remembered(const cast *c, shadow_points *points)
{
    const block_set all = all_blocks(points);
    block_set behind;
    for (uint32_t i = 0; i < c->occluder_count && points->live; i++) {
        const occluder one = occluder_of(c, c->occluder[i].number, points);
        const uint32_t blocks = c->occluder[i].blocks;
        if (!blocks_narrow(&c->occluder[i].box, points, &all, &behind)) continue;
        if (!blocks) cast_one(&one, &behind);
        if (blocks) cast_known(&one, &behind, &c->shaft_blocks[c->occluder[i].first], blocks);
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
        frame_box around;
        memset(c->under, 0, sizeof c->under);
        if (!DAFT_KERNEL(daft_cast_may_shadow)(c, one->number, &around) ||
            !DAFT_KERNEL(daft_cast_mark_under)(c, &around, one->instance, one->number))
            return false;
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
    daft_filtered filtered;
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
        if (mark_behind(c, &one, &met->box[i], &met->behind[i])) cast_one(&one, &met->behind[i]);
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

/* The points under something, by their places in the batch. */
static void add_under(const shadow_points *p, uint32_t *under)
{
    for (uint32_t b = 0; b < p->count; b++)
        for (uint32_t in = p->under[b]; in; in &= in - 1) {
            const uint32_t at = p->source[b * SHADOW_BLOCK + (uint32_t)__builtin_ctz(in)];
            under[at / 32] |= (uint32_t)1 << (at % 32);
        }
}

/* Takes away the bits of the points that the shaft's triangles hide; gives their number. */
static uint32_t darken_hidden(const cast *c, uint32_t *bits)
{
    uint32_t count = 0;
    for (uint32_t word = 0; c->hiders && word < DAFT_SAMPLES_WORDS; word++) {
        bits[word] &= ~c->hidden[word];
        count += (uint32_t)__builtin_popcount(c->hidden[word]);
    }
    return count;
}

/* The asked points form one pencil, whose light's axes and extent are set. Gives the number of points under something.
 */
static uint32_t cast_pencil(light_scratch *scratch, uint32_t *bits)
{
    cast *c = &scratch->cast;
    shadow_points *points = &scratch->points;
    uint32_t count = 0;
    c->frame_map = view_map_of(&c->view, c->tlas->nodes.items);
    bool few = DAFT_KERNEL(daft_cast_find_occluders)(c, FEW_OCCLUDERS, FEW_LOOKS);
    count = darken_hidden(c, bits);
    if (c->dark) return count;
    if (few) {
        for (uint32_t word = 0; word < DAFT_SAMPLES_WORDS; word++)
            count += (uint32_t)__builtin_popcount(c->under[word]);
        for (uint32_t word = 0; c->filtered && word < DAFT_SAMPLES_WORDS; word++)
            c->filtered->under[word] |= c->under[word];
    }
    if (few && c->occluder_count == 0) return count;
    DAFT_KERNEL(daft_shadow_blocks)
    (&c->view, c->samples, c->own, few ? c->under : c->asked, few ? STRAY_OF_FEW : STRAY_OF_MANY, &scratch->blocks,
     points);
    c->view.end = points->min_end;
    if (few) {
        cast_remembered(c, points);
    } else {
        cast_all(c, scratch);
        for (uint32_t b = 0; b < points->count; b++) count += (uint32_t)__builtin_popcount(points->under[b]);
        if (c->filtered) add_under(points, c->filtered->under);
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
        c->asked = on_face;
        DAFT_KERNEL(daft_cast_measure)(c);
        count += cast_pencil(scratch, bits);
    }
    return count;
}
/* False: nothing can hide the points. */
static bool cast_begin(cast *c, const daft_samples *points, const daft_apex *light, const daft_tlas *tlas,
                       const uint32_t *bits)
{
    c->samples = points, c->light = light, c->tlas = tlas, c->asked = bits, c->inverses_known = false;
    c->filtered = NULL, c->sifts = false;
    c->view.light = light;
    uint32_t any = 0;
    for (uint32_t word = 0; word < DAFT_SAMPLES_WORDS; word++) any |= bits[word];
    if (tlas->nodes.count == 0 || !any) return false;
    DAFT_KERNEL(daft_cast_points)(c);
    return !DAFT_KERNEL(daft_cast_clear)(c);
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
    return DAFT_KERNEL(daft_cast_measure)(c);
}

static uint32_t shadows(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas, uint32_t instance,
                        uint32_t bits[DAFT_SAMPLES_WORDS], void *memory)
{
    light_scratch *scratch = memory;
    cast *c = &scratch->cast;
    c->flag = DAFT_INSTANCE_CASTS_SHADOW, c->only = instance;
    if (!cast_begin(c, points, light, tlas, bits)) return 0;
    c->sifts = true;
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
    if (!DAFT_KERNEL(daft_cast_find_occluders)(c, DAFT_MAX_OCCLUDERS, UINT32_MAX)) return UINT32_MAX;
    for (uint32_t i = 0; i < c->occluder_count; i++) out[i] = c->occluder[i].number;
    return c->occluder_count;
}

static uint32_t filters(const daft_samples *points, const daft_apex *light, const daft_tlas *tlas,
                        uint32_t bits[DAFT_SAMPLES_WORDS], const daft_filtered **out, void *memory)
{
    light_scratch *scratch = memory;
    cast *c = &scratch->cast;
    daft_filtered *f = &scratch->filtered;
    *out = f;
    c->flag = DAFT_INSTANCE_FILTERS_SHADOW, c->only = DAFT_NOTHING;
    memset(f->under, 0, sizeof f->under), memset(f->open, 0, sizeof f->open), memset(f->count, 0, sizeof f->count);
    if (!cast_begin(c, points, light, tlas, bits)) return 0;
    c->filtered = f;
    const uint32_t count = cast_setup(c) ? cast_pencil(scratch, bits) : cast_faces(scratch, bits);
    c->filtered = NULL;
    return count;
}

const daft_sample_kernels DAFT_KERNEL(daft_samples) = {
    .scratch_size = (sizeof(light_scratch) + 63) / 64 * 64, .shadows = shadows, .tints = tints, .filters = filters};
