/* runtime: the console and the inspector: lines of Lua as a part of a game and of its recordings, typed at a platform
 * made for tests. */
#include "game/game.h"
#include "lua/statement.h"
#include "runtime_program.h"
#include "tools/console.h"
#include "tools/inspector.h"
#include "scripted_session.h"

static game_info info;

static int open_all(void **unused)
{
    (void)unused;
    daft_error error;
    make_folder();
    set_up(NULL, 0);
    assert_true(home_find_game(&s.where, DAFT_ROOT "/tests/games/sample", &info, &error));
    return 0;
}

static int close_all(void **unused)
{
    (void)unused;
    tear_down();
    drop_folder();
    return 0;
}

static session_end play_sample(const happening *script, size_t count, const char *replay)
{
    begin_script(script, count);
    s.def.pauses = true, s.def.record = replay ? NULL : recorded, s.def.replay = replay;
    return play("sample");
}

#define PLAY_SAMPLE(script) play_sample(script, sizeof script / sizeof script[0], NULL)

static int count_recorded(const char *wanted)
{
    int count;
    count_lines(recorded, wanted, &count);
    return count;
}

/* ---- at a window ---- */

static const happening TYPES[] = {{5, "console", 0, 0},     {6, " ball:push(0, 900, 0)", 0, 0},
                                  {7, "+return", 0, 0},     {9, "-return", 0, 0},
                                  {10, " score = 7", 0, 0}, {11, "+return", 0, 0},
                                  {12, "-return", 0, 0},    {13, "+left", 0, 0},
                                  {20, "-left", 0, 0},      {30, "console", 0, 0},
                                  {40, "+up", 0, 0},        {100, "close", 0, 0}};

static void what_is_typed_is_recorded_and_replayed(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    char command[260];
    assert_int_equal(PLAY_SAMPLE(TYPES), SESSION_CLOSED);
    assert_int_equal(count_recorded(" lua ball:push(0, 900, 0)"), 1);
    assert_int_equal(count_recorded(" lua score = 7"), 1);
    assert_int_equal(count_recorded("left"), 0); /* keys are the console's while it is open, */
    assert_int_equal(count_recorded("+up"), 1);  /* and the game's again when it has closed */
    assert_status(run_daft(output, "play tests/games/sample --headless --replay %s --strict", recorded), 0, output);
    /* Without the line the ball does not fly: the comparison would have found out. */
    snprintf(command, sizeof command, "sed '/lua ball/d' %s > %s.cut", recorded, recorded);
    assert_int_equal(system(command), 0);
    assert_status(run_daft(output, "play tests/games/sample --headless --replay %s.cut --strict", recorded), 1, output);
    assert_says(output, "the replay is not what was recorded");
}

static void escape_closes_the_console_and_not_the_game(void **unused)
{
    (void)unused;
    const happening escape[] = {
        {5, "console", 0, 0}, {8, "+escape", 0, 0}, {9, "-escape", 0, 0}, {20, "+up", 0, 0}, {60, "close", 0, 0}};
    assert_int_equal(PLAY_SAMPLE(escape), SESSION_CLOSED);
    assert_int_equal(count_recorded("+up"), 1); /* no pause menu took it */
}

static void the_console_shows_itself(void **unused)
{
    (void)unused;
    const happening none[] = {{30, "close", 0, 0}}, shown[] = {{5, "console", 0, 0}, {30, "close", 0, 0}},
                    hidden[] = {{5, "console", 0, 0}, {9, "console", 0, 0}, {30, "close", 0, 0}};
    assert_int_equal(PLAY_SAMPLE(none), SESSION_CLOSED);
    const uint64_t without = s.screen.hash;
    assert_int_equal(PLAY_SAMPLE(shown), SESSION_CLOSED);
    assert_true(s.screen.hash != without);
    assert_int_equal(PLAY_SAMPLE(hidden), SESSION_CLOSED);
    assert_true(s.screen.hash == without);
}

