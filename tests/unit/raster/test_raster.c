/* raster: the pencil sees at every pixel exactly what the reference path sees, on every instruction set, for any number
 * of workers; both are also compared with brute force over all triangles. */
#include "fixtures.h"

#include "math/exact.h"
#include "raster/raster.h"

enum { WIDTH = 150, HEIGHT = 97 }; /* neither a multiple of a tile nor of a lane count */

enum { TILES = ((WIDTH + DAFT_TILE - 1) / DAFT_TILE) * ((HEIGHT + DAFT_TILE - 1) / DAFT_TILE) };

/* Of the picture; of some of each tile's pixels by rays beside their middles; and of some by sixteen turned rays. */
enum { RAYS = DAFT_TILE * DAFT_TILE * DAFT_FINE_RAYS };
typedef struct ids {
    uint32_t instance[WIDTH * HEIGHT], triangle[WIDTH * HEIGHT];
    uint32_t beside[TILES * DAFT_TILE * DAFT_TILE][2], fine[TILES * RAYS][2];
} ids;

typedef struct setting {
    daft_pencil pencil;
    const daft_instance *instances;
    uint32_t count;
} setting;

static daft_pencil pencil_make(float yaw, float pitch, float fov)
{
    double cy = daft_cos((double)yaw), sy = daft_sin((double)yaw), cp = daft_cos((double)pitch),
           sp = daft_sin((double)pitch);
    daft_pencil p = {
        .focal = (float)(WIDTH / 2.0 / daft_tan((double)fov / 2)), .width = WIDTH, .height = HEIGHT, .reach = 0.5f};
    p.forward = daft_v3((float)(cp * cy), (float)-sp, (float)(cp * sy));
    p.right = daft_v3((float)-sy, 0, (float)cy);
    p.up = daft_cross(p.right, p.forward);
    return p;
}

static void keep_tile(const daft_tile *tile, ids *out)
{
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            int from = y * DAFT_TILE_STRIDE + x, to = (tile->y + y) * WIDTH + tile->x + x;
            out->instance[to] = tile->instance[from];
            out->triangle[to] = tile->triangle[from];
        }
}

/* Of every other tile all pixels, of others some. */
static daft_tile_part part_of(uint32_t tile)
{
    daft_tile_part part = {.shift_x = -0.5f, .shift_y = 0.25f};
    for (uint32_t y = 0; y < DAFT_TILE; y++)
        part.asked[y] = tile % 2 ? UINT32_MAX : (tile * DAFT_TILE + y + 1) * 2654435761u;
    return part;
}

static void keep_part(const daft_tile *tile, uint32_t number, ids *out)
{
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            uint32_t *to = out->beside[(number * DAFT_TILE + (uint32_t)y) * DAFT_TILE + (uint32_t)x];
            to[0] = tile->instance[y * DAFT_TILE_STRIDE + x], to[1] = tile->triangle[y * DAFT_TILE_STRIDE + x];
        }
}

/* Within the picture: all rays of some pixels or, of every other tile, some rays of more. */
static void fine_of(uint32_t tile, const daft_tile *place, daft_fine_tile *out)
{
    for (uint32_t y = 0; y < DAFT_TILE; y++) {
        const uint32_t hash = (tile * DAFT_TILE + y + 1) * 2654435761u, few = hash & hash >> 7 & hash >> 13,
                       columns = place->width == DAFT_TILE ? UINT32_MAX : (1u << place->width) - 1;
        out->pixels[y] = (int)y < place->height ? columns & (tile % 2 ? few : hash & hash >> 9) : 0;
        for (uint32_t x = 0; x < DAFT_TILE; x++)
            out->asked[DAFT_TILE * y + x] = (uint16_t)(tile % 2 ? 0xffff : 1u << (hash + x) % 16 | 0x0201);
    }
}

static void keep_fine(const daft_fine_tile *tile, uint32_t number, ids *out)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        const uint32_t pixel = i / DAFT_FINE_RAYS;
        if (!(tile->pixels[pixel / DAFT_TILE] >> pixel % DAFT_TILE & 1)) continue;
        uint32_t *to = out->fine[number * RAYS + i];
        to[0] = tile->instance[i], to[1] = tile->triangle[i];
    }
}

