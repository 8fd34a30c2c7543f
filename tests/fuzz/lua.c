/* Any text as a game's main.lua: its callbacks run for a few ticks, whatever it does to the scene, the picture and
 * itself. A call may run a million instructions and hold 64 MiB, so that endless scripts end soon. */
#include "fuzz.h"

#include "files/source.h"
#include "lua/host.h"

#include <math.h>
#include <string.h>

enum { TICKS = 3, WIDTH = 32, HEIGHT = 18 };

typedef struct stage {
    home where;
    game_source source;
    daft_engine *engine;
    font *face;
    daft_image *picture;
} stage;

static const stage *get_stage(void)
{
    static stage made;
    if (made.engine) return &made;
    daft_error error;
    snprintf(made.where.games, sizeof made.where.games, "%s", fuzz_folder());
    snprintf(made.where.assets, sizeof made.where.assets, "%s", fuzz_folder());
    snprintf(made.where.scripts, sizeof made.where.scripts, "%s/scripts", fuzz_root());
    game_info game = {.name = "fuzz"};
    snprintf(game.folder, sizeof game.folder, "%s", fuzz_folder());
    FUZZ_CHECK(source_open(&made.source, &made.where, &game, &error));
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    def.memory_limit = 64000000;
    made.engine = daft_engine_create(&def, &error);
    char face[640];
    snprintf(face, sizeof face, "%s/assets/fonts/daft.ttf", fuzz_root());
    made.face = font_open(NULL, NULL, face, face, &error);
    made.picture = daft_image_create(made.engine, WIDTH, HEIGHT, &error);
    FUZZ_CHECK(made.engine && made.face && made.picture);
    return &made;
}

static bool tick(host *scripts, const stage *on, int number)
{
    daft_scene *scene = scripts->def.scene;
    daft_error error = {0};
    daft_scene_begin_tick(scene);
    input_begin_tick(scripts->def.keys);
    input_apply_queue(scripts->def.keys);
    if (!host_key(scripts, input_key_find("space"), number % 2 == 0)) return false;
    if (!host_update(scripts, 1.0 / 60)) return false;
    FUZZ_CHECK(daft_scene_step(scene, 1.0f / 60, &error));
    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(scene, 1);
    FUZZ_CHECK(daft_render(scene, &view, on->picture, &error));
    canvas over = canvas_over(on->picture);
    return host_draw(scripts, &over);
}

int lua_input(const uint8_t *data, size_t size)
{
    const stage *on = get_stage();
    fuzz_write("main.lua", data, size);
    static input keys;
    memset(&keys, 0, sizeof keys);
    daft_error error = {0};
    host_def def = {.files = on->source.files,
                    .scripts = on->where.scripts,
                    .folder = fuzz_folder(),
                    .name = "fuzz",
                    .engine = on->engine,
                    .scene = daft_scene_create(on->engine, &error),
                    .keys = &keys,
                    .face = on->face,
                    .seed = 1,
                    .instructions = 1000000};
    FUZZ_CHECK(def.scene && daft_engine_set_files(on->engine, on->source.files, &error));
    static host scripts;
    bool good = host_open(&scripts, &def) && host_load(&scripts);
    for (int i = 0; good && i < TICKS && !scripts.quit && !scripts.restart; i++) good = tick(&scripts, on, i);
    FUZZ_CHECK(good || scripts.failure.message[0]);
    FUZZ_CHECK(memchr(scripts.failure.message, 0, sizeof scripts.failure.message) &&
               memchr(scripts.failure.trace, 0, sizeof scripts.failure.trace));
    host_close(&scripts);
    FUZZ_CHECK(scripts.memory == 0);
    daft_scene_destroy(def.scene);
    return 0;
}
