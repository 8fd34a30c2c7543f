/* Rays against every shape, in the shape's frame, in double. */
#include "sim/shape/triangles.h"

typedef struct ray {
    daft_dvec3 o, d;
    double tmax;          /* where it ends now: at the nearest hit */
    daft_dvec3 normal;    /* not turned to the ray */
    daft_shape_part part; /* of the hit */
    bool hit;
    const daft_sim_shape *surface;
    uint32_t child;
} ray;

static void take(ray *r, double t, daft_dvec3 normal, uint32_t triangle)
{
    if (!(t >= 0 && t <= r->tmax) || (r->hit && t >= r->tmax)) return;
    r->tmax = t;
    r->normal = normal;
    r->part = (daft_shape_part){r->child, triangle};
    r->hit = true;
}

/* The nearer hit of a sphere around c, by the discriminant that does not cancel (Haines et al., Ray Tracing Gems 2019,
 * 7). */
static void try_sphere(ray *r, daft_dvec3 c, double radius)
{
    daft_dvec3 f = daft_dsub(r->o, c);
    double a = daft_ddot(r->d, r->d), b = -daft_ddot(f, r->d);
    if (daft_ddot(f, f) <= radius * radius) {
        take(r, 0, daft_dscale(r->d, -1), DAFT_NO_FEATURE);
        return;
    }
    daft_dvec3 across = daft_dadd(f, daft_dscale(r->d, b / a));
    double rest = radius * radius - daft_ddot(across, across);
    if (rest < 0 || b < 0) return;
    double q = b + sqrt(a * rest), t = (daft_ddot(f, f) - radius * radius) / q;
    take(r, t, daft_dadd(f, daft_dscale(r->d, t)), DAFT_NO_FEATURE);
}

/* The round side; its ends are spheres. */
static void try_capsule(ray *r, double half, double radius)
{
    daft_dvec3 f = daft_dv3(r->o.x, 0, r->o.z), d = daft_dv3(r->d.x, 0, r->d.z);
    double a = daft_ddot(d, d), b = -daft_ddot(f, d), outside = daft_ddot(f, f) - radius * radius;
    if (outside <= 0 && fabs(r->o.y) <= half) {
        take(r, 0, daft_dscale(r->d, -1), DAFT_NO_FEATURE);
        return;
    }
    if (a > 0 && outside > 0) {
        daft_dvec3 across = daft_dadd(f, daft_dscale(d, b / a));
        double rest = radius * radius - daft_ddot(across, across);
        if (rest >= 0 && b >= 0) {
            double t = outside / (b + sqrt(a * rest)), y = r->o.y + t * r->d.y;
            if (fabs(y) <= half) take(r, t, daft_dadd(f, daft_dscale(d, t)), DAFT_NO_FEATURE);
        }
    }
    try_sphere(r, daft_dv3(0, -half, 0), radius);
    try_sphere(r, daft_dv3(0, half, 0), radius);
}

/* What is left of a ray behind planes. */
typedef struct stretch {
    double first, last;
    daft_dvec3 normal;
} stretch;

static bool cut(const ray *r, daft_dvec3 n, double offset, stretch *s)
{
    double height = daft_ddot(n, r->o) - offset, fall = -daft_ddot(n, r->d);
    if (fall == 0) return height <= 0;
    double t = height / fall;
    if (fall > 0) {
        if (t > s->first) s->first = t, s->normal = n;
    } else if (t < s->last) {
        s->last = t;
    }
    return s->first <= s->last;
}

static void try_planes(ray *r, const daft_sim_shape *shape)
{
    stretch s = {0, r->tmax, daft_dscale(r->d, -1)};
    if (shape->type == DAFT_GEOMETRY_HULL) {
        for (uint32_t i = 0; i < shape->hull->face_count; i++) {
            const daft_plane *p = &shape->hull->planes[i];
            if (!cut(r, daft_to_double(p->normal), (double)p->offset, &s)) return;
        }
    } else {
        for (int i = 0; i < 6; i++) {
            double sign = i & 1 ? 1 : -1;
            daft_dvec3 n = daft_dv3(i / 2 == 0 ? sign : 0, i / 2 == 1 ? sign : 0, i / 2 == 2 ? sign : 0);
            if (!cut(r, n, (double)daft_v3_at(shape->half, i / 2), &s)) return;
        }
    }
    take(r, s.first, s.normal, DAFT_NO_FEATURE);
}