/* A line that is typed while a recording plays would change its game. */
static void a_recording_is_left_alone(void **unused)
{
    (void)unused;
    char first[120];
    assert_int_equal(PLAY_SAMPLE(TYPES), SESSION_CLOSED);
    snprintf(first, sizeof first, "%s.first", recorded);
    assert_int_equal(rename(recorded, first), 0);
    const happening watch[] = {{40, "close", 0, 0}};
    assert_int_equal(play_sample(watch, 1, first), SESSION_CLOSED);
    const happening close[] = {{5, "console", 0, 0},
                               {6, " ball:push(0, -900, 0)", 0, 0},
                               {7, "+return", 0, 0},
                               {8, "console", 0, 0},
                               {40, "close", 0, 0}};
    const uint64_t alone = s.screen.hash;
    assert_int_equal(play_sample(close, 5, first), SESSION_CLOSED);
    assert_true(s.screen.hash == alone);
}

/* The ball falls through the middle of the picture. */
static void the_inspector_takes_clicks_and_changes_are_recorded(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    const happening clicks[] = {
        {5, "+f4", 0, 0},         {6, "move", 0.50f, 0.45f}, {6, "+mouse1", 0, 0},
        {7, "-mouse1", 0, 0},     {8, "+down", 0, 0},        {8, "-down", 0, 0},
        {9, "+down", 0, 0},       {9, "-down", 0, 0},        {10, "+down", 0, 0},
        {10, "-down", 0, 0},      {11, "+return", 0, 0},     {11, "-return", 0, 0},
        {12, "+left ctrl", 0, 0}, {12, "+u", 0, 0},          {12, "-u", 0, 0},
        {12, "-left ctrl", 0, 0}, {13, " 0, 7, 0", 0, 0},    {14, "+return", 0, 0},
        {14, "-return", 0, 0},    {20, "console", 0, 0},     {21, " score = it:position() it = it", 0, 0},
        {22, "+return", 0, 0},    {30, "console", 0, 0},     {31, "+escape", 0, 0},
        {32, "-escape", 0, 0},    {40, "+up", 0, 0},         {90, "close", 0, 0}};
    assert_int_equal(PLAY_SAMPLE(clicks), SESSION_CLOSED);
    assert_int_equal(count_recorded(":position(0, 7, 0)"), 1);
    assert_int_equal(count_recorded("lua score = entity_"), 1);
    assert_int_equal(count_recorded("it = it"), 0);
    assert_int_equal(count_recorded("it = entity_"), 1);
    assert_int_equal(count_recorded("mouse"), 0); /* the game hears of no click */
    assert_int_equal(count_recorded("down"), 0);
    assert_int_equal(count_recorded("+up"), 1); /* Esc has closed it */
    assert_status(run_daft(output, "play tests/games/sample --headless --replay %s --strict", recorded), 0, output);
}

/* ---- in a game ---- */

static game_state game;
static char answers[8192];

static void keep_answer(void *user, const char *line, const char *answer, bool good)
{
    (void)user, (void)line;
    const size_t used = strlen(answers);
    snprintf(answers + used, sizeof answers - used, "%s%s\n", good ? "" : "! ", answer);
}

static void open_game(void)
{
    daft_error error;
    const game_def def = {.where = &s.where,
                          .info = &info,
                          .engine = s.engine,
                          .face = s.face,
                          .seed = 1,
                          .seconds = 120,
                          .answered = keep_answer};
    assert_true(game_open(&game, &def, &error));
    assert_true(game_tick(&game));
}

/* What a line comes to. */
static const char *answer_to(const char *line)
{
    answers[0] = 0;
    assert_true(game_run_line(&game, line));
    if (!game_tick(&game)) fail_msg("%s: %s", line, game.scripts.failure.message);
    return answers;
}

