/* Distances, rays, casts and times of impact: against slow distances, and by looking at many moments in between. */
#include "shape_cases.h"

enum { KINDS = 4 };

static daft_hull *hull_made;

/* hull_made is the hull's, to be freed with drop. */
static daft_sim_shape any_shape(uint32_t kind, float size)
{
    switch (kind) {
    case 0: return must_sphere(size * random_float(0.3f, 1));
    case 1: return must_capsule(size * random_float(0.2f, 1), size * random_float(0.1f, 0.6f));
    case 2: return must_box(size * random_float(0.1f, 1), size * random_float(0.2f, 1), size * random_float(0.2f, 1));
    default:
        hull_made = random_hull(6 + random_bits() % 20, daft_v3(size, size, size));
        return daft_shape_hull(hull_made);
    }
}

static void drop(daft_sim_shape *s)
{
    if (s->type == DAFT_GEOMETRY_HULL) daft_hull_free((daft_hull *)(uintptr_t)s->hull);
}

static void distances_are_the_least(void **unused)
{
    (void)unused;
    fixture_seed(701);
    for (int round = 0; round < 3000; round++) {
        float ratio = round % 5 ? 1 : 0.05f;
        daft_sim_shape a = any_shape(random_bits() % KINDS, 1), b = any_shape(random_bits() % KINDS, ratio);
        daft_rigid identity = daft_rigid_identity(), pose = random_rigid(round % 3 ? 3 : 1);
        cloud ca = cloud_of(&a, &identity), cb = cloud_of(&b, &pose);
        double should = fmax(0, oracle_distance(&ca, &cb) - ca.radius - cb.radius);
        daft_distance d;
        assert_true(daft_shape_distance(&a, &b, &pose, INFINITY, &d));
        /* The oracle comes from above, and may stop short; the planes below prove what is larger than rounding. */
        if (!(d.distance < should + 1e-6)) fail_msg("round %d: %.9g is more than %.9g", round, d.distance, should);
        if (d.distance < 1e-3) assert_true(should < 0.05);
        if (d.distance > 1e-3) {
            daft_dvec3 gap = daft_dsub(d.on_b, d.on_a);
            assert_near(sqrt(daft_ddot(gap, gap)), d.distance, 1e-9);
            assert_near(daft_ddot(gap, d.normal), d.distance, 1e-9);
            /* No point of either is beyond the planes through the closest points. */
            assert_near(apart_along(&ca, &cb, d.normal), d.distance, 1e-7);
            assert_false(daft_shape_distance(&a, &b, &pose, 0.99 * d.distance, &d));
        }
        assert_int_equal(daft_shape_overlap(&a, &b, &pose, should + 1e-4), true);
        drop(&a), drop(&b);
    }
}

/* Degenerate simplices: faces, edges and corners exactly over each other, at all sizes. */
static void distances_of_aligned_boxes(void **unused)
{
    (void)unused;
    for (double scale = 1e-3; scale < 1e7; scale *= 10)
        for (int x = -2; x <= 2; x++)
            for (int y = -2; y <= 2; y++)
                for (int z = -2; z <= 2; z++) {
                    daft_sim_shape a = must_box((float)scale, (float)scale, (float)scale), b = a;
                    daft_rigid pose = daft_rigid_identity();
                    double h = (double)a.half.x, gap[3], square = 0;
                    pose.p = daft_dv3(x * 1.5 * h, y * 1.5 * h, z * 1.5 * h);
                    const int at[3] = {x, y, z};
                    for (int k = 0; k < 3; k++)
                        gap[k] = fmax(0, abs(at[k]) * 1.5 * h - 2 * h), square += gap[k] * gap[k];
                    daft_distance d;
                    assert_true(daft_shape_distance(&a, &b, &pose, INFINITY, &d));
                    assert_near(d.distance, sqrt(square), 1e-9 * h);
                }
}

