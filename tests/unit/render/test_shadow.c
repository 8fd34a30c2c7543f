/* The shadow pencil against single rays: for points anywhere, suns, lights far off, close by, inside the scene and
 * among the points, meshes, spheres and mirrored instances, both say the same but for points on a shadow's very edge;
 * and every instruction set says exactly the same. */
#include "fixtures.h"

#include "render/tile/tile.h"

enum { MANY = 300 };

typedef struct stage {
    daft_instance instances[MANY];
    uint32_t count;
    fixture_mesh soup, ball;
    daft_arena arena;
    daft_allocator allocator;
    const daft_tlas *tlas;
} stage;

/* `size`: of the instances, which are strewn about. */
static void stage_make_of(stage *s, uint32_t count, float size)
{
    s->soup = mesh_soup(700, 2, 0.35f);
    s->ball = mesh_ball(24, 1, 0.1f);
    s->count = count;
    for (uint32_t i = 0; i < count; i++) {
        daft_vec3 scale = i % 4 == 3 ? daft_v3(size, -0.6f * size, 1.3f * size) : daft_v3(size, size, size),
                  at = random_vec3(-5, 5);
        s->instances[i] = i % 4 == 0
                              ? sphere_make(at, random_float(0.2f, 1) * size)
                              : instance_make(i % 2 ? &s->soup : &s->ball, affine_make(random_rotation(), scale, at));
    }
    s->instances[7].flags = 0; /* casts none */
    s->allocator = daft_malloc_allocator();
    daft_arena_init(&s->arena, &s->allocator);
    s->tlas = daft_tlas_build(&s->arena, s->instances, s->count, NULL);
    assert_non_null(s->tlas);
}

static void stage_make(stage *s) { stage_make_of(s, 8, 1); }

static void stage_drop(stage *s)
{
    daft_arena_free(&s->arena);
    mesh_drop(&s->soup);
    mesh_drop(&s->ball);
}

/* Points of a patch, as a tile would see one: on a slanted plane of the given size around a place. */
static void fill_points(daft_batch *b, daft_vec3 place, float size)
{
    daft_vec3 u = daft_scale(random_vec3(-1, 1), size), v = daft_scale(random_vec3(-1, 1), size);
    b->count = 700 + random_bits() % 300;
    for (uint32_t i = 0; i < b->count; i++) {
        daft_vec3 p = daft_add(place, daft_add(daft_scale(u, random_float(-1, 1)), daft_scale(v, random_float(-1, 1))));
        b->shadow_origin.x[i] = p.x, b->shadow_origin.y[i] = p.y, b->shadow_origin.z[i] = p.z;
        b->instance[i] = UINT32_MAX;
    }
}

static bool lit_by_ray(const stage *s, const daft_batch *b, const daft_light_source *source, uint32_t i)
{
    daft_ray ray = {.origin = {b->shadow_origin.x[i], b->shadow_origin.y[i], b->shadow_origin.z[i]},
                    .direction = source->to_light,
                    .tmax = INFINITY};
    if (!source->sun) ray.direction = daft_sub(source->position, ray.origin), ray.tmax = 1;
    if (source->area) assert_true(daft_tile_sharp_ray(b, i, source, &ray));
    return !daft_accel_kernels_for(0)->occluded(s->tlas, &ray);
}

static uint32_t cast(int isa, const daft_batch *b, const daft_light_source *source, const daft_tlas *tlas,
                     uint32_t instance, uint32_t *bits)
{
    const daft_sample_kernels *k = daft_sample_kernels_for(isa);
    const daft_samples samples = daft_samples_of(b);
    const daft_apex apex = daft_apex_of(source);
    void *scratch = aligned_alloc(64, k->scratch_size);
    memset(scratch, 0xa5, k->scratch_size); /* nothing of it is kept */
    uint32_t kept = k->shadows(&samples, &apex, tlas, instance, bits, scratch);
    free(scratch);
    return kept;
}

static uint32_t cast_tints(int isa, const daft_batch *b, const daft_light_source *source, const daft_tlas *tlas,
                           const uint32_t *bits, uint32_t *out)
{
    const daft_sample_kernels *k = daft_sample_kernels_for(isa);
    const daft_samples samples = daft_samples_of(b);
    const daft_apex apex = daft_apex_of(source);
    void *scratch = aligned_alloc(64, k->scratch_size);
    uint32_t count = k->tints(&samples, &apex, tlas, bits, out, scratch);
    free(scratch);
    return count;
}