/* isa < 0: the reference path. Work is dealt to the workers in turn, as threads might take it. */
static void see(const setting *s, int isa, int workers, ids *out)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_raster raster;
    daft_error error = {0};
    daft_arena arena;
    daft_arena_init(&arena, &allocator);
    assert_true(daft_raster_init(&raster, &allocator, workers, isa < 0 ? daft_isa_best() : isa, &error));
    assert_true(daft_raster_begin(&raster, &s->pencil, s->instances, s->count, &error));
    const daft_tlas *tlas = daft_tlas_build(&arena, s->instances, s->count, &error);
    assert_non_null(tlas);
    const daft_raster_kernels *kernels = daft_raster_kernels_for(isa < 0 ? 0 : isa);
    daft_tile *tile = malloc(sizeof *tile);
    daft_fine_tile *fine = aligned_alloc(64, sizeof *fine);
    for (uint32_t i = 0; i < raster.work_count; i++) daft_raster_bin(&raster, i, i % (uint32_t)workers);
    for (uint32_t i = 0; i < (uint32_t)(raster.tiles_x * raster.tiles_y); i++) {
        const daft_tile_part part = part_of(i);
        const uint32_t worker = i % (uint32_t)workers;
        if (isa >= 0)
            kernels->tile(&raster, i, worker, NULL, tile);
        else
            daft_reference_tile(&raster, tlas, i, NULL, tile);
        keep_tile(tile, out);
        fine_of(i, tile, fine);
        if (isa >= 0)
            kernels->tile(&raster, i, worker, &part, tile), kernels->fine(&raster, i, worker, fine);
        else
            daft_reference_tile(&raster, tlas, i, &part, tile), daft_reference_fine(&raster, tlas, i, fine);
        keep_part(tile, i, out), keep_fine(fine, i, out);
    }
    free(tile), free(fine);
    daft_raster_free(&raster);
    daft_arena_free(&arena);
}

static uint32_t pixels_seen(const ids *a)
{
    uint32_t count = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) count += a->instance[i] != DAFT_NOTHING;
    return count;
}

/* Gives how many pixels see something. */
static uint32_t agree(const setting *s, const char *name)
{
    ids *reference = calloc(1, sizeof *reference), *pencil = calloc(1, sizeof *pencil);
    see(s, -1, 1, reference);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        for (int workers = 1; workers <= 3; workers += 2) {
            see(s, isa, workers, pencil);
            int wrong = 0, first = -1;
            for (int i = 0; i < WIDTH * HEIGHT; i++)
                if (reference->instance[i] != pencil->instance[i] || reference->triangle[i] != pencil->triangle[i]) {
                    if (first < 0) first = i;
                    wrong++;
                }
            if (wrong)
                fail_msg("%s, %s, %d workers: %d pixels differ, first (%d, %d): reference %u/%u, pencil %u/%u", name,
                         daft_isa_name(isa), workers, wrong, first % WIDTH, first / WIDTH, reference->instance[first],
                         reference->triangle[first], pencil->instance[first], pencil->triangle[first]);
            for (uint32_t i = 0; i < DAFT_COUNT_OF(reference->beside); i++)
                if (memcmp(reference->beside[i], pencil->beside[i], sizeof pencil->beside[i]) != 0)
                    fail_msg("%s, %s, %d workers, beside, tile %u: pixel %u, reference %u/%u, pencil %u/%u", name,
                             daft_isa_name(isa), workers, i / (DAFT_TILE * DAFT_TILE), i % (DAFT_TILE * DAFT_TILE),
                             reference->beside[i][0], reference->beside[i][1], pencil->beside[i][0],
                             pencil->beside[i][1]);
            for (uint32_t i = 0; i < DAFT_COUNT_OF(reference->fine); i++)
                if (memcmp(reference->fine[i], pencil->fine[i], sizeof pencil->fine[i]) != 0)
                    fail_msg("%s, %s, %d workers, fine, tile %u: ray %u, reference %u/%u, pencil %u/%u", name,
                             daft_isa_name(isa), workers, i / RAYS, i % RAYS, reference->fine[i][0],
                             reference->fine[i][1], pencil->fine[i][0], pencil->fine[i][1]);
        }
    }
    uint32_t seen = pixels_seen(reference);
    free(reference);
    free(pencil);
    return seen;
}

static daft_affine still(void) { return affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)); }

