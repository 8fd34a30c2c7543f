/* accel's kd-tree: rays find in it, bit for bit, what they find in the BVH; pictures are the same; hard inputs stay
 * small and shallow; memory may run out. */
#include "fixtures.h"
#include "meter.h"

#include "accel/kdtree.h"

static daft_kdtree *plant(const daft_trimesh *mesh, int threads)
{
    const daft_allocator allocator = daft_malloc_allocator();
    daft_kdtree *tree = daft_kdtree_build(&allocator, mesh, threads, NULL);
    assert_non_null(tree);
    return tree;
}

/* The same scene, once with BVHs and once with kd-trees. */
typedef struct pair {
    daft_instance bvh[3], kdtree[3];
    const daft_tlas *top[2];
    daft_kdtree *trees[3];
    daft_allocator allocator;
    daft_arena arena;
} pair;

static void pair_make(pair *p, const fixture_mesh *meshes, int count, daft_intersection how)
{
    p->allocator = daft_malloc_allocator();
    daft_arena_init(&p->arena, &p->allocator);
    for (int i = 0; i < count; i++) {
        daft_quat turn = i ? random_rotation() : daft_quat_identity();
        p->bvh[i] = instance_make(&meshes[i], affine_make(turn, daft_v3(1, i ? 0.5f : 1, 1), daft_v3((float)i, 0, 0)));
        p->trees[i] = plant(&meshes[i].mesh, 1 + i);
        p->kdtree[i] = p->bvh[i];
        p->kdtree[i].kdtree = p->trees[i];
    }
    const daft_tlas_def def = {how, 1, 0};
    p->top[0] = daft_tlas_build_for(&p->arena, p->bvh, (uint32_t)count, &def, NULL);
    p->top[1] = daft_tlas_build_for(&p->arena, p->kdtree, (uint32_t)count, &def, NULL);
    assert_true(p->top[0] && p->top[1]);
}

static void pair_drop(pair *p, int count)
{
    for (int i = 0; i < count; i++) daft_kdtree_free(p->trees[i]);
    daft_arena_free(&p->arena);
}

/* Whether the ray hits; both trees and all instruction sets must say the same. */
static bool agree(const pair *p, const daft_ray *ray)
{
    daft_hit first, hit;
    bool found = daft_accel_kernels_for(0)->closest(p->top[0], ray, UINT32_MAX, &first);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        assert_int_equal(daft_accel_kernels_for(isa)->closest(p->top[1], ray, UINT32_MAX, &hit), found);
        assert_memory_equal(&hit, &first, sizeof hit);
        assert_int_equal(daft_accel_kernels_for(isa)->occluded(p->top[1], ray), found);
    }
    return found;
}

/* Rays at vertices, along axes, within planes that cut cells, and any others. */
static daft_ray hard_ray(const daft_trimesh *mesh, int number)
{
    uint32_t v = random_bits() % mesh->vertex_count, w = random_bits() % mesh->vertex_count;
    daft_vec3 at = daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]), from = random_vec3(-3, 3);
    daft_ray ray = {.origin = from, .direction = daft_sub(at, from), .tmax = INFINITY};
    if (number % 5 == 1)
        ray.origin = daft_v3(at.x, from.y, at.z), ray.direction = daft_v3(0, from.y > at.y ? -1 : 1, 0);
    if (number % 5 == 2) ray.origin = daft_v3(at.x, from.y, from.z), ray.direction.x = 0; /* in the plane of a vertex */
    if (number % 5 == 3) ray.direction = daft_sub(daft_v3(mesh->x[w], mesh->y[w], mesh->z[w]), at), ray.origin = at;
    if (number % 5 == 4)
        ray.direction = random_vec3(-1, 1), ray.tmax = random_float(0, 4), ray.tmin = random_float(0, 1);
    return ray;
}

static void same_hits_as_the_bvh(void **unused)
{
    (void)unused;
    fixture_seed(1234);
    fixture_mesh meshes[3] = {mesh_soup(3000, 1, 0.1f), mesh_ball(50, 1, 0.1f), mesh_soup(40, 1, 1)};
    for (int how = 0; how < 3; how++) {
        pair p;
        pair_make(&p, meshes, 3, (daft_intersection)how);
        int hits = 0;
        for (int i = 0; i < 20000; i++) {
            daft_ray ray = hard_ray(&meshes[i % 3].mesh, i);
            if (how != 0 && i % 5 != 4) ray.direction = daft_add(ray.direction, random_vec3(-0.1f, 0.1f));
            hits += agree(&p, &ray);
        }
        assert_true(hits > 5000);
        pair_drop(&p, 3);
    }
    for (int i = 0; i < 3; i++) mesh_drop(&meshes[i]);
}

static void one_tree_for_any_number_of_threads(void **unused)
{
    (void)unused;
    fixture_seed(9);
    fixture_mesh m = mesh_soup(20000, 2, 0.05f);
    daft_kdtree *one = plant(&m.mesh, 1);
    for (int threads = 2; threads <= 5; threads += 3) {
        daft_kdtree *other = plant(&m.mesh, threads);
        assert_int_equal(one->node_count, other->node_count);
        assert_int_equal(one->item_count, other->item_count);
        assert_memory_equal(one->nodes, other->nodes, one->node_count * sizeof *one->nodes);
        assert_memory_equal(one->items, other->items, one->item_count * sizeof *one->items);
        daft_kdtree_free(other);
    }
    daft_kdtree_free(one);
    mesh_drop(&m);
}

static int depth_of(const daft_kdtree *tree, uint32_t node)
{
    uint32_t code = tree->nodes[node].code;
    if ((code & 3) == DAFT_KD_LEAF) return 0;
    int a = depth_of(tree, code >> 2), b = depth_of(tree, (code >> 2) + 1);
    return 1 + (a > b ? a : b);
}