static void lines_are_answered(void **unused)
{
    (void)unused;
    static const struct {
        const char *line, *answer;
    } CASES[] = {{"1 + 2, 'a\\nb'", "3, \"a\\nb\"\n"},
                 {"  nil  ", "nil\n"},
                 {"local a = 1", "\n"},
                 {"a = 1", "\n"},
                 {"a", "1\n"},
                 {"{b = {2}, 'x', [true] = 0}", "[1] = \"x\"\nb = {2}\nand 1 more\n"},
                 {"{}", "{}\n"},
                 {"score", "0\n"}, /* a local of main.lua that daft.draw uses */
                 {"score = score + 5", "\n"},
                 {"score", "5\n"},
                 {"_G.score", "nil\n"},
                 {"function twice(x) return 2 * x + score end", "\n"},
                 {"twice(4)", "13\n"},
                 {"ball == daft.find{}[1]", "! console:1: daft.find: tag or name expected\n"},
                 {"_ENV['entity_' .. tostring(ball):match('%d+')] == ball", "true\n"},
                 {"entity_99:position()", "! console:1: there is no entity 99\n"},
                 {"ball:pusch(1)", "! console:1: entity has no 'pusch': did you mean 'push'?\n"},
                 {"x +", "! console:1: unexpected symbol near <eof>\n"},
                 {"error({})", "! (an error that is a table)\n"},
                 {"daft.text('x', 1, 1)", "! console:1: daft.text: only within daft.draw\n"},
                 {"io.open('x')", "! console:1: io is not there in games: they can be replayed and cannot reach beyond "
                                  "their folder\n"}};
    open_game();
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        const char *answer = answer_to(CASES[i].line);
        if (strcmp(answer, CASES[i].answer) != 0) fail_msg("%s: %s, not %s", CASES[i].line, answer, CASES[i].answer);
    }
    assert_false(game.failed);
    assert_false(game_run_line(&game, " \t "));
    game_close(&game);
}

/* A line without an end stops at the same instruction each time, and the game goes on. */
static void endless_lines_end_alike(void **unused)
{
    (void)unused;
    char counts[2][64];
    for (int i = 0; i < 2; i++) {
        open_game();
        assert_string_equal(answer_to("n = 0 while true do n = n + 1 end"), "! console:1: the line ran too long\n");
        snprintf(counts[i], sizeof counts[i], "%s", answer_to("n"));
        assert_string_equal(answer_to("pcall(function() while true do end end) n = -1"),
                            "! console:1: the line ran too long\n");
        assert_string_equal(answer_to("n"), counts[i]);
        assert_string_equal(answer_to("1"), "1\n");
        game_close(&game);
    }
    assert_string_equal(counts[0], counts[1]);
    assert_true(atoi(counts[0]) > 1000000);
}

static void lines_that_do_not_fit_are_refused(void **unused)
{
    (void)unused;
    char line[STATEMENT_SIZE + 8];
    open_game();
    memset(line, ' ', sizeof line);
    memcpy(line + STATEMENT_SIZE, "1", 2);
    assert_true(game_run_line(&game, line)); /* blanks do not count */
    memset(line, '1', sizeof line);
    line[STATEMENT_SIZE] = 0;
    assert_false(game_run_line(&game, line));
    for (int i = 1; i < GAME_LINES; i++) assert_true(game_run_line(&game, "1"));
    assert_false(game_run_line(&game, "1"));
    assert_true(game_tick(&game));
    assert_true(game_run_line(&game, "1"));
    game_close(&game);
}

static inspector look;

static inspector_wish press_look(const char *key)
{
    const input_event event = {.kind = INPUT_KEY, .key = input_key_find(key), .down = true};
    return inspector_take(&look, &event, 0);
}

static const inspector_row *row_of(const char *label)
{
    inspector_read(&look, game.scene, &game.scripts);
    for (look.at = 0; look.at < look.count; look.at++)
        if (strstr(look.rows[look.at].label, label)) return &look.rows[look.at];
    fail_msg("there is no row '%s'", label);
    return NULL;
}

static void answer_look(void *user, const char *line, const char *answer, bool good)
{
    (void)user;
    inspector_answered(&look, line, answer, good);
}

