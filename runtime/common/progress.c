/* A progress bar on stderr. */
#include "common/progress.h"

#include "common/util.h"

#include <stdio.h>
#include <unistd.h>

void progress_begin(progress_bar *bar, const char *label)
{
    *bar = (progress_bar){.label = label, .shown = isatty(STDERR_FILENO), .began_ns = clock_now_ns()};
}

void progress_show(progress_bar *bar, double done)
{
    enum { WIDTH = 40 };
    uint64_t now = clock_now_ns();
    if (!bar->shown || (bar->last_ns && now - bar->last_ns < 100000000u)) return;
    bar->last_ns = now;
    done = done > 1 ? 1 : done >= 0 ? done : 0;
    int full = (int)(done * WIDTH);
    char cells[WIDTH + 1];
    for (int i = 0; i < WIDTH; i++) cells[i] = i < full ? '#' : '.';
    cells[WIDTH] = 0;
    double seconds = (double)(now - bar->began_ns) / 1e9;
    char left[32] = "";
    /* What has been done says how long the rest takes, once it is enough to tell. */
    if (done > 0.01 && seconds > 1) snprintf(left, sizeof left, ", %.0f s left", seconds * (1 - done) / done);
    fprintf(stderr, "\r%s [%s] %3d%%  %.1f s%s\033[K", bar->label, cells, (int)(done * 100), seconds, left);
    fflush(stderr);
}

void progress_end(progress_bar *bar)
{
    if (bar->shown && bar->last_ns) fprintf(stderr, "\r\033[K");
}
