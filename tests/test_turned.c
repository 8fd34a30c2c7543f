/* accel's turned trees: taken for what lies across the axes and for nothing else; boxes hold their triangles; every hit, pixel,
 * shadow and query is that of the plain tree, bit for bit; vertices may move; memory may run out. */
#include "fixtures.h"
#include "meter.h"

#include "raster/raster.h"
#include "scene/scene.h"
#include "sim/triangles.h"

enum { SIDES = 6, PIECES = 3, RODS = 150, ROD_TRIANGLES = 2 * SIDES * PIECES, ROD_VERTICES = SIDES * (PIECES + 1) };
static const daft_quat LEANING = {0.18f, 0.35f, 0.42f, 0.82f};

static daft_bvh *tree(const daft_trimesh *mesh, int threads, bool may_turn)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_bvh *bvh = daft_bvh_build(&allocator, mesh, &(daft_bvh_def){.threads = threads, .isa = daft_isa_best(), .may_turn = may_turn}, NULL);
    assert_non_null(bvh);
    return bvh;
}

/* Rods along the x axis, and across it where `ways` is 2 or 3, then all turned, scaled and shifted. */
static fixture_mesh mesh_rods(int ways, daft_quat turn, float scale, daft_vec3 shift)
{
    daft_vec3 *p = malloc(RODS * ROD_VERTICES * sizeof *p);
    uint32_t *index = malloc(RODS * ROD_TRIANGLES * 3 * sizeof *index), next = 0;
    daft_affine map = affine_make(turn, daft_v3(scale, scale, scale), shift);
    for (uint32_t r = 0; r < RODS; r++) {
        daft_vec3 at = random_vec3(-0.5f, 0.5f);
        for (uint32_t i = 0; i < ROD_VERTICES; i++) {
            double angle = 2 * DAFT_PI * (i % SIDES) / SIDES;
            float q[3] = {at.x, at.y, at.z}, *along = q + r % (uint32_t)ways;
            q[(r % (uint32_t)ways + 1) % 3] += 0.006f * (float)daft_cos(angle), q[(r % (uint32_t)ways + 2) % 3] += 0.006f * (float)daft_sin(angle);
            *along += (float)(i / SIDES) / PIECES - 0.5f;
            p[r * ROD_VERTICES + i] = daft_affine_point(&map, daft_v3(q[0], q[1], q[2]));
        }
        for (uint32_t i = 0; i < SIDES * PIECES; i++) {
            uint32_t a = r * ROD_VERTICES + i, b = r * ROD_VERTICES + i / SIDES * SIDES + (i + 1) % SIDES;
            const uint32_t corners[6] = {a, b, b + SIDES, a, b + SIDES, a + SIDES};
            memcpy(index + next, corners, sizeof corners);
            next += 6;
        }
    }
    fixture_mesh m = mesh_make(p, RODS * ROD_VERTICES, index, RODS * ROD_TRIANGLES);
    free(p);
    free(index);
    return m;
}

/* A bumpy square whose normal is z, turned: flat only as a whole, so that a tree's nodes must tell. The same whatever the seed. */
static fixture_mesh mesh_ground(daft_quat turn)
{
    enum { SIDE = 120 };
    static daft_vec3 p[(SIDE + 1) * (SIDE + 1)];
    static uint32_t index[6 * SIDE * SIDE];
    uint32_t next = 0;
    uint64_t state = fixture_state;
    fixture_state = 5;
    daft_affine map = affine_make(turn, daft_v3(1, 1, 1), daft_v3(0, 0, 0));
    for (uint32_t i = 0; i < DAFT_COUNT_OF(p); i++) {
        daft_vec3 q = daft_v3((float)(i % (SIDE + 1)) / SIDE, (float)(i / (SIDE + 1)) / SIDE, random_float(0, 0.004f));
        p[i] = daft_affine_point(&map, q);
    }
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        uint32_t a = i / SIDE * (SIDE + 1) + i % SIDE;
        const uint32_t corners[6] = {a, a + 1, a + SIDE + 2, a, a + SIDE + 2, a + SIDE + 1};
        memcpy(index + next, corners, sizeof corners);
        next += 6;
    }
    fixture_state = state;
    return mesh_make(p, DAFT_COUNT_OF(p), index, 2 * SIDE * SIDE);
}

