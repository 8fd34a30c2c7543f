/* Surfaces with alpha: what opacity classes of triangles and cells of masks say is what their textures say, and rays
 * are told of every hit. */
#include "fixtures.h"

#include "daft.h"
#include "render/render.h"
#include "scene/scene.h"

#include <math.h>

/* Patches of nothing, so many of eight, of all, and of noise: the last of them. */
static daft_texture_data patches(int width, int height, int across, int down, uint32_t empty)
{
    const daft_allocator allocator = daft_malloc_allocator();
    daft_texture_data out;
    uint8_t *rgba = calloc(4 * (size_t)width, (size_t)height);
    const uint32_t salt = random_bits();
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const uint32_t place = (uint32_t)(x / across) * 7919u + (uint32_t)(y / down) * 104729u,
                           patch = (place + salt) * 2654435761u >> 29;
            rgba[4 * (y * width + x) + 3] = patch < empty ? 0 : patch < 7 ? 255 : (uint8_t)random_bits();
        }
    assert_true(daft_texture_build(&allocator, rgba, width, height, &out, NULL));
    free(rgba);
    return out;
}

static daft_texture_data random_texture(int width, int height) { return patches(width, height, 9, 7, 3); }

/* Patches about a fifth of the picture wide. */
static daft_texture_data patchy_texture(int width, int height)
{
    return patches(width, height, (width + 4) / 5, (height + 3) / 4, 4);
}

/* What many places of each triangle say never differs from its class; and most that could have one do. */
static void classes_are_right(void **unused)
{
    (void)unused;
    enum { TRIANGLES = 400, PLACES = 60 };
    int count[3] = {0, 0, 0}, alike = 0;
    fixture_seed(92);
    daft_allocator allocator = daft_malloc_allocator();
    for (int round = 0; round < 24; round++) {
        fixture_mesh m = mesh_soup(TRIANGLES, 1, 0.2f);
        daft_texture_data t = random_texture(1 + (int)(random_bits() % 150), 1 + (int)(random_bits() % 150));
        daft_surface surface = {.texture = 0,
                                .traits = DAFT_TRAIT_BLEND,
                                .wrap = (uint32_t)round % 3,
                                .map_scale = {random_float(-2, 2), random_float(-2, 2)},
                                .map_offset = {random_float(-3, 3), random_float(-3, 3)},
                                .opacity = round % 4 ? 1 : random_float(0.4f, 1),
                                .cutoff = round % 2 ? 0.5f : 0,
                                .alpha_channel = 3};
        uint8_t classes[TRIANGLES];
        daft_vec2 *uvs = malloc(3 * TRIANGLES * sizeof *uvs);
        for (uint32_t i = 0; i < 3 * TRIANGLES; i++) {
            const float reach = i / 3 % 2 ? 0.06f : 0.5f;
            if (i % 3 == 0) uvs[i] = (daft_vec2){random_float(-2, 2), random_float(-2, 2)};
            if (i % 3)
                uvs[i] = (daft_vec2){uvs[i - i % 3].x + random_float(-reach, reach),
                                     uvs[i - i % 3].y + random_float(-reach, reach)};
        }
        float *alphas = malloc(3 * TRIANGLES * sizeof *alphas);
        for (uint32_t i = 0; i < 3 * TRIANGLES; i++) {
            const uint32_t kind = random_bits() % 8; /* 0 and 1 are often those of all three corners */
            alphas[i] = kind == 7 ? random_float(0, 1) : i % 3 ? alphas[i - 1] : (float)(kind > 1);
        }
        m.mesh.uvs = uvs, m.mesh.uv_count = 3 * TRIANGLES;
        m.mesh.alphas = round % 3 == 0 ? alphas : NULL;
        assert_true(daft_opacity_classify(&allocator, &m.mesh, &surface, FIXTURE_MATERIAL, &t, classes));
        for (uint32_t i = 0; i < m.mesh.triangle_count; i++) {
            int full = 0, none = 0;
            for (int k = 0; k < PLACES; k++) {
                float a = random_float(0, 1), b = random_float(0, 1);
                if (a + b > 1) a = 1 - a, b = 1 - b;
                if (k < 3) a = k == 1, b = k == 2;
                const daft_vec2 *c = &uvs[3 * i], at = {c[0].x * (1 - a - b) + c[1].x * a + c[2].x * b,
                                                        c[0].y * (1 - a - b) + c[1].y * a + c[2].y * b};
                const float *f = &alphas[3 * i], own = m.mesh.alphas ? f[0] + (f[1] - f[0]) * a + (f[2] - f[0]) * b : 1;
                const float opacity = daft_surface_opacity(&surface, &t, at, own, DAFT_TEXTURE_TRILINEAR);
                full += opacity == 1, none += opacity == 0;
            }
            if (classes[i] == DAFT_OPACITY_OPAQUE) assert_int_equal(full, PLACES);
            if (classes[i] == DAFT_OPACITY_CLEAR) assert_int_equal(none, PLACES);
            count[classes[i]]++, alike += full == PLACES || none == PLACES;
        }
        m.mesh.uvs = NULL, m.mesh.uv_count = 0, m.mesh.alphas = NULL;
        free(uvs), free(alphas);
        daft_texture_free(&allocator, &t);
        mesh_drop(&m);
    }
    print_message("mixed %d, opaque %d, clear %d; alike %d\n", count[0], count[1], count[2], alike);
    assert_true(count[1] > 200 && count[2] > 200 && count[1] + count[2] > alike / 2);
}

