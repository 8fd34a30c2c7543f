/* The rows of users' frames. */
#include "frames/users.h"

#include <stdio.h>

static const char P95[] = "95th percentile", MEDIAN[] = "median";

bool users_wants(bench *self, const char *scene)
{
    bool p95 = bench_wants(self, scene, P95), median = bench_wants(self, scene, MEDIAN);
    return p95 || median;
}

static void write_effects(const users_frames *f, const char *note, char *out, size_t size)
{
    int used = snprintf(out, size, "%d frames%s%s; ms:", f->frames, note[0] ? ", " : "", note);
    for (int i = 0; i < DAFT_EFFECT_COUNT && used > 0 && (size_t)used < size; i++)
        if (f->names[i] && f->effects[i] >= 0.005)
            used += snprintf(out + used, size - (size_t)used, " %s %.2f", f->names[i], f->effects[i]);
}

void users_report(bench *self, const char *scene, int threads, const users_frames *f, const char *note, double floor,
                  double aim)
{
    bench_row row = {.unit = "ms", .isa = self->isa, .threads = threads, .peer = -1};
    snprintf(row.scene, sizeof row.scene, "%s", scene);
    if (bench_wants(self, scene, P95)) {
        snprintf(row.what, sizeof row.what, "%s", P95);
        row.ours = f->p95, row.budget = (bench_budget){floor, aim, true};
        bench_add(self, &row);
    }
    if (!bench_wants(self, scene, MEDIAN)) return;
    snprintf(row.what, sizeof row.what, "%s", MEDIAN);
    row.ours = f->median, row.budget = (bench_budget){0};
    write_effects(f, note, row.counters, sizeof row.counters);
    bench_add(self, &row);
}