static double distance_to(const daft_sim_shape *s, daft_dvec3 p)
{
    daft_dvec3 on;
    double distance;
    daft_shape_part part;
    return daft_shape_closest(s, p, INFINITY, &on, &distance, &part) ? distance : INFINITY;
}

static void rays_end_at_the_surface(void **unused)
{
    (void)unused;
    fixture_seed(702);
    int hits = 0;
    for (int round = 0; round < 4000; round++) {
        daft_sim_shape s = any_shape((uint32_t)round % KINDS, 1);
        daft_dvec3 origin = daft_to_double(random_vec3(-4, 4)), aim = daft_to_double(random_vec3(-0.8f, 0.8f));
        daft_dvec3 d = daft_dsub(aim, origin);
        if (round % 7 == 0) d.x = 0, d.z = 0, d.y = -1;
        daft_ray_result r;
        bool hit = daft_shape_raycast(&s, origin, d, 2, &r);
        double end = hit ? r.t : 2;
        for (int i = 0; i < 50; i++) {
            daft_dvec3 p = daft_dadd(origin, daft_dscale(d, end * i / 50.0));
            if (!(distance_to(&s, p) > 0) && end > 0) fail_msg("round %d: through the surface at %d/50", round, i);
        }
        if (hit) {
            hits++;
            daft_dvec3 p = daft_dadd(origin, daft_dscale(d, r.t));
            assert_true(distance_to(&s, p) < 1e-6);
            assert_near(daft_length(r.normal), 1, 1e-5);
            assert_true(daft_ddot(daft_to_double(r.normal), d) <= 0);
        } else if (round % 7 && distance_to(&s, aim) == 0) {
            fail_msg("round %d: a ray to a point inside misses", round);
        }
        drop(&s);
    }
    assert_true(hits > 1000);
    daft_ray_result r;
    daft_sim_shape ball = must_sphere(1);
    assert_true(daft_shape_raycast(&ball, daft_dv3(0.5, 0, 0), daft_dv3(1, 0, 0), 1, &r) && r.t == 0);
    assert_false(daft_shape_raycast(&ball, daft_dv3(3, 0, 0), daft_dv3(0, 0, 0), 1, &r));
    assert_false(daft_shape_raycast(&ball, daft_dv3(3, 0, 0), daft_dv3(NAN, 0, 0), 1, &r));
    assert_false(daft_shape_raycast(&ball, daft_dv3(INFINITY, 0, 0), daft_dv3(1, 0, 0), 1, &r));
    assert_true(daft_shape_raycast(&ball, daft_dv3(1e9, 0, 0), daft_dv3(-1e-20, 0, 0), INFINITY, &r));
    assert_near(r.t * 1e-20, 1e9 - 1, 1);
}

static double distance_of(const daft_sim_shape *a, const daft_rigid *fa, const daft_sim_shape *b, const daft_rigid *fb)
{
    daft_rigid relative = daft_rigid_relative(fa, fb);
    daft_distance d;
    assert_true(daft_shape_distance(a, b, &relative, INFINITY, &d));
    return d.distance;
}

