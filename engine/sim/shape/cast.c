/* Time of impact and shape casts by conservative advancement (Mirtich, "Impulse-based Dynamic Simulation of Rigid Body
 * Systems", 1996; van den Bergen, "Ray Casting against General Convex Objects with Application to Continuous Collision
 * Detection", 2004). At distance d and with closest direction n no point of either can close the gap faster along n
 * than the centres do along n plus both angular speeds times the arms: so time may go on by (d - target) over that
 * speed. Without rotation it is Newton's method on a convex function, which never oversteps and converges quadratically
 * on faces. */
#include "math/trig.h"
#include "sim/shape/gjk.h"

enum { MAX_STEPS = 200 };

/* ---- sweeps ---- */

daft_rigid daft_sweep_frame(const daft_sweep *s, double t)
{
    daft_quat turn = daft_quat_nlerp(s->rotation_from, s->rotation_to, (float)t);
    daft_rigid out = daft_rigid_make(s->from, turn);
    daft_dvec3 centre = daft_dadd(s->from, daft_dscale(daft_dsub(s->to, s->from), t));
    out.p = daft_dsub(centre, daft_rigid_vector(&out, daft_to_double(s->centre)));
    return out;
}

daft_sweep daft_sweep_still(const daft_rigid *pose, daft_quat rotation)
{
    return (daft_sweep){pose->p, pose->p, rotation, rotation, {0, 0, 0}};
}

/* The most that the normalised straight line between two quaternions turns, in radians over the whole time: it is
 * fastest in the middle, at 4·tan(angle / 4) if it turned so all the time. */
static double fastest_turn(const daft_sweep *s)
{
    daft_quat p = s->rotation_from, q = s->rotation_to;
    double dot =
        (double)p.x * (double)q.x + (double)p.y * (double)q.y + (double)p.z * (double)q.z + (double)p.w * (double)q.w;
    double pp =
        (double)p.x * (double)p.x + (double)p.y * (double)p.y + (double)p.z * (double)p.z + (double)p.w * (double)p.w;
    double qq =
        (double)q.x * (double)q.x + (double)q.y * (double)q.y + (double)q.z * (double)q.z + (double)q.w * (double)q.w;
    if (!(pp > 0 && qq > 0)) return 0;
    double half = sqrt(fmax(0, 1 - fmin(1, dot * dot / (pp * qq)))); /* sine of half the angle */
    if (half < 1e-6) return 0;                                       /* rounding of floats */
    return 1.001 * 4 * daft_tan(daft_asin(half) / 2);
}

static bool is_finite_sweep(const daft_sweep *s)
{
    const daft_quat *q[2] = {&s->rotation_from, &s->rotation_to};
    for (int i = 0; i < 2; i++)
        if (!isfinite(q[i]->x) || !isfinite(q[i]->y) || !isfinite(q[i]->z) || !isfinite(q[i]->w)) return false;
    return daft_dfinite3(s->from) && daft_dfinite3(s->to) && daft_finite3(s->centre);
}

/* ---- two convex parts ---- */

/* A part of one of the bodies. */
typedef struct part {
    daft_proxy proxy;
    const daft_rigid *pose; /* in the body; NULL: its frame */
    double reach;           /* from the body's centre */
} part;

typedef struct job {
    const daft_sweep *a, *b;
    double turn_a, turn_b; /* fastest */
    double target, tolerance;
    bool overlaps_count; /* a part that overlaps at the start ends the search */
    daft_impact_kind kind;
    daft_impact best;
    /* The pair of shapes at hand. */
    part part_a;
    const daft_sim_shape *shape_a, *surface;
    const daft_rigid *pose_b;
    uint32_t child_a, child_b;
} job;

static daft_rigid part_frame(const daft_sweep *sweep, const part *p, double t)
{
    daft_rigid frame = daft_sweep_frame(sweep, t);
    return p->pose ? daft_rigid_mul(&frame, p->pose) : frame;
}

