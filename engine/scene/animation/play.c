/* Clips that play: their times, in ticks; passing over from one to the next; what of it is the game's state. */
#include "scene/animation/animation.h"

#include <stdio.h>
#include <string.h>

/* ---- clips of a mesh ---- */

static const daft_rig_clip *clip_of(const daft_mesh_item *mesh, uint32_t clip, daft_error *error)
{
    const uint32_t count = mesh->rig ? mesh->rig->clip_count : 0;
    if (clip < count) return &mesh->rig->clips[clip];
    if (count == 0)
        daft_fail(error, DAFT_ERROR_ARGUMENT, "the mesh has no clips");
    else
        daft_fail(error, DAFT_ERROR_ARGUMENT, "clip is %u; the mesh has %u, counted from 0", clip, count);
    return NULL;
}

bool daft_mesh_get_clip(daft_scene *scene, daft_mesh mesh, uint32_t clip, daft_clip_info *out, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "out", out)) return false;
    const daft_mesh_item *item = daft_mesh_find(scene, mesh, error);
    const daft_rig_clip *from = item ? clip_of(item, clip, error) : NULL;
    if (!from) return false;
    *out = (daft_clip_info){.duration = from->duration, .low = from->low, .high = from->high};
    snprintf(out->name, sizeof out->name, "%s", from->name);
    return true;
}

bool daft_mesh_find_clip(const daft_scene *scene, daft_mesh mesh, const char *name, uint32_t *clip, daft_error *error)
{
    char known[300] = "";
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "name", name) ||
        !daft_check_pointer(error, "clip", clip))
        return false;
    const daft_mesh_item *item = daft_mesh_find(scene, mesh, error);
    if (!item || !clip_of(item, 0, error)) return false;
    for (uint32_t i = 0; i < item->rig->clip_count; i++) {
        const size_t used = strlen(known);
        if (strcmp(item->rig->clips[i].name, name) == 0) {
            *clip = i;
            return true;
        }
        snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", item->rig->clips[i].name);
    }
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "the mesh has no clip '%.60s'; it has %s", name, known);
}

/* ---- times ---- */

/* Looped: from 0 to less than the duration. Not looped: within the clip. */
static double within(double time, double duration, bool loop)
{
    if (!(duration > 0)) return 0;
    if (!loop) return time < 0 ? 0 : time > duration ? duration : time;
    const double t = time - floor(time / duration) * duration;
    return t < duration ? t : 0; /* rounding may reach the end */
}

static double duration_of(const daft_scene *scene, const daft_animated *a, const daft_track *track)
{
    return daft_animated_mesh(scene, a)->rig->clips[track->clip].duration;
}

static bool has_ended(const daft_track *t, double duration)
{
    return !t->loop && (t->speed < 0 ? t->time <= 0 : t->time >= duration);
}

/* False: nothing of it has changed. */
static bool step_track(daft_track *t, double duration, double dt)
{
    const double before = t->time, wish = before + (double)t->speed * dt;
    t->time = within(wish, duration, t->loop);
    t->step = t->loop ? (double)t->speed * dt : t->time - before;
    t->more = t->blend - t->done < dt ? t->blend - t->done : dt;
    t->done += t->more;
    return (t->step != 0 && duration > 0) || t->more != 0;
}

/* What the newest that has fully come in covers goes, one tick later, since pictures are between ticks. */
static void drop_covered(daft_animated *a)
{
    uint32_t first = a->track_count - 1;
    while (first > 0 && !(a->tracks[first].done >= a->tracks[first].blend && a->tracks[first].more == 0)) first--;
    memmove(a->tracks, a->tracks + first, (a->track_count - first) * sizeof *a->tracks);
    a->track_count -= first;
}

void daft_animations_step(daft_scene *scene, float dt)
{
    for (daft_animated *a = scene->animated; a; a = a->next) {
        bool changed = false;
        for (uint32_t i = 0; i < a->track_count; i++)
            changed |= step_track(&a->tracks[i], duration_of(scene, a, &a->tracks[i]), (double)dt);
        drop_covered(a);
        if (!changed) continue;
        a->stepped = scene->moved_tick = scene->tick;
        daft_scene_touch(scene);
    }
}

uint32_t daft_tracks_layers(const daft_scene *scene, const daft_animated *a, const daft_rig *rig, float alpha,
                            daft_rig_layer out[DAFT_RIG_LAYERS])
{
    const double back = a->stepped == scene->tick ? 1 - (double)alpha : 0; /* of a tick */
    uint32_t count = 0;
    for (uint32_t i = 0; i < a->track_count; i++) {
        const daft_track *t = &a->tracks[i];
        const double time = within(t->time - t->step * back, rig->clips[t->clip].duration, t->loop);
        const double done = t->done - t->more * back;
        const double weight = t->blend > 0 && done < t->blend ? done / t->blend : 1;
        if (weight >= 1) count = 0;
        out[count++] = (daft_rig_layer){t->clip, time, weight};
    }
    return count;
}

/* ---- playing ---- */

static daft_track track_of(const daft_play_def *def, double duration)
{
    daft_track t = {.clip = def->clip, .loop = def->loop, .speed = def->speed, .blend = (double)def->blend};
    const double start = (double)def->start;
    t.time = within(def->speed < 0 ? duration - start : start, duration, def->loop && start > 0);
    return t;
}

