/* sim, what is built of many bodies: houses of cards, arches, dominoes, pyramids, what begins inside something else,
 * ragdolls. Each with the number it must keep to. */
#include "sim_cases.h"

static int count_awake(const daft_world *world) { return (int)daft_world_counters(world).awake; }

/* ---- what stands ---- */

/* Storeys of leaning pairs of cards, 0.4 m high, flat ones across them. */
static uint64_t house_of_cards(const variant *v)
{
    enum { STOREYS = 5 };
    daft_world *world = variant_world(v);
    one_shape ground = box(daft_v3(10, 1, 10), 0, -1, 0);
    ground.friction = 0.7f;
    put(world, v, ground);
    const double lean = 25 * DAFT_PI / 180, half = 0.2, thick = 0.001;
    double rise = half * daft_cos(lean) + thick * daft_sin(lean), reach = half * daft_sin(lean),
           pitch = 4 * reach + 0.02;
    uint32_t ids[64], n = 0;
    daft_dvec3 from[64];
    for (int storey = 0; storey < STOREYS; storey++) {
        double y = storey * (2 * rise + 2 * thick);
        int pairs = STOREYS - storey;
        for (int i = 0; i < pairs; i++) {
            double x = (i - 0.5 * (pairs - 1)) * pitch;
            for (int side = -1; side <= 1; side += 2) {
                one_shape card =
                    dynamic_box(daft_v3((float)thick, (float)half, 0.1f), x + side * (reach + thick), y + rise, 0);
                card.rotation = turned(0, 0, 1, side * lean);
                card.friction = 0.7f;
                ids[n++] = put(world, v, card);
            }
            if (i + 1 == pairs) continue;
            one_shape flat =
                dynamic_box(daft_v3((float)half, (float)thick, 0.1f), x + pitch / 2, y + 2 * rise + thick, 0);
            flat.friction = 0.7f;
            ids[n++] = put(world, v, flat);
        }
    }
    for (uint32_t i = 0; i < n; i++) from[i] = state_in(world, v, ids[i]).position;
    steps(world, 600);
    double moved = 0;
    for (uint32_t i = 0; i < n; i++) moved = fmax(moved, distance_of(from[i], state_in(world, v, ids[i]).position));
    print_message("%u cards, moved at most %g mm\n", n, 1000 * moved);
    assert_true(moved < 0.01);
    return end_of(world);
}

static void a_house_of_cards_stands(void **unused)
{
    (void)unused;
    play_variants(house_of_cards);
}

/* Sixteen wedges between two abutments, four boxes on top; friction 0.6 and nothing else holds them. */
static uint64_t arch(const variant *v)
{
    enum { STONES = 16 };
    daft_world *world = variant_world(v);
    put_floor(world, v, 20);
    daft_allocator allocator = daft_malloc_allocator();
    daft_error error = {0};
    daft_hull *hulls[STONES];
    uint32_t ids[STONES];
    const double inner = 3, outer = 4;
    for (int i = 0; i < STONES; i++) {
        double middle = DAFT_PI * (i + 0.5) / STONES;
        daft_dvec3 at = daft_dv3(3.5 * daft_cos(middle), 3.5 * daft_sin(middle), 0);
        daft_vec3 p[8];
        for (int k = 0; k < 8; k++) {
            double angle = DAFT_PI * (i + (k & 1)) / STONES, r = k & 2 ? outer : inner;
            p[k] = daft_v3((float)(v->side * (r * daft_cos(angle) - at.x)), (float)(r * daft_sin(angle) - at.y),
                           k & 4 ? 0.5f : -0.5f);
        }
        hulls[i] = daft_hull_create(&allocator, p, 8, 0, &error);
        assert_non_null(hulls[i]);
        one_shape stone = dynamic_box(daft_v3(1, 1, 1), at.x, at.y, 0);
        stone.part.shape = daft_shape_hull(hulls[i]);
        ids[i] = put(world, v, stone);
    }
    put(world, v, box(daft_v3(0.5f, 0.5f, 1), 4.5, 0.5, 0));
    put(world, v, box(daft_v3(0.5f, 0.5f, 1), -4.5, 0.5, 0));
    for (int i = 0; i < 4; i++) put(world, v, dynamic_box(daft_v3(0.25f, 0.25f, 0.25f), 0, 4.25 + 0.5 * i, 0));
    /* Contacts are springs: it settles first. After that nothing moves for a minute, awake. */
    daft_world_set_sleeping(world, false);
    double from = state_in(world, v, ids[STONES / 2]).position.y;
    steps(world, 300);
    double settled = state_in(world, v, ids[STONES / 2]).position.y;
    steps(world, 3600);
    double sank = settled - state_in(world, v, ids[STONES / 2]).position.y;
    print_message("the key stone settled by %g mm, then sank %g mm\n", 1000 * (from - settled), 1000 * sank);
    assert_true(fabs(sank) < 0.001 && from - settled < 0.01);
    uint64_t hash = end_of(world);
    for (int i = 0; i < STONES; i++) daft_hull_free(hulls[i]);
    return hash;
}

