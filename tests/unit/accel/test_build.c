/* accel's builders: the same tree for any number of threads and any instruction set; every thing in exactly one place
 * and inside all boxes above it; inputs that defeat naive builders; memory that runs out at any moment. */
#include "fixtures.h"
#include "meter.h"

static daft_bvh *build(const daft_trimesh *mesh, int threads, int isa)
{
    const daft_allocator allocator = daft_malloc_allocator();
    daft_bvh *bvh = daft_bvh_build(&allocator, mesh, &(daft_bvh_def){.threads = threads, .isa = isa}, NULL);
    assert_non_null(bvh);
    return bvh;
}

static void assert_same_tree(const daft_bvh *a, const daft_bvh *b)
{
    assert_int_equal(a->nodes.count, b->nodes.count);
    assert_int_equal(a->block_count, b->block_count);
    assert_memory_equal(a->nodes.items, b->nodes.items, a->nodes.count * sizeof(daft_node));
    assert_memory_equal(a->blocks, b->blocks, a->block_count * sizeof(daft_block));
}

static void one_tree_for_any_threads_and_isa(void **unused)
{
    (void)unused;
    fixture_seed(2024);
    const uint32_t counts[] = {1, 5, 300, 9000, 16383, 16384, 70000};
    for (size_t i = 0; i < DAFT_COUNT_OF(counts); i++) {
        fixture_mesh m = mesh_soup(counts[i], 5, 0.2f);
        for (int isa = 0; isa <= daft_isa_best(); isa++)
            for (int threads = 1; threads <= 5; threads += 2) {
                daft_bvh *other = build(&m.mesh, threads, isa);
                assert_same_tree(m.bvh, other);
                daft_bvh_free(other);
            }
        mesh_drop(&m);
    }
}

/* ---- what a tree must be ---- */

typedef struct walk {
    const daft_bvh *bvh;
    uint32_t *seen; /* how often a triangle occurs */
    uint32_t blocks;
    int deepest;
} walk;

static void check_inside(const daft_vec3 p, const float low[3], const float high[3])
{
    const float at[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; k++) assert_true(at[k] >= low[k] && at[k] <= high[k]);
}

static void check_block(walk *w, const daft_block *block, const float low[3], const float high[3])
{
    w->blocks++;
    assert_true(block->triangle[0] != DAFT_NO_TRIANGLE);
    for (int i = 0; i < DAFT_BLOCK; i++) {
        if (block->triangle[i] != DAFT_NO_TRIANGLE) w->seen[block->triangle[i]]++;
        for (int k = 0; k < 3; k++)
            check_inside(daft_v3(block->corner[k][0][i], block->corner[k][1][i], block->corner[k][2][i]), low, high);
    }
}

static void check_node(walk *w, uint32_t number, const float low[3], const float high[3], int depth)
{
    assert_true(number < w->bvh->nodes.count);
    const daft_node *node = &w->bvh->nodes.items[number];
    if (depth > w->deepest) w->deepest = depth;
    for (int i = 0; i < DAFT_WIDTH; i++) {
        uint32_t child = node->child[i];
        if (child == DAFT_CHILD_NONE) continue;
        float l[3], h[3];
        for (int k = 0; k < 3; k++) {
            l[k] = node->bounds[k][i], h[k] = node->bounds[k + 3][i];
            assert_true(l[k] >= low[k] && h[k] <= high[k]);
        }
        if (!(child & DAFT_CHILD_LEAF)) {
            check_node(w, child, l, h, depth + 1);
            continue;
        }
        uint32_t first = (child & ~DAFT_CHILD_LEAF) >> 2;
        for (uint32_t b = first; b <= first + (child & 3); b++) {
            assert_true(b < w->bvh->block_count);
            check_block(w, &w->bvh->blocks[b], l, h);
        }
    }
}

/* Gives how deep the tree is. */
static int check_tree(const daft_bvh *bvh, const daft_trimesh *mesh)
{
    walk w = {.bvh = bvh, .seen = calloc(mesh->triangle_count + 1, sizeof(uint32_t))};
    const float low[3] = {mesh->low.x, mesh->low.y, mesh->low.z}, high[3] = {mesh->high.x, mesh->high.y, mesh->high.z};
    if (mesh->triangle_count) check_node(&w, 0, low, high, 1);
    for (uint32_t i = 0; i < mesh->triangle_count; i++) assert_int_equal(w.seen[i], 1);
    assert_int_equal(w.blocks, bvh->block_count);
    assert_true(w.deepest * (DAFT_WIDTH - 1) + DAFT_WIDTH < DAFT_STACK);
    free(w.seen);
    return w.deepest;
}

/* ---- hard inputs ---- */

typedef enum hard_kind { EQUAL, PLANE, LINE, POINTS, HUGE_ONE, DOUBLING, FAR_APART, KINDS } hard_kind;

