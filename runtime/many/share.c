/* Hands out the pieces of a job. */
#include "many/share.h"

#include <stdlib.h>
#include <string.h>

enum { WINDOW = 16, WINDOW_EACH = 4 };

uint64_t share_window(int processes) { return WINDOW + WINDOW_EACH * (uint64_t)processes; }

bool share_open(share *self, const share_def *def)
{
    *self = (share){.def = *def, .count = def->count};
    self->groups = (def->count + def->group - 1) / def->group;
    self->skip = calloc(def->count + 1, sizeof *self->skip);
    self->group = calloc(self->groups + 1, sizeof *self->group);
    self->busy = calloc((size_t)def->processes, sizeof *self->busy);
    self->at = calloc((size_t)def->processes, sizeof *self->at);
    if (!self->skip || !self->group || !self->busy || !self->at) {
        share_close(self);
        return false;
    }
    for (uint64_t i = 0; i < self->groups; i++) self->group[i].next = i * def->group;
    for (int i = 0; i < def->processes; i++) self->at[i] = self->groups;
    return true;
}

void share_close(share *self)
{
    free(self->skip);
    free(self->group);
    free(self->busy);
    free(self->at);
    *self = (share){0};
}

void share_skip(share *self, uint64_t piece)
{
    if (self->skip[piece]) return;
    self->skip[piece] = 1;
    self->done++;
}

static uint64_t end_of(const share *self, uint64_t group)
{
    uint64_t end = (group + 1) * self->def.group;
    return end < self->count ? end : self->count;
}

/* Pieces of the group that nobody was given. */
static uint64_t left(share *self, uint64_t group)
{
    share_group *g = &self->group[group];
    uint64_t end = end_of(self, group);
    while (g->next < end && self->skip[g->next]) g->next++;
    return g->next < end ? end - g->next : 0;
}

static bool opens(share *self, uint64_t *group)
{
    while (self->open < self->groups && left(self, self->open) == 0) self->open++;
    *group = self->open;
    return self->open < self->groups;
}

/* The group that has most left for each process at it. */
static bool helps(share *self, int process, uint64_t *group)
{
    if (self->def.group == 1) return false; /* whoever opens a group has all of it */
    uint64_t mine = self->at[process], from = self->def.ascending && mine < self->groups ? mine + 1 : 0, most = 0;
    for (uint64_t i = from; i < self->open; i++) {
        uint64_t each = left(self, i) / (self->group[i].hands + 1);
        if (each <= most) continue;
        most = each;
        *group = i;
    }
    return most > 0;
}

/* Where the process goes on: where it is, or a new group, or somebody else's. */
static bool find_group(share *self, int process, uint64_t *group)
{
    uint64_t mine = self->at[process];
    *group = mine;
    if (mine < self->groups && left(self, mine) > 0) return true;
    bool fresh = opens(self, group);
    if (!fresh && !helps(self, process, group)) return false;
    if (fresh) self->group[self->open++].keeper = (uint32_t)process;
    if (mine < self->groups) self->group[mine].hands--;
    self->group[*group].hands++;
    self->at[process] = *group;
    return true;
}

static bool give_to(share *self, int process, share_work *out)
{
    uint64_t number;
    if (!find_group(self, process, &number)) return false;
    share_group *g = &self->group[number];
    if (g->waiting >= share_window((int)g->hands)) return false;
    *out = (share_work){.process = process, .keeper = (int)g->keeper, .piece = g->next++};
    g->waiting++;
    self->busy[process]++;
    return true;
}

bool share_give(share *self, share_work *out)
{
    for (int ahead = 0; ahead < SHARE_AHEAD; ahead++)
        for (int i = 0; i < self->def.processes; i++)
            if (self->busy[i] == ahead && give_to(self, i, out)) return true;
    return false;
}

void share_made(share *self, int process) { self->busy[process]--; }

void share_taken(share *self, uint64_t piece)
{
    self->group[piece / self->def.group].waiting--;
    self->done++;
}

void share_shorten(share *self, uint64_t count)
{
    if (count >= self->count) return;
    for (uint64_t i = count; i < self->count; i++) self->done -= self->skip[i];
    self->count = count;
}

void share_none(share *self, int process, uint64_t piece)
{
    share_made(self, process);
    self->group[piece / self->def.group].waiting--;
    share_shorten(self, piece);
}

bool share_finished(const share *self) { return self->done >= self->count; }