/* A ray reads what is drawn: bit for bit what the kernels find where a pixel is smaller than a texel. */
static void rays_read_what_is_drawn(void **unused)
{
    (void)unused;
    fixture_seed(95);
    daft_allocator allocator = daft_malloc_allocator();
    daft_batch *b = calloc(1, sizeof *b);
    b->varying = calloc(1, sizeof *b->varying);
    for (int round = 0; round < 60; round++) {
        daft_texture_data t = random_texture(1 + (int)(random_bits() % 40), 1 + (int)(random_bits() % 40));
        daft_surface surface = {.texture = DAFT_NO_TEXTURE,
                                .traits = DAFT_TRAIT_BLEND | DAFT_TRAIT_VARIES | DAFT_TRAIT_MAPS | DAFT_TRAIT_SENDS,
                                .wrap = (uint32_t)round % 3,
                                .map_scale = {random_float(-2, 2), random_float(-2, 2)},
                                .map_offset = {random_float(-3, 3), random_float(-3, 3)},
                                .opacity = round % 4 ? 1 : random_float(0.4f, 1),
                                .cutoff = round % 2 ? 0.5f : 0,
                                .alpha_channel = round % 5 ? 3 : (uint32_t)round / 5 % 3};
        const daft_texture_filter filter = round % 7 ? DAFT_TEXTURE_TRILINEAR : DAFT_TEXTURE_NEAREST;
        static float own[DAFT_BATCH_ROOM];
        const bool fades = round % 3 == 1;
        for (int i = 0; i < DAFT_MAPS; i++) surface.maps[i] = i == DAFT_MAP_ALPHA ? 0 : DAFT_NO_TEXTURE;
        b->count = 500, b->traits = daft_surface_traits(&surface) | (fades ? DAFT_TRAIT_FADES : 0);
        for (uint32_t i = 0; i < b->count; i++) own[i] = fades ? random_float(0, 1) : 1;
        for (uint32_t i = 0; i < b->count; i++)
            b->u[i] = random_float(-4, 4), b->v[i] = random_float(-4, 4), b->footprint[i] = 1e-6f;
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            const daft_vary_def def = {.lets_through = true};
            memcpy(b->varying->opacity, own, sizeof own);
            daft_shade_kernels_for(isa)->vary(b, &surface, &t, filter, &def);
            for (uint32_t i = 0; i < b->count; i++) {
                const float one = daft_surface_opacity(&surface, &t, (daft_vec2){b->u[i], b->v[i]}, own[i], filter);
                if (one != b->varying->opacity[i])
                    fail_msg("%a at %a, %a; drawn is %a", (double)one, (double)b->u[i], (double)b->v[i],
                             (double)b->varying->opacity[i]);
            }
        }
        daft_texture_free(&allocator, &t);
    }
    free(b->varying);
    free(b);
}

