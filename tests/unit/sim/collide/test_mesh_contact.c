/* Contacts with meshes and height fields: what a flat floor of triangles does, whatever its triangles are, is what a
 * flat floor does; and on any ground a ball touches where the ground is nearest. */
#include "shape_cases.h"

enum { MANY = 32, MAX_TRIANGLES = 4096 };

typedef struct soup {
    daft_vec3 p[3 * MAX_TRIANGLES];
    uint32_t index[3 * MAX_TRIANGLES], vertices, triangles;
} soup;

static soup made;

static uint32_t vertex(soup *s, float x, float y, float z)
{
    s->p[s->vertices] = daft_v3(x, y, z);
    return s->vertices++;
}

static void triangle(soup *s, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *i = s->index + 3 * s->triangles++;
    i[0] = a, i[1] = b, i[2] = c;
}

/* Upwards; cut one way or the other. */
static void quad(soup *s, daft_vec3 low, daft_vec3 high, bool other_way)
{
    uint32_t a = vertex(s, low.x, low.y, low.z), b = vertex(s, low.x, low.y, high.z);
    uint32_t c = vertex(s, high.x, high.y, high.z), d = vertex(s, high.x, high.y, low.z);
    if (other_way)
        triangle(s, a, b, d), triangle(s, b, c, d);
    else
        triangle(s, a, b, c), triangle(s, a, c, d);
}

typedef enum floor_kind { GRID, SEAMS, T_JUNCTIONS, DIRTY, FIELD, FLOORS } floor_kind;

static const char *const FLOOR_NAMES[FLOORS] = {"grid", "doubled vertices", "T-junctions", "dirty", "field"};

/* 10 m by 10 m around the origin, at y = 0. */
static surface flat_floor(floor_kind kind, daft_height_field **field)
{
    soup *s = &made;
    s->vertices = s->triangles = 0;
    enum { N = 20 };
    if (kind == FIELD) {
        static const float zero[(N + 1) * (N + 1)];
        daft_allocator allocator = daft_malloc_allocator();
        *field = daft_height_field_create(&allocator, zero, N + 1, N + 1, 0.5f, 0.5f, NULL);
        return (surface){.s = daft_shape_field(*field)};
    }
    if (kind == GRID || kind == DIRTY) {
        for (int i = 0; i < (N + 1) * (N + 1); i++)
            vertex(s, (float)(i % (N + 1)) * 0.5f - 5, 0, (float)(i / (N + 1)) * 0.5f - 5);
        for (uint32_t z = 0; z < N; z++)
            for (uint32_t x = 0; x < N; x++) {
                uint32_t a = z * (N + 1) + x, b = a + N + 1;
                bool way = random_bits() & 1;
                triangle(s, a, b, way ? a + 1 : b + 1), triangle(s, way ? b : a, b + 1, a + 1);
                if (kind == DIRTY && x % 3 == 0)
                    triangle(s, a, b, b + 1), triangle(s, a, a + 1, a + 2 < s->vertices ? a + 2 : a);
            }
    }
    for (int z = 0; z < N && kind >= SEAMS && kind <= T_JUNCTIONS; z++) {
        int columns = kind == SEAMS ? N : 3 + (int)(random_bits() % 20);
        for (int x = 0; x < columns; x++) {
            float x0 = -5 + 10 * (float)x / (float)columns, x1 = -5 + 10 * (float)(x + 1) / (float)columns,
                  z0 = (float)z * 0.5f - 5;
            quad(s, daft_v3(x0, 0, z0), daft_v3(x1, 0, z0 + 0.5f), random_bits() & 1);
        }
    }
    return surface_of(mesh_make(s->p, s->vertices, s->index, s->triangles));
}

static void floor_drop(surface *s, daft_height_field *field)
{
    if (s->shape)
        surface_drop(s);
    else
        daft_height_field_free(field);
}

