/* game/governor: on a simulated clock, with machines whose rungs cost other than expected, steps, spikes, drifts and
 * noise of the load. */
#include "session/costs.h"
#include "game/governor.h"

#include "support_content.h"

#include <dirent.h>
#include <math.h>
#include <unistd.h>

#define TARGET 16.6

typedef struct machine {
    governor g;
    double cost[GOVERNOR_RUNGS]; /* of its rungs, really */
    double load;                 /* milliseconds of a frame in full */
    double noise;                /* as a part */
    double spikes, spike_ms;     /* fraction of frames; how much longer */
    uint64_t state;              /* of the random numbers */
    double work[20000];
    int rung[20000];
    int frames;
} machine;

static double chance(machine *m)
{
    m->state ^= m->state << 13, m->state ^= m->state >> 7, m->state ^= m->state << 17;
    return (double)(m->state >> 11) * 0x1p-53;
}

/* What a rung costs beside another, really. */
static double between(machine *m, int rung, int other)
{
    return pow(m->g.known.cost[rung] / m->g.known.cost[other], 0.67 + 0.66 * chance(m));
}

static machine *machine_make(uint64_t seed, double load)
{
    machine *m = calloc(1, sizeof *m);
    assert_non_null(m);
    m->state = 0x9e3779b97f4a7c15u * (seed + 1), m->load = load, m->noise = 0.05;
    governor_begin(&m->g, TARGET, NULL);
    /* Rungs of which each is up to a third nearer to the next, or farther away, than expected. */
    const governor *g = &m->g;
    int full = 0;
    while (g->ladder[full] != governor_full()) full++;
    for (int i = 0; i < GOVERNOR_RUNGS; i++) m->cost[i] = g->known.cost[i];
    for (int i = full - 1; i >= 0; i--)
        m->cost[g->ladder[i]] = m->cost[g->ladder[i + 1]] * between(m, g->ladder[i], g->ladder[i + 1]);
    for (int i = full + 1; i < g->rungs; i++)
        m->cost[g->ladder[i]] = m->cost[g->ladder[i - 1]] * between(m, g->ladder[i], g->ladder[i - 1]);
    return m;
}

/* The display waits for its next picture. */
static void run(machine *m, int frames)
{
    for (int i = 0; i < frames; i++) {
        double work = m->load * m->cost[m->g.rung] * (1 + m->noise * (2 * chance(m) - 1));
        if (chance(m) < m->spikes) work += m->spike_ms;
        m->work[m->frames] = work, m->rung[m->frames++] = m->g.rung;
        governor_frame(&m->g, work, fmax(work, 1000.0 / 60));
    }
}

static int slow_frames(const machine *m, int first, int end)
{
    int slow = 0;
    for (int i = first; i < end; i++) slow += m->work[i] > TARGET;
    return slow;
}

static int changes(const machine *m, int first, int end)
{
    int count = 0;
    for (int i = first + 1; i < end; i++) count += m->rung[i] != m->rung[i - 1];
    return count;
}

/* Whatever happens, no second has two changes. */
static void check_calm(const machine *m)
{
    double since = 1e9;
    for (int i = 1; i < m->frames; i++) {
        since += fmax(m->work[i - 1], 1000.0 / 60);
        if (m->rung[i] == m->rung[i - 1]) continue;
        assert_true(since >= 999);
        since = 0;
    }
}

static void what_fits_is_drawn_in_full(void **unused)
{
    (void)unused;
    for (uint64_t seed = 0; seed < 50; seed++) {
        machine *m = machine_make(seed, 12.5);
        run(m, 3600);
        assert_int_equal(m->rung[m->frames - 1], governor_full());
        assert_int_equal(slow_frames(m, 0, m->frames), 0);
        free(m);
        m = machine_make(seed, 3); /* and what takes next to nothing, still better */
        run(m, 600);
        assert_int_equal(m->rung[m->frames - 1], GOVERNOR_RUNGS - 1);
        free(m);
    }
}

/* After a jump of the load frames are in time again within 30, or after a second step where the machine is far from
 * what was expected; and stay so. */
static void a_step_of_the_load_is_answered(void **unused)
{
    (void)unused;
    const double loads[] = {20, 28, 40};
    int late = 0, tries = 0;
    for (int k = 0; k < 3; k++)
        for (uint64_t seed = 0; seed < 100; seed++) {
            machine *m = machine_make(seed, 12);
            run(m, 600);
            m->load = loads[k];
            run(m, 900);
            if (m->load * m->cost[0] > 0.9 * TARGET) {
                free(m);
                continue; /* no rung keeps it */
            }
            tries++, late += slow_frames(m, 630, 690) > 3;
            /* At most three of a hundred later on, when it knows the machine. */
            assert_true(slow_frames(m, 800, 1500) <= 21);
            m->load = 12;
            run(m, 1800);
            assert_true(m->rung[m->frames - 1] >= governor_full());
            check_calm(m);
            free(m);
        }
    print_message("%d of %d steps needed more than 30 frames\n", late, tries);
    assert_true(late * 20 <= tries);
}

