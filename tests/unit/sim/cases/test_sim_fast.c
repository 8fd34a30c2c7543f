/* sim, cases of the table that are fast: bullets at loose boxes and in rooms of triangles, shots at edges and corners
 * that triangles share, bodies of two boxes on hills, thin boxes on waves. DAFT_SHOTS=1000 for as many as the table
 * asks for. */
#include "sim_cases.h"

static int shots_wanted(void)
{
    const char *text = getenv("DAFT_SHOTS");
    return text ? atoi(text) : 100;
}

/* ---- surfaces ---- */

typedef struct surface {
    fixture_mesh mesh;
    daft_mesh_shape *shape;
} surface;

/* Its shape points into it: it stays where it is. */
static void surface_make(surface *s, const variant *v, const daft_vec3 *p, uint32_t vertices, const uint32_t *index,
                         uint32_t triangles, bool one_sided)
{
    daft_error error = {0};
    heap = daft_malloc_allocator();
    s->mesh = variant_mesh(v, p, vertices, index, triangles);
    s->shape = daft_mesh_shape_create(&heap, &s->mesh.mesh, s->mesh.bvh, one_sided, &error);
    assert_non_null(s->shape);
}

static void surface_drop(surface *s)
{
    daft_mesh_shape_free(s->shape);
    mesh_drop(&s->mesh);
}

static uint32_t add_surface(daft_world *world, const variant *v, const surface *s)
{
    one_shape def = box(daft_v3(1, 1, 1), 0, 0, 0);
    def.part.shape = daft_shape_mesh(s->shape);
    return put(world, v, def);
}

typedef double height_at(double x, double z);

static double waves(double x, double z) { return 0.3 * daft_sin(x) * daft_cos(0.8 * z); }
static double hump(double x, double z) { return 2 * fmax(0, 1 - (x * x + z * z) / 9); }
static double hills(double x, double z) { return 0.8 * daft_sin(0.7 * x) + 0.6 * daft_sin(0.9 * z + 0.5 * x); }

enum { CELLS = 40 };

/* CELLS² cells of `cell` metres, centred. */
static void ground_of(surface *s, const variant *v, height_at *height, double cell, bool one_sided)
{
    static daft_vec3 p[(CELLS + 1) * (CELLS + 1)];
    static uint32_t index[CELLS * CELLS * 6];
    for (uint32_t i = 0; i < DAFT_COUNT_OF(p); i++) {
        double x = cell * (i % (CELLS + 1) - CELLS / 2.0), z = cell * (i / (CELLS + 1) - CELLS / 2.0);
        p[i] = daft_v3((float)x, (float)height(x, z), (float)z);
    }
    uint32_t used = index_field(CELLS, index);
    surface_make(s, v, p, DAFT_COUNT_OF(p), index, used / 3, one_sided);
}

/* How far the middle of the body is above the ground as its triangles have it; they are cut as ground_of cuts them. */
static double above(height_at *height, double cell, daft_dvec3 p)
{
    double x = floor(p.x / cell) * cell, z = floor(p.z / cell) * cell, u = (p.x - x) / cell, v = (p.z - z) / cell;
    double a = height(x, z), b = height(x + cell, z), c = height(x, z + cell), d = height(x + cell, z + cell);
    return p.y - (u + v <= 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d));
}

/* ---- bullets ---- */

/* 500 m/s at one of ten boxes that stand on each other. The first thing it touches is the box it is aimed at, and all
 * its momentum stays with the boxes and itself. */