static bool is_turned(const fixture_mesh *m)
{
    daft_bvh *bvh = tree(&m->mesh, 2, true);
    bool turned = bvh->turned;
    if (!turned) { /* then it is the plain tree */
        assert_int_equal(bvh->nodes.count, m->bvh->nodes.count);
        assert_memory_equal(bvh->nodes.items, m->bvh->nodes.items, bvh->nodes.count * sizeof(daft_node));
        assert_memory_equal(bvh->blocks, m->bvh->blocks, bvh->block_count * sizeof(daft_block));
    }
    daft_bvh_free(bvh);
    return turned;
}

static void turned_where_it_is_worth_it(void **unused)
{
    (void)unused;
    fixture_seed(70);
    const daft_vec3 here = {0, 0, 0};
    for (int i = 0; i < 6; i++) {
        fixture_mesh leaning = mesh_rods(1 + i % 3, LEANING, i % 2 ? 1e-4f : 1e4f, i % 2 ? here : random_vec3(-1e5f, 1e5f));
        fixture_mesh straight = mesh_rods(1 + i % 3, daft_quat_identity(), 1, here);
        fixture_mesh ball = mesh_ball(40 + (uint32_t)i, 1, 0.1f), soup = mesh_soup(3000, 1, 0.05f);
        assert_true(is_turned(&leaning));
        assert_false(is_turned(&straight) || is_turned(&ball) || is_turned(&soup));
        mesh_drop(&leaning), mesh_drop(&straight), mesh_drop(&ball), mesh_drop(&soup);
    }
    fixture_mesh slope = mesh_ground(LEANING), flat = mesh_ground(daft_quat_identity());
    assert_true(is_turned(&slope) && !is_turned(&flat));
    mesh_drop(&slope), mesh_drop(&flat);
}

/* ---- boxes ---- */

/* The corners below a child of a node, as exactly as doubles have them, against its box and all boxes around it. */
static void check_child(const daft_bvh *bvh, uint32_t child, const double low[3], const double high[3])
{
    if (child & DAFT_CHILD_LEAF) {
        const daft_block *blocks = &bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
        for (uint32_t i = 0; i < ((child & 3) + 1) * DAFT_BLOCK * 3; i++) {
            const float(*c)[DAFT_BLOCK] = blocks[i / 12].corner[i % 3];
            uint32_t lane = i / 3 % DAFT_BLOCK;
            daft_dvec3 q = daft_turn_point(&bvh->turn, daft_dv3((double)c[0][lane], (double)c[1][lane], (double)c[2][lane]));
            const double at[3] = {q.x, q.y, q.z};
            for (int k = 0; k < 3; k++) assert_true(at[k] >= low[k] && at[k] <= high[k]);
        }
        return;
    }
    const daft_node *node = &bvh->nodes.items[child];
    for (int i = 0; i < DAFT_WIDTH; i++) {
        if (node->child[i] == DAFT_CHILD_NONE) continue;
        double l[3], h[3];
        for (int k = 0; k < 3; k++) l[k] = fmax(low[k], (double)node->bounds[k][i]), h[k] = fmin(high[k], (double)node->bounds[k + 3][i]);
        check_child(bvh, node->child[i], l, h);
    }
}

static void check_boxes(const daft_bvh *bvh)
{
    assert_true(bvh->turned);
    check_child(bvh, 0, (double[3]){-INFINITY, -INFINITY, -INFINITY}, (double[3]){INFINITY, INFINITY, INFINITY});
}