static void an_arch_stands(void **unused)
{
    (void)unused;
    play_variants(arch);
}

/* ---- dominoes ---- */

/* Ticks until the last of fifteen leans by 30 degrees; they must do so in order. */
static int fall_of_dominoes(const variant *v, float dt, uint64_t *hash)
{
    enum { COUNT = 15 };
    daft_world *world = variant_world(v);
    put_floor(world, v, 20);
    uint32_t ids[COUNT];
    for (int i = 0; i < COUNT; i++) ids[i] = put(world, v, dynamic_box(daft_v3(0.05f, 0.8f, 0.2f), 0.6 * i, 0.8, 0));
    daft_error error = {0};
    steps(world, 30);
    launch(world, v, ids[0], daft_v3(0.2f, 0, 0), daft_v3(0, 0, -0.25f));
    int fallen = 0, tick = 0;
    for (; fallen < COUNT && tick * (double)dt < 20; tick++) {
        assert_true(daft_world_step(world, dt, &error));
        for (int i = fallen; i < COUNT; i++) {
            daft_quat q = state_in(world, v, ids[i]).rotation;
            double up = 1 - 2 * (double)(q.x * q.x + q.z * q.z);
            if (up > daft_cos(DAFT_PI / 6)) continue;
            assert_int_equal(i, fallen);
            fallen++;
        }
    }
    assert_int_equal(fallen, COUNT);
    *hash = hash_of_both(*hash, end_of(world));
    return tick;
}

static uint64_t dominoes(const variant *v)
{
    uint64_t hash = 0;
    double coarse = fall_of_dominoes(v, DT, &hash) / 60.0, fine = fall_of_dominoes(v, DT / 4, &hash) / 240.0;
    print_message("%g s, %g s at 240 steps a second\n", coarse, fine);
    assert_near(coarse, fine, 0.05 * fine);
    return hash;
}

static void dominoes_fall_in_order(void **unused)
{
    (void)unused;
    play_variants(dominoes);
}

/* ---- pyramids ---- */

/* Boxes of 100 m stand as those of 1 m do. */
static uint64_t huge_pyramid(const variant *v)
{
    uint64_t hash = 0;
    static const float sizes[] = {1, 100};
    for (int k = 0; k < 2; k++) {
        daft_world *world = variant_world(v);
        double size = (double)sizes[k];
        put(world, v, box(daft_v3(10 * sizes[k], sizes[k], 10 * sizes[k]), 0, -size, 0));
        uint32_t ids[55], n = 0;
        daft_dvec3 from[55];
        for (int row = 0; row < 10; row++)
            for (int i = 0; i < 10 - row; i++, n++) {
                from[n] = daft_dv3(1.05 * size * (i + 0.5 * row - 4.5), size * (0.5 + row), 0);
                ids[n] = put(world, v,
                             dynamic_box(daft_scale(daft_v3(0.5f, 0.5f, 0.5f), sizes[k]), from[n].x, from[n].y, 0));
            }
        steps(world, 600);
        double moved = 0, fastest = 0;
        for (uint32_t i = 0; i < n; i++) {
            moved = fmax(moved, distance_of(from[i], place_of(world, v, ids[i])));
            fastest = fmax(fastest, speed_of(state_of(world, ids[i])));
        }
        print_message("boxes of %g m: moved at most %g m, fastest %g m/s, %d awake\n", size, moved, fastest,
                      count_awake(world));
        assert_true(moved < 0.02 * size && fastest < 0.01);
        hash = hash_of_both(hash, end_of(world));
    }
    return hash;
}

static void a_huge_pyramid_stands_like_a_small_one(void **unused)
{
    (void)unused;
    play_variants(huge_pyramid);
}

