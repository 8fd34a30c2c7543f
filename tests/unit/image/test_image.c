/* Images: what is read, what is refused and why, writing, skies, and how pictures are enlarged. */
#include "base/budget.h"
#include "image/color.h"
#include "image/image.h"
#include "math/simd/dispatch.h"
#include "math/trig.h"
#include "noise_image.h"
#include "support_content.h"

static counting memory;

static void refuse(const char *path, daft_status code, const char *message)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_image image;
    daft_error error;
    char shown[1100];
    if (daft_image_read(&allocator, NULL, path, &image, &error)) fail_msg("read: %s", path);
    assert_int_equal(memory.live, 0);
    assert_string_equal(error.file, path);
    assert_contains(daft_error_text(&error, shown, sizeof shown), message);
    assert_int_equal(error.code, code);
    daft_sky_image sky;
    assert_false(daft_sky_read(&allocator, NULL, path, &sky, &error));
    daft_texture_data texture;
    assert_false(daft_texture_read(&allocator, NULL, path, &texture, NULL));
    assert_int_equal(memory.live, 0);
}

static void pictures_come_back_as_they_were(void **unused)
{
    (void)unused;
    static const int sizes[][2] = {{1, 1}, {7, 5}, {64, 64}, {3, 200}};
    for (size_t i = 0; i < DAFT_COUNT_OF(sizes); i++)
        for (int alpha = 0; alpha < 2; alpha++) {
            daft_allocator allocator = counting_allocator(&memory);
            daft_image image = noise_image(&allocator, sizes[i][0], sizes[i][1]), back;
            if (alpha) image.pixels[3] = 17;
            daft_error error;
            assert_true(daft_image_write(&image, test_path("a.PNG"), &error));
            assert_true(daft_image_read(&allocator, NULL, test_path("a.PNG"), &back, &error));
            assert_true(back.width == image.width && back.height == image.height);
            assert_memory_equal(back.pixels, image.pixels, 4 * (size_t)(image.width * image.height));
            daft_image_free(&back);
            daft_image_free(&image);
            assert_int_equal(memory.live, 0);
        }
}

static void ppm_is_what_it_says(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    uint8_t pixels[8] = {1, 2, 3, 255, 4, 5, 6, 0};
    daft_image image = {.allocator = allocator, .width = 2, .height = 1, .pixels = pixels};
    assert_true(daft_image_write(&image, test_path("a.ppm"), NULL));
    size_t size;
    char *bytes = daft_file_read(&allocator, NULL, test_path("a.ppm"), &size, NULL);
    assert_int_equal(size, 17);
    assert_memory_equal(bytes, "P6\n2 1\n255\n\1\2\3\4\5\6", 17);
    daft_release(&allocator, bytes);
    assert_false(daft_file_exists(NULL, test_path("a.ppm.tmp~")));
    assert_int_equal(memory.live, 0);
}