static void a_load_that_drifts_is_followed(void **unused)
{
    (void)unused;
    for (uint64_t seed = 0; seed < 50; seed++) {
        machine *m = machine_make(seed, 10);
        m->noise = 0.1;
        for (int i = 0; i < 120; i++) {
            m->load = 18 - 8 * cos(2 * 3.14159265 * i / 60); /* up and down in a minute, twice */
            run(m, 60);
        }
        assert_true(slow_frames(m, 0, m->frames) <= m->frames / 20);
        check_calm(m);
        free(m);
    }
}

/* Slow frames that come from elsewhere make no picture worse for long, and nothing swings. */
static void spikes_and_noise_change_little(void **unused)
{
    (void)unused;
    for (uint64_t seed = 0; seed < 50; seed++) {
        machine *m = machine_make(seed, 12);
        m->spikes = 0.02, m->spike_ms = 30;
        run(m, 3600);
        assert_true(changes(m, 0, m->frames) <= 2);
        m->spikes = 0.12; /* more than one in twenty: tried, and found to be in vain */
        run(m, 7200);
        int worse = 0;
        for (int i = 3600; i < m->frames; i++) worse += m->rung[i] < governor_full();
        assert_true(worse < (m->frames - 3600) / 2);
        check_calm(m);
        free(m);
    }
}

/* A load between two rungs does not make it go back and forth. */
static void nothing_swings(void **unused)
{
    (void)unused;
    for (uint64_t seed = 0; seed < 100; seed++) {
        machine *m = machine_make(seed, 14 + 0.3 * (double)seed);
        run(m, 600 + 3600);
        if (changes(m, 600, m->frames) > 6) fail_msg("seed %d: %d changes", (int)seed, changes(m, 600, m->frames));
        check_calm(m);
        free(m);
    }
}

static void what_no_rung_keeps_is_drawn_on_the_cheapest(void **unused)
{
    (void)unused;
    machine *m = machine_make(1, 300);
    run(m, 300);
    assert_int_equal(m->rung[m->frames - 1], 0);
    assert_true(changes(m, 0, m->frames) <= 2);
    free(m);
}

/* Where smaller pictures save less than expected, the first start needs several steps; the next one knows, by a file.
 */
