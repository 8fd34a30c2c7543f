/* The rays of pixels at edges: which of them are shaded, and for how many each speaks; and their light. */
#include "math/simd/ops.h"
#include "render/kernels.h"

enum {
    SCALE = DAFT_EDGE_SCALE,
    RAYS = DAFT_EDGE_RAYS,
    TRIANGLES = 6, /* that a pixel sees, above which rays go together by instances */
};
_Static_assert(RAYS == 16, "a pixel's rays are sixteen bits");

/* Of all sixteen rays, if these see the same, how many are shaded beside the pixel's first: by what that is, and by how
 * much changes. A texture is filtered over the whole pixel already; what is sent on takes longest, but beside outlines
 * changes most: where light is bent, these pixels have most of the error that is left. */
static const uint8_t SHADED[DAFT_OWN_KINDS][3] = {[DAFT_OWN_MATTE] = {4, 6, 12},
                                                  [DAFT_OWN_TEXTURED] = {0, 0, 0},
                                                  [DAFT_OWN_MIRRORS] = {4, 6, 8},
                                                  [DAFT_OWN_PASSES] = {4, 6, 8}};

/* And of a pixel beside an outline, where nothing else changes. */
static const uint8_t BESIDE[DAFT_OWN_KINDS] = {
    [DAFT_OWN_MATTE] = 2, [DAFT_OWN_TEXTURED] = 0, [DAFT_OWN_MIRRORS] = 2, [DAFT_OWN_PASSES] = 2};

/* Of each of the pixel's rays, by DAFT_EDGE_ORDER, what it sees. */
DAFT_INLINE void see_pixel(const daft_fine_tile *rays, uint32_t pixel, uint32_t id[RAYS])
{
    uint32_t own[RAYS];
    for (int i = 0; i < RAYS; i += DAFT_VL) {
        const uint32_t at = RAYS * pixel + (uint32_t)i;
        const vi triangle = vi_load(&rays->triangle[at]) & vi_set((1 << DAFT_ID_INSTANCE) - 1);
        vi_store(&own[i], vi_load(&rays->instance[at]) << DAFT_ID_INSTANCE | triangle);
    }
    for (int i = 0; i < RAYS; i += DAFT_VL)
        vf_store((float *)(void *)&id[i],
                 vf_table_lookup16((const float *)(const void *)own, vi_load(&DAFT_EDGE_ORDER[i])));
}

/* Those of the pixel's rays that see the same, by number; `id` without some lower bits. */
typedef struct group {
    uint32_t id, rays;
} group;

DAFT_INLINE uint32_t alike(const uint32_t id[RAYS], uint32_t one)
{
    uint32_t bits = 0;
    for (int i = 0; i < RAYS; i += DAFT_VL)
        bits |= (uint32_t)vbits_from_mask(vi_eq(vi_load(&id[i]), vi_set((int32_t)one))) << i;
    return bits;
}

DAFT_INLINE uint32_t group_rays(const uint32_t id[RAYS], group out[RAYS])
{
    uint32_t count = 0;
    for (uint32_t left = (1u << RAYS) - 1; left; count++) {
        const uint32_t one = id[__builtin_ctz(left)];
        out[count] = (group){one, alike(id, one)};
        left &= ~out[count].rays;
    }
    return count;
}

/* A list at work. */
typedef struct taking {
    const daft_edge_part *part;
    daft_edge_rays *out;
    uint32_t wanted; /* the pixel's place in the tile */
    int level;
    uint32_t kind; /* of the pixel's first sample */
} taking;

/* The ray at a place in the pixel. Two pixels of such a pencil are one of that which shades. */
DAFT_INLINE void shade(taking *t, uint32_t ray, float rays)
{
    const uint32_t x = ray % SCALE, y = ray / SCALE, at = RAYS * t->wanted + ray;
    const uint32_t column = SCALE * (t->wanted % DAFT_TILE) + x, row = SCALE * (t->wanted / DAFT_TILE) + y;
    const float half = 0.5f;
    daft_seen_list *list = t->out->list;
    const uint32_t i = list->count++, pixel = daft_place_in_batch(i);
    list->x[i] = half * (t->part->x + (float)column + DAFT_EDGE_TURN * daft_pencil_turned((int)y));
    list->y[i] = half * (t->part->y - (float)row + DAFT_EDGE_TURN * daft_pencil_turned((int)x));
    list->instance[i] = t->part->rays->instance[at], list->triangle[i] = t->part->rays->triangle[at];
    list->pixel[i] = pixel, t->out->wanted[pixel] = t->wanted, t->out->share[i] = rays;
}