/* Each row takes what is typed, shows it from then on, and what is wrong it says. */
static void fields_are_changed(void **unused)
{
    (void)unused;
    static const struct {
        const char *label, *typed, *shown, *told;
    } CASES[] = {{"name", "the \"ball\\", "the \"ball\\", ""},
                 {"tags", "red, round", "red, round", ""},
                 {"tags", "blue", "blue", ""},
                 {"tags", "", "", ""},
                 {"position", "1, 40.1, 2", "1, 40.1, 2", ""},
                 {"position", "1, nil, 2", NULL, "position"},
                 {"yaw, pitch, roll", "0.5, 0.25, -1", "0.5, 0.25, -1", ""},
                 {"scale", "2", NULL, "scale"},
                 {"color", "#ff0000", "1, 0, 0", ""},
                 {"color", "0, 0.5, 1", "0, 0.5, 1", ""},
                 {"mirror", "0.25", "0.25", ""},
                 {"mirror", "2", NULL, "between 0 and 1"},
                 {"material", "#00ff00", "its own", ""},
                 {"material", "checkr", NULL, "did you mean 'checker'"},
                 {"gravity", "", NULL, "cannot be changed"},
                 {"velocity", "1, 0, ball:mass() * 0", "1, 0, 0", ""}};
    open_game();
    game.def.answered = answer_look;
    daft_entity all[8];
    daft_entity_def def;
    uint32_t count = daft_scene_entities(game.scene, all, 8);
    inspector_show(&look, true);
    for (uint32_t i = 0; i < count; i++)
        if (daft_entity_get(game.scene, all[i], &def, NULL) && def.shape == DAFT_SHAPE_SPHERE)
            inspector_choose(&look, all[i]);
    look.box = (panel_box){0, 0, INSPECTOR_WIDTH, 600};
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        row_of(CASES[i].label);
        look.edits = false;
        inspector_wish wish = press_look("return");
        if (look.edits) {
            edit_set(&look.edit, CASES[i].typed);
            wish = press_look("return");
            assert_int_equal(wish, INSPECTOR_RUN);
            assert_true(game_run_line(&game, look.line));
            game.scripts.next_scale = 0; /* it stands still, to be looked at */
            assert_true(game_tick(&game));
        }
        if (CASES[i].told[0] ? !strstr(look.told, CASES[i].told) : look.told[0] != 0)
            fail_msg("%s, %s: '%s'", CASES[i].label, CASES[i].typed, look.told);
        if (CASES[i].shown && strcmp(row_of(CASES[i].label)->value, CASES[i].shown) != 0)
            fail_msg("%s, %s: %s", CASES[i].label, CASES[i].typed, row_of(CASES[i].label)->value);
    }
    /* What stands in a row is typed back to the bit. */
    assert_string_equal(row_of("position")->exact, "1, 40.1, 2");
    row_of("visible");
    assert_int_equal(press_look("return"), INSPECTOR_RUN); /* flags change at once */
    assert_true(game_run_line(&game, look.line) && game_tick(&game));
    assert_string_equal(row_of("visible")->value, "false");
    assert_true(daft_entity_destroy(game.scene, look.chosen, NULL));
    inspector_read(&look, game.scene, &game.scripts);
    assert_int_equal(look.count, 0);
    assert_says(look.title, "is gone");
    assert_int_equal(press_look("escape"), INSPECTOR_CLOSE);
    game_close(&game);
}

static void names_are_completed(void **unused)
{
    (void)unused;
    static const struct {
        const char *text, *common;
        int total; /* below 0: at least so many */
    } CASES[] = {{"daft.camera.lo", "look", 1},
                 {"x = bal", "ball", 1},
                 {"ball:pu", "push", -1},
                 {"ball:teleport(daft.inp", "input", 1},
                 {"scor", "score", 1},
                 {"entity_2:tele", "teleport", 1},
                 {"it:tele", "teleport", 1},
                 {"math.flo", "floor", 1},
                 {"nothing.", "", 0},
                 {"ball.x.y", "", 0},
                 {"daft.", "", -40},
                 {"", "", -30},
                 {"score.", "", 0},
                 {"daft:", "", -20}};
    completions found;
    open_game();
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; i++) {
        const size_t held = game.scripts.memory;
        host_complete(&game.scripts, CASES[i].text, &found);
        if (strcmp(found.common, CASES[i].common) != 0) fail_msg("%s: '%s'", CASES[i].text, found.common);
        if (CASES[i].total < 0 ? (int)found.total < -CASES[i].total : (int)found.total != CASES[i].total)
            fail_msg("%s: %d", CASES[i].text, (int)found.total);
        assert_int_equal(game.scripts.memory, held);
        for (size_t k = 1; k < found.count; k++) assert_true(strcmp(found.names[k - 1], found.names[k]) < 0);
    }
    game_close(&game);
}