/* How far from the body's centre its core, without the rounding, gets: a ball does not come nearer by turning about its
 * own centre. Reaches are rounded up as much as the radius is here. */
static double arm_of(const part *p) { return fmax(0, p->reach - (double)(float)(p->proxy.radius * (1 + 0x1p-22))); }

static daft_impact_kind advance(const job *j, const part *a, const part *b, daft_impact *out)
{
    double rounding = a->proxy.radius + b->proxy.radius;
    daft_dvec3 motion = daft_dsub(daft_dsub(j->a->to, j->a->from), daft_dsub(j->b->to, j->b->from));
    double spin = j->turn_a * arm_of(a) + j->turn_b * arm_of(b);
    for (int step = 0; step < MAX_STEPS; step++) {
        daft_rigid fa = part_frame(j->a, a, out->t), fb = part_frame(j->b, b, out->t);
        daft_rigid relative = daft_rigid_relative(&fa, &fb);
        daft_gjk g;
        daft_gjk_distance(&a->proxy, &b->proxy, &relative, INFINITY, &g);
        if (step > 0 && !(g.distance > 0)) return DAFT_IMPACT_HIT; /* by rounding; with the points of the step before */
        double distance = g.distance - rounding, gap = distance - j->target;
        daft_dvec3 n = daft_rigid_vector(&fa, g.normal);
        out->normal = n;
        out->point = daft_rigid_point(&fa, daft_dsub(g.on_b, daft_dscale(g.normal, b->proxy.radius)));
        if (step == 0 && (gap < 0 || !(g.distance > 0))) return DAFT_IMPACT_OVERLAP;
        double speed = daft_ddot(motion, n) + spin;
        if (gap <= j->tolerance && (step > 0 || speed > 0)) return DAFT_IMPACT_HIT;
        if (!(speed > 0)) return DAFT_IMPACT_MISS;
        out->t += gap / speed;
        if (!(out->t < 1)) return DAFT_IMPACT_MISS;
        if (j->kind == DAFT_IMPACT_HIT && out->t > j->best.t) return DAFT_IMPACT_MISS; /* later than another part */
    }
    return DAFT_IMPACT_GAVE_UP;
}

/* The order of what is found: what stops it counts before what it is stuck in, unless that is asked for. */
static void try_parts(job *j, const part *b, uint32_t triangle)
{
    daft_impact found = {.part_a = {j->child_a, DAFT_NO_FEATURE}, .part_b = {j->child_b, triangle}};
    daft_impact_kind kind = advance(j, &j->part_a, b, &found);
    if (kind == DAFT_IMPACT_MISS) return;
    if (kind == DAFT_IMPACT_OVERLAP) {
        found.t = 0;
        bool first = j->kind == DAFT_IMPACT_MISS || (j->overlaps_count && j->kind != DAFT_IMPACT_OVERLAP);
        if (first) j->kind = kind, j->best = found;
        return;
    }
    if (j->kind == DAFT_IMPACT_OVERLAP && j->overlaps_count) return;
    bool sooner = j->kind == DAFT_IMPACT_MISS || j->kind == DAFT_IMPACT_OVERLAP || found.t < j->best.t;
    if (sooner) j->kind = kind, j->best = found;
}

/* ---- which parts ---- */

/* Before when something must happen to matter: by then nothing else has. */
static double deadline(const job *j)
{
    bool found = j->kind == DAFT_IMPACT_HIT || j->kind == DAFT_IMPACT_GAVE_UP;
    return j->kind == DAFT_IMPACT_OVERLAP && j->overlaps_count ? 0 : found ? j->best.t : 1;
}

typedef struct path {
    daft_dvec3 origin, direction, reach; /* of part a's bounds, as seen from b's part */
    double end;                          /* the deadline */
    job *job;
} path;

/* The path of the centre of part a's bounds, in b's part's frame. It leaves the straight line by no more than turning
 * makes it: that much is added to its reach. */
