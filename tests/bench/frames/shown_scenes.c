/* Rows `scene frame, NAME`: each scene of assets/scenes in quality `game`: with one sample a pixel; as it is, with
 * antialiasing; and doing no more than the peer does: light is not sampled, and mirrors and glass show the sky. Of that
 * there are two, in which neither glass nor what blends throws a shadow: beside the peer whose only shadows are the
 * sun's, without any where no sun casts them, and with all shadows beside the peer that has all. The first camera sways
 * for 120 frames (sway.h), so that each is drawn in full. What the engine keeps from frame to frame stays kept, as for
 * a user. The row also reports the time of a frame in which nothing moves. The peer is llvmpipe, with one sample a
 * pixel and with four. */
#include "frames/users.h"

#include "frames/sway.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum show_kind { SHOW_PLAIN, SHOW_ANTIALIASED, SHOW_EQUAL_WORK, SHOW_ALL_SHADOWS, SHOW_KINDS } show_kind;
static const struct {
    const char *name;
    users_beside peer;
} KINDS[SHOW_KINDS] = {[SHOW_PLAIN] = {"", USERS_BESIDE_PLAIN},
                       [SHOW_ANTIALIASED] = {", antialiased", USERS_BESIDE_ANTIALIASED},
                       [SHOW_EQUAL_WORK] = {", equal work", USERS_BESIDE_PLAIN},
                       [SHOW_ALL_SHADOWS] = {", all shadows", USERS_BESIDE_ALL_SHADOWS}};

static daft_quality quality_of(show_kind kind, const users_show *s)
{
    daft_quality q = daft_preset_quality(DAFT_PRESET_GAME);
    if (kind != SHOW_ANTIALIASED) q.edge_samples = 0;
    if (kind == SHOW_EQUAL_WORK) sway_equal_work(&q, sway_has_sun(s->scene, &s->view));
    if (kind == SHOW_ALL_SHADOWS) sway_equal_work(&q, true);
    return q;
}

/* What light passes, or what blends: it throws no shadow in the peer. */
static bool throws_none(const daft_snapshot *s, const daft_instance *instance)
{
    const uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    if (!(instance->flags & DAFT_INSTANCE_FILTERS_SHADOW)) return instance->flags & DAFT_INSTANCE_TINTS_SHADOW;
    for (uint32_t i = 0; i < slots; i++) {
        const daft_surface *surface = &s->materials[instance->materials[i]];
        if (!daft_surface_blends(surface) || surface->cutoff > 0) return false;
    }
    return true;
}

/* As beside the peer. Entities are made anew, since none changes in that. */
static bool clear_glass(users_show *s, daft_error *error)
{
    daft_scene_frame *frame = daft_frame_take(s->scene, &s->view, SWAY_WIDTH, SWAY_HEIGHT, error);
    bool good = frame != NULL;
    uint32_t count = 0;
    daft_entity *glass = frame ? calloc(frame->snapshot.instance_count + 1, sizeof *glass) : NULL;
    for (uint32_t i = 0; glass && i < frame->snapshot.instance_count; i++)
        if (throws_none(&frame->snapshot, &frame->snapshot.instances[i]))
            glass[count++] = (daft_entity){frame->snapshot.instances[i].entity};
    if (frame) daft_frame_release(s->scene, frame);
    for (uint32_t i = 0; good && i < count; i++) {
        daft_entity_def def;
        good = daft_entity_get(s->scene, glass[i], &def, error);
        def.casts_shadow = false;
        good = good && daft_entity_create(s->scene, &def, error).id && daft_entity_destroy(s->scene, glass[i], error);
    }
    free(glass);
    return good;
}

/* Milliseconds; negative on failure. */
static double draw(users_show *s, const daft_camera *camera, daft_error *error)
{
    daft_view view = s->view;
    view.camera = *camera;
    return users_draw(s, &view, error);
}

/* The sway once: fills `out`. */
static bool show_all(users_show *s, users_frames *out, daft_error *error)
{
    double ms[SWAY_FRAMES];
    *out = (users_frames){.frames = SWAY_FRAMES};
    for (int i = 0; i < SWAY_FRAMES; i++) {
        daft_camera camera = sway(&s->view.camera, i);
        if ((ms[i] = draw(s, &camera, error)) < 0) return false;
        const daft_effect *effects = daft_scene_counters(s->scene)->effects;
        for (int k = 0; k < DAFT_EFFECT_COUNT; k++)
            out->names[k] = effects[k].name, out->effects[k] += effects[k].ms / SWAY_FRAMES;
    }
    out->median = sway_median(ms, SWAY_FRAMES), out->p95 = sway_p95(ms, SWAY_FRAMES);
    return true;
}

static void measure_scene(bench *self, const char *row, const char *path, int threads, show_kind kind)
{
    users_show s;
    daft_error error = {0};
    char text[1200], note[64];
    users_frames best = {0};
    users_beside peer = KINDS[kind].peer;
    fprintf(stderr, "%s, %d thread%s\n", row, threads, threads == 1 ? "" : "s");
    bool good = users_open(self, path, threads, SWAY_WIDTH, SWAY_HEIGHT, &s, &error);
    if (good) s.view.quality = quality_of(kind, &s);
    if (good && (kind == SHOW_EQUAL_WORK || kind == SHOW_ALL_SHADOWS)) good = clear_glass(&s, &error);
    good = good && draw(&s, &s.view.camera, &error) >= 0;
    for (int i = 0; good && i < (self->rounds ? self->rounds : 2); i++) {
        users_frames f;
        good = show_all(&s, &f, &error);
        if (i == 0 || f.median < best.median) best = f;
        users_peer(self, "scene", path, threads, &peer);
    }
    if (good) {
        draw(&s, &s.view.camera, &error);
        snprintf(note, sizeof note, "a still one %.2f ms", draw(&s, &s.view.camera, &error));
        users_report(self, row, threads, &best, &peer, note, 0, 0);
    } else {
        bench_note(self, true, "%s: %s", row, daft_error_text(&error, text, sizeof text));
    }
    users_close(&s);
}

void bench_shown_scenes(bench *self)
{
    struct dirent **files;
    int found = scandir(DAFT_ROOT "/assets/scenes", &files, users_is_scene, alphasort), counts[2];
    int count = bench_thread_counts(self, counts);
    for (int i = 0; i < found; i++) {
        char row[80], path[512];
        snprintf(path, sizeof path, "%s/assets/scenes/%.200s", DAFT_ROOT, files[i]->d_name);
        for (show_kind kind = 0; kind < SHOW_KINDS; kind++) {
            snprintf(row, sizeof row, "scene frame, %.*s%s", (int)(strlen(files[i]->d_name) - 6), files[i]->d_name,
                     KINDS[kind].name);
            if (users_wants(self, row))
                for (int t = 0; t < count; t++) measure_scene(self, row, path, counts[t], kind);
        }
        free(files[i]);
    }
    if (found >= 0) free(files);
}
