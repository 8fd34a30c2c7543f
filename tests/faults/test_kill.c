/* kill -9 at random moments, while the program records, renders and writes. Afterwards each file is the old one or a
 * whole new one, a cut recording plays up to its last whole second, and the next run removes what was left behind.
 *
 * test_kill [N]: kills N times (60). DAFT_TEST_SEED chooses the moments. */
#include "fault_run.h"

typedef struct victim {
    const char *arguments;
    const char *written[4];
    const char *recording; /* or NULL */
    double seconds;        /* that it may run */
} victim;

/* The second one runs for longer than it may, on any machine: it is always cut. */
static const victim VICTIMS[] = {
    {"render a.scene -o a.png --size 40x30 --threads 2 --aov depth,id --stats a.json",
     {"a.png", "a.depth.pfm", "a.id.png", "a.json"},
     NULL,
     0.4},
    {"play game --headless --ticks 400000 --threads 2 --record a.rec --shot a.ppm --size 40x30",
     {"a.rec", "a.ppm"},
     "a.rec",
     1.2},
    {"pack game -o a.daft", {"a.daft"}, NULL, 0.05},
    {"play game --headless --ticks 70 --threads 1 --record a.rec --shot a.ppm --size 40x30",
     {"a.rec", "a.ppm"},
     "a.rec",
     0.5},
};

static unsigned long wrong, replayed;

static void complain(const char *arguments, double after, const char *why)
{
    printf("daft %s, killed after %.4f s: %s\n", arguments, after, why);
    wrong++;
}

/* Files are old or whole. */
static void look_at_files(const victim *who, bool done, double after)
{
    char why[256];
    for (int i = 0; i < 4 && who->written[i]; i++)
        if (!look_at_file(who->written[i], done, why, sizeof why)) complain(who->arguments, after, why);
}

/* What was recorded until then plays: the recording in the making is FILE.part, and grows by a second at a time. */
static void replay_what_is_there(const victim *who, double after)
{
    struct stat part;
    if (stat("a.rec.part", &part) != 0 || part.st_size == 0) return;
    outcome end = run_with(NULL, "play game --headless --replay a.rec.part --size 16x16 --threads 1");
    replayed++;
    if (end.status != 0) complain(who->arguments, after, end.output);
}

/* The next run that writes there removes temporary files of dead processes, once they are old enough. */
static void age_temporaries(void)
{
    DIR *list = opendir(".");
    for (struct dirent *entry; list && (entry = readdir(list));)
        if (ends_with(entry->d_name, ".tmp")) {
            const struct timespec old[2] = {{1000000000, 0}, {1000000000, 0}};
            utimensat(AT_FDCWD, entry->d_name, old, 0);
        }
    closedir(list);
}

static void kill_once(const victim *who)
{
    for (int i = 0; i < 4 && who->written[i]; i++) write_text(who->written[i], OLD);
    unlink("a.rec.part");
    int nowhere = open("/dev/null", O_WRONLY);
    double after = (double)(random_next() % 1000000) * 1e-6 * who->seconds;
    pid_t child = start(NULL, who->arguments, -1, nowhere);
    close(nowhere);
    nanosleep(&(struct timespec){(time_t)after, (long)((after - (double)(time_t)after) * 1e9)}, NULL);
    kill(child, SIGKILL);
    int status = wait_for(child, DEADLINE);
    look_at_files(who, status == 0, after);
    if (who->recording) replay_what_is_there(who, after);
}

static void look_at_the_next_run(void)
{
    char why[256];
    age_temporaries();
    unlink("a.rec.part");
    outcome end = run_with(NULL, VICTIMS[0].arguments);
    if (end.status != 0) complain(VICTIMS[0].arguments, 0, end.output);
    if (!look_for_temporaries(why, sizeof why)) complain(VICTIMS[0].arguments, 0, why);
}

int main(int argc, char **argv)
{
    long times = argc > 1 ? atol(argv[1]) : 60;
    set_up(argv[0]);
    for (long i = 0; i < times; i++) {
        kill_once(&VICTIMS[i % (long)(sizeof VICTIMS / sizeof VICTIMS[0])]);
        if (i % 20 == 19) look_at_the_next_run();
    }
    tear_down();
    if (times >= 60 && replayed == 0) wrong++, printf("no recording was cut: the victims run too short\n");
    printf("%ld kills, %lu cut recordings played, %lu wrong\n", times, replayed, wrong);
    return wrong > 0;
}
