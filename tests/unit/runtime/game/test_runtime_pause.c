/* runtime: the pause menu: settings, the player's keys, a new start. */
#include "session/costs.h"
#include "runtime_program.h"
#include "scripted_session.h"

/* ---- the pause menu ---- */

static session_end play_and_pause(void)
{
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    session_end end = play("sample");
    tear_down();
    return end;
}

static void escape_pauses_and_the_game_stands_still(void **unused)
{
    (void)unused;
    int count;
    make_folder();
    /* Held when the menu opens: let go. In the menu the game hears nothing. */
    const happening script[] = {{5, "+left", 0, 0},   {10, "+escape", 0, 0}, {11, "-escape", 0, 0},
                                {40, "+right", 0, 0}, {60, "+escape", 0, 0}, {70, "+escape", 0, 0},
                                {80, "+up", 0, 0},    {81, "+return", 0, 0}};
    PLAY(script);
    assert_int_equal(play_and_pause(), SESSION_LEFT);
    assert_in_range(ticks_recorded(), 18, 22);
    assert_true(s.screen.hidden);
    count_lines(recorded, "-left", &count);
    assert_int_equal(count, 1);
    count_lines(recorded, "right", &count);
    assert_int_equal(count, 0);
    count_lines(recorded, "escape", &count);
    assert_int_equal(count, 0);
    const happening close[] = {{5, "+pad start", 0, 0}, {20, "close", 0, 0}};
    PLAY(close);
    assert_int_equal(play_and_pause(), SESSION_CLOSED);
    drop_folder();
}

static void the_pause_menu_shows_itself_and_goes_by_mouse(void **unused)
{
    (void)unused;
    make_folder();
    /* Nothing changes but by the menu: opened, the last row chosen by the mouse, and left by a click on it. */
    const happening script[] = {{5, "+escape", 0, 0}, {30, "click", 0.5f, 0.761f}};
    PLAY(script);
    assert_int_equal(play_and_pause(), SESSION_LEFT);
    const uint64_t with = s.screen.changed;
    assert_true(with >= 1);
    const happening miss[] = {{5, "+escape", 0, 0},
                              {30, "click", 0.1f, 0.761f},
                              {40, "click", 0.5f, 0.3f},
                              {60, "close", 0, 0}}; /* beside the rows; then "Continue" */
    PLAY(miss);
    assert_int_equal(play_and_pause(), SESSION_CLOSED);
    assert_in_range(ticks_recorded(), 20, 28);
    drop_folder();
}

/* In a few seconds of play, or behind the menu, all rungs of the governor are measured; the figures are kept. */
static void the_rungs_are_surveyed(void **unused)
{
    (void)unused;
    const happening plays[] = {{900, "close", 0, 0}}, pauses[] = {{5, "+escape", 0, 0}, {120, "close", 0, 0}};
    for (int i = 0; i < 2; i++) {
        make_folder();
        if (i)
            PLAY(pauses);
        else
            PLAY(plays);
        s.def.pauses = true, s.def.settings = folder, s.def.costs = folder, s.def.target_ms = 400;
        governor_costs known;
        assert_false(costs_load(folder, "physics", &known));
        assert_int_equal(play("physics"), SESSION_CLOSED);
        tear_down();
        assert_true(costs_load(folder, "physics", &known));
        for (int k = 0; k < GOVERNOR_RUNGS; k++) assert_true(known.cost[k] > 0 && known.error[k] >= 0);
        /* Half of the pixels, without smooth edges, are farther from the reference than all of them. */
        assert_true(known.error[0] > known.error[governor_full()]);
        drop_folder();
    }
}

static void settings_last(void **unused)
{
    (void)unused;
    char path[96];
    int count;
    make_folder();
    snprintf(path, sizeof path, "%s/DAFT.settings.save", folder);
    const happening script[] = {{2, "+escape", 0, 0}, {3, "+down", 0, 0},   {3, "+left", 0, 0},  {3, "+left", 0, 0},
                                {4, "+down", 0, 0},   {5, "+right", 0, 0},  {6, "+right", 0, 0}, {7, "+down", 0, 0},
                                {8, "+left", 0, 0},   {9, "+escape", 0, 0}, {12, "close", 0, 0}};
    PLAY(script);
    play_and_pause();
    count_lines(path, "pace 2 volume 7 full_screen 0 picture 3", &count);
    assert_int_equal(count, 1);
    const happening again[] = {
        {2, "+escape", 0, 0}, {3, "+down", 0, 0}, {4, "+down", 0, 0}, {5, "+left", 0, 0}, {12, "close", 0, 0}};
    PLAY(again);
    play_and_pause();
    count_lines(path, "pace 1 volume 7 full_screen 0 picture 3", &count);
    assert_int_equal(count, 1);
    /* A file of before pictures had a row. */
    static const char old[] = "daft-save 1\npace 2 volume 6 full_screen 0\n";
    daft_error error;
    assert_true(daft_write_file(path, old, sizeof old - 1, &error));
    PLAY(again);
    play_and_pause();
    count_lines(path, "pace 1 volume 6 full_screen 0 picture 0", &count);
    assert_int_equal(count, 1);
    /* What cannot be read is as if it had not been there. */
    static const char wrong[] = "daft-save 1\npace 99 volume 7 full_screen 0\n";
    assert_true(daft_write_file(path, wrong, sizeof wrong - 1, &error));
    PLAY(again);
    play_and_pause();
    count_lines(path, "pace 4 volume 8 full_screen 0 picture 0", &count);
    assert_int_equal(count, 1);
    drop_folder();
}

