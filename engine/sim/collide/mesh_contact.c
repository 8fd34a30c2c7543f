/* Contacts with the triangles of meshes and height fields, without ghosts.
 *
 * Each triangle near the body is a convex pair of its own. But a triangle alone does not know that the surface goes on
 * past its edge, and so pushes what slides over that edge sideways. A contact whose direction d, from the triangle to
 * the body, leaves the triangle's normal stands on an edge or a corner. It is one of the surface's own only if the
 * surface does not go on towards d from there: if no other corner of the triangles around that edge or corner is
 * farther along d (their Voronoi regions; compare Gregorius, GDC 2015, and Bullet's btInternalEdgeUtility). Flat and
 * hollow edges never pass, ridges do for what lies between their two normals. What does not pass becomes a contact
 * along the face. At a border it passes unless it lies on another triangle that bears the body with its face (a
 * T-junction, or a mesh of loose triangles).
 *
 * Contacts of coplanar triangles are put together in one manifold: of all points those that are farthest in eight
 * directions and the deepest, which do not depend on the order of triangles, and of these four. */
#include "sim/collide/manifold_parts.h"
#include "sim/shape/triangles.h"

/* A normal that leans by less than this (the sine) is the face's. */
#define LEAN 2e-3f
/* One whose cosine with the face's is over this (a degree) is made the face's, if there are points over the face. */
#define FACE 0.9998f
/* Manifolds whose normals' cosine is over this are one. */
#define SAME 0.99995f

/* Points within this fraction of it of the deepest are as deep. */
#define EVEN 1e-3f
/* Points of one manifold that are nearer to each other than this fraction of the body's size are one. */
#define CLOSE 5e-3f

enum { MAX_TURNED = 128, MAX_CLUSTERS = 32, DIRECTIONS = 8, MAX_RING = 64 };

/* Contacts with one normal. */
typedef struct cluster {
    daft_manifold manifold; /* but for its points */
    bool face;              /* the normal is a triangle's own */
    daft_vec3 u, v;
    daft_manifold_point points[DIRECTIONS + 1]; /* farthest in each direction; the deepest */
    float scores[DIRECTIONS + 1];
} cluster;

typedef struct near_triangle {
    uint32_t number;
    daft_vec3 corners[3]; /* in the body's frame */
    daft_vec3 normal;
} near_triangle;

/* A contact that is to be made along the face, on this side. */
typedef struct turned {
    near_triangle triangle;
    uint32_t side;
} turned;

typedef struct contact_job {
    const daft_sim_shape *surface;
    const daft_relpose *pose;
    float margin;
    daft_aabb bounds; /* of the body, in the surface's frame */
    double far;       /* of balls: a triangle that is farther from the centre is not met */
    bool one_sided;
    daft_poly body, face;
    daft_face_frame frame; /* of the last face */
    turned turned[MAX_TURNED];
    uint32_t turned_count;
    daft_manifold last_resort; /* the shallowest overlap of those that did not pass */
    uint32_t last_triangle;
    float deepest; /* separation of the deepest contact that passed; INFINITY: none yet */
    cluster clusters[MAX_CLUSTERS];
    uint32_t cluster_count;
} contact_job;

/* ---- coplanar contacts in one manifold ---- */

static uint32_t mixed_id(uint32_t id, uint32_t triangle) { return id ^ (triangle + 1) * 0x9e3779b1u; }

static const float directions[DIRECTIONS][2] = {{1, 0.1f},   {0.65f, 0.78f},   {-0.1f, 1}, {-0.78f, 0.65f},
                                                {-1, -0.1f}, {-0.65f, -0.78f}, {0.1f, -1}, {0.78f, -0.65f}};

/* Equal scores, as of a corner that two triangles share: the lower triangle's stays, whichever came first. */
static void offer(cluster *c, uint32_t slot, const daft_manifold_point *p, float score)
{
    if (score > c->scores[slot] || (score >= c->scores[slot] && p->id < c->points[slot].id))
        c->scores[slot] = score, c->points[slot] = *p;
}

static void add_points(cluster *c, const daft_manifold_point *points, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const daft_manifold_point *p = &points[i];
        float u = daft_dot(c->u, p->point), v = daft_dot(c->v, p->point);
        for (uint32_t k = 0; k < DIRECTIONS; k++) offer(c, k, p, directions[k][0] * u + directions[k][1] * v);
        offer(c, DIRECTIONS, p, -p->separation);
    }
}