static void path_set(job *j, path *p)
{
    part b = {.pose = j->pose_b};
    daft_rigid a0 = part_frame(j->a, &j->part_a, 0), a1 = part_frame(j->a, &j->part_a, 1);
    daft_rigid b0 = part_frame(j->b, &b, 0), b1 = part_frame(j->b, &b, 1);
    daft_rigid first = daft_rigid_relative(&b0, &a0), last = daft_rigid_relative(&b1, &a1);
    double more = j->target + j->tolerance + 1e-9;
    if (j->turn_a == 0 && j->turn_b == 0) {
        daft_daabb bounds = daft_shape_bounds(j->shape_a, &first);
        p->origin = daft_dscale(daft_dadd(bounds.low, bounds.high), 0.5);
        p->direction = daft_dsub(last.p, first.p);
        p->reach = daft_dscale(daft_dsub(bounds.high, bounds.low), 0.5);
    } else {
        daft_dvec3 c0 = daft_rigid_to_local(&b0, j->a->from), c1 = daft_rigid_to_local(&b1, j->a->to);
        double arm = fmax(sqrt(daft_ddot(c0, c0)), sqrt(daft_ddot(c1, c1)));
        p->origin = c0;
        p->direction = daft_dsub(c1, c0);
        more += j->turn_b * arm;
        p->reach = daft_dv3(j->part_a.reach, j->part_a.reach, j->part_a.reach);
    }
    p->reach = daft_dadd(p->reach, daft_dv3(more, more, more));
    p->end = deadline(j);
    p->job = j;
}

static double reach_from(const daft_vec3 corners[3], const daft_rigid *pose, daft_vec3 centre)
{
    double most = 0;
    for (int k = 0; k < 3; k++) {
        daft_dvec3 v = daft_to_double(corners[k]);
        if (pose) v = daft_rigid_point(pose, v);
        v = daft_dsub(v, daft_to_double(centre));
        most = fmax(most, daft_ddot(v, v));
    }
    return sqrt(most);
}

static void visit_triangle(void *context, uint32_t triangle)
{
    path *p = context;
    job *j = p->job;
    daft_vec3 corners[3];
    double enter;
    if (!daft_triangle_get(j->surface, triangle, corners)) return;
    daft_vec3 low = daft_min3(corners[0], daft_min3(corners[1], corners[2]));
    daft_vec3 high = daft_max3(corners[0], daft_max3(corners[1], corners[2]));
    if (!daft_sweep_meets(p->origin, p->direction, p->reach, daft_to_double(low), daft_to_double(high), p->end, &enter))
        return;
    part b = {daft_proxy_triangle(corners), j->pose_b, 0};
    if (j->turn_b > 0) b.reach = reach_from(corners, j->pose_b, j->b->centre);
    try_parts(j, &b, triangle);
    p->end = deadline(j);
}

static void try_leaf(job *j, const daft_sim_shape *b)
{
    if (b->type == DAFT_GEOMETRY_MESH || b->type == DAFT_GEOMETRY_FIELD) {
        path p;
        j->surface = b;
        path_set(j, &p);
        daft_triangles_sweep(b, p.origin, p.direction, p.reach, &p.end, visit_triangle, &p);
        return;
    }
    part other = {daft_proxy_of(b), j->pose_b, 0};
    daft_vec3 centre = j->b->centre;
    if (j->pose_b) centre = daft_to_float(daft_rigid_to_local(j->pose_b, daft_to_double(centre)));
    other.reach = (double)daft_shape_reach(b, centre);
    try_parts(j, &other, DAFT_NO_FEATURE);
}

