/* Contacts with the triangles of meshes and height fields, without ghosts.
 *
 * Each triangle near the body is a convex pair of its own. But a triangle alone does not know that the surface goes on
 * past its edge, and so pushes what slides over that edge sideways. A contact normal that leaves the triangle's own
 * leans over one or two of its edges; what lies across decides (the Voronoi regions of a mesh; compare Bullet's
 * btInternalEdgeUtility, and Gregorius, GDC 2015): flat, concave   no point of this triangle's can be the surface's
 * nearest: the contact is made along the face instead convex          allowed between the normals of both triangles,
 * else along the face border          allowed, unless the contact lies on another triangle that bears the body with its
 * face (a T-junction)
 *
 * Contacts of coplanar triangles are put together in one manifold of at most four points. */
#include "sim/manifold_parts.h"
#include "sim/triangles.h"

/* A normal that leans by less than this (the sine) is the face's. */
#define LEAN 2e-3f
/* Manifolds whose normals' cosine is over this are one. */
#define SAME 0.99995f

enum { MAX_DEFERRED = 64, MAX_BEARING = 64 };

typedef struct near_triangle {
    uint32_t number;
    daft_vec3 corners[3]; /* in the body's frame */
    daft_vec3 normal;
} near_triangle;

typedef struct deferred {
    near_triangle triangle;
    daft_manifold manifold;
    uint32_t side;
} deferred;

typedef struct contact_job {
    const daft_sim_shape *surface;
    const daft_relpose *pose;
    float margin;
    daft_aabb bounds; /* of the body, in the surface's frame */
    daft_sink *sink;
    bool one_sided;
    daft_poly body, face;
    deferred waiting[MAX_DEFERRED]; /* contacts that lean over borders */
    uint32_t waiting_count;
    near_triangle bearing[MAX_BEARING]; /* triangles that bear the body by their faces */
    uint32_t bearing_count;
} contact_job;

/* ---- coplanar contacts in one manifold ---- */

static uint32_t mixed_id(uint32_t id, uint32_t triangle)
{
    return id ^ (triangle + 1) * 0x9e3779b1u;
}

static void merge(daft_manifold *into, const daft_manifold *from)
{
    daft_manifold_point all[2 * DAFT_MANIFOLD_POINTS];
    daft_clip_point laid[2 * DAFT_MANIFOLD_POINTS];
    uint32_t count = 0;
    daft_vec3 n = into->normal, axis = fabsf(n.x) < 0.6f ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0);
    daft_vec3 u = daft_normalize(daft_cross(axis, n)), v = daft_cross(n, u);
    for (uint32_t i = 0; i < into->count; i++) all[count++] = into->points[i];
    for (uint32_t i = 0; i < from->count; i++) all[count++] = from->points[i];
    float spread = 0;
    for (uint32_t i = 0; i < count; i++) {
        daft_vec3 d = daft_sub(all[i].point, all[0].point);
        laid[i] = (daft_clip_point){daft_dot(u, d), daft_dot(v, d), all[i].separation, i};
        spread = fmaxf(spread, fabsf(laid[i].u) + fabsf(laid[i].v));
    }
    into->count = daft_clip_reduce(laid, count, 1e-3f * spread);
    for (uint32_t i = 0; i < into->count; i++) into->points[i] = all[laid[i].id];
    if (from->part_b.triangle < into->part_b.triangle) into->part_b.triangle = from->part_b.triangle;
    if (from->feature_a < into->feature_a) into->feature_a = from->feature_a;
    if (from->feature_b < into->feature_b) into->feature_b = from->feature_b, into->face_b = from->face_b;
}

static void put(contact_job *j, daft_manifold *m, uint32_t triangle)
{
    m->part_a = (daft_shape_part){0, DAFT_NO_FEATURE};
    m->part_b = (daft_shape_part){0, triangle};
    for (uint32_t i = 0; i < m->count; i++) m->points[i].id = mixed_id(m->points[i].id, triangle);
    for (uint32_t i = 0; i < j->sink->count; i++) {
        if (daft_dot(j->sink->out[i].normal, m->normal) <= SAME) continue;
        merge(&j->sink->out[i], m);
        return;
    }
    daft_sink_put(j->sink, m);
}

