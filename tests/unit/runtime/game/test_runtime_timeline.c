/* runtime: a heap that goes back to its images, and a game that goes back and forth in time. The slow, obvious twin is
 * the straight run: the same game, played once, with the state's hash of each tick. */
#include "cli/commands.h"
#include "game/heap.h"
#include "game/timeline.h"
#include "common/util.h"
#include "files/saves.h"
#include "runtime_program.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <sys/stat.h>
#include <unistd.h>

static uint64_t draw_state = 1;

static uint32_t draw(uint32_t below)
{
    draw_state = draw_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(draw_state >> 33) % below;
}

/* ---- the heap ---- */

enum { BLOCKS = 400 };

typedef struct block {
    unsigned char *bytes; /* NULL: none */
    size_t size, alignment;
    unsigned char value;
} block;

static void change_blocks(const daft_allocator *from, block *blocks, int times)
{
    while (times--) {
        block *b = &blocks[draw(BLOCKS)];
        from->release(from->user, b->bytes);
        *b = (block){
            .size = 1 + draw(1u << draw(18)), .alignment = (size_t)1 << draw(7), .value = (unsigned char)draw(256)};
        assert_non_null(b->bytes = from->allocate(from->user, b->size, b->alignment));
        assert_true((uintptr_t)b->bytes % b->alignment == 0);
        memset(b->bytes, b->value, b->size);
    }
}

/* No block was written to by way of another. */
static void check_blocks(const block *blocks)
{
    for (int i = 0; i < BLOCKS; i++)
        for (size_t k = 0; blocks[i].bytes && k < blocks[i].size; k++)
            if (blocks[i].bytes[k] != blocks[i].value) fail_msg("block %d differs in byte %zu", i, k);
}

static void images_bring_back_what_was(void **unused)
{
    (void)unused;
    enum { IMAGES = 12 };
    static block now[BLOCKS], then[IMAGES][BLOCKS];
    heap_image *images[IMAGES];
    daft_error error;
    heap *h = heap_open((uint64_t)1 << 30, &error);
    assert_non_null(h);
    for (int i = 0; i < IMAGES; i++) {
        change_blocks(heap_allocator(h), now, i ? 40 : 2000);
        assert_non_null(images[i] = heap_keep(h));
        memcpy(then[i], now, sizeof now);
    }
    const uint64_t bytes = heap_image_bytes(h);
    assert_true(bytes >= heap_used(h) && bytes < 6 * heap_used(h)); /* they share pages */
    for (int times = 0; times < 60; times++) {
        const uint32_t i = draw(IMAGES);
        heap_put_back(h, images[i]);
        memcpy(now, then[i], sizeof now);
        check_blocks(now);
        change_blocks(heap_allocator(h), now, 20); /* and on from there */
        check_blocks(now);
    }
    for (int i = 0; i < IMAGES; i++) heap_image_free(h, images[i]);
    assert_true(heap_image_bytes(h) == 0);
    assert_null(heap_allocator(h)->allocate(heap_allocator(h)->user, (size_t)1 << 31, 16));
    heap_close(h);
}

/* ---- a game ---- */

/* All that scripts can hold: closures, tasks, random numbers, entities that come and go, materials, sounds, particles,
 * fonts, and what is saved. */