/* Some of the group, which is of a kind: the first ones in their order, since these lie round the middle. */
DAFT_INLINE void take_group(taking *t, const group *g, uint32_t kind, bool has_own)
{
    const uint32_t count = (uint32_t)__builtin_popcount(g->rays),
                   due = (count * SHADED[kind][t->level] + RAYS / 2) / RAYS, fresh = due || has_own ? due : 1;
    const float share = (float)count / (float)(fresh + has_own);
    if (has_own) t->out->own[t->wanted] = share;
    for (uint32_t i = 0, left = g->rays; i < fresh; i++, left &= left - 1)
        shade(t, (uint32_t)DAFT_EDGE_ORDER[__builtin_ctz(left)], share);
}

/* The kind of what a group sees, if a pixel beside sees it, too; else the pixel's own. `id`: without `bits` lower bits.
 */
static uint32_t kind_around(const taking *t, uint32_t id, int bits)
{
    const daft_neighbours *n = t->part->first;
    const int px = (int)(t->wanted % DAFT_TILE), py = (int)(t->wanted / DAFT_TILE);
    for (int y = py - 1; y <= py + 1; y++)
        for (int x = px - 1; x <= px + 1; x++)
            if (n->id[y * n->id_stride + x] >> bits == id) return daft_first_kind(n, x, y);
    return t->kind;
}

/* Some of a pixel all of whose rays see the same. */
static void take_some(taking *t, uint32_t count)
{
    const float share = (float)RAYS / (float)(count + 1);
    t->out->own[t->wanted] = share;
    for (uint32_t left = DAFT_EDGE_FIRST[count]; left; left &= left - 1) shade(t, (uint32_t)__builtin_ctz(left), share);
}

static void take_inner(taking *t) { take_some(t, DAFT_EDGE_INNER[t->kind][t->level]); }

static bool is_inner(const taking *t)
{
    return t->part->edges->inner[t->wanted / DAFT_TILE] >> (t->wanted % DAFT_TILE) & 1;
}

/* An outline that is not in the pixel itself after all is beside it. */
static void take_beside(taking *t)
{
    if (is_inner(t))
        take_inner(t);
    else
        take_some(t, BESIDE[t->kind]);
}

static void take_outline(taking *t, uint32_t own)
{
    uint32_t id[RAYS];
    group groups[RAYS];
    int bits = 0;
    see_pixel(t->part->rays, t->wanted, id);
    uint32_t count = group_rays(id, groups);
    if (count > TRIANGLES) {
        bits = DAFT_ID_INSTANCE;
        for (int i = 0; i < RAYS; i++) id[i] >>= bits;
        count = group_rays(id, groups);
    }
    if (count == 1 && bits == 0 && groups[0].id == own) {
        take_beside(t);
        return;
    }
    t->out->own[t->wanted] = 0;
    for (uint32_t k = 0; k < count; k++) {
        const bool has_own = groups[k].id == own >> bits;
        take_group(t, &groups[k], has_own ? t->kind : kind_around(t, groups[k].id, bits), has_own);
    }
}

uint32_t DAFT_KERNEL(daft_take_edges)(const daft_edge_part *part, int y, uint32_t pixels, daft_edge_rays *out)
{
    const daft_edges *edges = part->edges;
    const int py = part->top + y;
    for (; pixels && out->list->count <= DAFT_BATCH - RAYS; pixels &= pixels - 1) {
        const int x = __builtin_ctz(pixels), px = part->left + x;
        taking t = {part, out, (uint32_t)(py * DAFT_TILE + px), daft_edge_level(edges, px, py),
                    daft_first_kind(part->first, px, py)};
        if (edges->outline[py] >> px & 1)
            take_outline(&t, part->first->id[py * part->first->id_stride + px]);
        else
            take_inner(&t);
    }
    return pixels;
}

void DAFT_KERNEL(daft_gather_light)(const daft_lanes3 *light, const daft_seen_list *list, daft_lanes3 *out)
{
    for (uint32_t i = 0; i < list->count; i += DAFT_VL) {
        const vi at =
            vi_if_then_else(vm_from_bits(vbits_first_n((int)(list->count - i))), vi_load(&list->pixel[i]), vi_set(0));
        vf_store(&out->x[i], vf_gather_index(light->x, at)), vf_store(&out->y[i], vf_gather_index(light->y, at));
        vf_store(&out->z[i], vf_gather_index(light->z, at));
    }
}

void DAFT_KERNEL(daft_add_light)(const daft_edge_rays *rays, daft_lanes3 *light, daft_lanes3 *sum)
{
    const uint32_t count = rays->list->count;
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        const vf share = vf_load(&rays->share[i]);
        vf_store(&light->x[i], vf_clamp01(vf_load(&light->x[i])) * share);
        vf_store(&light->y[i], vf_clamp01(vf_load(&light->y[i])) * share);
        vf_store(&light->z[i], vf_clamp01(vf_load(&light->z[i])) * share);
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t at = rays->wanted[rays->list->pixel[i]];
        sum->x[at] += light->x[i], sum->y[at] += light->y[i], sum->z[at] += light->z[i];
    }
}