static void casts_stop_at_the_first_touch(void **unused)
{
    (void)unused;
    fixture_seed(703);
    int kinds[4] = {0};
    for (int round = 0; round < 3000; round++) {
        daft_sim_shape a = any_shape(random_bits() % KINDS, round % 3 ? 1 : 0.02f),
                       b = any_shape(random_bits() % KINDS, 1);
        daft_rigid pose = random_rigid(4), identity = daft_rigid_identity();
        daft_dvec3 motion = daft_dsub(daft_to_double(random_vec3(-1, 1)), pose.p);
        motion = daft_dscale(motion, round % 2 ? 1 : 2);
        daft_impact hit;
        daft_impact_kind kind = daft_shape_cast(&a, &pose, motion, &b, &hit);
        kinds[kind]++;
        double before = distance_of(&a, &pose, &b, &identity), end = kind == DAFT_IMPACT_MISS ? 1 : hit.t;
        if (kind == DAFT_IMPACT_OVERLAP) assert_true(before < 1e-9);
        for (int i = 0; i < 40 && kind != DAFT_IMPACT_OVERLAP; i++) {
            daft_rigid at = pose;
            at.p = daft_dadd(pose.p, daft_dscale(motion, end * i / 40.0));
            if (!(distance_of(&a, &at, &b, &identity) > 0)) fail_msg("round %d: touches at %d/40 already", round, i);
        }
        if (kind == DAFT_IMPACT_HIT) {
            daft_rigid at = pose;
            at.p = daft_dadd(pose.p, daft_dscale(motion, hit.t));
            assert_true(distance_of(&a, &at, &b, &identity) < 1e-5);
            assert_near(distance_to(&b, hit.point), 0, 1e-5);
        }
        drop(&a), drop(&b);
    }
    print_message("%d missed, %d hit, %d overlapped, %d gave up\n", kinds[0], kinds[1], kinds[2], kinds[3]);
    assert_true(kinds[DAFT_IMPACT_HIT] > 1000 && kinds[DAFT_IMPACT_GAVE_UP] == 0);
}

static void turning_bodies_do_not_pass(void **unused)
{
    (void)unused;
    fixture_seed(704);
    int kinds[4] = {0};
    const double target = 0.005, tolerance = 0.001;
    for (int round = 0; round < 1500; round++) {
        daft_sim_shape a = any_shape(random_bits() % KINDS, 1), b = any_shape(random_bits() % KINDS, 1);
        daft_sweep sa = {.from = daft_to_double(random_vec3(-4, 4)), .to = daft_to_double(random_vec3(-4, 4))};
        daft_sweep sb = {.from = daft_to_double(random_vec3(-1, 1)), .to = daft_to_double(random_vec3(-1, 1))};
        sa.rotation_from = random_rotation(), sa.rotation_to = random_rotation();
        sb.rotation_from = random_rotation(), sb.rotation_to = round % 2 ? sb.rotation_from : random_rotation();
        sa.centre = random_vec3(-0.2f, 0.2f);
        daft_impact hit;
        daft_impact_kind kind = daft_shape_impact(&a, &sa, &b, &sb, target, tolerance, &hit);
        kinds[kind]++;
        double end = kind == DAFT_IMPACT_MISS ? 1 : hit.t;
        for (int i = 0; i <= 60; i++) {
            daft_rigid fa = daft_sweep_frame(&sa, end * i / 60.0), fb = daft_sweep_frame(&sb, end * i / 60.0);
            double d = distance_of(&a, &fa, &b, &fb);
            if (kind == DAFT_IMPACT_OVERLAP) {
                assert_true(d <= target + 1e-5);
                break;
            }
            if (!(d > target - tolerance)) fail_msg("round %d: %g m at %d/60, kind %d", round, d, i, kind);
            if (i == 60 && kind == DAFT_IMPACT_HIT) assert_true(d < target + 1.1 * tolerance);
        }
        drop(&a), drop(&b);
    }
    print_message("%d missed, %d hit, %d overlapped, %d gave up\n", kinds[0], kinds[1], kinds[2], kinds[3]);
    assert_true(kinds[DAFT_IMPACT_HIT] > 200 && kinds[DAFT_IMPACT_GAVE_UP] < 30);
}

/* ---- surfaces ---- */

enum { SIDE = 12 };

static float wave(int x, int z) { return (float)((x * 7 + z * 13) % 5) * 0.1f - 0.2f; }

