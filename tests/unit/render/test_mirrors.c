/* render: mirrors in mirrors. Boxes of mirrors against the same unfolded, planes of one mesh against meshes of one
 * plane, what pencils find against what rays find, and where mirrors end. */
#include "math/simd/dispatch.h"
#include "math/vec.h"

#include "stage.h"

#include <stdio.h>

static const daft_vec3 HALF = {3, 2, 2.5f}; /* of the box, metres */

static daft_material flat(stage *s, daft_vec3 ambient, float mirror, daft_vec3 emission)
{
    daft_error error = {0};
    daft_material_def m = daft_default_material_def();
    m.ambient = ambient, m.diffuse = m.specular = (daft_vec3){0, 0, 0}, m.emission = emission, m.mirror = mirror;
    const daft_material made = daft_material_create(s->scene, &m, &error);
    if (!made.id) fail_msg("%s", error.message);
    return made;
}

static void add(stage *s, const daft_entity_def *def)
{
    daft_error error = {0};
    if (!daft_entity_create(s->scene, def, &error).id) fail_msg("%s", error.message);
}

/* ---- boxes, seen from within ---- */

enum { QUADS = 400, MOST_CELLS = 8 };

typedef struct quads {
    uint32_t vertex_count, triangle_count;
    daft_vec3 positions[QUADS * (MOST_CELLS + 1) * (MOST_CELLS + 1)];
    uint32_t indices[6 * QUADS * MOST_CELLS * MOST_CELLS];
} quads;

static void add_quad(quads *q, daft_vec3 at, daft_vec3 u, daft_vec3 v, uint32_t cells)
{
    const uint32_t first = q->vertex_count, side = cells + 1;
    for (uint32_t i = 0; i < side * side; i++)
        q->positions[q->vertex_count++] = daft_add(at, daft_add(daft_scale(u, (float)(i % side) / (float)cells),
                                                                daft_scale(v, (float)(i / side) / (float)cells)));
    for (uint32_t i = 0; i < cells * cells; i++) {
        const uint32_t a = first + i / cells * side + i % cells,
                       corners[6] = {a, a + 1, a + side, a + 1, a + side + 1, a + side};
        memcpy(&q->indices[3 * q->triangle_count], corners, sizeof corners);
        q->triangle_count += 2;
    }
}

/* Side 0 to 5 of a box: -x, +x, -y, +y, -z, +z. */
static void add_side(quads *q, daft_vec3 centre, int side, uint32_t cells)
{
    const int axis = side / 2, i = (axis + 1) % 3, j = (axis + 2) % 3;
    daft_vec3 at = daft_sub(centre, HALF), u = {0, 0, 0}, v = {0, 0, 0};
    if (side % 2) daft_v3_put(&at, axis, daft_v3_at(centre, axis) + daft_v3_at(HALF, axis));
    daft_v3_put(&u, i, 2 * daft_v3_at(HALF, i)), daft_v3_put(&v, j, 2 * daft_v3_at(HALF, j));
    add_quad(q, at, u, v, cells);
}

static void add_mesh(stage *s, const quads *q, daft_material material, daft_quat turn)
{
    daft_error error = {0};
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = q->positions, mesh.vertex_count = q->vertex_count;
    mesh.indices = q->indices, mesh.triangle_count = q->triangle_count;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = daft_mesh_create(s->scene, &mesh, &error), def.material = material;
    def.rotation = daft_quat_normalize(turn);
    if (!def.mesh.id) fail_msg("%s", error.message);
    add(s, &def);
}

static const daft_quat UPRIGHT = {0, 0, 0, 1}, ASKEW = {0.2f, 0.1f, -0.3f, 1};

/* Mirrors on the sides of `mask`: of one mesh, or a mesh for each. */
static void add_mirrors(stage *s, unsigned mask, uint32_t cells, bool apart, daft_quat turn, float mirror)
{
    const daft_material material = flat(s, (daft_vec3){0, 0, 0}, mirror, (daft_vec3){0, 0, 0});
    quads *q = calloc(1, sizeof *q);
    assert_non_null(q);
    for (int side = 0; side < 6; side++) {
        if (!(mask >> side & 1)) continue;
        add_side(q, daft_v3(0, 0, 0), side, cells);
        if (apart) add_mesh(s, q, material, turn), memset(q, 0, sizeof *q);
    }
    if (!apart) add_mesh(s, q, material, turn);
    free(q);
}