static bool play_check(const daft_mesh_item *mesh, const daft_play_def *def, daft_error *error)
{
    return daft_check_pointer(error, "def", def) && daft_struct_check(DAFT_STRUCT_PLAY_DEF, def, error) &&
           clip_of(mesh, def->clip, error);
}

daft_play_def daft_default_play_def(void)
{
    daft_play_def def;
    daft_struct_default(DAFT_STRUCT_PLAY_DEF, &def);
    return def;
}

daft_animated *daft_animated_make(daft_scene *scene, const daft_mesh_item *mesh, const daft_play_def *def,
                                  daft_error *error)
{
    if (!play_check(mesh, def, error)) return NULL;
    daft_animated *a = daft_alloc_zero(scene->allocator, 1, sizeof *a);
    if (!a) {
        daft_fail_memory(error, "an animation");
        return NULL;
    }
    a->space = daft_rig_space_make(scene->allocator, mesh->rig, error);
    if (!a->space) {
        daft_release(scene->allocator, a);
        return NULL;
    }
    a->tracks[0] = track_of(def, mesh->rig->clips[def->clip].duration);
    a->tracks[0].blend = 0;
    a->track_count = 1;
    a->entity = DAFT_NONE;
    a->stepped = UINT64_MAX;
    return a;
}

void daft_animated_attach(daft_scene *scene, uint32_t entity, daft_animated *a)
{
    a->entity = entity;
    a->next = scene->animated;
    if (a->next) a->next->previous = a;
    scene->animated = scene->entities[entity].animated = a;
}

/* One more track over the others; where there are too many, the oldest goes. */
static void add_track(daft_animated *a, const daft_track *track)
{
    if (a->track_count == DAFT_RIG_LAYERS) {
        memmove(a->tracks, a->tracks + 1, (DAFT_RIG_LAYERS - 1) * sizeof *a->tracks);
        a->track_count--;
    }
    if (!(track->blend > 0)) a->track_count = 0;
    a->tracks[a->track_count++] = *track;
}

static void play_over(const daft_mesh_item *mesh, daft_animated *a, const daft_play_def *def)
{
    daft_track *top = &a->tracks[a->track_count - 1];
    const double duration = mesh->rig->clips[def->clip].duration;
    const bool goes_on = top->clip == def->clip && !def->restart && !has_ended(top, duration);
    if (goes_on) {
        top->speed = def->speed, top->loop = def->loop;
        return;
    }
    const daft_track track = track_of(def, duration);
    add_track(a, &track);
}

bool daft_entity_get_mesh(daft_scene *scene, daft_entity entity, daft_mesh *out, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || !daft_check_pointer(error, "out", out)) return false;
    if (item->def.shape != DAFT_SHAPE_MESH) return daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity shows no mesh");
    *out = item->def.mesh;
    return true;
}

bool daft_entity_play(daft_scene *scene, daft_entity entity, const daft_play_def *def, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item) return false;
    if (item->def.shape != DAFT_SHAPE_MESH)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity shows no mesh, so it has no clips");
    const daft_mesh_item *mesh = scene->assets.meshes[daft_asset_index(item->def.mesh.id)];
    if (!play_check(mesh, def, error)) return false;
    if (!item->animated) {
        daft_animated *a = daft_animated_make(scene, mesh, def, error);
        if (!a) return false;
        daft_animated_attach(scene, daft_handle_index(entity.id), a);
    } else {
        play_over(mesh, item->animated, def);
    }
    daft_scene_touch(scene);
    return true;
}

bool daft_entity_stop(daft_scene *scene, daft_entity entity, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item) return false;
    if (item->animated) daft_scene_touch(scene);
    daft_animated_free(scene, item->animated);
    item->animated = NULL;
    return true;
}

/* ---- asking ---- */

bool daft_entity_get_animation(daft_scene *scene, daft_entity entity, daft_animation *out, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || !daft_check_pointer(error, "out", out) || !item->animated) return false;
    const daft_track *t = &item->animated->tracks[item->animated->track_count - 1];
    *out = (daft_animation){.clip = t->clip,
                            .time = t->time,
                            .speed = t->speed,
                            .loop = t->loop,
                            .playing = !has_ended(t, duration_of(scene, item->animated, t)),
                            .weight = t->blend > 0 && t->done < t->blend ? (float)(t->done / t->blend) : 1};
    return true;
}

bool daft_entity_set_animation_time(daft_scene *scene, daft_entity entity, double seconds, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item || !daft_check_range(error, "seconds", seconds, -1e9, 1e9, "-1e9 to 1e9 (seconds)")) return false;
    if (!item->animated) return daft_fail(error, DAFT_ERROR_ARGUMENT, "the entity plays no clip");
    daft_track *t = &item->animated->tracks[item->animated->track_count - 1];
    t->time = within(seconds, duration_of(scene, item->animated, t), t->loop);
    t->step = 0;
    daft_scene_touch(scene);
    return true;
}

#define HASH(field) hash = daft_hash(&(field), sizeof(field), hash)

uint64_t daft_animations_hash(const daft_scene *scene, uint32_t entity, uint64_t hash)
{
    const daft_animated *a = scene->entities[entity].animated;
    for (uint32_t i = 0; a && i < a->track_count; i++) {
        const daft_track *t = &a->tracks[i];
        HASH(t->clip), HASH(t->loop), HASH(t->speed), HASH(t->time), HASH(t->blend), HASH(t->done);
    }
    return hash;
}
