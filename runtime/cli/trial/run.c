/* Runs the tests of a file, each in a game that begins anew, so that none hangs on another. */
#include "cli/trial/trial.h"

#include "common/util.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

typedef struct outcome {
    char why[FAILURE_TEXT]; /* empty: passed */
    uint64_t ticks;
} outcome;

static void fail_script(outcome *out, const game_state *play)
{
    const failure *told = &play->scripts.failure;
    size_t used = (size_t)snprintf(out->why, sizeof out->why, "%s", told->message);
    if (!told->trace[0]) return;
    for (const char *at = told->trace; *at && used + 8 < sizeof out->why; at++) { /* indented */
        if (at == told->trace || at[-1] == '\n')
            used += (size_t)snprintf(out->why + used, sizeof out->why - used, "%s      ", used ? "\n" : "");
        if (*at != '\n') out->why[used++] = *at, out->why[used] = 0;
    }
}

static void look_at_pictures(trials *t, game_state *play, trial *self, outcome *out)
{
    for (size_t i = 0; i < self->picture_count && !out->why[0]; i++) {
        if (!game_draw(play, t->picture, 1))
            fail_script(out, play);
        else
            trials_compare(t, &self->pictures[i], out->why, sizeof out->why);
    }
    self->picture_count = 0;
}

/* From the test's beginning to its end. */
static void play_on(trials *t, game_state *play, trial *self, outcome *out)
{
    look_at_pictures(t, play, self, out);
    while (self->runs && !out->why[0]) {
        if (play->ticks == t->max_ticks) {
            snprintf(out->why, sizeof out->why, "it did not end within %" PRIu64 " ticks (--ticks)", t->max_ticks);
        } else if (!game_tick(play)) {
            fail_script(out, play);
        } else if (play->scripts.trial != self) {
            snprintf(out->why, sizeof out->why, "the game began anew (daft.restart), which ends the test");
        } else {
            trial_look(&play->scripts, self);
            look_at_pictures(t, play, self, out);
            if (play->over && self->runs && !out->why[0])
                snprintf(out->why, sizeof out->why, "the game ended (daft.quit) before the test did");
        }
    }
    out->ticks = play->ticks;
}

static bool is_wanted(const trials *t, const char *file, const trial *self)
{
    char full[PATH_SIZE];
    snprintf(full, sizeof full, "%s: %s", file, self->name);
    return !t->filter || strstr(full, t->filter);
}

static void tell(trials *t, const char *file, const trial *self, const outcome *out)
{
    if (out->why[0])
        printf("FAIL  %s: %s\n      %s\n", file, self->name[0] ? self->name : "(the file)", out->why);
    else
        printf("ok    %s: %s (%" PRIu64 " ticks)\n", file, self->name, out->ticks);
    t->passed += !out->why[0];
    t->failed += out->why[0] != 0;
    fflush(stdout);
}

/* In a game that has been opened. */
static void run_in(trials *t, game_state *play, trial *self, const char *file)
{
    char within[PATH_SIZE];
    outcome out = {.why = ""};
    snprintf(within, sizeof within, "tests/%s", file);
    const bool good = !play->failed && trial_begin(&play->scripts, self, within);
    if (good && !self->name[0]) {
        if (self->count > 0) return;
        snprintf(out.why, sizeof out.why, "the file has no test: daft.test(name, function) names one");
    }
    if (good && self->name[0] && !is_wanted(t, file, self)) return;
    if (good && t->lists) {
        printf("%s: %s\n", file, self->name);
        return;
    }
    if (!good)
        fail_script(&out, play);
    else if (self->name[0])
        play_on(t, play, self, &out);
    tell(t, file, self, &out);
}

bool trials_run_file(trials *t, const char *file, daft_error *error)
{
    const game_def def = {.where = &t->where,
                          .info = &t->info,
                          .source = &t->source,
                          .engine = t->engine,
                          .face = t->face,
                          .quality = {.preset = t->quality},
                          .seed = 1};
    trial self = {.count = 1};
    for (size_t wanted = 0; wanted < self.count; wanted++) {
        game_state play;
        self = (trial){.wanted = wanted};
        if (!game_open(&play, &def, error)) return false;
        run_in(t, &play, &self, file);
        game_close(&play);
    }
    return true;
}