static uint64_t bullets_at_boxes(const variant *v)
{
    uint64_t hash = 0;
    seed_random(2001);
    double worst = 0;
    for (int shot = 0; shot < shots_wanted(); shot++) {
        daft_world *world = variant_world(v);
        put_floor(world, v, 100);
        uint32_t ids[10];
        for (int i = 0; i < 10; i++) ids[i] = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0.5 + i, 0));
        steps(world, 60);
        int aim = (int)uniform(0, 10);
        one_shape def = sphere(0.1, -20 - uniform(0, 10), aim + uniform(0.15, 0.85), uniform(-0.35, 0.35));
        def.bullet = true;
        uint32_t bullet = put(world, v, def);
        launch(world, v, bullet, daft_v3(500, 0, 0), daft_v3(0, 90, 0));
        double pushed = (double)daft_world_mass(world, bullet) * 500;
        uint32_t first = 0;
        for (int tick = 0; tick < 10 && !first; tick++) {
            steps(world, 1);
            const daft_sim_event *events;
            uint32_t count = daft_world_events(world, &events);
            for (uint32_t i = 0; i < count && !first; i++)
                if (events[i].kind == DAFT_SIM_CONTACT_BEGIN &&
                    (events[i].body_a == bullet || events[i].body_b == bullet))
                    first = events[i].body_a == bullet ? events[i].body_b : events[i].body_a;
            assert_true(state_in(world, v, bullet).position.x < state_in(world, v, ids[aim]).position.x - 0.5);
        }
        assert_int_equal(first, ids[aim]);
        double sum = (double)daft_world_mass(world, bullet) * (double)state_in(world, v, bullet).linear.x;
        for (int i = 0; i < 10; i++)
            sum += (double)daft_world_mass(world, ids[i]) * (double)state_in(world, v, ids[i]).linear.x;
        double held = 2 * 0.6 * G * 10 * (double)daft_world_mass(world, ids[0]) / 60; /* by the floor's friction, in two
                                                                                         steps */
        worst = fmax(worst, fabs(sum / pushed - 1));
        assert_true(fabs(sum - pushed) < held);
        hash = hash_of_both(hash, end_of(world));
    }
    print_message("momentum off by at most %g of it, the floor's doing\n", worst);
    return hash;
}

static void a_bullet_hits_the_box_it_is_aimed_at(void **unused)
{
    (void)unused;
    play_variants(bullets_at_boxes);
}

/* A closed room of twelve triangles, a ball and a box of 600 m/s that bounce, a minute. */
static uint64_t room_of_triangles(const variant *v)
{
    uint64_t hash = 0;
    daft_vec3 p[8];
    for (int i = 0; i < 8; i++) p[i] = daft_v3(i & 1 ? 5 : -5, i & 2 ? 5 : -5, i & 4 ? 5 : -5);
    const uint32_t index[] = {0, 2, 4, 2, 6, 4, 1, 5, 3, 3, 5, 7, 0, 4, 1, 1, 4, 5,
                              2, 3, 6, 3, 7, 6, 0, 1, 2, 1, 3, 2, 4, 6, 5, 5, 6, 7};
    for (int one_sided = 0; one_sided < 2; one_sided++) {
        surface room;
        surface_make(&room, v, p, 8, index, 12, one_sided);
        daft_world *world = variant_world(v);
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        add_surface(world, v, &room);
        one_shape ball = sphere(0.1, 1, 0, 0), crate = dynamic_box(daft_v3(0.2f, 0.1f, 0.1f), -1, 0, 0);
        ball.restitution = crate.restitution = 1;
        uint32_t ids[2] = {put(world, v, ball), put(world, v, crate)};
        launch(world, v, ids[0], daft_v3(400, 300, 330), daft_v3(0, 0, 0));
        launch(world, v, ids[1], daft_v3(-400, 310, -320), daft_v3(10, 20, 30));
        double farthest = 0;
        for (int i = 0; i < 3600; i++) {
            steps(world, 1);
            for (int k = 0; k < 2; k++) {
                daft_dvec3 c = state_in(world, v, ids[k]).position;
                farthest = fmax(farthest, fmax(fabs(c.x), fmax(fabs(c.y), fabs(c.z))));
            }
        }
        print_message("%s: farthest %g m from the middle of 10 m; ball at %g, box at %g m/s\n",
                      one_sided ? "one side" : "two sides", farthest, speed_of(state_in(world, v, ids[0])),
                      speed_of(state_in(world, v, ids[1])));
        assert_true(farthest < 5);
        hash = hash_of_both(hash, end_of(world));
        surface_drop(&room);
    }
    return hash;
}

static void nothing_leaves_a_room_of_triangles(void **unused)
{
    (void)unused;
    play_variants(room_of_triangles);
}

/* ---- paper ---- */

