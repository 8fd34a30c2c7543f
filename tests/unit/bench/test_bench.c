/* daft_bench: its options, what it writes, and that its rows say what they are. No figure is judged: only that there is
 * one, and that what is counted beside it holds. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "json.h"

enum { OUTPUT = 1 << 16 };
static char output[OUTPUT], file_text[OUTPUT];

static char *read_all(FILE *from, char *text)
{
    size_t used = from ? fread(text, 1, OUTPUT - 1, from) : 0;
    text[used] = 0;
    return text;
}

/* With `environment` before it; what it says on both streams is in `output`. */
static int run(const char *environment, const char *arguments)
{
    char command[2048];
    snprintf(command, sizeof command, "%s '%s' %s 2>&1 </dev/null", environment, DAFT_BENCH, arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    read_all(pipe, output);
    char rest[4096];
    while (fread(rest, 1, sizeof rest, pipe) > 0) {
    }
    int status = pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void assert_ran(const char *environment, const char *arguments)
{
    int status = run(environment, arguments);
    if (status) fail_msg("daft_bench %s: exit status %d\n%s", arguments, status, output);
}

static void assert_says(const char *text, const char *wanted)
{
    if (!strstr(text, wanted)) fail_msg("'%s' is not in:\n%s", wanted, text);
}

static const char *temporary(const char *extension)
{
    static char path[128];
    snprintf(path, sizeof path, "/tmp/daft-bench-%d.%s", (int)getpid(), extension);
    return path;
}

/* Reads a file into file_text and removes it. */
static void take_file(const char *path)
{
    FILE *file = fopen(path, "r");
    if (!file) fail_msg("there is no %s; the program said:\n%s", path, output);
    read_all(file, file_text);
    fclose(file);
    unlink(path);
}

static void wrong_usage_is_status_2(void **unused)
{
    (void)unused;
    static const char *const wrong[][2] = {{"--olny cow", "there is no option '--olny'"},
                                           {"cow", "there is no option 'cow'"},
                                           {"--json", "a value is missing after '--json'"},
                                           {"--threads 0", "1 to 64 expected, got '0'"},
                                           {"--threads=two", "1 to 64 expected, got 'two'"},
                                           {"--rounds 102", "1 to 101 expected, got '102'"},
                                           {"--isa mmx", "plain, sse2, avx2 or avx512 expected, got 'mmx'"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_int_equal(run("", wrong[i][0]), 2);
        assert_says(output, wrong[i][1]);
        assert_says(output, "--help");
    }
    assert_int_equal(run("", "--only no-such-row"), 1);
    assert_says(output, "no benchmark has 'no-such-row' in its name");
    assert_ran("", "--help");
    assert_says(output, "usage: daft bench");
}

static int lines_of(const char *text)
{
    int lines = 0;
    for (; *text; text++) lines += *text == '\n';
    return lines;
}

/* Every kind of row is listed, nothing is run, and --only leaves the rest out, whatever the case of its letters. */
static void list_names_what_there_is(void **unused)
{
    (void)unused;
    static const char *const names[] = {"cow, close up camera rays, exact",
                                        "1,000 instances of the cow camera rays, fast",
                                        "100,000 instances of the cow frame, one light\n",
                                        "1,000 instances of the cow frame, one light, the camera moves\n",
                                        "10,000 spheres camera rays",
                                        "interior intersection, exact to fast",
                                        "bunny, far frame, one light",
                                        "cow OBJ load, triangles alone",
                                        "cow OBJ load, with normals",
                                        "nefertiti memory",
                                        "marble start-up",
                                        "game frame, marble 95th percentile\n",
                                        "game frame, toppler 95th percentile\n",
                                        "scene frame, town median\n",
                                        "frame, unseen mirror, no light",
                                        "growth, triangles frame, 1k",
                                        "growth, threads frame, 1",
                                        "visibility-accuracy, needles",
                                        "scene frame, hall, all shadows median",
                                        "game frame, marble, all shadows median",
                                        "sim-accuracy, ball and chain",
                                        "sim, 1,000 boxes falling into a pile",
                                        "sim, 5,000 boxes two threads to one",
                                        "sim, 200 ragdolls falling into a pile",
                                        "sim, 10,000 asleep and one awake",
                                        "sim, stack of 20 the top's drift in a minute"};
    assert_ran("", "--list");
    int all = lines_of(output);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) assert_says(output, names[i]);
    assert_null(strstr(output, "growth, triangles frame, 10000k"));
    assert_ran("", "--list --only SPHERES");
    assert_true(lines_of(output) > 1 && lines_of(output) < all / 4);
    for (const char *line = output; line && *line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL)
        assert_non_null(strstr(line, "spheres"));
    assert_ran("", "--list --only growth");
    assert_says(output, "growth, triangles frame, 10000k");
}

/* Users' frames come first, and say what each effect took. */
static void users_frames_lead(void **unused)
{
    (void)unused;
    assert_ran("", "--list");
    assert_int_equal(strncmp(output, "game frame, ", 12), 0);
    assert_ran("", "--only 'scene frame, islands' --rounds 1 --threads 2");
    assert_says(output, "95th percentile");
    assert_says(output, "120 frames, a still one ");
    assert_says(output, " visibility ");
    assert_says(output, " sky ");
}

/* --tables puts rows of a JSON file into the marked sections of a page, with where and how they were measured; what
 * stands outside of the marks stays. */
static void tables_are_filled_from_json(void **unused)
{
    (void)unused;
    char folder[] = "/tmp/daft-tables-XXXXXX", page[64], arguments[512];
    assert_non_null(mkdtemp(folder));
    snprintf(page, sizeof page, "%s/page.md", folder);
    FILE *file = fopen(page, "w");
    assert_non_null(file);
    fputs(
        "before\n<!-- bench: sphere 130k memory; counters -->\nold\n<!-- /bench -->\nbetween\n<!-- bench: no such row "
        "-->\nkept\n<!-- /bench -->\n",
        file);
    fclose(file);
    snprintf(arguments, sizeof arguments, "--only 'sphere 130k memory' --json %s", temporary("json"));
    assert_ran("", arguments);
    snprintf(arguments, sizeof arguments, "--tables %s --from %s", folder, temporary("json"));
    assert_ran("", arguments);
    assert_says(output, "no rows for 'no such row'");
    unlink(temporary("json"));
    take_file(page);
    assert_int_equal(strncmp(file_text, "before\n<!-- bench: sphere 130k memory; counters -->\n", 51), 0);
    assert_says(file_text, "`daft bench --only 'sphere 130k memory'`");
    assert_says(file_text, "| sphere 130k | memory | 1 | ");
    assert_says(file_text, "bytes a triangle |\n<!-- /bench -->\nbetween\n");
    assert_says(file_text, "-->\nkept\n<!-- /bench -->\n");
    assert_null(strstr(file_text, "old"));
    assert_int_equal(rmdir(folder), 0);
    assert_int_equal(run("", "--tables /no/such/folder"), 1);
    assert_says(output, "there is no folder /no/such/folder");
}

static void rows_are_json_with_the_promised_names(void **unused)
{
    (void)unused;
    char arguments[256];
    static const char *const names[] = {"\"scene\": \"cow",
                                        "\"what\": \"intersection, exact to fast\"",
                                        "\"threads\": 1",
                                        "\"isa\": \"" DAFT_NARROWEST_ISA "\"",
                                        "\"ours\": ",
                                        "\"peer\": ",
                                        "\"peer_name\": \"fast\"",
                                        "\"unit\": \"Mray/s\"",
                                        "\"ratio\": ",
                                        "\"floor\": 0.909091",
                                        "\"aim\": ",
                                        "\"budget_of\": \"ratio\"",
                                        "\"counters\": \"fast: ",
                                        "\"what\": \"memory\"",
                                        "\"unit\": \"B/tri\"",
                                        "\"peer\": null",
                                        "\"budget_of\": \"ours\""};
    snprintf(arguments, sizeof arguments,
             "--only 'cow, far inter' --rounds 1 --threads 1 --isa " DAFT_NARROWEST_ISA " --json %s",
             temporary("json"));
    assert_ran("", arguments);
    assert_says(output, "of aim");
    assert_says(output, "have a budget");
    take_file(temporary("json"));
    char first[OUTPUT];
    memcpy(first, file_text, sizeof first);
    const char *end = json_value(first);
    if (!end || *json_blanks(end)) fail_msg("not JSON:\n%s", first);
    snprintf(arguments, sizeof arguments, "--only 'cow memory' --json=%s", temporary("json"));
    assert_ran("", arguments);
    take_file(temporary("json"));
    end = json_value(file_text);
    if (!end || *json_blanks(end)) fail_msg("not JSON:\n%s", file_text);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (!strstr(first, names[i])) assert_says(file_text, names[i]);
    assert_int_equal(run("", "--only 'cow memory' --json /no/such/folder/x.json"), 1);
    assert_says(output, "cannot write /no/such/folder/x.json");
}

/* Without the models a generated mesh is measured, and every row says so. */
static void missing_models_have_stand_ins(void **unused)
{
    (void)unused;
    assert_ran("DAFT_DATA=/no/such/folder", "--only 'cow, far camera rays, exact' --rounds 1 --threads 1");
    assert_says(output, "a generated mesh of 5776 triangles stands in for the cow");
    assert_says(output, "cow stand-in, far  camera rays, exact");
}

/* The exact test is right at every pixel, by its own count; boxes alone are not; the files hold the same rows. */
static void accuracy_is_a_table_a_csv_and_a_plot(void **unused)
{
    (void)unused;
    char arguments[512], csv[128];
    snprintf(csv, sizeof csv, "%s", temporary("csv"));
    snprintf(arguments, sizeof arguments, "--only 'visibility-accuracy, edge' --rounds 1 --csv %s --svg %s", csv,
             temporary("svg"));
    assert_ran("", arguments);
    assert_says(output, "pencil, exact");
    take_file(csv);
    assert_int_equal(strncmp(file_text, "scene,method,threads,isa,width,height,ms,wrong,holes,ghosts\n", 59), 0);
    int rows = 0;
    for (char *line = strtok(strchr(file_text, '\n') + 1, "\n"); line; line = strtok(NULL, "\n"), rows++) {
        char method[64];
        double ms;
        unsigned long long wrong, holes, ghosts;
        assert_int_equal(sscanf(line, "\"edge-aligned grid\",\"%63[^\"]\",1,%*[a-z0-9],1280,720,%lf,%llu,%llu,%llu",
                                method, &ms, &wrong, &holes, &ghosts),
                         5);
        assert_true(ms > 0 && holes + ghosts <= wrong);
        if (strcmp(method, "pencil, exact") == 0 || strcmp(method, "oracle") == 0) assert_int_equal(wrong, 0);
        if (strcmp(method, "boxes alone") == 0) assert_true(wrong > 1000);
    }
    assert_int_equal(rows, 11);
    take_file(temporary("svg"));
    assert_int_equal(strncmp(file_text, "<svg ", 5), 0);
    assert_says(file_text, "edge-aligned grid");
    assert_says(file_text, "milliseconds a frame");
    assert_says(file_text, "</svg>");
}

/* Every rate and number of substeps; what no other beats is marked, and small steps are nearer to the truth. */
static void motion_accuracy_is_a_table_a_csv_and_a_plot(void **unused)
{
    (void)unused;
    char arguments[512], csv[128];
    snprintf(csv, sizeof csv, "%s", temporary("csv"));
    snprintf(arguments, sizeof arguments, "--only 'sim-accuracy, pend' --rounds 1 --csv %s --svg %s", csv,
             temporary("svg"));
    assert_ran("", arguments);
    assert_says(output, "60 Hz, 4 substeps");
    assert_says(output, "FRONT");
    take_file(csv);
    const char *head = "scene,hz,substeps,isa,ms,error_mm,energy,joints_mm,overlap_mm,drift_mm,front\n";
    assert_int_equal(strncmp(file_text, head, strlen(head)), 0);
    int rows = 0, fronts = 0;
    double coarse = 0, fine = 0;
    for (char *line = strtok(strchr(file_text, '\n') + 1, "\n"); line; line = strtok(NULL, "\n"), rows++) {
        int hz, substeps, front;
        double ms, error;
        assert_int_equal(sscanf(line, "\"pendulum\",%d,%d,%*[a-z0-9],%lf,%lf,%*f,%*f,%*f,%*f,%d", &hz, &substeps, &ms,
                                &error, &front),
                         5);
        assert_true(ms > 0 && error > 0);
        fronts += front;
        if (hz == 30 && substeps == 1) coarse = error;
        if (hz == 240 && substeps == 16) fine = error;
    }
    assert_int_equal(rows, 20);
    assert_true(fronts >= 1 && fine < coarse / 10);
    take_file(temporary("svg"));
    assert_int_equal(strncmp(file_text, "<svg ", 5), 0);
    assert_says(file_text, "milliseconds a simulated second");
    assert_says(file_text, "</svg>");
}

/* What does not move is not stepped, by the simulation's own count, and the peer is named whether it is there or not.
 */
static void idle_worlds_do_nothing(void **unused)
{
    (void)unused;
    assert_ran("", "--only 'sim, nothing moves' --rounds 1");
    assert_says(output, "0 bodies, 0 awake, 0 pairs, 0 contacts, 0 rows, 0 substeps, 0 sweeps");
    assert_says(output, "10000 bodies, 0 awake, 0 pairs, 0 contacts, 0 rows, 0 substeps, 0 sweeps");
    assert_says(output, "2000 bodies, 0 awake, 0 pairs, 0 contacts, 0 rows, 0 substeps, 0 sweeps");
    assert_ran("", "--only 'sim, stack of 20 the' --peers");
    assert_says(output, "ODE QuickStep");
    assert_says(output, "it sank ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage_is_status_2),
        cmocka_unit_test(list_names_what_there_is),
        cmocka_unit_test(users_frames_lead),
        cmocka_unit_test(rows_are_json_with_the_promised_names),
        cmocka_unit_test(tables_are_filled_from_json),
        cmocka_unit_test(missing_models_have_stand_ins),
        cmocka_unit_test(accuracy_is_a_table_a_csv_and_a_plot),
        cmocka_unit_test(motion_accuracy_is_a_table_a_csv_and_a_plot),
        cmocka_unit_test(idle_worlds_do_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
