/* Samples lines by the clock. See profile.h. */
#include "lua/profile.h"

#include "common/util.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The profile of the calls on this thread, for the signal handler. */
static _Thread_local profile *_Atomic active;

/* ---- noting ---- */

/* The line's place: its own, else a free one. NULL: the table is full. */
static profile_line *find_line(profile *self, const char *file, int line)
{
    const uint64_t hash = daft_hash(file, strlen(file), (uint64_t)line);
    for (size_t i = 0; i < PROFILE_LINES; i++) {
        profile_line *at = &self->lines[(hash + i) % PROFILE_LINES];
        if (at->line == 0) return self->count < PROFILE_LINES - 1 ? at : NULL;
        if (at->line == line && strncmp(at->file, file, PROFILE_FILE - 1) == 0) return at;
    }
    return NULL;
}

static void note(profile *self, lua_State *L, lua_Debug *where, uint64_t ns)
{
    self->samples++, self->ns += ns, self->recent_ns += ns;
    if (!lua_getinfo(L, "Sl", where) || where->currentline <= 0) return;
    profile_line *at = find_line(self, where->short_src, where->currentline);
    if (!at) return;
    if (at->line == 0) {
        self->count++;
        at->line = where->currentline;
        snprintf(at->file, sizeof at->file, "%s", where->short_src);
        if (lua_getinfo(L, "n", where) && where->name) snprintf(at->function, sizeof at->function, "%s", where->name);
    }
    at->samples++, at->ns += ns, at->recent_ns += ns;
}

/* Before the next instruction of the state that the handler met. */
static void on_sample(lua_State *L, lua_Debug *where)
{
    profile *self = atomic_load(&active);
    lua_sethook(L, NULL, 0, 0);
    const uint64_t ns = self ? atomic_exchange(&self->pending_ns, 0) : 0;
    if (ns > 0) note(self, L, where, ns);
}

/* lua_sethook is made for signal handlers. */
static void on_signal(int unused)
{
    (void)unused;
    const profile *self = atomic_load(&active);
    lua_State *_Atomic *running = self ? atomic_load(&self->running) : NULL;
    lua_State *L = running ? atomic_load(running) : NULL;
    if (L && !lua_gethook(L)) lua_sethook(L, on_sample, LUA_MASKCOUNT, 1);
}

/* ---- the thread ---- */

/* Between 0.7 and 1.3 milliseconds. */
static long next_interval(uint32_t *random)
{
    *random = *random * 1664525u + 1013904223u;
    return 700000 + (long)(*random >> 8) % 600000;
}

static void *run(void *user)
{
    profile *self = user;
    uint32_t random = 1;
    for (uint64_t last = clock_now_ns(); !atomic_load(&self->ends);) {
        const struct timespec pause = {0, next_interval(&random)};
        nanosleep(&pause, NULL);
        const uint64_t now = clock_now_ns();
        if (atomic_load(&self->running)) {
            atomic_fetch_add(&self->pending_ns, now - last);
            pthread_kill(self->watched, SIGPROF);
        }
        last = now;
    }
    return NULL;
}

bool profile_start(profile *self, daft_error *error)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    if (self->on) return true;
    if (!self->lines) self->lines = calloc(PROFILE_LINES, sizeof *self->lines);
    self->watched = pthread_self();
    atomic_store(&self->ends, false);
    if (!self->lines || sigaction(SIGPROF, &action, NULL) != 0 || pthread_create(&self->thread, NULL, run, self) != 0)
        return fail(error, DAFT_ERROR_MEMORY, "no thread can be made to look at the game's lines");
    return self->on = true;
}

void profile_stop(profile *self)
{
    if (!self->on) return;
    atomic_store(&self->ends, true);
    pthread_join(self->thread, NULL);
    atomic_store(&active, NULL);
    self->on = false;
}

void profile_free(profile *self)
{
    profile_stop(self);
    free(self->lines);
    *self = (profile){0};
}

/* ---- calls ---- */

void profile_enter(profile *self, lua_State *_Atomic *running)
{
    if (!self || !self->on) return;
    self->began_ns = clock_now_ns();
    atomic_store(&self->pending_ns, 0);
    atomic_store(&active, self);
    atomic_store(&self->running, running);
}

void profile_leave(profile *self)
{
    if (!self || !self->on || !atomic_load(&self->running)) return;
    atomic_store(&self->running, NULL);
    self->call_ns += clock_now_ns() - self->began_ns;
}

/* ---- what was found ---- */

static uint64_t weight(const profile_line *line, bool recent) { return recent ? line->recent_ns : line->ns; }

/* Lines of equal weight in the order of their names, so that they do not change places. */
static bool comes_first(const profile_line *a, const profile_line *b, bool recent)
{
    if (weight(a, recent) != weight(b, recent)) return weight(a, recent) > weight(b, recent);
    const int order = strcmp(a->file, b->file);
    return order ? order < 0 : a->line < b->line;
}

size_t profile_top(const profile *self, bool recent, profile_line *out, size_t most)
{
    size_t count = 0;
    for (size_t i = 0; self->lines && i < PROFILE_LINES; i++) {
        const profile_line *line = &self->lines[i];
        if (line->line == 0 || weight(line, recent) == 0) continue;
        if (count == most && !comes_first(line, &out[most - 1], recent)) continue;
        size_t at = count < most ? count++ : most - 1;
        for (; at > 0 && comes_first(line, &out[at - 1], recent); at--) out[at] = out[at - 1];
        out[at] = *line;
    }
    return count;
}

void profile_fade(profile *self)
{
    self->recent_ns = self->recent_ns * 3 / 4;
    for (size_t i = 0; self->lines && i < PROFILE_LINES; i++)
        self->lines[i].recent_ns = self->lines[i].recent_ns * 3 / 4;
}