/* A ball of 5 cm radius, 100 m/s, at the edge that two triangles share, or the corner that eight do. */
static uint64_t balls_where_triangles_meet(const variant *v)
{
    uint64_t hash = 0;
    seed_random(2002);
    daft_vec3 p[9] = {{0, 0, 0}};
    uint32_t index[24];
    for (uint32_t i = 0; i < 8; i++) {
        double angle = DAFT_PI * i / 4;
        p[i + 1] = daft_v3(0, (float)(5 * daft_cos(angle)), (float)(5 * daft_sin(angle)));
        index[3 * i] = 0, index[3 * i + 1] = i + 1, index[3 * i + 2] = (i + 1) % 8 + 1;
    }
    surface sheet;
    surface_make(&sheet, v, p, 9, index, 8, false);
    for (int corner = 0; corner < 2; corner++) {
        int passed = 0;
        for (int shot = 0; shot < 10 * shots_wanted(); shot++) {
            daft_world *world = variant_world(v);
            daft_world_set_gravity(world, daft_v3(0, 0, 0));
            add_surface(world, v, &sheet);
            double along = corner ? 0 : uniform(0.2, 3), edge = DAFT_PI / 4 * (int)uniform(0, 8),
                   back = 2 + uniform(0, 2);
            daft_dvec3 aim = daft_dv3(1, 0, 0), at = daft_dv3(0, along * daft_cos(edge), along * daft_sin(edge));
            if (shot & 1) aim.y = uniform(-0.5, 0.5), aim.z = uniform(-0.5, 0.5);
            daft_dvec3 from = daft_dsub(at, daft_dscale(aim, back));
            uint32_t ball = put(world, v, sphere(0.05, from.x, from.y, from.z));
            launch(world, v, ball, daft_to_float(daft_dscale(aim, 100)), daft_v3(0, 0, 0));
            double farthest = -1;
            for (int i = 0; i < 6; i++) {
                steps(world, 1);
                farthest = fmax(farthest, state_in(world, v, ball).position.x);
            }
            passed += farthest > 0;
            hash = hash_of_both(hash, end_of(world));
        }
        print_message("%s: %d of %d passed\n", corner ? "corner" : "edge", passed, 10 * shots_wanted());
        assert_int_equal(passed, 0);
    }
    surface_drop(&sheet);
    return hash;
}

static void no_ball_passes_where_triangles_meet(void **unused)
{
    (void)unused;
    play_variants(balls_where_triangles_meet);
}

/* ---- onto hills ---- */

static uint32_t add_pair_of_boxes(daft_world *world, const variant *v, daft_dvec3 at, daft_quat turn)
{
    daft_sim_shape_def parts[2] = {daft_default_sim_shape_def(), daft_default_sim_shape_def()};
    for (int i = 0; i < 2; i++) {
        parts[i].shape = (daft_sim_shape){.type = DAFT_GEOMETRY_BOX,
                                          .half = i ? daft_v3(0.1f, 0.3f, 0.1f) : daft_v3(0.4f, 0.1f, 0.1f)};
        parts[i].position = variant_direction(v, i ? daft_v3(0.3f, 0.4f, 0) : daft_v3(0, 0, 0));
    }
    daft_sim_body_def def = daft_default_sim_body_def();
    def.position = variant_at(v, at), def.rotation = variant_turn(v, turn);
    def.shapes = parts, def.shape_count = 2;
    daft_error error = {0};
    uint32_t id = daft_world_add(world, &def, &error);
    assert_true(id);
    return id;
}