typedef struct tally {
    int lit, dark, edge, pencils;
    uint32_t asked; /* of the last: points whose rays were tested */
} tally;

/* Points that see the middle of an area are asked for. */
static void skip_middle(const daft_batch *b, const daft_light_source *source, uint32_t *asked)
{
    static const daft_render_kernels *const kernels[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_render);
    uint32_t aside[DAFT_BATCH_WORDS], left[DAFT_BATCH_WORDS], all[DAFT_BATCH_WORDS];
    memcpy(all, asked, sizeof all);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        memcpy(left, all, sizeof left);
        kernels[isa]->skip_middle(b, source, left, aside);
        if (isa) assert_memory_equal(left, asked, sizeof left);
        memcpy(asked, left, sizeof left);
        for (uint32_t k = 0; k < DAFT_BATCH_WORDS; k++) assert_true((left[k] ^ aside[k]) == all[k]);
    }
}

static void compare(const stage *s, const daft_batch *b, const daft_light_source *source, tally *sum)
{
    uint32_t asked[DAFT_BATCH_WORDS] = {0}, bits[DAFT_ISA_COUNT][DAFT_BATCH_WORDS], kept = 0;
    for (uint32_t i = 0; i < b->count; i++)
        if (i % 7) asked[i / 32] |= (uint32_t)1 << (i % 32);
    if (source->area) skip_middle(b, source, asked);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        memcpy(bits[isa], asked, sizeof asked);
        uint32_t under = cast(isa, b, source, s->tlas, DAFT_NOTHING, bits[isa]);
        if (isa) assert_int_equal(under, kept);
        kept = under;
        assert_memory_equal(bits[isa], bits[0], sizeof asked);
    }
    sum->pencils++, sum->asked = kept;
    for (uint32_t i = 0; i < b->count; i++) {
        bool was = asked[i / 32] >> (i % 32) & 1, lit = bits[0][i / 32] >> (i % 32) & 1;
        if (!was) assert_false(lit);
        if (!was) continue;
        if (lit != lit_by_ray(s, b, source, i)) sum->edge++;
        if (lit)
            sum->lit++;
        else
            sum->dark++;
    }
}

/* Few points differ from their ray, all at edges. */
static void check(const tally *sum)
{
    print_message("%d pencils: %d lit, %d dark, %d at an edge\n", sum->pencils, sum->lit, sum->dark, sum->edge);
    assert_true(sum->pencils > 10 && sum->lit > 1000 && sum->dark > 1000);
    assert_true(sum->edge * 2000 < sum->lit + sum->dark);
}

static void run_with(uint32_t count, float size, bool sun, float light_distance, float patch)
{
    daft_batch *b = calloc(1, sizeof *b);
    tally sum = {0};
    for (int round = 0; round < 25; round++) {
        stage s;
        stage_make_of(&s, count, size);
        for (int i = 0; i < 4; i++) {
            fill_points(b, random_vec3(-5, 5), patch);
            daft_light_source source = {.sun = sun, .casts_shadow = true};
            source.to_light = daft_normalize(random_vec3(-1, 1));
            source.position = daft_scale(random_vec3(-1, 1), light_distance);
            compare(&s, b, &source, &sum);
        }
        stage_drop(&s);
    }
    check(&sum);
    free(b);
}

static void run(bool sun, float light_distance, float patch) { run_with(8, 1, sun, light_distance, patch); }

/* Rays to areas end before them: at a sphere, just before a rectangle, at the bounds of what glows, in which other
 * things may lie. */