/* Möller and Trumbore (1997), with its edges a rounding error wide, so that rays do not slip between triangles. */
static void visit_triangle(void *context, uint32_t triangle)
{
    ray *r = context;
    daft_vec3 corners[3];
    if (!daft_triangle_get(r->surface, triangle, corners)) return;
    daft_dvec3 a = daft_to_double(corners[0]), u = daft_dsub(daft_to_double(corners[1]), a);
    daft_dvec3 v = daft_dsub(daft_to_double(corners[2]), a), p = daft_dcross(r->d, v), n = daft_dcross(u, v);
    double det = daft_ddot(u, p), slack = 1e-10 * fabs(det);
    if (det == 0) return;
    double sign = det < 0 ? -1 : 1;
    daft_dvec3 s = daft_dsub(r->o, a), q = daft_dcross(s, u);
    double bu = sign * daft_ddot(s, p), bv = sign * daft_ddot(r->d, q);
    if (bu < -slack || bv < -slack || bu + bv > fabs(det) + slack) return;
    take(r, daft_ddot(v, q) / det, n, triangle);
}

static void try_shape(ray *r, const daft_sim_shape *s);

static void try_compound(ray *r, const daft_compound *c)
{
    for (uint32_t i = 0; i < 2 * c->count - 1;) {
        const daft_compound_node *n = &c->nodes[i];
        double enter;
        bool may = daft_sweep_meets(r->o, r->d, daft_dv3(0, 0, 0), daft_to_double(n->bounds.low),
                                    daft_to_double(n->bounds.high), r->tmax, &enter);
        i = may || n->second == 0 ? i + 1 : n->skip;
        if (!may || n->second) continue;
        const daft_child *child = &c->children[n->child];
        ray inner = {.tmax = r->tmax, .child = n->child};
        inner.o = daft_rigid_to_local(&child->pose, r->o);
        inner.d = daft_rigid_to_local_vector(&child->pose, r->d);
        try_shape(&inner, &child->shape);
        if (!inner.hit || (r->hit && inner.tmax >= r->tmax)) continue;
        r->hit = true;
        r->tmax = inner.tmax;
        r->part = inner.part;
        r->normal = daft_rigid_vector(&child->pose, inner.normal);
    }
}

static void try_shape(ray *r, const daft_sim_shape *s)
{
    switch (s->type) {
    case DAFT_GEOMETRY_SPHERE: try_sphere(r, daft_dv3(0, 0, 0), (double)s->radius); break;
    case DAFT_GEOMETRY_CAPSULE: try_capsule(r, (double)s->half_height, (double)s->radius); break;
    case DAFT_GEOMETRY_BOX:
    case DAFT_GEOMETRY_HULL: try_planes(r, s); break;
    case DAFT_GEOMETRY_MESH:
    case DAFT_GEOMETRY_FIELD:
        r->surface = s;
        daft_triangles_sweep(s, r->o, r->d, daft_dv3(0, 0, 0), &r->tmax, visit_triangle, r);
        break;
    case DAFT_GEOMETRY_COMPOUND: try_compound(r, s->compound); break;
    case DAFT_GEOMETRY_NONE: break;
    }
}

bool daft_shape_raycast(const daft_sim_shape *s, daft_dvec3 origin, daft_dvec3 direction, double tmax,
                        daft_ray_result *out)
{
    double square = daft_ddot(direction, direction);
    if (!daft_dfinite3(origin) || !(square > 0) || !isfinite(square) || !(tmax >= 0)) return false;
    double length = sqrt(square); /* a unit direction inside, so that tiny and huge ones do not underflow */
    ray r = {.o = origin, .d = daft_dscale(direction, 1 / length), .tmax = tmax * length};
    try_shape(&r, s);
    if (!r.hit) return false;
    double size = sqrt(daft_ddot(r.normal, r.normal));
    double turn = daft_ddot(r.normal, direction) > 0 ? -1 : 1;
    out->t = r.tmax / length;
    out->normal = daft_to_float(daft_dscale(r.normal, turn / size));
    out->part = r.part;
    return true;
}