static void soups(void **unused)
{
    (void)unused;
    fixture_seed(20261);
    for (int round = 0; round < 12; round++) {
        float spread = round % 3 == 0 ? 0.02f : round % 3 == 1 ? 0.5f : 4;
        fixture_mesh mesh = mesh_soup(round % 3 == 0 ? 5000 : 300, 3, spread);
        daft_instance instances[3] = {
            instance_make(&mesh, affine_make(random_rotation(), daft_v3(1, 1, 1), random_vec3(-1, 1))),
            instance_make(&mesh, affine_make(random_rotation(), daft_v3(2, 0.5f, 1), random_vec3(-4, 4))),
            instance_make(&mesh, affine_make(random_rotation(), daft_v3(1, -1, 1), random_vec3(-4, 4))),
        };
        setting s = {pencil_make(random_float(-3, 3), random_float(-1, 1), random_float(0.3f, 2.5f)), instances, 3};
        assert_true(agree(&s, "soup") > 100);
        mesh_drop(&mesh);
    }
}

static void closed_from_inside(void **unused)
{
    (void)unused;
    fixture_seed(7);
    for (int round = 0; round < 8; round++) {
        fixture_mesh mesh = mesh_ball(round < 4 ? 6 : 60, 1, 0.2f);
        daft_instance instance =
            instance_make(&mesh, affine_make(random_rotation(), daft_v3(2, 2, 2), random_vec3(-0.3f, 0.3f)));
        setting s = {pencil_make(random_float(-3, 3), 0, 2), &instance, 1};
        assert_int_equal(agree(&s, "inside a ball"), WIDTH * HEIGHT);
        mesh_drop(&mesh);
    }
}

/* Two triangles to each quad of side × side vertices, row by row; returns how many indices. */
static uint32_t index_grid(uint32_t side, uint32_t *index)
{
    uint32_t n = 0;
    for (uint32_t y = 0; y + 1 < side; y++)
        for (uint32_t x = 0; x + 1 < side; x++) {
            uint32_t a = y * side + x;
            const uint32_t quad[6] = {a, a + 1, a + side, a + 1, a + side + 1, a + side};
            memcpy(index + n, quad, sizeof quad);
            n += 6;
        }
    return n;
}

/* Edges, vertices and whole triangles that lie exactly on rays, on the axes and on the camera's plane. */
static void on_the_grid(void **unused)
{
    (void)unused;
    enum { SIDE = 13 };
    daft_vec3 p[SIDE * SIDE];
    uint32_t index[6 * (SIDE - 1) * (SIDE - 1)];
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) p[y * SIDE + x] = daft_v3(64, (float)(y - 6) * 2.5f, (float)(x - 6) * 2.5f);
    uint32_t n = index_grid(SIDE, index);
    fixture_mesh mesh = mesh_make(p, SIDE * SIDE, index, n / 3);
    daft_instance instance = instance_make(&mesh, still());
    setting s = {pencil_make(0, 0, 1), &instance, 1};
    s.pencil.focal = 64; /* a step of the grid is then 2.5 pixels: vertices fall on pixel centres */
    uint32_t seen = agree(&s, "grid");
    assert_int_equal(seen, 30 * 30); /* 12 cells of 2.5 pixels, no pixel lost or seen twice along the closed rim's two
                                        sides */
    s.pencil.shift_x = 0.5f;
    agree(&s, "grid, shifted");
    mesh_drop(&mesh);
}

/* Few and large triangles, which fill tiles; some through the camera's plane, beyond what floats hold of their
 * depth, or upon each other; and a mesh that lies before, behind and among them. */
