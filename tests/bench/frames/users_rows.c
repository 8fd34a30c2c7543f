/* The rows of users' frames. */
#include "frames/users.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

void users_report(bench *self, const char *scene, int threads, const users_frames *f, const users_frames *peer,
                  const char *note, double floor, double aim)
{
    const bool beside = peer->frames > 0;
    bench_row row = {.unit = "ms", .isa = self->isa, .threads = threads};
    row.peer_name = self->peers ? "llvmpipe" : NULL;
    snprintf(row.scene, sizeof row.scene, "%s", scene);
    if (bench_wants(self, scene, P95)) {
        snprintf(row.what, sizeof row.what, "%s", P95);
        row.ours = f->p95, row.peer = beside ? peer->p95 : -1, row.budget = (bench_budget){floor, aim, true};
        bench_add(self, &row);
    }
    if (!bench_wants(self, scene, MEDIAN)) return;
    snprintf(row.what, sizeof row.what, "%s", MEDIAN);
    row.ours = f->median, row.peer = beside ? peer->median : -1, row.budget = (bench_budget){1.3, 2, false};
    write_effects(f, note, row.counters, sizeof row.counters);
    bench_add(self, &row);
}

int users_is_scene(const struct dirent *entry)
{
    const char *dot = strrchr(entry->d_name, '.');
    return dot && strcmp(dot, ".scene") == 0;
}

int users_has_demo(const struct dirent *entry)
{
    char path[512];
    if (entry->d_name[0] == '.') return 0;
    snprintf(path, sizeof path, "%s/games/%.200s/demo.rec", DAFT_ROOT, entry->d_name);
    return daft_file_exists(NULL, path);
}

/* ---- the peer ---- */

double users_number(const char *json, const char *name)
{
    char key[64];
    snprintf(key, sizeof key, "\"%s\":", name);
    const char *found = json ? strstr(json, key) : NULL;
    return found ? strtod(found + strlen(key), NULL) : -1;
}

void users_read_times(const char *json, users_frames *out)
{
    const char *frame = strstr(json, "\"frame_ms\"");
    *out = (users_frames){.median = users_number(frame, "median"),
                          .p95 = users_number(frame, "p95"),
                          .frames = (int)users_number(frame, "frames")};
}

#ifdef DAFT_LLVMPIPE
void users_peer(bench *self, const char *kind, const char *name, int threads, bool smooth, users_frames *best)
{
    char command[1200], answer[1 << 14]; /* games print, too */
    if (!self->peers) return;
    snprintf(command, sizeof command, "'%s' %s '%s' --threads %d%s", DAFT_LLVMPIPE, kind, name, threads,
             smooth ? " --antialiased" : "");
    FILE *pipe = popen(command, "r");
    answer[pipe ? fread(answer, 1, sizeof answer - 1, pipe) : 0] = 0;
    users_frames now;
    users_read_times(answer, &now);
    if (!pipe || pclose(pipe) != 0 || now.frames < 1)
        bench_note(self, true, "%s: llvmpipe failed", name);
    else if (best->frames == 0 || now.median < best->median)
        *best = now;
}
#else
void users_peer(bench *self, const char *kind, const char *name, int threads, bool smooth, users_frames *best)
{
    (void)self, (void)kind, (void)name, (void)threads, (void)smooth, (void)best;
}
#endif