/* Four rows that overlap by a quarter part within two seconds, at 3 m/s at most, and are at rest: the top, pushed up by
 * 0.75 m, does not overshoot. */
static uint64_t overlapping_pyramid(const variant *v)
{
    daft_world *world = variant_world(v);
    put_floor(world, v, 20);
    uint32_t ids[10], n = 0;
    for (int row = 0; row < 4; row++)
        for (int i = 0; i < 4 - row; i++)
            ids[n++] = put(world, v,
                           dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0.75 * (i + 0.5 * row - 1.5), 0.5 + 0.75 * row, 0));
    double fastest = 0, last = 0, highest = 0;
    for (int i = 0; i < 120; i++) {
        steps(world, 1);
        last = 0;
        for (uint32_t k = 0; k < n; k++) {
            daft_sim_state s = state_in(world, v, ids[k]);
            last = fmax(last, speed_of(s)), highest = fmax(highest, s.position.y);
        }
        fastest = fmax(fastest, last);
    }
    const daft_sim_contact *contacts;
    assert_true(daft_world_contacts(world, &contacts) > 0);
    daft_sim_shape cube = {.type = DAFT_GEOMETRY_BOX, .half = {0.497f, 0.497f, 0.497f}};
    for (uint32_t a = 0; a < n; a++)
        for (uint32_t b = 0; b < a; b++) {
            daft_sim_state x = state_in(world, v, ids[a]), y = state_in(world, v, ids[b]);
            daft_rigid p = daft_rigid_make(x.position, x.rotation), q = daft_rigid_make(y.position, y.rotation);
            daft_rigid relative = daft_rigid_relative(&p, &q);
            assert_false(daft_shape_overlap(&cube, &cube, &relative, 0));
        }
    print_message("fastest %g m/s, highest %g m\n", fastest, highest);
    assert_true(fastest <= 3 && last < 0.01 && highest < 3.5 + 0.01);
    return end_of(world);
}

static void an_overlapping_pyramid_parts(void **unused)
{
    (void)unused;
    play_variants(overlapping_pyramid);
}

/* A stack of ten at 1e7 m falls asleep in the same step as one at the origin, in the same place. */
static int stack_of_ten(const variant *v, daft_dvec3 at, daft_dvec3 *top, uint64_t *hash)
{
    daft_world *world = variant_world(v);
    put(world, v, box(daft_v3(10, 1, 10), at.x, at.y - 1, at.z));
    uint32_t id = 0;
    for (int i = 0; i < 10; i++) id = put(world, v, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), at.x, at.y + 0.5 + i, at.z));
    int tick = 0;
    do steps(world, 1);
    while (daft_world_is_awake(world, id) && ++tick < 1200);
    *top = daft_dsub(place_of(world, v, id), at);
    *hash = hash_of_both(*hash, end_of(world));
    return tick;
}

static uint64_t far_stack(const variant *v)
{
    uint64_t hash = 0;
    daft_dvec3 here, there;
    int when = stack_of_ten(v, daft_dv3(0, 0, 0), &here, &hash),
        then = stack_of_ten(v, daft_dv3(1e7, 1e7, -1e7), &there, &hash);
    print_message("asleep after %d and %d steps, %g m apart\n", when, then, distance_of(here, there));
    assert_int_equal(when, then);
    assert_true(when < 300 && distance_of(here, there) <= 1e-3);
    assert_true(hypot(here.x, here.z) < 0.02);
    return hash;
}

static void a_stack_far_away_is_the_same(void **unused)
{
    (void)unused;
    play_variants(far_stack);
}

/* ---- one in another ---- */

/* What a body can be: of three shapes, or boxes only. */
static one_shape one_of(int i, bool boxes)
{
    one_shape def = boxes || i % 3 ? dynamic_box(daft_v3(0.3f, 0.2f, 0.25f), 0, 0.5, 0) : sphere(0.3, 0, 0.5, 0);
    if (!boxes && i % 3 == 2)
        def.part.shape = (daft_sim_shape){.type = DAFT_GEOMETRY_CAPSULE, .radius = 0.2f, .half_height = 0.2f};
    return def;
}