static void walls(void **unused)
{
    (void)unused;
    fixture_seed(811);
    for (int round = 0; round < 16; round++) {
        daft_vec3 p[9];
        const uint32_t index[18] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 1, 2, 3, 4, 5, 6, 7, 8};
        float size = round % 4 == 3 ? 1e12f : round % 4 == 2 ? 1e4f : 200;
        bool ahead = round % 4 == 0; /* the first one is all that there is to see, but for the mesh and what crosses it
                                      */
        for (int i = 0; i < 9; i++) p[i] = daft_add(daft_v3(ahead ? 500 : 0, 0, 0), random_vec3(-size, size));
        for (int i = 0; i < 3 && ahead; i++)
            p[i] = daft_v3(random_float(20, 60), random_float(800, 2000) * (i == 2 ? -1.0f : 1.0f),
                           random_float(2000, 4000) * (i == 1 ? -1.0f : 1.0f) * (i == 2 ? 0.0f : 1.0f));
        fixture_mesh wall = mesh_make(p, 9, index, round % 4 == 2 ? 6 : 3), mesh = mesh_soup(300, 3, 0.5f);
        const daft_vec3 at = daft_scale(random_vec3(-1, 1), round % 3 ? 4 : 40);
        daft_instance instances[3] = {instance_make(&wall, still()),
                                      instance_make(&mesh, affine_make(random_rotation(), daft_v3(2, 2, 2), at)),
                                      instance_make(&wall, still())};
        float turn = ahead ? 0.3f : 3;
        setting s = {pencil_make(random_float(-turn, turn), random_float(-0.3f, 0.3f), random_float(0.3f, 1.5f)),
                     instances, round % 3 == 2 ? 3 : 2};
        agree(&s, "walls");
        mesh_drop(&wall), mesh_drop(&mesh);
    }
}

/* Triangles much longer than wide, from a hundredth of a pixel to two: any way, and along rows and columns of pixels,
 * with corners and sides on their centres; side by side as in a tube, crossing, through the camera's plane, and one
 * upon the other. */
static void long_thin_triangles(void **unused)
{
    (void)unused;
    fixture_seed(246);
    enum { COUNT = 400 };
    daft_vec3 p[3 * COUNT];
    uint32_t index[3 * COUNT];
    for (int round = 0; round < 24; round++) {
        bool on_centres = round % 4 == 3, tube = round % 4 == 2;
        float length = round % 2 ? 150 : 30, far = round % 8 == 1 ? 60.0f : 8.0f;
        for (int i = 0; i < COUNT; i++) {
            daft_vec3 from = daft_v3(64 + random_float(-far, far), random_float(-60, 60), random_float(-80, 80)),
                      along = random_vec3(-1, 1);
            float width = i % 3 == 0 ? 0.01f : i % 3 == 1 ? 0.4f : 2;
            if (on_centres) {
                from = daft_v3(64, floorf(from.y) + (float)(i % 2) * 0.5f, floorf(from.z) + (float)(i % 2) * 0.5f);
                along = i % 8 < 3   ? daft_v3(0, 1, 0)
                        : i % 8 < 6 ? daft_v3(0, 0, 1)
                                    : daft_v3(0, 0.5f, i % 8 == 6 ? 0.5f : -0.5f);
            }
            bool next = tube && i % 8;
            p[3 * i] = next ? p[3 * i - 2] : from;
            p[3 * i + 1] = next ? p[3 * i - 1] : daft_add(from, daft_scale(along, length));
            p[3 * i + 2] = daft_add(p[3 * i + next], on_centres ? daft_v3(0, width < 1 ? 0 : 0.5f, width < 0.1f ? 0 : 1)
                                                                : random_vec3(-width, width));
            for (int k = 0; k < 3; k++) index[3 * i + k] = (uint32_t)(3 * i + k);
        }
        fixture_mesh mesh = mesh_make(p, 3 * COUNT, index, COUNT);
        daft_instance instances[2] = {instance_make(&mesh, still()), instance_make(&mesh, still())};
        setting s = {pencil_make(0, 0, 1), instances, round % 3 == 2 ? 2 : 1};
        s.pencil.focal = 64;
        assert_true(agree(&s, "thin") > 100);
        mesh_drop(&mesh);
    }
}

static void spheres(void **unused)
{
    (void)unused;
    fixture_seed(99);
    for (int round = 0; round < 10; round++) {
        enum { COUNT = 40 };
        daft_instance instances[COUNT];
        for (int i = 0; i < COUNT; i++) {
            float size = i % 4 == 0 ? 100 : i % 4 == 1 ? 0.01f : 1;
            instances[i] = sphere_make(random_vec3(-8, 8), size * random_float(0.01f, 1));
        }
        setting s = {pencil_make(random_float(-3, 3), random_float(-1, 1), 1.5f), instances, COUNT};
        agree(&s, "spheres");
        setting far = {s.pencil, instances, 1};
        instances[0] =
            sphere_make(daft_v3(1e5f * s.pencil.forward.x, 1e5f * s.pencil.forward.y, 1e5f * s.pencil.forward.z), 2e4f);
        assert_true(agree(&far, "far sphere") > 100);
    }
}