static daft_sim_shape some_shape(uint32_t kind, float size)
{
    switch (kind) {
    case 0: return must_sphere(size * random_float(0.1f, 1));
    case 1: return must_capsule(size * random_float(0.1f, 1), size * random_float(0.1f, 0.6f));
    case 2: return must_box(size * random_float(0.1f, 1), size * random_float(0.1f, 1), size * random_float(0.1f, 1));
    default: return daft_shape_hull(random_hull(12 + random_bits() % 20, daft_v3(size, size, size)));
    }
}

static void shape_drop(daft_sim_shape *s)
{
    if (s->type == DAFT_GEOMETRY_HULL) daft_hull_free((daft_hull *)(uintptr_t)s->hull);
}

/* Upright, lying or at any angle. */
static daft_quat some_turn(uint32_t round)
{
    double angle = (double)random_float(-3, 3);
    daft_quat yaw = {0, (float)daft_sin(angle / 2), 0, (float)daft_cos(angle / 2)};
    if (round % 4 == 0) return random_rotation();
    return round % 4 == 1 ? daft_quat_mul(yaw, (daft_quat){0, 0, 0.70710678f, 0.70710678f}) : yaw;
}

/* Its lowest point is `depth` below y = 0, at (x, z). */
static daft_rigid lowered(const daft_sim_shape *s, daft_quat turn, double x, double z, double depth)
{
    daft_rigid pose = daft_rigid_make(daft_dv3(0, 0, 0), turn);
    daft_daabb bounds = daft_shape_bounds(s, &pose);
    pose.p = daft_dv3(x, -bounds.low.y - depth, z);
    return pose;
}

static void a_flat_floor_has_no_edges(void **unused)
{
    (void)unused;
    fixture_seed(801);
    for (floor_kind kind = 0; kind < FLOORS; kind++) {
        daft_height_field *field = NULL;
        surface ground = flat_floor(kind, &field);
        for (uint32_t round = 0; round < 1600; round++) {
            daft_sim_shape s = some_shape(round / 4 % 4, 0.6f);
            double size = (double)daft_shape_reach(&s, daft_v3(0, 0, 0)),
                   depth = (double)random_float(-0.01f, 0.03f) * size;
            daft_rigid world = random_rigid(100), place = daft_rigid_identity();
            if (kind == FIELD) place.p = daft_dv3(-5, 0, -5);
            daft_rigid body =
                lowered(&s, some_turn(round), (double)random_float(-3, 3), (double)random_float(-3, 3), depth);
            place = daft_rigid_mul(&world, &place), body = daft_rigid_mul(&world, &body);
            daft_relpose pose = daft_relpose_make(&body, &place);
            daft_vec3 down =
                daft_to_float(daft_rigid_to_local_vector(&body, daft_rigid_vector(&place, daft_dv3(0, -1, 0))));
            daft_manifold m[MANY];
            uint32_t count = daft_collide(&s, &ground.s, &pose, (float)(0.02 * size), m, MANY, NULL);
            for (uint32_t i = 0; i < count && count != 1; i++)
                print_message("%g %g %g against %g %g %g, %g deep\n", (double)m[i].normal.x, (double)m[i].normal.y,
                              (double)m[i].normal.z, (double)down.x, (double)down.y, (double)down.z,
                              (double)m[i].points[0].separation);
            if (count != 1) fail_msg("%s, round %u: %u manifolds", FLOOR_NAMES[kind], round, count);
            double deepest = INFINITY;
            for (uint32_t i = 0; i < m[0].count; i++) deepest = fmin(deepest, (double)m[0].points[i].separation);
            if (!(daft_length(daft_sub(m[0].normal, down)) < 1e-3f))
                fail_msg("%s, round %u, shape %d: the normal leans by %g", FLOOR_NAMES[kind], round, s.type,
                         (double)daft_length(daft_sub(m[0].normal, down)));
            if (!(fabs(deepest + depth) < 2e-3 * size))
                fail_msg("%s, round %u: %g deep, not %g", FLOOR_NAMES[kind], round, -deepest, depth);
            assert_true(m[0].count <= 4 && m[0].part_b.triangle != DAFT_NO_FEATURE);
            shape_drop(&s);
        }
        floor_drop(&ground, field);
    }
}

