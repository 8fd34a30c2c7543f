/* Shafts: what can stand between a tile's points and a lamp. The instance tree is walked with tests that only ever keep too
 * much. Towards a sun a box is kept when its shadow on the plane across the light overlaps the points' and it does not lie
 * wholly behind them; towards a point lamp when its bounding sphere touches the cone from the lamp around theirs. */
#include "accel/bvh.h"
#include "render/internal.h"

typedef struct shaft {
    bool sun;
    daft_vec3 axis[3];                /* sun: two across the light, one towards it */
    float low[3], high[3];            /* of the points, along the axes */
    daft_vec3 lamp, along;            /* point: position, and the unit vector to the middle of the points */
    float length, radius;             /* to the middle; of the cone there */
    bool everything;                  /* the lamp is among the points */
} shaft;

static void points_box(const daft_batch *points, const uint32_t *bits, float low[3], float high[3], const daft_vec3 axis[3])
{
    for (int k = 0; k < 3; k++) low[k] = INFINITY, high[k] = -INFINITY;
    for (uint32_t i = 0; i < points->count; i++) {
        if (!(bits[i / 32] >> (i % 32) & 1)) continue;
        daft_vec3 p = {points->lifted.x[i], points->lifted.y[i], points->lifted.z[i]};
        for (int k = 0; k < 3; k++) {
            float at = daft_dot(p, axis[k]);
            low[k] = at < low[k] ? at : low[k];
            high[k] = at > high[k] ? at : high[k];
        }
    }
}

static shaft shaft_setup(const daft_batch *points, const uint32_t *bits, const daft_lamp *lamp)
{
    shaft s = {.sun = lamp->sun, .axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    if (s.sun) {
        daft_vec3 l = lamp->to_light, least = fabsf(l.y) < 0.7f ? daft_v3(0, 1, 0) : daft_v3(1, 0, 0);
        s.axis[0] = daft_normalize(daft_cross(l, least));
        s.axis[1] = daft_cross(s.axis[0], l);
        s.axis[2] = l;
    }
    points_box(points, bits, s.low, s.high, s.axis);
    if (s.sun) return s;
    daft_vec3 middle = {(s.low[0] + s.high[0]) / 2, (s.low[1] + s.high[1]) / 2, (s.low[2] + s.high[2]) / 2};
    daft_vec3 half = {(s.high[0] - s.low[0]) / 2, (s.high[1] - s.low[1]) / 2, (s.high[2] - s.low[2]) / 2};
    float radius = daft_length(half) * 1.0001f;
    s.lamp = lamp->position;
    daft_vec3 way = daft_sub(middle, s.lamp);
    s.length = daft_length(way);
    s.everything = !(s.length > radius * 1.01f);
    if (s.everything) return s;
    s.along = daft_scale(way, 1 / s.length);
    s.radius = radius * s.length / sqrtf(s.length * s.length - radius * radius);
    s.high[0] = s.length + radius; /* nothing behind the points matters */
    return s;
}

/* Sun: the box as an interval on each axis, with slack for the roundings of both sides. */
static bool sun_touches(const shaft *s, daft_vec3 centre, daft_vec3 half)
{
    for (int k = 0; k < 3; k++) {
        daft_vec3 a = s->axis[k];
        float at = daft_dot(centre, a), reach = fabsf(a.x) * half.x + fabsf(a.y) * half.y + fabsf(a.z) * half.z;
        reach += (fabsf(centre.x) + fabsf(centre.y) + fabsf(centre.z) + reach + fabsf(s->low[k]) + fabsf(s->high[k])) * 0x1p-20f;
        if (at + reach < s->low[k]) return false;
        if (k < 2 && at - reach > s->high[k]) return false;
    }
    return true;
}

static bool lamp_touches(const shaft *s, daft_vec3 centre, daft_vec3 half)
{
    if (s->everything) return true;
    daft_vec3 way = daft_sub(centre, s->lamp);
    float radius = daft_length(half) * 1.001f + daft_length(way) * 0x1p-19f, along = daft_dot(way, s->along);
    if (along < -radius || along - radius > s->high[0]) return false;
    float reach = (along + radius) / s->length * s->radius * 1.001f + radius;
    daft_vec3 aside = daft_sub(way, daft_scale(s->along, along));
    return daft_dot(aside, aside) <= reach * reach;
}

static bool child_touches(const shaft *s, const daft_node *node, int child)
{
    daft_vec3 low = {node->bounds[0][child], node->bounds[1][child], node->bounds[2][child]};
    daft_vec3 high = {node->bounds[3][child], node->bounds[4][child], node->bounds[5][child]};
    daft_vec3 centre = daft_add(daft_scale(low, 0.5f), daft_scale(high, 0.5f));
    daft_vec3 half = daft_sub(daft_scale(high, 0.5f), daft_scale(low, 0.5f));
    return s->sun ? sun_touches(s, centre, half) : lamp_touches(s, centre, half);
}

uint32_t daft_shaft_candidates(const daft_tlas *tlas, const daft_batch *points, const uint32_t *bits,
                               const daft_lamp *lamp, uint32_t flag, uint32_t *out, uint32_t capacity)
{
    if (tlas->nodes.count == 0) return 0;
    shaft s = shaft_setup(points, bits, lamp);
    uint32_t stack[DAFT_STACK], count = 0;
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const daft_node *node = &tlas->nodes.items[stack[--top]];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE || !child_touches(&s, node, i)) continue;
            if (!(child & DAFT_CHILD_LEAF)) {
                stack[top++] = child;
                continue;
            }
            uint32_t instance = child & ~DAFT_CHILD_LEAF;
            if (!(tlas->instances[instance].flags & flag)) continue;
            if (count == capacity) return UINT32_MAX;
            out[count++] = instance;
        }
    }
    return count;
}