static const char GAME[] =
    "local ball, boxes, turns, voice, dust, face = nil, {}, 0\n"
    "local function counter() local n = 0 return function() n = n + 1 return n end end\n"
    "local next_number = counter()\n"
    "function daft.load()\n"
    "  daft.light.sun { direction = {-1, -2, -0.5} }\n"
    "  daft.entity { box = {40, 1, 40}, position = {0, -0.5, 0}, body = 'static' }\n"
    "  ball = daft.entity { sphere = 0.5, position = {0, 0.5, 0}, body = 'dynamic' }\n"
    "  daft.camera.look { from = {-9, 6, 0}, at = {0, 0, 0} }\n"
    "  daft.start(function() while true do wait(0.1 + daft.random() / 5) turns = turns + next_number() "
    "    ball:push(daft.random() * 900 - 450, 2000, daft.random() * 900 - 450) end end)\n"
    "end\n"
    "function daft.update()\n"
    "  local tick = daft.tick()\n"
    "  if daft.input.down('left') then ball:push(-4000, 0, 0) end\n"
    "  if daft.input.pressed('right') then turns = turns + 1000 end\n"
    "  if tick % 7 == 0 then boxes[#boxes + 1] = daft.entity { box = {0.4, 0.4, 0.4}, position = {daft.random() * 6 - "
    "3, 4, "
    "    daft.random() * 6 - 3}, material = { color = {daft.random(), 0.5, 0.5} }, body = 'dynamic' } end\n"
    "  if #boxes > 12 then table.remove(boxes, 1):destroy() end\n"
    "  if tick % 25 == 0 then daft.sound { wave = 'sine', pitch = 200 + tick, decay = 0.2 }:play() end\n"
    "  if tick % 60 == 20 then dust = daft.particles { count = 200, position = ball, rate = 60, life = 1 } end\n"
    "  if tick % 40 == 0 then face = daft.font('fonts/daft.ttf') end\n"
    "  if tick % 50 == 0 then daft.save('turns', { turns, (daft.load_saved('turns') or {0})[1] }) end\n"
    "  if tick % 90 == 30 then collectgarbage() end\n"
    "  if #boxes > 0 then boxes[#boxes]:position((turns + (daft.load_saved('turns') or {0})[1]) % 5, 2, 0) end\n"
    "end\n";

typedef struct stage {
    char folder[64], kept[80];
    home where;
    game_info info;
    game_source source;
    daft_engine *engine;
    font *face;
    saves *store;
    trail past;
    game_state games[2], *play;
} stage;

static stage s;

static void told(void *user, const char *name, const char *text)
{
    (void)user;
    trail_saved(&s.past, name, text);
}

static game_def set_up(const char *script)
{
    char path[PATH_SIZE];
    daft_error error;
    memset(&s, 0, sizeof s);
    snprintf(s.folder, sizeof s.folder, "/tmp/daft-time-XXXXXX");
    assert_non_null(mkdtemp(s.folder));
    snprintf(s.kept, sizeof s.kept, "%s/kept", s.folder);
    assert_int_equal(mkdir(s.kept, 0777), 0);
    snprintf(path, sizeof path, "%s/main.lua", s.folder);
    assert_true(daft_write_file(path, script, strlen(script), &error));
    assert_true(home_find(&s.where, &error) && home_find_game(&s.where, s.folder, &s.info, &error) &&
                source_open(&s.source, &s.where, &s.info, &error));
    daft_engine_def def = daft_default_engine_def();
    def.memory_limit = 500000000;
    assert_non_null(s.engine = daft_engine_create(&def, &error));
    assert_non_null(s.face = open_font(&s.where, &error));
    s.store = saves_open(&(saves_def){.folder = s.kept, .game = s.info.name, .told = told}, &error);
    s.play = &s.games[0];
    return (game_def){.where = &s.where,
                      .info = &s.info,
                      .source = &s.source,
                      .engine = s.engine,
                      .face = s.face,
                      .seed = 7,
                      .trail = &s.past,
                      .saves = s.store};
}

static void tear_down(void)
{
    char command[96];
    game_close(s.play);
    saves_close(s.store);
    trail_free(&s.past);
    font_close(s.face);
    source_close(&s.source);
    snprintf(command, sizeof command, "rm -r %s", s.folder);
    assert_int_equal(system(command), 0);
}

static void press(const char *key, bool down)
{
    input_push(&s.play->keys, &(input_event){.kind = INPUT_KEY, .key = input_key_find(key), .down = down});
}