static void cluster_set(cluster *c, const daft_manifold *m, bool face, const daft_manifold_point *points,
                        uint32_t count)
{
    daft_vec3 n = m->normal, axis = fabsf(n.x) < 0.6f ? daft_v3(1, 0, 0) : daft_v3(0, 1, 0);
    c->manifold = *m, c->face = face;
    c->u = daft_normalize(daft_cross(axis, n));
    c->v = daft_cross(n, c->u);
    for (int k = 0; k <= DIRECTIONS; k++) c->scores[k] = -INFINITY;
    add_points(c, points, count);
}

/* face: it is along the triangle's. */
static void put(contact_job *j, daft_manifold *m, bool face, daft_manifold_point *points, uint32_t count,
                uint32_t triangle)
{
    m->part_a = (daft_shape_part){0, DAFT_NO_FEATURE};
    m->part_b = (daft_shape_part){0, triangle};
    for (uint32_t i = 0; i < count; i++) points[i].id = mixed_id(points[i].id, triangle);
    uint32_t shallowest = 0;
    for (uint32_t i = 0; i < j->cluster_count; i++) {
        cluster *c = &j->clusters[i];
        if (c->scores[DIRECTIONS] < j->clusters[shallowest].scores[DIRECTIONS]) shallowest = i;
        if (daft_dot(c->manifold.normal, m->normal) <= SAME) continue;
        add_points(c, points, count);
        if (triangle < c->manifold.part_b.triangle) c->manifold.part_b.triangle = triangle;
        if (face && !c->face) c->face = true, c->manifold.normal = m->normal;
        return;
    }
    if (j->cluster_count < MAX_CLUSTERS) {
        cluster_set(&j->clusters[j->cluster_count++], m, face, points, count);
        return;
    }
    cluster c;
    cluster_set(&c, m, face, points, count);
    if (c.scores[DIRECTIONS] > j->clusters[shallowest].scores[DIRECTIONS]) j->clusters[shallowest] = c;
}

/* Four of a cluster's points. */
static void finish(const contact_job *j, cluster *c, daft_sink *sink)
{
    daft_clip_point laid[DIRECTIONS + 1];
    uint32_t count = 0;
    float size = j->body.size + j->body.radius, close = CLOSE * size;
    for (uint32_t i = DIRECTIONS + 1; i-- > 0;) { /* the deepest first */
        daft_clip_point p = {daft_dot(c->u, c->points[i].point), daft_dot(c->v, c->points[i].point),
                             c->points[i].separation, i};
        bool known = false;
        for (uint32_t k = 0; k < count && !known; k++) known = fabsf(laid[k].u - p.u) + fabsf(laid[k].v - p.v) <= close;
        if (!known) laid[count++] = p;
    }
    c->manifold.count = daft_clip_reduce(laid, count, EVEN * size);
    for (uint32_t i = 0; i < c->manifold.count; i++) c->manifold.points[i] = c->points[laid[i].id];
    daft_sink_put(sink, &c->manifold);
}

/* ---- along a triangle's face ---- */

/* side: 0 the front, 1 the back. Gives the least separation; INFINITY where there is no contact, or one deeper than
 * `most`. */
static float put_face_contact(contact_job *j, const near_triangle *t, uint32_t side, float most)
{
    daft_manifold m;
    daft_manifold_point points[DAFT_CLIP_MAX];
    daft_vec3 n = j->face.planes[side].normal, known = j->frame.basis.n;
    if (n.x != known.x || n.y != known.y || n.z != known.z) daft_face_frame_set(&j->frame, n, &j->body);
    uint32_t count = daft_face_points(&j->frame, &j->face, &j->body, side, true, j->margin, true, &m, points);
    float least = INFINITY;
    for (uint32_t i = 0; i < count; i++) least = fminf(least, points[i].separation);
    if (count == 0 || -least > most) return INFINITY;
    put(j, &m, true, points, count, t->number);
    return least;
}

