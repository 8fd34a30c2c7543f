/* depth SCENE [FOLDER]: what the depth camera of a robot sees while it drives ahead: eight images of 160 × 120 pixels,
 * as 16-bit PGM files in millimetres (the format of most depth cameras; 0 means nothing in range), and the obstacle
 * ahead. */
#include <daft.h>
#include <stdio.h>

enum { WIDTH = 160, HEIGHT = 120, FRAMES = 8 };
static const double STRIDE = 0.25; /* metres from frame to frame */
static const float RANGE = 65;     /* metres: what 16 bits of millimetres hold */

static int fail(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "depth: %s\n", daft_error_text(error, text, sizeof text));
    return 1;
}

static bool save(const float *depth, const char *path)
{
    static uint8_t bytes[2 * WIDTH * HEIGHT]; /* the most significant byte first, as PGM wants */
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        unsigned millimetres = depth[i] < RANGE ? (unsigned)(1000 * depth[i] + 0.5f) : 0;
        bytes[2 * i] = (uint8_t)(millimetres >> 8), bytes[2 * i + 1] = (uint8_t)millimetres;
    }
    FILE *file = fopen(path, "wb");
    if (!file) return false;
    fprintf(file, "P5\n%d %d\n65535\n", WIDTH, HEIGHT);
    bool written = fwrite(bytes, sizeof bytes, 1, file) == 1;
    return fclose(file) == 0 && written;
}

/* The nearest thing in the middle ninth of the image. */
static float ahead(const float *depth)
{
    float nearest = RANGE;
    for (int y = HEIGHT / 3; y < 2 * HEIGHT / 3; y++)
        for (int x = WIDTH / 3; x < 2 * WIDTH / 3; x++)
            if (depth[y * WIDTH + x] < nearest) nearest = depth[y * WIDTH + x];
    return nearest;
}

int main(int argc, char **argv)
{
    if (argc < 2) return fprintf(stderr, "usage: depth SCENE [FOLDER]\n"), 2;
    static float depth[WIDTH * HEIGHT];
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_scene *scene = engine ? daft_scene_create(engine, &error) : NULL;
    if (!scene || !daft_scene_load(scene, argv[1], &error)) return fail(&error);
    daft_image *image = daft_image_create(engine, WIDTH, HEIGHT, &error);
    if (!image) return fail(&error);

    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(scene, 1);
    view.camera.pitch = 0;
    view.quality = daft_preset_quality(DAFT_PRESET_DRAFT); /* shadows and reflections do not change depth */
    view.aov.depth = depth; /* metres along each pixel's ray; infinity where the sky is */
    for (int frame = 0; frame < FRAMES; frame++) {
        char path[1024];
        if (!daft_render(scene, &view, image, &error)) return fail(&error);
        snprintf(path, sizeof path, "%s/depth-%d.pgm", argc > 2 ? argv[2] : ".", frame);
        if (!save(depth, path)) return fprintf(stderr, "depth: cannot write %s\n", path), 1;
        printf("%s: %.3f m to the nearest obstacle\n", path, (double)ahead(depth));
        view.camera.position.x += STRIDE * daft_cos((double)view.camera.yaw);
        view.camera.position.z += STRIDE * daft_sin((double)view.camera.yaw);
    }
    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return 0;
}
