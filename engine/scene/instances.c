/* The instances of a frame: what render/ and the ray queries see of entities. One thread lists them; all
 * threads compute their transforms, inverses and bounds. */
#include "scene/scene.h"

static bool finite_affine(const daft_affine *a)
{
    bool finite = true;
    for (int i = 0; i < 9; i++) finite = finite && isfinite(a->m[i]);
    for (int i = 0; i < 3; i++) finite = finite && isfinite(a->t[i]);
    return finite;
}

/* Products of three coordinates are the largest numbers that kernels make of them, so 1e12 metres stay inside floats;
 * and what is smaller than 1e-15 metres vanishes among denormals. Beyond these limits an entity is not drawn. */
#define FARTHEST 1e12f
#define SMALLEST 1e-15f

bool daft_fits_kernels(daft_vec3 p)
{
    return fabsf(p.x) <= FARTHEST && fabsf(p.y) <= FARTHEST && fabsf(p.z) <= FARTHEST; /* no NaN is */
}

static bool fits_bounds(daft_vec3 low, daft_vec3 high)
{
    daft_vec3 size = daft_sub(high, low);
    return daft_fits_kernels(low) && daft_fits_kernels(high) &&
           (size.x >= SMALLEST || size.y >= SMALLEST || size.z >= SMALLEST);
}

/* In the frame, and in the mesh's own space, to which rays are turned. */
static bool fits_kernels(const daft_instance *instance)
{
    const daft_trimesh *mesh = instance->mesh;
    const float *eye = instance->to_object.t;
    if (mesh && mesh->triangle_count == 0) return true;
    if (!fits_bounds(instance->low, instance->high)) return false;
    if (!mesh) return instance->radius >= SMALLEST;
    for (int i = 0; i < 9; i++)
        if (!(fabsf(instance->to_object.m[i]) <= FARTHEST)) return false;
    return fits_bounds(mesh->low, mesh->high) && daft_fits_kernels(daft_v3(eye[0], eye[1], eye[2]));
}

static daft_affine rounded(const daft_daffine *a)
{
    daft_affine out;
    for (int i = 0; i < 9; i++) out.m[i] = (float)a->m[i];
    for (int i = 0; i < 3; i++) out.t[i] = (float)a->t[i];
    return out;
}

/* False: the transform is singular, or does not fit floats. */
static bool place(const daft_daffine *world, daft_dvec3 origin, daft_instance *instance)
{
    daft_daffine frame = *world, inverse;
    frame.t[0] -= origin.x, frame.t[1] -= origin.y, frame.t[2] -= origin.z;
    if (!daft_daffine_invert(&frame, &inverse)) return false;
    instance->to_frame = rounded(&frame);
    instance->to_object = rounded(&inverse);
    return finite_affine(&instance->to_frame) && finite_affine(&instance->to_object);
}

/* A sphere's scale is the same in every direction: the length of any column. */
float daft_world_radius(const daft_daffine *world, float radius)
{
    const double *m = world->m;
    return (float)(sqrt(m[0] * m[0] + m[3] * m[3] + m[6] * m[6]) * (double)radius);
}

daft_mesh_item *daft_entity_shape(const daft_scene *scene, const daft_entity_item *item)
{
    switch (item->def.shape) {
    case DAFT_SHAPE_MESH: return scene->assets.meshes[daft_asset_index(item->def.mesh.id)];
    case DAFT_SHAPE_BOX: return &scene->assets.boxes[item->box]->shape;
    case DAFT_SHAPE_SPHERE:
    case DAFT_SHAPE_NONE: break;
    }
    return NULL;
}

/* What instances are made with. */
typedef struct maker {
    daft_scene *scene;
    daft_dvec3 origin;
    float alpha;
    bool kdtrees;
    const daft_sight *sight; /* NULL: for rays */
    daft_arena *arena;
    const daft_accel_kernels *kernels;
    /* Material indices. `numbers`: 0, 1, 2, …, shared by the instances with one slot, which saves each a cache line of
     * its own. `repeated`: for a material that covers all slots of a mesh, its index as often as any mesh has slots. */
    const uint32_t *numbers, **repeated;
    uint32_t max_slots;
    uint32_t count, *entities;            /* those to show, by index */
    uint32_t posed_count, *posed, unseen; /* those of them that play; those left out */
    daft_instance *instances;
    bool *fits; /* by instance */
    /* By entity, of those that have a mesh in a material with alpha; NULL: no material has any, or rays ask. */
    const daft_opacity_set **opacity;
} maker;