/* ---- along a triangle's face ---- */

static void bears(contact_job *j, const near_triangle *t)
{
    if (j->bearing_count < MAX_BEARING) j->bearing[j->bearing_count++] = *t;
}

/* side: 0 the front, 1 the back. */
static void put_face_contact(contact_job *j, const near_triangle *t, uint32_t side)
{
    daft_manifold m;
    float lowest = INFINITY;
    daft_plane plane = j->face.planes[side];
    for (uint32_t i = 0; i < j->body.vertex_count; i++)
        lowest = fminf(lowest, daft_dot(plane.normal, j->body.vertices[i]) - plane.offset);
    /* Deeper than the body is large: it is on the other side of a sheet, or past its rim. */
    if (!j->one_sided && lowest < -(2 * j->body.size + j->body.radius)) return;
    daft_axis axis = {DAFT_AXIS_FACE_B, 0, side, lowest, daft_neg(plane.normal)};
    if (!daft_manifold_along(&j->body, &j->face, &axis, j->margin, &m)) return;
    bears(j, t);
    put(j, &m, t->number);
}

/* ---- edges ---- */

static daft_vec3 in_body(const contact_job *j, daft_vec3 v)
{
    daft_vec3 d = daft_to_float(daft_dsub(daft_to_double(v), j->pose->q));
    const float *r = j->pose->r;
    return daft_v3((r[0] * d.x + r[1] * d.y) + r[2] * d.z, (r[3] * d.x + r[4] * d.y) + r[5] * d.z,
                   (r[6] * d.x + r[7] * d.y) + r[8] * d.z);
}

/* Unit, in the plane of an edge and a point, across the edge, away from the point. */
static daft_vec3 away_from(daft_vec3 from, daft_vec3 to, daft_vec3 point)
{
    daft_vec3 d = daft_normalize(daft_sub(to, from)), w = daft_sub(from, point);
    return daft_normalize(daft_sub(w, daft_scale(d, daft_dot(w, d))));
}

typedef enum verdict { ALLOWED, AT_BORDER, FORBIDDEN } verdict;

/* `away`: the contact's direction from the triangle to the body. side: which one it is on. */
static verdict judge(const contact_job *j, const near_triangle *t, daft_vec3 away, uint32_t side)
{
    verdict out = ALLOWED;
    for (uint32_t k = 0; k < 3; k++) {
        daft_vec3 from = t->corners[k], to = t->corners[(k + 1) % 3], beyond;
        if (daft_dot(away, away_from(from, to, t->corners[(k + 2) % 3])) <= LEAN) continue;
        daft_edge_kind kind = daft_triangle_edge(j->surface, t->number, k, &beyond);
        if (kind == DAFT_EDGE_BORDER) {
            out = AT_BORDER;
            continue;
        }
        /* From behind, valleys are ridges. */
        if (side == 1 && kind != DAFT_EDGE_FLAT) kind = kind == DAFT_EDGE_CONVEX ? DAFT_EDGE_CONCAVE : DAFT_EDGE_CONVEX;
        if (kind != DAFT_EDGE_CONVEX) return FORBIDDEN;
        if (daft_dot(away, away_from(from, to, in_body(j, beyond))) < -LEAN) return FORBIDDEN;
    }
    return out;
}

/* Which side of the triangle a contact is on: where its normal points, or if that is along the sheet, where the body
 * is. */
static uint32_t side_of(const contact_job *j, const near_triangle *t, daft_vec3 away)
{
    if (j->one_sided) return 0;
    float along = daft_dot(away, t->normal);
    if (fabsf(along) < 0.1f) along = daft_dot(t->normal, daft_sub(j->body.centre, t->corners[0]));
    return along < 0;
}