static void hard_triangle(hard_kind kind, uint32_t i, uint32_t count, daft_vec3 out[3])
{
    float x = random_float(0, 1), y = random_float(0, 1), small = 0.001f;
    daft_vec3 at = daft_v3(x, y, random_float(0, 1));
    if (kind == EQUAL) at = daft_v3(0.25f, 0.5f, 0.75f);
    if (kind == PLANE) at.y = 3;
    if (kind == LINE) at = daft_v3(x, 0, 0);
    if (kind == POINTS) at = daft_scale(at, 1e-30f), small = 1e-33f;
    if (kind == DOUBLING) at = daft_v3(ldexpf(1, (int)(i % 200) - 100), 0, 0), small = at.x * 0.1f;
    if (kind == FAR_APART) at = daft_scale(at, i % 2 ? 1e30f : -1e30f), small = 1e28f;
    if (kind == HUGE_ONE && i == count / 2) small = 1e6f;
    out[0] = at;
    out[1] = daft_add(at, daft_v3(small, 0, kind == LINE ? 0 : small));
    out[2] = daft_add(
        at, daft_v3(2 * small, 0, kind == PLANE || kind == LINE ? 0 : 2 * small + (float)(kind == EQUAL) * 0.1f));
}

static fixture_mesh hard_mesh(hard_kind kind, uint32_t count)
{
    daft_vec3 *p = malloc((3 * (size_t)count + 1) * sizeof *p);
    uint32_t *index = malloc((3 * (size_t)count + 1) * sizeof *index);
    for (uint32_t i = 0; i < count; i++) {
        hard_triangle(kind, i, count, &p[3 * (size_t)i]);
        for (uint32_t k = 0; k < 3; k++) index[3 * i + k] = 3 * i + k;
    }
    fixture_mesh m = mesh_make(p, 3 * count, index, count);
    free(p);
    free(index);
    return m;
}

static void hard_inputs_build_shallow(void **unused)
{
    (void)unused;
    fixture_seed(77);
    const uint32_t counts[] = {0, 1, 2, 17, 3000, 60000};
    for (int kind = 0; kind < KINDS; kind++)
        for (size_t i = 0; i < DAFT_COUNT_OF(counts); i++) {
            fixture_mesh m = hard_mesh((hard_kind)kind, counts[i]);
            daft_bvh *other = build(&m.mesh, 3, 0);
            assert_true(check_tree(m.bvh, &m.mesh) <= 32);
            assert_same_tree(m.bvh, other);
            daft_bvh_free(other);
            mesh_drop(&m);
        }
}

static void one_huge_among_a_million_tiny(void **unused)
{
    (void)unused;
    fixture_seed(78);
    fixture_mesh m = hard_mesh(HUGE_ONE, 1000001);
    assert_true(check_tree(m.bvh, &m.mesh) <= 24);
    assert_true(daft_bvh_bytes(m.bvh) < 96u * 1000001);
    mesh_drop(&m);
}

/* ---- memory ---- */

static void memory_may_run_out_at_any_moment(void **unused)
{
    (void)unused;
    fixture_seed(5);
    fixture_mesh m = mesh_soup(17000, 4, 0.1f); /* enough for a grid */
    for (int threads = 1; threads <= 3; threads += 2) {
        int failures = 0;
        for (bool built = false; !built; failures++) {
            meter taken = {.left = failures};
            const daft_allocator allocator = {.user = &taken, .allocate = meter_allocate, .release = meter_release};
            daft_error error = {0};
            daft_bvh *bvh = daft_bvh_build(&allocator, &m.mesh, &(daft_bvh_def){.threads = threads}, &error);
            built = bvh != NULL;
            assert_int_equal(error.code, built ? DAFT_OK : DAFT_ERROR_MEMORY);
            if (built) assert_same_tree(m.bvh, bvh);
            daft_bvh_free(bvh);
            assert_int_equal(taken.held, 0);
        }
        assert_true(failures > 8);
    }
    mesh_drop(&m);
}

/* ---- refit ---- */

static void bend(const daft_trimesh *mesh, float amount, daft_vec3 *out)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        float angle = amount * mesh->y[i], c = (float)daft_cos((double)angle), s = (float)daft_sin((double)angle);
        out[i] =
            daft_v3(mesh->x[i] * c - mesh->z[i] * s, mesh->y[i] + 0.1f * amount * s, mesh->x[i] * s + mesh->z[i] * c);
    }
}

/* Rays through a fitted tree find, bit for bit, what rays through a tree that is built anew find. */
static void same_hits(const fixture_mesh *fitted, const daft_bvh *fresh)
{
    daft_instance a = instance_make(fitted, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0))),
                  b = a;
    b.bvh = fresh;
    daft_allocator allocator = daft_malloc_allocator();
    daft_arena arena;
    daft_arena_init(&arena, &allocator);
    const daft_tlas *top[2] = {daft_tlas_build(&arena, &a, 1, NULL), daft_tlas_build(&arena, &b, 1, NULL)};
    const daft_accel_kernels *kernels = daft_accel_kernels_for(daft_isa_best());
    int hits = 0;
    for (int i = 0; i < 4000; i++) {
        uint32_t v = random_bits() % fitted->mesh.vertex_count;
        daft_vec3 at = daft_v3(fitted->mesh.x[v], fitted->mesh.y[v], fitted->mesh.z[v]);
        daft_ray ray = {.origin = random_vec3(-3, 3), .tmax = INFINITY};
        ray.direction = daft_sub(daft_add(at, random_vec3(-0.1f, 0.1f)), ray.origin);
        daft_hit hit[2];
        bool found = kernels->closest(top[0], &ray, UINT32_MAX, &hit[0]);
        assert_int_equal(kernels->closest(top[1], &ray, UINT32_MAX, &hit[1]), found);
        assert_memory_equal(&hit[0], &hit[1], sizeof hit[0]);
        hits += found;
    }
    assert_true(hits > 500);
    daft_arena_free(&arena);
}