static void costs_are_remembered(void **unused)
{
    (void)unused;
    char folder[] = "/tmp/daft-costs-XXXXXX", path[64];
    governor_costs known;
    assert_non_null(mkdtemp(folder));
    assert_false(costs_load(folder, "marble", &known));
    int first_time = 0, second_time = 0;
    for (uint64_t seed = 0; seed < 20; seed++) {
        machine *m = machine_make(seed, 24), *again = machine_make(seed, 24);
        for (int i = 0; i < GOVERNOR_RUNGS; i++) m->cost[i] = again->cost[i] = pow(m->g.known.cost[i], 0.45);
        run(m, 3600);
        costs_save(folder, "marble", &m->g.known);
        assert_true(costs_load(folder, "marble", &known));
        assert_false(costs_load(folder, "another", &known));
        for (int i = 0; i < GOVERNOR_RUNGS; i++) {
            assert_true(fabs(known.cost[i] - m->g.known.cost[i]) < 1e-3);
            assert_true(isnan(known.error[i]));
        }
        governor_begin(&again->g, TARGET, &known);
        run(again, 3600);
        first_time += slow_frames(m, 0, 300), second_time += slow_frames(again, 0, 300);
        free(m), free(again);
    }
    print_message("slow frames: %d at the first start, %d at the second\n", first_time, second_time);
    assert_true(4 * second_time < 3 * first_time);
    assert_false(costs_load("/nowhere", "marble", &known) || costs_load(NULL, "marble", &known));
    DIR *all = opendir(folder);
    assert_non_null(all);
    for (const struct dirent *e; (e = readdir(all));) {
        if (e->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%.32s", folder, e->d_name);
        FILE *file = fopen(path, "wb"); /* what is not such a file is not believed */
        fputs("daft frame costs 4\n0.5 0.1\n-1 0\n", file);
        fclose(file);
        assert_false(costs_load(folder, "marble", &known));
        unlink(path);
    }
    closedir(all);
    rmdir(folder);
}

/* Surveyed rungs: the ladder is the front of cost and error, cheapest first, whatever the machine; the rung of the
 * quality itself is always one of it. */
static void the_ladder_is_the_front(void **unused)
{
    (void)unused;
    for (uint64_t seed = 0; seed < 200; seed++) {
        machine *m = machine_make(seed, 12);
        governor_costs k;
        for (int i = 0; i < GOVERNOR_RUNGS; i++) k.cost[i] = 0.1 + 2 * chance(m), k.error[i] = 0.3 * chance(m);
        k.cost[governor_full()] = 1;
        assert_false(governor_is_surveyed(&m->g));
        governor_survey(&m->g, &k);
        assert_true(governor_is_surveyed(&m->g));
        bool on[GOVERNOR_RUNGS] = {false};
        for (int i = 0; i < m->g.rungs; i++) on[m->g.ladder[i]] = true;
        for (int i = 0; i < GOVERNOR_RUNGS; i++) {
            bool beaten = false;
            for (int j = 0; j < GOVERNOR_RUNGS; j++) beaten |= k.cost[j] < k.cost[i] && k.error[j] < k.error[i];
            assert_int_equal(on[i], !beaten || i == governor_full());
        }
        for (int i = 1; i < m->g.rungs; i++)
            assert_true(m->g.known.cost[m->g.ladder[i]] > m->g.known.cost[m->g.ladder[i - 1]]);
        memcpy(m->cost, m->g.known.cost, sizeof m->cost);
        m->load = 25; /* and it is climbed: rungs that others beat are never chosen */
        run(m, 1200);
        check_calm(m);
        for (int i = 0; i < m->frames; i++) assert_true(on[m->rung[i]]);
        free(m);
    }
}

/* A rung that others beat, on which it stands as the survey ends, is left with the next change. */
static void a_beaten_rung_is_left(void **unused)
{
    (void)unused;
    machine *m = machine_make(3, 26);
    run(m, 300);
    const int stood = m->g.rung;
    assert_true(stood != governor_full());
    governor_costs k = m->g.known;
    for (int i = 0; i < GOVERNOR_RUNGS; i++) k.error[i] = 0.2 / (i + 1);
    for (int i = 0; i < GOVERNOR_RUNGS; i++)
        if (i != stood && k.cost[i] < k.cost[stood]) k.error[i] = 0.001, k.error[stood] = 0.3;
    governor_survey(&m->g, &k);
    m->load = 60;
    run(m, 300);
    assert_true(m->g.rung != stood);
    m->load = 5;
    run(m, 3000);
    for (int i = 600; i < m->frames; i++) assert_true(m->rung[i] != stood);
    free(m);
}

static void nonsense_is_harmless(void **unused)
{
    (void)unused;
    const governor_costs bad = {{NAN, -1, 0, 1e300, INFINITY, 3, 2, 1}, {NAN, -1, 2, INFINITY}};
    governor g;
    governor_begin(&g, TARGET, &bad);
    for (int i = 1; i < g.rungs; i++) {
        const double *cost = g.known.cost;
        assert_true(cost[g.ladder[i]] > cost[g.ladder[i - 1]] && cost[g.ladder[i]] < 100);
    }
    assert_false(governor_frame(&g, NAN, 16));
    assert_false(governor_frame(&g, 5, -1));
    for (int i = 0; i < 500; i++) governor_frame(&g, i % 7 ? 1e12 : 0, 16);
    assert_true(g.rung >= 0 && g.rung < GOVERNOR_RUNGS);
}

/* Rungs above the quality make it better and change nothing that is better or that a game has chosen otherwise. */
static void better_rungs_keep_what_a_game_chose(void **unused)
{
    (void)unused;
    const daft_quality game = daft_preset_quality(DAFT_PRESET_GAME);
    bool sharp = false, smooth = false;
    for (int rung = governor_full(); rung < GOVERNOR_RUNGS; rung++) {
        daft_quality plain = game, pixels = game, fine = daft_preset_quality(DAFT_PRESET_HIGH);
        const daft_quality high = fine;
        pixels.texture_filter = DAFT_TEXTURE_NEAREST;
        governor_set(rung, &plain), governor_set(rung, &pixels), governor_set(rung, &fine);
        assert_int_equal(pixels.texture_filter, DAFT_TEXTURE_NEAREST);
        assert_true(plain.scale == 1 && plain.shadow_samples == game.shadow_samples);
        assert_true(plain.edge_samples >= game.edge_samples && plain.mirror_depth >= game.mirror_depth);
        assert_memory_equal(&fine, &high, sizeof high);
        sharp |= plain.texture_filter == DAFT_TEXTURE_ANISOTROPIC4 && plain.edge_samples == game.edge_samples;
        smooth |= plain.edge_samples == 16 && plain.edge_contrast == 1;
    }
    assert_true(sharp && smooth);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_fits_is_drawn_in_full),
        cmocka_unit_test(a_step_of_the_load_is_answered),
        cmocka_unit_test(a_load_that_drifts_is_followed),
        cmocka_unit_test(spikes_and_noise_change_little),
        cmocka_unit_test(nothing_swings),
        cmocka_unit_test(what_no_rung_keeps_is_drawn_on_the_cheapest),
        cmocka_unit_test(costs_are_remembered),
        cmocka_unit_test(the_ladder_is_the_front),
        cmocka_unit_test(a_beaten_rung_is_left),
        cmocka_unit_test(better_rungs_keep_what_a_game_chose),
        cmocka_unit_test(nonsense_is_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
