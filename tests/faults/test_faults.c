/* Faults on purpose: each call of each kind that the program makes (see fault.c) fails once, or from there on, while it
 * renders, checks, plays, records and writes. Afterwards: exit status 0 or 1, with one message where it is 1; each file
 * it writes is the old one or a whole new one; no temporary file is left; nothing hangs.
 *
 * test_faults [--all | --every] [KIND...]: of calls that are many (more than FEW) a sample of three, with --all of
 * STRATA, one from each part of the run, other ones each time that DAFT_TEST_SEED is another; with --every, each call,
 * which takes an hour. */
#include "fault_run.h"

enum { FEW = 5, SAMPLES = 3, STRATA = 40 };

typedef struct action {
    const char *name, *arguments;
    const char *written[4];
} action;

static const action ACTIONS[] = {
    {"render",
     "render a.scene -o a.png --size 40x30 --threads 3 --aov depth,id --stats a.json",
     {"a.png", "a.depth.pfm", "a.id.png", "a.json"}},
    {"check", "check a.scene game a.png", {NULL}},
    {"play",
     "play game --headless --ticks 70 --threads 2 --hash --record a.rec --shot a.ppm --size 40x30",
     {"a.rec", "a.ppm"}},
    {"pack", "pack game -o a.daft", {"a.daft"}},
    {"play packed", "play old.daft --headless --ticks 20 --threads 1 --shot a.ppm --size 40x30", {"a.ppm"}},
    {"pictures", "video a.scene -o a%d.png --fps 2 --to 1 --size 40x30 --threads 2", {"a0.png", "a1.png"}},
    {"film", "video a.scene -o a.mp4 --fps 5 --to 1 --size 40x30 --threads 2", {"a.mp4"}},
    {"replay", "play game --headless --replay old.rec --threads 1 --size 16x16 --shot a.png", {"a.png"}},
};

static const char *const KINDS[] = {"malloc", "open", "read",   "write", "rename",
                                    "fsync",  "mmap", "thread", "clock", "back"};

static bool every;
static long samples = SAMPLES;
static unsigned long runs, wrong;

/* What a film that failed leaves for the next call would be taken over. */
static void forget_parts(void)
{
    if (system("rm -rf ./*.parts") != 0) give_up("remove parts");
}

/* One run with the N-th call failing. False: the program makes no N-th call. */
static bool strike(const action *what, const char *kind, long n, bool go_on)
{
    char fault[64];
    snprintf(fault, sizeof fault, "%s:%ld%s", kind, n, go_on ? "+" : "");
    for (int i = 0; i < 4 && what->written[i]; i++) write_text(what->written[i], OLD);
    forget_parts();
    outcome end = run_with(fault, what->arguments);
    runs++;
    char why[256] = "";
    if (!look_at(&end, what->written, why, sizeof why)) {
        wrong++;
        printf("daft %s with DAFT_FAULT=%s: %s\n%s\n", what->arguments, fault, why, end.output);
        fflush(stdout);
    }
    return end.struck;
}

/* How many calls of the kind the action makes, to within a factor of two. */
static long count_calls(const action *what, const char *kind)
{
    long n = 1;
    while (strike(what, kind, n, false)) n *= 2;
    return n;
}

static void strike_everywhere(const action *what, const char *kind, bool go_on)
{
    long reach = every ? 0 : count_calls(what, kind), n = 1;
    while (n <= FEW || every)
        if (!strike(what, kind, n++, go_on)) return;
    for (long i = 0; i < samples; i++) {
        long first = FEW + 1 + i * reach / samples, width = reach / samples + 1;
        strike(what, kind, first + (long)(random_next() % (uint64_t)width), go_on);
    }
}

/* FFmpeg's libraries end the process where memory is out. */
static bool aborts(const action *what, const char *kind)
{
    return strcmp(what->name, "film") == 0 && strcmp(kind, "malloc") == 0;
}

int main(int argc, char **argv)
{
    set_up(argv[0]);
    int options = 0;
    for (int i = 1; i < argc; i++) {
        bool all = strcmp(argv[i], "--all") == 0, each = strcmp(argv[i], "--every") == 0;
        if (all) samples = STRATA;
        every |= each;
        options += all || each;
    }
    for (size_t a = 0; a < sizeof ACTIONS / sizeof ACTIONS[0]; a++) {
        outcome first = run_with("none:1", ACTIONS[a].arguments);
        if (first.status != 0) printf("daft %s: %s\n", ACTIONS[a].arguments, first.output), wrong++;
        for (size_t k = 0; k < sizeof KINDS / sizeof KINDS[0]; k++) {
            bool chosen = argc == 1 + options;
            for (int i = 1; i < argc; i++) chosen |= strcmp(argv[i], KINDS[k]) == 0;
            if (!chosen || aborts(&ACTIONS[a], KINDS[k])) continue;
            strike_everywhere(&ACTIONS[a], KINDS[k], false);
            if (strcmp(KINDS[k], "malloc") == 0 || strcmp(KINDS[k], "thread") == 0)
                strike_everywhere(&ACTIONS[a], KINDS[k], true);
        }
    }
    tear_down();
    printf("%lu runs, %lu wrong\n", runs, wrong);
    return wrong > 0;
}