static void boxes_hold_their_triangles(void **unused)
{
    (void)unused;
    fixture_seed(71);
    for (int i = 0; i < 9; i++) {
        float scale = (float[]){1, 1e-5f, 1e6f}[i % 3];
        fixture_mesh m = mesh_rods(1 + i / 3, random_rotation(), scale, i % 2 ? random_vec3(-300 * scale, 300 * scale) : daft_v3(0, 0, 0));
        daft_bvh *one = tree(&m.mesh, 1, true), *three = tree(&m.mesh, 3, true);
        if (one->turned) check_boxes(one);
        assert_memory_equal(one->nodes.items, three->nodes.items, one->nodes.count * sizeof(daft_node));
        daft_bvh_free(one);
        daft_bvh_free(three);
        mesh_drop(&m);
    }
}

/* ---- rays ---- */

enum { THINGS = 4 };

typedef struct pair { /* the same things, with turned trees and with plain ones */
    daft_instance instances[2][THINGS];
    daft_allocator allocator;
    daft_arena arena;
    const daft_tlas *tlas[2];
} pair;

static void pair_make(pair *p, const fixture_mesh *m, const daft_bvh *turned, float size, int round)
{
    p->allocator = daft_malloc_allocator();
    daft_arena_init(&p->arena, &p->allocator);
    for (int i = 0; i < THINGS; i++) {
        daft_vec3 scale = i < 2 ? daft_v3(1, 1, 1) : daft_v3(random_float(0.3f, 2), 1, i == 3 ? -0.6f : random_float(0.3f, 2));
        daft_vec3 at = daft_scale(random_vec3(-1, 1), i == 0 ? 0 : size);
        p->instances[0][i] = instance_make(m, affine_make(i < 2 ? daft_quat_identity() : random_rotation(), scale, at));
        p->instances[1][i] = p->instances[0][i];
        p->instances[0][i].bvh = turned;
    }
    uint32_t count = round % 2 ? THINGS : 1;
    for (int k = 0; k < 2; k++)
        p->tlas[k] = daft_tlas_build(&p->arena, p->instances[k], count, NULL);
    assert_true(p->tlas[0] && p->tlas[1]);
}

/* To corners, to points of triangles and past them; along axes; from far off; backwards; of any length. */
static daft_ray any_ray(const daft_trimesh *mesh, const daft_instance *thing, float size)
{
    uint32_t t = random_bits() % mesh->triangle_count, kind = random_bits() % 12;
    daft_vec3 corner[3], at;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t v = mesh->indices[3 * t + k];
        corner[k] = daft_affine_point(&thing->to_frame, daft_v3(mesh->x[v], mesh->y[v], mesh->z[v]));
    }
    float u = random_float(0, 1), v = random_float(0, 1 - u);
    at = daft_add(corner[0], daft_add(daft_scale(daft_sub(corner[1], corner[0]), u), daft_scale(daft_sub(corner[2], corner[0]), v)));
    if (kind < 3) at = corner[kind];
    float far = kind == 5 ? 1e4f : kind == 6 ? 1e-3f : 2;
    daft_ray ray = {.origin = daft_add(at, random_vec3(-far * size, far * size)), .tmax = INFINITY};
    if (kind == 7) ray.origin = daft_add(at, daft_v3(random_bits() % 2 ? size : -size, 0, 0));
    if (kind == 8) ray.origin = daft_add(at, daft_v3(0, 0, random_bits() % 2 ? size : -size));
    ray.direction = daft_sub(at, ray.origin);
    if (kind == 9) ray.direction = daft_scale(ray.direction, ldexpf(1, (int)(random_bits() % 160) - 100));
    if (kind == 10) ray.tmin = -1, ray.tmax = random_float(0, 2);
    if (kind == 11) ray.tmin = random_float(0, 1.1f), ray.tmax = random_float(1, 3);
    return ray;
}

