/* sim: a pile of every shape and every joint gives the same bits for any number of workers and any instruction set, and
 * goes on with the same bits from saved bytes; damaged bytes are an error. */
#include "fixtures.h"

#include "math/simd/dispatch.h"
#include "sim_scene.h"

typedef struct shapes {
    daft_hull *hull;
    daft_height_field *field;
    daft_compound *compound;
    fixture_mesh mesh;
    daft_mesh_shape *surface;
} shapes;

enum { ID_HULL = 1, ID_FIELD, ID_COMPOUND, ID_SURFACE };

static shapes make_shapes(void)
{
    shapes s;
    daft_error error = {0};
    daft_allocator allocator = daft_malloc_allocator();
    const daft_vec3 wedge[] = {{-0.4f, -0.3f, -0.3f}, {0.4f, -0.3f, -0.3f}, {0.4f, -0.3f, 0.3f},
                               {-0.4f, -0.3f, 0.3f},  {-0.4f, 0.3f, 0},     {0.3f, 0.25f, 0.05f}};
    s.hull = daft_hull_create(&allocator, wedge, DAFT_COUNT_OF(wedge), 0, &error);
    float heights[17 * 17];
    for (int i = 0; i < 17 * 17; i++) heights[i] = 0.3f * (float)((i * 7919 % 13) % 5) / 5 - 0.2f;
    s.field = daft_height_field_create(&allocator, heights, 17, 17, 0.5f, 0.5f, &error);
    daft_child children[2] = {{.pose = daft_rigid_identity()}, {.pose = daft_rigid_identity()}};
    assert_true(daft_shape_box(daft_v3(0.5f, 0.15f, 0.15f), &children[0].shape, &error));
    assert_true(daft_shape_sphere(0.3f, &children[1].shape, &error));
    children[1].pose.p = daft_dv3(0.6, 0.1, 0);
    s.compound = daft_compound_create(&allocator, children, 2, &error);
    const daft_vec3 corners[] = {{4, 0, -4}, {4, 3, -4}, {4, 0, 4}, {4, 3, 4}};
    const uint32_t indices[] = {0, 2, 1, 1, 2, 3};
    s.mesh = mesh_make(corners, 4, indices, 2);
    return s;
}

static void free_shapes(shapes *s)
{
    daft_mesh_shape_free(s->surface);
    daft_hull_free(s->hull);
    daft_height_field_free(s->field);
    daft_compound_free(s->compound);
    mesh_drop(&s->mesh);
}

static bool find_shape(void *context, uint32_t id, daft_geometry type, daft_sim_shape *out)
{
    shapes *s = context;
    (void)type;
    if (id == ID_HULL) *out = daft_shape_hull(s->hull);
    if (id == ID_FIELD) *out = daft_shape_field(s->field);
    if (id == ID_COMPOUND) *out = daft_shape_compound(s->compound);
    if (id == ID_SURFACE) *out = daft_shape_mesh(s->surface);
    return true;
}

static uint32_t add_thing(daft_world *world, shapes *s, int i)
{
    one_shape def =
        dynamic_box(daft_v3(0.3f, 0.25f, 0.2f), -2 + 0.9 * (i % 5), 1 + 0.5 * (i / 5.0), -1.6 + 0.8 * (i % 4));
    def.rotation = turned(1, i % 3, 0.5, 0.7 * i);
    def.restitution = i % 7 == 0 ? 0.5f : 0;
    def.rolling_resistance = i % 4 == 0 ? 0.02f : 0;
    switch (i % 6) {
    case 0: def.part.shape = (daft_sim_shape){.type = DAFT_GEOMETRY_SPHERE, .radius = 0.3f}; break;
    case 1:
        def.part.shape = (daft_sim_shape){.type = DAFT_GEOMETRY_CAPSULE, .radius = 0.2f, .half_height = 0.3f};
        break;
    case 2: def.part.geometry_id = ID_HULL, def.part.shape = daft_shape_hull(s->hull); break;
    case 3: def.part.geometry_id = ID_COMPOUND, def.part.shape = daft_shape_compound(s->compound); break;
    default: break;
    }
    return add(world, def);
}

static void join(daft_world *world, daft_joint_kind kind, uint32_t a, uint32_t b, int i)
{
    daft_sim_joint_def def = daft_default_sim_joint_def();
    daft_error error = {0};
    def.kind = kind;
    def.body_a = kind == DAFT_JOINT_DRAG ? 0 : a, def.body_b = b;
    def.anchor = state_of(world, a).position;
    def.anchor_b = state_of(world, b).position;
    def.axis = daft_v3(0.3f, 1, 0.2f);
    if (kind == DAFT_JOINT_DRAG) def.anchor = def.anchor_b, def.anchor_b.y += 1;
    def.limit = i % 2 == 0 && kind != DAFT_JOINT_DISTANCE;
    def.lower = -0.5f, def.upper = 0.5f;
    def.motor = i % 3 == 0, def.motor_speed = 2, def.motor_force = 50;
    def.spring = i % 4 == 1;
    def.break_force = i == 5 ? 3000 : 0;
    if (!daft_world_add_joint(world, &def, &error)) fail_msg("%s", error.message);
}