/* The player's quality is what pictures have, from the next one on; where the program was started with one, from the
 * player's first change on. */
static void the_player_chooses_the_picture(void **unused)
{
    (void)unused;
    uint64_t seen[3];
    make_folder();
    for (int i = 0; i < 3; i++) {
        const happening high[] = {{2, "+escape", 0, 0}, {3, "+down", 0, 0},   {3, "+right", 0, 0}, {4, "+right", 0, 0},
                                  {5, "+right", 0, 0},  {6, "+escape", 0, 0}, {20, "close", 0, 0}};
        const happening none[] = {{2, "+escape", 0, 0}, {6, "+escape", 0, 0}, {20, "close", 0, 0}};
        if (i == 0)
            PLAY(none);
        else if (i == 1)
            PLAY(high);
        else
            PLAY(none); /* it lasts */
        s.def.quality.preset = QUALITY_OF_SCENE, s.def.target_ms = 0;
        play_and_pause();
        seen[i] = s.screen.hash;
    }
    assert_true(seen[1] != seen[0] && seen[2] == seen[1]);
    drop_folder();
}

/* The game binds "jump" to Space; the player wants J for it, which the recording knows nothing of. */
static void other_keys_are_chosen_in_the_menu(void **unused)
{
    (void)unused;
    int count;
    make_folder();
    const happening script[] = {
        {3, " a", 0, 0},      {4, "+escape", 0, 0},  {5, "+down", 0, 0},      {5, "+down", 0, 0},    {6, "+down", 0, 0},
        {7, "+down", 0, 0},   {8, "+down", 0, 0},    {9, "+return", 0, 0},    {10, "+return", 0, 0}, {11, "+f1", 0, 0},
        {12, "+j", 0, 0},     {13, "+escape", 0, 0}, {14, "+escape", 0, 0},   {20, "+j", 0, 0},      {22, "-j", 0, 0},
        {24, "+space", 0, 0}, {26, "-space", 0, 0},  {30, " \xc3\xa4", 0, 0}, {40, "close", 0, 0}};
    PLAY(script);
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    assert_int_equal(play("actions"), SESSION_CLOSED);
    tear_down();
    count_lines(recorded, "+space", &count);
    assert_int_equal(count, 1);
    count_lines(recorded, "+j", &count);
    assert_int_equal(count, 0);
    count_lines(recorded, "text 00e4", &count);
    assert_int_equal(count, 1);
    /* It lasts; and all is as at first again by the last row but one. */
    const happening again[] = {
        {10, "+j", 0, 0},      {12, "-j", 0, 0},      {14, "+escape", 0, 0}, {15, "+down", 0, 0},
        {15, "+down", 0, 0},   {16, "+down", 0, 0},   {17, "+down", 0, 0},   {18, "+down", 0, 0},
        {19, "+return", 0, 0}, {20, "+up", 0, 0},     {21, "+up", 0, 0},     {22, "+return", 0, 0},
        {23, "+escape", 0, 0}, {24, "+escape", 0, 0}, {30, "+j", 0, 0},      {40, "close", 0, 0}};
    PLAY(again);
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    assert_int_equal(play("actions"), SESSION_CLOSED);
    tear_down();
    count_lines(recorded, "+space", &count);
    assert_int_equal(count, 1);
    count_lines(recorded, "+j", &count);
    assert_int_equal(count, 1);
    drop_folder();
}

/* "jump" by the left trigger, and "walk" by the right stick, the other way round: the recording has what the game asked
 * for, and its replay does the same. */