enum { TASK = 256, FEW = 4096 }; /* instances; with fewer, others are not worth waking */
enum { AHEAD = 16 };             /* entities: little of each is looked at */

static const uint32_t *make_numbers(const daft_scene *scene, daft_arena *arena)
{
    uint32_t count = scene->assets.material_slots.count, *numbers = daft_arena_alloc(arena, count, sizeof *numbers);
    for (uint32_t i = 0; numbers && i < count; i++) numbers[i] = i;
    return numbers;
}

/* Whether a frame may have to look at the alpha of something. */
static bool has_alpha(const daft_scene *scene)
{
    const daft_assets *assets = &scene->assets;
    for (uint32_t i = 0; i < assets->material_slots.count; i++)
        if (daft_surface_blends(&assets->surfaces[i])) return true;
    return false;
}

static bool begin(maker *m)
{
    uint32_t max = m->scene->entity_slots.live, materials = m->scene->assets.material_slots.count;
    m->kernels = daft_accel_kernels_for(m->scene->engine->isa);
    m->numbers = make_numbers(m->scene, m->arena);
    m->repeated = daft_arena_alloc(m->arena, materials, sizeof *m->repeated);
    m->entities = daft_arena_alloc(m->arena, max, sizeof *m->entities);
    m->posed = daft_arena_alloc(m->arena, m->scene->animated ? max : 1, sizeof *m->posed);
    m->instances = daft_arena_alloc(m->arena, max, sizeof *m->instances);
    m->fits = daft_arena_alloc(m->arena, max, sizeof *m->fits);
    const bool alpha = m->sight && has_alpha(m->scene);
    if (alpha) m->opacity = daft_arena_alloc(m->arena, max, sizeof *m->opacity);
    if (alpha && !m->opacity) return false;
    for (uint32_t i = 0; m->repeated && i < materials; i++) m->repeated[i] = NULL;
    for (uint32_t i = 0; i < m->scene->assets.mesh_slots.count; i++)
        if (m->scene->assets.meshes[i])
            m->max_slots = daft_max_u(m->max_slots, m->scene->assets.meshes[i]->mesh.slot_count);
    return m->numbers && m->repeated && m->entities && m->posed && m->instances && m->fits;
}

/* ---- which ---- */

/* Whether the entity's own material goes to more slots than one. */
static bool repeats(const daft_entity_item *item, const daft_mesh_item *shape)
{
    return item->def.material.id && shape && shape->mesh.slot_count > 1;
}

static bool repeat_material(maker *m, uint32_t material)
{
    if (m->repeated[material]) return true;
    uint32_t *all = daft_arena_alloc(m->arena, m->max_slots, sizeof *all);
    for (uint32_t i = 0; all && i < m->max_slots; i++) all[i] = material;
    m->repeated[material] = all;
    return all != NULL;
}

/* Notes an entity that plays, unless the picture can do without it, and without its light. */
static bool list_posed(maker *m, uint32_t index)
{
    const daft_entity_item *item = daft_entity_world(m->scene, index, m->alpha);
    const daft_mesh_item *shape = daft_entity_shape(m->scene, item);
    daft_vec3 low, high;
    daft_animated_bounds(item->animated, shape->rig, &low, &high);
    const bool lights = item->def.lights && daft_glow_is_some(m->scene, item->def.material, shape),
               seen = !m->sight || lights || daft_sight_has(m->scene, m->sight, item, low, high);
    if (seen) m->posed[m->posed_count++] = index;
    m->unseen += !seen;
    return seen;
}

/* The mesh's own materials, unless the entity has one, which then goes to every slot. */
static const uint32_t *materials_of(const maker *m, const daft_entity_item *item, const daft_mesh_item *shape)
{
    if (!item->def.material.id && shape) return shape->materials;
    uint32_t material = item->def.material.id ? daft_asset_index(item->def.material.id) : 0;
    return repeats(item, shape) ? m->repeated[material] : &m->numbers[material];
}

static bool any_blends(const daft_scene *scene, const uint32_t *materials, uint32_t slots)
{
    for (uint32_t i = 0; i < slots; i++)
        if (daft_surface_blends(&scene->assets.surfaces[materials[i]])) return true;
    return false;
}

