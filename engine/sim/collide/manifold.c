/* Where two shapes touch: which code a pair needs, and the children of compounds. */
#include "sim/collide/manifold_parts.h"
#include "sim/shape/triangles.h"

daft_relpose daft_relpose_make(const daft_rigid *a, const daft_rigid *b)
{
    daft_rigid relative = daft_rigid_relative(a, b);
    daft_relpose out = {.p = relative.p, .q = daft_rigid_to_local(b, a->p)};
    for (int i = 0; i < 9; i++) out.r[i] = (float)relative.m[i];
    return out;
}

daft_relpose daft_relpose_swapped(const daft_relpose *pose)
{
    const float *r = pose->r;
    return (daft_relpose){{r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}, pose->q, pose->p};
}

static daft_rigid rigid_of(const float r[9], daft_dvec3 p)
{
    daft_rigid out = {.p = p};
    for (int i = 0; i < 9; i++) out.m[i] = (double)r[i];
    return out;
}

/* ---- pairs ---- */

static bool is_solid(const daft_sim_shape *s) { return s->type == DAFT_GEOMETRY_BOX || s->type == DAFT_GEOMETRY_HULL; }

static uint32_t collide_convex(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                               daft_manifold *out, daft_pair_cache *cache)
{
    daft_poly pa, pb;
    bool box_a = a->type == DAFT_GEOMETRY_BOX, box_b = b->type == DAFT_GEOMETRY_BOX;
    uint32_t count;
    out->part_a = out->part_b = (daft_shape_part){0, DAFT_NO_FEATURE};
    if (box_a && box_b) return daft_collide_boxes(a->half, b->half, pose, margin, out, cache);
    if (!is_solid(a) && !is_solid(b)) return daft_collide_rounds(a, b, pose, margin, out);
    bool boxed = (box_a && !is_solid(b)) || (box_b && !is_solid(a));
    if (boxed && daft_collide_round_box(a, b, pose, margin, out, &count)) return count;
    daft_poly_set(&pa, a, NULL);
    daft_poly_set(&pb, b, pose);
    return daft_collide_polys(&pa, &pb, margin, 3, out, cache);
}

uint32_t daft_collide_plain(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_manifold *out, uint32_t capacity, daft_pair_cache *cache)
{
    if (daft_shape_is_convex(b)) return collide_convex(a, b, pose, margin, out, cache);
    daft_sink sink = {out, capacity, 0};
    daft_collide_triangles(a, b, pose, margin, &sink);
    return sink.count;
}

static uint32_t collide_pair(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                             daft_manifold *out, uint32_t capacity, daft_pair_cache *cache)
{
    bool cylinders = daft_shape_is_cylinder(a) || daft_shape_is_cylinder(b);
    return (cylinders ? daft_collide_cylinder : daft_collide_plain)(a, b, pose, margin, out, capacity, cache);
}

static float deepest(const daft_manifold *m)
{
    float least = INFINITY;
    for (uint32_t i = 0; i < m->count; i++)
        if (m->points[i].separation < least) least = m->points[i].separation;
    return least;
}

void daft_sink_put(daft_sink *sink, const daft_manifold *m)
{
    if (sink->count < sink->capacity) {
        sink->out[sink->count++] = *m;
        return;
    }
    uint32_t shallowest = 0;
    for (uint32_t i = 1; i < sink->count; i++)
        if (deepest(&sink->out[i]) > deepest(&sink->out[shallowest])) shallowest = i;
    if (sink->count > 0 && deepest(m) < deepest(&sink->out[shallowest])) sink->out[shallowest] = *m;
}

typedef struct job {
    const daft_sim_shape *a, *b;
    float margin;
    daft_sink *sink;
    daft_pair_cache *cache;
    uint32_t child_a, child_b;
} job;

