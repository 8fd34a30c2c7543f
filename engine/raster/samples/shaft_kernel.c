/* Occluders against all of a tile's points at once: what of them stands in the shaft between the points and the light
 * (Haines and Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", 1991). In most tiles nothing does but the
 * surfaces that the points lie on, or one triangle hides all points: then blocks are never made.
 *
 * The shaft is the points' extent in the light's picture, from their depths to where the rays end. Lanes are triangles,
 * and those beside it are left out: an edge has all of the extent surely outside. The others are asked point by point,
 * lanes being points, by the tests of mesh_kernel.c: surely before the triangle's plane, surely outside an edge. What
 * passes over each point is left out. This chooses which triangles are tested; it never changes what hides a point.
 *
 * Only so much is looked at: beyond that, trees are walked with blocks, as if nothing were known. The limits count
 * triangles and nodes, not registers, so that every instruction set gives up alike. */
#include "raster/samples/cast.h"
#include "raster/samples/setup.h"

enum {
    MESHES = 16, /* are looked at, */
    KEEPING = 4, /* once a triangle may hide some points; of each: */
    NODES = 32,
    BLOCKS = 32,   /* of triangles, in leaves that meet the extent; and of all meshes: */
    TRIANGLES = 8, /* asked point by point, until one may hide some: then blocks are made anyway */
    HIDERS = 4     /* large triangles that are asked what they hide */
};

typedef struct shaft {
    cast *c;
    mesh_occluder m;
    vf middle_u, middle_v, half_u, half_v; /* of the points' extent */
    float near;                            /* the least z of a point's ray */
    daft_slanted_box box;                  /* that the light's rays end before, in view space */
    float box_side[3];                     /* 1, and what products with the box's axes are off by */
} shaft;

static daft_vec3 turned_to_view(const daft_pencil *p, daft_vec3 d)
{
    return daft_v3(daft_dot(p->right, d), daft_dot(p->up, d), daft_dot(p->forward, d));
}

static void shaft_make(cast *c, uint32_t number, shaft *out)
{
    const light_view *l = &c->view;
    const occluder one = occluder_of(c, number, NULL);
    out->c = c;
    DAFT_KERNEL(daft_mesh_occluder_make)(&one, &out->m);
    out->middle_u = vf_set((l->low_u + l->high_u) * 0.5f), out->middle_v = vf_set((l->low_v + l->high_v) * 0.5f);
    out->half_u = vf_set((l->high_u - l->low_u) * 0.5f + l->slack_u);
    out->half_v = vf_set((l->high_v - l->low_v) * 0.5f + l->slack_v);
    out->near = l->pencil.parallel ? 1 : l->near + l->pencil.away;
    const daft_slanted_box *box = l->light->box;
    if (!box) return;
    out->box.middle = turned_to_view(&l->pencil, daft_sub(box->middle, l->pencil.origin));
    const float size = l->size + 2 * (l->pencil.away + daft_length(out->box.middle));
    for (int k = 0; k < 3; k++) {
        const daft_vec3 a = out->box.axes[k] = turned_to_view(&l->pencil, box->axes[k]);
        out->box_side[k] = 1 + (fabsf(a.x) + fabsf(a.y) + fabsf(a.z)) * size * 0x1p-20f;
    }
}

/* ---- all points together ---- */

/* Triangles in the box that rays end before, `off` being what their corners are off by. */
static vm inside_box(const shaft *s, const view_corners *t, vf off)
{
    const daft_slanted_box *box = &s->box;
    vm inside = vf_le(vf_set(0), vf_set(1));
    for (int k = 0; k < 3; k++) {
        const daft_vec3 a = box->axes[k];
        const vf limit = vf_set(1 - 0x1p-18f) - vf_set(2 * (fabsf(a.x) + fabsf(a.y) + fabsf(a.z))) * off;
        for (int i = 0; i < 3; i++) {
            const vf at = vf_set(a.x) * (t->p[i].x - vf_set(box->middle.x)) +
                          vf_set(a.y) * (t->p[i].y - vf_set(box->middle.y)) +
                          vf_set(a.z) * (t->depth[i] - vf_set(box->middle.z));
            inside = vm_and(inside, vf_lt(vf_abs(at), limit));
        }
    }
    return inside;
}

/* Triangles that lie beside the extent, behind all points, or where all rays have ended. */
static vbits beside_extent(const shaft *s, const view_corners *t)
{
    const light_view *l = &s->c->view;
    const vf near = nearest_depth(t);
    const vf off = s->m.before ? vf_set(s->m.off_depth) : near_apex_error(&s->m, t, near, vf_set(0)).depth;
    const vm behind = vf_lt(vf_set(l->far) + off, near);
    if (l->pencil.parallel) return vbits_from_mask(vm_or(behind, corners_outside(l, t, off)));
    vm past = vf_lt(farthest_depth(t) + off, vf_set(l->end - l->pencil.away * 0x1p-20f));
    if (l->light->box) past = vm_or(past, inside_box(s, t, off + vf_set(l->pencil.away * 0x1p-20f)));
    return vbits_from_mask(vm_or(vm_or(behind, past), corners_outside(l, t, off + vf_set(l->pencil.away * 0x1p-20f))));
}

