/* What is made of images: the sRGB curve, textures and their mip chains, and what several scenes share. */
#include "base/budget.h"
#include "image/color.h"
#include "image/image.h"
#include "noise_image.h"
#include "support_content.h"

static counting memory;

/* ---- colour ---- */

static void the_srgb_curve(void **unused)
{
    (void)unused;
    assert_true(daft_srgb_to_linear(0) == 0 && daft_srgb_to_linear(1) == 1 && daft_linear_to_srgb(1) == 1);
    assert_true(daft_linear_to_srgb(-1) == 0 && daft_linear_to_srgb(7) == 1 && daft_linear_to_srgb(NAN) == 0);
    assert_true(fabsf(daft_srgb_to_linear(0.5f) - 0.21404114f) < 1e-7f);
    assert_true(fabsf(daft_linear_to_srgb(0.5f) - 0.73535698f) < 1e-7f);
    daft_srgb_table table;
    daft_srgb_table_make(&table);
    for (int i = 0; i < 256; i++) {
        assert_true(fabsf(table.linear[i] - daft_srgb_to_linear((float)(i / 255.0))) < 1e-7f);
        assert_int_equal(daft_srgb_byte(&table, table.linear[i]), i);
        assert_true(fabsf(daft_linear_to_srgb(table.linear[i]) * 255 - (float)i) < 1e-4f);
    }
    for (int i = 0; i <= 1000000; i++) {
        float light = (float)i / 1000000;
        double exact = (double)daft_linear_to_srgb(light) * 255;
        int byte = daft_srgb_byte(&table, light);
        if (fabs(exact - byte) > 0.5001) fail_msg("%g: byte %d for %g", (double)light, byte, exact);
    }
    assert_int_equal(daft_srgb_byte(&table, NAN), 0);
    assert_int_equal(daft_srgb_byte(&table, INFINITY), 255);
}

/* ---- textures ---- */

static daft_texture_data build(const uint8_t *rgba, int width, int height)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_texture_data texture;
    daft_error error;
    if (!daft_texture_build(&allocator, rgba, width, height, &texture, &error)) fail_msg("%s", error.message);
    return texture;
}

static void free_texture(daft_texture_data *texture)
{
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    daft_texture_free(&allocator, texture);
    assert_int_equal(memory.live, 0);
}

static void levels_halve_down_to_one_texel(void **unused)
{
    (void)unused;
    static const int sizes[][3] = {{1, 1, 1}, {2, 1, 2},      {4, 4, 3},     {5, 3, 3},
                                   {1, 9, 4}, {640, 333, 10}, {16384, 1, 15}};
    static uint8_t rgba[4 * 640 * 333];
    for (size_t i = 0; i < DAFT_COUNT_OF(sizes); i++) {
        daft_texture_data texture = build(rgba, sizes[i][0], sizes[i][1]);
        assert_int_equal(texture.levels, sizes[i][2]);
        for (int level = 1; level < texture.levels; level++) {
            assert_int_equal(texture.width[level], daft_max_i(1, texture.width[level - 1] / 2));
            assert_int_equal(texture.height[level], daft_max_i(1, texture.height[level - 1] / 2));
        }
        assert_true(texture.width[texture.levels - 1] == 1 && texture.height[texture.levels - 1] == 1 &&
                    !texture.missing);
        free_texture(&texture);
    }
}

/* The fraction of source texel `s` in target texel `t`, along one axis, by overlap of intervals. */
static double overlap(int t, int target, int s, int source)
{
    double low = fmax((double)t * source / target, s), high = fmin((t + 1.0) * source / target, s + 1.0);
    return high > low ? (high - low) * target / source : 0;
}

/* Level 1 against the plain definition: the mean of the light over each texel's area, in double, rounded once. */
static void filtering_is_in_linear_light(void **unused)
{
    (void)unused;
    static const uint8_t checker[16] = {0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255, 0, 0, 0, 255};
    daft_texture_data texture = build(checker, 2, 2);
    const uint8_t *grey = texture.texels[1];
    assert_true(grey[0] == 188 && grey[1] == 188 && grey[2] == 188 && grey[3] == 255); /* half the light, not 128 */
    free_texture(&texture);
    print_message("seed %llu\n", (unsigned long long)random_state);
    static const int sizes[][2] = {{2, 2}, {3, 3}, {7, 4}, {4, 9}, {1, 5}, {13, 1}, {64, 31}};
    static uint8_t rgba[4 * 64 * 64];
    for (size_t i = 0; i < sizeof rgba; i++) rgba[i] = (uint8_t)random_below(256);
    for (size_t k = 0; k < DAFT_COUNT_OF(sizes); k++) {
        int w = sizes[k][0], h = sizes[k][1];
        texture = build(rgba, w, h);
        assert_memory_equal(texture.texels[0], rgba, 4 * (size_t)(w * h));
        for (int y = 0; y < texture.height[1]; y++)
            for (int x = 0; x < texture.width[1]; x++)
                for (int c = 0; c < 4; c++) {
                    double sum = 0;
                    for (int j = 0; j < h; j++)
                        for (int i = 0; i < w; i++) {
                            double value = rgba[4 * (j * w + i) + c] / 255.0;
                            if (c < 3) value = (double)daft_srgb_to_linear((float)value);
                            sum += value * overlap(x, texture.width[1], i, w) * overlap(y, texture.height[1], j, h);
                        }
                    double expected = (c < 3 ? (double)daft_linear_to_srgb((float)sum) : sum) * 255;
                    int got = texture.texels[1][4 * (y * texture.width[1] + x) + c];
                    if (fabs(got - expected) > 0.501) fail_msg("%dx%d at %d,%d: %d, not %g", w, h, x, y, got, expected);
                }
        free_texture(&texture);
    }
}