/* The same ground as a field and as a mesh, with a hole. */
static void ground(surface *mesh, daft_height_field **field)
{
    daft_allocator allocator = daft_malloc_allocator();
    float heights[SIDE * SIDE];
    daft_vec3 p[SIDE * SIDE];
    uint32_t index[6 * SIDE * SIDE], triangles = 0;
    for (int z = 0; z < SIDE; z++)
        for (int x = 0; x < SIDE; x++) {
            heights[z * SIDE + x] = x == 8 && z == 8 ? NAN : wave(x, z);
            p[z * SIDE + x] = daft_v3((float)x * 0.5f, wave(x, z), (float)z * 0.25f);
        }
    for (uint32_t z = 0; z + 1 < SIDE; z++)
        for (uint32_t x = 0; x + 1 < SIDE; x++) {
            if ((x == 7 || x == 8) && (z == 7 || z == 8)) continue;
            uint32_t a = z * SIDE + x;
            const uint32_t two[6] = {a, a + SIDE, a + SIDE + 1, a, a + SIDE + 1, a + 1};
            memcpy(index + 3 * triangles, two, sizeof two);
            triangles += 2;
        }
    *mesh = surface_of(mesh_make(p, SIDE * SIDE, index, triangles));
    *field = daft_height_field_create(&allocator, heights, SIDE, SIDE, 0.5f, 0.25f, NULL);
    assert_non_null(*field);
}

static void fields_and_meshes_agree(void **unused)
{
    (void)unused;
    fixture_seed(705);
    surface mesh;
    daft_height_field *field;
    ground(&mesh, &field);
    daft_sim_shape f = daft_shape_field(field);
    int hits = 0, through = 0;
    for (int round = 0; round < 3000; round++) {
        daft_dvec3 o = {(double)random_float(-1, 7), (double)random_float(-2, 3), (double)random_float(-1, 4)};
        daft_dvec3 d = daft_to_double(random_vec3(-3, 3));
        daft_ray_result r, q;
        bool hit = daft_shape_raycast(&f, o, d, 2, &r);
        assert_int_equal(daft_shape_raycast(&mesh.s, o, d, 2, &q), hit);
        if (hit) assert_near(r.t, q.t, 1e-7);
        hits += hit, through += !hit;
        /* One triangle after the other. */
        double nearest = 2, least = INFINITY;
        for (uint32_t t = 0; t < mesh.mesh->mesh.triangle_count; t++) {
            daft_vec3 c[3];
            for (uint32_t k = 0; k < 3; k++) {
                uint32_t v = mesh.mesh->mesh.indices[3 * t + k];
                c[k] = daft_v3(mesh.mesh->mesh.x[v], mesh.mesh->mesh.y[v], mesh.mesh->mesh.z[v]);
            }
            cloud triangle = {.count = 3, .points = {daft_to_double(c[0]), daft_to_double(c[1]), daft_to_double(c[2])}};
            cloud point = {.count = 1, .points = {o}};
            if (round % 20 == 0) least = fmin(least, oracle_distance(&point, &triangle));
            daft_dvec3 u = daft_dsub(triangle.points[1], triangle.points[0]),
                       v = daft_dsub(triangle.points[2], triangle.points[0]);
            daft_dvec3 n = daft_dcross(u, v);
            double at = daft_ddot(n, daft_dsub(triangle.points[0], o)) / daft_ddot(n, d);
            daft_dvec3 x = daft_dsub(daft_dadd(o, daft_dscale(d, at)), triangle.points[0]);
            double bv = daft_ddot(n, daft_dcross(u, x)) / daft_ddot(n, n),
                   bu = daft_ddot(n, daft_dcross(x, v)) / daft_ddot(n, n);
            if (at >= 0 && at < nearest && bu > -1e-9 && bv > -1e-9 && bu + bv < 1 + 1e-9) nearest = at;
        }
        assert_near(hit ? r.t : 2, nearest, 1e-6);
        if (round % 20) continue;
        assert_near(distance_to(&f, o), least, 1e-5);
        assert_near(distance_to(&mesh.s, o), least, 1e-5);
        daft_sim_shape a = any_shape((uint32_t)(round / 20) % KINDS, 0.2f);
        daft_rigid pose = random_rigid(0);
        daft_impact hm, hf;
        pose.p = o;
        daft_impact_kind kind = daft_shape_cast(&a, &pose, d, &f, &hf);
        assert_int_equal(daft_shape_cast(&a, &pose, d, &mesh.s, &hm), kind);
        if (kind == DAFT_IMPACT_HIT) assert_near(hf.t, hm.t, 1e-5);
        drop(&a);
    }
    print_message("%d rays hit, %d went by\n", hits, through);
    daft_height_field_free(field);
    surface_drop(&mesh);
}

