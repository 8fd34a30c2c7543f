/* What the camera's pixels see, listed: pixels with a hit become a batch's points, the others rays to the sky, and each
 * triangle or sphere that several windows see becomes one facet. surface_kernel.c makes surfaces of them. */
#include "render/points/surface.h"

/* Bits of the pixels of a row, from `at` on, that are the last of a run that sees one facet; `count` of them count. */
DAFT_INLINE vbits run_ends(const daft_tile *tile, int at, int count)
{
    vm same = vm_and(vi_eq(vi_load(&tile->instance[at]), vi_load(&tile->instance[at + 1])),
                     vi_eq(vi_load(&tile->triangle[at]), vi_load(&tile->triangle[at + 1])));
    return (~vbits_from_mask(same) & vbits_first_n(count)) | (vbits)1 << (count - 1);
}

/* Pixels put into the batches, and what they see beside those that see something. A pixel's number is its place in the
 * tile. */
typedef struct sorted {
    const daft_tile *tile;
    finder *finder;
    daft_batch *points;
    daft_ray_batch *sky;
    int32_t *slots;
    uint32_t seen, unseen;
} sorted;

static void sort_runs(sorted *s, int at, int count)
{
    int first = at;
    for (vbits ends = run_ends(s->tile, at, count); ends; ends &= ends - 1) {
        int end = at + __builtin_ctz(ends) + 1;
        uint32_t instance = s->tile->instance[first], triangle = s->tile->triangle[first];
        vi numbers = vi_iota() + vi_set(first);
        if (instance == DAFT_NOTHING) {
            vi_store(&s->sky->pixel[s->unseen], numbers);
            s->unseen += (uint32_t)(end - first);
        } else {
            vi_store(&s->points->pixel[s->seen], numbers);
            vi_store(&s->points->instance[s->seen], vi_set((int32_t)instance));
            vi_store(&s->points->triangle[s->seen], vi_set((int32_t)triangle));
            vi_store(&s->slots[s->seen], vi_set(find_slot(s->finder, instance, triangle)));
            s->seen += (uint32_t)(end - first);
        }
        first = end;
    }
}

/* DAFT_VL pixels that all have a hit; lanes of `same` share the facets of `slots`. */
static void sort_visible(sorted *s, int at, vi instance, vi triangle, vbits same, vi slots)
{
    vbits ends = run_ends(s->tile, at, DAFT_VL);
    vi_store(&s->points->pixel[s->seen], vi_iota() + vi_set(at));
    vi_store(&s->points->instance[s->seen], instance), vi_store(&s->points->triangle[s->seen], triangle);
    for (vbits left = ~same & DAFT_ALL_LANES; left;) {
        int first = __builtin_ctz(left);
        vbits before = (vbits)((1u << first) - 1), to_end = ends & ~before, run = (to_end ^ (to_end - 1)) & ~before;
        int32_t slot = find_slot(s->finder, s->tile->instance[at + first], s->tile->triangle[at + first]);
        slots = vi_if_then_else(vm_from_bits(run), vi_set(slot), slots);
        left &= ~run;
    }
    vi_store(&s->slots[s->seen], slots);
    s->seen += DAFT_VL;
}

/* Which of DAFT_VL pixels see what those above them see. */
DAFT_INLINE vbits as_above(const daft_tile *tile, int at, vi instance, vi triangle)
{
    return vbits_from_mask(vm_and(vi_eq(instance, vi_load(&tile->instance[at - DAFT_TILE_STRIDE])),
                                  vi_eq(triangle, vi_load(&tile->triangle[at - DAFT_TILE_STRIDE]))));
}

static void end_lists(sorted *s)
{
    vi_store(&s->slots[s->seen], vi_set(0)), vi_store(&s->points->pixel[s->seen], vi_set(0));
    vi_store(&s->sky->pixel[s->unseen], vi_set(0));
    s->points->count = s->seen, s->sky->count = s->unseen;
}

static void sort_pixels(sorted *s)
{
    const daft_tile *tile = s->tile;
    uint32_t above[DAFT_TILE / DAFT_VL]; /* where the slots of the window above begin, or DAFT_NOTHING: it sees some sky
                                          */
    for (int i = 0; i < DAFT_TILE / DAFT_VL; i++) above[i] = DAFT_NOTHING;
    for (int row = 0; row < tile->height; row++)
        for (int x = 0; x < tile->width; x += DAFT_VL) {
            int at = row * DAFT_TILE_STRIDE + x, column = x / DAFT_VL;
            uint32_t begin = s->seen;
            vi instance = vi_load(&tile->instance[at]), triangle = vi_load(&tile->triangle[at]);
            bool known = above[column] != DAFT_NOTHING;
            vbits same = known ? as_above(tile, at, instance, triangle) : 0;
            vi slots = vi_load(&s->slots[known ? above[column] : 0]);
            if (same == DAFT_ALL_LANES) {
                vi_store(&s->slots[begin], slots);
                vi_store(&s->points->pixel[begin], vi_iota() + vi_set(at));
                vi_store(&s->points->instance[begin], instance);
                vi_store(&s->points->triangle[begin], triangle);
                s->seen += DAFT_VL;
            } else if (tile->width - x >= DAFT_VL && !vbits_from_mask(vi_eq(instance, vi_set((int32_t)DAFT_NOTHING)))) {
                sort_visible(s, at, instance, triangle, same, slots);
            } else {
                sort_runs(s, at, daft_min_i(DAFT_VL, tile->width - x));
            }
            above[column] = s->seen - begin == DAFT_VL ? begin : DAFT_NOTHING;
        }
    end_lists(s);
}

/* The list's points, with where their rays go in u and v, and its rays to the sky. */
static void sort_list(const daft_seen_list *list, finder *f, int32_t *slots, daft_batch *points, daft_ray_batch *sky)
{
    uint32_t seen = 0, unseen = 0;
    for (uint32_t i = 0; i < list->count; i++) {
        if (list->instance[i] == DAFT_NOTHING) {
            sky->direction.x[unseen] = list->x[i], sky->direction.y[unseen] = list->y[i];
            sky->pixel[unseen++] = list->pixel[i];
            continue;
        }
        points->u[seen] = list->x[i], points->v[seen] = list->y[i];
        points->instance[seen] = list->instance[i], points->triangle[seen] = list->triangle[i];
        points->pixel[seen] = list->pixel[i];
        slots[seen++] = find_slot(f, list->instance[i], list->triangle[i]);
    }
    for (uint32_t i = seen; i % DAFT_VL; i++) points->u[i] = points->v[i] = 0, points->pixel[i] = 0, slots[i] = 0;
    points->count = seen, sky->count = unseen;
}

void DAFT_KERNEL(daft_tile_facets)(const daft_snapshot *snapshot, const daft_tile *tile, daft_facets *facets,
                                   daft_batch *points, daft_ray_batch *sky)
{
    finder f = {.snapshot = snapshot, .facets = facets};
    sorted pixels = {tile, &f, points, sky, facets->slot, 0, 0};
    facets->count = 0;
    sort_pixels(&pixels);
}

void DAFT_KERNEL(daft_list_facets)(const daft_snapshot *snapshot, const daft_seen_list *list, daft_facets *facets,
                                   daft_batch *points, daft_ray_batch *sky)
{
    finder f = {.snapshot = snapshot, .facets = facets};
    facets->count = 0;
    sort_list(list, &f, facets->slot, points, sky);
}
