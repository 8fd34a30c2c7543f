/* Any bytes as a .scene file beside a few assets. What does not load leaves the scene as it was; what does is drawn. */
#include "fuzz.h"

#include <math.h>

enum { WIDTH = 24, HEIGHT = 16 };

static daft_engine *get_engine(void)
{
    static daft_engine *engine;
    if (engine) return engine;
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    engine = daft_engine_create(&def, NULL);
    FUZZ_CHECK(engine);
    return engine;
}

static void draw(daft_scene *scene)
{
    daft_error error = {0};
    daft_image *picture = daft_image_create(get_engine(), WIDTH, HEIGHT, &error);
    float depth[WIDTH * HEIGHT];
    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(scene, 1);
    view.aov.depth = depth;
    FUZZ_CHECK(picture && daft_render(scene, &view, picture, &error));
    for (int i = 0; i < WIDTH * HEIGHT; i++) FUZZ_CHECK(depth[i] >= 0);
    daft_image_destroy(picture);
}

int scene_input(const uint8_t *data, size_t size)
{
    daft_error error = {0};
    daft_scene *scene = daft_scene_create(get_engine(), &error);
    FUZZ_CHECK(scene);
    uint64_t before = daft_scene_hash(scene);
    bool good = daft_scene_load(scene, fuzz_write("input.scene", data, size), &error);
    fuzz_check_error(good, &error);
    if (good)
        draw(scene);
    else
        FUZZ_CHECK(daft_scene_hash(scene) == before && daft_entity_count(scene) == 0 &&
                   daft_scene_camera_count(scene) == 0);
    daft_scene_destroy(scene);
    return 0;
}