/* A sheet of two triangles: aimed at the shared edge, its ends, and anywhere, from both sides, by all shapes, with
 * spin. */
static void paper_stops_bullets(void **unused)
{
    (void)unused;
    fixture_seed(706);
    const daft_vec3 p[4] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
    const uint32_t index[6] = {0, 2, 1, 0, 3, 2};
    surface sheet = surface_of(mesh_make(p, 4, index, 2));
    daft_sweep still = daft_sweep_still(&(daft_rigid){.m = {1, 0, 0, 0, 1, 0, 0, 0, 1}}, (daft_quat){0, 0, 0, 1});
    for (int round = 0; round < 4000; round++) {
        daft_sim_shape a = any_shape((uint32_t)round % KINDS, 0.05f);
        float s = random_float(-1, 1);
        daft_vec3 at = round % 3 == 0   ? daft_v3(s, 0, s)
                       : round % 3 == 1 ? p[round % 4]
                                        : daft_v3(s, 0, random_float(-1, 1));
        daft_dvec3 d = random_unit();
        if (fabs(d.y) < 0.05) d.y = 0.05;
        daft_sweep sa = {.from = daft_dsub(daft_to_double(at), daft_dscale(d, (double)random_float(1, 9))),
                         .to = daft_dadd(daft_to_double(at), daft_dscale(d, (double)random_float(1, 9)))};
        sa.rotation_from = random_rotation();
        sa.rotation_to = round % 2 ? sa.rotation_from : random_rotation();
        daft_rigid first = daft_sweep_frame(&sa, 0), identity = daft_rigid_identity();
        double before = distance_of(&a, &first, &sheet.s, &identity);
        daft_impact hit;
        daft_impact_kind kind = daft_shape_impact(&a, &sa, &sheet.s, &still, 1e-3, 2e-4, &hit);
        if (before < 1e-3)
            assert_int_equal(kind, DAFT_IMPACT_OVERLAP);
        else if (round % 3 == 1 && a.type == DAFT_GEOMETRY_HULL)
            (void)kind; /* past a corner of the sheet, a hull around something else than its middle may miss */
        else if (kind != DAFT_IMPACT_HIT)
            fail_msg("round %d, shape %d: went through (%d)", round, a.type, kind);
        drop(&a);
    }
    surface_drop(&sheet);
}

/* ---- compounds ---- */

