/* The pictures of a game. A picture at time t lies between the ticks before and after t, as in a window. */
#include "video/film_game.h"

#include "common/util.h"
#include "game/loop.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static frame_result fail_script(const film_game *self, daft_error *error)
{
    fail(error, DAFT_ERROR_ARGUMENT, "%.900s", self->play.scripts.failure.message);
    return FRAME_FAILED;
}

/* A picture that nobody looks at still calls daft.draw, which may keep things for the next picture. */
static bool draw_picture(film_game *self, bool wanted, daft_image *target, float alpha)
{
    return wanted ? game_draw(&self->play, target, alpha) : game_draw_over(&self->play, target);
}

static frame_result draw(frame_source *source, double time, bool wanted, daft_image *target, daft_error *error)
{
    film_game *self = (film_game *)source;
    double ticks = time * LOOP_RATE, whole = ceil(ticks - 1e-6);
    if (self->has_replay && whole > (double)self->replay.end) return FRAME_NONE;
    while ((double)self->play.ticks < whole) {
        if (self->play.over) return FRAME_NONE;
        if (!game_tick(&self->play)) return fail_script(self, error);
    }
    float alpha = whole > 0 ? (float)(ticks - (whole - 1)) : 1;
    alpha = alpha < 0 ? 0 : alpha > 1 ? 1 : alpha;
    return draw_picture(self, wanted, target, alpha) ? FRAME_DRAWN : fail_script(self, error);
}

static bool open_replay(film_game *self, const daft_files *files, const char *path, const game_info *info,
                        daft_error *error)
{
    if (!recording_load(&self->replay, files, path, error)) return false;
    self->has_replay = true;
    if (!self->replay.game[0] || strcmp(self->replay.game, info->name) == 0) return true;
    return fail_at(error, path, 0, 0, "this is a recording of the game '%s', not of '%s'", self->replay.game,
                   info->name);
}

bool film_game_open(film_game *self, const game_def *def, const char *replay, bool inside, daft_error *error)
{
    *self = (film_game){.source.draw = draw};
    game_def play = *def;
    bool good = !replay || open_replay(self, inside ? def->source->files : NULL, replay, def->info, error);
    if (good && replay) play.replay = &self->replay, play.seed = self->replay.seed;
    good = good && game_open(&self->play, &play, error);
    if (good && self->play.failed) {
        fail_script(self, error);
        game_close(&self->play);
        good = false;
    }
    if (!good) recording_free(&self->replay);
    return good;
}

void film_game_close(film_game *self)
{
    game_close(&self->play);
    recording_free(&self->replay);
}
