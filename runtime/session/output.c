/* What a session leaves: hashes, pictures, figures and errors. */
#include "session/state.h"

#include "common/util.h"

#include <inttypes.h>
#include <stdio.h>
#include <time.h>

enum { HASH_TICKS = 60 };

static bool print_hash(session *s, daft_error *error)
{
    if (!session_draw(s, 1, error)) return false;
    if (s->play->failed) return true;
    size_t size = 4 * (size_t)daft_image_width(s->picture) * (size_t)daft_image_height(s->picture);
    printf("tick %" PRIu64 " state 0x%016" PRIx64 " frame 0x%016" PRIx64 "\n", s->play->ticks, game_hash(s->play),
           daft_hash(daft_image_pixels(s->picture), size, 0));
    fflush(stdout);
    s->hashed = s->play->ticks;
    return true;
}

static bool take_shot(session *s, const char *path, daft_error *error)
{
    if (!session_draw(s, 1, error)) return false;
    return s->play->failed || daft_image_write(s->picture, path, error);
}

bool session_after_tick(session *s, daft_error *error)
{
    uint64_t tick = s->play->ticks;
    if (!session_compare(s, error)) return false;
    if (s->time.line) timeline_keep(s->time.line);
    if (s->def->hash && tick % HASH_TICKS == 0 && !print_hash(s, error)) return false;
    if (s->def->shot && s->def->shot_tick == tick) {
        s->shot_done = tick;
        if (!take_shot(s, s->def->shot, error)) return false;
    }
    return true;
}

bool session_at_end(session *s, daft_error *error)
{
    if (s->play->failed) return true;
    if (s->def->hash && (s->hashed != s->play->ticks || s->play->ticks == 0) && !print_hash(s, error)) return false;
    if (s->def->shot && s->def->shot_tick == 0 && !take_shot(s, s->def->shot, error)) return false;
    if (s->def->shot && s->def->shot_tick > 0 && s->shot_done == 0)
        return fail(error, DAFT_ERROR_ARGUMENT, "--shot-tick %" PRIu64 ": the game ended at tick %" PRIu64,
                    s->def->shot_tick, s->play->ticks);
    /* Without a window few pictures are drawn: a broken daft.draw is not to go unseen. */
    if (s->def->screen->headless && s->play->ticks > 0 && s->drawn != s->play->ticks && !session_draw(s, 1, error))
        return false;
    if (!s->def->stats) return true;
    if (s->times.count == 0 && !session_draw(s, 1, error)) return false;
    s->times.memory = daft_engine_memory(s->play->def.engine);
    s->times.simulation = daft_scene_sim_counters(s->play->scene);
    return s->play->failed || stats_write(s->def->stats, daft_scene_counters(s->play->scene), &s->times, error);
}

/* Writes a picture to the current folder, named by the time. */
void session_user_shot(session *s)
{
    char name[64];
    time_t now = time(NULL);
    struct tm parts;
    localtime_r(&now, &parts);
    strftime(name, sizeof name, "daft-%Y%m%d-%H%M%S.png", &parts);
    daft_error error;
    if (s->picture && daft_image_write(s->picture, name, &error))
        fprintf(stderr, "daft: wrote %s\n", name);
    else if (s->picture)
        report(&error);
}

void session_report(session *s)
{
    if (!s->play->failed || s->reported || s->play->scripts.asked) return;
    progress_end(&s->bar);
    fflush(stdout);
    char text[FAILURE_TEXT];
    fprintf(stderr, "daft: %s", failure_text(&s->play->scripts.failure, text, sizeof text));
    s->reported = true;
}