/* One tick of the game that runs, with something that the player does. */
static void play_tick(uint64_t salt)
{
    if ((s.play->ticks * 7 + salt) % 31 == 0) press("left", (s.play->ticks + salt) % 2 == 0);
    if ((s.play->ticks + salt) % 17 == 0) press("right", true);
    if ((s.play->ticks + salt) % 17 == 5) press("right", false);
    if ((s.play->ticks + salt) % 45 == 11) assert_true(game_run_line(s.play, "daft.random()")); /* in a console */
    game_tick(s.play);
    if (s.play->failed) fail_msg("%s", s.play->scripts.failure.message);
}

enum { TICKS = 330, MORE = 150 };

/* The game's saved value, on top of the state. */
static uint64_t state_now(void)
{
    const char *text;
    daft_error error;
    saves *copy = saves_clone(s.play->def.saves, &error);
    saves_get(copy, "turns", &text, &error);
    const uint64_t hash = daft_hash(text ? text : "", text ? strlen(text) : 0, game_hash(s.play));
    saves_close(copy);
    return daft_hash(&s.play->scripts.mixer.last_id, sizeof s.play->scripts.mixer.last_id, hash);
}

static daft_image *picture;

static uint64_t picture_now(void)
{
    if (!game_draw(s.play, picture, 1)) fail_msg("%s", s.play->scripts.failure.message);
    return daft_hash(daft_image_pixels(picture), (size_t)96 * 54 * 4, 0);
}

static timeline *hold(uint64_t present)
{
    daft_error error;
    timeline *line = timeline_open(&s.play->def, present, &s.games[1], &s.past, &error);
    if (!line) fail_msg("%s", error.message);
    while (!timeline_catch_up(line, clock_now_ns() + 1000000)) assert_false(s.games[1].failed);
    assert_true(timeline_take_over(line, s.play, &error));
    s.play = line->play;
    return line;
}

static void go(timeline *line, uint64_t tick, const uint64_t *hashes)
{
    daft_error error;
    if (!timeline_go(line, tick, &error))
        fail_msg("tick %d: %s", (int)tick, error.code ? error.message : s.play->scripts.failure.message);
    assert_int_equal(s.play->ticks, tick);
    if (state_now() != hashes[tick]) fail_msg("another state after tick %d", (int)tick);
}

/* Pictures too, by what the renderer remembers of the tick before. */
static void pictures_are_as_they_were(void **unused)
{
    (void)unused;
    static uint64_t hashes[TICKS + 1], pictures[TICKS + 1];
    daft_error error;
    game_def def = set_up(GAME);
    assert_true(game_open(s.play, &def, &error));
    assert_non_null(picture = daft_image_create(s.engine, 96, 54, &error));
    while (s.play->ticks < TICKS) {
        play_tick(0);
        hashes[s.play->ticks] = state_now(), pictures[s.play->ticks] = picture_now();
    }
    timeline *line = hold(TICKS);
    assert_non_null(s.play->def.history = daft_history_create(line->engine, &error));
    for (int i = 0; i < 80; i++) {
        const uint64_t tick = i % 4 < 3 && s.play->ticks > 1 ? s.play->ticks - 1 : 1 + draw(TICKS);
        go(line, tick, hashes);
        if (picture_now() != pictures[tick]) fail_msg("another picture after tick %d", (int)tick);
    }
    assert_true(timeline_release(line, &error));
    daft_history *history = s.play->def.history;
    tear_down();
    daft_history_destroy(history);
    daft_image_destroy(picture);
    timeline_close(line);
    daft_engine_destroy(s.engine);
}