static int check_single(const pair *p, const daft_ray *ray)
{
    int found = 0;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        const daft_accel_kernels *kernels = daft_accel_kernels_for(isa);
        daft_hit hit[2];
        found = kernels->closest(p->tlas[0], ray, UINT32_MAX, &hit[0]);
        bool plain = kernels->closest(p->tlas[1], ray, UINT32_MAX, &hit[1]);
        if (plain != found || memcmp(&hit[0], &hit[1], sizeof hit[0]) != 0)
            fail_msg("isa %d: the ray %a %a %a, %a %a %a, %a to %a hits %u at %a, not %u at %a", isa, (double)ray->origin.x, (double)ray->origin.y,
                     (double)ray->origin.z, (double)ray->direction.x, (double)ray->direction.y, (double)ray->direction.z, (double)ray->tmin,
                     (double)ray->tmax, hit[0].triangle, (double)hit[0].t, hit[1].triangle, (double)hit[1].t);
        assert_int_equal(kernels->occluded(p->tlas[0], ray), kernels->occluded(p->tlas[1], ray));
    }
    return found;
}

static void check_together(const pair *p, const daft_ray *rays, uint32_t count)
{
    daft_hit hits[2][64];
    uint32_t stopped[2][2];
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        const daft_accel_kernels *kernels = daft_accel_kernels_for(isa);
        for (int k = 0; k < 2; k++) {
            kernels->closest_stream(p->tlas[k], rays, count, UINT32_MAX, hits[k]);
            kernels->occluded_stream(p->tlas[k], rays, count, stopped[k]);
        }
        assert_memory_equal(hits[0], hits[1], count * sizeof *hits[0]);
        assert_memory_equal(stopped[0], stopped[1], sizeof stopped[0]);
        for (uint32_t i = 0; i < count; i += DAFT_PACKET) {
            daft_ray_packet packet;
            for (uint32_t j = 0; j < DAFT_PACKET; j++) daft_ray_packet_set(&packet, j, &rays[i + j]);
            uint32_t bits = kernels->closest_packet(p->tlas[0], &packet, 0xffff, UINT32_MAX, hits[0]);
            assert_int_equal(bits, kernels->closest_packet(p->tlas[1], &packet, 0xffff, UINT32_MAX, hits[1]));
            for (uint32_t j = 0; j < DAFT_PACKET; j++)
                if (bits >> j & 1) assert_memory_equal(&hits[0][j], &hits[1][j], sizeof hits[0][j]);
            assert_int_equal(kernels->occluded_packet(p->tlas[0], &packet, 0xffff), kernels->occluded_packet(p->tlas[1], &packet, 0xffff));
        }
    }
}

static void same_hits_as_the_plain_tree(void **unused)
{
    (void)unused;
    fixture_seed(72);
    int hits = 0, rays = 0;
    for (int round = 0; round < 12; round++) {
        float size = (float[]){1, 1e-4f, 1e5f}[round % 3];
        fixture_mesh m = mesh_rods(1 + round % 2, LEANING, size, round % 4 == 3 ? random_vec3(-50 * size, 50 * size) : daft_v3(0, 0, 0));
        daft_bvh *turned = tree(&m.mesh, 1, true);
        assert_true(turned->turned);
        pair p;
        pair_make(&p, &m, turned, size, round);
        for (int i = 0; i < 800; i++, rays++) {
            daft_ray ray = any_ray(&m.mesh, &p.instances[1][random_bits() % p.tlas[1]->instance_count], size);
            hits += check_single(&p, &ray);
        }
        for (int i = 0; i < 12; i++) {
            daft_ray many[64];
            for (int j = 0; j < 64; j++) many[j] = any_ray(&m.mesh, &p.instances[1][0], size);
            for (int j = 16; j < 64; j++) { /* about one way, from one place */
                many[j] = many[j / 16 * 16];
                many[j].direction = daft_add(many[j].direction, daft_scale(random_vec3(-0.02f, 0.02f), daft_length(many[j].direction)));
            }
            check_together(&p, many, 64);
        }
        daft_arena_free(&p.arena);
        daft_bvh_free(turned);
        mesh_drop(&m);
    }
    print_message("%d hits of %d rays\n", hits, rays);
    assert_true(hits > rays / 2);
}

