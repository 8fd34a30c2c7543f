/* accel's BVH with spatial splits: no triangle is lost, hits and pictures are those of the plain BVH bit for bit, the tree is
 * the same for any number of threads, memory may run out. */
#include "fixtures.h"
#include "meter.h"

static daft_bvh *grow(const daft_allocator *allocator, const daft_trimesh *mesh, int threads, daft_error *error)
{
    return daft_bvh_build(allocator, mesh, &(daft_bvh_def){.threads = threads, .isa = daft_isa_best(), .spatial_splits = true}, error);
}

/* Small triangles, and long thin ones across the axes, which are what spatial splits are for. */
static void needles(daft_vec3 *p, uint32_t *index, uint32_t count, float scale)
{
    for (uint32_t i = 0; i < count; i++) {
        float length = i % 8 ? 0.02f : 0.8f;
        daft_vec3 at = random_vec3(-1, 1), along = daft_scale(random_vec3(-1, 1), length);
        p[3 * i] = daft_scale(daft_sub(at, along), scale), p[3 * i + 1] = daft_scale(daft_add(at, along), scale);
        p[3 * i + 2] = daft_scale(daft_add(at, random_vec3(-0.02f, 0.02f)), scale);
        for (uint32_t k = 0; k < 3; k++) index[3 * i + k] = 3 * i + k;
    }
}

static fixture_mesh mesh_needles(uint32_t count, float scale)
{
    daft_vec3 *p = malloc(3 * (size_t)count * sizeof *p);
    uint32_t *index = malloc(3 * (size_t)count * sizeof *index);
    needles(p, index, count, scale);
    fixture_mesh m = mesh_make(p, 3 * count, index, count);
    free(p);
    free(index);
    return m;
}

static void every_triangle_is_there(const daft_bvh *bvh, uint32_t count)
{
    uint32_t *seen = calloc(count, sizeof *seen), most = 0;
    for (size_t b = 0; b < bvh->block_count; b++)
        for (int i = 0; i < DAFT_BLOCK; i++)
            if (bvh->blocks[b].triangle[i] != DAFT_NO_TRIANGLE) seen[bvh->blocks[b].triangle[i]]++;
    for (uint32_t i = 0; i < count; i++) {
        assert_true(seen[i] > 0);
        most = seen[i] > most ? seen[i] : most;
    }
    print_message("%u triangles, %zu blocks, one triangle stands in %u places\n", count, bvh->block_count, most);
    free(seen);
}

static void same_hits_as_the_plain_tree(void **unused)
{
    (void)unused;
    fixture_seed(321);
    const daft_allocator allocator = daft_malloc_allocator();
    const float scales[] = {1, 1e-4f, 3e5f};
    for (int round = 0; round < 6; round++) {
        float scale = scales[round % 3];
        fixture_mesh m = mesh_needles(round < 3 ? 300 : 9000, scale);
        daft_bvh *spatial = grow(&allocator, &m.mesh, 2, NULL);
        assert_non_null(spatial);
        every_triangle_is_there(spatial, m.mesh.triangle_count);
        daft_instance a = instance_make(&m, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0))), b = a;
        b.bvh = spatial;
        daft_arena arena;
        daft_arena_init(&arena, &allocator);
        const daft_tlas *top[2] = {daft_tlas_build(&arena, &a, 1, NULL), daft_tlas_build(&arena, &b, 1, NULL)};
        int hits = 0;
        for (int i = 0; i < 4000; i++) {
            uint32_t v = random_bits() % m.mesh.vertex_count;
            daft_vec3 at = daft_v3(m.mesh.x[v], m.mesh.y[v], m.mesh.z[v]), from = random_vec3(-2 * scale, 2 * scale);
            if (i % 2) at = daft_add(at, random_vec3(-0.01f * scale, 0.01f * scale));
            daft_ray ray = {.origin = from, .direction = daft_sub(at, from), .tmax = INFINITY};
            daft_hit hit[2];
            const daft_accel_kernels *kernels = daft_accel_kernels_for(i % (daft_isa_best() + 1));
            bool found = kernels->closest(top[0], &ray, UINT32_MAX, &hit[0]);
            assert_int_equal(kernels->closest(top[1], &ray, UINT32_MAX, &hit[1]), found);
            assert_memory_equal(&hit[0], &hit[1], sizeof hit[0]);
            assert_int_equal(kernels->occluded(top[1], &ray), found);
            hits += found;
        }
        assert_true(hits > 200);
        daft_arena_free(&arena);
        daft_bvh_free(spatial);
        mesh_drop(&m);
    }
}

