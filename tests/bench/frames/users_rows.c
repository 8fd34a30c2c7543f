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

void users_report(bench *self, const char *scene, int threads, const users_frames *f, const users_beside *peer,
                  const char *note, double floor, double aim)
{
    const bool beside = peer->best.frames > 0;
    bench_row row = {.unit = "ms", .isa = self->isa, .threads = threads};
    row.peer_name = self->peers ? "llvmpipe" : NULL;
    snprintf(row.scene, sizeof row.scene, "%s", scene);
    if (bench_wants(self, scene, P95)) {
        snprintf(row.what, sizeof row.what, "%s", P95);
        row.ours = f->p95, row.peer = beside ? peer->best.p95 : -1, row.budget = (bench_budget){floor, aim, true};
        bench_add(self, &row);
    }
    if (!bench_wants(self, scene, MEDIAN)) return;
    snprintf(row.what, sizeof row.what, "%s", MEDIAN);
    row.ours = f->median, row.peer = beside ? peer->best.median : -1;
    row.budget = (bench_budget){peer->floor, peer->aim, false};
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

/* ---- a scene ---- */

static void ignore(void *user, const daft_error *warning) { (void)user, (void)warning; }

bool users_open(bench *self, const char *path, int threads, int width, int height, users_show *out, daft_error *error)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads, def.isa = self->isa, def.warn = ignore;
    *out = (users_show){.view = daft_default_view(), .threads = threads};
    out->view.quality = daft_preset_quality(DAFT_PRESET_GAME);
    out->engine = daft_engine_create(&def, error);
    if (out->engine) out->scene = daft_scene_create(out->engine, error);
    if (out->scene && daft_scene_load(out->scene, path, error))
        out->image = daft_image_create(out->engine, width, height, error);
    if (out->image) out->view.camera = daft_scene_camera(out->scene, 1);
    return out->image != NULL;
}

void users_close(users_show *show)
{
    daft_image_destroy(show->image);
    if (show->scene) daft_scene_destroy(show->scene);
    if (show->engine) daft_engine_destroy(show->engine);
}

double users_draw(users_show *show, const daft_view *view, daft_error *error)
{
    const double start = bench_clock_ms(show->threads);
    if (!daft_render(show->scene, view, show->image, error)) return -1;
    return bench_clock_ms(show->threads) - start;
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
void users_peer(bench *self, const char *kind, const char *name, int threads, users_beside *peer)
{
    char command[1200], answer[1 << 14]; /* games print, too */
    if (!self->peers) return;
    snprintf(command, sizeof command, "'%s' %s '%s' --threads %d%s", DAFT_LLVMPIPE, kind, name, threads, peer->options);
    FILE *pipe = popen(command, "r");
    answer[pipe ? fread(answer, 1, sizeof answer - 1, pipe) : 0] = 0;
    users_frames now;
    users_read_times(answer, &now);
    if (!pipe || pclose(pipe) != 0 || now.frames < 1)
        bench_note(self, true, "%s: llvmpipe failed", name);
    else if (peer->best.frames == 0 || now.median < peer->best.median)
        peer->best = now;
}
#else
void users_peer(bench *self, const char *kind, const char *name, int threads, users_beside *peer)
{
    (void)self, (void)kind, (void)name, (void)threads, (void)peer;
}
#endif