/* Fastest of all in this tick, less what it may have got by falling from the highest place that any has been at. */
static double fastest_push(const daft_world *world, const uint32_t *ids, int count, double *highest, double *lowest)
{
    double square = 0;
    for (int i = 0; i < count; i++) {
        daft_sim_state s = state_of(world, ids[i]);
        assert_true(daft_dfinite3(s.position) && daft_finite3(s.linear) && daft_finite3(s.angular));
        *highest = fmax(*highest, s.position.y), *lowest = fmin(*lowest, s.position.y);
    }
    for (int i = 0; i < count; i++) {
        daft_sim_state s = state_of(world, ids[i]);
        square = fmax(square, speed_of(s) * speed_of(s) - 2 * G * (*highest - s.position.y));
    }
    return sqrt(square);
}

/* Whether two boxes overlap by more than `deep` metres. */
static bool some_overlap(const daft_world *world, const uint32_t *ids, int count, daft_vec3 half, float deep)
{
    daft_vec3 h = daft_sub(half, daft_v3(deep / 2, deep / 2, deep / 2));
    daft_sim_shape shape = {.type = DAFT_GEOMETRY_BOX, .half = h};
    for (int a = 0; a < count; a++)
        for (int b = 0; b < a; b++) {
            daft_sim_state x = state_of(world, ids[a]), y = state_of(world, ids[b]);
            if (distance_of(x.position, y.position) > 2 * (double)daft_length(h)) continue;
            daft_rigid p = daft_rigid_make(x.position, x.rotation), q = daft_rigid_make(y.position, y.rotation);
            daft_rigid relative = daft_rigid_relative(&p, &q);
            if (daft_shape_overlap(&shape, &shape, &relative, 0)) return true;
        }
    return false;
}

/* Bodies made in one place leave it at `most` m/s; boxes are apart but for `deep` metres after the given seconds. */
static uint64_t spot_comes_apart(const variant *v, int count, bool boxes, int seconds, double most, float deep)
{
    daft_world *world = variant_world(v);
    put_floor(world, v, 2000);
    uint32_t *ids = malloc((size_t)count * sizeof *ids);
    for (int i = 0; i < count; i++) ids[i] = put(world, v, one_of(i, boxes));
    double fastest = 0, lowest = 1e9, highest = 0;
    for (int tick = 0; tick < 60 * seconds; tick++) {
        steps(world, 1);
        fastest = fmax(fastest, fastest_push(world, ids, count, &highest, &lowest));
    }
    print_message("%d: left at %g m/s, up to %g m, lowest %g m\n", count, fastest, highest, lowest);
    assert_true(fastest < most && lowest > 0.1);
    assert_true(!boxes || !some_overlap(world, ids, count, daft_v3(0.3f, 0.2f, 0.25f), deep));
    free(ids);
    return end_of(world);
}

static uint64_t spots(const variant *v)
{
    uint64_t hash = spot_comes_apart(v, 60, false, 10, 4, 0);
    hash = hash_of_both(hash, spot_comes_apart(v, 60, true, 3, 4, 0.01f));
    return hash_of_both(hash, spot_comes_apart(v, 1000, true, 5, 6, 0.03f));
}

static void what_is_made_in_one_spot_comes_apart(void **unused)
{
    (void)unused;
    play_variants(spots);
}

/* ---- ragdolls ---- */

typedef struct ragdoll {
    uint32_t bodies[11], joints[10];
    const variant *v;
    daft_dvec3 hips;
    daft_quat turn; /* of all of it, about the hips */
} ragdoll;

/* Places are from the hips, where it is not turned. */
static daft_dvec3 place_in(const ragdoll *r, double x, double y, double z)
{
    return daft_dadd(r->hips, daft_to_double(daft_quat_rotate(r->turn, daft_v3((float)x, (float)y, (float)z))));
}

static uint32_t limb(daft_world *world, const ragdoll *r, double radius, double half, double x, double y, bool across)
{
    one_shape def = sphere(radius, 0, 0, 0);
    def.part.shape =
        (daft_sim_shape){.type = DAFT_GEOMETRY_CAPSULE, .radius = (float)radius, .half_height = (float)half};
    def.position = place_in(r, x, y, 0);
    def.rotation = across ? daft_quat_mul(r->turn, turned(0, 0, 1, DAFT_PI / 2)) : r->turn;
    def.rolling_resistance = 0.05f;
    return put(world, r->v, def);
}

