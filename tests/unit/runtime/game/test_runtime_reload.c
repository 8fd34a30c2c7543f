/* runtime: games whose files are saved while they run, and time that goes back and on. */
#include "runtime_program.h"
#include "scripted_session.h"

/* ---- live reload ---- */

/* The position after some ticks of "left", and what it was when the game began. */
#define WALK(speed)                                                                                                    \
    "local x, begun = 0, daft.load_saved('begun') or 0\n"                                                              \
    "daft.save('begun', begun + 1)\n"                                                                                  \
    "function daft.update()\n"                                                                                         \
    "  if daft.input.down('left') then x = x + " speed " end\n"                                                        \
    "  daft.save('x', x .. ' after ' .. daft.tick() .. ' begun ' .. begun)\n"                                          \
    "end\n"

/* New code goes on where the old one stood, as if it had been there from the start; what it keeps, it was given once.
 */
static void saved_scripts_take_effect_while_the_game_runs(void **unused)
{
    (void)unused;
    char now[80], wanted[80];
    begin_changing(WALK("1"));
    const happening script[] = {{5, "+left", 0, 0},
                                {15, "-left", 0, 0},
                                {40, "write " WALK("100"), 0, 0},
                                {60, "+left", 0, 0},
                                {100, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    int x, ticks, begun;
    assert_int_equal(sscanf(now, "\"%d after %d begun %d", &x, &ticks, &begun), 3);
    assert_int_equal(x, 100 * (10 + ticks + 1 - 59)); /* the key of frame 60 is there in tick 59 */
    assert_in_range(ticks, 97, 101);
    assert_int_equal(begun, 0);
    /* The recording, played by the new code alone, ends the same. */
    static char output[OUTPUT_SIZE];
    char line[256];
    snprintf(line, sizeof line, "for f in %s/kept/*; do mv $f $f.old; done", folder);
    assert_int_equal(system(line), 0);
    write_game(
        "local all = {}\n" WALK("100") "local update = daft.update\n"
                                       "function daft.update() update() all = daft.load_saved('x') print(all) end\n");
    assert_status(run_daft(output, "play %s/changing --headless --replay %s", folder, recorded), 0, output);
    snprintf(wanted, sizeof wanted, "%d after %d begun 0", x, ticks);
    assert_says(output, wanted);
    drop_folder();
}

static void wrong_scripts_leave_the_old_ones_running(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    begin_changing(WALK("1"));
    const happening script[] = {{5, "+left", 0, 0},
                                {20, "write function daft.update() this is wrong end", 0, 0},
                                {40, "write function daft.update() local none = nil; none.x = 1 end", 0, 0},
                                {60, "write " WALK("10"), 0, 0},
                                {90, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_int_equal(x, 10 * (ticks + 1 - 4));
    assert_in_range(ticks, 87, 91);
    drop_folder();
}

/* What was before the game began again is not done again. */
static void a_game_that_began_again_is_relived_from_there(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks, begun;
    begin_changing(WALK("1"));
    /* Held all the time; again from frame 33 on. */
    const happening script[] = {
        {5, "+left", 0, 0}, {30, "+f9", 0, 0}, {60, "write " WALK("100"), 0, 0}, {90, "close", 0, 0}};
    write_game(WALK("1") "function daft.keypressed(key) if key == 'f9' then daft.restart() end end\n");
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d begun %d", &x, &ticks, &begun), 3);
    assert_int_equal(x, 100 * (ticks + 1));
    assert_in_range(ticks, 57, 62);
    assert_int_equal(begun, 1);
    drop_folder();
}

/* ---- daft.reload ---- */

#define HANDS                                                                                                          \
    "local all, n = { turns = 0 }, %s\nfunction daft.keep() all.turns = all.turns + 1 return all end\n"                \
    "function daft.load() all.loaded = true end\nfunction daft.update() all.ticks = (all.ticks or 0) + n "             \
    "daft.save('x', all.ticks .. ' turns ' .. all.turns .. ' after ' .. daft.tick()) end\n"
#define TAKES "function daft.reload(old) assert(all.loaded and not all.ticks) all = old end\n"

static const char *hands(const char *step, const char *more)
{
    static char text[4][1024];
    static int last;
    char *out = text[last++ % 4];
    const int length = snprintf(out, 1024, "write " HANDS, step);
    snprintf(out + length, 1024 - (size_t)length, "%s", more);
    return out;
}

/* By what the old code keeps, and not by its input; the recording ends there, and is right. */
static void state_is_handed_to_new_code(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    char now[80], line[256];
    int x, turns, ticks;
    begin_changing(WALK("1"));
    const happening script[] = {
        {40, hands("100", TAKES), 0, 0}, {80, hands("10000", TAKES), 0, 0}, {110, "close", 0, 0}};
    write_game(hands("1", TAKES) + 6);
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d turns %d after %d", &x, &turns, &ticks), 3);
    assert_int_equal(turns, 2);
    assert_in_range(ticks, 20, 30); /* of the last code */
    assert_int_equal(x / 10000, ticks + 1);
    assert_in_range(x / 100 % 100, 38, 42);
    assert_in_range(x % 100, 40, 47);
    assert_int_equal(ticks_recorded(), x % 100);
    write_game(hands("1", TAKES) + 6);
    snprintf(line, sizeof line, "for f in %s/kept/*; do mv $f $f.old; done", folder);
    assert_int_equal(system(line), 0);
    assert_status(run_daft(output, "play %s/changing --headless --hash --replay %s", folder, recorded), 0, output);
    drop_folder();
}

/* Where nothing can be handed over the old code runs on, or the input is played again. */
static void reload_may_fail_or_be_missing(void **unused)
{
    (void)unused;
    char now[80];
    int x, turns, ticks;
    begin_changing(WALK("1"));
    const happening wrong[] = {{30, hands("100", "function daft.reload(old) old.ticks.x = 1 end\n"), 0, 0},
                               {60, hands("100", TAKES "function daft.keep() return print end\n"), 0, 0},
                               {80, hands("5", TAKES), 0, 0}, /* refused: daft.keep fails */
                               {100, "close", 0, 0}};
    write_game(hands("1", TAKES) + 6);
    PLAY(wrong);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d turns %d after %d", &x, &turns, &ticks), 3);
    assert_int_equal(turns, 2); /* kept twice: for the code that failed, and for the next one */
    assert_int_equal(x / 100, ticks + 1);
    assert_in_range(x % 100, 60, 67);
    drop_folder();
    begin_changing(WALK("1"));
    const happening missing[] = {{40, hands("3", ""), 0, 0}, {80, "close", 0, 0}};
    write_game(hands("1", TAKES) + 6);
    PLAY(missing);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d turns %d after %d", &x, &turns, &ticks), 3);
    assert_int_equal(x, 3 * (ticks + 1));
    assert_in_range(ticks, 77, 81);
    drop_folder();
}

/* Without daft.keep, plain global variables; and back in time to where they were handed over. */
static void globals_are_handed_to_new_code(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    static const char GAME[] =
        "write count, list = count or 0, { function() end, 5, inner = { true, 1 / 0 } }\nlist.self = list\n"
        "function daft.reload(old) assert(old.list[2] == 5 and old.list.inner[1] and not old.list[1] and not old.math "
        "and "
        "not old._VERSION and not old.daft and not old.assert) count = old.count end\n"
        "function daft.update() count = count + STEP daft.save('x', count .. ' after ' .. daft.tick()) end\n";
    char second[1024];
    const char *place = strstr(GAME, "STEP");
    snprintf(second, sizeof second, "%.*s100%s", (int)(place - GAME), GAME, place + 4);
    happening script[64] = {{40, second, 0, 0}};
    size_t count = 1;
    script[count++] = (happening){70, "+f5", 0, 0}; /* back beyond the reload: it stops there */
    script[count++] = (happening){170, "-f5", 0, 0};
    tap(script, &count, 180, "+space", "-space");
    script[count++] = (happening){190, "close", 0, 0};
    begin_changing(WALK("1"));
    char first[1024];
    snprintf(first, sizeof first, "%.*s1%s", (int)(place - GAME) - 6, GAME + 6, place + 4);
    write_game(first);
    set_up(script, count);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(x % 100, 40, 47);
    assert_int_equal(x / 100, ticks + 1);
    assert_in_range(ticks, 7, 11);
    drop_folder();
}

/* ---- how soon ---- */

/* What a game is made of, and how it is after it was saved anew. */
enum { SAVED_FILES = 5 };
static const char *const SAVED[SAVED_FILES] = {"main.lua", "level.scene", "shape.obj", "paint.png", "tone.wav"};

/* Each time a file is saved: when, and when it was seen. */
static struct {
    int saved; /* of SAVED: the file that is to be seen */
    uint64_t frame, ns, upper;
    double ms[SAVED_FILES];
    uint64_t frames[SAVED_FILES];
} soon;

static const char SCRIPT[] = "local tone = daft.sound('tone.wav')\nfunction daft.load() daft.scene('level.scene') "
                             "daft.entity { mesh = 'shape.obj', material = 'paint.png', position = {6, 0.5, 0} } end\n"
                             "function daft.draw() daft.text(('%.2f s, '):format(tone:seconds()) .. ";

static size_t put_wav(char *out, uint32_t frames)
{
    const uint32_t size = 2 * frames, head[11] = {0x46464952, 36 + size, 0x45564157, 0x20746d66, 16,  0x00010001,
                                                  48000,      96000,     0x00100002, 0x61746164, size};
    memcpy(out, head, sizeof head);
    memset(out + sizeof head, 1, size);
    return sizeof head + size;
}

static void save_file(const char *name, bool anew)
{
    static char text[1 << 16];
    char path[96];
    size_t size = 0;
    daft_error error;
    snprintf(path, sizeof path, "%s/changing/%s", folder, name);
    if (strcmp(name, "paint.png") == 0) {
        daft_image *image = daft_image_create(s.engine, anew ? 2 : 1, 1, &error);
        memset(daft_image_pixels(image), anew ? 250 : 100, anew ? 8 : 4);
        if (!daft_image_write(image, path, &error)) fail_msg("%s", error.message);
        daft_image_destroy(image);
        return;
    }
    if (strcmp(name, "main.lua") == 0)
        size = (size_t)snprintf(text, sizeof text, "%s %s, 16, 16) end\n", SCRIPT, anew ? "'anew'" : "'old'");
    else if (strcmp(name, "level.scene") == 0)
        size = (size_t)snprintf(text, sizeof text, "camera 0 1 0\nsun 1 -1 0 1 1 %s\nambient 1 1 1\n",
                                anew ? "0.25" : "1");
    else if (strcmp(name, "shape.obj") == 0)
        size = (size_t)snprintf(text, sizeof text,
                                "v 0 0 -1\nv 0 0 1\nv 0 %s 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 3/3 2/2 1/1\n",
                                anew ? "3.25" : "2");
    else
        size = put_wav(text, anew ? 24000 : 12000);
    if (!daft_write_file(path, text, size, &error)) fail_msg("%s", error.message);
}

/* One file after another, half a second after the last one was seen. */
static void save_and_wait(script_platform *p, uint64_t upper)
{
    const uint64_t now = clock_now_ns();
    if (soon.ns && upper != soon.upper) {
        soon.ms[soon.saved] = (double)(now - soon.ns) / 1e6, soon.frames[soon.saved] = p->frame - soon.frame;
        soon.saved++, soon.ns = 0, soon.frame = p->frame;
        p->closes = soon.saved == SAVED_FILES;
    } else if (!soon.ns && soon.saved < SAVED_FILES && p->frame > soon.frame + 30) {
        save_file(SAVED[soon.saved], true);
        soon.ns = clock_now_ns(), soon.frame = p->frame;
    }
    soon.upper = upper;
}

/* Each kind of file, in a small game, with a clock that runs. On a machine that does nothing else it is within a
 * tenth of a second; a test on a busy one only finds what waits for ever. */
static void what_is_saved_is_soon_seen(void **unused)
{
    (void)unused;
    begin_changing(WALK("1"));
    set_up(NULL, 0);
    for (int i = 0; i < SAVED_FILES; i++) save_file(SAVED[i], false);
    s.screen.seen = save_and_wait, s.screen.width = 640, s.screen.height = 360;
    assert_int_equal(play_changing(), SESSION_CLOSED);
    for (int i = 0; i < SAVED_FILES; i++) {
        printf("%-12s shows after %5.1f ms, in frame %d\n", SAVED[i], soon.ms[i], (int)soon.frames[i]);
        assert_true(soon.ms[i] > 0 && soon.ms[i] < 2000);
    }
    drop_folder();
}

static char large[4096]; /* what is saved of a large game */

static void save_and_wait_for_white(script_platform *p, uint64_t unused)
{
    static const uint8_t WHITE[4] = {255, 255, 255, 255};
    (void)unused;
    if (!soon.ns && p->frame == 30) {
        assert_int_equal(system(large), 0);
        soon.ns = clock_now_ns(), soon.frame = p->frame;
    } else if (soon.ns && memcmp(p->corner, WHITE, 4) == 0) {
        soon.ms[0] = (double)(clock_now_ns() - soon.ns) / 1e6, soon.frames[0] = p->frame - soon.frame;
        p->closes = true, soon.ns = 0;
    }
}

/* The same of games that come with DAFT: their pictures and sounds are there already. */
static void what_is_saved_in_large_games_is_soon_seen(void **unused)
{
    (void)unused;
    static const char *const GAMES[] = {"marble", "toppler"};
    for (size_t i = 0; i < COUNT_OF(GAMES); i++) {
        char line[256];
        begin_changing("");
        set_up(NULL, 0);
        memset(&soon, 0, sizeof soon);
        snprintf(line, sizeof line, "cp -r %s/games/%s/. %s/changing", DAFT_ROOT, GAMES[i], folder);
        assert_int_equal(system(line), 0);
        snprintf(large, sizeof large,
                 "echo 'function daft.draw() daft.rect(0, 0, 2000, 720, \"#fff\") end' >> %s/changing/main.lua",
                 folder);
        s.screen.seen = save_and_wait_for_white, s.screen.width = 640, s.screen.height = 360;
        assert_int_equal(play_changing(), SESSION_CLOSED);
        printf("%-12s shows after %5.1f ms, in frame %d\n", GAMES[i], soon.ms[0], (int)soon.frames[0]);
        assert_true(soon.ms[0] > 0 && soon.ms[0] < 4000);
        drop_folder();
    }
}

static const char LONG_NOTES[] =
    "local ring = daft.sound('tone.wav')\n"
    "local hum = daft.sound { beat = 10, notes = 'c4 - - - - - - - - - - - - - - - - - - - - - - -' }\n"
    "function daft.load() daft.entity { box = {1, 1, 1}, material = 'paint.png', position = {6, 0, 0} } hum:play() "
    "ring:play() end\n"
    "function daft.draw() daft.rect(0, 0, 9, 9, '#f%s') end\n";

/* The picture is 1024 pixels a side, the sounds are one and four minutes long: 4, 6 and 23 MB. */
static void put_large_files(void)
{
    enum { SIDE = 1024, FRAMES = 48000 * 60 };
    char path[96];
    daft_error error;
    daft_image *image = daft_image_create(s.engine, SIDE, SIDE, &error);
    memset(daft_image_pixels(image), 77, (size_t)4 * SIDE * SIDE);
    snprintf(path, sizeof path, "%s/changing/paint.png", folder);
    if (!daft_image_write(image, path, &error)) fail_msg("%s", error.message);
    daft_image_destroy(image);
    char *wav = malloc(44 + 2 * (size_t)FRAMES);
    assert_non_null(wav);
    snprintf(path, sizeof path, "%s/changing/tone.wav", folder);
    if (!daft_write_file(path, wav, put_wav(wav, FRAMES), &error)) fail_msg("%s", error.message);
    free(wav);
}

/* Of a game and the one that takes its place, what both have is in memory once. */
static void what_both_games_have_is_there_once(void **unused)
{
    (void)unused;
    char first[1024], second[1024] = "write ";
    snprintf(first, sizeof first, LONG_NOTES, "ff");
    snprintf(second + 6, sizeof second - 6, LONG_NOTES, "00");
    const happening none[] = {{80, "close", 0, 0}};
    const happening saved[] = {{40, second, 0, 0}, {80, "close", 0, 0}};
    uint64_t peak[2];
    for (int i = 0; i < 2; i++) {
        begin_changing(first);
        set_up(i ? saved : none, i ? 2 : 1);
        put_large_files();
        assert_int_equal(play_changing(), SESSION_CLOSED);
        assert_int_equal(s.screen.corner[1], i ? 0 : 255);
        peak[i] = s.peak;
        drop_folder();
    }
    if (peak[1] > peak[0] + 3000000) fail_msg("%.1f MB, not %.1f", (double)peak[1] / 1e6, (double)peak[0] / 1e6);
}

/* ---- time that is held ---- */

/* Back by five, on by two, back by one and one for the first: the tick that the game goes on from; and its recording
 * plays as one straight game. */
static void f5_and_f6_go_through_time(void **unused)
{
    (void)unused;
    happening script[64];
    size_t count = 0;
    char line[256], now[80];
    static char output[OUTPUT_SIZE];
    int x, ticks;
    begin_changing(WALK("1"));
    script[count++] = (happening){5, "+left", 0, 0};
    for (int i = 0; i < 5; i++) tap(script, &count, 60 + 4 * (uint64_t)i, "+f5", "-f5"); /* tick 60 becomes 55 */
    tap(script, &count, 90, "+f6", "-f6");
    tap(script, &count, 94, "+f6", "-f6");
    script[count++] = (happening){100, "-left", 0, 0};
    tap(script, &count, 110, "+space", "-space"); /* on from tick 57 */
    script[count++] = (happening){140, "close", 0, 0};
    set_up(script, count);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 57 + 26, 57 + 31);
    assert_in_range(x, 57 - 6, 57 - 4); /* the key went up while time was held */
    assert_int_equal(ticks_recorded(), ticks + 1);
    snprintf(line, sizeof line, "for f in %s/kept/*; do mv $f $f.old; done", folder);
    assert_int_equal(system(line), 0);
    assert_status(run_daft(output, "play %s/changing --headless --strict --replay %s", folder, recorded), 0, output);
    drop_folder();
}

/* Live reload forgets the images of the old code's memory: the new one is played again from the start. */
static void new_code_goes_back_too(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    happening script[64];
    size_t count = 0;
    begin_changing(WALK("1"));
    script[count++] = (happening){5, "+left", 0, 0};
    tap(script, &count, 60, "+f5", "-f5");
    tap(script, &count, 70, "+space", "-space"); /* from tick 59 on */
    script[count++] = (happening){90, "write " WALK("100"), 0, 0};
    script[count++] = (happening){120, "+f5", 0, 0};
    script[count++] = (happening){300, "-f5", 0, 0};
    for (int i = 0; i < 7; i++) tap(script, &count, 310 + 3 * (uint64_t)i, "+f6", "-f6");
    tap(script, &count, 340, "+space", "-space");
    script[count++] = (happening){350, "-left", 0, 0};
    script[count++] = (happening){360, "close", 0, 0};
    set_up(script, count);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 7 + 17, 7 + 22);
    assert_in_range(x, 100 * (2 + 8), 100 * (2 + 12)); /* of the first seven ticks the key was down in two */
    drop_folder();
}

/* Held down it goes back by as much as it was held, and no farther than the start; steps beyond the present are new
 * ticks, of what the player holds. */
static void time_that_is_held_is_scrubbed_and_stepped(void **unused)
{
    (void)unused;
    char now[80];
    int x, ticks;
    const happening back[] = {
        {5, "+left", 0, 0}, {60, "+f5", 0, 0}, {200, "-f5", 0, 0}, {210, "+space", 0, 0}, {230, "close", 0, 0}};
    begin_changing(WALK("1"));
    PLAY(back);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 17, 21); /* from the start on, the key held all the time */
    assert_int_equal(x, ticks + 1);
    drop_folder();
    const happening on[] = {{60, "+f6", 0, 0}, {61, "-f6", 0, 0},   {70, "+left", 0, 0},
                            {72, "+f6", 0, 0}, {73, "-f6", 0, 0},   {75, "+f6", 0, 0},
                            {76, "-f6", 0, 0}, {90, "-left", 0, 0}, {95, "close", 0, 0}};
    begin_changing(WALK("1"));
    PLAY(on);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_int_equal(sscanf(now, "\"%d after %d", &x, &ticks), 2);
    assert_in_range(ticks, 60, 62);
    assert_int_equal(x, 2);
    drop_folder();
}

/* A game that has stopped with an error goes on when its script is right. */
static void a_stopped_game_goes_on_when_it_is_right(void **unused)
{
    (void)unused;
    char now[80];
    begin_changing(WALK("1"));
    write_game(WALK("1") "local update = daft.update\nfunction daft.update() if daft.tick() == 10 then nothing.x = 1 "
                         "end update() end\n");
    const happening script[] = {{40, "write " WALK("1"), 0, 0}, {90, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_non_null(strstr(now, "0 after 5")); /* ten ticks, and those from frame 43 on */
    drop_folder();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(saved_scripts_take_effect_while_the_game_runs),
                                       cmocka_unit_test(wrong_scripts_leave_the_old_ones_running),
                                       cmocka_unit_test(a_game_that_began_again_is_relived_from_there),
                                       cmocka_unit_test(state_is_handed_to_new_code),
                                       cmocka_unit_test(reload_may_fail_or_be_missing),
                                       cmocka_unit_test(globals_are_handed_to_new_code),
                                       cmocka_unit_test(what_is_saved_is_soon_seen),
                                       cmocka_unit_test(what_is_saved_in_large_games_is_soon_seen),
                                       cmocka_unit_test(what_both_games_have_is_there_once),
                                       cmocka_unit_test(f5_and_f6_go_through_time),
                                       cmocka_unit_test(new_code_goes_back_too),
                                       cmocka_unit_test(time_that_is_held_is_scrubbed_and_stepped),
                                       cmocka_unit_test(a_stopped_game_goes_on_when_it_is_right)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