/* Layers closer than floats can tell apart, a triangle twice, planes that cut each other. */
static void ties(void **unused)
{
    (void)unused;
    fixture_seed(5);
    fixture_mesh mesh = mesh_soup(60, 2, 3);
    daft_affine a = affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(6, 0, 0)), b = a;
    b.t[0] += 2e-7f;
    daft_instance instances[3] = {instance_make(&mesh, b), instance_make(&mesh, a), instance_make(&mesh, a)};
    setting s = {pencil_make(0, 0, 1.2f), instances, 3};
    assert_true(agree(&s, "ties") > 1000);
    mesh_drop(&mesh);
}

static void huge_and_tiny(void **unused)
{
    (void)unused;
    fixture_seed(3);
    const float scales[] = {1e-12f, 1e-4f, 1e4f, 1e9f, 1e15f};
    for (size_t i = 0; i < DAFT_COUNT_OF(scales); i++) {
        float k = scales[i];
        fixture_mesh mesh = mesh_ball(20, 1, 0.3f);
        daft_instance instances[2] = {
            instance_make(&mesh, affine_make(random_rotation(), daft_v3(k, k, k), daft_v3(3 * k, 0, 0))),
            instance_make(&mesh,
                          affine_make(random_rotation(), daft_v3(k, k, k), daft_v3(3.5f * k, 0.5f * k, 0.2f * k))),
        };
        setting s = {pencil_make(0, 0, 1), instances, 2};
        assert_true(agree(&s, "scaled") > 1000);
        mesh_drop(&mesh);
    }
}

/* A ground plane of two triangles under the camera, to the horizon, and slivers along it. */
static void through_the_camera_plane(void **unused)
{
    (void)unused;
    fixture_seed(11);
    const daft_vec3 p[] = {{-1e7f, -1, -1e7f}, {1e7f, -1, -1e7f},  {1e7f, -1, 1e7f},
                           {-1e7f, -1, 1e7f},  {1e7f, -0.999f, 3}, {-1e6f, 2, -1}};
    const uint32_t index[] = {0, 2, 1, 0, 3, 2, 4, 5, 0, 1, 4, 5};
    fixture_mesh mesh = mesh_make(p, 6, index, 4);
    daft_instance instance = instance_make(&mesh, still());
    for (int i = 0; i < 12; i++) {
        setting s = {pencil_make(random_float(-3, 3), random_float(-1.2f, 1.2f), 1.6f), &instance, 1};
        agree(&s, "ground");
    }
    mesh_drop(&mesh);
}

static void brute_force(void **unused)
{
    (void)unused;
    fixture_seed(77);
    fixture_mesh mesh = mesh_soup(400, 3, 0.7f);
    daft_instance instance = instance_make(&mesh, affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(4, 0, 0)));
    setting s = {pencil_make(0, 0, 1.4f), &instance, 1};
    ids *pencil = malloc(sizeof *pencil);
    see(&s, daft_isa_best(), 1, pencil);
    daft_allocator allocator = daft_malloc_allocator();
    daft_raster raster;
    daft_error error;
    assert_true(daft_raster_init(&raster, &allocator, 1, daft_isa_best(), &error) &&
                daft_raster_begin(&raster, &s.pencil, &instance, 1, &error));
    daft_raster_bin(&raster, 0, 0);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        daft_vec3 ray = daft_pencil_ray(&s.pencil, i % WIDTH, i / WIDTH), c[3];
        double nearest = INFINITY;
        uint32_t triangle = 0;
        for (uint32_t k = 0; k < mesh.mesh.triangle_count; k++) {
            daft_view_corners(&raster.visible[0], k, c);
            if (!daft_pencil_hits(c[0], c[1], c[2], ray)) continue;
            double z = daft_pencil_depth(c[0], c[1], c[2], ray);
            if (z < nearest) nearest = z, triangle = k;
        }
        assert_int_equal(pencil->instance[i], nearest < INFINITY ? 0 : DAFT_NOTHING);
        if (nearest < INFINITY) assert_int_equal(pencil->triangle[i], triangle);
    }
    free(pencil);
    daft_raster_free(&raster);
    mesh_drop(&mesh);
}

