/* Manifolds of convex pairs, against axes and distances found the slow way. */
#include "shape_cases.h"

#include "sim/collide/manifold_box.h"
#include "sim/collide/manifold_round.h"

enum { KINDS = 4 };

static daft_hull *owned[4096];
static uint32_t owned_count;

static void drop_hulls(void)
{
    while (owned_count > 0) daft_hull_free(owned[--owned_count]);
}

static daft_sim_shape random_shape(uint32_t kind, float size)
{
    switch (kind) {
    case 0: return must_sphere(size * random_float(0.3f, 1));
    case 1: return must_capsule(size * random_float(0.2f, 1), size * random_float(0.1f, 0.6f));
    case 2: return must_box(size * random_float(0.2f, 1), size * random_float(0.2f, 1), size * random_float(0.2f, 1));
    default:
        owned[owned_count] = random_hull(5 + random_bits() % 20, daft_v3(size, size * random_float(0.3f, 1), size));
        return daft_shape_hull(owned[owned_count++]);
    }
}

static const char *const NAMES[KINDS] = {"sphere", "capsule", "box", "hull"};

typedef struct sample {
    daft_sim_shape a, b;
    daft_rigid pose_a, pose_b;
    cloud ca, cb; /* in a's frame */
    double size;  /* of the smaller */
    double truth; /* separation: distance, or minus the least way out */
    char name[64];
} sample;

static double extent(const daft_sim_shape *s) { return (double)daft_shape_reach(s, daft_v3(0, 0, 0)); }

static double truth_of(const cloud *a, const cloud *b)
{
    double rounding = a->radius + b->radius;
    double sat = a->axis_count + b->axis_count > 0 ? oracle_sat(a, b) + rounding : INFINITY;
    return (sat < 0 ? sat : oracle_distance(a, b)) - rounding;
}

/* b touches a about as deep as `depth` times the smaller's size says, at some place. */
static sample random_sample(uint32_t kind_a, uint32_t kind_b, float ratio, float depth, double far)
{
    sample s = {.a = random_shape(kind_a, 1), .b = random_shape(kind_b, ratio)};
    double ea = extent(&s.a), eb = extent(&s.b);
    s.size = fmin(ea, eb);
    s.pose_a = random_rigid((float)far);
    daft_rigid relative = random_rigid((float)(0.5 * fmax(ea, eb))), identity = daft_rigid_identity();
    s.ca = cloud_of(&s.a, &identity), s.cb = cloud_of(&s.b, &relative);
    daft_dvec3 n = random_unit();
    relative.p = daft_dadd(relative.p, daft_dscale(n, -apart_along(&s.ca, &s.cb, n) - (double)depth * s.size));
    s.pose_b = daft_rigid_mul(&s.pose_a, &relative);
    relative = daft_rigid_relative(&s.pose_a, &s.pose_b);
    s.cb = cloud_of(&s.b, &relative);
    s.truth = truth_of(&s.ca, &s.cb);
    snprintf(s.name, sizeof s.name, "%s and %s, %g as large, %g deep", NAMES[kind_a], NAMES[kind_b], (double)ratio,
             (double)depth);
    return s;
}

/* How far x is outside of a cloud, from below: over its axes only. */
static double outside(const cloud *c, daft_dvec3 x)
{
    double most = -INFINITY;
    for (uint32_t i = 0; i < c->axis_count; i++) {
        double top = -INFINITY, bottom = INFINITY, at = daft_ddot(c->axes[i], x);
        for (uint32_t k = 0; k < c->count; k++) {
            top = fmax(top, daft_ddot(c->axes[i], c->points[k]));
            bottom = fmin(bottom, daft_ddot(c->axes[i], c->points[k]));
        }
        most = fmax(most, fmax(at - top, bottom - at));
    }
    if (c->axis_count == 0) {
        cloud point = {.points = {x}, .count = 1};
        most = oracle_distance(c, &point) - c->radius;
    }
    return most;
}