static void run_areas(daft_area area, bool bounded, uint32_t count, float size, float light_distance, float patch)
{
    daft_batch *b = calloc(1, sizeof *b);
    tally sum = {0};
    for (int round = 0; round < 25; round++) {
        stage s;
        stage_make_of(&s, count, size);
        for (int i = 0; i < 4; i++) {
            fill_points(b, random_vec3(-5, 5), patch);
            daft_light_source source = {
                .area = area, .casts_shadow = true, .bounded = bounded, .radius = random_float(0.1f, 2)};
            const daft_affine turn = affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(0, 0, 0));
            source.to_light = daft_normalize(random_vec3(-1, 1));
            source.position = daft_scale(random_vec3(-1, 1), light_distance);
            source.bounds.middle = daft_add(source.position, random_vec3(-0.1f, 0.1f));
            for (int k = 0; k < 3; k++)
                source.bounds.axes[k] =
                    daft_scale(daft_affine_vector(&turn, daft_v3(k == 0, k == 1, k == 2)), 1 / random_float(0.2f, 2));
            daft_axes_across(source.to_light, &source.edges[0], &source.edges[1]);
            for (uint32_t k = 0; k < b->count; k++) {
                const daft_vec3 n = daft_normalize(random_vec3(-1, 1));
                b->normal.x[k] = n.x, b->normal.y[k] = n.y, b->normal.z[k] = n.z;
            }
            compare(&s, b, &source, &sum);
        }
        stage_drop(&s);
    }
    check(&sum);
    free(b);
}

static void areas_of_any_kind(void **unused)
{
    (void)unused;
    fixture_seed(75);
    for (int bounded = 0; bounded < 2; bounded++)
        for (int ball = 0; ball < 2; ball++) {
            const daft_area area = ball ? DAFT_AREA_SPHERE : DAFT_AREA_RECTANGLE;
            run_areas(area, bounded, 8, 1, 4, 1), run_areas(area, bounded, 8, 1, 3, 4);
            run_areas(area, bounded, MANY, 0.3f, 6, 1), run_areas(area, bounded, MANY, 0.3f, 3, 4);
        }
}

static void suns(void **unused) { (void)unused, fixture_seed(61), run(true, 0, 1); }
static void large_patches(void **unused) { (void)unused, fixture_seed(62), run(true, 0, 8); }
static void far_lights(void **unused) { (void)unused, fixture_seed(63), run(false, 1000, 1); }
static void lights_beyond_the_hills(void **unused) { (void)unused, fixture_seed(66), run(false, 1e5f, 1); }
static void lights_in_the_scene(void **unused) { (void)unused, fixture_seed(64), run(false, 4, 1); }
static void lights_among_the_points(void **unused) { (void)unused, fixture_seed(65), run(false, 3, 4); }

static void suns_over_many(void **unused) { (void)unused, fixture_seed(71), run_with(MANY, 0.3f, true, 0, 1); }
static void lights_over_many(void **unused) { (void)unused, fixture_seed(72), run_with(MANY, 0.3f, false, 30, 1); }
static void lights_far_from_many(void **unused)
{
    (void)unused, fixture_seed(73), run_with(MANY, 0.2f, false, 1e5f, 3);
}
static void lights_among_many(void **unused) { (void)unused, fixture_seed(74), run_with(MANY, 0.2f, false, 3, 4); }

/* Points a little above or below triangles that are neighbours, their lights at any angle over these, grazing ones,
 * too: most of what is close to them does not hide them. */
static void fill_on_surface(const daft_instance *s, daft_batch *b, uint32_t first)
{
    b->count = 700 + random_bits() % 300;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t *corner = &s->mesh->indices[3 * ((first + random_bits() % 60) % s->mesh->triangle_count)];
        daft_vec3 p[3];
        for (int k = 0; k < 3; k++)
            p[k] = daft_affine_point(&s->to_frame,
                                     daft_v3(s->mesh->x[corner[k]], s->mesh->y[corner[k]], s->mesh->z[corner[k]]));
        daft_vec3 e = daft_sub(p[1], p[0]), f = daft_sub(p[2], p[0]), up = daft_normalize(daft_cross(e, f));
        float v = random_float(0, 1), w = random_float(0, 1 - v),
              over = random_float(1e-5f, 1e-3f) * (i % 5 ? 1.0f : -1.0f);
        daft_vec3 at = daft_add(daft_add(p[0], daft_add(daft_scale(e, v), daft_scale(f, w))), daft_scale(up, over));
        b->shadow_origin.x[i] = at.x, b->shadow_origin.y[i] = at.y, b->shadow_origin.z[i] = at.z;
        b->instance[i] = UINT32_MAX;
    }
}

