/* Clipping in the plane of a reference face (Sutherland and Hodgman 1974), and the choice of four points of many
 * (Gregorius, "Robust Contact Creation for Physics Simulations", GDC 2015). */
#include "sim/collide/manifold_parts.h"

/* Of a corner (13 bits) and the clipping edge (15 bits); bit 28: the corner came from clipping itself, and is named by
 * the edge that made it; bit 29: see daft_clip. */
static uint32_t clipped_id(uint32_t id, uint32_t edge, bool entering)
{
    uint32_t again = id >> 31;
    return 0x80000000u | (uint32_t)entering << 29 | again << 28 | (id & 0x1fffu) << 15 | (edge & 0x7fffu);
}

static daft_clip_point between(const daft_clip_point *from, const daft_clip_point *to, float d0, float d1, uint32_t id)
{
    float t = d0 / (d0 - d1);
    return (daft_clip_point){from->u + t * (to->u - from->u), from->v + t * (to->v - from->v),
                             from->w + t * (to->w - from->w), id};
}

uint32_t daft_clip(const daft_clip_point *in, uint32_t count, float a, float b, float c, uint32_t edge,
                   daft_clip_point *out)
{
    uint32_t made = 0;
    if (count == 0) return 0;
    const daft_clip_point *from = &in[count - 1];
    float d0 = from->u * a + from->v * b - c;
    for (uint32_t i = 0; i < count; i++) {
        const daft_clip_point *to = &in[i];
        float d1 = to->u * a + to->v * b - c;
        bool closing = count == 2 && i == 0; /* a segment has no edge back */
        /* A point where the polygon leaves is named by the edge it leaves on, one where it comes in by the corner it
         * comes to; so both ends of an edge that is cut twice differ. */
        if (!closing && (d0 <= 0) != (d1 <= 0) && made < DAFT_CLIP_MAX)
            out[made++] = between(from, to, d0, d1, clipped_id(d0 <= 0 ? from->id : to->id, edge, d0 > 0));
        if (d1 <= 0 && made < DAFT_CLIP_MAX) out[made++] = *to;
        from = to, d0 = d1;
    }
    return made;
}

/* Twice the signed area of the triangle p, q, r. */
static float area(const daft_clip_point *p, const daft_clip_point *q, const daft_clip_point *r)
{
    return (q->u - p->u) * (r->v - p->v) - (q->v - p->v) * (r->u - p->u);
}

static uint32_t rim_point(const daft_clip_point *p, uint32_t count, float even)
{
    float deepest = INFINITY, most = -INFINITY;
    uint32_t best = 0;
    for (uint32_t i = 0; i < count; i++)
        if (p[i].w < deepest) deepest = p[i].w;
    for (uint32_t i = 0; i < count; i++) {
        float along = p[i].u + 0.37f * p[i].v; /* any direction in which corners of boxes differ */
        if (p[i].w <= deepest + even && along > most) most = along, best = i;
    }
    return best;
}

uint32_t daft_clip_reduce(daft_clip_point *p, uint32_t count, float even)
{
    if (count <= DAFT_MANIFOLD_POINTS) return count;
    uint32_t first = rim_point(p, count, even), second = first, left = UINT32_MAX, right = UINT32_MAX;
    float farthest = 0, most = 0, least = 0;
    for (uint32_t i = 0; i < count; i++) {
        float u = p[i].u - p[first].u, v = p[i].v - p[first].v, square = u * u + v * v;
        if (square > farthest) farthest = square, second = i;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (i == first || i == second) continue;
        float side = area(&p[first], &p[second], &p[i]);
        if (side > most) most = side, left = i;
        if (side < least) least = side, right = i;
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++)
        if (i == first || i == second || i == left || i == right) p[kept++] = p[i];
    return kept;
}