static void check_points(const sample *s, const daft_manifold *m, double tolerance)
{
    assert_true(m->count >= 1 && m->count <= 4);
    double least = INFINITY, length = (double)daft_length(m->normal);
    if (!(fabs(length - 1) < 1e-5)) fail_msg("%s: a normal of %g", s->name, length);
    for (uint32_t i = 0; i < m->count; i++) {
        const daft_manifold_point *p = &m->points[i];
        least = fmin(least, (double)p->separation);
        double room = fabs((double)p->separation) / 2 + tolerance, oa = outside(&s->ca, daft_to_double(p->point)),
               ob = outside(&s->cb, daft_to_double(p->point));
        if (!(oa <= room && ob <= room))
            fail_msg("%s: a point %g outside of a, %g of b, separation %g", s->name, oa, ob, (double)p->separation);
        for (uint32_t k = 0; k < i; k++) assert_int_not_equal(p->id, m->points[k].id);
    }
    double along = apart_along(&s->ca, &s->cb, daft_to_double(m->normal));
    if (s->truth < 0 && !(fabs(least - along) <= tolerance))
        fail_msg("%s: deepest point %g, along the normal %g (truth %g)", s->name, least, along, s->truth);
    if (s->truth < 0 && !(along >= s->truth - tolerance))
        fail_msg("%s: %g along the normal, but %g is enough", s->name, along, s->truth);
}

static uint32_t collide(const sample *s, float margin, daft_manifold *m, daft_pair_cache *cache)
{
    daft_relpose pose = daft_relpose_make(&s->pose_a, &s->pose_b);
    return daft_collide(&s->a, &s->b, &pose, margin, m, 1, cache);
}

static void check_sample(const sample *s, double tolerance)
{
    daft_manifold m, again;
    daft_pair_cache cache = {0};
    double margin = 0.05 * s->size;
    bool solids = s->ca.axis_count > 0 && s->cb.axis_count > 0;
    uint32_t count = collide(s, (float)margin, &m, &cache);
    if (s->truth < -tolerance && count != 1) fail_msg("%s: no contact at %g", s->name, s->truth);
    if (!solids && s->truth < margin - tolerance && count != 1) fail_msg("%s: none at %g", s->name, s->truth);
    if (!solids && s->truth > margin + tolerance && count != 0) fail_msg("%s: one at %g", s->name, s->truth);
    if (count) check_points(s, &m, tolerance);
    /* With what is now in the cache: the same. */
    uint32_t once_more = collide(s, (float)margin, &again, &cache);
    if (once_more != count && (s->truth < -tolerance || !solids)) fail_msg("%s: the cache changes the answer", s->name);
    if (once_more) check_points(s, &again, tolerance);

    sample swapped = {.a = s->b, .b = s->a, .pose_a = s->pose_b, .pose_b = s->pose_a};
    daft_manifold other;
    if (collide(&swapped, (float)margin, &other, NULL) != count && (s->truth < -tolerance || !solids) &&
        fabs(s->truth - margin) > tolerance)
        fail_msg("%s: swapped, %u contacts become %u at %g", s->name, count, 1 - count, s->truth);
}

static void pairs_touch_as_they_should(void **unused)
{
    (void)unused;
    fixture_seed(601);
    static const float depths[] = {-0.04f, -0.01f, 0.001f, 0.01f, 0.1f, 0.4f};
    for (uint32_t a = 0; a < KINDS; a++)
        for (uint32_t b = 0; b < KINDS; b++)
            for (int round = 0; round < 90; round++) {
                float ratio = round % 3 == 0 ? 1 : round % 3 == 1 ? 0.1f : 8;
                sample s = random_sample(a, b, ratio, depths[round % 6], 5);
                check_sample(&s, 4e-3 * s.size);
                drop_hulls();
            }
}

/* ---- what a resting body needs ---- */

/* A crate on one corner of a huge floor, at any place and turn: the contact is as good as on a small one. */
static void a_crate_on_a_huge_floor(void **unused)
{
    (void)unused;
    fixture_seed(602);
    for (int round = 0; round < 2000; round++) {
        daft_sim_shape crate = must_box(0.5f, 0.5f, 0.5f), floor = must_box(500, 50, 500);
        double angle = (double)random_float(-3, 3), depth = 0.003;
        daft_rigid world = random_rigid(1000);
        daft_rigid ground = daft_rigid_make(daft_dv3(0, -50, 0), (daft_quat){0, 0, 0, 1});
        daft_quat turn = {0, (float)daft_sin(angle / 2), 0, (float)daft_cos(angle / 2)};
        daft_rigid body = daft_rigid_make(
            daft_dv3((double)random_float(-499, 499), 0.5 - depth, (double)random_float(-499, 499)), turn);
        ground = daft_rigid_mul(&world, &ground), body = daft_rigid_mul(&world, &body);
        daft_relpose pose = daft_relpose_make(&body, &ground);
        daft_manifold m;
        assert_int_equal(daft_collide(&crate, &floor, &pose, 0.01f, &m, 1, NULL), 1);
        assert_int_equal(m.count, 4);
        for (int i = 0; i < 4; i++) {
            assert_near(m.points[i].separation, -depth, 2e-6);
            assert_near(fabsf(m.points[i].point.x), 0.5f, 2e-6);
            assert_near(fabsf(m.points[i].point.z), 0.5f, 2e-6);
        }
        assert_true(m.normal.y < -0.999999f);
    }
}