static void rays_of_any_size_do_no_harm(void **unused)
{
    (void)unused;
    fixture_seed(73);
    fixture_mesh m = mesh_rods(1, LEANING, 1, daft_v3(0, 0, 0));
    daft_bvh *turned = tree(&m.mesh, 1, true);
    pair p;
    pair_make(&p, &m, turned, 1, 0);
    const float sizes[] = {0, -0.0f, 1e-35f, -1e-30f, 1e-20f, 1, -1, 1e20f, -3e38f, INFINITY, NAN};
    for (int i = 0; i < 8000; i++) {
        float n[6];
        for (int k = 0; k < 6; k++) n[k] = sizes[random_bits() % DAFT_COUNT_OF(sizes)] * (random_bits() % 2 ? 1 : random_float(0, 1));
        daft_ray ray = {.origin = daft_v3(n[0], n[1], n[2]), .direction = daft_v3(n[3], n[4], n[5]), .tmax = i % 2 ? INFINITY : 1e30f};
        check_single(&p, &ray);
    }
    daft_arena_free(&p.arena);
    daft_bvh_free(turned);
    mesh_drop(&m);
}

/* ---- pencils ---- */

static void pixels_are_those_of_the_plain_tree(void **unused)
{
    (void)unused;
    fixture_seed(74);
    daft_allocator allocator = daft_malloc_allocator();
    int drawn = 0;
    for (int round = 0; round < 8; round++) {
        float size = round % 2 ? 1 : 100;
        fixture_mesh m = mesh_rods(1 + round % 2, LEANING, size, round % 3 == 2 ? random_vec3(-40 * size, 40 * size) : daft_v3(0, 0, 0));
        daft_bvh *turned = tree(&m.mesh, 1, true);
        daft_instance things[2];
        daft_vec3 middle = daft_scale(daft_add(m.mesh.low, m.mesh.high), 0.5f);
        daft_affine map = affine_make(random_rotation(), daft_v3(1, random_float(0.5f, 1), 1), daft_v3(0, 0, 0));
        daft_vec3 at = daft_sub(daft_v3(0, 0, -size * (round < 4 ? 1.2f : 0.1f)), daft_affine_point(&map, middle)); /* within it, too */
        map.t[0] = at.x, map.t[1] = at.y, map.t[2] = at.z;
        things[1] = things[0] = instance_make(&m, map);
        things[0].bvh = turned;
        daft_pencil pencil = {.right = {1, 0, 0}, .up = {0, 1, 0}, .forward = {0, 0, -1}, .focal = 90, .width = 160, .height = 96};
        static daft_tile tile[2];
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            daft_raster raster[2];
            daft_arena arena;
            daft_arena_init(&arena, &allocator);
            const daft_tlas *tlas = daft_tlas_build(&arena, things, 1, NULL);
            for (int k = 0; k < 2; k++) {
                assert_true(daft_raster_init(&raster[k], &allocator, 1, daft_isa_best(), NULL));
                assert_true(daft_raster_begin(&raster[k], &pencil, &things[k], 1, NULL));
                for (uint32_t w = 0; w < raster[k].work_count; w++) daft_raster_bin(&raster[k], w, 0);
            }
            for (uint32_t t = 0; t < (uint32_t)(raster[0].tiles_x * raster[0].tiles_y); t++) {
                for (int other = 0; other < 2; other++) { /* drawn, and by the reference path */
                    daft_raster_kernels_for(isa)->tile(&raster[1], t, 0, &tile[1]);
                    if (other) daft_reference_tile(&raster[0], tlas, t, &tile[0]);
                    else daft_raster_kernels_for(isa)->tile(&raster[0], t, 0, &tile[0]);
                    for (int y = 0; y < tile[0].height; y++)
                        for (int x = 0; x < tile[0].width; x++) {
                            int i = y * DAFT_TILE_STRIDE + x;
                            assert_int_equal(tile[0].instance[i], tile[1].instance[i]);
                            drawn += tile[0].instance[i] != DAFT_NOTHING;
                            if (tile[0].instance[i] != DAFT_NOTHING) assert_int_equal(tile[0].triangle[i], tile[1].triangle[i]);
                        }
                }
            }
            for (int k = 0; k < 2; k++) daft_raster_free(&raster[k]);
            daft_arena_free(&arena);
        }
        daft_bvh_free(turned);
        mesh_drop(&m);
    }
    assert_true(drawn > 20000);
}

