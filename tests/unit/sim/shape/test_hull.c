/* Convex hulls: whatever points they get, a closed convex surface around them, or a message that says why not. */
#include "shape_cases.h"

static daft_hull *make(const daft_vec3 *points, uint32_t count, uint32_t most, daft_error *error)
{
    daft_allocator allocator = daft_malloc_allocator();
    return daft_hull_create(&allocator, points, count, most, error);
}

static double most_outside(const daft_hull *h, daft_vec3 p)
{
    double most = -INFINITY;
    for (uint32_t f = 0; f < h->face_count; f++)
        most =
            fmax(most, daft_ddot(daft_to_double(h->planes[f].normal), daft_to_double(p)) - (double)h->planes[f].offset);
    return most;
}

/* Topology and convexity; corners are points that were given. */
static void check_surface(const daft_hull *h, const daft_vec3 *points, uint32_t count)
{
    assert_int_equal(h->vertex_count + h->face_count, h->half_edge_count / 2 + 2);
    uint32_t walked = 0;
    for (uint16_t f = 0; f < h->face_count; f++) {
        uint16_t e = h->first_half_edges[f];
        uint32_t corners = 0;
        do {
            const daft_half_edge *edge = &h->half_edges[e], *twin = &h->half_edges[e ^ 1];
            assert_int_equal(edge->face, f);
            assert_int_equal(twin->origin, h->half_edges[edge->next].origin);
            assert_true(twin->face != f && edge->origin < h->vertex_count);
            e = edge->next;
            assert_true(++corners <= h->vertex_count);
        } while (e != h->first_half_edges[f]);
        assert_true(corners >= 3);
        walked += corners;
    }
    assert_int_equal(walked, h->half_edge_count);
    double size = (double)daft_length(daft_sub(h->high, h->low)), far = 0;
    for (uint32_t i = 0; i < count; i++) far = fmax(far, (double)daft_length(points[i]));
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        assert_true(most_outside(h, h->vertices[i]) <= 1e-6 * (size + far));
        bool given = false;
        for (uint32_t k = 0; k < count && !given; k++)
            given = memcmp(&points[k], &h->vertices[i], sizeof points[k]) == 0;
        assert_true(given);
    }
}

static void check_all(const daft_hull *h, const daft_vec3 *points, uint32_t count)
{
    check_surface(h, points, count);
    double size = 0;
    for (uint32_t i = 0; i < count; i++) size = fmax(size, (double)daft_length(points[i]));
    for (uint32_t i = 0; i < count; i++)
        assert_true(most_outside(h, points[i]) <= (double)h->deviation * 1.00001 + 5e-6 * size);
}

static void random_clouds_are_wrapped(void **unused)
{
    (void)unused;
    fixture_seed(501);
    daft_vec3 points[400];
    for (int round = 0; round < 600; round++) {
        uint32_t count = 4 + random_bits() % 60, kind = random_bits() % 4;
        float scale = (float)daft_exp2((double)random_float(-10, 20));
        daft_vec3 offset = random_vec3(-3 * scale, 3 * scale);
        for (uint32_t i = 0; i < count; i++) {
            daft_vec3 p = random_vec3(-1, 1);
            if (kind == 1) p = daft_normalize(p);
            if (kind == 2) p = daft_v3(roundf(2 * p.x), roundf(2 * p.y), roundf(2 * p.z)); /* many in one plane */
            if (kind == 3) p.y *= 1e-3f;
            points[i] = daft_add(daft_scale(p, scale), kind == 3 ? daft_v3(0, 0, 0) : offset);
        }
        daft_error error = {0};
        daft_hull *h = make(points, count, 0, &error);
        if (!h) { /* a few points of a small grid may lie in one plane */
            assert_int_equal(kind, 2);
            assert_non_null(strstr(error.message, "all in one plane"));
            continue;
        }
        check_all(h, points, count);
        daft_hull_free(h);
    }
}