/* Whether there is a contact along the face. It passes, as all of these. */
static bool take_face(contact_job *j, const near_triangle *t, uint32_t side)
{
    float least = put_face_contact(j, t, side, INFINITY);
    j->deepest = fminf(j->deepest, least);
    return least < INFINITY;
}

/* ---- edges ---- */

static daft_vec3 in_body(const contact_job *j, daft_vec3 v)
{
    daft_vec3 d = daft_to_float(daft_dsub(daft_to_double(v), j->pose->q));
    const float *r = j->pose->r;
    return daft_v3((r[0] * d.x + r[1] * d.y) + r[2] * d.z, (r[3] * d.x + r[4] * d.y) + r[5] * d.z,
                   (r[6] * d.x + r[7] * d.y) + r[8] * d.z);
}

typedef enum verdict { ALLOWED, AT_BORDER, FORBIDDEN } verdict;

static daft_vec3 without(daft_vec3 v, daft_vec3 unit) { return daft_sub(v, daft_scale(unit, daft_dot(v, unit))); }

/* Whether p is farther along d than `top`, which lies on an edge along the unit vector `edge` (zero: a corner). */
static bool is_farther(daft_vec3 p, daft_vec3 top, daft_vec3 d, daft_vec3 edge, float tolerance)
{
    daft_vec3 w = without(daft_sub(p, top), edge);
    return daft_dot(without(d, edge), w) > LEAN * daft_length(w) + tolerance;
}

static bool goes_on(const contact_job *j, uint32_t triangle, uint32_t which, daft_vec3 top, daft_vec3 d, daft_vec3 edge)
{
    daft_vec3 corners[3];
    if (!daft_triangle_get(j->surface, triangle, corners)) return false;
    return is_farther(in_body(j, corners[which % 3]), top, d, edge, 0);
}

static verdict judge_edge(const contact_job *j, const near_triangle *t, uint32_t k, daft_vec3 d)
{
    uint32_t other, other_k;
    daft_vec3 edge = daft_normalize(daft_sub(t->corners[(k + 1) % 3], t->corners[k]));
    if (!daft_triangle_across(j->surface, t->number, k, &other, &other_k)) return AT_BORDER;
    return goes_on(j, other, other_k + 2, t->corners[k], d, edge) ? FORBIDDEN : ALLOWED;
}

/* Around corner k, in one direction until it is back or at a border, then in the other. */
static verdict judge_corner(const contact_job *j, const near_triangle *t, uint32_t k, daft_vec3 d)
{
    for (int backwards = 0; backwards < 2; backwards++) {
        uint32_t triangle = t->number, corner = k, other, other_k;
        for (int step = 0; step < MAX_RING; step++) {
            /* Out over the edge that leaves the corner, or over the one that comes to it. */
            bool inside =
                daft_triangle_across(j->surface, triangle, backwards ? (corner + 2) % 3 : corner, &other, &other_k);
            if (!inside) break;
            triangle = other;
            corner = backwards ? other_k : (other_k + 1) % 3;
            if (triangle == t->number) return ALLOWED;
            if (goes_on(j, triangle, other_k + 2, t->corners[k], d, daft_v3(0, 0, 0))) return FORBIDDEN;
        }
    }
    return AT_BORDER;
}

/* What of a triangle is farthest along d: `count` of its corners, one, two (from first to second along its rim) or all.
 */
typedef struct top_feature {
    uint32_t count, first, second;
} top_feature;

static top_feature top_of(const near_triangle *t, daft_vec3 d)
{
    uint32_t top = 0;
    float height[3], fall[3] = {0, 0, 0}; /* fall: from the top, beyond what leaning over that distance allows */
    if (daft_length(without(d, t->normal)) <= LEAN) return (top_feature){3, 0, 1};
    for (uint32_t k = 0; k < 3; k++) {
        height[k] = daft_dot(d, t->corners[k]);
        if (height[k] > height[top]) top = k;
    }
    uint32_t next = (top + 1) % 3, last = (top + 2) % 3;
    for (uint32_t k = 0; k < 3; k++)
        fall[k] = height[top] - height[k] - LEAN * daft_length(daft_sub(t->corners[top], t->corners[k]));
    if (fall[next] <= 0 && fall[next] <= fall[last]) return (top_feature){2, top, next};
    if (fall[last] <= 0) return (top_feature){2, last, top};
    return (top_feature){1, top, top};
}