/* A crate lying flat on many small triangles rests on its own four corners. */
static void four_corners_bear_a_crate(void **unused)
{
    (void)unused;
    fixture_seed(802);
    for (floor_kind kind = 0; kind < FLOORS; kind++) {
        daft_height_field *field = NULL;
        surface ground = flat_floor(kind, &field);
        for (int round = 0; round < 300; round++) {
            daft_sim_shape crate = must_box(1.2f, 0.4f, 0.9f);
            daft_rigid place = daft_rigid_identity();
            if (kind == FIELD) place.p = daft_dv3(-5, 0, -5);
            daft_rigid body =
                lowered(&crate, some_turn(2), (double)random_float(-3, 3), (double)random_float(-3, 3), 0.002);
            daft_relpose pose = daft_relpose_make(&body, &place);
            daft_manifold m[MANY];
            assert_int_equal(daft_collide(&crate, &ground.s, &pose, 0.01f, m, MANY, NULL), 1);
            assert_int_equal(m[0].count, 4);
            for (int i = 0; i < 4; i++) {
                daft_vec3 p = m[0].points[i].point;
                if (!(fabsf(fabsf(p.x) - 1.2f) < 0.01f && fabsf(fabsf(p.z) - 0.9f) < 0.01f))
                    fail_msg("%s: a point at %g, %g", FLOOR_NAMES[kind], (double)p.x, (double)p.z);
                assert_near(m[0].points[i].separation, -0.002, 1e-5);
                for (int k = 0; k < i; k++) assert_int_not_equal(m[0].points[i].id, m[0].points[k].id);
            }
        }
        floor_drop(&ground, field);
    }
}

/* On bumpy ground a ball's deepest contact is at the point that is nearest to its centre, and so is its normal. */
static void balls_touch_where_the_ground_is_nearest(void **unused)
{
    (void)unused;
    fixture_seed(803);
    surface ground = surface_of(mesh_ball(12, 2, 0.1f));
    int touches = 0;
    for (int round = 0; round < 20000; round++) {
        daft_sim_shape ball = must_sphere(random_float(0.05f, 0.5f));
        daft_rigid body = random_rigid(0), place = daft_rigid_identity();
        body.p = daft_dscale(random_unit(), (double)random_float(1.7f, 2.6f));
        daft_dvec3 on;
        double distance, margin = 0.01;
        daft_shape_part part;
        assert_true(daft_shape_closest(&ground.s, body.p, INFINITY, &on, &distance, &part));
        daft_relpose pose = daft_relpose_make(&body, &place);
        daft_manifold m[MANY];
        uint32_t count = daft_collide(&ball, &ground.s, &pose, (float)margin, m, MANY, NULL);
        double should = distance - (double)ball.radius, least = INFINITY;
        if (fabs(should - margin) < 1e-5 || distance < 0.01) continue;
        if ((count > 0) != (should < margin)) fail_msg("round %d: %u manifolds at %g", round, count, should);
        if (count == 0) continue;
        touches++;
        for (uint32_t i = 0; i < count; i++)
            for (uint32_t k = 0; k < m[i].count; k++) least = fmin(least, (double)m[i].points[k].separation);
        /* Two faces may be as near as each other: one of them is the one that was found. */
        daft_dvec3 d = daft_dsub(on, body.p);
        double along = -1;
        for (uint32_t i = 0; i < count; i++)
            for (uint32_t k = 0; k < m[i].count; k++)
                if ((double)m[i].points[k].separation < least + 1e-6)
                    along = fmax(along, daft_ddot(daft_rigid_vector(&body, daft_to_double(m[i].normal)), d));
        assert_near(least, should, 1e-4);
        assert_true(along > 0.9998 * distance);
    }
    assert_true(touches > 3000);
    surface_drop(&ground);
}