static void hard_inputs_stay_small(void **unused)
{
    (void)unused;
    enum { COUNT = 6000 };
    fixture_seed(8);
    daft_vec3 *p = malloc(3 * COUNT * sizeof *p);
    uint32_t *index = malloc(3 * COUNT * sizeof *index);
    for (uint32_t i = 0; i < 3 * COUNT; i++) index[i] = i;
    for (int kind = 0; kind < 6; kind++) {
        for (uint32_t i = 0; i < COUNT; i++) {
            daft_vec3 at = kind == 0 ? daft_v3(1, 2, 3) : random_vec3(0, 1); /* 0: all equal */
            float size = kind == 2 && i == 7 ? 1e6f : kind == 3 ? 1 : 0.01f; /* 2: one huge; 3: all cross all */
            p[3 * i] = at, p[3 * i + 1] = daft_add(at, daft_v3(size, 0, 0)),
                  p[3 * i + 2] = daft_add(at, daft_v3(0, size, size));
            for (int k = 0; k < 3; k++) {
                if (kind == 1) p[3 * i + (uint32_t)k].y = 0; /* all in one plane */
                if (kind == 4) p[3 * i + (uint32_t)k] = daft_scale(p[3 * i + (uint32_t)k], 1e30f);
                if (kind == 5) p[3 * i + (uint32_t)k] = daft_v3(p[3 * i + (uint32_t)k].x, 0, 0); /* a line */
            }
        }
        for (uint32_t count = 1; count <= COUNT; count = count == 1 ? COUNT : COUNT + 1) {
            fixture_mesh m = mesh_make(p, 3 * COUNT, index, count);
            pair both;
            pair_make(&both, &m, 1, DAFT_INTERSECT_EXACT);
            assert_true(both.trees[0]->item_count <= 4 * (size_t)count + 64);
            assert_true(depth_of(both.trees[0], 0) <= DAFT_KD_DEPTH);
            for (int i = 0; i < 200; i++) {
                daft_ray ray = hard_ray(&m.mesh, i);
                agree(&both, &ray);
            }
            pair_drop(&both, 1);
            mesh_drop(&m);
        }
    }
    fixture_mesh none = mesh_make(p, 3, index, 0);
    daft_kdtree *empty = plant(&none.mesh, 2);
    assert_int_equal(empty->node_count, 0);
    daft_kdtree_free(empty);
    mesh_drop(&none);
    free(p);
    free(index);
}

/* ---- memory ---- */

static void memory_may_run_out_at_any_moment(void **unused)
{
    (void)unused;
    fixture_seed(5);
    fixture_mesh m = mesh_soup(6000, 4, 0.1f);
    int failures = 0;
    for (bool built = false; !built; failures++) {
        meter taken = {.left = failures};
        const daft_allocator allocator = {.user = &taken, .allocate = meter_allocate, .release = meter_release};
        daft_error error = {0};
        daft_kdtree *tree = daft_kdtree_build(&allocator, &m.mesh, 1 + failures % 3, &error);
        built = tree != NULL;
        assert_int_equal(error.code, built ? DAFT_OK : DAFT_ERROR_MEMORY);
        daft_kdtree_free(tree);
        assert_int_equal(taken.held, 0);
    }
    assert_true(failures > 10);
    mesh_drop(&m);
}

/* ---- pictures ---- */

enum { WIDTH = 160, HEIGHT = 90 };

static void draw(const char *scene_path, daft_accel accel, uint8_t *out)
{
    char path[512];
    snprintf(path, sizeof path, "%s/assets/scenes/%s", DAFT_ROOT, scene_path);
    daft_engine_def def = daft_default_engine_def();
    def.accel = accel;
    daft_error error = {0};
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_scene *scene = daft_scene_create(engine, &error);
    daft_image *image = daft_image_create(engine, WIDTH, HEIGHT, &error);
    if (!daft_scene_load(scene, path, &error)) fail_msg("%s", error.message);
    daft_view view = daft_default_view();
    assert_true(daft_scene_get_camera(scene, 0, &view.camera, &error));
    if (!daft_render(scene, &view, image, &error)) fail_msg("%s", error.message);
    memcpy(out, daft_image_pixels(image), 4 * WIDTH * HEIGHT);
    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

static void same_pictures_as_the_bvh(void **unused)
{
    (void)unused;
    static uint8_t pictures[2][4 * WIDTH * HEIGHT];
    const char *const scenes[] = {"hello.scene", "islands.scene", "temple.scene"};
    for (size_t i = 0; i < DAFT_COUNT_OF(scenes); i++) {
        for (int accel = 0; accel < 2; accel++) draw(scenes[i], (daft_accel)accel, pictures[accel]);
        assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
    }
}

static void accelerators_have_names(void **unused)
{
    (void)unused;
    daft_accel accel = DAFT_ACCEL_BVH;
    assert_true(daft_accel_parse("kdtree", &accel) && accel == DAFT_ACCEL_KDTREE);
    assert_true(daft_accel_parse(daft_accel_name(DAFT_ACCEL_BVH), &accel) && accel == DAFT_ACCEL_BVH);
    assert_false(daft_accel_parse("octree", &accel));
    daft_engine_def def = daft_default_engine_def();
    def.accel = (daft_accel)7;
    daft_error error;
    assert_null(daft_engine_create(&def, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_hits_as_the_bvh),     cmocka_unit_test(one_tree_for_any_number_of_threads),
        cmocka_unit_test(hard_inputs_stay_small),   cmocka_unit_test(memory_may_run_out_at_any_moment),
        cmocka_unit_test(same_pictures_as_the_bvh), cmocka_unit_test(accelerators_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