static float wrapped_place(float a, uint32_t wrap)
{
    if (wrap == DAFT_WRAP_CLAMP) return fminf(fmaxf(a, 0), 1);
    const float cycle = wrap == DAFT_WRAP_MIRROR ? 2 : 1, within = a - floorf(a / cycle) * cycle;
    return within > 1 ? 2 - within : within;
}

static uint32_t cell_at(const daft_mask *m, daft_vec2 uv)
{
    const float u = wrapped_place(uv.x * m->scale_u + m->offset_u, m->wrap),
                v = wrapped_place(1 - (uv.y * m->scale_v + m->offset_v), m->wrap);
    const int column = daft_min_i((int)(u * m->across), m->columns - 1),
              row = daft_min_i((int)(v * m->down), m->rows - 1);
    const uint32_t at = (uint32_t)(row * m->columns + column);
    return m->cells[at / DAFT_MASK_CELLS] >> DAFT_MASK_BITS * (at % DAFT_MASK_CELLS) & ((1 << DAFT_MASK_BITS) - 1);
}

/* What a cell says of its places is what the texture says there, and within the slack of them; where it says a hole,
 * pixels find nothing that are as large. */
static void masks_are_right(void **unused)
{
    (void)unused;
    enum { PLACES = 1000 };
    int opaque = 0, clear = 0, mixed = 0, holes[DAFT_MASK_HOLES + 1] = {0};
    fixture_seed(96);
    daft_allocator allocator = daft_malloc_allocator();
    daft_batch *b = calloc(1, sizeof *b);
    b->varying = calloc(1, sizeof *b->varying);
    for (int round = 0; round < 90; round++) {
        fixture_mesh m = mesh_soup(4, 1, 0.2f);
        const int width = round % 2 ? 64 << round % 4 : 1 + (int)(random_bits() % 700),
                  height = round % 2 ? 128 : 1 + (int)(random_bits() % 700);
        daft_texture_data t = round % 5 ? patchy_texture(width, height) : random_texture(width, height);
        daft_surface surface = {.texture = DAFT_NO_TEXTURE,
                                .traits = DAFT_TRAIT_BLEND | DAFT_TRAIT_VARIES | DAFT_TRAIT_MAPS | DAFT_TRAIT_SENDS,
                                .wrap = (uint32_t)round % 3,
                                .map_scale = {random_float(-2, 2), random_float(-2, 2)},
                                .map_offset = {random_float(-3, 3), random_float(-3, 3)},
                                .opacity = round % 4 ? 1 : random_float(0.4f, 1),
                                .cutoff = round % 2 ? 0.5f : 0,
                                .alpha_channel = 3};
        for (int i = 0; i < DAFT_MAPS; i++) surface.maps[i] = i == DAFT_MAP_ALPHA ? 0 : DAFT_NO_TEXTURE;
        surface.steepness = daft_mask_steepness(&surface, &t);
        daft_mask mask;
        assert_true(daft_masks_make(&allocator, &m.mesh, &surface, FIXTURE_MATERIAL, &t, &mask) && mask.cells);
        assert_true(daft_masks_bytes(&mask, 1) <= sizeof mask + 65536 / 2 + 4);
        const float size = sqrtf((float)width * (float)height * fabsf(mask.scale_u * mask.scale_v));
        b->count = PLACES, b->traits = daft_surface_traits(&surface);
        for (uint32_t i = 0; i < PLACES; i++) {
            const daft_vec2 at = {random_float(-2, 2), random_float(-2, 2)};
            const uint32_t cell = cell_at(&mask, at), hole = cell > DAFT_OPACITY_CLEAR ? cell - DAFT_OPACITY_CLEAR : 0;
            const float near = 0.9f;
            daft_vec2 other = {at.x + random_float(-near, near) * mask.slack_u / mask.scale_u,
                               at.y + random_float(-near, near) * mask.slack_v / mask.scale_v};
            if (i % 2) other = at;
            const float found = daft_surface_opacity(&surface, &t, other, 1, DAFT_TEXTURE_TRILINEAR);
            if (cell == DAFT_OPACITY_OPAQUE && found != 1) fail_msg("round %d: %g is opaque", round, (double)found);
            if (cell >= DAFT_OPACITY_CLEAR && found != 0) fail_msg("round %d: %g is clear", round, (double)found);
            opaque += cell == DAFT_OPACITY_OPAQUE, clear += cell >= DAFT_OPACITY_CLEAR, mixed += cell == 0,
                holes[hole]++;
            b->u[i] = other.x, b->v[i] = other.y, b->weight.x[i] = b->weight.y[i] = b->weight.z[i] = 1;
            b->footprint[i] = (hole ? exp2f((float)hole + 0.24f) : 0.01f) * random_float(0.6f, 1) / size;
        }
        for (int soft = 0; soft < 2; soft++) {
            const daft_vary_def def = {.lets_through = true, .sample_side = (float)soft};
            daft_shade_kernels_for(daft_isa_best())->vary(b, &surface, &t, DAFT_TEXTURE_TRILINEAR, &def);
            for (uint32_t i = 0; i < PLACES; i++)
                if (cell_at(&mask, (daft_vec2){b->u[i], b->v[i]}) > DAFT_OPACITY_CLEAR && b->footprint[i] * size > 1)
                    if (b->varying->opacity[i] != 0) {
                        /* the place itself may be in a cell beside the hole's */
                        const uint32_t own = cell_at(&mask, (daft_vec2){b->u[i], b->v[i]}) - DAFT_OPACITY_CLEAR;
                        if (b->footprint[i] * size <= exp2f((float)own + 0.24f))
                            fail_msg("round %d: %g in a hole", round, (double)b->varying->opacity[i]);
                    }
        }
        daft_masks_free(&allocator, &mask, 1);
        daft_texture_free(&allocator, &t);
        mesh_drop(&m);
    }
    print_message("opaque %d, clear %d, mixed %d; holes", opaque, clear, mixed);
    for (int k = 0; k <= DAFT_MASK_HOLES; k++) print_message(" %d", holes[k]);
    print_message("\n");
    assert_true(opaque > 15000 && clear > 15000 && mixed < 45000 && holes[1] > 100 && holes[3] > 100 && holes[5] > 100);
    free(b->varying);
    free(b);
}