/* Many instances of many more triangles than pixels, one behind the other. */
static void many_instances(void **unused)
{
    (void)unused;
    fixture_seed(1000);
    enum { COUNT = 250 };
    fixture_mesh meshes[] = {mesh_ball(40, 0.5f, 0.4f), mesh_soup(2000, 1, 0.05f), mesh_ball(24, 0.4f, 0.3f)};
    daft_instance *instances = malloc(COUNT * sizeof *instances);
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < COUNT; i++) {
            daft_vec3 at = daft_v3(random_float(4, 40), random_float(-6, 6), random_float(-6, 6));
            instances[i] = instance_make(&meshes[i % 3], affine_make(random_rotation(), daft_v3(1, 1, 1), at));
        }
        setting s = {pencil_make(0, 0, 0.8f), instances, COUNT};
        assert_true(agree(&s, "many instances") > WIDTH * HEIGHT / 2);
    }
    free(instances);
    for (int i = 0; i < 3; i++) mesh_drop(&meshes[i]);
}

/* Balls, dented or mirrored or flat, near and far: much of each hides behind its own front. */
static void closed_meshes(void **unused)
{
    (void)unused;
    fixture_seed(5152);
    enum { COUNT = 60 };
    fixture_mesh meshes[2] = {mesh_ball(60, 0.5f, 0), mesh_ball(5, 0.5f, 0.1f)};
    daft_instance instances[COUNT];
    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < COUNT; i++) {
            float far = i % 10 == 0 ? 0.6f : i % 3 == 0 ? 200 : 20, size = far > 100 ? 8 : random_float(0.5f, 2);
            daft_vec3 at =
                daft_v3(random_float(0.1f, 1) * far, random_float(-0.4f, 0.4f) * far, random_float(-0.4f, 0.4f) * far);
            daft_vec3 scale = daft_v3(i % 4 == 1 ? -size : size, size, i % 5 == 2 ? 0.3f * size : size);
            instances[i] = instance_make(&meshes[i % 2], affine_make(random_rotation(), scale, at));
        }
        const setting s = {pencil_make(0, 0, 0.9f), instances, COUNT};
        assert_true(agree(&s, "closed meshes") > WIDTH * HEIGHT / 3);
    }
    mesh_drop(&meshes[0]), mesh_drop(&meshes[1]);
}

/* Corners and edges of triangles smaller than a pixel on its very ray: no pixel is lost. */
static void specks_on_the_grid(void **unused)
{
    (void)unused;
    enum { SIDE = 65, QUADS = (SIDE - 1) * (SIDE - 1) };
    daft_vec3 *p = malloc(SIDE * SIDE * sizeof *p);
    uint32_t *index = malloc(6 * QUADS * sizeof *index);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) p[y * SIDE + x] = daft_v3(64, (float)(y - 32) * 0.25f, (float)(x - 32) * 0.25f);
    uint32_t n = index_grid(SIDE, index);
    fixture_mesh mesh = mesh_make(p, SIDE * SIDE, index, n / 3);
    daft_instance instance = instance_make(&mesh, still());
    setting s = {pencil_make(0, 0, 1), &instance, 1};
    s.pencil.focal = 64; /* a step of the grid is then a quarter of a pixel */
    const float shifts[] = {0, 0.5f, 0.25f, 0.03125f};
    for (size_t i = 0; i < DAFT_COUNT_OF(shifts); i++) {
        s.pencil.shift_x = s.pencil.shift_y = shifts[i];
        assert_in_range(agree(&s, "specks on the grid"), 16 * 16, 17 * 17);
    }
    mesh_drop(&mesh);
    free(p), free(index);
}