/* Two crates of one size, one upon the other with last bits of noise: always the four corners, with the same ids. */
static void a_stack_keeps_its_corners(void **unused)
{
    (void)unused;
    fixture_seed(603);
    daft_allocator allocator = daft_malloc_allocator();
    daft_trimesh mesh;
    assert_true(daft_trimesh_box(&allocator, daft_v3(1, 1, 1), &mesh, NULL));
    daft_hull *hull = daft_hull_create_mesh(&allocator, &mesh, daft_v3(1, 1, 1), 0, NULL);
    for (int kind = 0; kind < 2; kind++) {
        uint32_t ids[4] = {0};
        daft_sim_shape crate = kind ? daft_shape_hull(hull) : must_box(0.5f, 0.5f, 0.5f);
        daft_pair_cache cache = {0};
        for (int round = 0; round < 500; round++) {
            daft_quat tilt = {random_float(-1e-5f, 1e-5f), random_float(-1e-5f, 1e-5f), random_float(-1e-5f, 1e-5f), 1};
            daft_rigid low = daft_rigid_identity();
            daft_rigid top = daft_rigid_make(daft_dv3((double)random_float(-1e-5f, 1e-5f), 0.999, 1e-5), tilt);
            daft_relpose pose = daft_relpose_make(&low, &top);
            daft_manifold m;
            assert_int_equal(daft_collide(&crate, &crate, &pose, 0.01f, &m, 1, &cache), 1);
            assert_int_equal(m.count, 4);
            for (int i = 0; i < 4; i++) {
                if (round == 0) ids[i] = m.points[i].id;
                assert_int_equal(m.points[i].id, ids[i]);
                assert_near(fabsf(m.points[i].point.x), 0.5f, 1e-3);
            }
        }
    }
    daft_hull_free(hull);
    daft_trimesh_free(&allocator, &mesh);
}

/* A box and the same box as a hull are the same thing. */
static void boxes_are_hulls(void **unused)
{
    (void)unused;
    fixture_seed(604);
    daft_allocator allocator = daft_malloc_allocator();
    int contacts = 0, faces = 0, same = 0;
    for (int round = 0; round < 2000; round++) {
        sample s = random_sample(2, 2, 1, 0.3f, 0);
        if (s.truth > -2e-3) continue;
        daft_trimesh mesh;
        daft_trimesh_box(&allocator, daft_scale(s.a.half, 2), &mesh, NULL);
        daft_hull *hull = daft_hull_create_mesh(&allocator, &mesh, daft_v3(1, 1, 1), 0, NULL);
        daft_sim_shape as_hull = daft_shape_hull(hull);
        daft_relpose pose = daft_relpose_make(&s.pose_a, &s.pose_b);
        daft_manifold m, n;
        uint32_t count = daft_collide(&s.a, &s.b, &pose, 0.01f, &m, 1, NULL);
        assert_int_equal(daft_collide(&as_hull, &s.b, &pose, 0.01f, &n, 1, NULL), count);
        contacts += count > 0;
        if (count && daft_dot(m.normal, n.normal) > 0.9999f) {
            faces++;
            same += m.count == n.count;
            float deep_m = INFINITY, deep_n = INFINITY;
            for (uint32_t i = 0; i < m.count; i++) deep_m = fminf(deep_m, m.points[i].separation);
            for (uint32_t i = 0; i < n.count; i++) deep_n = fminf(deep_n, n.points[i].separation);
            assert_near(deep_m, deep_n, 2e-3);
        }
        daft_hull_free(hull);
        daft_trimesh_free(&allocator, &mesh);
    }
    print_message("%d contacts, %d with one normal, %d with as many points\n", contacts, faces, same);
    assert_true(contacts > 100 && faces > 0.97 * contacts && same > 0.97 * faces);
}

static float deepest_of(const daft_manifold *m)
{
    float least = INFINITY;
    for (uint32_t i = 0; i < m->count; i++) least = fminf(least, m->points[i].separation);
    return least;
}