enum { WIDTH = 240, HEIGHT = 136 };

/* Rods over a ground, with a lamp among them, a sun and mirrors. Spatial splits are never turned. */
static void draw(daft_accel accel, int threads, daft_vec3 lamp_at, const fixture_mesh *m, const daft_vec3 *positions, uint8_t *out)
{
    daft_engine_def def = daft_default_engine_def();
    def.accel = accel, def.threads = threads;
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_scene *scene = daft_scene_create(engine, NULL);
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = positions, mesh.vertex_count = m->mesh.vertex_count;
    mesh.indices = m->mesh.indices, mesh.triangle_count = m->mesh.triangle_count;
    daft_entity_def thing = daft_default_entity_def();
    thing.shape = DAFT_SHAPE_MESH, thing.mesh = daft_mesh_create(scene, &mesh, NULL);
    thing.rotation = (daft_quat){0.1f, -0.2f, 0.1f, 0.95f};
    assert_true(daft_entity_create(scene, &thing, NULL).id != 0);
    thing.shape = DAFT_SHAPE_BOX, thing.rotation = daft_quat_identity();
    thing.size = daft_v3(6, 0.2f, 6), thing.position = daft_dv3(0, -1, 0);
    assert_true(daft_entity_create(scene, &thing, NULL).id != 0);
    daft_light_def lamp = daft_default_light_def();
    lamp.position = daft_to_double(lamp_at);
    assert_true(daft_light_create(scene, &lamp, NULL).id != 0);
    lamp.kind = DAFT_LIGHT_SUN, lamp.direction = daft_v3(-1, -2, -0.5f);
    assert_true(daft_light_create(scene, &lamp, NULL).id != 0);
    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at(daft_dv3(0.9, 0.8, 1.4), daft_dv3(0, -0.2, 0), 1.2f);
    daft_image *image = daft_image_create(engine, WIDTH, HEIGHT, NULL);
    assert_true(daft_render(scene, &view, image, NULL));
    memcpy(out, daft_image_pixels(image), 4 * WIDTH * HEIGHT);
    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
}

static void pictures_are_those_of_the_plain_tree(void **unused)
{
    (void)unused;
    fixture_seed(75);
    static uint8_t turned[4 * WIDTH * HEIGHT], plain[4 * WIDTH * HEIGHT];
    for (int round = 0; round < 4; round++) {
        fixture_mesh m = mesh_rods(1 + round % 3, LEANING, 1, daft_v3(0, 0, 0));
        assert_true(is_turned(&m));
        daft_vec3 *positions = malloc(m.mesh.vertex_count * sizeof *positions), lamp = round % 2 ? daft_v3(0.1f, 0.2f, 0.1f) : daft_v3(2, 4, 1);
        for (uint32_t i = 0; i < m.mesh.vertex_count; i++) positions[i] = daft_v3(m.mesh.x[i], m.mesh.y[i], m.mesh.z[i]);
        draw(DAFT_ACCEL_BVH, 1 + round % 2, lamp, &m, positions, turned);
        for (int accel = DAFT_ACCEL_BVH; accel <= DAFT_ACCEL_KDTREE; accel++) {
            draw((daft_accel)accel, 2, lamp, &m, positions, plain);
            assert_memory_equal(turned, plain, sizeof plain);
        }
        free(positions);
        mesh_drop(&m);
    }
}

/* ---- queries of the simulation ---- */

typedef struct visits {
    uint8_t *seen;
} visits;