/* In a far corner of a very large picture floats are at their coarsest. */
static void specks_in_a_far_corner(void **unused)
{
    (void)unused;
    enum { SIZE = 8192 };
    fixture_seed(8192);
    fixture_mesh mesh = mesh_ball(40, 1, 0.3f);
    daft_allocator allocator = daft_malloc_allocator();
    daft_pencil pencil = {
        .right = {0, 0, 1}, .up = {0, 1, 0}, .forward = {1, 0, 0}, .focal = 3000, .width = SIZE, .height = SIZE};
    daft_raster raster;
    daft_tile *tile = malloc(2 * sizeof *tile);
    uint32_t seen = 0;
    assert_true(daft_raster_init(&raster, &allocator, 1, daft_isa_best(), NULL));
    for (int round = 0; round < 20; round++) {
        float z = random_float(100, 3000), slope = (SIZE / 2 - 16) / pencil.focal;
        daft_instance instance =
            instance_make(&mesh, affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(z, slope * z, slope * z)));
        daft_arena arena;
        daft_arena_init(&arena, &allocator);
        const daft_tlas *tlas = daft_tlas_build(&arena, &instance, 1, NULL);
        assert_true(tlas && daft_raster_begin(&raster, &pencil, &instance, 1, NULL));
        daft_raster_bin(&raster, 0, 0);
        uint32_t corner = (uint32_t)raster.tiles_x - 1;
        daft_reference_tile(&raster, tlas, corner, NULL, &tile[0]);
        for (int i = 0; i < DAFT_TILE * DAFT_TILE_STRIDE; i++) seen += tile[0].instance[i] == 0;
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            daft_raster_kernels_for(isa)->tile(&raster, corner, 0, NULL, &tile[1]);
            for (int y = 0; y < DAFT_TILE; y++) {
                size_t row = (size_t)y * DAFT_TILE_STRIDE, bytes = DAFT_TILE * sizeof(uint32_t);
                assert_memory_equal(&tile[0].instance[row], &tile[1].instance[row], bytes);
                assert_memory_equal(&tile[0].triangle[row], &tile[1].triangle[row], bytes);
            }
        }
        daft_arena_free(&arena);
    }
    assert_true(seen > 1000);
    free(tile);
    daft_raster_free(&raster);
    mesh_drop(&mesh);
}

/* What cannot be seen is not tested: behind the camera, beside it, between the pixels' rays. */
static void culling(void **unused)
{
    (void)unused;
    fixture_mesh mesh = mesh_ball(40, 1, 0);
    daft_allocator allocator = daft_malloc_allocator();
    daft_raster raster;
    daft_error error;
    assert_true(daft_raster_init(&raster, &allocator, 1, daft_isa_best(), &error));
    daft_pencil pencil = pencil_make(0, 0, 1);
    const daft_vec3 hidden[] = {{-5, 0, 0}, {5, 0, 40}, {5, 40, 0}, {-1e6f, 3, 0}};
    for (size_t i = 0; i < DAFT_COUNT_OF(hidden); i++) {
        daft_instance instance = instance_make(&mesh, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), hidden[i]));
        assert_true(daft_raster_begin(&raster, &pencil, &instance, 1, &error));
        daft_raster_bin(&raster, 0, 0);
        assert_int_equal(raster.bins[0].visible, 0);
        assert_null(raster.visible[0].instance);
    }
    daft_instance speck =
        instance_make(&mesh, affine_make(daft_quat_identity(), daft_v3(1e-3f, 1e-3f, 1e-3f), daft_v3(5, 0, 0)));
    pencil.shift_x = pencil.shift_y = 0.25f; /* WIDTH is even, HEIGHT odd: the speck lies between rays in x alone */
    assert_true(daft_raster_begin(&raster, &pencil, &speck, 1, &error));
    daft_tile *tile = malloc(sizeof *tile);
    for (uint32_t i = 0; i < raster.work_count; i++) daft_raster_bin(&raster, i, 0);
    for (uint32_t i = 0; i < (uint32_t)(raster.tiles_x * raster.tiles_y); i++)
        daft_raster_kernels_for(0)->tile(&raster, i, 0, NULL, tile);
    assert_int_equal(raster.bins[0].tested, 0);
    /* Around the camera: what lies beside a tile is left out, though much of it reaches behind the camera's plane. */
    daft_instance around =
        instance_make(&mesh, affine_make(daft_quat_identity(), daft_v3(9, 9, 9), daft_v3(0.1f, 0.2f, 0)));
    assert_true(daft_raster_begin(&raster, &pencil, &around, 1, &error));
    daft_raster_bin(&raster, 0, 0);
    for (uint32_t i = 0; i < (uint32_t)(raster.tiles_x * raster.tiles_y); i++)
        daft_raster_kernels_for(0)->tile(&raster, i, 0, NULL, tile);
    assert_in_range(raster.bins[0].tested, 1, mesh.mesh.triangle_count);
    free(tile);
    daft_raster_free(&raster);
    mesh_drop(&mesh);
}