static void one_tree_for_any_number_of_threads(void **unused)
{
    (void)unused;
    fixture_seed(322);
    const daft_allocator allocator = daft_malloc_allocator();
    fixture_mesh m = mesh_needles(12000, 1);
    daft_bvh *one = grow(&allocator, &m.mesh, 1, NULL), *four = grow(&allocator, &m.mesh, 4, NULL);
    assert_true(one && four);
    assert_int_equal(one->nodes.count, four->nodes.count);
    assert_int_equal(one->block_count, four->block_count);
    assert_memory_equal(one->nodes.items, four->nodes.items, one->nodes.count * sizeof(daft_node));
    assert_memory_equal(one->blocks, four->blocks, one->block_count * sizeof(daft_block));
    daft_bvh_free(one);
    daft_bvh_free(four);
    mesh_drop(&m);
}

static void hard_inputs_build(void **unused)
{
    (void)unused;
    fixture_seed(323);
    enum { COUNT = 3000 };
    const daft_allocator allocator = daft_malloc_allocator();
    static daft_vec3 p[3 * COUNT];
    static uint32_t index[3 * COUNT];
    for (int kind = 0; kind < 5; kind++) {
        needles(p, index, COUNT, kind == 3 ? 1e30f : kind == 4 ? 1e-30f : 1);
        for (uint32_t i = 0; i < 3 * COUNT; i++) {
            if (kind == 0) p[i] = daft_v3((float)(i % 3 == 0), (float)(i % 3 == 1), (float)(i % 3 == 2)); /* all equal */
            if (kind == 1) p[i].y = 7;                                                                  /* in one plane */
            if (kind == 2) p[i].y = p[i].z = 0;                                                         /* in one line */
        }
        for (uint32_t count = 0; count <= COUNT; count = count < 2 ? count + 1 : count == 2 ? COUNT : COUNT + 1) {
            fixture_mesh m = mesh_make(p, 3 * COUNT, index, count);
            daft_bvh *bvh = grow(&allocator, &m.mesh, 2, NULL);
            assert_non_null(bvh);
            if (count) every_triangle_is_there(bvh, count);
            daft_bvh_free(bvh);
            mesh_drop(&m);
        }
    }
}

/* ---- memory ---- */

static void memory_may_run_out_at_any_moment(void **unused)
{
    (void)unused;
    fixture_seed(5);
    fixture_mesh m = mesh_needles(150, 1);
    int failures = 0;
    for (bool built = false; !built; failures++) {
        meter taken = {.left = failures};
        const daft_allocator allocator = {&taken, meter_allocate, meter_release};
        daft_error error = {0};
        daft_bvh *bvh = grow(&allocator, &m.mesh, 1, &error);
        built = bvh != NULL;
        assert_int_equal(error.code, built ? DAFT_OK : DAFT_ERROR_MEMORY);
        daft_bvh_free(bvh);
        assert_int_equal(taken.held, 0);
    }
    assert_true(failures > 10);
    mesh_drop(&m);
}

/* ---- pictures ---- */

enum { WIDTH = 240, HEIGHT = 135, COUNT = 600 };

static void draw(daft_accel accel, bool reference, uint8_t *out)
{
    static daft_vec3 p[3 * COUNT];
    static uint32_t index[3 * COUNT];
    fixture_state = 99;
    needles(p, index, COUNT, 3);
    daft_engine_def def = daft_default_engine_def();
    def.accel = accel;
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_scene *scene = daft_scene_create(engine, NULL);
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = p, mesh.vertex_count = 3 * COUNT, mesh.indices = index, mesh.triangle_count = COUNT;
    daft_entity_def thing = daft_default_entity_def();
    thing.shape = DAFT_SHAPE_MESH, thing.mesh = daft_mesh_create(scene, &mesh, NULL);
    thing.rotation = (daft_quat){0.1f, 0.2f, 0.3f, 0.9f};
    assert_true(daft_entity_create(scene, &thing, NULL).id != 0);
    daft_light_def lamp = daft_default_light_def();
    lamp.position = daft_dv3(5, 9, 4);
    assert_true(daft_light_create(scene, &lamp, NULL).id != 0);
    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at(daft_dv3(4, 2, 3), daft_dv3(0, 0, 0), 1.2f);
    view.reference = reference;
    daft_image *image = daft_image_create(engine, WIDTH, HEIGHT, NULL);
    assert_true(daft_render(scene, &view, image, NULL));
    memcpy(out, daft_image_pixels(image), 4 * WIDTH * HEIGHT);
    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

static void same_pictures_as_the_plain_tree(void **unused)
{
    (void)unused;
    static uint8_t plain[4 * WIDTH * HEIGHT], other[4 * WIDTH * HEIGHT];
    draw(DAFT_ACCEL_BVH, false, plain);
    for (int accel = DAFT_ACCEL_BVH; accel <= DAFT_ACCEL_KDTREE; accel++)
        for (int reference = 0; reference < 2; reference++) {
            draw((daft_accel)accel, reference, other);
            assert_memory_equal(plain, other, sizeof plain);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_hits_as_the_plain_tree),
        cmocka_unit_test(one_tree_for_any_number_of_threads),
        cmocka_unit_test(hard_inputs_build),
        cmocka_unit_test(memory_may_run_out_at_any_moment),
        cmocka_unit_test(same_pictures_as_the_plain_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