static void writing_says_what_is_wrong(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_image image = noise_image(&allocator, 2, 2);
    static const char *const names[] = {"a.jpg", "a", ".png/a", "a.png.", ""};
    daft_error error;
    for (size_t i = 0; i < DAFT_COUNT_OF(names); i++) assert_false(daft_image_write(&image, names[i], &error));
    assert_false(daft_image_write(&image, "a.jpg", &error));
    assert_int_equal(error.code, DAFT_ERROR_UNSUPPORTED);
    assert_contains(error.message, ".png or .ppm");
    assert_false(daft_image_write(&image, test_path("no folder/a.png"), &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_contains(error.message, "No such file or directory");
    char command[256];
    snprintf(command, sizeof command, "mkdir '%s'", test_path("folder.png"));
    assert_int_equal(system(command), 0);
    assert_false(daft_image_write(&image, test_path("folder.png"), &error));
    assert_contains(error.message, "is a folder");
    assert_false(daft_image_write(NULL, "a.png", &error));
    daft_image_free(&image);
    assert_int_equal(memory.live, 0);
}

/* ---- reading ---- */

static void what_is_no_image_is_refused(void **unused)
{
    (void)unused;
    refuse(test_path("none.png"), DAFT_ERROR_IO, "cannot open");
    refuse(test_folder, DAFT_ERROR_IO, "is a directory");
    refuse(write_test_text("empty.png", ""), DAFT_ERROR_SYNTAX, "the file is empty");
    refuse(write_test_text("text.png", "hello, this is not an image at all"), DAFT_ERROR_SYNTAX,
           "cannot decode the image: ");
    refuse(write_test_text("x.ppm", "P6 1 1 255 abc"), DAFT_ERROR_SYNTAX, "cannot decode the image: ");
    refuse(write_test_file("magic.png", "\x89PNG\r\n\x1a\n", 8), DAFT_ERROR_SYNTAX, "cannot decode the image: ");
    static const unsigned char wide[] = {0, 0, 2, 0,    0,    0, 0, 0,  0,
                                         0, 0, 0, 0xff, 0x7f, 1, 0, 24, 0}; /* TGA, 32767 wide */
    refuse(write_test_file("wide.tga", wide, sizeof wide), DAFT_ERROR_UNSUPPORTED, "32767 by 1 pixels; 16384 a side");
    static const unsigned char none[] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 24, 0};
    refuse(write_test_file("none.tga", none, sizeof none), DAFT_ERROR_SYNTAX, "image");
}

/* A 2x2 TGA, top row first, and its colours as RGBA. */
static const unsigned char small_tga[] = {0, 0,  2,    0, 0, 0, 0, 0, 0, 0, 0, 0, 2,  0,  2,
                                          0, 24, 0x20, 3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10};

static void other_formats(void **unused)
{
    (void)unused;
    static const unsigned char expected[] = {1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255, 10, 11, 12, 255};
    static const unsigned char bmp[] = {'B', 'M', 70, 0,  0,  0,  0, 0, 0, 0, 54, 0, 0, 0, 40, 0, 0,  0,
                                        2,   0,   0,  0,  2,  0,  0, 0, 1, 0, 24, 0, 0, 0, 0,  0, 16, 0,
                                        0,   0,   0,  0,  0,  0,  0, 0, 0, 0, 0,  0, 0, 0, 0,  0, 0,  0,
                                        9,   8,   7,  12, 11, 10, 0, 0, 3, 2, 1,  6, 5, 4, 0,  0};
    static const unsigned char gif[] = {'G', 'I',  'F', '8', '9', 'a', 1, 0, 1, 0, 0x80, 0, 0, 255,  0, 0, 0,   0,
                                        0,   0x2c, 0,   0,   0,   0,   1, 0, 1, 0, 0,    2, 2, 0x44, 1, 0, 0x3b};
    daft_allocator allocator = counting_allocator(&memory);
    daft_image image;
    assert_true(daft_image_read(&allocator, NULL, write_test_file("a.tga", small_tga, sizeof small_tga), &image, NULL));
    assert_memory_equal(image.pixels, expected, sizeof expected);
    daft_image_free(&image);
    assert_true(daft_image_read(&allocator, NULL, write_test_file("a.bmp", bmp, sizeof bmp), &image, NULL));
    assert_memory_equal(image.pixels, expected, sizeof expected);
    daft_image_free(&image);
    assert_true(daft_image_read(&allocator, NULL, write_test_file("a.gif", gif, sizeof gif), &image, NULL));
    assert_true(image.width == 1 && image.pixels[0] == 255 && image.pixels[1] == 0 && image.pixels[3] == 255);
    daft_image_free(&image);
    assert_int_equal(memory.live, 0);
}

static void check_truncated(const char *bytes, size_t size, const char *name, size_t step)
{
    for (size_t cut = 0; cut + 1 < size; cut += step) {
        daft_allocator allocator = counting_allocator(&memory);
        const char *path = write_test_file(name, bytes, cut);
        daft_image image;
        daft_error error;
        if (daft_image_read(&allocator, NULL, path, &image, &error))
            fail_msg("%s was read from %zu of %zu bytes", name, cut, size);
        assert_int_equal(memory.live, 0);
        assert_string_equal(error.file, path);
    }
}

static void files_that_were_cut_off(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    check_truncated((const char *)small_tga, sizeof small_tga, "cut.tga", 1);
    refuse(write_test_file("cut.tga", small_tga, sizeof small_tga - 1), DAFT_ERROR_SYNTAX, "truncated");
    daft_image image = noise_image(&allocator, 9, 9);
    assert_true(daft_image_write(&image, test_path("whole.png"), NULL));
    daft_image_free(&image);
    size_t size;
    char *bytes = daft_file_read(&allocator, NULL, test_path("whole.png"), &size, NULL);
    check_truncated(bytes, size, "cut.png", 3);
    daft_allocator plain = counting_allocator(&memory);
    memory.live = 1;
    daft_release(&plain, bytes);
    const char *jpeg = shared_file("models/hand/hand_mapNew.jpg");
    if (!jpeg) return;
    bytes = daft_file_read(&plain, NULL, jpeg, &size, NULL);
    assert_non_null(bytes);
    check_truncated(bytes, size, "cut.jpg", size / 7);
    daft_release(&plain, bytes);
}

static void damaged_files_never_crash(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_image image = noise_image(&allocator, 12, 7);
    assert_true(daft_image_write(&image, test_path("whole.png"), NULL));
    daft_image_free(&image);
    size_t sizes[2] = {0, sizeof small_tga};
    char *bytes = daft_file_read(&allocator, NULL, test_path("whole.png"), &sizes[0], NULL);
    const char *const sources[2] = {bytes, (const char *)small_tga};
    print_message("seed %llu\n", (unsigned long long)random_state);
    for (int run = 0; run < 1000; run++) {
        char damaged[1024];
        int which = run & 1;
        assert_true(sizes[which] <= sizeof damaged);
        memcpy(damaged, sources[which], sizes[which]);
        for (uint32_t edit = random_below(4) + 1; edit > 0; edit--)
            damaged[random_below((uint32_t)sizes[which])] = (char)random_below(256);
        if (which) damaged[13] = damaged[15] = 0; /* keep it small */
        const char *path = write_test_file("damaged", damaged, sizes[which]);
        if (daft_image_read(&allocator, NULL, path, &image, NULL)) daft_image_free(&image);
        assert_int_equal(memory.live, 1);
    }
    daft_release(&allocator, bytes);
}

/* ---- skies ---- */

static void skies_are_linear(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_sky_image sky;
    assert_true(daft_sky_read(&allocator, NULL, write_test_file("a.tga", small_tga, sizeof small_tga), &sky, NULL));
    assert_true(sky.width == 2 && sky.height == 2);
    for (int i = 0; i < 12; i++) assert_true(fabsf(sky.texels[i] - daft_srgb_to_linear((float)(i + 1) / 255)) < 1e-9f);
    daft_sky_free(&allocator, &sky);
    /* two RGBE pixels: 128, 64, 32 with exponent 129 is 1, 0.5, 0.25; exponent 137 is 256 times that */
    static const char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x20\x81\x80\x40\x20\x89";
    const char *path = write_test_file("a.hdr", hdr, sizeof hdr - 1);
    assert_true(daft_sky_read(&allocator, NULL, path, &sky, NULL));
    const float expected[6] = {1, .5f, .25f, 256, 128, 64};
    assert_memory_equal(sky.texels, expected, sizeof expected);
    daft_sky_free(&allocator, &sky);
    daft_image image;
    assert_true(daft_image_read(&allocator, NULL, path, &image, NULL));
    const uint8_t bytes[8] = {255, 188, 137, 255, 255, 255, 255, 255};
    assert_memory_equal(image.pixels, bytes, sizeof bytes);
    daft_image_free(&image);
    assert_int_equal(memory.live, 0);
    refuse(write_test_file("cut.hdr", hdr, sizeof hdr - 4), DAFT_ERROR_SYNTAX, "truncated");
}

/* A row of an HDR file, stored as it is: `bright` at texel `at`, black elsewhere. */
static size_t put_hdr_row(char *to, int width, int at, const char bright[4])
{
    memset(to, 0, 4 * (size_t)width);
    if (at >= 0) memcpy(to + 4 * at, bright, 4);
    return 4 * (size_t)width;
}

/* The mean over the sphere is that over rows weighed by their solid angle; one texel of sun is not overlooked in a tall
 * image. */
static void means_of_skies(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_sky_image sky;
    float texels[3 * 4 * 2] = {0};
    for (int i = 0; i < 12; i++) texels[i] = 3; /* the upper half */
    const daft_sky_image half = {.width = 4, .height = 2, .texels = texels};
    assert_true(fabsf(daft_sky_mean(&half).y - 1.5f) < 1e-6f);
    enum { W = 4, H = 1026, SUN = 301 };
    static char file[64 + 4 * W * H];
    size_t size = (size_t)snprintf(file, sizeof file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", H, W);
    double weights = 0, sun = 0;
    for (int y = 0; y < H; y++) {
        const double weight = sin(DAFT_PI * (y + 0.5) / H);
        weights += W * weight, sun += y == SUN ? weight * 512 : 0;
        size += put_hdr_row(file + size, W, y == SUN ? 2 : -1, "\x80\x40\x20\x8a");
    }
    assert_true(daft_sky_read(&allocator, NULL, write_test_file("sun.hdr", file, size), &sky, NULL));
    assert_true(sky.texels[3 * (SUN * W + 2)] == 512);
    assert_true(fabs((double)daft_sky_mean(&sky).x / (sun / weights) - 1) < 1e-6);
    daft_sky_free(&allocator, &sky);
    assert_int_equal(memory.live, 0);
}

static void real_files(void **unused)
{
    (void)unused;
    static const struct {
        const char *name;
        int width, height;
    } files[] = {{"models/hand/hand_mapNew.jpg", 0, 0},
                 {"models/plane/plane_diffuse.png", 0, 0},
                 {"models/spider/wal67ar_small.jpg", 0, 0},
                 {"sky/dresden_square_1k.hdr", 1024, 512}};
    for (size_t i = 0; i < DAFT_COUNT_OF(files); i++) {
        const char *path = shared_file(files[i].name);
        if (!path) continue;
        daft_allocator allocator = counting_allocator(&memory);
        daft_texture_data texture;
        daft_sky_image sky;
        daft_error error;
        if (!daft_texture_read(&allocator, NULL, path, &texture, &error)) fail_msg("%s: %s", path, error.message);
        if (files[i].width) assert_true(texture.width[0] == files[i].width && texture.height[0] == files[i].height);
        assert_true(daft_sky_read(&allocator, NULL, path, &sky, &error));
        for (int k = 0; k < 3 * sky.width * sky.height; k++) assert_true(isfinite(sky.texels[k]) && sky.texels[k] >= 0);
        daft_sky_free(&allocator, &sky);
        daft_texture_free(&allocator, &texture);
        assert_int_equal(memory.live, 0);
    }
}

/* Reads the file as a picture, a texture or a sky, or writes the picture. */
enum { READ_IMAGE, READ_TEXTURE, READ_SKY, WRITE_IMAGE, KINDS };
static bool do_one(int kind, const daft_allocator *allocator, const char *path, const daft_image *picture,
                   daft_error *error)
{
    daft_texture_data texture;
    daft_sky_image sky;
    daft_image image;
    bool done = false;
    if (kind == READ_IMAGE && (done = daft_image_read(allocator, NULL, path, &image, error))) daft_image_free(&image);
    if (kind == READ_TEXTURE && (done = daft_texture_read(allocator, NULL, path, &texture, error)))
        daft_texture_free(allocator, &texture);
    if (kind == READ_SKY && (done = daft_sky_read(allocator, NULL, path, &sky, error))) daft_sky_free(allocator, &sky);
    if (kind == WRITE_IMAGE) done = daft_image_write(picture, test_path("out.png"), error);
    return done;
}

/* The old picture stays where the new one cannot be written. */
static void fail_everywhere(int kind, const char *path, const daft_image *picture)
{
    for (long fail_at = 0;; fail_at++) {
        daft_allocator allocator = counting_allocator(&memory);
        memory.fail_at = fail_at;
        daft_error error;
        daft_image written = *picture;
        written.allocator = allocator;
        bool done = do_one(kind, &allocator, path, &written, &error);
        assert_int_equal(memory.live, 0);
        if (!done && error.code != DAFT_ERROR_MEMORY) fail_msg("%s, %ld: %s", path, fail_at, error.message);
        if (!done && kind == WRITE_IMAGE) assert_false(daft_file_exists(NULL, test_path("out.png")));
        if (done && kind == WRITE_IMAGE) remove(test_path("out.png"));
        if (memory.calls > fail_at) continue;
        assert_true(done);
        break;
    }
}

/* In every decoder and encoder of stb, which looks for NULL here and there. */
static void memory_may_run_out_anywhere(void **unused)
{
    (void)unused;
    static const char *const seeds[] = {"base.jpg", "progressive.jpg", "grey16.png", "palette.png",
                                        "rgb.png",  "two.gif",         "raw.psd",    "rgb.bmp",
                                        "rle.tga",  "sky.hdr",         "rgba.png"};
    daft_allocator plain = counting_allocator(&memory);
    daft_image picture = noise_image(&plain, 24, 24);
    char path[512];
    for (size_t i = 0; i < DAFT_COUNT_OF(seeds); i++) {
        snprintf(path, sizeof path, "%s/tests/fuzz/seeds/image/%s", DAFT_ROOT, seeds[i]);
        for (int kind = 0; kind < WRITE_IMAGE; kind++) fail_everywhere(kind, path, &picture);
    }
    fail_everywhere(WRITE_IMAGE, "out.png", &picture);
    picture.pixels[3] = 1; /* with alpha */
    fail_everywhere(WRITE_IMAGE, "out.png", &picture);
    plain = daft_malloc_allocator();
    daft_release(&plain, picture.pixels);
}

/* ---- a limit of bytes ---- */

/* As many bytes as make the size in the header possible. */
static const char *write_huge_png(void)
{
    static uint8_t bytes[20000] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0,  0, 13, 'I',
                                   'H',  'D', 'R', 0,   0,  64, 0,  0,  0, 64, 0, 8,  /* 16384 by 16384, 8 bits */ 6,
                                   0,    0,   0};
    return write_test_file("huge.png", bytes, sizeof bytes);
}

static void what_is_too_large_is_not_decoded(void **unused)
{
    (void)unused;
    daft_allocator counted = counting_allocator(&memory);
    daft_budget *budget = daft_budget_open(&counted, 1000000000);
    daft_allocator allocator = daft_budget_allocator(budget);
    const char *path = write_huge_png();
    uint64_t before = daft_budget_memory(budget).used;
    for (int kind = 0; kind < WRITE_IMAGE; kind++) {
        daft_error error;
        char shown[1100];
        assert_false(do_one(kind, &allocator, path, NULL, &error));
        assert_int_equal(error.code, DAFT_ERROR_MEMORY);
        assert_string_equal(error.file, path);
        assert_contains(daft_error_text(&error, shown, sizeof shown),
                        "an image of 16384 by 16384 pixels needs 1.07 GB of memory; the limit is 1 GB");
        assert_int_equal(daft_budget_memory(budget).used, before);
        assert_true(daft_budget_memory(budget).peak < 100000);
    }
    daft_budget_close(budget);
    assert_int_equal(memory.live, 0);
}

/* ---- in little memory ---- */

/* A file as it is and with `extra` at a place where it says nothing new, but makes the file one that stb_image decodes
 * as a whole: the same picture, and what reading it took. */
static void read_both(const char *path, const char *extra, size_t extra_size, long at)
{
    daft_allocator counted = counting_allocator(&memory);
    daft_image image[2];
    daft_error error;
    uint64_t peak[2];
    size_t size;
    char *bytes = daft_file_read(&counted, NULL, path, &size, &error), *longer = malloc(size + extra_size);
    const size_t place = at < 0 ? size - (size_t)-at : (size_t)at;
    memcpy(longer, bytes, place), memcpy(longer + place, extra, extra_size);
    memcpy(longer + place + extra_size, bytes + place, size - place);
    const char *const files[2] = {path, write_test_file("longer", longer, size + extra_size)};
    for (int k = 0; k < 2; k++) {
        daft_budget *budget = daft_budget_open(&counted, 0);
        daft_allocator allocator = daft_budget_allocator(budget);
        if (!daft_image_read(&allocator, NULL, files[k], &image[k], &error)) fail_msg("%s: %s", path, error.message);
        peak[k] = daft_budget_memory(budget).peak;
        daft_budget_close(budget);
    }
    assert_true(image[0].width == image[1].width && image[0].height == image[1].height);
    const size_t rgba = 4 * (size_t)image[0].width * (size_t)image[0].height;
    assert_memory_equal(image[0].pixels, image[1].pixels, rgba);
    if (rgba > 1000000) assert_true(peak[0] < peak[1] && peak[0] < rgba * 11 / 10 + size);
    for (int k = 0; k < 2; k++) daft_image_free(&image[k]);
    daft_release(&counted, bytes), free(longer);
    assert_int_equal(memory.live, 0);
}

static void pictures_are_those_of_stb_image(void **unused)
{
    (void)unused;
    static const char *const jpegs[] = {"fuzz/seeds/image/base.jpg",    "fuzz/seeds/image/s444.jpg",
                                        "fuzz/seeds/image/s422.jpg",    "fuzz/seeds/image/s440.jpg",
                                        "fuzz/seeds/image/s411.jpg",    "fuzz/seeds/image/restart.jpg",
                                        "../assets/textures/cobble.jpg"};
    static const char *const pngs[] = {"fuzz/seeds/image/rgb.png", "fuzz/seeds/image/rgba.png",
                                       "../assets/textures/brick.png", "../assets/textures/twig_alpha.png"};
    char path[512];
    for (size_t i = 0; i < DAFT_COUNT_OF(jpegs); i++) {
        snprintf(path, sizeof path, "%s/tests/%s", DAFT_ROOT, jpegs[i]);
        read_both(path, "\xff\xfe\0\2", 4, -2); /* a comment before the end */
    }
    for (size_t i = 0; i < DAFT_COUNT_OF(pngs); i++) {
        snprintf(path, sizeof path, "%s/tests/%s", DAFT_ROOT, pngs[i]);
        read_both(path, "\0\0\0\3PLTE\1\2\3\0\0\0\0", 15, 33); /* colours that it does not use */
    }
}

/* A PNG file's data in pieces of these bytes, with a chunk between them that says nothing. */
static size_t cut_png(const char *from, size_t size, size_t piece, char *out)
{
    const size_t length = size - 33 - 24; /* of the one IDAT between IHDR and IEND */
    size_t at = 33;
    memcpy(out, from, at);
    for (size_t done = 0; done < length; done += piece) {
        const size_t now = length - done < piece ? length - done : piece;
        const char head[8] = {(char)(now >> 24), (char)(now >> 16), (char)(now >> 8), (char)now, 'I', 'D', 'A', 'T'};
        memcpy(out + at, head, 8), memcpy(out + at + 8, from + 41 + done, now), memset(out + at + 8 + now, 0, 4);
        at += now + 12;
        memcpy(out + at, "\0\0\0\1teXt!\0\0\0\0", 13), at += 13;
    }
    memcpy(out + at, from + size - 12, 12);
    return at + 12;
}

static void pieces_of_a_png_file_are_joined(void **unused)
{
    (void)unused;
    daft_allocator allocator = counting_allocator(&memory);
    daft_image image = noise_image(&allocator, 40, 30), back;
    daft_error error;
    size_t size;
    assert_true(daft_image_write(&image, test_path("one.png"), &error));
    char *bytes = daft_file_read(&allocator, NULL, test_path("one.png"), &size, &error), *cut = malloc(30 * size);
    for (size_t piece = 1; piece < size; piece += piece < 4 ? 1 : 977) {
        const size_t all = cut_png(bytes, size, piece, cut);
        const char *path = write_test_file("many.png", cut, all);
        if (!daft_image_read(&allocator, NULL, path, &back, &error)) fail_msg("%s", error.message);
        assert_memory_equal(back.pixels, image.pixels, 4 * 40 * 30);
        daft_image_free(&back);
        assert_true(daft_image_decode(&allocator, cut, all, "memory", &back, &error)); /* which stays as it is */
        assert_memory_equal(back.pixels, image.pixels, 4 * 40 * 30);
        daft_image_free(&back);
        cut[all / 2] ^= 85, cut[all / 2 + 1] ^= 85; /* damaged, or not: nothing else than that happens */
        if (daft_image_read(&allocator, NULL, write_test_file("bad.png", cut, all), &back, &error))
            daft_image_free(&back);
    }
    daft_release(&allocator, bytes), free(cut);
    daft_image_free(&image);
    assert_int_equal(memory.live, 0);
}

/* ---- enlarging ---- */

/* A byte of `image`, with its border repeated beyond. */
static double byte_at(const daft_image *image, int x, int y, int channel)
{
    x = x < 0 ? 0 : x >= image->width ? image->width - 1 : x;
    y = y < 0 ? 0 : y >= image->height ? image->height - 1 : y;
    return (double)image->pixels[4 * (y * image->width + x) + channel];
}

/* Of a to d, at the fraction f between b and c. */
static double between(double a, double b, double c, double d, double f, daft_upscale how)
{
    if (how == DAFT_UPSCALE_NEAREST) return f < 0.5 ? b : c;
    if (how == DAFT_UPSCALE_BILINEAR) return b + (c - b) * f;
    const double curve =
        b + 0.5 * f * (c - a + f * (2 * a - 5 * b + 4 * c - d + f * (3 * (b - c) + d - a))); /* Catmull, Rom 1974 */
    return fmin(fmax(curve, fmin(b, c)), fmax(b, c));
}

static double enlarged(const daft_image *from, const daft_image *to, int x, int y, int channel, daft_upscale how)
{
    const double px = (x + 0.5) * from->width / to->width - 0.5, py = (y + 0.5) * from->height / to->height - 0.5;
    const int left = (int)floor(px), top = (int)floor(py);
    double column[4];
    for (int i = 0; i < 4; i++) {
        double row[4];
        for (int j = 0; j < 4; j++) row[j] = byte_at(from, left - 1 + i, top - 1 + j, channel);
        column[i] = between(row[0], row[1], row[2], row[3], py - top, how);
    }
    return between(column[0], column[1], column[2], column[3], px - left, how);
}

static void enlarging_is_as_in_double(void **unused)
{
    (void)unused;
    static const int sizes[][4] = {{1, 1, 5, 3},    {2, 3, 2, 3},     {3, 2, 7, 7},
                                   {17, 9, 31, 18}, {40, 30, 80, 60}, {1, 8, 1, 9}};
    daft_allocator allocator = counting_allocator(&memory);
    for (size_t i = 0; i < DAFT_COUNT_OF(sizes) * DAFT_ISA_COUNT * 3; i++) {
        const int *size = sizes[i % DAFT_COUNT_OF(sizes)];
        const int isa = (int)(i / DAFT_COUNT_OF(sizes) % DAFT_ISA_COUNT);
        const daft_upscale how = (daft_upscale)(i / DAFT_COUNT_OF(sizes) / DAFT_ISA_COUNT);
        int found;
        if (daft_isa_find(daft_isa_name(isa), &found) != DAFT_ISA_READY) continue;
        daft_image from = noise_image(&allocator, size[0], size[1]), to = noise_image(&allocator, size[2], size[3]);
        void *scratch = daft_alloc(&allocator, daft_image_enlarge_bytes(&from, &to, 2), 1);
        daft_image_enlarge(&from, &to, how, scratch, 2, isa);
        for (int y = 0; y < to.height; y++)
            for (int x = 0; x < to.width; x++)
                for (int channel = 0; channel < 4; channel++) {
                    const double true_value = enlarged(&from, &to, x, y, channel, how);
                    const double byte = (double)to.pixels[4 * (y * to.width + x) + channel];
                    assert_true(fabs(byte - true_value) < 0.5001);
                }
        daft_release(&allocator, scratch);
        daft_image_free(&from), daft_image_free(&to);
    }
    assert_int_equal(memory.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_come_back_as_they_were),
        cmocka_unit_test(ppm_is_what_it_says),
        cmocka_unit_test(writing_says_what_is_wrong),
        cmocka_unit_test(what_is_no_image_is_refused),
        cmocka_unit_test(other_formats),
        cmocka_unit_test(files_that_were_cut_off),
        cmocka_unit_test(damaged_files_never_crash),
        cmocka_unit_test(enlarging_is_as_in_double),
        cmocka_unit_test(skies_are_linear),
        cmocka_unit_test(means_of_skies),
        cmocka_unit_test(real_files),
        cmocka_unit_test(memory_may_run_out_anywhere),
        cmocka_unit_test(what_is_too_large_is_not_decoded),
        cmocka_unit_test(pictures_are_those_of_stb_image),
        cmocka_unit_test(pieces_of_a_png_file_are_joined),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
