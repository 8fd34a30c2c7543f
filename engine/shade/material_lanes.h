/* Materials of a batch's points, in lanes. For the kernel sources of shade and of what is above it. */
#ifndef DAFT_MATERIAL_LANES_H
#define DAFT_MATERIAL_LANES_H

#include "math/simd/ops.h"
#include "shade/shade.h"

#include <stddef.h>

/* Reads a member of the points' materials: one broadcast where all DAFT_VL points share one, else a gather. */
typedef struct material_reader {
    const float *base;
    vi offset;
    bool same;
    uint32_t first;
} material_reader;

enum { SURFACE_WORDS = sizeof(daft_surface) / sizeof(float) };
_Static_assert(sizeof(daft_surface) == SURFACE_WORDS * sizeof(float), "materials are gathered by words");

DAFT_INLINE material_reader read_materials(const daft_batch *batch, const daft_surface *materials, uint32_t i)
{
    if (batch->one_material) return (material_reader){(const float *)materials, vi_set(0), true, batch->material[0]};
    uint32_t left = batch->count - i, first = batch->material[i];
    vi numbers = vi_load(&batch->material[i]);
    vbits used = vbits_first_n(left > DAFT_VL ? DAFT_VL : (int)left);
    bool same = (vbits_from_mask(vi_eq(numbers, vi_set((int32_t)first))) & used) == used;
    numbers = vi_if_then_else(vm_from_bits(used), numbers, vi_set((int32_t)first));
    return (material_reader){(const float *)materials, numbers * vi_set(SURFACE_WORDS), same, first};
}
/* Of points that may share one where the others beside them do not: at least one lane, of points of the batch. */
DAFT_INLINE material_reader read_some_materials(const daft_batch *batch, const daft_surface *materials, uint32_t i,
                                                vbits lanes)
{
    if (batch->one_material) return read_materials(batch, materials, i);
    const uint32_t first = batch->material[i + (uint32_t)__builtin_ctz(lanes)];
    const vi numbers = vi_if_then_else(vm_from_bits(lanes), vi_load(&batch->material[i]), vi_set((int32_t)first));
    const bool same = vbits_from_mask(vi_eq(numbers, vi_set((int32_t)first))) == DAFT_ALL_LANES;
    return (material_reader){(const float *)materials, numbers * vi_set(SURFACE_WORDS), same, first};
}
DAFT_INLINE vf material_word(const material_reader *r, size_t word)
{
    if (r->same) return vf_set(r->base[r->first * SURFACE_WORDS + word]);
    return vf_gather_index(r->base + word, r->offset);
}
#define MATERIAL_WORD(reader, member) material_word(reader, offsetof(daft_surface, member) / sizeof(float))
#define MATERIAL_COLOR(reader, member)                                                                                 \
    ((vf3){MATERIAL_WORD(reader, member.x), MATERIAL_WORD(reader, member.y), MATERIAL_WORD(reader, member.z)})

#endif