static void points_on_surfaces(void **unused)
{
    (void)unused;
    fixture_seed(76);
    daft_batch *b = calloc(1, sizeof *b);
    tally sum = {0};
    for (int round = 0; round < 40; round++) {
        stage s;
        stage_make(&s);
        for (uint32_t i = 1; i < s.count; i += i % 4 == 3 ? 2 : 1) { /* all but the spheres */
            fill_on_surface(&s.instances[i], b, random_bits() % s.instances[i].mesh->triangle_count);
            daft_vec3 at = {b->shadow_origin.x[0], b->shadow_origin.y[0], b->shadow_origin.z[0]};
            daft_light_source source = {
                .sun = i % 2, .casts_shadow = true, .to_light = daft_normalize(random_vec3(-1, 1))};
            source.position = daft_add(at, daft_scale(random_vec3(-1, 1), random_float(0.1f, 6)));
            compare(&s, b, &source, &sum);
        }
        stage_drop(&s);
    }
    check(&sum);
    free(b);
}

/* Of points in the open beside many instances, none is asked for, though they share a tile with points behind the
 * instances.
 */
static void beside_many(void **unused)
{
    (void)unused;
    fixture_seed(75);
    daft_batch *b = calloc(1, sizeof *b);
    int dark = 0;
    for (int round = 0; round < 20; round++) {
        stage s;
        stage_make_of(&s, MANY, 0.3f); /* between -6 and 6 on each axis */
        b->count = 1000;
        for (uint32_t i = 0; i < b->count; i++) {
            daft_vec3 p = i < 500 ? daft_v3(random_float(-4, 4), -9, random_float(-4, 4))
                                  : daft_v3(random_float(10, 14), -9, random_float(-4, 4));
            b->shadow_origin.x[i] = p.x, b->shadow_origin.y[i] = p.y, b->shadow_origin.z[i] = p.z;
            b->instance[i] = UINT32_MAX, b->pixel[i] = i;
        }
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            uint32_t bits[DAFT_BATCH_WORDS] = {0}, lit = 0;
            daft_light_source source = {.sun = true, .casts_shadow = true, .to_light = {0, 1, 0}};
            for (uint32_t i = 0; i < b->count; i++) bits[i / 32] |= (uint32_t)1 << (i % 32);
            uint32_t kept = cast(isa, b, &source, s.tlas, DAFT_NOTHING, bits);
            for (int word = 0; word < DAFT_BATCH_WORDS; word++) lit += (uint32_t)__builtin_popcount(bits[word]);
            assert_true(kept <= 500 && kept >= 1000 - lit);
            for (uint32_t i = 500; i < 1000; i++) assert_true(bits[i / 32] >> (i % 32) & 1);
            dark += (int)(1000 - lit);
        }
        stage_drop(&s);
    }
    assert_true(dark > 1000);
    free(b);
}

/* Instance by instance, as tinted shadows ask, takes away what all together do; and who tints is found. */
static void one_at_a_time(void **unused)
{
    (void)unused;
    fixture_seed(67);
    daft_batch *b = calloc(1, sizeof *b);
    int dark = 0, found = 0;
    for (int round = 0; round < 20; round++) {
        stage s;
        stage_make(&s);
        fill_points(b, random_vec3(-5, 5), 2);
        daft_light_source source = {
            .sun = round % 2, .casts_shadow = true, .to_light = daft_normalize(random_vec3(-1, 1))};
        source.position = daft_scale(random_vec3(-1, 1), 9);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            uint32_t all[DAFT_BATCH_WORDS] = {0}, each[DAFT_BATCH_WORDS], tints[DAFT_MAX_OCCLUDERS];
            for (uint32_t i = 0; i < b->count; i++) all[i / 32] |= (uint32_t)1 << (i % 32);
            memcpy(each, all, sizeof all);
            for (uint32_t i = 0; i < s.count; i++) {
                uint32_t alone[DAFT_BATCH_WORDS], gone = 0;
                if (!(s.instances[i].flags & DAFT_INSTANCE_CASTS_SHADOW)) continue;
                for (int word = 0; word < DAFT_BATCH_WORDS; word++) alone[word] = all[word];
                cast(isa, b, &source, s.tlas, i, alone);
                for (int word = 0; word < DAFT_BATCH_WORDS; word++)
                    gone |= all[word] & ~alone[word], each[word] &= alone[word];
                s.instances[i].flags = DAFT_INSTANCE_TINTS_SHADOW;
                uint32_t count = cast_tints(isa, b, &source, s.tlas, all, tints);
                assert_true(count <= 1 || count == UINT32_MAX);
                if (gone) assert_true(count == UINT32_MAX || (count == 1 && tints[0] == i));
                s.instances[i].flags = DAFT_INSTANCE_CASTS_SHADOW;
                found += gone != 0;
            }
            cast(isa, b, &source, s.tlas, DAFT_NOTHING, all);
            assert_memory_equal(all, each, sizeof all);
            for (uint32_t i = 0; i < b->count; i++) dark += !(all[i / 32] >> (i % 32) & 1);
        }
        stage_drop(&s);
    }
    assert_true(dark > 1000 && found > 20);
    free(b);
}