/* What is over a face, with ends beyond its rim or not, has the points that clipping gives. */
static void capsules_on_boxes_are_on_hulls(void **unused)
{
    (void)unused;
    fixture_seed(618);
    daft_allocator allocator = daft_malloc_allocator();
    int two = 0, one = 0, hanging = 0, others = 0;
    for (int round = 0; round < 2000; round++) {
        daft_sim_shape capsule = must_capsule(random_float(0.3f, 2), random_float(0.1f, 0.4f)),
                       box = must_box(1, 0.7f, 1.3f);
        daft_quat turn = {random_float(-0.1f, 0.1f), random_float(-1, 1), random_float(0.6f, 0.8f), 0.7f};
        double x = (double)random_float(-1.2f, 1.2f), z = (double)random_float(-1.5f, 1.5f);
        double y = 0.7 + (double)(capsule.radius * random_float(0.8f, 1.1f));
        daft_rigid ground = daft_rigid_identity(), lying = daft_rigid_make(daft_dv3(x, y, z), turn);
        daft_trimesh mesh;
        daft_trimesh_box(&allocator, daft_scale(box.half, 2), &mesh, NULL);
        daft_hull *hull = daft_hull_create_mesh(&allocator, &mesh, daft_v3(1, 1, 1), 0, NULL);
        daft_sim_shape as_hull = daft_shape_hull(hull);
        daft_relpose pose = daft_relpose_make(&lying, &ground);
        daft_manifold m = {.count = 0}, n = {.count = 0};
        daft_collide(&capsule, &box, &pose, 0.05f, &m, 1, NULL);
        daft_collide(&capsule, &as_hull, &pose, 0.05f, &n, 1, NULL);
        bool like = m.count == n.count && (m.count == 0 || (daft_dot(m.normal, n.normal) > 0.9999f &&
                                                            fabsf(deepest_of(&m) - deepest_of(&n)) < 2e-3f));
        for (uint32_t i = 0; like && i < m.count; i++) {
            float nearest = INFINITY;
            for (uint32_t k = 0; k < n.count; k++)
                nearest = fminf(nearest, daft_length(daft_sub(m.points[i].point, n.points[k].point)));
            like = nearest < 5e-3f;
            if (m.count == 2) hanging += fabsf(m.points[i].point.y) < 0.98f * capsule.half_height;
        }
        others += !like;
        two += m.count == 2, one += m.count == 1;
        daft_hull_free(hull);
        daft_trimesh_free(&allocator, &mesh);
    }
    print_message("%d with two points, %d with one, %d points at the rim, %d not as with a hull\n", two, one, hanging,
                  others);
    assert_true(two > 300 && one > 100 && hanging > 200 && others < 10);
}

static void capsules_lie_on_two_points(void **unused)
{
    (void)unused;
    daft_sim_shape capsule = must_capsule(1, 0.25f), box = must_box(3, 1, 3), other = must_capsule(2, 0.5f);
    daft_rigid ground = daft_rigid_identity();
    daft_rigid lying = daft_rigid_make(daft_dv3(0.3, 1.25 - 0.01, 0.2), (daft_quat){0, 0, 1, 1});
    daft_relpose pose = daft_relpose_make(&lying, &ground);
    daft_manifold m;
    assert_int_equal(daft_collide(&capsule, &box, &pose, 0.02f, &m, 1, NULL), 1);
    assert_int_equal(m.count, 2);
    for (int i = 0; i < 2; i++) {
        assert_near(m.points[i].separation, -0.01f, 1e-6);
        assert_near(fabsf(m.points[i].point.y), 1, 1e-5);
    }
    lying = daft_rigid_make(daft_dv3(0.7, 0.4, 0), (daft_quat){0, 0, 0, 1});
    pose = daft_relpose_make(&lying, &ground);
    assert_int_equal(daft_collide(&capsule, &other, &pose, 0.02f, &m, 1, NULL), 1);
    assert_int_equal(m.count, 2);
    assert_near(m.points[0].separation, -0.05f, 1e-6);
    assert_near(m.normal.x, -1, 1e-6);
}