static void collide_parts(const job *j, const daft_relpose *pose)
{
    daft_sink *sink = j->sink;
    if (j->b->type == DAFT_GEOMETRY_MESH || j->b->type == DAFT_GEOMETRY_FIELD) {
        daft_sink part = {sink->out + sink->count, sink->capacity - sink->count, 0};
        daft_manifold spare[8];
        bool full = part.capacity < DAFT_COUNT_OF(spare);
        if (full) part = (daft_sink){spare, DAFT_COUNT_OF(spare), 0};
        part.count = collide_pair(j->a, j->b, pose, j->margin, part.out, part.capacity, NULL);
        for (uint32_t i = 0; i < part.count; i++) {
            part.out[i].part_a = (daft_shape_part){j->child_a, DAFT_NO_FEATURE};
            part.out[i].part_b.child = j->child_b;
            if (full) daft_sink_put(sink, &part.out[i]);
        }
        if (!full) sink->count += part.count;
        return;
    }
    daft_manifold m;
    if (!collide_pair(j->a, j->b, pose, j->margin, &m, 1, j->cache)) return;
    m.part_a.child = j->child_a, m.part_b.child = j->child_b;
    daft_sink_put(sink, &m);
}

/* ---- compounds ---- */

static bool overlap(const daft_aabb *a, const daft_aabb *b)
{
    return a->low.x <= b->high.x && b->low.x <= a->high.x && a->low.y <= b->high.y && b->low.y <= a->high.y &&
           a->low.z <= b->high.z && b->low.z <= a->high.z;
}

daft_aabb daft_bounds_in(const daft_sim_shape *s, const float r[9], daft_dvec3 p, float margin)
{
    daft_rigid pose = rigid_of(r, p);
    daft_daabb b = daft_shape_bounds(s, &pose);
    /* The float frame turns by 1e-7 more or less than it should; floats round by as much. */
    double most = fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z)));
    double more = (double)margin + 4e-7 * (most + (b.high.x - b.low.x) + (b.high.y - b.low.y) + (b.high.z - b.low.z));
    daft_dvec3 m = daft_dv3(more, more, more);
    return (daft_aabb){daft_to_float(daft_dsub(b.low, m)), daft_to_float(daft_dadd(b.high, m))};
}

/* The next child, from node `from` on, whose bounds overlap: gives the node to go on from, or UINT32_MAX. */
static uint32_t next_child(const daft_compound *c, const daft_aabb *bounds, uint32_t from, uint32_t *child)
{
    uint32_t end = 2 * c->count - 1;
    for (uint32_t i = from; i < end;) {
        const daft_compound_node *n = &c->nodes[i];
        bool hit = overlap(&n->bounds, bounds);
        i = hit || n->second == 0 ? i + 1 : n->skip;
        if (hit && n->second == 0) return *child = n->child, i;
    }
    return UINT32_MAX;
}

static void collide_b(job j, const daft_relpose *pose)
{
    if (j.b->type != DAFT_GEOMETRY_COMPOUND) {
        collide_parts(&j, pose);
        return;
    }
    const daft_compound *c = j.b->compound;
    daft_relpose back = daft_relpose_swapped(pose);
    daft_aabb bounds = daft_bounds_in(j.a, back.r, pose->q, j.margin);
    daft_rigid r = rigid_of(pose->r, daft_dv3(0, 0, 0));
    j.cache = NULL;
    for (uint32_t i = 0; (i = next_child(c, &bounds, i, &j.child_b)) != UINT32_MAX;) {
        const daft_child *child = &c->children[j.child_b];
        daft_rigid turned = daft_rigid_mul(&r, &child->pose);
        daft_relpose inner = {.q = daft_rigid_to_local(&child->pose, pose->q)};
        for (int k = 0; k < 9; k++) inner.r[k] = (float)turned.m[k];
        turned.p = daft_dv3(0, 0, 0);
        inner.p = daft_dscale(daft_rigid_vector(&turned, inner.q), -1);
        j.b = &child->shape;
        collide_parts(&j, &inner);
    }
}

