/* assets: everything that ships loads without a warning: the font in stb_truetype, meshes, textures, skies, scenes. */
#include "daft.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#if __has_include(<stb/stb_truetype.h>)
#include <stb/stb_truetype.h>
#else
#include <stb_truetype.h>
#endif
#pragma GCC diagnostic pop

static int warnings;

static void count_warning(void *user, const daft_error *warning)
{
    (void)user;
    char text[1200];
    print_message("warning: %s\n", daft_error_text(warning, text, sizeof text));
    warnings++;
}

typedef struct fixture {
    daft_engine *engine;
    daft_scene *scene;
    daft_error error;
} fixture;

static int set_up(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    daft_engine_def def = daft_default_engine_def();
    def.warn = count_warning;
    warnings = 0;
    f->engine = daft_engine_create(&def, &f->error);
    assert_non_null(f->engine);
    f->scene = daft_scene_create(f->engine, &f->error);
    assert_non_null(f->scene);
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    daft_scene_destroy(f->scene);
    daft_engine_destroy(f->engine);
    free(f);
    return 0;
}

/* Calls `load` for each file in assets/`folder` that ends so, and fails with the loader's message. */
static int for_each(fixture *f, const char *folder, const char *ending, bool (*load)(fixture *, const char *))
{
    char path[1024];
    int count = 0;
    snprintf(path, sizeof path, "%s/assets/%s", DAFT_ROOT, folder);
    DIR *entries = opendir(path);
    assert_non_null(entries);
    for (struct dirent *entry; (entry = readdir(entries));) {
        size_t length = strlen(entry->d_name), tail = strlen(ending);
        if (length < tail || strcmp(entry->d_name + length - tail, ending) != 0) continue;
        snprintf(path, sizeof path, "%s/assets/%s/%s", DAFT_ROOT, folder, entry->d_name);
        if (!load(f, path)) fail_msg("%s: %s", path, f->error.message);
        count++;
    }
    closedir(entries);
    return count;
}

static bool load_mesh(fixture *f, const char *path)
{
    daft_mesh mesh = daft_mesh_load(f->scene, path, &f->error);
    daft_mesh_info info;
    return mesh.id && daft_mesh_get_info(f->scene, mesh, &info, &f->error) && info.triangle_count > 0;
}
static bool load_texture(fixture *f, const char *path) { return daft_texture_load(f->scene, path, &f->error).id != 0; }
static bool load_sky(fixture *f, const char *path) { return daft_scene_set_sky_image(f->scene, path, &f->error); }
/* Into a scene of its own: paths of two files are not one. */
static bool load_scene(fixture *f, const char *path)
{
    daft_scene *scene = daft_scene_create(f->engine, &f->error);
    const bool good = scene && daft_scene_load(scene, path, &f->error) && daft_scene_camera_count(scene) > 0;
    daft_scene_destroy(scene);
    return good;
}

static void files_load_without_a_warning(void **state)
{
    fixture *f = *state;
    assert_true(for_each(f, "meshes", ".obj", load_mesh) >= 10);
    assert_true(for_each(f, "textures", ".png", load_texture) >= 10);
    assert_true(for_each(f, "sky", ".jpg", load_sky) >= 1);
    assert_true(for_each(f, "scenes", ".scene", load_scene) >= 3);
    assert_int_equal(warnings, 0);
}

static unsigned char *read_font(void)
{
    FILE *file = fopen(DAFT_ROOT "/assets/fonts/daft.ttf", "rb");
    assert_non_null(file);
    unsigned char *bytes = calloc(1, 1 << 20);
    assert_true(fread(bytes, 1, 1 << 20, file) > 1000);
    fclose(file);
    return bytes;
}

/* The sum of all 32-bit words of a correct TrueType file. */
static void font_checksum(void **state)
{
    (void)state;
    unsigned char *bytes = read_font();
    uint32_t sum = 0;
    for (size_t i = 0; i < 1 << 20; i += 4)
        sum += (uint32_t)bytes[i] << 24 | (uint32_t)bytes[i + 1] << 16 | (uint32_t)bytes[i + 2] << 8 | bytes[i + 3];
    assert_int_equal(sum, 0xb1b0afba);
    free(bytes);
}

static void font_has_the_letters(void **state)
{
    (void)state;
    static const int extra[] = {0xb0, 0xd7, 0x2013, 0x2014, 0x2026, 0x201c, 0x201d, 0x2019, 0xe9,   0xe4,  0xf6,
                                0xfc, 0xdf, 0x20ac, 0x2192, 0x2190, 0x2191, 0x2193, 0x25cf, 0x2605, 0x25c6};
    unsigned char *bytes = read_font();
    stbtt_fontinfo font;
    assert_true(stbtt_InitFont(&font, bytes, 0));
    int digit, bearing;
    stbtt_GetCodepointHMetrics(&font, '0', &digit, &bearing);
    for (int i = 33; i < 127 + (int)(sizeof extra / sizeof extra[0]); i++) {
        int code = i < 127 ? i : extra[i - 127], x0, y0, x1, y1, advance;
        assert_true(stbtt_FindGlyphIndex(&font, code) > 0);
        stbtt_GetCodepointBitmapBox(&font, code, 0.02f, 0.02f, &x0, &y0, &x1, &y1);
        assert_true(x1 > x0 && y1 > y0 && x1 - x0 < 80 && y1 - y0 < 60);
        stbtt_GetCodepointHMetrics(&font, code, &advance, &bearing);
        assert_true(advance > 0 && advance < 2500);
        if (code >= '0' && code <= '9') assert_int_equal(advance, digit); /* a running clock must not shake */
    }
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(files_load_without_a_warning, set_up, tear_down),
        cmocka_unit_test(font_checksum),
        cmocka_unit_test(font_has_the_letters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