/* What lies exactly in the middle of another leaves it somehow. */
static void nothing_is_undecided_in_the_middle(void **unused)
{
    (void)unused;
    fixture_seed(605);
    for (uint32_t a = 0; a < KINDS; a++)
        for (uint32_t b = 0; b < KINDS; b++)
            for (int round = 0; round < 30; round++) {
                daft_sim_shape sa = random_shape(a, 1), sb = round % 2 ? random_shape(b, 1) : sa;
                daft_rigid pa = daft_rigid_identity(), pb = round % 4 > 1 ? random_rigid(0) : pa;
                if (sa.type == DAFT_GEOMETRY_HULL) pa.p = daft_dscale(daft_to_double(sa.hull->centre), -1);
                if (sb.type == DAFT_GEOMETRY_HULL)
                    pb.p = daft_dscale(daft_rigid_vector(&pb, daft_to_double(sb.hull->centre)), -1);
                daft_relpose pose = daft_relpose_make(&pa, &pb);
                daft_manifold m;
                if (daft_collide(&sa, &sb, &pose, 0.01f, &m, 1, NULL) != 1) fail_msg("%s and %s", NAMES[a], NAMES[b]);
                assert_true(m.count >= 1 && fabsf(daft_length(m.normal) - 1) < 1e-4f);
                float deepest = INFINITY;
                for (uint32_t i = 0; i < m.count; i++) {
                    assert_true(daft_finite3(m.points[i].point));
                    deepest = fminf(deepest, m.points[i].separation);
                }
                assert_true(deepest < 0);
                drop_hulls();
            }
}

static void sizes_from_ants_to_planets(void **unused)
{
    (void)unused;
    fixture_seed(606);
    for (float scale = 2e-4f; scale < 1e7f; scale *= 10)
        for (int round = 0; round < 100; round++) {
            daft_sim_shape a = must_box(scale * 0.9f, scale * 0.6f, scale * 0.7f),
                           b = must_box(scale, scale, scale * 0.5f);
            daft_sim_shape big_a = must_box(0.9f, 0.6f, 0.7f), big_b = must_box(1, 1, 0.5f);
            daft_rigid pa = daft_rigid_identity(), pb = random_rigid(0.8f);
            daft_relpose one = daft_relpose_make(&pa, &pb);
            pb.p = daft_dscale(pb.p, (double)scale);
            daft_relpose scaled = daft_relpose_make(&pa, &pb);
            daft_manifold m = {0}, n = {0};
            assert_int_equal(daft_collide(&big_a, &big_b, &one, 0.01f, &m, 1, NULL),
                             daft_collide(&a, &b, &scaled, 0.01f * scale, &n, 1, NULL));
            float deep_m = INFINITY, deep_n = INFINITY;
            for (uint32_t i = 0; i < m.count; i++) deep_m = fminf(deep_m, m.points[i].separation);
            for (uint32_t i = 0; i < n.count; i++) deep_n = fminf(deep_n, n.points[i].separation / scale);
            assert_true(m.count == 0 || fabsf(deep_m - deep_n) < 1e-4f);
        }
}