typedef struct ball {
    daft_vec3 at, color;
    float radius;
} ball;

static const ball BALLS[] = {{{1.5f, -1, 0.5f}, {0.9f, 0.2f, 0.1f}, 0.7f},
                             {{-1.2f, 0.6f, -1.3f}, {0.1f, 0.8f, 0.3f}, 0.5f},
                             {{0.4f, 1.1f, 1.6f}, {0.2f, 0.3f, 1}, 0.6f},
                             {{-2.2f, -1.2f, 1.4f}, {0.9f, 0.8f, 0.2f}, 0.4f},
                             {{2.4f, 0.9f, -1.6f}, {0.7f, 0.1f, 0.8f}, 0.45f}};
enum { BALL_COUNT = (int)(sizeof BALLS / sizeof *BALLS) };

typedef struct colors {
    daft_material of[BALL_COUNT];
} colors;

static colors colors_make(stage *s)
{
    colors c;
    for (int i = 0; i < BALL_COUNT; i++) c.of[i] = flat(s, BALLS[i].color, 0, (daft_vec3){0, 0, 0});
    return c;
}

static void add_ball(stage *s, const colors *c, int i, daft_vec3 at)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = BALLS[i].radius, def.material = c->of[i];
    def.position = (daft_dvec3){(double)at.x, (double)at.y, (double)at.z};
    add(s, &def);
}

static stage *box_stage(int threads, const char *isa, int depth)
{
    stage *s = stage_make(threads, isa);
    s->view.camera.position = (daft_dvec3){-0.4, 0.1, 0.2};
    s->view.camera.yaw = 0.1f, s->view.camera.pitch = 0.1f, s->view.camera.fov = 1;
    s->view.quality.edge_samples = 0, s->view.quality.mirror_depth = depth;
    daft_scene_set_ambient(s->scene, (daft_vec3){1, 1, 1});
    daft_scene_set_sky_color(s->scene, (daft_vec3){0.25f, 0.5f, 0.4f});
    return s;
}

static void add_balls(stage *s)
{
    const colors c = colors_make(s);
    for (int i = 0; i < BALL_COUNT; i++) add_ball(s, &c, i, BALLS[i].at);
}

static int pixels_apart(const stage *a, const stage *b)
{
    int apart = 0;
    for (int i = 0; i < PIXELS; i++) {
        const daft_vec3 d = daft_sub(a->color[i], b->color[i]);
        apart += fabsf(d.x) + fabsf(d.y) + fabsf(d.z) > 1e-4f;
    }
    return apart;
}

static const char *why(const daft_counters *c) { return c->effects[DAFT_EFFECT_REFLECTION].why; }

/* ---- unfolded ---- */

/* The box's images up to so many mirrorings away, and what the last of the mirrors show. */
static void add_images(stage *s, int depth)
{
    const daft_vec3 none = {0, 0, 0};
    const colors c = colors_make(s);
    quads *q = calloc(1, sizeof *q);
    assert_non_null(q);
    for (int x = -depth; x <= depth; x++)
        for (int y = -depth; y <= depth; y++)
            for (int z = -depth; z <= depth; z++) {
                const int cell[3] = {x, y, z}, far = abs(x) + abs(y) + abs(z);
                if (far > depth) continue;
                const daft_vec3 centre = daft_v3(2 * HALF.x * (float)x, 2 * HALF.y * (float)y, 2 * HALF.z * (float)z);
                for (int i = 0; i < BALL_COUNT; i++) {
                    daft_vec3 p = BALLS[i].at;
                    for (int k = 0; k < 3; k++)
                        if (cell[k] % 2) daft_v3_put(&p, k, -daft_v3_at(p, k));
                    add_ball(s, &c, i, daft_add(p, centre));
                }
                for (int side = 0; far == depth && side < 6; side++)
                    if (side % 2 ? cell[side / 2] >= 0 : cell[side / 2] <= 0) add_side(q, centre, side, 1);
            }
    add_mesh(s, q, flat(s, none, 0, (daft_vec3){0.25f, 0.5f, 0.4f}), UPRIGHT);
    free(q);
}

