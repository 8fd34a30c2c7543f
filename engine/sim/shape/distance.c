/* Distance, overlap and closest points of all shapes: GJK for each pair of convex parts that may be the nearest. */
#include "sim/shape/gjk.h"

typedef struct search {
    const daft_sim_shape *surface; /* mesh or field */
    daft_rigid b_in_a;             /* of the parts at hand */
    daft_proxy a;
    daft_aabb bounds; /* of a in the surface's frame, grown by the limit */
    daft_distance *best;
    bool found;
    uint32_t child_a, child_b;
} search;

/* Takes a pair of cores if it is nearer than what is known. */
static void try_pair(search *s, const daft_proxy *b, uint32_t triangle)
{
    daft_gjk g;
    double rounding = s->a.radius + b->radius;
    if (!daft_gjk_distance(&s->a, b, &s->b_in_a, s->best->distance + rounding, &g)) return;
    double distance = fmax(g.distance - rounding, 0);
    if (s->found && distance >= s->best->distance) return;
    s->found = true;
    s->best->distance = distance;
    s->best->normal = g.normal;
    s->best->on_a = daft_dadd(g.on_a, daft_dscale(g.normal, s->a.radius));
    s->best->on_b = daft_dsub(g.on_b, daft_dscale(g.normal, b->radius));
    s->best->part_a = (daft_shape_part){s->child_a, DAFT_NO_FEATURE};
    s->best->part_b = (daft_shape_part){s->child_b, triangle};
}

static void visit_triangle(void *context, uint32_t triangle)
{
    search *s = context;
    daft_vec3 corners[3];
    if (!daft_triangle_get(s->surface, triangle, corners)) return;
    daft_vec3 low = daft_min3(corners[0], daft_min3(corners[1], corners[2]));
    daft_vec3 high = daft_max3(corners[0], daft_max3(corners[1], corners[2]));
    if (low.x > s->bounds.high.x || low.y > s->bounds.high.y || low.z > s->bounds.high.z) return;
    if (high.x < s->bounds.low.x || high.y < s->bounds.low.y || high.z < s->bounds.low.z) return;
    daft_proxy b = daft_proxy_triangle(corners);
    try_pair(s, &b, triangle);
}

static daft_aabb grown(const daft_daabb *b, double by)
{
    double more = by + 1e-6 * (by + fabs(b->low.x) + fabs(b->low.y) + fabs(b->low.z) + fabs(b->high.x) +
                               fabs(b->high.y) + fabs(b->high.z));
    daft_dvec3 m = daft_dv3(more, more, more);
    return (daft_aabb){daft_to_float(daft_dsub(b->low, m)), daft_to_float(daft_dadd(b->high, m))};
}

static double gap_of_bounds(const daft_daabb *a, const daft_daabb *b, bool farthest)
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        double al = daft_dv3_at(a->low, k), ah = daft_dv3_at(a->high, k), bl = daft_dv3_at(b->low, k),
               bh = daft_dv3_at(b->high, k);
        double d = farthest ? fmax(ah - bl, bh - al) : fmax(0, fmax(bl - ah, al - bh));
        square += d * d;
    }
    return sqrt(square);
}

/* Looks in bounds that double until what is found is nearer than they reach. */
static void try_surface(search *s, const daft_sim_shape *a, const daft_sim_shape *b)
{
    daft_rigid a_in_b = daft_rigid_inverse(&s->b_in_a), identity = daft_rigid_identity();
    daft_daabb own = daft_shape_bounds(a, &a_in_b), all = daft_shape_bounds(b, &identity);
    double least = gap_of_bounds(&own, &all, false), most = gap_of_bounds(&own, &all, true);
    double reach = least + 0.05 * (most - least) + 1e-9;
    s->surface = b;
    if (least > s->best->distance) return;
    for (;;) {
        bool last = reach >= s->best->distance || reach >= most;
        if (reach > s->best->distance) reach = s->best->distance;
        s->bounds = grown(&own, reach);
        daft_triangles_query(b, &s->bounds, visit_triangle, s);
        if (last || (s->found && s->best->distance <= reach)) return;
        reach *= 2;
    }
}