static void take_triangle(void *context, uint32_t number)
{
    contact_job *j = context;
    near_triangle t = {.number = number};
    daft_vec3 own[3];
    if (!daft_triangle_get(j->surface, number, own)) return;
    daft_vec3 low = daft_min3(own[0], daft_min3(own[1], own[2])), high = daft_max3(own[0], daft_max3(own[1], own[2]));
    if (low.x > j->bounds.high.x || low.y > j->bounds.high.y || low.z > j->bounds.high.z) return;
    if (high.x < j->bounds.low.x || high.y < j->bounds.low.y || high.z < j->bounds.low.z) return;
    for (int k = 0; k < 3; k++) t.corners[k] = in_body(j, own[k]);
    const float *r = j->pose->r;
    daft_vec3 n = daft_to_float(daft_triangle_normal(own));
    t.normal = daft_v3((r[0] * n.x + r[1] * n.y) + r[2] * n.z, (r[3] * n.x + r[4] * n.y) + r[5] * n.z,
                       (r[6] * n.x + r[7] * n.y) + r[8] * n.z);
    daft_poly_set_triangle(&j->face, t.corners, t.normal);

    daft_manifold m;
    if (!daft_collide_polys(&j->body, &j->face, j->margin, j->one_sided ? 1 : 3, &m, NULL)) return;
    daft_vec3 away = daft_neg(m.normal);
    uint32_t side = side_of(j, &t, away);
    float along = daft_dot(away, t.normal) * (side ? -1.0f : 1.0f);
    if (along > 1 - LEAN * LEAN) {
        bears(j, &t);
        put(j, &m, number);
        return;
    }
    verdict v = j->one_sided && along < -LEAN ? FORBIDDEN : judge(j, &t, away, side);
    m.face_b = side ? daft_neg(t.normal) : t.normal;
    if (v == ALLOWED)
        put(j, &m, number);
    else if (v == AT_BORDER && j->waiting_count < MAX_DEFERRED)
        j->waiting[j->waiting_count++] = (deferred){t, m, side};
    else
        put_face_contact(j, &t, side);
}

/* ---- borders ---- */

/* Whether a point lies on the triangle or its rim. */
static bool lies_on(const near_triangle *t, daft_vec3 p, float tolerance)
{
    if (fabsf(daft_dot(t->normal, daft_sub(p, t->corners[0]))) > tolerance) return false;
    for (uint32_t k = 0; k < 3; k++) {
        daft_vec3 from = t->corners[k], to = t->corners[(k + 1) % 3];
        if (daft_dot(away_from(from, to, t->corners[(k + 2) % 3]), daft_sub(p, from)) > tolerance) return false;
    }
    return true;
}

static void settle_border(contact_job *j, deferred *d)
{
    const daft_manifold_point *p = &d->manifold.points[0];
    /* The point on the triangle: from midway along the normal, which goes from the body to the triangle. */
    daft_vec3 on = daft_add(p->point, daft_scale(d->manifold.normal, 0.5f * p->separation));
    float tolerance = 1e-3f * (j->body.size + j->body.radius) + fabsf(p->separation) * 0.01f;
    for (uint32_t i = 0; i < j->bearing_count; i++) {
        const near_triangle *t = &j->bearing[i];
        if (t->number == d->triangle.number || !lies_on(t, on, tolerance)) continue;
        daft_poly_set_triangle(&j->face, d->triangle.corners, d->triangle.normal);
        put_face_contact(j, &d->triangle, d->side);
        return;
    }
    put(j, &d->manifold, d->triangle.number);
}

void daft_collide_triangles(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_sink *sink)
{
    contact_job j;
    daft_relpose back = daft_relpose_swapped(pose);
    j.surface = b, j.pose = pose, j.margin = margin, j.sink = sink;
    j.one_sided = b->type == DAFT_GEOMETRY_FIELD || b->mesh->one_sided;
    j.waiting_count = j.bearing_count = 0;
    j.bounds = daft_bounds_in(a, back.r, pose->q, margin);
    daft_poly_set(&j.body, a, NULL);
    daft_triangles_query(b, &j.bounds, take_triangle, &j);
    uint32_t bearing = j.bearing_count; /* what borders bear does not decide about other borders */
    for (uint32_t i = 0; i < j.waiting_count; i++) {
        j.bearing_count = bearing;
        settle_border(&j, &j.waiting[i]);
    }
}