static uint32_t tie(daft_world *world, const ragdoll *r, daft_joint_kind kind, uint32_t a, uint32_t b, double x,
                    double y, float lower, float upper)
{
    daft_sim_joint_def def = daft_default_sim_joint_def();
    daft_error error = {0};
    def.kind = kind, def.body_a = a, def.body_b = b, def.anchor = variant_at(r->v, place_in(r, x, y, 0));
    /* A hinge's axis is axial, the middle of a cone's swing is not. */
    if (kind == DAFT_JOINT_HINGE)
        def.axis = variant_spin(r->v, daft_quat_rotate(r->turn, daft_v3(1, 0, 0)));
    else
        def.axis = variant_direction(r->v, daft_quat_rotate(r->turn, daft_v3(0, -1, 0)));
    def.limit = true, def.lower = lower, def.upper = upper;
    def.motor = true, def.motor_force = 2; /* N·m of friction */
    uint32_t joint = daft_world_add_joint(world, &def, &error);
    if (!joint) fail_msg("%s", error.message);
    return joint;
}

/* Hips, chest, head; two arms and two legs of two parts each. */
static ragdoll add_ragdoll(daft_world *world, const variant *v, daft_dvec3 hips, daft_quat turn)
{
    ragdoll r = {.v = v, .hips = hips, .turn = turn};
    uint32_t *b = r.bodies;
    b[0] = limb(world, &r, 0.13, 0.08, 0, 0, true);
    b[1] = limb(world, &r, 0.15, 0.1, 0, 0.4, false);
    b[2] = limb(world, &r, 0.11, 0.02, 0, 0.8, false);
    r.joints[0] = tie(world, &r, DAFT_JOINT_BALL, b[0], b[1], 0, 0.15, 0, 0.4f);
    r.joints[1] = tie(world, &r, DAFT_JOINT_BALL, b[1], b[2], 0, 0.66, 0, 0.6f);
    for (int side = -1, n = 3; side <= 1; side += 2, n += 4) {
        double arm = side * 0.25, leg = side * 0.12;
        b[n] = limb(world, &r, 0.06, 0.12, arm, 0.35, false);
        b[n + 1] = limb(world, &r, 0.05, 0.12, arm, 0, false);
        b[n + 2] = limb(world, &r, 0.09, 0.14, leg, -0.35, false);
        b[n + 3] = limb(world, &r, 0.07, 0.16, leg, -0.8, false);
        uint32_t *j = r.joints + n - 1;
        j[0] = tie(world, &r, DAFT_JOINT_BALL, b[1], b[n], arm, 0.53, 0, 1.4f);
        j[1] = tie(world, &r, DAFT_JOINT_HINGE, b[n], b[n + 1], arm, 0.175, -2, 0.1f);
        j[2] = tie(world, &r, DAFT_JOINT_BALL, b[0], b[n + 2], leg, -0.12, 0, 1);
        j[3] = tie(world, &r, DAFT_JOINT_HINGE, b[n + 2], b[n + 3], leg, -0.57, -0.1f, 2);
    }
    return r;
}

static double past_limit(int joint, double value)
{
    static const double limits[10][2] = {{0, 0.4},  {0, 0.6}, {0, 1.4},  {-2, 0.1}, {0, 1},
                                         {-0.1, 2}, {0, 1.4}, {-2, 0.1}, {0, 1},    {-0.1, 2}};
    return fmax(limits[joint][0] - value, value - limits[joint][1]);
}

/* Waves of triangles, 30 cm high, 24 m wide. */
static fixture_mesh hilly_mesh(const variant *v)
{
    enum { CELLS = 40 };
    static daft_vec3 p[(CELLS + 1) * (CELLS + 1)];
    static uint32_t index[CELLS * CELLS * 6];
    for (uint32_t i = 0; i < DAFT_COUNT_OF(p); i++) {
        double x = 0.6 * (i % (CELLS + 1)) - 12, z = 0.6 * (i / (CELLS + 1)) - 12;
        p[i] = daft_v3((float)x, (float)(0.15 * daft_sin(1.3 * x) * daft_cos(0.9 * z)), (float)z);
    }
    uint32_t used = index_field(CELLS, index);
    return variant_mesh(v, p, DAFT_COUNT_OF(p), index, used / 3);
}

enum { FLOOR, STAIRS, TRIANGLES, GROUNDS };
static const char *const GROUND[GROUNDS] = {"floor", "stairs", "triangles"};