static bool any_transmits(const daft_scene *scene, const uint32_t *materials, uint32_t slots)
{
    for (uint32_t i = 0; i < slots; i++)
        if (scene->assets.surfaces[materials[i]].transmission > 0) return true;
    return false;
}

static const daft_opacity_set *opacity_of(const maker *m, const daft_entity_item *item, daft_mesh_item *shape)
{
    if (!shape || !item->def.casts_shadow) return NULL;
    const uint32_t *materials = materials_of(m, item, shape);
    if (!any_blends(m->scene, materials, daft_max_u(shape->mesh.slot_count, 1))) return NULL;
    return daft_opacity_find(m->scene, shape, materials);
}

/* Notes the entity if there is something of it to show. Where those with parents are is found here, since others may
 * stand on the same. False: memory is out. */
static bool list_entity(maker *m, uint32_t index)
{
    daft_scene *scene = m->scene;
    const daft_entity_item *item = &scene->entities[index];
    if (!scene->entity_slots.items[index].live || item->def.shape == DAFT_SHAPE_NONE || !item->def.visible) return true;
    if (item->parent != DAFT_NONE && !daft_entity_world(scene, index, m->alpha)->shown) return true;
    if (item->animated && !list_posed(m, index)) return true;
    daft_mesh_item *shape = daft_entity_shape(scene, item);
    m->entities[m->count++] = index;
    if (repeats(item, shape) && !repeat_material(m, daft_asset_index(item->def.material.id))) return false;
    if (m->opacity) m->opacity[m->count - 1] = opacity_of(m, item, shape);
    return true;
}

/* ---- where ---- */

/* Whether the camera is outside a box or a sphere, with a margin for rounding. Its points that face a light then lie in
 * no shadow of its own; with the camera inside, visible walls may. */
static bool seen_from_outside(const daft_entity_item *item, const daft_instance *instance)
{
    const float *camera = instance->to_object.t, half = 0.50001f;
    daft_vec3 size = item->def.size,
              center = daft_v3(instance->to_frame.t[0], instance->to_frame.t[1], instance->to_frame.t[2]);
    if (item->def.shape == DAFT_SHAPE_SPHERE) return daft_length(center) > 1.00001f * instance->radius;
    return item->def.shape == DAFT_SHAPE_BOX &&
           (fabsf(camera[0]) > half * size.x || fabsf(camera[1]) > half * size.y || fabsf(camera[2]) > half * size.z);
}

/* The shadow is full if some material transmits nothing, and none if all of them transmit everything; with alpha it is
 * what the hits say, or what all of them would. */
static uint32_t shadow_of(const daft_scene *scene, const daft_instance *instance, const daft_opacity_set *opacity)
{
    uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    bool dims = false;
    if (opacity) return opacity->flags;
    if (any_blends(scene, instance->materials, slots)) return DAFT_INSTANCE_FILTERS_SHADOW;
    for (uint32_t i = 0; i < slots; i++) {
        const daft_surface *surface = &scene->assets.surfaces[instance->materials[i]];
        if (surface->transmission == 0) return DAFT_INSTANCE_CASTS_SHADOW;
        dims |= surface->transmittance.x < 1 || surface->transmittance.y < 1 || surface->transmittance.z < 1 ||
                daft_surface_absorbs(surface);
    }
    return dims ? DAFT_INSTANCE_TINTS_SHADOW : 0;
}

/* Light comes to the inner side of what transmits: its points may lie in its own shadow. */
static uint32_t flags_of(const daft_scene *scene, const daft_entity_item *item, const daft_instance *instance,
                         const daft_opacity_set *opacity)
{
    uint32_t shadow = shadow_of(scene, instance, opacity);
    bool convex = shadow == DAFT_INSTANCE_CASTS_SHADOW && seen_from_outside(item, instance);
    const uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    const bool transmits = any_transmits(scene, instance->materials, slots);
    return (item->def.casts_shadow ? shadow : 0) | (convex ? DAFT_INSTANCE_CONVEX : 0) |
           (transmits ? DAFT_INSTANCE_TRANSMITS : 0);
}