static void boxes_have_six_faces(void **unused)
{
    (void)unused;
    fixture_seed(502);
    for (int round = 0; round < 300; round++) {
        daft_vec3 corners[27 + 8], half = random_vec3(0.1f, 3);
        daft_rigid pose = random_rigid(round % 2 ? 0 : 5);
        uint32_t count = 0;
        for (int i = 0; i < 27; i++) { /* with points on edges and faces, and one inside */
            daft_vec3 p = daft_mul(daft_v3((float)(i % 3 - 1), (float)(i / 3 % 3 - 1), (float)(i / 9 - 1)), half);
            corners[count++] = round % 3 ? daft_to_float(daft_rigid_point(&pose, daft_to_double(p))) : p;
        }
        for (int i = 0; i < 8; i++) corners[count++] = corners[i]; /* and duplicates */
        daft_hull *h = make(corners, count, 0, NULL);
        assert_non_null(h);
        check_all(h, corners, count);
        assert_int_equal(h->vertex_count, 8);
        assert_int_equal(h->face_count, 6);
        daft_hull_free(h);
    }
}

static void too_many_points_are_thinned_by_what_sticks_out(void **unused)
{
    (void)unused;
    fixture_seed(503);
    enum { COUNT = 10000 };
    daft_vec3 *points = malloc(COUNT * sizeof *points);
    for (int i = 0; i < COUNT; i++) points[i] = daft_to_float(random_unit());
    float before = INFINITY;
    for (uint32_t most = 8; most <= 64; most *= 2) {
        daft_hull *h = make(points, COUNT, most, NULL);
        assert_non_null(h);
        assert_true(h->vertex_count <= most);
        check_all(h, points, COUNT);
        double outside = 0;
        for (int i = 0; i < COUNT; i++) outside = fmax(outside, most_outside(h, points[i]));
        assert_near(outside, (double)h->deviation, 1e-5);
        assert_true(h->deviation < before);
        before = h->deviation;
        print_message("%u vertices: off by %g of the radius\n", most, (double)h->deviation);
        daft_hull_free(h);
    }
    assert_true(before < 0.06f);
    free(points);
}