static void add_ground(daft_world *world, const variant *v, int ground, const daft_mesh_shape *surface)
{
    one_shape waves = box(daft_v3(1, 1, 1), 0, 0, 0);
    if (surface) waves.part.shape = daft_shape_mesh(surface);
    if (ground == TRIANGLES)
        put(world, v, waves);
    else
        put_floor(world, v, 100);
    for (int i = 0; ground == STAIRS && i < 6; i++)
        put(world, v, box(daft_v3(0.3f * (float)(6 - i), 0.1f, 100), 0, 0.1 + 0.2 * i, 0));
}

/* What became of dolls in 10 s. */
typedef struct falls {
    double open, beyond, lowest; /* widest joint ever; farthest past a limit at the end, radians; m */
    int torn;                    /* dolls of which a joint opened by more than 20 mm */
} falls;

static falls watch(daft_world *world, const ragdoll *dolls, int count)
{
    falls out = {.beyond = -1, .lowest = 1};
    double *open = calloc((size_t)count, sizeof *open);
    for (int tick = 0; tick < 600; tick++) {
        steps(world, 1);
        for (int i = 0; i < count; i++) {
            for (int k = 0; k < 10; k++) {
                daft_sim_joint_state s;
                assert_true(daft_world_get_joint(world, dolls[i].joints[k], &s));
                open[i] = fmax(open[i], distance_of(s.anchor_a, s.anchor_b));
                if (tick == 599) out.beyond = fmax(out.beyond, past_limit(k, (double)s.value));
            }
            for (int k = 0; k < 11; k++) out.lowest = fmin(out.lowest, state_of(world, dolls[i].bodies[k]).position.y);
        }
    }
    for (int i = 0; i < count; i++) out.open = fmax(out.open, open[i]), out.torn += open[i] > 0.02;
    free(open);
    return out;
}

static daft_mesh_shape *make_surface(const fixture_mesh *hills)
{
    daft_error error = {0};
    heap = daft_malloc_allocator();
    daft_mesh_shape *surface = daft_mesh_shape_create(&heap, &hills->mesh, hills->bvh, true, &error);
    assert_non_null(surface);
    return surface;
}

/* They fall 3 m onto a floor, or stairs, or waves of triangles: nobody below the floor, no joint opens by 2 cm even in
 * the impact or leaves its limits by a degree once they lie, and all sleep within 10 s. */
static uint64_t ragdolls(const variant *v)
{
    enum { COUNT = 6 };
    uint64_t hash = 0;
    fixture_mesh hills = hilly_mesh(v);
    daft_mesh_shape *surface = make_surface(&hills);
    for (int ground = 0; ground < GROUNDS; ground++) {
        daft_world *world = variant_world(v);
        add_ground(world, v, ground, surface);
        ragdoll dolls[COUNT];
        for (int i = 0; i < COUNT; i++)
            dolls[i] = add_ragdoll(world, v, daft_dv3(0.3 * i - 0.7, ground == STAIRS ? 5.2 : 4, 3.0 * i - 9),
                                   daft_quat_identity());
        falls f = watch(world, dolls, COUNT);
        print_message("%s: joints open by %g mm, %g degrees past their limits at the end, lowest at %g m, %d awake\n",
                      GROUND[ground], 1000 * f.open, f.beyond * 180 / DAFT_PI, f.lowest, count_awake(world));
        assert_true(f.open < 0.02 && f.beyond < DAFT_PI / 180 && f.lowest > (ground == TRIANGLES ? -0.15 : 0));
        assert_int_equal(count_awake(world), 0);
        hash = hash_of_both(hash, end_of(world));
    }
    daft_mesh_shape_free(surface);
    mesh_drop(&hills);
    return hash;
}

static void ragdolls_stay_whole(void **unused)
{
    (void)unused;
    play_variants(ragdolls);
}

/* Thrown, turned any way: an arm may be caught under the chest at 8 m/s. Whatever stops a limb on its way, or turns it
 * aside, stops what is joined to it, or joints would be torn open by the rest of the way, 10 cm and more. All sleep. */