static void visit(void *context, uint32_t triangle) { ((visits *)context)->seen[triangle] = 1; }

/* What has a point within the box is visited. */
static void check_query(const daft_sim_shape *s, const daft_trimesh *mesh, const daft_aabb *box)
{
    visits v = {calloc(mesh->triangle_count, 1)};
    daft_triangles_query(s, box, visit, &v);
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        daft_vec3 c[3];
        if (!daft_triangle_get(s, t, c)) continue;
        for (int i = 0; i < 24; i++) { /* corners, points of edges, points within */
            float u = i < 12 ? (float)(i % 4) / 3 : random_float(0, 1), w = i < 4 ? 0 : random_float(0, 1 - u);
            daft_vec3 p = daft_add(c[i % 3], daft_add(daft_scale(daft_sub(c[(i + 1) % 3], c[i % 3]), u),
                                                      daft_scale(daft_sub(c[(i + 2) % 3], c[i % 3]), w)));
            bool within = p.x > box->low.x && p.x < box->high.x && p.y > box->low.y && p.y < box->high.y && p.z > box->low.z && p.z < box->high.z;
            if (within) assert_true(v.seen[t]);
        }
    }
    free(v.seen);
}

static void queries_are_those_of_the_plain_tree(void **unused)
{
    (void)unused;
    fixture_seed(76);
    daft_allocator allocator = daft_malloc_allocator();
    int hits = 0, touched = 0;
    for (int round = 0; round < 4; round++) {
        float size = round % 2 ? 1 : 20;
        fixture_mesh m = mesh_rods(1 + round % 3, LEANING, size, round == 3 ? random_vec3(-30, 30) : daft_v3(0, 0, 0));
        daft_bvh *turned = tree(&m.mesh, 1, true);
        assert_true(turned->turned);
        daft_mesh_shape *mesh[2] = {daft_mesh_shape_create(&allocator, &m.mesh, turned, false, NULL),
                                    daft_mesh_shape_create(&allocator, &m.mesh, m.bvh, false, NULL)};
        daft_sim_shape shape[2] = {daft_shape_mesh(mesh[0]), daft_shape_mesh(mesh[1])}, ball;
        assert_true(daft_shape_sphere(0.02f * size, &ball, NULL));
        daft_vec3 middle = daft_scale(daft_add(m.mesh.low, m.mesh.high), 0.5f);
        for (int i = 0; i < 20; i++) {
            daft_vec3 at = daft_add(middle, random_vec3(-size, size)), half = random_vec3(0, 0.2f * size);
            check_query(&shape[0], &m.mesh, &(daft_aabb){daft_sub(at, half), daft_add(at, half)});
        }
        for (int i = 0; i < 500; i++) {
            daft_dvec3 from = daft_to_double(daft_add(middle, random_vec3(-size, size)));
            daft_dvec3 way = daft_dsub(daft_to_double(daft_add(middle, random_vec3(-size, size))), from);
            daft_ray_result hit[2];
            bool found = daft_shape_raycast(&shape[0], from, way, 2, &hit[0]);
            assert_int_equal(daft_shape_raycast(&shape[1], from, way, 2, &hit[1]), found);
            assert_true(!found || hit[0].t == hit[1].t);
            daft_rigid start = daft_rigid_identity();
            start.p = from;
            daft_impact impact[2];
            daft_impact_kind met = daft_shape_cast(&ball, &start, way, &shape[0], &impact[0]);
            assert_int_equal(daft_shape_cast(&ball, &start, way, &shape[1], &impact[1]), met);
            if (met == DAFT_IMPACT_HIT) assert_true(fabs(impact[0].t - impact[1].t) < 1e-6);
            hits += found, touched += met == DAFT_IMPACT_HIT;
        }
        for (int k = 0; k < 2; k++) daft_mesh_shape_free(mesh[k]);
        daft_bvh_free(turned);
        mesh_drop(&m);
    }
    assert_true(hits > 100 && touched > 300);
}

