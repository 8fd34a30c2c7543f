/* Frames: their life from taking to release, and when what they may read is freed.
 *
 * A frame's snapshot points to three kinds of memory: the frame's own arenas (instances, surfaces, the table of
 * textures, lights); meshes, texels and sky images, which never change once a frame may read them and which are retired
 * when the scene lets go of them; nothing else. Taking and releasing happen on the scene's thread, so nothing here is
 * atomic. */
#include "scene/scene.h"

#include <string.h>

void daft_scene_touch(daft_scene *scene) { scene->revision = ++scene->engine->revision; }

/* ---- what is let go of ---- */

bool daft_frame_is_taken(const daft_scene *scene)
{
    for (const daft_scene_frame *f = scene->frames; f; f = f->next)
        if (f->taken) return true;
    return false;
}

/* Frees what no frame that is taken may read. */
static void free_retired(daft_scene *scene)
{
    uint64_t oldest = UINT64_MAX;
    for (const daft_scene_frame *f = scene->frames; f; f = f->next)
        if (f->taken && f->number < oldest) oldest = f->number;
    for (daft_retired **link = &scene->retired; *link;) {
        daft_retired *item = *link;
        if (item->frame >= oldest) {
            link = &item->next;
            continue;
        }
        *link = item->next;
        item->free(scene, item);
    }
}

void daft_retire(daft_scene *scene, daft_retired *item, void (*free)(const daft_scene *scene, daft_retired *item))
{
    item->free = free;
    item->frame = scene->frames_taken;
    item->next = scene->retired;
    scene->retired = item;
    free_retired(scene);
}

/* ---- frames ---- */

/* Whether the frame's instances are still right for the view. Tick and alpha count only where some entity is between
 * two poses, what is in sight only where some is left out. */
static bool still_valid(const daft_scene *scene, const daft_scene_frame *f, const daft_view *view,
                        const daft_sight *sight)
{
    daft_dvec3 origin = view->camera.position;
    bool still = f->still && scene->moved_tick != scene->tick;
    return f->posings == scene->posings && (f->unseen == 0 || memcmp(&f->sight, sight, sizeof *sight) == 0) &&
           f->revision && f->revision == scene->revision && f->without == view->without &&
           f->kdtrees == daft_uses_kdtrees(scene, view) && f->origin.x == origin.x && f->origin.y == origin.y &&
           f->origin.z == origin.z && (still || (f->tick == scene->tick && f->alpha == view->alpha));
}

static daft_scene_frame *frame_new(daft_scene *scene, daft_error *error)
{
    daft_scene_frame *f = daft_alloc_zero(scene->allocator, 1, sizeof *f);
    if (!f) {
        daft_fail_memory(error, "a frame");
        return NULL;
    }
    daft_arena_init(&f->lights, scene->allocator);
    daft_arena_init(&f->instances, scene->allocator);
    f->next = scene->frames;
    scene->frames = f;
    return f;
}

/* A free frame, best one whose instances are still right. */
static daft_scene_frame *frame_pick(daft_scene *scene, const daft_view *view, const daft_sight *sight,
                                    daft_error *error)
{
    daft_scene_frame *any = NULL;
    for (daft_scene_frame *f = scene->frames; f; f = f->next) {
        if (f->taken) continue;
        if (still_valid(scene, f, view, sight)) return f;
        any = f;
    }
    return any ? any : frame_new(scene, error);
}

/* Leaves out of a surface what the view goes without. Without shading it glows in its own colour: ambient light of 1,
 * and no other, falls on it (see daft_snapshot_fill). */
static daft_surface strip(daft_surface surface, uint32_t without)
{
    const daft_vec3 none = {0, 0, 0};
    if (without & DAFT_WITHOUT_SHADING) surface.ambient = surface.diffuse;
    if (without & DAFT_WITHOUT_DIFFUSE) surface.diffuse = none;
    if (without & (DAFT_WITHOUT_SPECULAR | DAFT_WITHOUT_SHADING)) surface.specular = none;
    if (without & DAFT_WITHOUT_SHADING) surface.mirror = none;
    if (without & DAFT_WITHOUT_SHADING)
        surface.traits &= ~(uint32_t)DAFT_TRAIT_OCCLUSION, surface.maps[DAFT_MAP_OCCLUSION] = DAFT_NO_TEXTURE;
    if (surface.traits & DAFT_TRAIT_PHYSICAL && without & (DAFT_WITHOUT_SPECULAR | DAFT_WITHOUT_SHADING))
        surface.traits &= ~(uint32_t)DAFT_TRAIT_PHYSICAL, surface.mirror = none;
    if (!(without & DAFT_WITHOUT_TEXTURES)) return surface;
    surface.texture = DAFT_NO_TEXTURE;
    surface.traits &= ~(uint32_t)(DAFT_TRAIT_MAPS | DAFT_TRAIT_TANGENT | DAFT_TRAIT_OCCLUSION);
    for (int i = 0; i < DAFT_MAPS; i++) surface.maps[i] = DAFT_NO_TEXTURE;
    return surface;
}