/* d: the contact's direction, from the triangle to the body. */
static verdict judge(const contact_job *j, const near_triangle *t, daft_vec3 d)
{
    top_feature top = top_of(t, d);
    if (top.count == 3) return ALLOWED;
    return top.count == 2 ? judge_edge(j, t, top.first, d) : judge_corner(j, t, top.first, d);
}

static daft_vec3 turned_vector(const contact_job *j, daft_vec3 v)
{
    const float *r = j->pose->r;
    return daft_v3((r[0] * v.x + r[1] * v.y) + r[2] * v.z, (r[3] * v.x + r[4] * v.y) + r[5] * v.z,
                   (r[6] * v.x + r[7] * v.y) + r[8] * v.z);
}

/* ---- borders ---- */

typedef struct border {
    const contact_job *job;
    uint32_t number;          /* whose border it is */
    daft_vec3 at, away, edge; /* the contact on it; in the body's frame */
    float tolerance;
    bool goes_on;
} border;

/* Unit, in the plane of an edge and a point, across the edge, away from the point. */
static daft_vec3 away_from(daft_vec3 from, daft_vec3 to, daft_vec3 point)
{
    daft_vec3 d = daft_normalize(daft_sub(to, from)), w = daft_sub(from, point);
    return daft_normalize(daft_sub(w, daft_scale(d, daft_dot(w, d))));
}

/* Whether a point lies on the triangle or its rim. */
static bool lies_on(const daft_vec3 corners[3], daft_vec3 normal, daft_vec3 p, float tolerance)
{
    if (fabsf(daft_dot(normal, daft_sub(p, corners[0]))) > tolerance) return false;
    for (uint32_t k = 0; k < 3; k++) {
        daft_vec3 from = corners[k], to = corners[(k + 1) % 3];
        if (daft_dot(away_from(from, to, corners[(k + 2) % 3]), daft_sub(p, from)) > tolerance) return false;
    }
    return true;
}

static void visit_border(void *context, uint32_t number)
{
    border *b = context;
    daft_vec3 own[3], corners[3];
    if (b->goes_on || number == b->number || !daft_triangle_get(b->job->surface, number, own)) return;
    for (int k = 0; k < 3; k++) corners[k] = in_body(b->job, own[k]);
    daft_vec3 normal = turned_vector(b->job, daft_to_float(daft_triangle_normal(own)));
    if (!lies_on(corners, normal, b->at, b->tolerance)) return;
    for (int k = 0; k < 3; k++)
        if (is_farther(corners[k], b->at, b->away, b->edge, 0.1f * b->tolerance)) b->goes_on = true;
    /* Or a step over the triangle, in the direction in which the contact leans. */
    daft_vec3 lean = without(b->away, normal);
    if (daft_length(lean) <= LEAN) return;
    daft_vec3 step = daft_scale(daft_normalize(lean), 4 * b->tolerance);
    if (lies_on(corners, normal, daft_add(b->at, step), 0.5f * b->tolerance)) b->goes_on = true;
}

/* The point of the triangle's top that is nearest to p. */
static daft_vec3 on_top(const near_triangle *t, const top_feature *top, daft_vec3 p)
{
    daft_vec3 from = t->corners[top->first], d = daft_sub(t->corners[top->second], from);
    float square = daft_dot(d, d), at = square > 0 ? daft_dot(daft_sub(p, from), d) / square : 0;
    return daft_add(from, daft_scale(d, fminf(fmaxf(at, 0), 1)));
}

/* Whether no other triangle, from where the contact is, goes on towards the body. */
static bool ends_here(const contact_job *j, const near_triangle *t, const daft_manifold *m)
{
    float size = j->body.size + j->body.radius;
    top_feature top = top_of(t, daft_neg(m->normal));
    border b = {.job = j, .number = t->number, .away = daft_neg(m->normal)};
    b.edge = daft_normalize(daft_sub(t->corners[top.second], t->corners[top.first]));
    for (uint32_t i = 0; i < m->count && !b.goes_on; i++) {
        b.at = on_top(t, &top, m->points[i].point);
        b.tolerance = 1e-3f * size + 0.01f * fabsf(m->points[i].separation);
        const float *r = j->pose->r;
        daft_vec3 p = b.at;
        daft_dvec3 local = daft_dadd(j->pose->q, daft_to_double(daft_v3(r[0] * p.x + r[3] * p.y + r[6] * p.z,
                                                                        r[1] * p.x + r[4] * p.y + r[7] * p.z,
                                                                        r[2] * p.x + r[5] * p.y + r[8] * p.z)));
        daft_vec3 c = daft_to_float(local), more = daft_v3(b.tolerance, b.tolerance, b.tolerance);
        daft_aabb bounds = {daft_sub(c, more), daft_add(c, more)};
        daft_triangles_query(j->surface, &bounds, visit_border, &b);
    }
    return !b.goes_on;
}