/* Bumpy ground. From both sides a ridge thinner than the margin is seen from behind as well, so what pushes a body the
 * right way holds of the one-sided one only; where the points are, of both. */
typedef struct bumps {
    surface ground;
    daft_mesh_shape *solid;
} bumps;

static bumps bumps_make(void)
{
    daft_allocator allocator = daft_malloc_allocator();
    bumps b = {.ground = surface_of(mesh_ball(12, 2, 0.1f))};
    b.solid = daft_mesh_shape_create(&allocator, &b.ground.mesh->mesh, b.ground.mesh->bvh, true, NULL);
    assert_non_null(b.solid);
    return b;
}

static void bumps_drop(bumps *b)
{
    daft_mesh_shape_free(b->solid);
    surface_drop(&b->ground);
}

/* All points are on the body, but for half of the gap between both and 2 mm. */
static void check_points(const daft_sim_shape *s, const daft_manifold *m, uint32_t count, uint32_t round)
{
    daft_rigid identity = daft_rigid_identity();
    cloud c = cloud_of(s, &identity);
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < m[i].count; k++) {
            cloud point = {.count = 1, .points = {daft_to_double(m[i].points[k].point)}};
            double gap = oracle_distance(&c, &point) - c.radius, separation = (double)m[i].points[k].separation;
            if (!(gap < 0.5 * fabs(separation) + 2e-3)) fail_msg("round %u: a point %g m off", round, gap);
        }
}

/* A box, a capsule or a hull 2 mm deep in the ground from a random side. */
static void check_on_bumps(const bumps *b, uint32_t round)
{
    daft_sim_shape s = some_shape(1 + round % 3, 0.4f), solid = daft_shape_mesh(b->solid);
    daft_rigid body = random_rigid(0), place = daft_rigid_identity();
    daft_dvec3 out = random_unit();
    body.p = daft_dscale(out, 4);
    daft_impact hit;
    assert_int_equal(daft_shape_cast(&s, &body, daft_dscale(out, -4), &b->ground.s, &hit), DAFT_IMPACT_HIT);
    double depth = 0.002;
    body.p = daft_dadd(body.p, daft_dscale(out, -4 * hit.t - depth));
    daft_relpose pose = daft_relpose_make(&body, &place);
    daft_manifold m[MANY];
    uint32_t count = daft_collide(&s, &b->ground.s, &pose, 0.005f, m, MANY, NULL);
    if (count == 0) fail_msg("round %u: no contact from both sides", round);
    check_points(&s, m, count, round);
    count = daft_collide(&s, &solid, &pose, 0.005f, m, MANY, NULL);
    if (count == 0) fail_msg("round %u: no contact", round);
    check_points(&s, m, count, round);
    for (uint32_t i = 0; i < count; i++) {
        daft_dvec3 n = daft_rigid_vector(&body, daft_to_double(m[i].normal));
        if (!(daft_ddot(n, out) < 0.5))
            fail_msg("round %u, shape %d: a contact pulls it in by %g", round, s.type, daft_ddot(n, out));
        for (uint32_t k = 0; k < m[i].count; k++)
            if (!((double)m[i].points[k].separation > -0.1))
                fail_msg("round %u, shape %d: %g deep", round, s.type, (double)m[i].points[k].separation);
    }
    shape_drop(&s);
}

/* Every contact of a box, a capsule or a hull on bumpy ground pushes it towards the side it is on, and no farther than
 * needed: along each normal the body is as deep as its points say. */
static void contacts_on_bumps_are_true(void **unused)
{
    (void)unused;
    fixture_seed(804);
    bumps b = bumps_make();
    for (uint32_t round = 0; round < 6000; round++) check_on_bumps(&b, round);
    bumps_drop(&b);
}

/* Poses that had a point off the body. Seeds 16 and 1: a face preferred to edges about as deep had only air over it,
 * and the point, the corner farthest in, was moved 2 cm to the triangle's rim. Seeds 4 and 5: a face with an acute
 * corner reached 5 and 4 mm past it when its sides were moved out by the overhang. Seeds 52 and 73: the best edges
 * passed each other at 2 and 1 cm, and the point was halfway between them. */