/* An L of two boxes, 180 m/s with spin, anyhow onto hills. Its middle stays above them. */
static uint64_t pairs_of_boxes_onto_hills(const variant *v)
{
    uint64_t hash = 0;
    seed_random(2003);
    double lowest = 1;
    for (int one_sided = 0; one_sided < 2; one_sided++) {
        surface ground;
        ground_of(&ground, v, hills, 1, one_sided);
        for (int shot = 0; shot < shots_wanted(); shot++) {
            daft_world *world = variant_world(v);
            add_surface(world, v, &ground);
            daft_dvec3 at = random_in(-4, 4), axis = random_in(-1, 1), aim = random_in(-0.7, 0.7),
                       spin = random_in(-40, 40);
            at.y = 6 + uniform(0, 3);
            uint32_t id = add_pair_of_boxes(world, v, at, turned(axis.x, axis.y + 1.5, axis.z, uniform(0, 6)));
            aim.y = -1;
            double scale = 180 / sqrt(daft_ddot(aim, aim));
            launch(world, v, id, daft_to_float(daft_dscale(aim, scale)), daft_to_float(spin));
            for (int i = 0; i < 90; i++) {
                steps(world, 1);
                daft_dvec3 p = variant_from(v, daft_world_centre(world, id));
                if (fmax(fabs(p.x), fabs(p.z)) > 19) break;
                double height = above(hills, 1, p);
                lowest = fmin(lowest, height);
                if (height < 0) fail_msg("shot %d is %g m below the hills at tick %d", shot, -height, i);
            }
            hash = hash_of_both(hash, end_of(world));
        }
        surface_drop(&ground);
    }
    print_message("lowest middle %g m above the ground\n", lowest);
    return hash;
}

static void no_body_of_two_boxes_passes_hills(void **unused)
{
    (void)unused;
    play_variants(pairs_of_boxes_onto_hills);
}

/* 40 thin boxes, 4×40×8 cm, onto waves, and at 50 m/s onto a hump: all stay above, and it is the same every time. */
static uint64_t drop_needles(const variant *v, height_at *height, double cell, double speed, bool one_sided)
{
    surface ground;
    ground_of(&ground, v, height, cell, one_sided);
    daft_world *world = variant_world(v);
    uint32_t ids[40];
    random_state = 88172645463325252u;
    add_surface(world, v, &ground);
    for (int i = 0; i < 40; i++) {
        daft_dvec3 at = random_in(-1.5, 1.5), axis = random_in(-1, 1);
        one_shape needle = dynamic_box(daft_v3(0.02f, 0.2f, 0.04f), at.x, 3 + 0.3 * i, at.z);
        needle.rotation = turned(axis.x, axis.y + 1.5, axis.z, uniform(0, 6));
        ids[i] = put(world, v, needle);
        launch(world, v, ids[i], daft_v3(0, (float)-speed, 0), daft_v3(0, 0, 0));
    }
    double lowest = 1;
    for (int i = 0; i < 600; i++) {
        steps(world, 1);
        for (int k = 0; k < 40; k++) {
            daft_dvec3 p = state_in(world, v, ids[k]).position;
            if (fmax(fabs(p.x), fabs(p.z)) < 0.45 * CELLS * cell) lowest = fmin(lowest, above(height, cell, p));
        }
    }
    print_message("%g m/s, %s: lowest middle %g m above the ground, %u awake\n", speed,
                  one_sided ? "one side" : "two sides", lowest, daft_world_counters(world).awake);
    assert_true(lowest > 0);
    uint64_t hash = end_of(world);
    surface_drop(&ground);
    return hash;
}

static uint64_t needles(const variant *v)
{
    uint64_t hash = 0;
    for (int one_sided = 0; one_sided < 2; one_sided++)
        for (int k = 0; k < 2; k++) {
            uint64_t first = drop_needles(v, k ? hump : waves, 0.5, k ? 50 : 0, one_sided);
            if (v == &VARIANT[0]) assert_true(drop_needles(v, k ? hump : waves, 0.5, k ? 50 : 0, one_sided) == first);
            hash = hash_of_both(hash, first);
        }
    return hash;
}

static void no_needle_passes_a_mesh(void **unused)
{
    (void)unused;
    play_variants(needles);
}

/* ---- hit by what moves ---- */

/* A kinematic bar comes along at 2 to 120 m/s, or swings at 1 to 45 rad/s, up to 2 m or 0.75 rad a step. */
typedef struct bar_blow {
    uint32_t id, mover;
    bool swings, posed;
    double rate, at; /* m/s, m; rad/s, rad */
} bar_blow;