/* A box of mirrors shows its images: by pencils as far as they reach, by rays beyond. */
static void a_box_of_mirrors_is_its_images(void **unused)
{
    (void)unused;
    for (int depth = 1; depth <= 4; depth++) {
        stage *box = box_stage(2, NULL, depth), *images = box_stage(2, NULL, depth);
        add_mirrors(box, 63, 1, false, UPRIGHT, 1), add_balls(box);
        add_images(images, depth);
        const daft_counters *c = draw(box);
        assert_non_null(strstr(why(c), "mirrored camera"));
        assert_true((strstr(why(c), "in each other") != NULL) == (depth > 1));
        assert_int_equal(draw(images)->reflection_rays, 0);
        const int apart = pixels_apart(box, images);
        print_message("depth %d: %d of %d pixels differ, %llu mirrored rays\n", depth, apart, PIXELS,
                      (unsigned long long)c->reflection_rays);
        assert_true(c->reflection_rays > PIXELS / 2 && apart < PIXELS / 200); /* on edges */
        stage_drop(box), stage_drop(images);
    }
}

/* ---- one mesh, or many ---- */

/* Whatever the mesh, the same bytes: coarse or fine, upright or turned, two facing mirrors or all six. */
static void planes_may_share_a_mesh(void **unused)
{
    (void)unused;
    int nested = 0;
    for (int kind = 0; kind < 8; kind++) {
        const unsigned mask = kind & 1 ? 63 : 3;
        const uint32_t cells = kind & 2 ? 8 : 1;
        const daft_quat turn = kind & 4 ? ASKEW : UPRIGHT;
        stage *one = box_stage(2, NULL, 3), *many = box_stage(1, NULL, 3);
        add_mirrors(one, mask, cells, false, turn, 0.9f), add_balls(one);
        add_mirrors(many, mask, cells, true, turn, 0.9f), add_balls(many);
        assert_non_null(strstr(why(draw(one)), "mirrored camera"));
        nested += strstr(why(daft_scene_counters(one->scene)), "in each other") != NULL;
        draw(many);
        assert_memory_equal(daft_image_pixels(one->image), daft_image_pixels(many->image), 4 * PIXELS);
        assert_memory_equal(one->color, many->color, sizeof one->color);
        stage_drop(one), stage_drop(many);
    }
    assert_true(nested >= 4);
}

/* ---- pencils and rays ---- */

/* A wall and a floor of one mesh behind and through the mirrors, things that stand in them, and a curved mirror. */
static void add_things(stage *s)
{
    const daft_vec3 none = {0, 0, 0};
    quads *q = calloc(1, sizeof *q);
    assert_non_null(q);
    add_quad(q, daft_v3(-9, -2.2f, -9), daft_v3(18, 0, 0), daft_v3(0, 0.4f, 18), 8);
    add_quad(q, daft_v3(3.01f, -4, -5), daft_v3(0, 8, 0), daft_v3(0, 0, 10), 8);
    add_mesh(s, q, flat(s, daft_v3(0.5f, 0.4f, 0.3f), 0, none), UPRIGHT);
    free(q);
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.position = (daft_dvec3){2.8, 0.5, 0.3}, def.size = (daft_vec3){1.2f, 0.8f, 0.5f};
    def.rotation = daft_quat_normalize(ASKEW), def.material = flat(s, daft_v3(0.2f, 0.6f, 0.7f), 0.3f, none);
    add(s, &def);
    def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.position = (daft_dvec3){-0.6, -1.2, -1}, def.radius = 0.5f;
    def.material = flat(s, none, 0.8f, none);
    add(s, &def);
}

static stage *mixed_stage(int threads, const char *isa, int kind, bool rays)
{
    stage *s = box_stage(threads, isa, 2 + kind % 3);
    s->view.camera.yaw = 0.1f - 0.2f * (float)kind;
    if (rays) s->view.quality.tree = DAFT_TREE_BVH;
    add_mirrors(s, kind % 2 ? 55 : 19, kind % 3 ? 4 : 1, false, kind % 2 ? ASKEW : UPRIGHT, 0.8f);
    add_balls(s), add_things(s);
    return s;
}