static void odd_poses_give_nothing(void **unused)
{
    (void)unused;
    daft_sim_shape a = must_box(1, 1, 1), b = must_sphere(1);
    daft_rigid pa = daft_rigid_identity(), pb = pa;
    daft_manifold m;
    pb.p.x = NAN;
    daft_relpose pose = daft_relpose_make(&pa, &pb);
    assert_int_equal(daft_collide(&a, &b, &pose, 0.1f, &m, 1, NULL), 0);
    pb.p.x = INFINITY;
    pose = daft_relpose_make(&pa, &pb);
    assert_int_equal(daft_collide(&a, &b, &pose, 0.1f, &m, 1, NULL), 0);
    pb.p.x = 1e30;
    pose = daft_relpose_make(&pa, &pb);
    assert_int_equal(daft_collide(&a, &a, &pose, 0.1f, &m, 1, NULL), 0);
    assert_int_equal(daft_collide(&a, &b, &pose, 0.1f, &m, 1, NULL), 0);
    pb.p.x = 0;
    pose = daft_relpose_make(&pa, &pb);
    assert_int_equal(daft_collide(&a, &b, &pose, NAN, &m, 1, NULL), 0);
    daft_sim_shape s;
    daft_error error = {0};
    assert_false(daft_shape_sphere(NAN, &s, &error) || daft_shape_sphere(0, &s, &error) ||
                 daft_shape_sphere(-1, &s, &error) || daft_shape_sphere(1e8f, &s, &error) ||
                 daft_shape_capsule(-1, 1, &s, &error) || daft_shape_capsule(1, 0, &s, &error) ||
                 daft_shape_box(daft_v3(1, 0, 1), &s, &error) || daft_shape_box(daft_v3(1, INFINITY, 1), &s, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
}

/* ---- pairs of boxes, side by side ---- */

/* Boxes of any turn to each other, or along each other's axes, where corners and edges meet; apart and deep; now and
 * then one is as large beside the other as a crate's floor. */
static sample random_boxes(int round)
{
    static const float depths[] = {-0.3f, -0.04f, -0.004f, 1e-4f, 0.01f, 0.1f, 0.4f, 0.9f};
    static const float ratios[] = {5, 0.1f, 100, 2000};
    float ratio = round % 3 == 0 ? 1 : round % 5 == 0 ? ratios[random_bits() % 4] : random_float(0.8f, 2);
    sample s = random_sample(2, 2, ratio, depths[round % 8], 20);
    if (round % 4 != 3) return s;
    float coarse = round % 8 == 3 ? 0.25f : 0;
    if (round % 3 == 0) s.b = s.a;
    float low = fminf(s.a.half.x, fminf(s.a.half.y, s.a.half.z));
    daft_quat turn = {0, 0, 0, 1};
    daft_vec3 axis = {0, 0, 0};
    int about = (int)(random_bits() % 3);
    daft_v3_put(&axis, about, round % 5 == 0 ? 1 : random_float(-1e-5f, 1e-5f));
    turn.x = axis.x, turn.y = axis.y, turn.z = axis.z;
    daft_rigid relative = daft_rigid_make(daft_dv3(0, 0, 0), turn);
    double p[3];
    for (int k = 0; k < 3; k++) p[k] = (double)(coarse * low * (float)(random_bits() % 9));
    p[random_bits() % 3] = (double)(s.a.half.x + s.b.half.x);
    relative.p = daft_dv3(p[0], p[1], p[2]);
    s.pose_a = daft_rigid_identity();
    s.pose_b = relative;
    return s;
}

/* What a lane says is what the pair's own first lane says, in the narrowest lanes there are, bit for bit. */
static void check_lane(const daft_box_batch *asked, daft_box_batch *done, int lane, const sample *s)
{
    static const daft_box_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_box);
    daft_box_batch one = {0};
    daft_box_batch_put(&one, 0, &s->pose_a, &s->pose_b, s->a.half, s->b.half);
    one.margin[0] = asked->margin[lane], one.kind[0] = asked->kind[lane];
    TABLE[0]->collide(&one, 1);
    assert_int_equal(done->kind[lane], one.kind[0]);
    assert_int_equal(done->found.count[lane], one.found.count[0]);
    if (!one.found.count[0]) return;
    daft_vec3 n = daft_lane_get(one.found.normal, 0), normal = daft_lane_get(done->found.normal, lane);
    assert_memory_equal(&normal, &n, sizeof n);
    for (int i = 0; i < one.found.count[0]; i++) {
        daft_vec3 at = daft_lane_get(one.found.point[i], 0), point = daft_lane_get(done->found.point[i], lane);
        assert_memory_equal(&point, &at, sizeof at);
        assert_memory_equal(&done->found.separation[i][lane], &one.found.separation[i][0], sizeof(float));
        assert_int_equal(done->found.id[i][lane], one.found.id[i][0]);
    }
}

/* In the frame of a, as daft_collide has it, the pair says the same, but for the rounding of another frame. */
static void check_alone(const daft_box_batch *asked, daft_box_batch *done, int lane, const sample *s)
{
    daft_pair_cache cache = {.kind = (uint8_t)asked->kind[lane]};
    daft_manifold m = {.count = 0};
    daft_relpose pose = daft_relpose_make(&s->pose_a, &s->pose_b);
    uint32_t found = daft_collide(&s->a, &s->b, &pose, asked->margin[lane], &m, 1, &cache);
    float size = (float)s->size;
    assert_int_equal(done->kind[lane], cache.kind);
    assert_int_equal(done->found.count[lane], found ? (int)m.count : 0);
    for (uint32_t i = 0; found && i < m.count; i++) {
        daft_vec3 at = daft_to_float(daft_rigid_vector(&s->pose_a, daft_to_double(m.points[i].point)));
        daft_vec3 off = daft_sub(daft_lane_get(done->found.point[i], lane), at);
        assert_true(daft_length(off) < 1e-5f * size);
        assert_near(done->found.separation[i][lane], m.points[i].separation, 1e-5 * (double)size);
        assert_int_equal((uint32_t)done->found.id[i][lane], m.points[i].id);
    }
}

static void lanes_are_one_pair_each(void **unused)
{
    (void)unused;
    fixture_seed(611);
    static const daft_box_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_box);
    int found[DAFT_AXIS_CLOSEST] = {0};
    for (int round = 0; round < 3000; round++) {
        sample samples[DAFT_PAIR_LANES];
        daft_box_batch batch = {0}, done;
        int lanes = 1 + (int)(random_bits() % DAFT_PAIR_LANES);
        for (int i = 0; i < lanes; i++) {
            sample *s = &samples[i];
            *s = random_boxes(i + round);
            batch.margin[i] = 0.05f * (float)s->size;
            batch.kind[i] = (int32_t)(random_bits() % DAFT_AXIS_CLOSEST);
            daft_box_batch_put(&batch, i, &s->pose_a, &s->pose_b, s->a.half, s->b.half);
        }
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            done = batch;
            TABLE[isa]->collide(&done, lanes);
            for (int i = 0; i < lanes; i++) {
                check_lane(&batch, &done, i, &samples[i]);
                if (isa == 0) check_alone(&batch, &done, i, &samples[i]);
                found[done.found.count[i] ? done.kind[i] : 0]++;
            }
        }
    }
    print_message("%d apart, %d and %d on faces, %d on edges\n", found[0], found[1], found[2], found[3]);
    for (int i = 0; i < DAFT_AXIS_CLOSEST; i++) assert_true(found[i] > 1000);
}