static void refuses(const daft_vec3 *points, uint32_t count, const char *why)
{
    daft_error error = {0};
    assert_null(make(points, count, 0, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    if (!strstr(error.message, why)) fail_msg("\"%s\" does not say \"%s\"", error.message, why);
}

static void bad_points_are_refused(void **unused)
{
    (void)unused;
    daft_vec3 p[100] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    refuses(p, 3, "needs four points");
    refuses(p, 0, "needs four points");
    for (int i = 0; i < 100; i++) p[i] = daft_v3(3, 4, 5);
    refuses(p, 100, "in one spot");
    for (int i = 0; i < 100; i++) p[i] = daft_v3((float)i, (float)(2 * i), 7);
    refuses(p, 100, "on one line");
    for (int i = 0; i < 100; i++) p[i] = daft_v3((float)(i % 10), 0.3f, (float)(i / 10));
    refuses(p, 100, "in one plane");
    fixture_seed(504);
    daft_rigid pose = random_rigid(1);
    for (int i = 0; i < 100; i++) p[i] = daft_to_float(daft_rigid_point(&pose, daft_dv3(i % 10, 0, i / 10)));
    refuses(p, 100, "in one plane");
    p[0] = daft_v3(0, 0, 0), p[50] = daft_v3(NAN, 0, 0);
    refuses(p, 100, "point 50 of a convex hull is not finite");
    p[50] = daft_v3(0, INFINITY, 0);
    refuses(p, 100, "not finite");
    p[50] = daft_v3(0, 1e8f, 0);
    refuses(p, 100, "the most is");
    daft_error error = {0};
    assert_null(make(p, 10, 3, &error));
    assert_null(make(p, 10, 65, &error));
}

/* Thin, but solid. */
static void slabs_are_made(void **unused)
{
    (void)unused;
    fixture_seed(505);
    for (float thin = 1e-1f; thin > 2e-6f; thin *= 0.3f) {
        daft_rigid pose = random_rigid(0);
        daft_vec3 p[40];
        for (int i = 0; i < 40; i++) {
            daft_vec3 v = daft_mul(random_vec3(-1, 1), daft_v3(1, thin, 1));
            if (i < 8) v = daft_v3(i & 1 ? 1 : -1, i & 2 ? thin : -thin, i & 4 ? 1 : -1);
            p[i] = daft_to_float(daft_rigid_point(&pose, daft_to_double(v)));
        }
        daft_error error = {0};
        daft_hull *h = make(p, 40, 0, &error);
        if (!h) fail_msg("%g: %s", (double)thin, error.message);
        check_all(h, p, 40);
        daft_hull_free(h);
    }
}

typedef struct failing {
    daft_allocator base;
    int left;
} failing;

static void *failing_allocate(void *user, size_t size, size_t alignment)
{
    failing *f = user;
    return f->left-- > 0 ? f->base.allocate(f->base.user, size, alignment) : NULL;
}
static void failing_release(void *user, void *pointer)
{
    failing *f = user;
    f->base.release(f->base.user, pointer);
}

static void memory_may_run_out_at_any_time(void **unused)
{
    (void)unused;
    fixture_seed(506);
    daft_vec3 p[30];
    for (int i = 0; i < 30; i++) p[i] = random_vec3(-1, 1);
    bool done = false;
    for (int n = 0; !done; n++) {
        failing f = {daft_malloc_allocator(), n};
        daft_allocator allocator = {.user = &f, .allocate = failing_allocate, .release = failing_release};
        daft_error error = {0};
        daft_hull *h = daft_hull_create(&allocator, p, 30, 0, &error);
        if (!h) assert_int_equal(error.code, DAFT_ERROR_MEMORY);
        done = h != NULL;
        f.left = 1000;
        daft_hull_free(h);
        assert_true(n < 100);
    }
}

/* ---- mass ---- */

static void same_mass(const daft_mass *a, const daft_mass *b, double fraction)
{
    assert_near(a->mass, b->mass, fraction * b->mass);
    double length = sqrt((b->inertia[0] + b->inertia[4] + b->inertia[8]) / b->mass), far = 0;
    for (int k = 0; k < 3; k++) far = fmax(far, fabs(daft_dv3_at(b->centre, k)));
    for (int k = 0; k < 3; k++)
        assert_near(daft_dv3_at(a->centre, k), daft_dv3_at(b->centre, k), fraction * (length + far));
    for (int k = 0; k < 9; k++) assert_near(a->inertia[k], b->inertia[k], fraction * b->mass * length * length);
}

static void a_hull_weighs_what_its_box_does(void **unused)
{
    (void)unused;
    fixture_seed(507);
    for (int round = 0; round < 200; round++) {
        daft_vec3 half = random_vec3(0.2f, 2), corners[8];
        daft_rigid pose = random_rigid(1);
        for (int i = 0; i < 8; i++) {
            daft_vec3 v = daft_v3(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z);
            corners[i] = daft_to_float(daft_rigid_point(&pose, daft_to_double(v)));
        }
        daft_hull *h = make(corners, 8, 0, NULL);
        daft_sim_shape hull = daft_shape_hull(h), box = must_box(half.x, half.y, half.z);
        daft_mass mine, should;
        assert_true(daft_shape_mass(&hull, 700, &mine) && daft_shape_mass(&box, 700, &should));
        should = daft_mass_moved(&should, &pose);
        same_mass(&mine, &should, 3e-6);
        assert_near(should.mass, 700 * 8 * (double)half.x * (double)half.y * (double)half.z, 1e-3);
        daft_hull_free(h);
    }
}

/* Points thrown into a capsule: the integral itself. */
static void a_capsule_weighs_its_integral(void **unused)
{
    (void)unused;
    enum { N = 200 };
    double r = 0.5, half = 0.8, cell = 2 * r / N, sum = 0, along = 0, across = 0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            for (int k = 0; k < (int)(N * (r + half) / r); k++) {
                double x = (i + 0.5) * cell - r, z = (j + 0.5) * cell - r, y = (k + 0.5) * cell - (r + half);
                double beyond = fmax(fabs(y) - half, 0);
                if (x * x + z * z + beyond * beyond > r * r) continue;
                sum += 1, along += x * x + z * z, across += x * x + y * y;
            }
    double v = cell * cell * cell;
    daft_sim_shape s = must_capsule((float)half, (float)r);
    daft_mass m;
    assert_true(daft_shape_mass(&s, 1, &m));
    assert_near(m.mass, sum * v, 2e-3 * m.mass);
    assert_near(m.inertia[4], along * v, 4e-3 * m.inertia[4]);
    assert_near(m.inertia[0], across * v, 4e-3 * m.inertia[0]);
    assert_near(m.inertia[8], m.inertia[0], 1e-12);
}

/* A box sawn into parts weighs what it did. */
static void the_parts_make_the_whole(void **unused)
{
    (void)unused;
    daft_allocator allocator = daft_malloc_allocator();
    daft_child parts[3] = {
        {must_box(1, 0.5f, 0.25f), daft_rigid_identity()},
        {must_box(0.5f, 0.5f, 0.25f), daft_rigid_identity()},
        {must_box(0.25f, 0.5f, 0.5f), daft_rigid_make(daft_dv3(2.25, 0, 0), (daft_quat){0, 0, 0, 1})}};
    parts[1].pose.p.x = 1.5;
    parts[2].shape = must_box(0.25f, 0.5f, 0.25f);
    daft_compound *c = daft_compound_create(&allocator, parts, 3, NULL);
    daft_sim_shape whole = daft_shape_compound(c), box = must_box(1.75f, 0.5f, 0.25f);
    daft_mass mine, should;
    assert_true(daft_shape_mass(&whole, 3, &mine) && daft_shape_mass(&box, 3, &should));
    should.centre = daft_dv3(0.75, 0, 0);
    same_mass(&mine, &should, 1e-12);
    daft_compound_free(c);
}

static void principal_axes_are_found(void **unused)
{
    (void)unused;
    fixture_seed(508);
    for (int round = 0; round < 500; round++) {
        daft_sim_shape box = must_box(random_float(0.1f, 1), random_float(0.1f, 1), random_float(0.1f, 1));
        daft_rigid pose = random_rigid(1);
        daft_mass m;
        daft_vec3 moments;
        daft_quat axes;
        daft_shape_mass(&box, 1, &m);
        double before[3] = {m.inertia[0], m.inertia[4], m.inertia[8]};
        m = daft_mass_moved(&m, &pose);
        daft_mass_principal(m.inertia, &moments, &axes);
        daft_rigid back = daft_rigid_make(daft_dv3(0, 0, 0), axes);
        daft_mass diagonal = {.mass = m.mass,
                              .inertia = {[0] = (double)moments.x, [4] = (double)moments.y, [8] = (double)moments.z}};
        diagonal = daft_mass_moved(&diagonal, &back);
        for (int k = 0; k < 9; k++)
            assert_near(diagonal.inertia[k], m.inertia[k], 1e-6 * (before[0] + before[1] + before[2]));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_clouds_are_wrapped),
        cmocka_unit_test(boxes_have_six_faces),
        cmocka_unit_test(too_many_points_are_thinned_by_what_sticks_out),
        cmocka_unit_test(bad_points_are_refused),
        cmocka_unit_test(slabs_are_made),
        cmocka_unit_test(memory_may_run_out_at_any_time),
        cmocka_unit_test(a_hull_weighs_what_its_box_does),
        cmocka_unit_test(a_capsule_weighs_its_integral),
        cmocka_unit_test(the_parts_make_the_whole),
        cmocka_unit_test(principal_axes_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