static uint64_t ragdolls_thrown(const variant *v)
{
    enum { COUNT = 36 };
    uint64_t hash = 0;
    seed_random(88);
    fixture_mesh hills = hilly_mesh(v);
    daft_mesh_shape *surface = make_surface(&hills);
    for (int ground = 0; ground < GROUNDS; ground++) {
        daft_world *world = variant_world(v);
        add_ground(world, v, ground, surface);
        ragdoll dolls[COUNT];
        for (int i = 0; i < COUNT; i++) {
            double x = uniform(-1.5, 1.5), angle = uniform(-DAFT_PI, DAFT_PI);
            daft_dvec3 axis = random_in(-1, 1), hips = daft_dv3(x, ground == STAIRS ? 5.2 : 4, 3.0 * i - 54);
            if (ground == TRIANGLES) hips = daft_dv3(3.2 * (i / 6) - 8, 4, 3.2 * (i % 6) - 8);
            dolls[i] = add_ragdoll(world, v, hips, turned(axis.x, axis.y, axis.z, angle));
            daft_vec3 thrown = daft_to_float(random_in(-1, 1));
            for (int k = 0; k < 11; k++) launch(world, v, dolls[i].bodies[k], thrown, daft_v3(0, 0, 0));
        }
        falls f = watch(world, dolls, COUNT);
        print_message("%s: joints open by %g mm, %d of %d by more than 20; lowest at %g m, %d awake\n", GROUND[ground],
                      1000 * f.open, f.torn, COUNT, f.lowest, count_awake(world));
        assert_true(f.open < 0.02 && f.lowest > (ground == TRIANGLES ? -0.15 : 0));
        assert_int_equal(count_awake(world), 0);
        hash = hash_of_both(hash, end_of(world));
    }
    daft_mesh_shape_free(surface);
    mesh_drop(&hills);
    return hash;
}

static void ragdolls_fall_any_way(void **unused)
{
    (void)unused;
    play_variants(ragdolls_thrown);
}

/* A hundred, close to each other, fall into a pile ("Falling Ragdolls" of Box3D's samples). */
enum { PILE_SIDE = 10, PILE = PILE_SIDE * PILE_SIDE };

static daft_world *pile_of_ragdolls(const variant *v, ragdoll dolls[PILE])
{
    daft_world *world = variant_world(v);
    add_ground(world, v, FLOOR, NULL);
    for (int i = 0; i < PILE; i++) {
        double x = 1.1 * (i % PILE_SIDE) - 5 + uniform(-0.1, 0.1), z = 1.1 * (i / PILE_SIDE) - 5;
        dolls[i] = add_ragdoll(world, v, daft_dv3(x, 4, z), daft_quat_identity());
    }
    return world;
}

static uint64_t hundred_ragdolls(const variant *v)
{
    ragdoll dolls[PILE];
    seed_random(5);
    daft_world *world = pile_of_ragdolls(v, dolls);
    falls f = watch(world, dolls, PILE);
    print_message("joints open by %g mm, %d of %d by more than 20; lowest at %g m, %d awake\n", 1000 * f.open, f.torn,
                  PILE, f.lowest, count_awake(world));
    assert_true(f.open < 0.02 && f.lowest > 0);
    assert_int_equal(count_awake(world), 0);
    return end_of(world);
}

static void a_hundred_ragdolls_come_to_rest(void **unused)
{
    (void)unused;
    play_variants(hundred_ragdolls);
}

/* Limbs that are wedged between others bear ten times their weight, in one point or two as they lie. When the load was
 * forgotten with the point, one pile in eight trembled for ever, by a centimetre. */
static void piles_of_ragdolls_do_not_tremble(void **unused)
{
    (void)unused;
    seed_random(16);
    for (int number = 0; number < 12; number++) {
        ragdoll dolls[PILE];
        daft_world *world = pile_of_ragdolls(&VARIANT[number % 3], dolls);
        int ticks = 60;
        steps(world, ticks);
        while (count_awake(world) > 0 && ticks++ < 20 * 60) steps(world, 1);
        print_message("%s: asleep after %.1f s, %d awake\n", VARIANT[number % 3].name, ticks / 60.0,
                      count_awake(world));
        assert_int_equal(count_awake(world), 0);
        daft_world_destroy(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_house_of_cards_stands),
        cmocka_unit_test(an_arch_stands),
        cmocka_unit_test(dominoes_fall_in_order),
        cmocka_unit_test(a_huge_pyramid_stands_like_a_small_one),
        cmocka_unit_test(an_overlapping_pyramid_parts),
        cmocka_unit_test(a_stack_far_away_is_the_same),
        cmocka_unit_test(what_is_made_in_one_spot_comes_apart),
        cmocka_unit_test(ragdolls_stay_whole),
        cmocka_unit_test(ragdolls_fall_any_way),
        cmocka_unit_test(a_hundred_ragdolls_come_to_rest),
        cmocka_unit_test(piles_of_ragdolls_do_not_tremble),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