static void try_b(job *j, const daft_sim_shape *b)
{
    j->pose_b = NULL;
    j->child_b = 0;
    if (b->type != DAFT_GEOMETRY_COMPOUND) {
        try_leaf(j, b);
        return;
    }
    const daft_compound *c = b->compound;
    path p;
    path_set(j, &p);
    for (uint32_t i = 0; i < 2 * c->count - 1;) {
        const daft_compound_node *n = &c->nodes[i];
        double enter;
        bool may = daft_sweep_meets(p.origin, p.direction, p.reach, daft_to_double(n->bounds.low),
                                    daft_to_double(n->bounds.high), deadline(j), &enter);
        i = may || n->second == 0 ? i + 1 : n->skip;
        if (!may || n->second) continue;
        j->pose_b = &c->children[n->child].pose;
        j->child_b = n->child;
        try_leaf(j, &c->children[n->child].shape);
    }
}

static void set_part_a(job *j, const daft_sim_shape *shape, const daft_rigid *pose)
{
    daft_vec3 centre = j->a->centre;
    if (pose) centre = daft_to_float(daft_rigid_to_local(pose, daft_to_double(centre)));
    j->shape_a = shape;
    j->part_a = (part){daft_proxy_of(shape), pose, (double)daft_shape_reach(shape, centre)};
}

static daft_impact_kind run(job *j, const daft_sim_shape *a, const daft_sim_shape *b, daft_impact *out)
{
    if (!daft_shape_has_mass(a) || !is_finite_sweep(j->a) || !is_finite_sweep(j->b)) return DAFT_IMPACT_MISS;
    j->turn_a = fastest_turn(j->a), j->turn_b = fastest_turn(j->b);
    if (a->type != DAFT_GEOMETRY_COMPOUND) {
        set_part_a(j, a, NULL);
        try_b(j, b);
    } else {
        for (uint32_t i = 0; i < a->compound->count; i++) {
            set_part_a(j, &a->compound->children[i].shape, &a->compound->children[i].pose);
            j->child_a = i;
            try_b(j, b);
        }
    }
    *out = j->best;
    return j->kind;
}

daft_impact_kind daft_shape_impact(const daft_sim_shape *a, const daft_sweep *sweep_a, const daft_sim_shape *b,
                                   const daft_sweep *sweep_b, double target, double tolerance, daft_impact *out)
{
    job j = {.a = sweep_a, .b = sweep_b, .target = target, .tolerance = tolerance};
    return run(&j, a, b, out);
}

daft_impact_kind daft_shape_cast(const daft_sim_shape *a, const daft_rigid *a_in_b, daft_dvec3 motion,
                                 const daft_sim_shape *b, daft_impact *out)
{
    /* The frame itself is a's only child's pose, so that no quaternion is needed. */
    daft_quat none = {0, 0, 0, 1};
    daft_sweep still = {{0, 0, 0}, {0, 0, 0}, none, none, {0, 0, 0}}, moving = still;
    moving.to = motion;
    if (!daft_dfinite3(a_in_b->p)) return DAFT_IMPACT_MISS;
    double size = (double)daft_shape_reach(a, daft_v3(0, 0, 0));
    job j = {.a = &moving, .b = &still, .target = 1e-6 * size, .tolerance = 5e-7 * size, .overlaps_count = true};
    if (a->type != DAFT_GEOMETRY_COMPOUND) {
        if (!daft_shape_is_convex(a) || !is_finite_sweep(&moving)) return DAFT_IMPACT_MISS;
        set_part_a(&j, a, a_in_b);
        try_b(&j, b);
        *out = j.best;
        return j.kind;
    }
    for (uint32_t i = 0; i < a->compound->count; i++) {
        const daft_child *child = &a->compound->children[i];
        daft_rigid pose = daft_rigid_mul(a_in_b, &child->pose);
        if (!daft_shape_is_convex(&child->shape) || !is_finite_sweep(&moving)) return DAFT_IMPACT_MISS;
        set_part_a(&j, &child->shape, &pose);
        j.child_a = i;
        try_b(&j, b);
    }
    *out = j.best;
    return j.kind;
}