/* ---- every hit of a ray ---- */

typedef struct found {
    uint32_t count;
    daft_pierced hit[512];
} found;

static bool note(void *user, const daft_pierced *hit)
{
    found *f = user;
    assert_true(f->count < DAFT_COUNT_OF(f->hit));
    f->hit[f->count++] = *hit;
    return true;
}

/* Triangle by triangle, each alone in a tree, by the nearest hit. */
static void all_hits_are_found(void **unused)
{
    (void)unused;
    enum { TRIANGLES = 120 };
    fixture_seed(93);
    int hits = 0;
    daft_allocator allocator = daft_malloc_allocator();
    for (int round = 0; round < 12; round++) {
        fixture_mesh m = mesh_soup(TRIANGLES, 1, 0.8f), one[TRIANGLES];
        daft_affine place = affine_make(random_rotation(), daft_v3(1, 2, 1), random_vec3(-1, 1));
        daft_instance all[2] = {instance_make(&m, place), sphere_make(random_vec3(-1, 1), 0.7f)};
        daft_arena arena;
        daft_arena_init(&arena, &allocator);
        const uint32_t flag = round % 3 < 2 ? DAFT_INSTANCE_FILTERS_SHADOW : DAFT_INSTANCE_TRANSMITS,
                       ignore = round % 4 == 3 ? 1 : UINT32_MAX;
        const bool ball = round % 2 && ignore == UINT32_MAX,
                   clear = round % 3 != 1 && flag == DAFT_INSTANCE_FILTERS_SHADOW;
        all[0].flags = flag | DAFT_INSTANCE_CASTS_SHADOW, all[1].flags = round % 2 ? flag : DAFT_INSTANCE_CASTS_SHADOW;
        const daft_tlas *tlas = daft_tlas_build(&arena, all, 2, NULL), *single[TRIANGLES];
        uint8_t classes[TRIANGLES];
        for (uint32_t i = 0; i < m.mesh.triangle_count; i++) {
            daft_vec3 p[3];
            const uint32_t index[3] = {0, 1, 2};
            for (int k = 0; k < 3; k++) {
                const uint32_t v = m.mesh.indices[3 * i + (uint32_t)k];
                p[k] = daft_v3(m.mesh.x[v], m.mesh.y[v], m.mesh.z[v]);
            }
            one[i] = mesh_make(p, 3, index, 1);
            daft_instance *alone = daft_arena_alloc(&arena, 1, sizeof *alone);
            *alone = instance_make(&one[i], place);
            single[i] = daft_tlas_build(&arena, alone, 1, NULL);
            classes[i] = random_bits() % 4 ? DAFT_OPACITY_MIXED : DAFT_OPACITY_CLEAR;
        }
        if (round % 3 != 1) all[0].opacity = classes;
        for (int n = 0; n < 200; n++) {
            const daft_ray ray = {
                .origin = random_vec3(-3, 3), .direction = random_vec3(-1, 1), .tmax = n % 2 ? INFINITY : 2};
            found first;
            for (int isa = 0; isa <= daft_isa_best(); isa++) {
                const daft_accel_kernels *k = daft_accel_kernels_for(isa);
                found f = {0};
                uint32_t spheres = 0;
                daft_pierced_leaf last;
                k->pierce(tlas, &ray, flag, ignore, note, &f, &last);
                if (isa == 0) first = f;
                assert_int_equal(first.count, f.count);
                assert_memory_equal(first.hit, f.hit, f.count * sizeof f.hit[0]);
                for (uint32_t i = 0; i < f.count; i++) spheres += f.hit[i].instance == 1;
                assert_true(spheres <= (ball ? 2u : 0u));
                uint32_t expected = spheres;
                for (uint32_t i = 0; i < m.mesh.triangle_count; i++) {
                    daft_hit hit;
                    if (clear && classes[i] == DAFT_OPACITY_CLEAR) continue;
                    if (!k->closest(single[i], &ray, UINT32_MAX, &hit)) continue;
                    uint32_t at = 0;
                    while (at < f.count && !(f.hit[at].instance == 0 && f.hit[at].triangle == i)) at++;
                    assert_true(at < f.count && f.hit[at].t == hit.t && f.hit[at].u == hit.u && f.hit[at].v == hit.v);
                    expected++;
                }
                assert_int_equal(expected, f.count);
            }
            hits += (int)first.count;
        }
        for (uint32_t i = 0; i < m.mesh.triangle_count; i++) mesh_drop(&one[i]);
        daft_arena_free(&arena);
        mesh_drop(&m);
    }
    print_message("%d hits\n", hits);
    assert_true(hits > 400);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(classes_are_right),
        cmocka_unit_test(masks_are_right),
        cmocka_unit_test(rays_read_what_is_drawn),
        cmocka_unit_test(all_hits_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