static void points_beside_the_body(void **unused)
{
    (void)unused;
    static const struct pose {
        uint64_t seed, state; /* of the ground, of the body */
        uint32_t round;
    } poses[] = {{16, 0xaf558b415a37806a, 4220}, {1, 0x37f0043759c9ef25, 3197},  {4, 0x680205dbd115cac7, 1523},
                 {5, 0x8fc8f4dce6f7048c, 2990},  {52, 0xfeca9155060b7394, 2921}, {73, 0x647fbb4677432924, 3317}};
    for (size_t i = 0; i < DAFT_COUNT_OF(poses); i++) {
        fixture_state = poses[i].seed;
        bumps b = bumps_make();
        fixture_state = poses[i].state;
        check_on_bumps(&b, poses[i].round);
        bumps_drop(&b);
    }
}

/* A floor and a wall in one mesh: pushed up and away from the wall, never askew. */
static void a_corner_pushes_two_ways(void **unused)
{
    (void)unused;
    fixture_seed(805);
    soup *s = &made;
    s->vertices = s->triangles = 0;
    for (int z = 0; z < 16; z++)
        for (int x = 0; x < 8; x++) {
            float x0 = (float)x * 0.5f, z0 = (float)z * 0.5f - 4;
            quad(s, daft_v3(x0, 0, z0), daft_v3(x0 + 0.5f, 0, z0 + 0.5f), random_bits() & 1);
            uint32_t a = vertex(s, 0, x0, z0), b = vertex(s, 0, x0 + 0.5f, z0); /* the wall x = 0 looks along +x */
            uint32_t c = vertex(s, 0, x0 + 0.5f, z0 + 0.5f), d = vertex(s, 0, x0, z0 + 0.5f);
            triangle(s, a, b, c), triangle(s, a, c, d);
        }
    surface ground = surface_of(mesh_make(s->p, s->vertices, s->index, s->triangles));
    for (int round = 0; round < 2000; round++) {
        daft_vec3 h = daft_v3(random_float(0.2f, 1), random_float(0.2f, 1), random_float(0.2f, 1));
        daft_sim_shape box = round % 2 ? must_box(h.x, h.y, h.z) : must_sphere(h.x);
        if (round % 2 == 0) h = daft_v3(h.x, h.x, h.x);
        daft_rigid body = daft_rigid_identity(), place = body;
        body.p = daft_dv3((double)h.x - 0.003, (double)h.y - 0.005, (double)random_float(-2, 2));
        daft_relpose pose = daft_relpose_make(&body, &place);
        daft_manifold m[MANY];
        uint32_t count = daft_collide(&box, &ground.s, &pose, 0.01f, m, MANY, NULL);
        assert_int_equal(count, 2);
        for (uint32_t i = 0; i < count; i++) {
            bool up = m[i].normal.y < -0.99999f, side = m[i].normal.x < -0.99999f;
            if (!up && !side)
                fail_msg("round %d: a normal %g %g %g", round, (double)m[i].normal.x, (double)m[i].normal.y,
                         (double)m[i].normal.z);
            for (uint32_t k = 0; k < m[i].count; k++)
                assert_near(m[i].points[k].separation, up ? -0.005 : -0.003, 1e-5);
        }
    }
    surface_drop(&ground);
}