/* ---- spheres, capsules and boxes, side by side ---- */

static daft_outline outline_of(const daft_sim_shape *s, const daft_rigid *pose, daft_rigid *frame)
{
    daft_outline out = {.centre = pose->p, .reach = (float)extent(s), .centred = true};
    out.kind = s->type == DAFT_GEOMETRY_BOX ? DAFT_OUTLINE_BOX : DAFT_OUTLINE_ROUND;
    double h = s->type == DAFT_GEOMETRY_CAPSULE ? (double)s->half_height : 0;
    out.half = daft_v3((float)(h * pose->m[1]), (float)(h * pose->m[4]), (float)(h * pose->m[7]));
    if (out.kind == DAFT_OUTLINE_BOX)
        out.half = s->half;
    else
        out.radius = s->radius;
    *frame = *pose;
    return out;
}

/* Along an edge of a box every place of a capsule is as near: there the point may be another one. */
static bool is_point_of(const sample *s, daft_round_batch *batch, int lane, int i, const daft_manifold_point *p)
{
    daft_vec3 at = daft_to_float(daft_rigid_vector(&s->pose_a, daft_to_double(p->point)));
    daft_vec3 off = daft_sub(daft_lane_get(batch->found.point[i], lane), at);
    uint32_t id = (uint32_t)batch->found.id[i][lane];
    float size = (float)s->size;
    if (!(fabsf(batch->found.separation[i][lane] - p->separation) < 2e-5f * size)) return false;
    bool along_edge = id >> 28 == 5 && p->id >> 28 == 5 &&
                      fabsf(daft_dot(off, daft_lane_get(batch->found.normal, lane))) < 2e-5f * size;
    return along_edge || (id == p->id && daft_length(off) < 2e-3f * size);
}

/* Gives whether a lane says what the slow way does; where that is on an edge between two answers, it may say the other.
 */
static bool is_like_one(const sample *s, daft_round_batch *batch, int lane, float margin)
{
    daft_manifold m = {.count = 0};
    daft_relpose pose = daft_relpose_make(&s->pose_a, &s->pose_b);
    uint32_t found = daft_collide(&s->a, &s->b, &pose, margin, &m, 1, NULL);
    if (batch->state[lane] != DAFT_ROUND_MET) return !found;
    if (!found || (int)m.count != batch->found.count[lane]) return false;
    daft_vec3 n = daft_to_float(daft_rigid_vector(&s->pose_a, daft_to_double(m.normal)));
    if (daft_length(daft_sub(n, daft_lane_get(batch->found.normal, lane))) > 2e-3f) return false;
    for (uint32_t i = 0; i < m.count; i++)
        if (!is_point_of(s, batch, lane, (int)i, &m.points[i])) return false;
    return true;
}