/* Points of a mesh of no thickness that face the light are asked for only under other instances; those that face away
 * are dark. */
static void flat_ground(void **unused)
{
    (void)unused;
    fixture_seed(68);
    const daft_vec3 corners[4] = {{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    fixture_mesh ground = mesh_make(corners, 4, indices, 2);
    daft_instance instance =
        instance_make(&ground, affine_make(random_rotation(), daft_v3(1, 1, 1), daft_v3(3, -2, 5)));
    daft_allocator allocator = daft_malloc_allocator();
    daft_arena arena;
    daft_arena_init(&arena, &allocator);
    const daft_tlas *tlas = daft_tlas_build(&arena, &instance, 1, NULL);
    daft_vec3 up = daft_affine_vector(&instance.to_frame, daft_v3(0, 1, 0));
    daft_batch *b = calloc(1, sizeof *b);
    b->count = 900;
    for (uint32_t i = 0; i < b->count; i++) {
        float x = random_float(-8, 8), z = random_float(-8, 8);
        daft_vec3 p = daft_add(daft_affine_point(&instance.to_frame, daft_v3(x, 0, z)), daft_scale(up, 1e-5f));
        b->shadow_origin.x[i] = p.x, b->shadow_origin.y[i] = p.y, b->shadow_origin.z[i] = p.z;
        b->outward.x[i] = up.x, b->outward.y[i] = up.y, b->outward.z[i] = up.z;
        b->triangle[i] = x > z ? 1 : 0; /* either: which one matters to nobody */
        b->pixel[i] = i;
    }
    for (int side = -1; side <= 1; side += 2)
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            uint32_t bits[DAFT_BATCH_WORDS] = {0}, lit = 0;
            daft_light_source source = {.casts_shadow = true,
                                        .position = daft_add(daft_v3(3, -2, 5), daft_scale(up, 4 * (float)side))};
            for (uint32_t i = 0; i < b->count; i++) bits[i / 32] |= (uint32_t)1 << (i % 32);
            assert_int_equal(cast(isa, b, &source, tlas, DAFT_NOTHING, bits), side > 0 ? 0 : 900);
            for (int word = 0; word < DAFT_BATCH_WORDS; word++) lit += (uint32_t)__builtin_popcount(bits[word]);
            assert_int_equal(lit, side > 0 ? 900 : 0);
        }
    free(b);
    daft_arena_free(&arena);
    mesh_drop(&ground);
}

/* Patches of a floor, from a small one to one as large as what stands over it: all lit beside it, all dark behind a
 * ball inside it, or across its outline. */
static void floors(void **unused)
{
    (void)unused;
    fixture_seed(77);
    const daft_vec3 corners[4] = {{-40, -3, -40}, {-40, -3, 40}, {40, -3, 40}, {40, -3, -40}};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    daft_batch *b = calloc(1, sizeof *b);
    tally sum = {0};
    int whole[2] = {0, 0};
    for (int round = 0; round < 24; round++) {
        stage s = {.count = 2, .allocator = daft_malloc_allocator(), .soup = mesh_make(corners, 4, indices, 2)};
        s.ball = round % 3 ? mesh_ball(round % 3 == 1 ? 24 : 60, 1, 0.1f) : mesh_soup(700, 2, 0.35f);
        s.instances[0] =
            instance_make(&s.ball, affine_make(random_rotation(), daft_v3(2, 2, random_float(1, 2)), daft_v3(0, 0, 0)));
        s.instances[1] = instance_make(&s.soup, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)));
        daft_arena_init(&s.arena, &s.allocator);
        s.tlas = daft_tlas_build(&s.arena, s.instances, s.count, NULL);
        assert_non_null(s.tlas);
        for (int i = 0; i < 20; i++) {
            const float size = random_float(0.02f, 1), x = random_float(-4, 4), z = random_float(-4, 4);
            b->count = 900;
            for (uint32_t k = 0; k < b->count; k++) {
                const daft_vec3 p = {x + random_float(-size, size), -3 + 1e-4f, z + random_float(-size, size)};
                b->shadow_origin.x[k] = p.x, b->shadow_origin.y[k] = p.y, b->shadow_origin.z[k] = p.z;
                b->outward.x[k] = b->outward.z[k] = 0, b->outward.y[k] = 1;
                b->instance[k] = 1, b->triangle[k] = p.x > p.z, b->pixel[k] = k;
            }
            daft_light_source source = {.sun = i % 2,
                                        .casts_shadow = true,
                                        .to_light = daft_normalize(daft_add(daft_v3(0, 2, 0), random_vec3(-1, 1)))};
            source.position = daft_add(daft_v3(0, 9, 0), random_vec3(-4, 4));
            tally one = {0};
            compare(&s, b, &source, &one);
            whole[0] += one.lit == 0, whole[1] += one.dark == 0;
            sum.lit += one.lit, sum.dark += one.dark, sum.edge += one.edge;
        }
        stage_drop(&s);
    }
    print_message("%d lit, %d dark, %d at an edge; %d patches dark, %d lit\n", sum.lit, sum.dark, sum.edge, whole[0],
                  whole[1]);
    assert_true(whole[0] > 20 && whole[1] > 20 && sum.edge * 2000 < sum.lit + sum.dark);
    free(b);
}

