/* Files that are saved while the game runs. */
#include "session/state.h"

#include "common/util.h"

#include <stdio.h>

/* A recording ends where daft.reload has put the game: no input leads from the start to there. */
static void tell(session *s, bool handed, uint64_t now)
{
    daft_error error;
    const bool ends = handed && s->record;
    if (ends && !recorder_finish(s->record, &error)) report(&error);
    snprintf(s->notice, sizeof s->notice, ends ? "Reloaded: the recording ends here" : "Reloaded");
    s->notice_ns = now + (ends ? 4000000000u : 1500000000u);
}

/* What changed on the disk is what is played from here on. */
bool session_take_changes(session *s, daft_error *error)
{
    platform *screen = s->def->screen;
    const uint64_t now = screen->now_ns(screen);
    if (s->notice_ns && now > s->notice_ns) s->notice[0] = 0, s->notice_ns = 0;
    if (!s->def->watches || !watch_changed(&s->files, now)) return true;
    game_state *fresh = s->play == s->games ? &s->games[1] : s->games;
    daft_error why;
    const relive_end end = relive(s->play, fresh, &s->past, s->notice, &why);
    switch (end) {
    case RELIVE_HANDED:
    case RELIVE_DONE:
        s->play = fresh, s->reported = false;
        tell(s, end == RELIVE_HANDED, now);
        daft_history_destroy(s->history);
        s->history = daft_history_create(s->play->def.engine, error);
        if (s->time.line) timeline_forget(s->time.line, s->play);
        s->play->def.history = s->history;
        break;
    case RELIVE_LONG:
        if (s->play->failed)
            s->wants_reload = true;
        else
            session_restart(s);
        snprintf(s->notice, sizeof s->notice, "Reloaded, from the start: it has been played for too long");
        s->notice_ns = now + 4000000000u;
        break;
    case RELIVE_FAILED:
        fprintf(stderr, "daft: %s\n", s->notice);
        s->notice_ns = 0;
        break;
    }
    s->last_ns += screen->now_ns(screen) - now; /* the time it took is not the game's */
    return s->history != NULL;
}
