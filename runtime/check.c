/* daft check: loads each file as the program would, and says what is wrong with it. */
#include "commands.h"

#include "cli.h"
#include "game.h"
#include "util.h"

#include <stdio.h>

static const cli_command COMMAND = {
    "check",
    "PATH...",
    "Checks scenes (.scene), meshes (.obj), materials (.mtl), pictures, recordings (.rec) and games.",
    "A game is loaded, and runs for one second without a window. Exit status 1 when anything is wrong.",
    1,
    CLI_OPERANDS};

typedef struct checker {
    daft_engine *engine;
    home where;
    font *face;
} checker;

static bool check_game(const checker *c, const char *path, daft_error *error)
{
    game_info info;
    if (!home_find_game(&c->where, path, &info, error)) return false;
    game_state play;
    game_def def = {.where = &c->where,
                    .info = &info,
                    .engine = c->engine,
                    .face = c->face,
                    .quality = DAFT_QUALITY_DRAFT,
                    .seed = 1};
    if (!game_open(&play, &def, error)) return false;
    for (int tick = 0; tick < 60 && !play.over; tick++)
        if (!game_tick(&play)) break;
    daft_image *picture = daft_image_create(c->engine, 64, 36, error);
    bool good = picture != NULL && game_draw(&play, picture, 1);
    if (picture && !good) fail(error, DAFT_ERROR_SYNTAX, "%.500s", play.scripts.message);
    daft_image_destroy(picture);
    game_close(&play);
    return good;
}

static bool check_with_scene(const checker *c, const char *path, daft_error *error)
{
    daft_scene *scene = daft_scene_create(c->engine, error);
    if (!scene) return false;
    bool good;
    if (has_extension(path, ".scene"))
        good = daft_scene_load(scene, path, error);
    else if (has_extension(path, ".obj"))
        good = daft_mesh_load(scene, path, error).id != 0;
    else
        good = daft_material_load(scene, path, error).id != 0;
    daft_scene_destroy(scene);
    return good;
}

static bool check_path(const checker *c, const char *path, daft_error *error)
{
    static const char *const in_scene[] = {".scene", ".obj", ".mtl"};
    for (size_t i = 0; i < COUNT_OF(in_scene); i++)
        if (has_extension(path, in_scene[i])) return check_with_scene(c, path, error);
    if (has_extension(path, ".rec")) {
        recording record;
        bool good = recording_load(&record, path, error);
        if (good) recording_free(&record);
        return good;
    }
    if (path_is_folder(path) || !path_is_file(path)) return check_game(c, path, error);
    daft_image *image = daft_image_load(c->engine, path, error);
    daft_image_destroy(image);
    return image != NULL;
}

static int check_all(checker *c, const char *const *paths, size_t count)
{
    daft_error error;
    if (!home_find(&c->where, &error) || !(c->face = open_font(&c->where, &error))) return report(&error);
    c->engine = open_engine(0, NULL);
    if (!c->engine) return STATUS_BAD_INPUT;
    int status = STATUS_DONE;
    for (size_t i = 0; i < count; i++) {
        error = (daft_error){0};
        bool good = check_path(c, paths[i], &error);
        if (good)
            printf("%s: good\n", paths[i]);
        else
            status = report(&error);
    }
    return status;
}

int command_check(int argc, char **argv)
{
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, NULL, 0, argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    checker c = {0};
    int status = check_all(&c, operands, count);
    font_close(c.face);
    daft_engine_destroy(c.engine);
    return status;
}
