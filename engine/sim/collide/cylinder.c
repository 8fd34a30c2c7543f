/* Cylinders. A cylinder is a hull, a prism of CYLINDER_SIDES sides, and collides as one of three shapes:
 *
 *     side  its side faces the other shape: a capsule of its radius and length, whose manifold is the cylinder's
 *           wherever the normal is square to the axis. So it rolls as a round body does;
 *     rim   the prism, turned about its axis so that an edge of it points to the other shape: the rim's point is
 *           where it is on a cylinder, and stays under it while it rolls;
 *     cap   the prism as it is.
 *
 * The closest points of the other shape and of a core within the cylinder, a segment on its axis, tell which. */
#include "sim/collide/manifold_parts.h"

#include <math.h>

enum { CYLINDER_SIDES = DAFT_HULL_MAX_VERTICES / 2 };

/* Sines of angles between the axis, or the plane square to it, and the direction to the other shape: what is nearer
 * counts as square. */
#define SQUARE   0.02
#define SIDEWAYS 0.1f /* of normals: a capsule's are the cylinder's */
#define FLAT     0.9f /* of normals: the cap is met, not the rim */
#define ON_RIM                                                                                                         \
    0.05f /* fraction of the radius: points of the rim that is met are no farther beside the edge that points there */

daft_hull *daft_hull_create_cylinder(const daft_allocator *allocator, float radius, float half_height,
                                     daft_error *error)
{
    daft_sim_shape check;
    daft_vec3 p[2 * CYLINDER_SIDES];
    if (!daft_shape_box(daft_v3(radius, half_height, radius), &check, error)) return NULL;
    for (int i = 0; i < CYLINDER_SIDES; i++) {
        double angle = 2 * DAFT_PI * i / CYLINDER_SIDES;
        float x = (float)((double)radius * daft_cos(angle)), z = (float)((double)radius * daft_sin(angle));
        p[2 * i] = daft_v3(x, half_height, z), p[2 * i + 1] = daft_v3(x, -half_height, z);
    }
    daft_hull *hull = daft_hull_create(allocator, p, 2 * CYLINDER_SIDES, 0, error);
    if (hull) hull->cylinder = radius, hull->centre = daft_v3(0, 0, 0);
    return hull;
}

bool daft_shape_is_cylinder(const daft_sim_shape *s) { return s->type == DAFT_GEOMETRY_HULL && s->hull->cylinder > 0; }

/* Within the cylinder, and as far from its caps as from its side. */
static daft_sim_shape core_of(const daft_sim_shape *s)
{
    if (!daft_shape_is_cylinder(s)) return *s;
    float half = s->hull->high.y - s->hull->cylinder;
    return (daft_sim_shape){.type = DAFT_GEOMETRY_CAPSULE, .half_height = half > 0 ? half : 0};
}

static double radius_of(const daft_sim_shape *s) { return daft_shape_is_cylinder(s) ? (double)s->hull->cylinder : 0; }

/* How a cylinder is met; other shapes stay what they are. */
typedef struct stance {
    bool side, rim;
    double c, s; /* of the turn about y that brings the prism's first edge to where it is met */
} stance;

static stance stance_of(const daft_sim_shape *s, daft_dvec3 towards)
{
    double across = hypot(towards.x, towards.z);
    stance out = {.c = 1};
    if (!daft_shape_is_cylinder(s) || across <= SQUARE) return out;
    out.side = fabs(towards.y) < SQUARE;
    out.rim = !out.side;
    out.c = towards.x / across, out.s = -towards.z / across;
    return out;
}

static daft_rigid turn_of(const stance *s) { return (daft_rigid){.m = {s->c, 0, s->s, 0, 1, 0, -s->s, 0, s->c}}; }

static daft_sim_shape round_side(const daft_sim_shape *s)
{
    return (daft_sim_shape){.type = DAFT_GEOMETRY_CAPSULE, .radius = s->hull->cylinder, .half_height = s->hull->high.y};
}

/* Both as turned. */
static daft_relpose turned_pose(const daft_relpose *pose, const daft_rigid *turn_a, const daft_rigid *turn_b)
{
    daft_rigid r = {.p = {0, 0, 0}}, both;
    for (int i = 0; i < 9; i++) r.m[i] = (double)pose->r[i];
    daft_rigid from_a = daft_rigid_inverse(turn_a);
    both = daft_rigid_mul(&from_a, &r);
    both = daft_rigid_mul(&both, turn_b);
    daft_relpose out = {.p = daft_rigid_to_local_vector(turn_a, pose->p),
                        .q = daft_rigid_to_local_vector(turn_b, pose->q)};
    for (int i = 0; i < 9; i++) out.r[i] = (float)both.m[i];
    return out;
}