/* A field and a wall of two triangles, a platform that turns, a trigger, as many bodies, and a fifth as many joints. */
static daft_world *make_pile(shapes *s, int bodies)
{
    daft_world *world = new_world();
    one_shape ground = box(daft_v3(1, 1, 1), -4, 0, -4);
    ground.part.shape = daft_shape_field(s->field);
    ground.part.geometry_id = ID_FIELD;
    add(world, ground);
    ground.part.shape = daft_shape_mesh(s->surface);
    ground.part.geometry_id = ID_SURFACE;
    ground.position = daft_dv3(0, 0, 0);
    add(world, ground);
    add_tray(world, daft_dv3(0, -1, 0), 4);
    one_shape bar = box(daft_v3(2.5f, 0.15f, 0.15f), 0, 0.6, 0);
    bar.kind = DAFT_BODY_KINEMATIC;
    daft_world_set_velocity(world, add(world, bar), daft_v3(0, 0, 0), daft_v3(0, 1.5f, 0));
    one_shape trigger = box(daft_v3(1, 1, 1), 1, 1, 1);
    trigger.part.sensor = true;
    add(world, trigger);
    uint32_t last = 0;
    for (int i = 0; i < bodies; i++) {
        uint32_t body = add_thing(world, s, i);
        if (i % 5 == 4) join(world, (daft_joint_kind)(1 + i / 5 % 6), last, body, i / 5);
        last = body;
    }
    return world;
}
static daft_world *make_everything(shapes *s) { return make_pile(s, 60); }

static uint64_t hash_events(const daft_world *world, uint64_t hash)
{
    const daft_sim_event *events;
    uint32_t count = daft_world_events(world, &events);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t whole[] = {events[i].kind, events[i].body_a, events[i].body_b, events[i].joint};
        const float real[] = {events[i].impulse, events[i].speed, events[i].normal.x};
        hash = daft_hash(whole, sizeof whole, hash);
        hash = daft_hash(real, sizeof real, hash);
    }
    return hash;
}

static uint64_t run(daft_world *world, int count, uint64_t hash)
{
    for (int i = 0; i < count; i++) {
        steps(world, 1);
        hash = hash_events(world, hash);
    }
    return hash;
}

/* The same for gcc and clang, debug and release, every machine: change it only together with the simulation. */
#define GOLDEN_HASH 0x69acf4b7a1d94241u

static void everything_is_the_same_for_any_workers_and_instructions(void **unused)
{
    (void)unused;
    shapes s = make_shapes();
    daft_allocator allocator = daft_malloc_allocator();
    s.surface = daft_mesh_shape_create(&allocator, &s.mesh.mesh, s.mesh.bvh, false, NULL);
    for (int isa = 0; isa <= daft_isa_best(); isa++)
        for (int workers = 1; workers <= 4; workers++) {
            if (isa != daft_isa_best() && workers > 1) continue;
            daft_world *world = make_everything(&s);
            daft_world_set_workers(world, workers, isa);
            uint64_t hash = daft_world_hash(world, run(world, 1000, 0));
            print_message("%s, %d workers: 0x%016llx\n", daft_isa_name(isa), workers, (unsigned long long)hash);
            assert_true(hash == GOLDEN_HASH);
            daft_world_destroy(world);
        }
    free_shapes(&s);
}

/* Of a hundred bodies, which one worker sees to, and of four hundred, which all share: the bits after each of 600
 * steps; of a thousand, whose contacts are placed and whose islands are examined in parallel, after each of 120. */
