/* Triangles with alpha between points and a light. What their opacity classes, and masks in their textures' place, say
 * of the whole neighbourhood of a hit is taken where the hit itself is sure: in lanes of points, as mesh_kernel.c tests
 * opaque ones. Points of which something is not sure are left open: their own ray asks all again, and reads textures.
 * So nothing that is decided here differs from what the ray would say. */
#include "raster/samples/setup.h"
#include "raster/masks.h"

/* DAFT_VL points behind, or in doubt behind, a triangle. */
typedef struct meeting {
    vbits sure, maybe;
    vf inverse; /* of the sum of the edges */
} meeting;

/* Rays are rounded in frame space and again in the mesh's own: hits are sure where edges and depths are apart by more
 * than that as well. */
static meeting meeting_of(const mesh_occluder *m, const lanes *t, int i, const triangle_edges *e, vbits side,
                          uint32_t first)
{
    const light_view *l = m->c.view;
    const vf limit = vf_load(&m->c.points->depth[first]), apart = vf_set(t->apart[i]),
             inverse = vf_set(1) / (e->e0 + e->e1 + e->e2);
    const vf depth =
        (e->e0 * vf_set(t->depth[0][i]) + e->e1 * vf_set(t->depth[1][i]) + e->e2 * vf_set(t->depth[2][i])) * inverse;
    const vf error = vf_abs(vf_set(4 * t->slack[i]) * inverse) + vf_set(4 * t->rounding[i] + l->reach * 0x1p-20f);
    const vf behind = error + vf_set(l->pencil.away * 0x1p-20f) + vf_load(&m->c.points->end[first]);
    const vm inside = vm_or(vf_le(apart, e->min), vf_le(e->max, -apart)),
             before = vm_and(vf_lt(depth + error, limit), vf_lt(behind, depth));
    /* what is not a number is in doubt */
    return (meeting){.sure = side & vbits_from_mask(vm_and(inside, before)),
                     .maybe = side & ~vbits_from_mask(vf_le(limit, depth - error)),
                     .inverse = inverse};
}

static void meet_even(const occluder *c, uint32_t triangle, vbits points, uint32_t first)
{
    const daft_trimesh *mesh = c->instance->mesh;
    const uint32_t material = c->instance->materials[mesh->slots ? mesh->slots[triangle] : 0];
    daft_filtered *f = c->filtered;
    for (; points; points &= points - 1) {
        const uint32_t at = c->points->source[first + (uint32_t)__builtin_ctz(points)];
        if (f->count[at] == DAFT_MET_SURFACES)
            leave_open(c, at);
        else
            f->material[f->count[at]++][at] = material;
    }
}

/* The points at opaque places, and those where it is known. */
static vbits opaque_places(const occluder *c, const daft_mask *mask, const lanes *t, int i, const triangle_edges *e,
                           const meeting *met, vbits *known)
{
    const daft_mask_triangle on = daft_mask_triangle_of(mask, c->instance->mesh, t->triangle[i]);
    const vi states =
        mask_states(&on, e->e1 * met->inverse, e->e2 * met->inverse, vf_abs(vf_set(t->apart[i]) * met->inverse));
    const vbits opaque = vbits_from_mask(vi_eq(states, vi_set(DAFT_OPACITY_OPAQUE)));
    *known = (met->sure & opaque) | vbits_from_mask(vi_eq(states, vi_set(DAFT_OPACITY_CLEAR)));
    return opaque;
}

bool DAFT_KERNEL(daft_filter_points)(const mesh_occluder *m, const lanes *t, int i, const triangle_edges *e, vbits side,
                                     uint32_t first)
{
    const occluder *c = &m->c;
    const uint32_t triangle = t->triangle[i];
    side &= ~lie_on(c, triangle, first);
    if (!side) return false;
    const meeting met = meeting_of(m, t, i, e, side, first);
    vbits known = met.sure, dark = 0;
    if (c->instance->opacity && c->instance->opacity[triangle] == DAFT_OPACITY_OPAQUE) {
        dark = met.sure;
    } else {
        const daft_mask *mask = daft_mask_of(c->instance, triangle);
        if (mask && mask->cells)
            dark = met.sure & opaque_places(c, mask, t, i, e, &met, &known);
        else if (mask && mask->even)
            meet_even(c, triangle, met.sure, first);
        else
            known = 0;
    }
    for (vbits open = met.maybe & ~known; open; open &= open - 1)
        leave_open(c, c->points->source[first + (uint32_t)__builtin_ctz(open)]);
    float *depth = &c->points->depth[first];
    if (dark) vf_store(depth, vf_if_then_else(vm_from_bits(dark), vf_set(-INFINITY), vf_load(depth)));
    return dark != 0;
}