/* Both show the same but for pixels on edges; the pencils with the same bytes on all instruction sets. */
static void pencils_find_what_rays_find(void **unused)
{
    (void)unused;
    int nested = 0;
    for (int kind = 0; kind < 6; kind++) {
        stage *pencils = mixed_stage(1, NULL, kind, false), *rays = mixed_stage(2, NULL, kind, true);
        const daft_counters *a = draw(pencils), *b = draw(rays);
        assert_non_null(strstr(why(a), "mirrored camera"));
        assert_null(strstr(why(b), "mirrored camera"));
        nested += strstr(why(a), "in each other") != NULL;
        const int apart = pixels_apart(pencils, rays);
        print_message("kind %d: %d of %d pixels differ, %llu mirrored rays\n", kind, apart, PIXELS,
                      (unsigned long long)a->reflection_rays);
        assert_true(apart < PIXELS / 500);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            stage *other = mixed_stage(3, daft_isa_name(isa), kind, false);
            draw(other);
            assert_memory_equal(other->color, pencils->color, sizeof pencils->color);
            stage_drop(other);
        }
        stage_drop(pencils), stage_drop(rays);
    }
    assert_true(nested >= 3);
}

/* ---- where mirrors end ---- */

static void add_box(stage *s, daft_dvec3 at, daft_vec3 size, float white, float mirror)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = size, def.position = at;
    def.material = flat(s, (daft_vec3){white, white, white}, mirror, (daft_vec3){0, 0, 0});
    add(s, &def);
}

/* Six mirrors around the camera, open at the edges of their box: what is left of the light after the last bounce is the
 * sky's mean, by its integral over all directions, and nothing is black. */
static void mirrors_in_mirrors_end_in_the_sky(void **unused)
{
    (void)unused;
    for (int depth = 1; depth < 5; depth++) { /* 0: the sky itself (test_knobs.c) */
        stage *s = stage_make(2, NULL);
        s->view.camera.position = (daft_dvec3){0, 0, 0};
        s->view.quality.edge_samples = 0, s->view.quality.mirror_depth = depth;
        daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
        daft_scene_set_sky_gradient(s->scene, (daft_vec3){0.5f, 0.25f, 1}, (daft_vec3){1, 0.75f, 0.5f});
        const double at[6][3] = {{9, 0, 0}, {-9, 0, 0}, {0, 9, 0}, {0, -9, 0}, {0, 0, 9}, {0, 0, -9}};
        for (int i = 0; i < 6; i++) add_box(s, (daft_dvec3){at[i][0], at[i][1], at[i][2]}, (daft_vec3){8, 8, 8}, 0, 1);
        draw(s);
        int ended = 0;
        for (int i = 0; i < PIXELS; i++) {
            const double wanted[3] = {0.6 * 0.5 + 19.0 / 60, 0.6 * 0.25 + 0.75 * 19 / 60, 0.6 + 0.5 * 19 / 60};
            const daft_vec3 c = s->color[i];
            assert_true(c.x > 0.3f); /* black nowhere */
            ended +=
                fabs((double)c.x - wanted[0]) + fabs((double)c.y - wanted[1]) + fabs((double)c.z - wanted[2]) < 1e-4;
        }
        print_message("depth %d: %d of %d pixels end in the sky's mean\n", depth, ended, PIXELS);
        assert_true(ended > PIXELS / 20);
        stage_drop(s);
    }
}

/* A closed room without a sky: its ambient light stands for what mirrors show no more. */
static void rooms_without_a_sky_end_in_their_light(void **unused)
{
    (void)unused;
    for (int depth = 0; depth < 5; depth++) {
        stage *s = box_stage(2, NULL, depth);
        daft_scene_set_sky_color(s->scene, (daft_vec3){0, 0, 0});
        daft_scene_set_ambient(s->scene, (daft_vec3){0.3f, 0.2f, 0.1f});
        add_mirrors(s, 63, 1, false, ASKEW, 1), add_balls(s);
        draw(s);
        int ended = 0;
        for (int i = 0; i < PIXELS; i++) {
            const daft_vec3 c = s->color[i];
            assert_true(c.x > 0.02f && c.y > 0.01f && c.z > 0.005f);
            ended += fabsf(c.x - 0.3f) + fabsf(c.y - 0.2f) + fabsf(c.z - 0.1f) < 1e-4f;
        }
        assert_true(ended > PIXELS / 20);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_of_mirrors_is_its_images),
        cmocka_unit_test(planes_may_share_a_mesh),
        cmocka_unit_test(pencils_find_what_rays_find),
        cmocka_unit_test(mirrors_in_mirrors_end_in_the_sky),
        cmocka_unit_test(rooms_without_a_sky_end_in_their_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