static void sticks_are_chosen_in_the_menu(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    int count;
    make_folder();
    const happening script[] = {{4, "+escape", 0, 0},
                                {5, "+down", 0, 0},
                                {5, "+down", 0, 0},
                                {6, "+down", 0, 0},
                                {7, "+down", 0, 0},
                                {8, "+down", 0, 0},
                                {9, "+return", 0, 0},
                                {10, "+return", 0, 0},
                                {11, "~left trigger", 0.3f, 0},
                                {12, "~left trigger", 0.9f, 0},
                                {13, "~left trigger", 0, 0},
                                {14, "+up", 0, 0},
                                {14, "+up", 0, 0},
                                {15, "+up", 0, 0},
                                {16, "+return", 0, 0},
                                {17, "+x", 0, 0},
                                {18, "~right trigger", 1, 0},
                                {19, "~right x", -0.8f, 0},
                                {20, "+escape", 0, 0},
                                {21, "+escape", 0, 0},
                                {30, "~left trigger", 0.55f, 0},
                                {32, "~left trigger", 0.45f, 0},
                                {34, "~left trigger", 0.3f, 0},
                                {36, "~right x", -0.5f, 0},
                                {38, "~right x", 0.25f, 0},
                                {39, "+space", 0, 0},
                                {40, "~left x", 1, 0},
                                {50, "close", 0, 0}};
    PLAY(script);
    s.def.pauses = true, s.def.record = recorded, s.def.settings = folder;
    assert_int_equal(play("actions"), SESSION_CLOSED);
    tear_down();
    static const struct {
        const char *line;
        int count;
    } WANTED[] = {{"+space", 1},  {"-space", 1}, {"stick 0.5 left x", 1}, {"stick -0.25 left x", 1},
                  {"trigger", 0}, {"right x", 0}};
    for (size_t i = 0; i < COUNT_OF(WANTED); i++) {
        count_lines(recorded, WANTED[i].line, &count);
        if (count != WANTED[i].count) fail_msg("'%s' is recorded %d times", WANTED[i].line, count);
    }
    assert_status(run_daft(output, "play tests/games/actions --headless --hash --strict --replay %s", recorded), 0,
                  output);
    drop_folder();
}

/* It is part of the recording: the replay starts again at the same tick. */
static void starting_again_is_replayed(void **unused)
{
    (void)unused;
    static char output[OUTPUT_SIZE];
    make_folder();
    const happening script[] = {
        {30, "+escape", 0, 0}, {31, "+up", 0, 0}, {32, "+up", 0, 0}, {33, "+return", 0, 0}, {60, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_and_pause(), SESSION_CLOSED);
    int count;
    count_lines(recorded, "+start again", &count);
    assert_int_equal(count, 1);
    const int ticks = ticks_recorded();
    char before[64];
    snprintf(before, sizeof before, "tick %d state 0x", ticks);
    assert_status(run_daft(output, "play tests/games/sample --headless --hash --replay %s", recorded), 0, output);
    assert_says(output, before);
    char with[32];
    snprintf(with, sizeof with, "%.18s", strstr(output, "state ") + 6);
    assert_status(run_daft(output, "play tests/games/sample --headless --hash --ticks %d", ticks), 0, output);
    assert_true(strstr(output, with) == NULL); /* it would be elsewhere without */
    drop_folder();
}

/* The game binds places; what it shows is what the player reads there, or has chosen instead. */
static void keys_are_told_as_the_player_reads_them(void **unused)
{
    (void)unused;
    char now[128];
    begin_changing(
        "daft.input.bind('walk', 'a', 'left')\n"
        "local shown = ''\n"
        "function daft.draw()\n"
        "  shown = daft.input.label('walk') .. ' ' .. daft.input.label('w') .. ' ' .. daft.input.label('left')\n"
        "    .. ' ' .. daft.input.label('+left x')\n"
        "end\n"
        "function daft.update() daft.save('x', shown) end\n");
    const happening script[] = {{20, "close", 0, 0}};
    PLAY(script);
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_non_null(strstr(now, "Q Z Left left stick right"));
    /* "walk" by the key in the place of M. */
    const happening other[] = {{4, "+escape", 0, 0},  {5, "+up", 0, 0},     {5, "+up", 0, 0}, {6, "+up", 0, 0},
                               {7, "+return", 0, 0},  {8, "+return", 0, 0}, {9, "+;", 0, 0},  {10, "+escape", 0, 0},
                               {11, "+escape", 0, 0}, {40, "close", 0, 0}};
    PLAY(other);
    s.def.pauses = true;
    assert_int_equal(play_changing(), SESSION_CLOSED);
    saved_x(now);
    assert_non_null(strstr(now, "M Z Left left stick right"));
    drop_folder();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(escape_pauses_and_the_game_stands_still),
                                       cmocka_unit_test(the_pause_menu_shows_itself_and_goes_by_mouse),
                                       cmocka_unit_test(the_rungs_are_surveyed),
                                       cmocka_unit_test(settings_last),
                                       cmocka_unit_test(the_player_chooses_the_picture),
                                       cmocka_unit_test(other_keys_are_chosen_in_the_menu),
                                       cmocka_unit_test(sticks_are_chosen_in_the_menu),
                                       cmocka_unit_test(starting_again_is_replayed),
                                       cmocka_unit_test(keys_are_told_as_the_player_reads_them)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