/* Triangles one of whose edges has all of the extent surely outside. Rounding of its function over the extent is below
 * 5u of its M over the points, `wide` above 10u. Which of two signs is outside is known where the light is surely off
 * the plane and the triangle before it: else edges of both must be there, as in mesh_kernel.c. */
static vbits beside_edges(const shaft *s, const view_corners *t, const lanes *at)
{
    const light_view *l = &s->c->view;
    const vf zero = vf_set(0), scale = vf_set(s->near), margin = vf_set(4) * vf_load(at->wide);
    vm below = vf_lt(zero, zero), above = below, before = vm_not(below);
    for (int k = 0; k < 3; k++) {
        const vf nx = vf_load(at->nx[k]), ny = vf_load(at->ny[k]), nz = vf_load(at->nz[k]);
        const vf middle = nx * s->middle_u + ny * s->middle_v + nz,
                 half = vf_abs(nx) * s->half_u + vf_abs(ny) * s->half_v;
        below = vm_or(below, vf_lt((middle + half) * scale, -margin));
        above = vm_or(above, vf_lt(margin, (middle - half) * scale));
    }
    if (!l->pencil.parallel) {
        const vf nearest = nearest_depth(t), off = near_apex_error(&s->m, t, nearest, zero).depth;
        before = vf_lt(vf_set(-l->pencil.away + l->pencil.away * 0x1p-18f) + off, nearest);
    }
    const vf turned = vf_load(at->turned);
    const vm positive = vm_and(before, vf_lt(zero, turned)), negative = vm_and(before, vf_lt(turned, zero));
    return vbits_from_mask(vm_or(vm_and(below, above), vm_or(vm_and(positive, below), vm_and(negative, above))));
}

/* Triangles that hold two of the middles of the extent's quarters, and so may hide many points. */
static vbits large_triangles(const shaft *s, const lanes *at)
{
    const vf zero = vf_set(0), half = vf_set(0.5f);
    vbits one = 0, two = 0;
    for (int quarter = 0; quarter < 4; quarter++) {
        const vf u = s->middle_u + (quarter & 1 ? half : -half) * s->half_u,
                 v = s->middle_v + (quarter & 2 ? half : -half) * s->half_v;
        vm below = vf_le(zero, zero), above = below;
        for (int k = 0; k < 3; k++) {
            const vf e = vf_load(at->nx[k]) * u + vf_load(at->ny[k]) * v + vf_load(at->nz[k]);
            below = vm_and(below, vf_lt(e, zero)), above = vm_and(above, vf_lt(zero, e));
        }
        const vbits holds = vbits_from_mask(vm_or(below, above));
        two |= one & holds, one |= holds;
    }
    return two;
}

/* ---- point by point ---- */

DAFT_INLINE triangle_edges edges_at_ray(const lanes *t, int i, vf3 d)
{
    vf e[3];
    for (int k = 0; k < 3; k++)
        e[k] = vf_set(t->nx[k][i]) * d.x + vf_set(t->ny[k][i]) * d.y + vf_set(t->nz[k][i]) * d.z;
    return (triangle_edges){e[0], e[1], e[2], vf_min(e[0], vf_min(e[1], e[2])), vf_max(e[0], vf_max(e[1], e[2]))};
}

/* lie_on, of those points from `at` on that are `among` them; the rest may be past the last point. */
static vbits lie_on_it(const shaft *s, uint32_t triangle, uint32_t at, vbits among)
{
    const occluder *c = &s->m.c;
    const vbits on = among & vbits_from_mask(vi_eq(vi_load(&c->samples->instance[at]), vi_set((int32_t)c->number)));
    if (c->convex || !on) return on;
    const vi own = vi_load(&s->c->own[at]);
    if (c->flat) return on & ~vbits_from_mask(vi_eq(own, vi_set((int32_t)DAFT_NO_TRIANGLE)));
    return on & vbits_from_mask(vi_eq(own, vi_set((int32_t)triangle)));
}

/* Places in view space. */
DAFT_INLINE vf3 place_of(const cast *c, uint32_t at)
{
    return (vf3){vf_load(&c->place[0][at]), vf_load(&c->place[1][at]), vf_load(&c->place[2][at])};
}

DAFT_INLINE vf3 ray_of(const light_view *l, vf3 place)
{
    return (vf3){place.x, place.y, l->pencil.parallel ? vf_set(1) : place.z + vf_set(l->pencil.away)};
}