static bar_blow place_bar(daft_world *world, const variant *v, uint32_t id, int shot)
{
    bar_blow b = {.id = id, .swings = shot & 1, .posed = shot & 4};
    b.rate = b.swings ? uniform(1, 45) : uniform(2, 120);
    double thick = shot & 16 ? 0.1 : 0.02;
    b.at = b.swings ? uniform(0.3, 1.2) : -4 - uniform(0, 2);
    one_shape bar = b.swings ? box(daft_v3(2, 0.3f, (float)thick), -1.2, 0.31, 0)
                             : box(daft_v3((float)thick, 0.3f, 1), b.at, 0.31, 0);
    if (b.swings) bar.rotation = turned(0, 1, 0, b.at);
    bar.kind = DAFT_BODY_KINEMATIC;
    b.mover = put(world, v, bar);
    if (!b.posed)
        launch(world, v, b.mover, daft_v3(b.swings ? 0 : (float)b.rate, 0, 0),
               daft_v3(0, b.swings ? (float)-b.rate : 0, 0));
    return b;
}

/* The fastest that what it comes over goes, of the bar's speed. It may not be on the bar's other side. */
static double blow_of(daft_world *world, const variant *v, bar_blow b)
{
    double fastest = 0;
    while (b.swings ? b.at > -1 : b.at < 3) {
        b.at += b.swings ? -b.rate / 60 : b.rate / 60;
        daft_dvec3 place = b.swings ? daft_dv3(-1.2, 0.31, 0) : daft_dv3(b.at, 0.31, 0);
        daft_quat turn = b.swings ? turned(0, 1, 0, b.at) : daft_quat_identity();
        if (b.posed) daft_world_set_pose(world, b.mover, variant_at(v, place), variant_turn(v, turn), false);
        steps(world, 1);
        daft_sim_state s = state_in(world, v, b.id);
        fastest = fmax(fastest, speed_of(s));
        assert_true(b.swings || s.position.x > b.at - 0.1 || fabs(s.position.z) > 1 || s.position.y > 0.6);
    }
    return fastest / (b.swings ? 1.2 * b.rate : b.rate);
}

/* What lies there, asleep or not, is never jumped over, but goes on at the bar's speed or, struck at a part of the
 * bar's length, at a good part of its end's. */
static uint64_t bars(const variant *v)
{
    uint64_t hash = 0;
    seed_random(2004);
    daft_hull *hulls[2] = {cylinder(0.15, 0.3), prism(0.15, 0.3, 8)};
    const daft_sim_shape shapes[] = {{.type = DAFT_GEOMETRY_SPHERE, .radius = 0.15f},
                                     {.type = DAFT_GEOMETRY_CAPSULE, .radius = 0.15f, .half_height = 0.3f},
                                     {.type = DAFT_GEOMETRY_BOX, .half = {0.15f, 0.15f, 0.15f}},
                                     daft_shape_hull(hulls[0]),
                                     daft_shape_hull(hulls[1])};
    double least = 1;
    for (int shot = 0; shot < 4 * shots_wanted(); shot++) {
        daft_world *world = variant_world(v);
        daft_world_set_sleeping(world, shot & 2);
        put_floor(world, v, 50);
        one_shape def = sphere(1, 0, 0.15, 0);
        def.part.shape = shapes[shot / 8 % 5];
        def.rotation = shot & 8 ? turned(1, 0, 0, DAFT_PI / 2) : turned(0, 0, 1, DAFT_PI / 2);
        uint32_t id = put(world, v, def);
        steps(world, 60);
        least = fmin(least, blow_of(world, v, place_bar(world, v, id, shot)));
        hash = hash_of_both(hash, end_of(world));
    }
    print_message("at least %g of the bar's speed\n", least);
    assert_true(least > 0.3);
    for (int i = 0; i < 2; i++) daft_hull_free(hulls[i]);
    return hash;
}

static void a_moving_bar_hits_what_lies(void **unused)
{
    (void)unused;
    play_variants(bars);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bullet_hits_the_box_it_is_aimed_at),
        cmocka_unit_test(nothing_leaves_a_room_of_triangles),
        cmocka_unit_test(no_ball_passes_where_triangles_meet),
        cmocka_unit_test(no_body_of_two_boxes_passes_hills),
        cmocka_unit_test(no_needle_passes_a_mesh),
        cmocka_unit_test(a_moving_bar_hits_what_lies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