static void one_colour_stays_that_colour(void **unused)
{
    (void)unused;
    static uint8_t rgba[4 * 37 * 53];
    for (int value = 0; value < 256; value += 15) {
        memset(rgba, value, sizeof rgba);
        daft_texture_data texture = build(rgba, 37, 53);
        for (int level = 0; level < texture.levels; level++)
            for (int i = 0; i < 4 * texture.width[level] * texture.height[level]; i++)
                assert_int_equal(texture.texels[level][i], value);
        free_texture(&texture);
    }
}

static void the_missing_texture_is_a_checker(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_texture_data texture;
    assert_true(daft_texture_missing(&allocator, &texture, NULL));
    assert_true(texture.missing && texture.levels > 1);
    const uint8_t *first = texture.texels[0], *other = first + 4 * 8;
    assert_true(first[0] == 255 && first[1] == 0 && first[2] == 255 && first[3] == 255 && other[0] == 0 &&
                other[2] == 0);
    free_texture(&texture);
    daft_error error;
    uint8_t pixel[4] = {0};
    assert_false(daft_texture_build(&allocator, pixel, 0, 1, &texture, &error));
    assert_false(daft_texture_build(&allocator, pixel, 1, 16385, &texture, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
}

/* What textures take while they are made: the file and the picture, and then the picture with its levels, none of which
 * is in floats. */
static void textures_are_made_in_little_memory(void **unused)
{
    (void)unused;
    enum { SIDE = 1024 };
    daft_allocator counted = counting_allocator(&memory);
    daft_image image = noise_image(&counted, SIDE, SIDE);
    daft_error error;
    assert_true(daft_image_write(&image, test_path("large.png"), &error));
    size_t file_size;
    daft_release(&counted, daft_file_read(&counted, NULL, test_path("large.png"), &file_size, &error));
    daft_budget *budget = daft_budget_open(&counted, 0);
    daft_allocator allocator = daft_budget_allocator(budget);
    daft_texture_data texture;
    assert_true(daft_texture_read(&allocator, NULL, test_path("large.png"), &texture, &error));
    uint64_t rgba = 4 * SIDE * SIDE;
    assert_true(daft_budget_memory(budget).used < rgba * 134 / 100);
    assert_true(daft_budget_memory(budget).peak < rgba * 101 / 100 + file_size);
    daft_texture_free(&allocator, &texture);
    daft_budget_close(budget);
    daft_image_free(&image);
    assert_int_equal(memory.live, 0);
}

/* ---- what several scenes share ---- */

static daft_image_file file_of(const daft_allocator *allocator, const char *path)
{
    daft_error error;
    daft_image_file file = {.path = path};
    file.bytes = daft_file_read(allocator, NULL, path, &file.size, &error);
    if (!file.bytes) fail_msg("%s", error.message);
    return file;
}

static void write_noise(const daft_allocator *allocator, const char *path, int width, int height)
{
    daft_image image = noise_image(allocator, width, height);
    daft_error error;
    assert_true(daft_image_write(&image, path, &error));
    daft_image_free(&image);
}

static void assert_same_texture(const daft_texture_data *a, const daft_texture_data *b)
{
    assert_int_equal(a->levels, b->levels);
    assert_int_equal(a->has_alpha, b->has_alpha);
    for (int i = 0; i < a->levels; i++)
        assert_memory_equal(a->texels[i], b->texels[i], 4 * (size_t)a->width[i] * (size_t)a->height[i]);
}

/* The texels of a shared texture are those of one that is read alone; they are there once, and gone with the last
 * holder, in any order. */
static void textures_of_the_same_bytes_are_shared(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_error error;
    daft_image_cache cache = {NULL};
    const daft_texture_change grey = {.channel = 'l', .gain = 1}, dark = {.gain = 0.5f};
    const daft_texture_change *const changes[] = {NULL, &grey, &dark};
    write_noise(&allocator, test_path("one.png"), 40, 24);
    write_noise(&allocator, test_path("two.png"), 40, 24);
    const daft_image_file files[] = {file_of(&allocator, test_path("one.png")),
                                     file_of(&allocator, test_path("two.png"))};
    const long before = memory.live;
    daft_texture_data shared[2][3][2], alone;
    for (int f = 0; f < 2; f++)
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < 2; i++)
                assert_true(daft_texture_share(&cache, &allocator, &files[f], changes[c], &shared[f][c][i], &error));
            assert_true(daft_texture_decode(&allocator, &files[f], changes[c], &alone, &error));
            assert_ptr_equal(shared[f][c][0].texels[0], shared[f][c][1].texels[0]);
            assert_same_texture(&shared[f][c][0], &alone);
            daft_texture_free(&allocator, &alone);
        }
    for (int c = 0; c < 6; c++)
        for (int d = 0; d < c; d++)
            assert_ptr_not_equal(shared[c / 3][c % 3][0].texels[0], shared[d / 3][d % 3][0].texels[0]);
    for (int k = 0; k < 12; k++) {
        daft_texture_data *t = &shared[k * 7 % 12 / 6][k * 7 % 12 / 2 % 3][k * 7 % 2];
        const uint8_t *texels = t->texels[0];
        daft_texture_free(&allocator, t);
        for (int i = 0; i < 12; i++) { /* the other holder's are still there */
            const daft_texture_data *other = &shared[i / 6][i / 2 % 3][i % 2];
            if (other->texels[0] == texels) assert_true(other->levels > 1 && texels[3] == 255);
        }
    }
    assert_null(cache.first);
    assert_int_equal(memory.live, before);
    for (int f = 0; f < 2; f++) daft_release(&allocator, (void *)(uintptr_t)files[f].bytes);
}