/* What the camera sees of instances, in groups and one by one. */
static void compare_seen(const daft_view_instance *group, const daft_view_instance *alone, uint32_t index)
{
    assert_ptr_equal(group->instance, alone->instance);
    if (!alone->instance) return;
    assert_int_equal(group->index, index);
    assert_ptr_equal(group->mesh, alone->mesh);
    assert_ptr_equal(group->bvh, alone->bvh);
    assert_memory_equal(&group->to_view, &alone->to_view, sizeof alone->to_view);
    assert_memory_equal(&group->near_z, &alone->near_z, sizeof alone->near_z);
    assert_int_equal(group->x0, alone->x0), assert_int_equal(group->x1, alone->x1);
    assert_int_equal(group->y0, alone->y0), assert_int_equal(group->y1, alone->y1);
    assert_int_equal(group->dense, alone->dense);
}

static daft_affine anywhere(void)
{
    float size = ldexpf(random_float(0.5f, 1), (int)(random_bits() % 16) - 10), far = random_bits() % 8 ? 6 : 1e6f;
    daft_vec3 scale =
        random_bits() % 3 ? daft_v3(size, size, size) : daft_v3(size, -size, random_bits() % 4 ? 0.01f * size : 1e-13f);
    daft_quat turn = random_bits() % 8 ? random_rotation() : daft_quat_identity();
    daft_affine map = affine_make(turn, scale, random_vec3(-far, far));
    if (random_bits() % 64 == 0) map.m[random_bits() % 9] = random_bits() % 2 ? 3e38f : 0;
    return map;
}

/* A group's lanes are the bits of one thing alone: kernels of any width may take any part of them. */
static void groups_and_alone(void **unused)
{
    (void)unused;
    enum { INSTANCES = 640 };
    fixture_seed(1616);
    daft_allocator allocator = daft_malloc_allocator();
    daft_instance *instances = malloc(INSTANCES * sizeof *instances);
    daft_raster group, alone;
    fixture_mesh mesh[] = {mesh_ball(12, 1, 0.4f), mesh_ball(5, 1, 0), mesh_ball(4, 3, 0.9f)};
    uint32_t seen = 0;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        assert_true(daft_raster_init(&group, &allocator, 1, isa, NULL) &&
                    daft_raster_init(&alone, &allocator, 1, isa, NULL));
        for (int round = 0; round < 8; round++) {
            daft_pencil pencil = pencil_make(random_float(0, 6), random_float(-1, 1), random_float(0.2f, 2.5f));
            pencil.shift_x = round % 2 ? 0.375f : 0, pencil.shift_y = -0.125f;
            for (uint32_t i = 0; i < INSTANCES; i++)
                instances[i] = instance_make(&mesh[i < INSTANCES / 2 ? 0 : random_bits() % 3], anywhere());
            assert_true(daft_raster_begin(&group, &pencil, instances, INSTANCES, NULL));
            for (uint32_t i = 0; i < group.work_count; i++) daft_raster_bin(&group, i, 0);
            for (uint32_t i = 0; i < INSTANCES; i++) {
                assert_true(daft_raster_begin(&alone, &pencil, &instances[i], 1, NULL));
                daft_raster_bin(&alone, 0, 0);
                compare_seen(&group.visible[i], &alone.visible[0], i);
                seen += alone.visible[0].instance != NULL;
            }
        }
        daft_raster_free(&group), daft_raster_free(&alone);
    }
    assert_true(seen > 500);
    for (size_t i = 0; i < DAFT_COUNT_OF(mesh); i++) mesh_drop(&mesh[i]);
    free(instances);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(soups),
        cmocka_unit_test(closed_from_inside),
        cmocka_unit_test(on_the_grid),
        cmocka_unit_test(spheres),
        cmocka_unit_test(ties),
        cmocka_unit_test(huge_and_tiny),
        cmocka_unit_test(through_the_camera_plane),
        cmocka_unit_test(brute_force),
        cmocka_unit_test(culling),
        cmocka_unit_test(many_instances),
        cmocka_unit_test(specks_on_the_grid),
        cmocka_unit_test(specks_in_a_far_corner),
        cmocka_unit_test(closed_meshes),
        cmocka_unit_test(long_thin_triangles),
        cmocka_unit_test(walls),
        cmocka_unit_test(groups_and_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