static void move_manifold(const daft_rigid *pose, daft_manifold *m)
{
    m->normal = daft_to_float(daft_rigid_vector(pose, daft_to_double(m->normal)));
    for (uint32_t i = 0; i < m->count; i++)
        m->points[i].point = daft_to_float(daft_rigid_point(pose, daft_to_double(m->points[i].point)));
}

static void collide_a(job j, const daft_relpose *pose)
{
    if (j.a->type != DAFT_GEOMETRY_COMPOUND) {
        collide_b(j, pose);
        return;
    }
    const daft_compound *c = j.a->compound;
    daft_rigid b_in_a = rigid_of(pose->r, pose->p);
    daft_aabb bounds = daft_bounds_in(j.b, pose->r, pose->p, j.margin);
    j.cache = NULL;
    for (uint32_t i = 0; (i = next_child(c, &bounds, i, &j.child_a)) != UINT32_MAX;) {
        const daft_child *child = &c->children[j.child_a];
        daft_rigid relative = daft_rigid_relative(&child->pose, &b_in_a);
        daft_relpose inner = {.p = relative.p};
        inner.q = daft_dadd(pose->q, daft_rigid_to_local_vector(&b_in_a, child->pose.p));
        for (int k = 0; k < 9; k++) inner.r[k] = (float)relative.m[k];
        daft_manifold found[32];
        daft_sink sink = {found, DAFT_COUNT_OF(found), 0};
        job one = j;
        one.a = &child->shape, one.sink = &sink;
        collide_b(one, &inner);
        for (uint32_t k = 0; k < sink.count; k++) {
            move_manifold(&child->pose, &found[k]);
            daft_sink_put(j.sink, &found[k]);
        }
    }
}

/* ---- all ---- */

static bool comes_before(const daft_manifold *x, const daft_manifold *y)
{
    if (x->part_a.child != y->part_a.child) return x->part_a.child < y->part_a.child;
    if (x->part_b.child != y->part_b.child) return x->part_b.child < y->part_b.child;
    return x->part_b.triangle < y->part_b.triangle;
}

static void sort(daft_manifold *m, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        daft_manifold moved = m[i];
        uint32_t k = i;
        for (; k > 0 && comes_before(&moved, &m[k - 1]); k--) m[k] = m[k - 1];
        m[k] = moved;
    }
}

/* a is the one with triangles: the same from the other side. */
static uint32_t collide_swapped(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose,
                                float margin, daft_manifold *out, uint32_t capacity)
{
    daft_relpose swapped = daft_relpose_swapped(pose);
    daft_rigid b_in_a = rigid_of(pose->r, pose->p);
    uint32_t count = daft_collide(b, a, &swapped, margin, out, capacity, NULL);
    for (uint32_t i = 0; i < count; i++) {
        daft_manifold *m = &out[i];
        daft_shape_part part = m->part_a;
        move_manifold(&b_in_a, m);
        m->normal = daft_neg(m->normal);
        m->part_a = m->part_b, m->part_b = part;
    }
    return count;
}

uint32_t daft_collide(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *b_in_a, float margin,
                      daft_manifold *out, uint32_t capacity, daft_pair_cache *cache)
{
    if (capacity == 0 || !daft_dfinite3(b_in_a->p) || !daft_dfinite3(b_in_a->q) || !(margin >= 0)) return 0;
    if (daft_shape_is_convex(a) && daft_shape_is_convex(b))
        return collide_pair(a, b, b_in_a, margin, out, capacity, cache);
    if (!daft_shape_has_mass(a)) {
        if (!daft_shape_has_mass(b)) return 0;
        return collide_swapped(a, b, b_in_a, margin, out, capacity);
    }
    daft_sink sink = {out, capacity, 0};
    job j = {.a = a, .b = b, .margin = margin, .sink = &sink, .cache = NULL};
    collide_a(j, b_in_a);
    sort(out, sink.count);
    return sink.count;
}