/* One image, and six as a cube; a texture of the same file is something else. */
static void skies_of_the_same_bytes_are_shared(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_error error;
    daft_image_cache cache = {NULL};
    daft_image_file files[6];
    for (int i = 0; i < 6; i++) {
        char name[32];
        snprintf(name, sizeof name, "face%d.png", i);
        write_noise(&allocator, test_path(name), 8, 8);
        files[i] = file_of(&allocator, test_path(name));
        files[i].path = "a face";
    }
    const long before = memory.live;
    daft_sky_image one[2], cube[2], alone;
    daft_texture_data texture;
    assert_true(daft_texture_share(&cache, &allocator, &files[0], NULL, &texture, &error));
    for (int i = 0; i < 2; i++) {
        assert_true(daft_sky_share(&cache, &allocator, files, 1, &one[i], &error));
        assert_true(daft_sky_share(&cache, &allocator, files, 6, &cube[i], &error));
    }
    assert_ptr_equal(one[0].texels, one[1].texels);
    assert_ptr_equal(cube[0].texels, cube[1].texels);
    assert_true(cube[0].cube && !one[0].cube);
    assert_true(daft_sky_decode_cube(&allocator, files, &alone, &error));
    assert_memory_equal(alone.texels, cube[0].texels, 3 * sizeof(float) * (size_t)alone.width * (size_t)alone.height);
    daft_sky_free(&allocator, &alone);
    assert_true(daft_sky_decode(&allocator, &files[0], &alone, &error));
    assert_memory_equal(alone.texels, one[0].texels, 3 * sizeof(float) * 64);
    daft_sky_free(&allocator, &alone);
    for (int i = 0; i < 2; i++) daft_sky_free(&allocator, &one[i]), daft_sky_free(&allocator, &cube[1 - i]);
    daft_texture_free(&allocator, &texture);
    assert_null(cache.first);
    assert_int_equal(memory.live, before);
    for (int i = 0; i < 6; i++) daft_release(&allocator, (void *)(uintptr_t)files[i].bytes);
}

/* Nothing stays of what cannot be decoded, or for which there is no memory. */
static void what_fails_is_not_shared(void **unused)
{
    (void)unused;
    daft_allocator plain = counting_allocator(&memory);
    write_noise(&plain, test_path("one.png"), 40, 24);
    daft_image_file file = file_of(&plain, test_path("one.png"));
    daft_image_cache cache = {NULL};
    daft_texture_data texture;
    daft_error error;
    const long before = memory.live;
    for (long fail_at = 0;; fail_at++) {
        memory.calls = 0, memory.fail_at = fail_at;
        const bool done = daft_texture_share(&cache, &plain, &file, NULL, &texture, &error);
        if (done) break;
        assert_int_equal(error.code, DAFT_ERROR_MEMORY);
        assert_null(cache.first);
        assert_int_equal(memory.live, before);
    }
    memory.fail_at = -1;
    daft_texture_free(&plain, &texture);
    const size_t whole = file.size;
    file.size /= 2;
    assert_false(daft_texture_share(&cache, &plain, &file, NULL, &texture, &error));
    assert_null(cache.first);
    file.size = whole;
    daft_release(&plain, (void *)(uintptr_t)file.bytes);
    assert_int_equal(memory.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_srgb_curve),
        cmocka_unit_test(levels_halve_down_to_one_texel),
        cmocka_unit_test(filtering_is_in_linear_light),
        cmocka_unit_test(one_colour_stays_that_colour),
        cmocka_unit_test(the_missing_texture_is_a_checker),
        cmocka_unit_test(textures_are_made_in_little_memory),
        cmocka_unit_test(textures_of_the_same_bytes_are_shared),
        cmocka_unit_test(skies_of_the_same_bytes_are_shared),
        cmocka_unit_test(what_fails_is_not_shared),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