/* ---- one triangle ---- */

/* Which side of the triangle a contact is on: where its normal points, or if that is along the sheet, where the body
 * is. */
static uint32_t side_of(const contact_job *j, const near_triangle *t, daft_vec3 away)
{
    if (j->one_sided) return 0;
    float along = daft_dot(away, t->normal);
    if (fabsf(along) < 0.1f) along = daft_dot(t->normal, daft_sub(j->body.centre, t->corners[0]));
    return along < 0;
}

static void take_contact(contact_job *j, const near_triangle *t, daft_manifold *m)
{
    daft_vec3 away = daft_neg(m->normal);
    uint32_t side = side_of(j, t, away);
    float along = (side ? -1.0f : 1.0f) * daft_dot(away, t->normal);
    if (along > FACE && take_face(j, t, side)) return;
    verdict v = j->one_sided && along < -LEAN ? FORBIDDEN : judge(j, t, away);
    if (v == AT_BORDER) v = ends_here(j, t, m) ? ALLOWED : FORBIDDEN;
    if (v == ALLOWED) {
        for (uint32_t i = 0; i < m->count; i++) j->deepest = fminf(j->deepest, m->points[i].separation);
        put(j, m, false, m->points, m->count, t->number);
        return;
    }
    if (!(m->points[0].separation >= 0) && m->points[0].separation > j->last_resort.points[0].separation)
        j->last_resort = *m, j->last_triangle = t->number;
    /* To the side that the body's middle is on. */
    uint32_t turn = !j->one_sided && daft_dot(t->normal, daft_sub(j->body.centre, t->corners[0])) < 0;
    if (j->turned_count < MAX_TURNED) j->turned[j->turned_count++] = (turned){*t, turn};
}

/* Square distance of a ball's centre from a triangle, in the surface's frame (Ericson, "Real-Time Collision Detection",
 * 2005, 5.1.5). */