static void try_parts(search *s, const daft_sim_shape *a, const daft_sim_shape *b)
{
    s->a = daft_proxy_of(a);
    if (b->type == DAFT_GEOMETRY_MESH || b->type == DAFT_GEOMETRY_FIELD) {
        try_surface(s, a, b);
    } else {
        daft_proxy proxy = daft_proxy_of(b);
        try_pair(s, &proxy, DAFT_NO_FEATURE);
    }
}

static void try_b(search *s, const daft_sim_shape *a, const daft_sim_shape *b, const daft_rigid *b_in_a)
{
    s->b_in_a = *b_in_a;
    if (b->type != DAFT_GEOMETRY_COMPOUND) {
        try_parts(s, a, b);
        return;
    }
    const daft_compound *c = b->compound;
    daft_rigid a_in_b = daft_rigid_inverse(b_in_a);
    daft_daabb own = daft_shape_bounds(a, &a_in_b);
    for (uint32_t i = 0; i < 2 * c->count - 1;) {
        const daft_compound_node *n = &c->nodes[i];
        daft_daabb bounds = {daft_to_double(n->bounds.low), daft_to_double(n->bounds.high)};
        bool may = gap_of_bounds(&own, &bounds, false) <= s->best->distance;
        i = may || n->second == 0 ? i + 1 : n->skip;
        if (!may || n->second) continue;
        s->child_b = n->child;
        s->b_in_a = daft_rigid_mul(b_in_a, &c->children[n->child].pose);
        try_parts(s, a, &c->children[n->child].shape);
    }
}

/* The parts' frames are those of children of a; out of them. */
static void move_distance(const daft_rigid *pose, daft_distance *d)
{
    d->on_a = daft_rigid_point(pose, d->on_a);
    d->on_b = daft_rigid_point(pose, d->on_b);
    d->normal = daft_rigid_vector(pose, d->normal);
}

bool daft_shape_distance(const daft_sim_shape *a, const daft_sim_shape *b, const daft_rigid *b_in_a, double limit,
                         daft_distance *out)
{
    if (!(limit >= 0) || !daft_dfinite3(b_in_a->p)) return false;
    if (!daft_shape_has_mass(a)) {
        if (!daft_shape_has_mass(b)) return false;
        daft_rigid a_in_b = daft_rigid_inverse(b_in_a);
        if (!daft_shape_distance(b, a, &a_in_b, limit, out)) return false;
        move_distance(b_in_a, out);
        daft_distance d = *out;
        out->on_a = d.on_b, out->on_b = d.on_a, out->part_a = d.part_b, out->part_b = d.part_a;
        out->normal = daft_dscale(d.normal, -1);
        return true;
    }
    search s = {.best = out};
    *out = (daft_distance){.distance = limit};
    if (a->type != DAFT_GEOMETRY_COMPOUND) {
        try_b(&s, a, b, b_in_a);
        return s.found;
    }
    for (uint32_t i = 0; i < a->compound->count; i++) {
        const daft_child *child = &a->compound->children[i];
        daft_rigid inner = daft_rigid_relative(&child->pose, b_in_a);
        daft_distance found = *out;
        search one = {.best = &found, .child_a = i};
        try_b(&one, &child->shape, b, &inner);
        if (!one.found || (s.found && found.distance >= out->distance)) continue;
        move_distance(&child->pose, &found);
        *out = found;
        s.found = true;
    }
    return s.found;
}

bool daft_shape_overlap(const daft_sim_shape *a, const daft_sim_shape *b, const daft_rigid *b_in_a, double margin)
{
    daft_distance d;
    return daft_shape_distance(a, b, b_in_a, margin, &d);
}

bool daft_shape_closest(const daft_sim_shape *s, daft_dvec3 point, double limit, daft_dvec3 *on_shape, double *distance,
                        daft_shape_part *part)
{
    daft_sim_shape dot = {.type = DAFT_GEOMETRY_SPHERE};
    daft_rigid at = daft_rigid_identity();
    daft_distance d;
    at.p = daft_dscale(point, -1); /* the shape as seen from the point */
    if (!daft_shape_distance(&dot, s, &at, limit, &d)) return false;
    *distance = d.distance;
    *on_shape = d.distance > 0 ? daft_dadd(d.on_b, point) : point;
    *part = d.part_b;
    return true;
}