/* A round one and another, b or a may be a box; often along its axes, where ends hang over rims. */
static sample random_rounds(int round, bool boxed)
{
    static const float depths[] = {-0.3f, -0.04f, -0.004f, 1e-4f, 0.01f, 0.1f, 0.4f};
    uint32_t kind_a = random_bits() & 1, kind_b = random_bits() & 1;
    if (boxed && round % 2) kind_a = 2;
    if (boxed && round % 2 == 0) kind_b = 2;
    sample s = random_sample(kind_a, kind_b, random_float(0.3f, 3), depths[round % 7], 20);
    if (round % 3 == 0) {
        daft_rigid relative = daft_rigid_relative(&s.pose_a, &s.pose_b);
        daft_quat turn = round % 9 ? (daft_quat){0, 0, 0.70710678f, 0.70710678f} : daft_quat_identity();
        relative = daft_rigid_make(relative.p, turn);
        s.pose_b = daft_rigid_mul(&s.pose_a, &relative);
    }
    return s;
}

static void fill_rounds(daft_round_batch *batch, daft_outline *outlines, daft_rigid *frames, const sample *s, int lane,
                        float margin)
{
    uint32_t a = 2 * (uint32_t)lane, b = a + 1;
    outlines[a] = outline_of(&s->a, &s->pose_a, &frames[a]), outlines[b] = outline_of(&s->b, &s->pose_b, &frames[b]);
    daft_round_batch_put(batch, lane, outlines, a, b, margin);
    bool box_first = outlines[a].kind == DAFT_OUTLINE_BOX;
    if (!box_first && outlines[b].kind != DAFT_OUTLINE_BOX) return;
    const daft_rigid *frame = &frames[box_first ? a : b];
    daft_dvec3 centre = daft_rigid_to_local(frame, outlines[box_first ? b : a].centre);
    daft_round_batch_put_box(batch, lane, outlines, centre, frame->m, box_first);
}

static void check_rounds(bool boxed, int states[3], int *others)
{
    static const daft_round_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_round);
    for (int round = 0; round < 2000; round++) {
        sample samples[DAFT_PAIR_LANES];
        daft_outline outlines[2 * DAFT_PAIR_LANES];
        daft_rigid frames[2 * DAFT_PAIR_LANES];
        daft_round_batch batch = {0}, done, first;
        int lanes = 1 + (int)(random_bits() % DAFT_PAIR_LANES);
        memset(outlines, 0, sizeof outlines);
        for (int i = 0; i < lanes; i++) {
            samples[i] = random_rounds(i + round, boxed);
            fill_rounds(&batch, outlines, frames, &samples[i], i, 0.05f * (float)samples[i].size);
        }
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            done = batch;
            (boxed ? TABLE[isa]->boxes : TABLE[isa]->rounds)(outlines, &done, lanes);
            if (isa == 0) first = done;
            for (int i = 0; i < lanes; i++) {
                assert_int_equal(done.state[i], first.state[i]);
                states[done.state[i]] += isa == 0;
                if (done.state[i] == DAFT_ROUND_ASK) continue;
                *others += !is_like_one(&samples[i], &done, i, batch.margin[i]);
                if (done.state[i] == DAFT_ROUND_MET) assert_int_equal(done.found.count[i], first.found.count[i]);
                for (int k = 0; done.state[i] == DAFT_ROUND_MET && k < done.found.count[i]; k++)
                    assert_true(done.found.id[k][i] == first.found.id[k][i] &&
                                done.found.separation[k][i] == first.found.separation[k][i] &&
                                done.found.point[k][0][i] == first.found.point[k][0][i] &&
                                done.found.normal[1][i] == first.found.normal[1][i]);
            }
        }
    }
}

static void round_lanes_are_one_pair_each(void **unused)
{
    (void)unused;
    fixture_seed(617);
    for (int boxed = 0; boxed < 2; boxed++) {
        int states[3] = {0}, others = 0;
        check_rounds(boxed, states, &others);
        print_message("%s: %d apart, %d met, %d to be asked, %d not as one pair\n", boxed ? "boxes" : "rounds",
                      states[0], states[1], states[2], others);
        assert_true(states[0] > 3000 && states[1] > 2000 && states[2] >= 50 * boxed && others == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_touch_as_they_should),
        cmocka_unit_test(a_crate_on_a_huge_floor),
        cmocka_unit_test(a_stack_keeps_its_corners),
        cmocka_unit_test(boxes_are_hulls),
        cmocka_unit_test(capsules_lie_on_two_points),
        cmocka_unit_test(capsules_on_boxes_are_on_hulls),
        cmocka_unit_test(nothing_is_undecided_in_the_middle),
        cmocka_unit_test(sizes_from_ants_to_planets),
        cmocka_unit_test(odd_poses_give_nothing),
        cmocka_unit_test(lanes_are_one_pair_each),
        cmocka_unit_test(round_lanes_are_one_pair_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