/* Whether the triangle may hide one of the points. */
static bool may_hide(const shaft *s, const lanes *t, int i)
{
    const cast *c = s->c;
    const vf px = vf_set(t->plane[0][i]), py = vf_set(t->plane[1][i]), pz = vf_set(t->plane[2][i]),
             surface = vf_set(t->surface[i]), wide = vf_set(t->wide[i]);
    for (uint32_t at = 0; at < c->samples->count; at += DAFT_VL) {
        vbits in = bits_at(c->asked, at) & ~bits_at(c->hidden, at);
        if (!in) continue;
        const vf3 p = place_of(c, at);
        in &= vbits_from_mask(vf_le(surface, px * p.x + py * p.y + pz * p.z));
        if (!in) continue;
        const triangle_edges e = edges_at_ray(t, i, ray_of(&c->view, p));
        in &= vbits_from_mask(vm_or(vf_le(-wide, e.min), vf_le(e.max, wide)));
        if (in & ~lie_on_it(s, t->triangle[i], at, in)) return true;
    }
    return false;
}

/* Where rays from places to the light come into the box, in parts of them, or before; 1: nowhere. The box is larger by
 * what places in it may be off by. */
static vf boxes_enter(const shaft *s, vf3 p)
{
    const light_view *l = &s->c->view;
    const daft_slanted_box *box = &s->box;
    const vf zero = vf_set(0);
    const vf3 rest = {p.x - vf_set(box->middle.x), p.y - vf_set(box->middle.y), p.z - vf_set(box->middle.z)},
              way = {-p.x, -p.y, -(p.z + vf_set(l->pencil.away))};
    vf first = zero, last = vf_set(1);
    vm meets = vf_le(zero, last);
    for (int k = 0; k < 3; k++) {
        const daft_vec3 a = box->axes[k];
        const vf3 axis = {vf_set(a.x), vf_set(a.y), vf_set(a.z)};
        const vf side = vf_set(s->box_side[k]), at = vf3_dot(axis, rest), by = vf3_dot(axis, way);
        meets = vm_and(meets, vm_or(vf_le(vf_abs(at), side), vf_lt(at * by, zero)));
        const vm level = vm_and(vf_le(by, zero), vf_le(zero, by));
        const vf inverse = vf_set(1) / by, low = (-side - at) * inverse, high = (side - at) * inverse;
        first = vf_if_then_else(level, first, vf_max(first, vf_min(low, high)));
        last = vf_if_then_else(level, last, vf_min(last, vf_max(low, high)));
    }
    const vf most = vf_set(1 + 0x1p-20f);
    return vf_if_then_else(vm_and(meets, vf_le(first, last * most)), first * vf_set(1 - 0x1p-20f), vf_set(1));
}

/* No ray ends before these depths: ends_of (blocks_kernel.c), and more by what either rounds. */
DAFT_INLINE vf ends_before(const shaft *s, vf3 p)
{
    const light_view *l = &s->c->view;
    const daft_apex *light = l->light;
    if (l->pencil.parallel) return vf_set(-INFINITY);
    vf end = vf_set(fmaxf(light->around, light->before * l->max_z));
    if (light->box) end = vf_max(end, (p.z + vf_set(l->pencil.away)) * (vf_set(1) - boxes_enter(s, p)));
    return end - vf_set(l->pencil.away * (1 - 0x1p-18f));
}

/* Marks the points that the triangle surely hides, well inside its edges: those that hide_points takes, but for some.
 * Gives whether all points are hidden now. */
static bool hide(const shaft *s, const lanes *t, int i)
{
    cast *c = s->c;
    const light_view *l = &c->view;
    uint32_t left = 0;
    const vf rounding = vf_set(t->rounding[i]), bound = vf_set(t->bound[i]);
    for (uint32_t at = 0; at < c->samples->count; at += DAFT_VL) {
        vbits in = bits_at(c->asked, at) & ~bits_at(c->hidden, at);
        if (!in) continue;
        const vf3 p = place_of(c, at);
        const triangle_edges e = edges_at_ray(t, i, ray_of(l, p));
        const vf inverse = vf_set(1) / (e.e0 + e.e1 + e.e2);
        const vf depth =
            (e.e0 * vf_set(t->depth[0][i]) + e.e1 * vf_set(t->depth[1][i]) + e.e2 * vf_set(t->depth[2][i])) * inverse;
        const vf error = vf_abs(vf_set(t->slack[i]) * inverse) + rounding;
        const vm inside = vm_or(vf_lt(bound, e.min), vf_lt(e.max, -bound));
        vbits dark = in & vbits_from_mask(vm_and(inside, vf_lt(depth + error, p.z)));
        if (dark) dark &= ~lie_on_it(s, t->triangle[i], at, dark);
        if (dark) dark &= vbits_from_mask(vf_lt(ends_before(s, p) + rounding, depth));
        c->hidden[at / 32] |= dark << (at % 32);
        left |= in & ~dark;
    }
    return !left;
}

