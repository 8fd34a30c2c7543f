/* Poses: for each entity that plays, meshes with vertices, normals and trees of their own. Two are for pictures, so
 * that one may be in the making while the next is listed; a third is for rays, whose answers are the game's state and
 * so must not depend on what is drawn. A pose that is right already is kept. */
#include "scene/animation/animation.h"

#include <string.h>

enum { RAYS = 2 }; /* the third */

/* ---- memory ---- */

static void posed_free(const daft_scene *scene, daft_posed *p)
{
    daft_release(scene->allocator, p->mesh.x), daft_release(scene->allocator, p->mesh.y);
    daft_release(scene->allocator, p->mesh.z), daft_release(scene->allocator, p->mesh.normals);
    if (p->bvh) daft_bvh_free(p->bvh);
    daft_release(scene->allocator, p);
}

static void free_retired(const daft_scene *scene, daft_retired *item) { posed_free(scene, (daft_posed *)item); }

static daft_posed *posed_make(const daft_scene *scene, const daft_mesh_item *from, daft_error *error)
{
    daft_posed *p = daft_alloc_zero(scene->allocator, 1, sizeof *p);
    daft_vec3 *normals = daft_alloc(scene->allocator, (size_t)from->mesh.normal_count + 1, sizeof *normals);
    const size_t room = (from->mesh.vertex_count + DAFT_RIG_BLOCK - 1u) / DAFT_RIG_BLOCK * DAFT_RIG_BLOCK + 1;
    if (p) {
        p->mesh = from->mesh;
        p->mesh.normals = normals;
        p->mesh.x = daft_alloc_zero(scene->allocator, room, sizeof(float));
        p->mesh.y = daft_alloc_zero(scene->allocator, room, sizeof(float));
        p->mesh.z = daft_alloc_zero(scene->allocator, room, sizeof(float));
        p->bvh = daft_bvh_copy(scene->allocator, from->bvh);
        p->layer_count = UINT32_MAX; /* no pose yet */
        if (p->mesh.x && p->mesh.y && p->mesh.z && normals && p->bvh) return p;
        posed_free(scene, p);
    } else {
        daft_release(scene->allocator, normals);
    }
    daft_fail_memory(error, "a pose");
    return NULL;
}

static void retire(daft_scene *scene, daft_posed *p)
{
    if (p) daft_retire(scene, &p->retired, free_retired);
}

void daft_animated_free(daft_scene *scene, daft_animated *a)
{
    if (!a) return;
    for (int i = 0; i < DAFT_POSES; i++) retire(scene, a->posed[i]);
    if (a->next) a->next->previous = a->previous;
    if (a->previous) a->previous->next = a->next;
    if (scene->animated == a) scene->animated = a->next;
    daft_rig_space_free(a->space);
    daft_glow_free(scene, &a->glow);
    daft_release(scene->allocator, a);
}

/* ---- which ---- */

/* Whether a picture that is in the making may show it. */
static bool is_read(const daft_scene *scene, const daft_posed *p)
{
    for (const daft_scene_frame *f = scene->frames; p && f; f = f->next)
        if (f->taken && f->listing >= p->first && f->listing <= p->last) return true;
    return false;
}

/* The place of a pose that may be changed. */
static uint32_t free_place(daft_scene *scene, daft_animated *a, bool rays)
{
    if (rays) return RAYS;
    if (!is_read(scene, a->posed[a->shown])) return a->shown;
    const uint32_t other = 1 - a->shown;
    if (is_read(scene, a->posed[other])) retire(scene, a->posed[other]), a->posed[other] = NULL;
    return other;
}

static bool same_layers(const daft_posed *p, const daft_rig_layer *layers, uint32_t count)
{
    bool same = p && p->layer_count == count;
    for (uint32_t i = 0; same && i < count; i++)
        same = p->layers[i].clip == layers[i].clip && p->layers[i].time == layers[i].time &&
               p->layers[i].weight == layers[i].weight;
    return same;
}

typedef struct pose_job {
    daft_animated *animated;
    const daft_rig *rig;
    daft_posed *posed;
    bool rebuilt;
} pose_job;

typedef struct pose_list {
    daft_scene *scene;
    pose_job *jobs;
    uint32_t count;
    daft_bvh_def def;
} pose_list;

/* Adds a job where the pose is not right yet. */
static bool list_pose(pose_list *list, daft_animated *a, float alpha, bool rays, daft_error *error)
{
    daft_scene *scene = list->scene;
    const daft_mesh_item *mesh = daft_animated_mesh(scene, a);
    daft_rig_layer layers[DAFT_RIG_LAYERS];
    const uint32_t count = daft_tracks_layers(scene, a, mesh->rig, alpha, layers), now = rays ? RAYS : a->shown;
    if (!same_layers(a->posed[now], layers, count)) {
        const uint32_t place = free_place(scene, a, rays);
        daft_posed **posed = &a->posed[place];
        if (!*posed && !(*posed = posed_make(scene, mesh, error))) return false;
        if (!rays) a->shown = place;
        memcpy((*posed)->layers, layers, sizeof layers);
        (*posed)->layer_count = count;
        (*posed)->first = scene->listings, (*posed)->revision = ++scene->engine->revision;
        list->jobs[list->count++] = (pose_job){.animated = a, .rig = mesh->rig, .posed = *posed};
    }
    a->posed[rays ? RAYS : a->shown]->last = scene->listings;
    return true;
}

static void pose_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    const pose_list *list = context;
    pose_job *job = &list->jobs[index];
    daft_posed *p = job->posed;
    daft_rig_pose(job->rig, p->layers, p->layer_count, job->animated->space);
    daft_rig_skin(job->rig, job->animated->space, list->def.isa, &p->mesh);
    job->rebuilt = daft_bvh_update(p->bvh, &p->mesh, &list->def);
}

bool daft_animated_pose(daft_scene *scene, const uint32_t *entities, uint32_t count, float alpha, bool rays,
                        daft_arena *arena, daft_error *error)
{
    const int threads = scene->engine->threads;
    pose_list list = {.scene = scene, .def = {.threads = 1, .isa = scene->engine->isa}};
    list.jobs = daft_arena_alloc(arena, count, sizeof *list.jobs);
    if (!list.jobs) return daft_fail_memory(error, "poses");
    for (uint32_t i = 0; i < count; i++)
        if (!list_pose(&list, scene->entities[entities[i]].animated, alpha, rays, error)) return false;
    if (list.count == 1) { /* alone it may have all threads for its tree */
        list.def.threads = threads;
        pose_task(&list, 0, 0);
    } else {
        daft_parallel_for(threads, list.count, pose_task, &list);
    }
    for (uint32_t i = 0; i < list.count; i++) scene->counters.mesh_builds += list.jobs[i].rebuilt;
    scene->counters.poses += list.count, scene->counters.mesh_refits += list.count;
    if (!rays && list.count > 0) scene->posings++;
    return true;
}

const daft_posed *daft_animated_shown(const daft_animated *a, bool rays) { return a->posed[rays ? RAYS : a->shown]; }

/* ---- bounds ---- */

/* Of all clips that it shows; a pose between two may reach beyond. */
void daft_animated_bounds(const daft_animated *a, const daft_rig *rig, daft_vec3 *low, daft_vec3 *high)
{
    *low = rig->clips[a->tracks[0].clip].low, *high = rig->clips[a->tracks[0].clip].high;
    for (uint32_t i = 1; i < a->track_count; i++) {
        *low = daft_min3(*low, rig->clips[a->tracks[i].clip].low);
        *high = daft_max3(*high, rig->clips[a->tracks[i].clip].high);
    }
}