/* Along a side's axis a capsule goes on beyond the cylinder. */
static bool is_sideways(const daft_manifold *m, const daft_relpose *pose, bool side_a, bool side_b)
{
    const float *r = pose->r;
    float along_b = m->normal.x * r[1] + m->normal.y * r[4] + m->normal.z * r[7];
    return (!side_a || fabsf(m->normal.y) < SIDEWAYS) && (!side_b || fabsf(along_b) < SIDEWAYS);
}

/* A rim rolls on the one point that is met; its neighbours will not come there as a prism's would. */
static void keep_rim(daft_manifold *m, const daft_relpose *pose, bool of_b, float radius)
{
    const float *r = pose->r;
    daft_vec3 axis = of_b ? daft_v3(r[1], r[4], r[7]) : daft_v3(0, 1, 0),
              beside = of_b ? daft_v3(r[2], r[5], r[8]) : daft_v3(0, 0, 1);
    float middle = of_b ? daft_dot(daft_to_float(pose->p), beside) : 0;
    uint32_t kept = 0;
    if (fabsf(daft_dot(m->normal, axis)) > FLAT) return;
    for (uint32_t i = 0; i < m->count; i++)
        if (fabsf(daft_dot(m->points[i].point, beside) - middle) <= ON_RIM * radius) m->points[kept++] = m->points[i];
    if (kept > 0) m->count = kept;
}

static void turn_back(const daft_rigid *turn, daft_manifold *m)
{
    m->normal = daft_to_float(daft_rigid_vector(turn, daft_to_double(m->normal)));
    for (uint32_t i = 0; i < m->count; i++)
        m->points[i].point = daft_to_float(daft_rigid_vector(turn, daft_to_double(m->points[i].point)));
}

typedef struct meeting {
    const daft_sim_shape *a, *b;
    stance of_a, of_b;
    daft_rigid turn_a;
    daft_relpose pose; /* of both as turned */
    float margin;
    uint32_t capacity;
    daft_pair_cache *cache;
} meeting;

/* With capsules for sides, and of that what is sideways; with prisms for sides, and of that the rest. */
static uint32_t meet(const meeting *t, bool as_capsules, bool all, daft_manifold *out)
{
    daft_sim_shape a = as_capsules && t->of_a.side ? round_side(t->a) : *t->a;
    daft_sim_shape b = as_capsules && t->of_b.side ? round_side(t->b) : *t->b;
    uint32_t count = daft_collide_plain(&a, &b, &t->pose, t->margin, out, t->capacity, t->cache), kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        daft_manifold *m = &out[i];
        if (!all && is_sideways(m, &t->pose, t->of_a.side, t->of_b.side) != as_capsules) continue;
        if (t->of_a.rim) keep_rim(m, &t->pose, false, t->a->hull->cylinder);
        if (t->of_b.rim) keep_rim(m, &t->pose, true, t->b->hull->cylinder);
        turn_back(&t->turn_a, m);
        if (kept != i) out[kept] = *m;
        kept++;
    }
    return kept;
}

uint32_t daft_collide_cylinder(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                               daft_manifold *out, uint32_t capacity, daft_pair_cache *cache)
{
    daft_sim_shape core_a = core_of(a), core_b = core_of(b);
    daft_rigid b_in_a = {.p = pose->p};
    for (int i = 0; i < 9; i++) b_in_a.m[i] = (double)pose->r[i];
    daft_distance d;
    daft_dvec3 towards = daft_dv3(0, 0, 0);
    double limit = (double)margin + 1.5 * (radius_of(a) + radius_of(b));
    if (daft_shape_distance(&core_a, &core_b, &b_in_a, limit, &d) && d.distance > 0) towards = d.normal;
    meeting t = {.a = a, .b = b, .margin = margin, .capacity = capacity, .cache = cache};
    t.of_a = stance_of(a, towards);
    t.of_b = stance_of(b, daft_rigid_to_local_vector(&b_in_a, daft_dscale(towards, -1)));
    daft_rigid turn_b = turn_of(&t.of_b);
    t.turn_a = turn_of(&t.of_a);
    t.pose = turned_pose(pose, &t.turn_a, &turn_b);
    bool side = t.of_a.side || t.of_b.side, surface = !daft_shape_is_convex(b);
    uint32_t count = meet(&t, side, !side, out);
    if (side && (surface || count == 0)) { /* beyond an end, or with other triangles */
        t.capacity -= count;
        if (t.capacity > 0) count += meet(&t, false, !surface, out + count);
    }
    return count;
}