/* ---- a mesh ---- */

/* Lists the leaf blocks whose boxes meet the extent. False: there may be more. */
static bool list_blocks(const shaft *s, leaf list[BLOCKS + DAFT_MAX_LEAF_BLOCKS], uint32_t *count)
{
    const daft_bvh *bvh = s->m.c.instance->bvh;
    const block_set none = {{0}};
    uint32_t stack[NODES * DAFT_WIDTH], looked = 0;
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        if (looked++ == NODES) return false;
        node_boxes boxes;
        const daft_node *node = &bvh->nodes.items[stack[--top]];
        for (uint32_t in = DAFT_KERNEL(daft_node_project)(&s->c->view, &s->m.map, node, &boxes); in; in &= in - 1) {
            const uint32_t child = node->child[__builtin_ctz(in)];
            if (child == DAFT_CHILD_NONE) continue;
            if (!(child & DAFT_CHILD_LEAF))
                stack[top++] = child;
            else if ((*count = list_leaf(bvh, child, &none, list, *count)) > BLOCKS)
                return false;
        }
    }
    return true;
}

/* What is known of some leaf blocks: those that some triangle of which may hide points, by bits. */
typedef struct sifted {
    shaft_answer answer;
    uint32_t blocks;
} sifted;

/* `count` of the leaves' blocks are real. */
static sifted sift_leaves(shaft *s, const leaf *const *leaves, uint32_t count)
{
    lanes t;
    sifted out = {SHAFT_CLEAR, 0};
    const view_corners moved = corners_move(&s->m, leaves);
    vbits live = lanes_name(leaves, count, &t);
    live &= ~beside_extent(s, &moved);
    if (!live) return out;
    lanes_setup(&s->m, &moved, true, &t);
    live &= ~beside_edges(s, &moved, &t);
    const vbits large = live ? large_triangles(s, &t) : 0;
    for (; live; live &= live - 1) {
        const int i = __builtin_ctz(live);
        cast *c = s->c;
        const bool asks = c->tried < TRIANGLES && !c->keeps;
        c->tried += asks;
        if (asks && !may_hide(s, &t, i)) continue;
        c->keeps = true;
        if (large >> i & 1 && c->hiders++ < HIDERS && hide(s, &t, i)) return (sifted){SHAFT_DARK, 0};
        out.answer = SHAFT_SOME, out.blocks |= 1u << i / DAFT_BLOCK;
    }
    return out;
}

static shaft_answer sift_mesh(cast *c, uint32_t number, uint32_t *blocks)
{
    shaft s;
    leaf list[BLOCKS + DAFT_MAX_LEAF_BLOCKS];
    uint32_t count = 0, kept = 0;
    shaft_make(c, number, &s);
    if (!list_blocks(&s, list, &count)) return SHAFT_SOME;
    for (uint32_t i = 0; i < count; i += DAFT_BATCH_BLOCKS) {
        const leaf *leaves[DAFT_BATCH_BLOCKS];
        for (uint32_t k = 0; k < DAFT_BATCH_BLOCKS; k++) leaves[k] = &list[i + k < count ? i + k : i];
        const sifted found = sift_leaves(&s, leaves, count - i);
        if (found.answer == SHAFT_DARK) return SHAFT_DARK;
        for (uint32_t left = found.blocks; left; left &= left - 1)
            list[kept++] = list[i + (uint32_t)__builtin_ctz(left)];
    }
    if (!kept) return SHAFT_CLEAR;
    if (c->shaft_count + kept > SHAFT_ROOM) return SHAFT_SOME;
    for (uint32_t i = 0; i < kept; i++) c->shaft_blocks[c->shaft_count++] = list[i].block;
    *blocks = kept;
    return SHAFT_SOME;
}

shaft_answer DAFT_KERNEL(daft_cast_shaft)(cast *c, uint32_t number, picture_box *box, uint32_t *blocks)
{
    const light_view *l = &c->view;
    const daft_instance *s = &c->tlas->instances[number];
    if (s->mesh) return c->sifted++ < (c->keeps ? KEEPING : MESHES) ? sift_mesh(c, number, blocks) : SHAFT_SOME;
    DAFT_KERNEL(daft_sphere_occluder_box)(l, s, box);
    const bool beside = box->high_u < l->low_u || box->low_u > l->high_u || box->high_v < l->low_v ||
                        box->low_v > l->high_v || box->near > l->far;
    return beside ? SHAFT_CLEAR : SHAFT_SOME;
}
