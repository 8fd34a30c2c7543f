/* Any bytes as a recording: what loads plays without harm, and written and read again it is the same. */
#include "fuzz.h"

#include "game/recording.h"

#include <math.h>
#include <string.h>

static void play(recording *record)
{
    static input state;
    memset(&state, 0, sizeof state);
    for (uint64_t tick = 0; tick < record->end && tick < 100; tick++) {
        input_begin_tick(&state);
        recording_play(record, tick, &state);
        FUZZ_CHECK(state.applied_count <= INPUT_QUEUE);
    }
    FUZZ_CHECK(record->next <= record->count);
}

static void write_again(const recording *record, const char *path)
{
    daft_error error;
    recorder *writer = recorder_open(
        path,
        &(recording_head){.game = record->game, .pack = record->pack, .content = record->content, .seed = record->seed},
        &error);
    FUZZ_CHECK(writer);
    for (size_t i = 0; i < record->count; i++) recorder_tick(writer, record->items[i].tick, &record->items[i].event, 1);
    if (record->end > 0) recorder_tick(writer, record->end - 1, NULL, 0);
    FUZZ_CHECK(recorder_finish(writer, &error));
    recorder_free(writer);
}

static void check_equal(const recording *a, const recording *b)
{
    FUZZ_CHECK(strcmp(a->game, b->game) == 0 && a->seed == b->seed && a->end == b->end && a->count == b->count);
    for (size_t i = 0; i < a->count; i++) {
        const input_event *x = &a->items[i].event, *y = &b->items[i].event;
        FUZZ_CHECK(a->items[i].tick == b->items[i].tick && x->kind == y->kind && x->key == y->key &&
                   x->down == y->down);
        FUZZ_CHECK(memcmp(&x->x, &y->x, sizeof x->x) == 0 && memcmp(&x->y, &y->y, sizeof x->y) == 0);
    }
}

int recording_input(const uint8_t *data, size_t size)
{
    recording record = {0}, again = {0};
    daft_error error = {0};
    bool good = recording_load(&record, NULL, fuzz_write("input.rec", data, size), &error);
    fuzz_check_error(good, &error);
    if (!good) return 0;
    for (size_t i = 0; i < record.count; i++)
        FUZZ_CHECK(isfinite(record.items[i].event.x) && isfinite(record.items[i].event.y) &&
                   record.items[i].tick < record.end);
    play(&record);
    if (record.game[0]) { /* one without a game's name cannot be written as it is */
        const char *path = fuzz_write("again.rec", "", 0);
        write_again(&record, path);
        FUZZ_CHECK(recording_load(&again, NULL, path, &error));
        check_equal(&record, &again);
    }
    recording_free(&record);
    recording_free(&again);
    return 0;
}