static double square_distance(daft_dvec3 p, const daft_vec3 own[3])
{
    daft_dvec3 a = daft_to_double(own[0]), b = daft_to_double(own[1]), c = daft_to_double(own[2]), on;
    daft_dvec3 ab = daft_dsub(b, a), ac = daft_dsub(c, a), ap = daft_dsub(p, a), bp = daft_dsub(p, b);
    daft_dvec3 cp = daft_dsub(p, c);
    double d1 = daft_ddot(ab, ap), d2 = daft_ddot(ac, ap), d3 = daft_ddot(ab, bp), d4 = daft_ddot(ac, bp);
    double d5 = daft_ddot(ab, cp), d6 = daft_ddot(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, all = (va + vb) + vc;
    if (d1 <= 0 && d2 <= 0)
        on = a;
    else if (d3 >= 0 && d4 <= d3)
        on = b;
    else if (d6 >= 0 && d5 <= d6)
        on = c;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0)
        on = daft_dadd(a, daft_dscale(ab, d1 / (d1 - d3)));
    else if (vb <= 0 && d2 >= 0 && d6 <= 0)
        on = daft_dadd(a, daft_dscale(ac, d2 / (d2 - d6)));
    else if (va <= 0 && d4 >= d3 && d5 >= d6)
        on = daft_dadd(b, daft_dscale(daft_dsub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    else
        on = all > 0 ? daft_dadd(a, daft_dscale(daft_dadd(daft_dscale(ab, vb), daft_dscale(ac, vc)), 1 / all)) : p;
    daft_dvec3 gap = daft_dsub(p, on);
    return daft_ddot(gap, gap);
}

/* Most triangles near a body are not near enough. Says so of those that surely are not, before any work is done in the
 * body's frame: by bounds, and for balls by distance. */
static bool is_far(const contact_job *j, const daft_vec3 own[3])
{
    daft_vec3 low = daft_min3(own[0], daft_min3(own[1], own[2])), high = daft_max3(own[0], daft_max3(own[1], own[2]));
    if (low.x > j->bounds.high.x || low.y > j->bounds.high.y || low.z > j->bounds.high.z) return true;
    if (high.x < j->bounds.low.x || high.y < j->bounds.low.y || high.z < j->bounds.low.z) return true;
    return j->body.core == DAFT_CORE_POINT && square_distance(j->pose->q, own) > j->far * j->far;
}

static void take_triangle(void *context, uint32_t number)
{
    contact_job *j = context;
    near_triangle t = {.number = number};
    daft_vec3 own[3];
    daft_manifold m;
    if (!daft_triangle_get(j->surface, number, own) || is_far(j, own)) return;
    for (int k = 0; k < 3; k++) t.corners[k] = in_body(j, own[k]);
    t.normal = turned_vector(j, daft_to_float(daft_triangle_normal(own)));
    daft_poly_set_triangle(&j->face, t.corners, t.normal);
    uint32_t sides = j->one_sided ? 1 : 3;
    daft_axis axis;
    if (!daft_axis_find(&j->body, &j->face, j->margin, sides, NULL, &axis)) return;
    if (j->body.core == DAFT_CORE_SOLID && axis.kind == DAFT_AXIS_FACE_B && take_face(j, &t, axis.b)) return;
    if (daft_collide_along(&j->body, &j->face, &axis, j->margin, sides, &m)) take_contact(j, &t, &m);
}

/* ---- all ---- */

/* The contacts along faces that had to be turned to them. Where no other is, the shallowest of them is measure. */
static void put_turned(contact_job *j)
{
    float measure = j->deepest;
    for (uint32_t i = 0; i < j->turned_count && j->deepest == INFINITY; i++) {
        const turned *t = &j->turned[i];
        daft_plane plane = {t->side ? daft_neg(t->triangle.normal) : t->triangle.normal, 0};
        float lowest = INFINITY;
        for (uint32_t k = 0; k < j->body.vertex_count; k++)
            lowest = fminf(lowest, daft_dot(plane.normal, daft_sub(j->body.vertices[k], t->triangle.corners[0])));
        lowest -= j->body.radius;
        measure = measure == INFINITY || lowest > measure ? lowest : measure;
    }
    float depth = measure < 0 ? -measure : 0, most = 2 * depth + 0.03f * (j->body.size + j->body.radius);
    for (uint32_t i = 0; i < j->turned_count; i++) {
        daft_poly_set_triangle(&j->face, j->turned[i].triangle.corners, j->turned[i].triangle.normal);
        put_face_contact(j, &j->turned[i].triangle, j->turned[i].side, most);
    }
}

void daft_collide_triangles(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_sink *sink)
{
    contact_job j;
    daft_relpose back = daft_relpose_swapped(pose);
    j.surface = b, j.pose = pose, j.margin = margin;
    j.one_sided = b->type == DAFT_GEOMETRY_FIELD || b->mesh->one_sided;
    j.turned_count = j.cluster_count = 0;
    j.deepest = INFINITY;
    j.frame.basis.n = daft_v3(0, 0, 0);
    j.last_resort.points[0].separation = -INFINITY;
    j.bounds = daft_bounds_in(a, back.r, pose->q, margin);
    daft_poly_set(&j.body, a, NULL);
    daft_vec3 l = j.bounds.low, h = j.bounds.high; /* what grew the bounds by rounding is enough here */
    j.far = 0.5 * fmax((double)h.x - (double)l.x, fmax((double)h.y - (double)l.y, (double)h.z - (double)l.z));
    daft_triangles_query(b, &j.bounds, take_triangle, &j);
    put_turned(&j);
    if (j.cluster_count == 0 && j.last_resort.points[0].separation > -INFINITY)
        put(&j, &j.last_resort, false, j.last_resort.points, j.last_resort.count, j.last_triangle);
    for (uint32_t i = 0; i < j.cluster_count; i++) finish(&j, &j.clusters[i], sink);
}