static void place_entity(const maker *m, uint32_t i)
{
    daft_scene *scene = m->scene;
    const daft_entity_item *item = daft_entity_world(scene, m->entities[i], m->alpha);
    daft_instance *instance = &m->instances[i];
    const daft_mesh_item *shape = daft_entity_shape(scene, item);
    *instance =
        (daft_instance){.entity = daft_slots_handle(&scene->entity_slots, m->entities[i]), .order = m->entities[i]};
    m->fits[i] = place(&item->world, m->origin, instance);
    const daft_posed *posed = item->animated ? daft_animated_shown(item->animated, !m->sight) : NULL;
    instance->mesh = posed ? &posed->mesh : shape ? &shape->mesh : NULL;
    instance->shape = posed ? posed->revision : shape ? shape->revision : 0;
    instance->bvh = posed ? posed->bvh : shape ? shape->bvh : NULL;
    instance->kdtree = shape && !posed && m->kdtrees ? shape->kdtree : NULL; /* none of a pose: rays go through the BVH
                                                                              */
    if (!shape) instance->radius = daft_world_radius(&item->world, item->def.radius);
    instance->materials = materials_of(m, item, shape);
    const daft_opacity_set *opacity = m->opacity ? m->opacity[i] : NULL;
    instance->opacity = opacity ? opacity->classes : NULL;
    instance->masks = opacity ? opacity->masks : NULL;
    instance->flags = flags_of(scene, item, instance, opacity);
}

static void place_task(void *context, uint32_t task, uint32_t worker)
{
    (void)worker;
    const maker *m = context;
    uint32_t first = task * TASK, end = daft_min_u(m->count, first + TASK);
    for (uint32_t i = first; i < end; i++) place_entity(m, i);
    m->kernels->bound(m->instances + first, end - first);
    for (uint32_t i = first; i < end; i++) m->fits[i] = m->fits[i] && fits_kernels(&m->instances[i]);
}

static void warn_once(daft_scene *scene, daft_entity_item *item, uint32_t id)
{
    if (item->warned) return;
    item->warned = true;
    daft_warn_at(&scene->engine->log, DAFT_ERROR_ARGUMENT, NULL, 0, 0,
                 "entity 0x%x is not drawn: its transform, with its parents', is singular or does not fit floats", id);
}

/* Those of the meshes that are shown. */
static bool need_kdtrees(const maker *m, daft_error *error)
{
    for (uint32_t i = 0; i < m->count; i++) {
        daft_mesh_item *shape = daft_entity_shape(m->scene, &m->scene->entities[m->entities[i]]);
        if (shape && !daft_mesh_need_kdtree(m->scene, shape, error)) return false;
    }
    return true;
}

/* Keeps what fits. */
static uint32_t sift(maker *m)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < m->count; i++) {
        if (!m->fits[i])
            warn_once(m->scene, &m->scene->entities[m->entities[i]], m->instances[i].entity);
        else if (kept++ != i)
            m->instances[kept - 1] = m->instances[i];
    }
    return kept;
}

/* Entities in order, then the poses of those that play, on all threads. */
static bool list_all(maker *m, daft_error *error)
{
    daft_scene *scene = m->scene;
    scene->walk = ++scene->engine->revision;
    scene->listings += m->sight != NULL;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        const daft_entity_item *ahead = &scene->entities[daft_min_u(i + AHEAD, scene->entity_slots.count - 1)];
        __builtin_prefetch(&ahead->def.shape), __builtin_prefetch(&ahead->parent);
        if (!list_entity(m, i)) return daft_fail_memory(error, "a snapshot's materials");
    }
    return m->posed_count == 0 ||
           daft_animated_pose(scene, m->posed, m->posed_count, m->alpha, !m->sight, m->arena, error);
}

bool daft_snapshot_instances(daft_scene *scene, daft_listing *listing, daft_error *error)
{
    maker m = {.scene = scene,
               .origin = listing->origin,
               .alpha = listing->alpha,
               .sight = listing->sight,
               .kdtrees = listing->kdtrees,
               .arena = listing->arena};
    listing->count = 0;
    if (!begin(&m)) return daft_fail_memory(error, "a snapshot's instances");
    if (!list_all(&m, error) || (m.kdtrees && !need_kdtrees(&m, error))) return false;
    daft_parallel_for(m.count < FEW ? 1 : scene->engine->threads, (m.count + TASK - 1) / TASK, place_task, &m);
    listing->instances = m.instances, listing->unseen = m.unseen;
    listing->count = sift(&m);
    return true;
}