static void find_colors(const daft_assets *assets, daft_snapshot *s)
{
    s->colors = s->fades = false;
    for (uint32_t i = 0; i < assets->mesh_slots.count; i++) {
        if (!assets->meshes[i]) continue;
        s->colors |= assets->meshes[i]->mesh.colors != NULL;
        s->fades |= assets->meshes[i]->mesh.alphas != NULL;
    }
}

/* Instances, and with them what they index: surfaces and textures. */
static bool frame_place(daft_scene *scene, daft_scene_frame *f, const daft_view *view, const daft_sight *sight,
                        daft_error *error)
{
    daft_snapshot *s = &f->snapshot;
    const daft_assets *assets = &scene->assets;
    if (still_valid(scene, f, view, sight)) {
        scene->counters.poses_unseen += f->unseen;
        return true;
    }
    f->revision = 0;
    daft_arena_reset(&f->instances);
    daft_listing listing = {.origin = view->camera.position,
                            .alpha = view->alpha,
                            .sight = sight,
                            .kdtrees = daft_uses_kdtrees(scene, view),
                            .arena = &f->instances};
    if (!daft_snapshot_instances(scene, &listing, error)) return false;
    daft_surface *surfaces = daft_arena_alloc(&f->instances, assets->material_slots.count, sizeof *surfaces);
    daft_texture_data *textures = daft_arena_alloc(&f->instances, assets->texture_slots.count, sizeof *textures);
    if (!surfaces || !textures) return daft_fail_memory(error, "a snapshot's materials");
    for (uint32_t i = 0; i < assets->material_slots.count; i++) surfaces[i] = strip(assets->surfaces[i], view->without);
    for (uint32_t i = 0; i < assets->texture_slots.count; i++) textures[i] = assets->textures[i];
    s->instances = listing.instances, s->instance_count = listing.count;
    s->materials = surfaces, s->material_count = assets->material_slots.count;
    s->textures = textures, s->texture_count = assets->texture_slots.count;
    find_colors(assets, s);
    s->revision = ++scene->engine->revision;
    f->revision = scene->revision, f->tick = scene->tick, f->alpha = view->alpha, f->origin = view->camera.position;
    f->without = view->without, f->kdtrees = daft_uses_kdtrees(scene, view);
    f->listing = scene->listings, f->posings = scene->posings, f->unseen = listing.unseen, f->sight = *sight;
    scene->counters.poses_unseen += listing.unseen;
    f->still = scene->moved_tick != scene->tick;
    scene->counters.instance_updates++;
    return true;
}

daft_scene_frame *daft_frame_take(daft_scene *scene, const daft_view *view, int width, int height, daft_error *error)
{
    if (!scene->revision) daft_scene_touch(scene); /* nothing has been put into it yet */
    daft_sight sight;
    daft_sight_make(scene, view, width, height, &sight);
    daft_scene_frame *f = frame_pick(scene, view, &sight, error);
    if (!f || !frame_place(scene, f, view, &sight, error) || !daft_snapshot_fill(scene, view, width, height, f, error))
        return NULL;
    if (!daft_history_take(view->history, scene, view, f, error)) return NULL;
    f->counters = scene->counters;
    f->taken = true;
    f->number = ++scene->frames_taken;
    return f;
}

/* The renderer writes instance numbers where the caller wants entities: both are 32 bits, so they are turned in place.
 */
static void name_entities(const daft_snapshot *snapshot, uint32_t *ids, bool drawn)
{
    _Static_assert(sizeof(daft_entity) == sizeof(uint32_t), "an entity is one number");
    if (!ids) return;
    size_t width = (size_t)snapshot->width, begin = width * (size_t)snapshot->first_row;
    size_t end = begin + width * (size_t)snapshot->row_count;
    for (size_t i = begin; i < end; i++)
        ids[i] = drawn && ids[i] < snapshot->instance_count ? snapshot->instances[ids[i]].entity : 0;
}

bool daft_frame_draw(daft_scene_frame *frame, daft_renderer *renderer, const daft_frame_target *target,
                     daft_error *error)
{
    bool drawn = daft_render_frame(renderer, &frame->snapshot, target, &frame->counters, error);
    name_entities(&frame->snapshot, target->aov.instance, drawn);
    return drawn;
}

/* Counters that run since the scene was made may have grown while the frame was drawn: the scene's hold. */
void daft_frame_release(daft_scene *scene, daft_scene_frame *frame)
{
    daft_counters *c = &frame->counters, *all = &scene->counters;
    c->query_rays = all->query_rays, c->mesh_builds = all->mesh_builds, c->mesh_refits = all->mesh_refits;
    c->instance_updates = all->instance_updates, c->poses = all->poses, c->poses_unseen = all->poses_unseen;
    *all = *c;
    frame->taken = false;
    free_retired(scene);
}

void daft_frames_free(daft_scene *scene)
{
    for (daft_scene_frame *f = scene->frames, *next; f; f = next) {
        next = f->next;
        daft_arena_free(&f->lights);
        daft_arena_free(&f->instances);
        daft_release(scene->allocator, f);
    }
    scene->frames = NULL;
    free_retired(scene);
}