/* A box from -1 to 1 on each axis; its sides two by two, each of two triangles. */
static fixture_mesh box_make(void)
{
    daft_vec3 corners[24];
    uint32_t indices[36];
    for (uint32_t side = 0; side < 6; side++) {
        for (uint32_t k = 0; k < 4; k++) {
            float p[3];
            p[side / 2] = side % 2 ? -1 : 1, p[(side / 2 + 1) % 3] = k == 1 || k == 2 ? 1 : -1;
            p[(side / 2 + 2) % 3] = k >= 2 ? 1 : -1;
            corners[4 * side + k] = daft_v3(p[0], p[1], p[2]);
        }
        const uint32_t of_side[6] = {0, 1, 2, 0, 2, 3};
        for (uint32_t k = 0; k < 6; k++) indices[6 * side + k] = 4 * side + of_side[k];
    }
    return mesh_make(corners, 24, indices, 12);
}

/* A patch of a box's side, as a tile sees it. */
static void fill_on_box(const stage *s, uint32_t box, daft_batch *b)
{
    const daft_affine *map = &s->instances[box].to_frame;
    const uint32_t side = random_bits() % 6, axis = side / 2;
    const float size = random_float(0.01f, 0.4f), x = random_float(-0.9f, 0.9f), y = random_float(-0.9f, 0.9f);
    daft_vec3 up = daft_affine_vector(map, daft_v3(axis == 0, axis == 1, axis == 2));
    up = daft_scale(daft_normalize(up), side % 2 ? -1 : 1);
    b->count = 1024;
    for (uint32_t i = 0; i < b->count; i++) {
        const float u = fminf(fmaxf(x + size * ((float)(i % 32) / 16 - 1), -1), 1),
                    v = fminf(fmaxf(y + size * ((float)(i / 32) / 16 - 1), -1), 1);
        float p[3];
        p[axis] = side % 2 ? -1 : 1, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
        const daft_vec3 at = daft_add(daft_affine_point(map, daft_v3(p[0], p[1], p[2])), daft_scale(up, 1e-4f));
        b->shadow_origin.x[i] = at.x, b->shadow_origin.y[i] = at.y, b->shadow_origin.z[i] = at.z;
        b->outward.x[i] = up.x, b->outward.y[i] = up.y, b->outward.z[i] = up.z;
        b->normal.x[i] = up.x, b->normal.y[i] = up.y, b->normal.z[i] = up.z;
        b->instance[i] = box, b->triangle[i] = 2 * side + (v > u), b->pixel[i] = i;
    }
}

