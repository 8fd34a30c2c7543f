/* Compares a replay with the states that its recording came to. */
#include "game/agree.h"

#include "game/fingerprint.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INDEX_MASK = (1 << 20) - 1 };

/* By entities' places, and then the latest first. */
static int compare(const void *a, const void *b)
{
    const recording_mark *x = a, *y = b;
    const uint32_t i = x->entity & INDEX_MASK, j = y->entity & INDEX_MASK;
    if (i != j) return i < j ? -1 : 1;
    if (x->tick != y->tick) return x->tick > y->tick ? -1 : 1;
    return x->entity > y->entity ? -1 : x->entity < y->entity; /* the place was given anew */
}

static const char *name_of(const daft_scene *scene, uint32_t entity)
{
    daft_named_entity named;
    for (uint32_t i = 0; i < daft_scene_named_count(scene); i++)
        if (daft_scene_get_named(scene, i, &named, NULL) && named.entity.id == entity) return named.name;
    return "";
}

static bool differs(daft_scene *scene, const recording_mark *mark, char out[160])
{
    char fields[80];
    const char *name = name_of(scene, mark->entity);
    const int used = snprintf(out, 160, "entity 0x%" PRIx32 "%s%.40s%s", mark->entity, name[0] ? " '" : "", name,
                              name[0] ? "'" : "");
    char *end = out + used;
    const bool there = daft_entity_is_valid(scene, (daft_entity){mark->entity});
    const uint32_t now = there ? fingerprint(scene, (daft_entity){mark->entity}) : 0;
    if (there == mark->gone)
        snprintf(end, 160 - (size_t)used, there ? " should be gone" : " is gone");
    else if (there && now != mark->print)
        snprintf(end, 160 - (size_t)used, " differs in %s", fingerprint_name(now ^ mark->print, fields, sizeof fields));
    else
        return false;
    return true;
}

/* The first entity that is not as the recording told it, after this tick. Where a line was full only what stands in it
 * is known to be of this tick. */
static bool first_entity(daft_scene *scene, const recording *record, uint64_t tick, char out[160])
{
    size_t end = record->mark_count, first;
    while (end > 0 && record->marks[end - 1].tick > tick) end--;
    for (first = end; first > 0 && record->marks[first - 1].tick == tick;) first--;
    if (end - first < RECORDING_MARKS) first = 0;
    const size_t count = end - first;
    recording_mark *marks = count ? malloc(count * sizeof *marks) : NULL;
    if (!marks) return false;
    memcpy(marks, record->marks + first, count * sizeof *marks);
    qsort(marks, count, sizeof *marks, compare);
    bool found = false;
    for (size_t i = 0; i < count && !found; i++)
        if (i == 0 || (marks[i].entity & INDEX_MASK) != (marks[i - 1].entity & INDEX_MASK))
            found = differs(scene, &marks[i], out);
    free(marks);
    return found;
}

static bool tell(agreement *self, const recording *record, uint64_t ticks, daft_scene *scene, bool exact,
                 char message[AGREE_TEXT])
{
    char entity[160];
    self->told = true;
    int used = snprintf(message, AGREE_TEXT, "the replay is not what was recorded: %s tick %" PRIu64,
                        exact ? "it parts in" : "it has parted before", self->from);
    if (ticks % RECORDING_SECOND == 0)
        snprintf(message + used, AGREE_TEXT - (size_t)used, "; after tick %" PRIu64 " %s", ticks,
                 first_entity(scene, record, ticks, entity)
                     ? entity
                     : "no entity that the recording tells of differs: random numbers, lights, the camera, or another");
    return false;
}

bool agree(agreement *self, const recording *record, uint64_t ticks, uint64_t hash, daft_scene *scene,
           char message[AGREE_TEXT])
{
    while (self->state < record->state_count && record->states[self->state].tick < ticks) self->state++;
    if (self->told || self->state == record->state_count) return true;
    const recording_state *state = &record->states[self->state];
    const uint64_t left = state->tick - ticks;
    const bool known = left < state->count;
    if (!self->from && known && state->ticks[state->count - 1 - left] != (uint16_t)hash) self->from = ticks;
    if (left > 0 || (!self->from && state->hash == hash)) return true;
    const bool exact = self->from != 0;
    if (!exact) self->from = ticks;
    return tell(self, record, ticks, scene, exact, message);
}