/* Sheets hold from both sides; one-sided ones push up whatever is in them. */
static void sides_of_a_sheet(void **unused)
{
    (void)unused;
    daft_allocator allocator = daft_malloc_allocator();
    const daft_vec3 p[4] = {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
    const uint32_t index[6] = {0, 2, 1, 0, 3, 2};
    surface sheet = surface_of(mesh_make(p, 4, index, 2));
    daft_mesh_shape *one = daft_mesh_shape_create(&allocator, &sheet.mesh->mesh, sheet.mesh->bvh, true, NULL);
    daft_sim_shape shapes[4] = {must_sphere(0.5f), must_capsule(0.5f, 0.5f), must_box(0.5f, 0.5f, 0.5f),
                                must_box(0.7f, 0.5f, 0.7f)};
    for (int i = 0; i < 4; i++) {
        daft_rigid body = daft_rigid_identity(), place = body;
        daft_manifold m[MANY];
        double reach = i == 1 ? 1 : 0.5;
        body.p = daft_dv3(0.3, -reach + 0.01, 0.2);
        daft_relpose pose = daft_relpose_make(&body, &place);
        assert_int_equal(daft_collide(&shapes[i], &sheet.s, &pose, 0.02f, m, MANY, NULL), 1);
        assert_near(m[0].normal.y, 1, 1e-6);
        assert_near(m[0].points[0].separation, -0.01, 1e-5);
        daft_sim_shape solid = daft_shape_mesh(one);
        assert_int_equal(daft_collide(&shapes[i], &solid, &pose, 0.02f, m, MANY, NULL), 1);
        assert_near(m[0].normal.y, -1, 1e-6);
        float deepest = 0;
        for (uint32_t k = 0; k < m[0].count; k++) deepest = fminf(deepest, m[0].points[k].separation);
        assert_near(deepest, -2 * reach + 0.01, 1e-4);
    }
    daft_mesh_shape_free(one);
    surface_drop(&sheet);
}

/* The mesh as a, a compound on a mesh, and fewer places than contacts. */
static void other_orders_and_compounds(void **unused)
{
    (void)unused;
    fixture_seed(806);
    daft_allocator allocator = daft_malloc_allocator();
    daft_height_field *none = NULL;
    surface ground = flat_floor(GRID, &none);
    daft_child legs[2] = {{must_box(0.1f, 0.5f, 0.1f), daft_rigid_identity()},
                          {must_sphere(0.5f), daft_rigid_identity()}};
    legs[0].pose.p.x = -1, legs[1].pose.p.x = 1;
    daft_compound *c = daft_compound_create(&allocator, legs, 2, NULL);
    daft_sim_shape table = daft_shape_compound(c);
    for (int round = 0; round < 200; round++) {
        daft_rigid body = lowered(&table, some_turn(2), (double)random_float(-3, 3), (double)random_float(-3, 3), 0.01);
        daft_rigid place = daft_rigid_identity();
        daft_relpose pose = daft_relpose_make(&body, &place), back = daft_relpose_make(&place, &body);
        daft_manifold m[MANY], n[MANY];
        assert_int_equal(daft_collide(&table, &ground.s, &pose, 0.02f, m, MANY, NULL), 2);
        assert_int_equal(m[0].part_a.child, 0);
        assert_int_equal(m[1].part_a.child, 1);
        assert_int_equal(m[0].count, 4);
        assert_int_equal(m[1].count, 1);
        assert_int_equal(daft_collide(&ground.s, &table, &back, 0.02f, n, MANY, NULL), 2);
        for (int i = 0; i < 2; i++) {
            assert_near(m[i].normal.y, -1, 1e-5);
            assert_near(n[i].normal.y, 1, 1e-5);
            assert_near(m[i].points[0].separation, -0.01, 1e-4);
            assert_int_equal(n[i].part_b.child, i);
        }
        assert_int_equal(daft_collide(&table, &ground.s, &pose, 0.02f, m, 1, NULL), 1);
        assert_int_equal(daft_collide(&ground.s, &ground.s, &pose, 0.02f, m, MANY, NULL), 0);
    }
    daft_compound_free(c);
    surface_drop(&ground);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flat_floor_has_no_edges),
        cmocka_unit_test(four_corners_bear_a_crate),
        cmocka_unit_test(balls_touch_where_the_ground_is_nearest),
        cmocka_unit_test(contacts_on_bumps_are_true),
        cmocka_unit_test(points_beside_the_body),
        cmocka_unit_test(a_corner_pushes_two_ways),
        cmocka_unit_test(sides_of_a_sheet),
        cmocka_unit_test(other_orders_and_compounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