/* ---- recordings ---- */

static bool load(recording *out, const char *text, daft_error *error)
{
    assert_true(daft_write_file(recorded, text, strlen(text), error));
    return recording_load(out, NULL, recorded, error);
}

static void recordings_hold_lines(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        int line;
        const char *message;
    } WRONG[] = {{"daft-recording 6\n3 lua\nend 9\n", 2, "a line of Lua expected"},
                 {"daft-recording 6\n3 lua x\n2 +left\nend 9\n", 3, "must not go back"},
                 {"daft-recording 6\n3 +left\n2 lua x\nend 9\n", 3, "must not go back"},
                 {"daft-recording 6\n3 lua x\nend 3\n", 3, "before its last event"}};
    recording read;
    daft_error error;
    assert_true(load(&read, "daft-recording 6\n3 lua  a = '# 1'  -- \n3 +left\n3 lua b\n70 lua c\nend 90\n", &error));
    assert_int_equal(read.line_count, 3);
    assert_null(recording_line_at(&read, 2));
    assert_string_equal(recording_line_at(&read, 3), "a = '# 1'  --");
    assert_string_equal(recording_line_at(&read, 3), "b");
    assert_null(recording_line_at(&read, 69));
    assert_string_equal(recording_line_at(&read, 70), "c");
    recording_free(&read);
    /* Cut short: what came after the last mark is not whole. */
    assert_true(load(&read, "daft-recording 6\n3 lua b\ntick 60\n70 lua c\n", &error));
    assert_true(read.cut && read.line_count == 1 && read.end == 60);
    recording_free(&read);
    for (size_t i = 0; i < sizeof WRONG / sizeof WRONG[0]; i++) {
        assert_false(load(&read, WRONG[i].text, &error));
        assert_int_equal(error.line, WRONG[i].line);
        assert_says(error.message, WRONG[i].message);
    }
}

/* ---- typing ---- */

/* A text as a list of letters. */
typedef struct twin {
    char letters[64][5];
    int count, cursor;
} twin;

static void insert_twin(twin *t, const char *letter)
{
    memmove(t->letters[t->cursor + 1], t->letters[t->cursor], (size_t)(t->count - t->cursor) * 5);
    snprintf(t->letters[t->cursor++], 5, "%s", letter);
    t->count++;
}

static void remove_twin(twin *t, int at)
{
    if (at < 0 || at >= t->count) return;
    memmove(t->letters[at], t->letters[at + 1], (size_t)(t->count - at - 1) * 5);
    t->count--;
    if (at < t->cursor) t->cursor--;
}