/* What shines from a sign's side, and its body, which lies in the bounds or comes out of them behind. */
static daft_light_source light_of_sign(const daft_affine *map, float deep)
{
    daft_light_source light = {.area = DAFT_AREA_RECTANGLE, .casts_shadow = true, .bounded = true};
    const daft_vec3 columns[3] = {daft_affine_vector(map, daft_v3(1, 0, 0)), daft_affine_vector(map, daft_v3(0, 1, 0)),
                                  daft_affine_vector(map, daft_v3(0, 0, 1))};
    light.position = daft_affine_point(map, daft_v3(0, 0, 1));
    light.to_light = daft_scale(daft_normalize(columns[2]), -1);
    light.edges[0] = daft_scale(columns[1], 2), light.edges[1] = daft_scale(columns[0], 2);
    light.bounds.middle = daft_affine_point(map, daft_v3(0, 0, 1 - deep / 2));
    for (int k = 0; k < 3; k++) {
        const float half = k == 2 ? deep / 2 + 0.01f : 1.01f;
        light.bounds.axes[k] = daft_scale(columns[k], 1 / (half * daft_dot(columns[k], columns[k])));
    }
    return light;
}

/* Houses around a square, and signs on them. Of walls that see all of a light no ray is tested, though they lie in
 * their house's bounds; others lie behind a wall as a whole, or across its edge. */
static void streets(void **unused)
{
    (void)unused;
    fixture_seed(78);
    const daft_vec3 corners[4] = {{-40, 0, -40}, {-40, 0, 40}, {40, 0, 40}, {40, 0, -40}};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    daft_batch *b = calloc(1, sizeof *b);
    tally sum = {0};
    int dark = 0, lit = 0, clear = 0;
    for (int round = 0; round < 24; round++) {
        stage s = {.count = 9, .allocator = daft_malloc_allocator(), .ball = box_make()};
        s.soup = mesh_make(corners, 4, indices, 2);
        s.instances[0] = instance_make(&s.soup, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)));
        for (uint32_t i = 1; i < s.count; i++) {
            const daft_vec3 scale = i == 1 ? daft_v3(0.6f, 0.3f, 0.1f)
                                           : daft_v3(random_float(1, 2), random_float(1, 3), random_float(1, 2)),
                            at = daft_v3(random_float(-9, 9), i == 1 ? 2 : scale.y, random_float(-9, 9));
            const daft_quat turn = i % 2 ? daft_quat_identity() : random_rotation();
            s.instances[i] = instance_make(&s.ball, affine_make(turn, scale, at));
        }
        daft_arena_init(&s.arena, &s.allocator);
        s.tlas = daft_tlas_build(&s.arena, s.instances, s.count, NULL);
        assert_non_null(s.tlas);
        for (int i = 0; i < 30; i++) {
            daft_light_source light = light_of_sign(&s.instances[1].to_frame, i % 6 ? 2 : 1);
            if (i % 3 == 1) light = (daft_light_source){.casts_shadow = true, .position = {0, random_float(1, 6), 0}};
            if (i % 3 == 2) light = (daft_light_source){.casts_shadow = true, .sun = true};
            if (light.sun) light.to_light = daft_normalize(daft_add(daft_v3(0, 1, 0), random_vec3(-1, 1)));
            fill_on_box(&s, 2 + random_bits() % (s.count - 2), b);
            tally one = {0};
            compare(&s, b, &light, &one);
            dark += one.lit == 0 && one.dark, lit += one.dark == 0 && one.lit;
            clear += one.dark == 0 && one.lit && one.asked == 0;
            sum.lit += one.lit, sum.dark += one.dark, sum.edge += one.edge;
        }
        stage_drop(&s);
    }
    print_message("%d lit, %d dark, %d at an edge; %d walls dark, %d lit, %d of them untested\n", sum.lit, sum.dark,
                  sum.edge, dark, lit, clear);
    assert_true(dark > 50 && lit > 50 && clear * 10 > lit * 9 && sum.edge * 2000 < sum.lit + sum.dark);
    free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(suns),
        cmocka_unit_test(large_patches),
        cmocka_unit_test(far_lights),
        cmocka_unit_test(lights_beyond_the_hills),
        cmocka_unit_test(lights_in_the_scene),
        cmocka_unit_test(lights_among_the_points),
        cmocka_unit_test(suns_over_many),
        cmocka_unit_test(lights_over_many),
        cmocka_unit_test(lights_far_from_many),
        cmocka_unit_test(lights_among_many),
        cmocka_unit_test(areas_of_any_kind),
        cmocka_unit_test(points_on_surfaces),
        cmocka_unit_test(beside_many),
        cmocka_unit_test(one_at_a_time),
        cmocka_unit_test(flat_ground),
        cmocka_unit_test(floors),
        cmocka_unit_test(streets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