static void compounds_are_their_children(void **unused)
{
    (void)unused;
    fixture_seed(707);
    daft_allocator allocator = daft_malloc_allocator();
    for (int round = 0; round < 300; round++) {
        daft_child children[20];
        uint32_t count = 1 + random_bits() % 20;
        for (uint32_t i = 0; i < count; i++) {
            daft_sim_shape s = any_shape(random_bits() % 3, 0.5f);
            children[i] = (daft_child){s, random_rigid(2)};
        }
        daft_compound *c = daft_compound_create(&allocator, children, count, NULL);
        daft_sim_shape whole = daft_shape_compound(c), b = any_shape(random_bits() % 3, 0.7f);
        daft_rigid pose = random_rigid(4), identity = daft_rigid_identity();
        daft_distance d, back;
        double least = INFINITY, first = 2;
        daft_dvec3 motion = daft_dscale(pose.p, -2), aim = daft_dscale(pose.p, -1);
        daft_impact hit;
        daft_ray_result ray;
        for (uint32_t i = 0; i < count; i++) {
            daft_rigid in_child = daft_rigid_relative(&children[i].pose, &pose);
            least = fmin(least, distance_of(&children[i].shape, &identity, &b, &in_child));
            if (daft_shape_raycast(&children[i].shape, daft_rigid_to_local(&children[i].pose, pose.p),
                                   daft_rigid_to_local_vector(&children[i].pose, aim), 1, &ray))
                first = fmin(first, ray.t);
        }
        assert_true(daft_shape_distance(&whole, &b, &pose, INFINITY, &d));
        assert_near(d.distance, least, 1e-9);
        daft_rigid inverse = daft_rigid_inverse(&pose);
        assert_true(daft_shape_distance(&b, &whole, &inverse, INFINITY, &back));
        assert_near(back.distance, least, 1e-9);
        bool any = daft_shape_raycast(&whole, pose.p, aim, 1, &ray);
        assert_int_equal(any, first < 2);
        if (any) assert_near(ray.t, first, 1e-9);
        daft_impact_kind kind = daft_shape_cast(&b, &pose, motion, &whole, &hit);
        double soonest = 2;
        for (uint32_t i = 0; i < count; i++) {
            daft_rigid in_child = daft_rigid_relative(&children[i].pose, &pose);
            daft_impact one;
            daft_impact_kind k = daft_shape_cast(&b, &in_child, daft_rigid_to_local_vector(&children[i].pose, motion),
                                                 &children[i].shape, &one);
            if (k != DAFT_IMPACT_MISS) soonest = fmin(soonest, one.t);
        }
        assert_int_equal(kind != DAFT_IMPACT_MISS, soonest < 2);
        if (kind == DAFT_IMPACT_HIT) assert_near(hit.t, soonest, 1e-5);
        daft_compound_free(c);
    }
    daft_error error = {0};
    daft_child bad = {{0}, daft_rigid_identity()};
    assert_null(daft_compound_create(&allocator, &bad, 1, &error));
    assert_null(daft_compound_create(&allocator, &bad, 0, &error));
    bad.shape = must_sphere(1), bad.pose.p.x = NAN;
    assert_null(daft_compound_create(&allocator, &bad, 1, &error));
}

static void odd_fields(void **unused)
{
    (void)unused;
    daft_allocator allocator = daft_malloc_allocator();
    float h[9] = {NAN, NAN, NAN, NAN, 1, NAN, NAN, NAN, NAN};
    daft_error error = {0};
    daft_ray_result r;
    daft_height_field *f = daft_height_field_create(&allocator, h, 3, 3, 1, 1, &error);
    assert_non_null(f);
    daft_sim_shape s = daft_shape_field(f), ball = must_sphere(5);
    assert_false(daft_shape_raycast(&s, daft_dv3(1, 5, 1), daft_dv3(0, -1, 0), 100, &r));
    daft_rigid a = daft_rigid_identity();
    daft_manifold m;
    daft_relpose pose = daft_relpose_make(&a, &a);
    assert_int_equal(daft_collide(&ball, &s, &pose, 1, &m, 1, NULL), 0);
    assert_false(daft_shape_overlap(&ball, &s, &a, 1));
    daft_height_field_free(f);
    assert_null(daft_height_field_create(&allocator, h, 1, 3, 1, 1, &error));
    assert_null(daft_height_field_create(&allocator, h, 3, 3, 0, 1, &error));
    assert_null(daft_height_field_create(&allocator, h, 3, 3, 1, NAN, &error));
    h[3] = 1e9f;
    assert_null(daft_height_field_create(&allocator, h, 3, 3, 1, 1, &error));
    h[3] = INFINITY;
    assert_null(daft_height_field_create(&allocator, h, 3, 3, 1, 1, &error));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_are_the_least),
        cmocka_unit_test(distances_of_aligned_boxes),
        cmocka_unit_test(rays_end_at_the_surface),
        cmocka_unit_test(casts_stop_at_the_first_touch),
        cmocka_unit_test(turning_bodies_do_not_pass),
        cmocka_unit_test(fields_and_meshes_agree),
        cmocka_unit_test(paper_stops_bullets),
        cmocka_unit_test(compounds_are_their_children),
        cmocka_unit_test(odd_fields),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
