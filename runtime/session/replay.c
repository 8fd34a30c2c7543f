/* The recordings of a session, the one it replays and the one it makes, and how fast it goes. */
#include "session/state.h"

#include "common/util.h"
#include "files/content.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static double limit_seconds(const session *s) { return s->def->seconds > 0 ? s->def->seconds : WATCHDOG_SECONDS; }

/* What is different from when it was recorded; empty: nothing that is known. */
static const char *find_changes(session *s, const char *content, char *out, size_t size)
{
    const recording *r = &s->replay;
    const uint64_t memory = daft_engine_memory(s->def->engine).limit;
    out[0] = 0;
    if (r->content[0] ? strcmp(r->content, content) != 0 : r->pack[0] && strcmp(r->pack, s->source->hash) != 0)
        snprintf(out, size, "it was recorded with another version of the game, SHA-256 %s",
                 r->content[0] ? r->content : r->pack);
    else if (r->memory && r->memory != memory)
        snprintf(out, size, "it was recorded with --memory-limit %" PRIu64 ", not %" PRIu64, r->memory, memory);
    else if (r->memory && (float)r->seconds != (float)limit_seconds(s))
        snprintf(out, size, "it was recorded with --time-limit %g, not %g", r->seconds, limit_seconds(s));
    return out;
}

static bool open_replay(session *s, const char *content, daft_error *error)
{
    const session_def *def = s->def;
    char changes[300], name[PATH_SIZE];
    if (s->replay.game[0] && strcmp(s->replay.game, s->info->name) != 0)
        return fail_at(error, def->replay, 0, 0, "this is a recording of the game '%s', not of '%s'", s->replay.game,
                       s->info->name);
    daft_escape(def->replay, name, sizeof name);
    if (find_changes(s, content, changes, sizeof changes)[0] && def->strict)
        return fail_at(error, def->replay, 0, 0, "%s", changes);
    if (changes[0]) fprintf(stderr, "daft: %s: %s: it may play differently\n", name, changes);
    if (def->strict && s->replay.end > 0 && s->replay.state_count == 0)
        return fail_at(error, def->replay, 0, 0, "it holds no states to compare with: record it anew for --strict");
    if (s->replay.cut)
        fprintf(stderr, "daft: %s was cut short: it plays up to tick %" PRIu64 "\n", name, s->replay.end);
    return true;
}

bool session_open_replay(session *s, daft_error *error)
{
    const session_def *def = s->def;
    char content[SHA256_TEXT] = "";
    if (def->replay && !recording_load(&s->replay, def->replay_inside ? s->source->files : NULL, def->replay, error))
        return false;
    if ((def->record || s->replay.content[0]) && !content_hash(s->source, s->info, content, error)) return false;
    if (def->replay && !open_replay(s, content, error)) return false;
    if (!def->record) return true;
    const recording_head head = {.game = s->info->name,
                                 .pack = s->source->hash,
                                 .content = content,
                                 .seed = def->replay ? s->replay.seed : def->seed,
                                 .memory = daft_engine_memory(def->engine).limit,
                                 .seconds = limit_seconds(s)};
    s->record = recorder_open(def->record, &head, error);
    return s->record != NULL;
}

void session_required(void *user, const char *name, const char *text, size_t size)
{
    session *s = user;
    recording_script *script = &s->scripts[s->script_count];
    if (s->script_count == RECORDING_SCRIPTS || strlen(name) >= sizeof script->name) return;
    for (size_t i = 0; i < s->script_count; i++)
        if (strcmp(s->scripts[i].name, name) == 0) return; /* the game has begun again */
    sha256 hash;
    sha256_begin(&hash);
    sha256_add(&hash, text, size);
    sha256_end(&hash, script->content);
    snprintf(script->name, sizeof script->name, "%s", name);
    s->script_count++;
    recorder_script(s->record, script);
}

static bool is_as_recorded(const recording *r, const recording_script *script)
{
    for (size_t i = 0; i < r->script_count; i++)
        if (strcmp(r->scripts[i].name, script->name) == 0) return strcmp(r->scripts[i].content, script->content) == 0;
    return true;
}

bool session_compare_scripts(session *s, daft_error *error)
{
    for (; s->script_told < s->script_count; s->script_told++) {
        const recording_script *script = &s->scripts[s->script_told];
        char name[PATH_SIZE];
        if (is_as_recorded(&s->replay, script)) continue;
        if (s->def->strict)
            return fail_at(error, s->def->replay, 0, 0, "it was recorded with another version of scripts/%s.lua",
                           script->name);
        fprintf(stderr, "daft: %s: it was recorded with another version of scripts/%s.lua: it may play differently\n",
                daft_escape(s->def->replay, name, sizeof name), script->name);
    }
    return true;
}

/* Whether the replay still does what was recorded. */
bool session_compare(session *s, daft_error *error)
{
    char message[AGREE_TEXT];
    if (!session_compare_scripts(s, error)) return false;
    if (!s->def->replay || s->replay.state_count == 0 || s->play->ticks > s->replay.end) return true;
    if (agree(&s->agreed, &s->replay, s->play->ticks, game_hash(s->play), s->play->scene, message)) return true;
    if (s->def->strict) return fail_at(error, s->def->replay, 0, 0, "%s", message);
    progress_end(&s->bar);
    fprintf(stderr, "daft: %s: %s\n", s->def->replay, message);
    snprintf(s->notice, sizeof s->notice, "%s", message);
    s->notice_ns = s->def->screen->now_ns(s->def->screen) + 8000000000u;
    return true;
}

uint64_t session_last_tick(const session *s)
{
    if (s->def->ticks) return s->def->ticks;
    return s->def->replay && s->def->screen->headless ? s->replay.end : UINT64_MAX;
}

/* ---- speed ---- */

double session_speed(const session *s) { return s->def->speed > 0 && game_is_replaying(s->play) ? s->def->speed : 1; }

/* Updates that are due after so many nanoseconds. */
int session_updates_due(session *s, uint64_t elapsed)
{
    const double speed = session_speed(s);
    if (speed == 1 || s->def->screen->headless || isinf(speed)) return loop_advance(&s->clock, elapsed);
    const int parts = 1 + (int)(speed / 2); /* none so long that updates are dropped, unless frames are slow */
    int updates = 0;
    for (int i = 0; i < parts; i++) updates += loop_advance(&s->clock, (uint64_t)((double)elapsed * speed / parts));
    return updates;
}

/* Without a window no clock but this one holds a replay back. */
void session_keep_pace(session *s)
{
    if (!s->def->screen->headless || s->def->speed <= 0 || isinf(s->def->speed)) return;
    const uint64_t due = s->began_ns + (uint64_t)((double)s->play->ticks * 1e9 / LOOP_RATE / s->def->speed);
    const uint64_t now = clock_now_ns();
    if (due <= now) return;
    const struct timespec rest = {(time_t)((due - now) / 1000000000u), (long)((due - now) % 1000000000u)};
    nanosleep(&rest, NULL);
}