/* ---- vertices that move, memory that runs out ---- */

static void vertices_may_move(void **unused)
{
    (void)unused;
    fixture_seed(77);
    daft_allocator allocator = daft_malloc_allocator();
    fixture_mesh m = mesh_rods(2, LEANING, 1, daft_v3(0, 0, 0));
    daft_bvh *bvh = tree(&m.mesh, 1, true);
    daft_vec3 *moved = malloc(m.mesh.vertex_count * sizeof *moved);
    const daft_bvh_def def = {.threads = 2, .isa = daft_isa_best(), .may_turn = true};
    int turned = 0, straight = 0;
    for (int step = 0; step < 10; step++) {
        /* shaken, further and further off; then straightened, so that no turned tree is wanted; at last beyond all bounds */
        float far = step < 5 ? ldexpf(1, step) : 1;
        daft_affine map = affine_make(step < 5 ? daft_quat_identity() : (daft_quat){-0.18f, -0.35f, -0.42f, 0.82f}, daft_v3(1, 1, 1),
                                      step < 5 ? random_vec3(-far, far) : daft_v3(0, 0, 0));
        for (uint32_t i = 0; i < m.mesh.vertex_count; i++) {
            daft_vec3 p = daft_v3(m.mesh.x[i], m.mesh.y[i], m.mesh.z[i]);
            moved[i] = daft_add(step > 5 ? p : daft_affine_point(&map, p), random_vec3(-0.001f, 0.001f));
            if (step == 9) moved[i] = daft_scale(p, 1e20f);
        }
        assert_true(daft_trimesh_deform(&allocator, &m.mesh, moved, NULL, NULL));
        daft_bvh_update(bvh, &m.mesh, &def);
        if (bvh->turned) check_boxes(bvh);
        turned += bvh->turned, straight += !bvh->turned;
        daft_bvh *plain = tree(&m.mesh, 1, false);
        fixture_mesh now = {m.mesh, plain};
        pair p;
        pair_make(&p, &now, bvh, 1, 0);
        for (int i = 0; i < 500; i++) {
            daft_ray ray = any_ray(&m.mesh, &p.instances[1][0], step == 9 ? 1e20f : 1);
            check_single(&p, &ray);
        }
        daft_arena_free(&p.arena);
        daft_bvh_free(plain);
    }
    assert_true(turned >= 5 && straight > 0);
    free(moved);
    daft_bvh_free(bvh);
    mesh_drop(&m);
}

/* The slope's tree is built twice. */
static void memory_may_run_out_at_any_moment(void **unused)
{
    (void)unused;
    fixture_seed(78);
    fixture_mesh m = mesh_ground(LEANING);
    int failures = 0;
    for (bool built = false; !built; failures++) {
        meter taken = {.left = failures};
        const daft_allocator allocator = {&taken, meter_allocate, meter_release};
        daft_error error = {0};
        daft_bvh *bvh = daft_bvh_build(&allocator, &m.mesh, &(daft_bvh_def){.threads = 1, .isa = daft_isa_best(), .may_turn = true}, &error);
        built = bvh != NULL;
        assert_int_equal(error.code, built ? DAFT_OK : DAFT_ERROR_MEMORY);
        if (built) assert_true(bvh->turned);
        daft_bvh_free(bvh);
        assert_int_equal(taken.held, 0);
    }
    assert_true(failures > 20);
    mesh_drop(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turned_where_it_is_worth_it),         cmocka_unit_test(boxes_hold_their_triangles),
        cmocka_unit_test(same_hits_as_the_plain_tree),         cmocka_unit_test(rays_of_any_size_do_no_harm),
        cmocka_unit_test(pixels_are_those_of_the_plain_tree),  cmocka_unit_test(pictures_are_those_of_the_plain_tree),
        cmocka_unit_test(queries_are_those_of_the_plain_tree), cmocka_unit_test(vertices_may_move),
        cmocka_unit_test(memory_may_run_out_at_any_moment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