static void refit_finds_what_a_fresh_tree_finds(void **unused)
{
    (void)unused;
    fixture_seed(41);
    daft_allocator allocator = daft_malloc_allocator();
    fixture_mesh m = mesh_ball(60, 1, 0.05f);
    daft_vec3 *moved = malloc(m.mesh.vertex_count * sizeof *moved);
    int rebuilt = 0;
    for (int step = 0; step < 12; step++) {
        bend(&m.mesh, step < 6 ? 0.1f : 1.5f, moved);
        assert_true(daft_trimesh_deform(&allocator, &m.mesh, moved, NULL, NULL));
        rebuilt += daft_bvh_update(m.bvh, &m.mesh, &(daft_bvh_def){.threads = 1 + step % 3, .isa = daft_isa_best()});
        check_tree(m.bvh, &m.mesh);
        daft_bvh *fresh = build(&m.mesh, 1, 0);
        same_hits(&m, fresh);
        daft_bvh_free(fresh);
        if (step == 2) assert_int_equal(rebuilt, 0); /* gentle bends keep the tree */
    }
    assert_true(rebuilt > 0 && rebuilt < 12);
    free(moved);
    mesh_drop(&m);
}

/* ---- the top level ---- */

static void check_top(const daft_node_list *nodes, const daft_instance *instances, uint32_t number, uint32_t *seen)
{
    const daft_node *node = &nodes->items[number];
    for (int i = 0; i < DAFT_WIDTH; i++) {
        uint32_t child = node->child[i];
        if (child == DAFT_CHILD_NONE) continue;
        if (!(child & DAFT_CHILD_LEAF)) {
            assert_true(child > number && child < nodes->count);
            check_top(nodes, instances, child, seen);
            continue;
        }
        const daft_instance *instance = &instances[child & ~DAFT_CHILD_LEAF];
        const float *low = &instance->low.x, *high = &instance->high.x;
        for (int k = 0; k < 3; k++) assert_true(node->bounds[k][i] <= low[k] && node->bounds[k + 3][i] >= high[k]);
        seen[child & ~DAFT_CHILD_LEAF]++;
    }
}

static void the_top_level_holds_each_instance_once(void **unused)
{
    (void)unused;
    fixture_seed(99);
    enum { MOST = 30000 };
    daft_instance *instances = malloc(MOST * sizeof *instances);
    uint32_t *seen = malloc(MOST * sizeof *seen);
    const uint32_t counts[] = {1, 8, 9, 100, 16384, MOST};
    for (size_t c = 0; c < DAFT_COUNT_OF(counts); c++) {
        for (uint32_t i = 0; i < counts[c]; i++)
            instances[i] = sphere_make(i % 3 ? random_vec3(-100, 100) : daft_v3(1, 2, 3), random_float(0.1f, 2));
        daft_allocator allocator = daft_malloc_allocator();
        const daft_tlas *first = NULL;
        daft_arena arenas[4];
        for (int i = 0; i < 4; i++) {
            daft_arena_init(&arenas[i], &allocator);
            const daft_tlas_def def = {DAFT_INTERSECT_EXACT, 1 + i, i < 3 ? daft_min_i(i, daft_isa_best()) : 0};
            const daft_tlas *tlas = daft_tlas_build_for(&arenas[i], instances, counts[c], &def, NULL);
            assert_non_null(tlas);
            if (!first) first = tlas;
            assert_int_equal(tlas->nodes.count, first->nodes.count);
            assert_memory_equal(tlas->nodes.items, first->nodes.items, first->nodes.count * sizeof(daft_node));
        }
        memset(seen, 0, MOST * sizeof *seen);
        check_top(&first->nodes, instances, 0, seen);
        for (uint32_t i = 0; i < counts[c]; i++) assert_int_equal(seen[i], 1);
        for (int i = 0; i < 4; i++) daft_arena_free(&arenas[i]);
    }
    free(instances);
    free(seen);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_tree_for_any_threads_and_isa),    cmocka_unit_test(hard_inputs_build_shallow),
        cmocka_unit_test(one_huge_among_a_million_tiny),       cmocka_unit_test(memory_may_run_out_at_any_moment),
        cmocka_unit_test(refit_finds_what_a_fresh_tree_finds), cmocka_unit_test(the_top_level_holds_each_instance_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