static void letters_are_edited(void **unused)
{
    (void)unused;
    static const char *const LETTERS[] = {"a", "ä", "€", "😀", " "};
    line_edit edit = {0};
    twin t = {0};
    uint32_t random = 1;
    for (int i = 0; i < 20000; i++) {
        random = random * 1664525u + 1013904223u;
        const uint32_t what = random >> 29;
        if (what < 3 && t.count < 60) {
            const char *letter = LETTERS[(random >> 8) % 5];
            insert_twin(&t, letter);
            edit_type(&edit, (int)utf8_next(&letter));
        } else if (what == 3) {
            if (t.cursor > 0) t.cursor--;
            edit_key(&edit, "left", false);
        } else if (what == 4) {
            if (t.cursor < t.count) t.cursor++;
            edit_key(&edit, "right", false);
        } else if (what == 5) {
            remove_twin(&t, t.cursor - 1);
            edit_key(&edit, "backspace", false);
        } else if (what == 6) {
            remove_twin(&t, t.cursor);
            edit_key(&edit, "delete", false);
        } else if (what == 7 && random >> 20 & 1) {
            t.cursor = random >> 21 & 1 ? 0 : t.count;
            edit_key(&edit, random >> 21 & 1 ? "home" : "end", false);
        }
        char text[300] = "";
        size_t cursor = 0;
        for (int k = 0; k < t.count; k++) {
            if (k == t.cursor) cursor = strlen(text);
            strcat(text, t.letters[k]);
        }
        if (t.cursor == t.count) cursor = strlen(text);
        assert_string_equal(edit.text, text);
        assert_int_equal(edit.cursor, cursor);
    }
}

static void held_keys_repeat(void **unused)
{
    (void)unused;
    key_repeat held = {.key = -1};
    int count = 0;
    assert_int_equal(repeat_next(&held, 5), -1);
    repeat_key(&held, 3, true, 0);
    for (uint64_t ms = 0; ms <= 1000; ms++) count += repeat_next(&held, ms * 1000000u) == 3;
    assert_int_equal(count, 19); /* (1000 - 400) / 33 + 1 */
    repeat_key(&held, 3, false, 1000000000u);
    assert_int_equal(repeat_next(&held, 9000000000u), -1);
}

static console_wish press(console *c, const char *key)
{
    const console_wish wish = console_key(c, input_key_find(key), true, 0);
    console_key(c, input_key_find(key), false, 0);
    return wish;
}

static void type_line(console *c, const char *text)
{
    edit_insert(&c->edit, text);
    assert_int_equal(press(c, "return"), CONSOLE_RUN);
    assert_string_equal(c->line, text);
}

static void what_was_typed_comes_back(void **unused)
{
    (void)unused;
    static console c;
    console_show(&c, true);
    assert_int_equal(press(&c, "return"), CONSOLE_STAY); /* nothing was typed */
    type_line(&c, "one");
    type_line(&c, "two");
    type_line(&c, "two");
    edit_insert(&c.edit, "thr");
    press(&c, "up");
    assert_string_equal(c.edit.text, "two");
    press(&c, "up");
    press(&c, "up");
    assert_string_equal(c.edit.text, "one");
    press(&c, "down");
    press(&c, "down");
    assert_string_equal(c.edit.text, "thr");
    for (int i = 0; i < 3 * CONSOLE_LINES; i++) console_print(&c, "a\tb\n", 4);
    assert_int_equal(c.count, CONSOLE_LINES);
    assert_string_equal(c.lines[c.first].text, "a b");
    press(&c, "pageup");
    assert_true(c.scroll > 0);
    assert_true(console_command(&c, "help position"));
    assert_false(console_command(&c, "help = 3"));
    assert_false(console_command(&c, "helpful"));
    assert_true(console_command(&c, "clear"));
    assert_int_equal(c.count, 0);
    console_free(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_typed_is_recorded_and_replayed),
                                       cmocka_unit_test(escape_closes_the_console_and_not_the_game),
                                       cmocka_unit_test(the_console_shows_itself),
                                       cmocka_unit_test(a_recording_is_left_alone),
                                       cmocka_unit_test(the_inspector_takes_clicks_and_changes_are_recorded),
                                       cmocka_unit_test(fields_are_changed),
                                       cmocka_unit_test(lines_are_answered),
                                       cmocka_unit_test(endless_lines_end_alike),
                                       cmocka_unit_test(lines_that_do_not_fit_are_refused),
                                       cmocka_unit_test(names_are_completed),
                                       cmocka_unit_test(recordings_hold_lines),
                                       cmocka_unit_test(letters_are_edited),
                                       cmocka_unit_test(held_keys_repeat),
                                       cmocka_unit_test(what_was_typed_comes_back)};
    return cmocka_run_group_tests_name("runtime console", tests, open_all, close_all);
}