static void each_step_is_the_same_for_any_workers(void **unused)
{
    (void)unused;
    enum { STEPS = 600 };
    static const int WORKERS[] = {1, 1, 2, 4, 8, 16}, BODIES[] = {100, 400, 1000}, COUNTS[] = {STEPS, STEPS, 120};
    static uint64_t first[STEPS];
    shapes s = make_shapes();
    daft_allocator allocator = daft_malloc_allocator();
    s.surface = daft_mesh_shape_create(&allocator, &s.mesh.mesh, s.mesh.bvh, false, NULL);
    for (size_t b = 0; b < DAFT_COUNT_OF(BODIES); b++)
        for (size_t k = 0; k < DAFT_COUNT_OF(WORKERS); k++) {
            if (BODIES[b] == 1000 && WORKERS[k] > 4)
                continue; /* no other code, and slow where there are few processors */
            daft_world *world = make_pile(&s, BODIES[b]);
            daft_world_set_workers(world, WORKERS[k], daft_isa_best());
            uint64_t hash = 0;
            for (int i = 0; i < COUNTS[b]; i++) {
                hash = daft_world_hash(world, run(world, 1, hash));
                if (k == 0) first[i] = hash;
                if (hash != first[i]) fail_msg("%d bodies, %d workers: step %d", BODIES[b], WORKERS[k], i);
            }
            print_message("%d bodies, %d workers: 0x%016llx\n", BODIES[b], WORKERS[k], (unsigned long long)hash);
            daft_world_destroy(world);
        }
    free_shapes(&s);
}

static void saved_worlds_go_on_with_the_same_bits(void **unused)
{
    (void)unused;
    shapes s = make_shapes();
    daft_allocator allocator = daft_malloc_allocator();
    s.surface = daft_mesh_shape_create(&allocator, &s.mesh.mesh, s.mesh.bvh, false, NULL);
    for (int at = 0; at <= 900; at += 300) {
        daft_world *world = make_everything(&s), *other = new_world();
        void *bytes;
        size_t size;
        daft_error error = {0};
        run(world, at, 0);
        assert_true(daft_world_save(world, &bytes, &size, &error));
        add_floor(other, 3); /* what is there is replaced */
        if (!daft_world_load(other, bytes, size, find_shape, &s, &error)) fail_msg("%s", error.message);
        assert_true(daft_world_hash(other, 0) == daft_world_hash(world, 0));
        uint64_t one = run(world, 300, 0), two = run(other, 300, 0);
        assert_true(one == two);
        assert_true(daft_world_hash(world, 0) == daft_world_hash(other, 0));
        daft_release(&heap, bytes);
        daft_world_destroy(world);
        daft_world_destroy(other);
    }
    free_shapes(&s);
}

/* The hash in the header, so that what is made up gets past it. */
static void sign(unsigned char *bytes, size_t size)
{
    const size_t header = 112;
    uint64_t hash = daft_hash(bytes + header, size - header, 0);
    memcpy(bytes + header - sizeof hash, &hash, sizeof hash);
}

static void damaged_bytes_are_an_error(void **unused)
{
    (void)unused;
    seed_random(20261121);
    shapes s = make_shapes();
    daft_allocator allocator = daft_malloc_allocator();
    s.surface = daft_mesh_shape_create(&allocator, &s.mesh.mesh, s.mesh.bvh, false, NULL);
    daft_world *world = make_everything(&s), *other = new_world();
    add_floor(other, 3);
    uint64_t before = daft_world_hash(other, 0);
    void *bytes;
    size_t size;
    daft_error error = {0};
    run(world, 200, 0);
    assert_true(daft_world_save(world, &bytes, &size, &error));
    unsigned char *copy = malloc(size);
    for (int i = 0; i < 300; i++) {
        memcpy(copy, bytes, size);
        size_t at = (size_t)uniform(0, (double)size), cut = i % 3 == 0 ? (size_t)uniform(0, (double)size) : size;
        copy[at] ^= (unsigned char)(1 + (int)uniform(0, 255));
        assert_false(daft_world_load(other, copy, cut, find_shape, &s, &error));
        assert_true(daft_world_hash(other, 0) == before);
    }
    memcpy(copy, bytes, size);
    sign(copy, size);
    assert_true(daft_world_load(other, copy, size, find_shape, &s, &error)); /* that is how it is signed */
    int loaded = 0;
    for (int i = 0; i < 3000; i++) {
        memcpy(copy, bytes, size);
        for (int k = 0; k < 3; k++)
            copy[(size_t)uniform(112, (double)size)] ^= (unsigned char)(1 + (int)uniform(0, 255));
        sign(copy, size);
        if (!daft_world_load(other, copy, size, find_shape, &s, &error)) continue;
        loaded++;
        daft_world_step(other, DT, &error);
        daft_world_remove(other, 20);
        for (uint32_t id = 1; id < 70; id++) assert_true(daft_dfinite3(state_of(other, id).position));
    }
    print_message("%d of 3000 made-up states were taken\n", loaded);
    free(copy);
    daft_release(&heap, bytes);
    daft_world_destroy(world);
    daft_world_destroy(other);
    free_shapes(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_the_same_for_any_workers_and_instructions),
        cmocka_unit_test(each_step_is_the_same_for_any_workers),
        cmocka_unit_test(saved_worlds_go_on_with_the_same_bits),
        cmocka_unit_test(damaged_bytes_are_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