static void each_tick_is_as_it_was(void **unused)
{
    (void)unused;
    static uint64_t hashes[TICKS + MORE + 1], again[TICKS + MORE + 1];
    daft_error error;
    game_def def = set_up(GAME);
    assert_true(game_open(s.play, &def, &error));
    for (hashes[0] = state_now(); s.play->ticks < TICKS;) play_tick(0), hashes[s.play->ticks] = state_now();
    timeline *line = hold(TICKS);
    go(line, TICKS, hashes);
    for (uint64_t i = TICKS; i-- > TICKS - 20;) go(line, i, hashes); /* one by one */
    for (int i = 0; i < 120; i++) go(line, draw(TICKS + 1), hashes);
    for (uint64_t i = 0; i <= 70; i++) go(line, i, hashes);
    /* On from an earlier tick, with other input; and back again within that. */
    go(line, 200, hashes);
    assert_true(timeline_release(line, &error));
    memcpy(again, hashes, sizeof again);
    while (s.play->ticks < TICKS + MORE) play_tick(3), again[s.play->ticks] = state_now(), timeline_keep(line);
    assert_true(again[TICKS] != hashes[TICKS]);
    assert_true(timeline_hold(line, &error));
    for (int i = 0; i < 120; i++) go(line, draw(TICKS + MORE + 1), again);
    go(line, TICKS + MORE, again);
    assert_true(timeline_release(line, &error));
    tear_down();
    timeline_close(line);
    daft_engine_destroy(s.engine);
}

/* What the trail and the recording hold after all that is one straight game. */
static void what_went_on_replays(void **unused)
{
    (void)unused;
    char path[96], wanted[64];
    static char output[OUTPUT_SIZE];
    daft_error error;
    game_def def = set_up(GAME);
    snprintf(path, sizeof path, "%s/a.rec", s.kept);
    const recording_head head = {.game = s.info.name, .seed = def.seed};
    recorder *record = recorder_open(path, &head, &error);
    assert_non_null(record);
    def.record = record;
    assert_true(game_open(s.play, &def, &error));
    while (s.play->ticks < TICKS) play_tick(0);
    timeline *line = hold(TICKS);
    const uint64_t cuts[] = {250, 180, 240, 181, 61};
    for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
        if (i > 0) assert_true(timeline_hold(line, &error));
        assert_true(timeline_go(line, cuts[i], &error));
        assert_true(timeline_release(line, &error));
        for (int k = 0; k < 75; k++) play_tick(i), timeline_keep(line);
    }
    const uint64_t hash = game_hash(s.play), ticks = s.play->ticks;
    assert_int_equal(ticks, 61 + 75);
    assert_true(recorder_finish(record, &error));
    snprintf(wanted, sizeof wanted, "tick %d state 0x%016llx", (int)ticks, (unsigned long long)hash);
    assert_status(run_daft(output, "play %s --headless --strict --hash --replay %s", s.folder, path), 0, output);
    assert_says(output, wanted);
    recorder_free(record);
    tear_down();
    timeline_close(line);
    daft_engine_destroy(s.engine);
}

/* A game that has stopped with an error goes back to before that. */
static void a_failed_game_goes_back(void **unused)
{
    (void)unused;
    daft_error error;
    game_def def =
        set_up("local n = 0 function daft.update() n = n + 1 if daft.input.down('left') then nothing.x = 1 end end\n");
    assert_true(game_open(s.play, &def, &error));
    for (int i = 0; i < 100; i++) game_tick(s.play);
    press("left", true);
    assert_false(game_tick(s.play));
    timeline *line = hold(100);
    assert_true(timeline_go(line, 90, &error));
    assert_true(timeline_release(line, &error));
    for (int i = 0; i < 30; i++) assert_true(game_tick(s.play));
    tear_down();
    timeline_close(line);
    daft_engine_destroy(s.engine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_bring_back_what_was), cmocka_unit_test(each_tick_is_as_it_was),
        cmocka_unit_test(pictures_are_as_they_were), cmocka_unit_test(what_went_on_replays),
        cmocka_unit_test(a_failed_game_goes_back)};
    return cmocka_run_group_tests_name("timeline", tests, NULL, NULL);
}
