/* The points of a tile as the light sees them: their extent in its picture, the box of their rays, and which of them
 * lie under the bounds of which instances (steps 1 to 3 of occlusion_kernel.c). Lanes are points; where the tree over
 * instances is walked, the eight boxes of a node. */
#include "raster/samples/cast.h"

#define TINY 1e-36f

/* ---- view space ---- */

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

bool DAFT_KERNEL(daft_cast_measure)(cast *c)
{
    light_view *l = &c->view;
    const daft_samples *b = c->samples;
    const uint32_t *bits = c->asked;
    const vf inf = vf_set(INFINITY);
    const daft_vec3 first = first_point(b, bits);
    vf lu = inf, lv = inf, ld = inf, hu = -inf, hv = -inf, hd = -inf, ax = vf_set(0), ay = ax;
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vbits in = bits_at(bits, i);
        if (!in) continue;
        vf3 p = to_view_space(&l->pencil, asked_points(b, in, i, first));
        vf_store(&c->place[0][i], p.x), vf_store(&c->place[1][i], p.y), vf_store(&c->place[2][i], p.z);
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
    l->end = l->pencil.parallel ? -INFINITY : -l->pencil.away;
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
void DAFT_KERNEL(daft_cast_points)(cast *c)
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

/* The bound is grown by 2^-20 of what there is in coordinates: over the roundings of rays, planes and distances, each a
 * few 2^-24 of them. */
static frame_box grown_bound(const cast *c, const daft_instance *s)
{
    daft_vec3 h = daft_max3(daft_neg(s->low), s->high);
    float pad = (c->view.reach + fabsf(h.x) + fabsf(h.y) + fabsf(h.z)) * 0x1p-20f;
    daft_vec3 by = daft_v3(pad, pad, pad);
    return (frame_box){daft_sub(s->low, by), daft_add(s->high, by)};
}

/* Whether rays from between the points' corners have left the bound on one axis before they come to it on another.
 * Along an axis they go between `slow` and `fast` of their length, towards the light. */
static bool rays_apart(const cast *c, const frame_box *s)
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
static bool rays_clear(const cast *c, const frame_box *s)
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

/* Whether all of a mesh or sphere lies in the box that rays end before, by its own bounds. */
static bool lies_in_box(const daft_slanted_box *box, const daft_instance *s)
{
    const float *m = s->to_frame.m, *t = s->to_frame.t;
    const double r = (double)s->radius;
    daft_dvec3 middle = daft_dv3((double)t[0], (double)t[1], (double)t[2]),
               half[3] = {daft_dv3(r, 0, 0), daft_dv3(0, r, 0), daft_dv3(0, 0, r)};
    for (int j = 0; s->mesh && j < 3; j++) {
        const double low = (double)daft_v3_at(s->mesh->low, j), high = (double)daft_v3_at(s->mesh->high, j);
        const daft_dvec3 column = daft_dv3((double)m[j], (double)m[3 + j], (double)m[6 + j]);
        half[j] = daft_dscale(column, (high - low) / 2);
        middle = daft_dadd(middle, daft_dscale(column, (high + low) / 2));
    }
    middle = daft_dsub(middle, daft_to_double(box->middle));
    for (int k = 0; k < 3; k++) {
        const daft_dvec3 axis = daft_to_double(box->axes[k]);
        double reach = fabs(daft_ddot(axis, middle));
        for (int j = 0; j < 3; j++) reach += fabs(daft_ddot(axis, half[j]));
        if (!(reach < 1)) return false;
    }
    return true;
}

/* Whether the instance lies where no ray goes, as what glows does to its own light. */
static bool lies_past_ends(const daft_apex *light, const daft_instance *s)
{
    if (light->infinite) return false;
    if (light->box && lies_in_box(light->box, s)) return true;
    if (!(light->around > 0) || s->mesh) return false;
    const daft_dvec3 to =
        daft_dsub(daft_dv3((double)s->to_frame.t[0], (double)s->to_frame.t[1], (double)s->to_frame.t[2]),
                  daft_to_double(light->at));
    return sqrt(daft_ddot(to, to)) + (double)s->radius < (double)light->around * (1 - 1e-6);
}

/* Whether the rays may meet the instance in its bound: neither a convex instance nor a flat one shadows its own points.
 */
bool DAFT_KERNEL(daft_cast_may_shadow)(const cast *c, uint32_t number, frame_box *box)
{
    const daft_instance *s = &c->tlas->instances[number];
    if (number == c->sole && (s->flags & DAFT_INSTANCE_CONVEX || is_flat(s))) return false;
    *box = grown_bound(c, s);
    return !rays_clear(c, box) && !lies_past_ends(c->light, s);
}

static bool holds_points(const cast *c, const frame_box *s)
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
DAFT_INLINE vbits rays_meet(const cast *c, const frame_box *s, uint32_t i)
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
bool DAFT_KERNEL(daft_cast_mark_under)(cast *c, const frame_box *box, const daft_instance *s, uint32_t number)
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
    frame_box box;
    picture_box seen = node_child(boxes, i);
    const uint32_t first = c->shaft_count;
    uint32_t blocks = 0;
    if (!DAFT_KERNEL(daft_cast_may_shadow)(c, number, &box)) return;
    if (c->sifts) {
        const shaft_answer found = DAFT_KERNEL(daft_cast_shaft)(c, number, &seen, &blocks);
        if (found == SHAFT_CLEAR) return;
        c->dark = found == SHAFT_DARK;
    }
    if (c->occluder_count < DAFT_MAX_OCCLUDERS) {
        c->occluder[c->occluder_count].number = number;
        c->occluder[c->occluder_count].box = seen;
        c->occluder[c->occluder_count].first = first, c->occluder[c->occluder_count].blocks = blocks;
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
        const frame_box box = grown_bound(c, s);
        if (DAFT_KERNEL(daft_cast_mark_under)(c, &box, s, c->occluder[i].number)) c->occluder[kept++] = c->occluder[i];
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
bool DAFT_KERNEL(daft_cast_find_occluders)(cast *c, uint32_t max, uint32_t looks)
{
    uint32_t stack[DAFT_STACK], looked = 0;
    int top = 0;
    c->occluder_count = c->shaft_count = c->sifted = c->tried = c->hiders = 0, c->keeps = false, c->dark = false;
    memset(c->hidden, 0, sizeof c->hidden);
    if (c->only != DAFT_NOTHING)
        find_one(c);
    else
        stack[top++] = 0;
    while (top > 0 && c->occluder_count <= max && !c->dark && looked++ <= looks) {
        node_boxes boxes;
        const daft_node *node = &c->tlas->nodes.items[stack[--top]];
        uint32_t in = DAFT_KERNEL(daft_node_project)(&c->view, &c->frame_map, node, &boxes);
        for (; in && !c->dark; in &= in - 1) {
            int i = __builtin_ctz(in);
            uint32_t child = node->child[i], number = child & ~DAFT_CHILD_LEAF;
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF))
                stack[top++] = child;
            else if (looked++, c->tlas->instances[number].flags & c->flag)
                remember(c, number, &boxes, i);
        }
    }
    if (c->dark) return true;
    if (c->hiders) {
        for (uint32_t word = 0; word < DAFT_SAMPLES_WORDS; word++) c->rest[word] = c->asked[word] & ~c->hidden[word];
        c->asked = c->rest;
    }
    if (top > 0 || c->occluder_count > max) return false;
    mark_occluders(c);
    return true;
}

/* ---- nothing in the way ---- */

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
bool DAFT_KERNEL(daft_cast_clear)(const cast *c)
{
    frame_box box;
    uint32_t stack[DAFT_STACK], looked = 0;
    int top = 0;
    if (c->only != DAFT_NOTHING) return !DAFT_KERNEL(daft_cast_may_shadow)(c, c->only, &box);
    stack[top++] = 0;
    while (top > 0) {
        if (looked++ > FEW_LOOKS) return false;
        const daft_node *node = &c->tlas->nodes.items[stack[--top]];
        for (uint32_t in = children_met(c, node); in; in &= in - 1) {
            uint32_t child = node->child[__builtin_ctz(in)], number = child & ~DAFT_CHILD_LEAF;
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF))
                stack[top++] = child;
            else if (looked++,
                     c->tlas->instances[number].flags & c->flag && DAFT_KERNEL(daft_cast_may_shadow)(c, number, &box))
                return false;
        }
    }
    return true;
}
