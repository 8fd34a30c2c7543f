/* Checks recordings against their game, and runs a game for one second. */
#include "cli/check/names.h"

#include "cli/commands.h"
#include "game/game.h"
#include "common/util.h"

#include <stdlib.h>
#include <string.h>

bool check_need_home(checker *c)
{
    if (c->has_home) return true;
    daft_error error;
    if (home_find(&c->where, &error) && (c->face = open_font(&c->where, &error))) return c->has_home = true;
    check_problem(c, DAFT_SEVERITY_ERROR, &error);
    return false;
}

void check_recording(checker *c, const char *path, const char *game)
{
    recording record;
    daft_error error;
    if (!recording_load(&record, c->game.files, path, &error)) {
        check_problem(c, DAFT_SEVERITY_ERROR, &error);
        return;
    }
    if (game && record.game[0] && strcmp(record.game, game) != 0)
        check_add(c, DAFT_SEVERITY_WARNING, path, 0, 0, "a recording of the game '%s', in the folder of '%s'",
                  record.game, game);
    if (record.end == 0) check_add(c, DAFT_SEVERITY_WARNING, path, 0, 0, "the recording has no ticks");
    recording_free(&record);
}

/* Maps Lua's "NAME/file.lua:12: text" to the path of the file. */
static void report_script_error(checker *c, const game_info *info, const char *message)
{
    const char *colon = strstr(message, ".lua:");
    char file[PATH_SIZE], path[PATH_SIZE] = "";
    size_t length = colon ? (size_t)(colon - message) + 4 : 0, name = strlen(info->name);
    if (length > 0 && length < sizeof file) {
        memcpy(file, message, length);
        file[length] = 0;
        bool fits = false;
        if (strncmp(file, info->name, name) == 0 && file[name] == '/')
            fits = path_join(path, sizeof path, info->folder, file + name + 1);
        else if (strncmp(file, "scripts/", 8) == 0)
            fits = path_join(path, sizeof path, c->where.scripts, file + 8);
        if (!fits) path[0] = 0;
    }
    char *end = NULL;
    long line = path[0] ? strtol(message + length + 1, &end, 10) : 0;
    if (path[0] && end && strncmp(end, ": ", 2) == 0)
        check_add(c, DAFT_SEVERITY_ERROR, path, (int)line, 0, "%s", end + 2);
    else
        check_add(c, DAFT_SEVERITY_ERROR, info->folder, 0, 0, "%s", message);
}

static bool run(game_state *play, daft_image *picture)
{
    for (int tick = 0; tick < 60 && !play->over; tick++)
        if (!game_tick(play)) return false;
    return game_draw(play, picture, 1);
}

static void run_on(checker *c, daft_engine *engine, const game_info *info)
{
    daft_error error;
    game_state play;
    game_def def = {.where = &c->where,
                    .info = info,
                    .source = &c->game,
                    .engine = engine,
                    .face = c->face,
                    .quality.preset = DAFT_PRESET_DRAFT,
                    .seed = 1};
    daft_image *picture = daft_image_create(engine, 64, 36, &error);
    if (!picture || !game_open(&play, &def, &error)) {
        check_problem(c, DAFT_SEVERITY_ERROR, &error);
    } else {
        const bool good = run(&play, picture);
        if (good && c->names) names_take_globals(c->names, play.scripts.L);
        if (!good) report_script_error(c, info, play.scripts.failure.message);
        game_close(&play);
    }
    daft_image_destroy(picture);
}

/* With an engine of its own, whose memory has the limit of daft play. */
void check_run_game(checker *c, const game_info *info)
{
    daft_engine_def def = daft_default_engine_def();
    def.warn = check_warning;
    def.warn_user = c;
    def.memory_limit = HOST_MEMORY;
    daft_error error;
    daft_engine *engine = daft_engine_create(&def, &error);
    if (engine)
        run_on(c, engine, info);
    else
        check_problem(c, DAFT_SEVERITY_ERROR, &error);
    daft_engine_destroy(engine);
}
