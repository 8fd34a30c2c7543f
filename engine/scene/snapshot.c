/* The frame snapshot: what render/ and the ray queries see of a scene. Positions are subtracted from the frame's origin
 * in double and rounded to float once, so precision is the same wherever in the world the frame is. */
#include "cost/cost.h"
#include "math/real.h"
#include "scene/scene.h"

static bool finite_affine(const daft_affine *a)
{
    bool finite = true;
    for (int i = 0; i < 9; i++) finite = finite && isfinite(a->m[i]);
    for (int i = 0; i < 3; i++) finite = finite && isfinite(a->t[i]);
    return finite;
}

/* Products of three coordinates are the largest numbers that kernels make of them, so 1e12 metres stay inside floats;
 * and what is smaller than 1e-15 metres vanishes among denormals. Beyond that nothing is drawn, instead of something
 * wrong.
 */
#define FARTHEST 1e12f
#define SMALLEST 1e-15f

static bool is_near(daft_vec3 p)
{
    return fabsf(p.x) <= FARTHEST && fabsf(p.y) <= FARTHEST && fabsf(p.z) <= FARTHEST; /* no NaN is */
}

static bool fits_bounds(daft_vec3 low, daft_vec3 high)
{
    daft_vec3 size = daft_sub(high, low);
    return is_near(low) && is_near(high) && (size.x >= SMALLEST || size.y >= SMALLEST || size.z >= SMALLEST);
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
    return fits_bounds(mesh->low, mesh->high) && is_near(daft_v3(eye[0], eye[1], eye[2]));
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
static float world_radius(const daft_daffine *world, float radius)
{
    const double *m = world->m;
    return (float)(sqrt(m[0] * m[0] + m[3] * m[3] + m[6] * m[6]) * (double)radius);
}

static daft_mesh_item *shape_of(const daft_scene *scene, const daft_entity_item *item)
{
    switch (item->def.shape) {
    case DAFT_SHAPE_MESH: return scene->assets.meshes[item->def.mesh.id - 1];
    case DAFT_SHAPE_BOX: return &scene->assets.boxes[item->box]->shape;
    case DAFT_SHAPE_SPHERE:
    case DAFT_SHAPE_NONE: break;
    }
    return NULL;
}

/* What the instances of a snapshot are made with, and how many there are. */
typedef struct maker {
    daft_scene *scene;
    daft_dvec3 origin;
    float alpha;
    daft_arena *arena;
    const uint32_t *numbers; /* of the materials, in order: things of one slot share them, since a line of a cache for each would be
                                missed wherever many are seen */
    daft_instance *instances;
    uint32_t count;
} maker;

static const uint32_t *make_numbers(const daft_scene *scene, daft_arena *arena)
{
    uint32_t count = scene->assets.material_count ? scene->assets.material_count : 1, *numbers = daft_arena_alloc(arena, count, sizeof *numbers);
    for (uint32_t i = 0; numbers && i < count; i++) numbers[i] = i;
    return numbers;
}

/* The mesh's own materials, unless the entity has one, which then goes to every slot. NULL: memory is out. */
static const uint32_t *materials_of(const maker *m, const daft_entity_item *item, const daft_mesh_item *shape)
{
    if (!item->def.material.id && shape) return shape->materials;
    uint32_t material = item->def.material.id ? item->def.material.id - 1 : 0;
    if (!shape || shape->mesh.slot_count <= 1) return &m->numbers[material];
    uint32_t count = shape->mesh.slot_count, *materials = daft_arena_alloc(m->arena, count, sizeof *materials);
    for (uint32_t i = 0; materials && i < count; i++) materials[i] = material;
    return materials;
}

/* Whether the camera is outside a box or a sphere, with a margin for rounding. Its points that face a lamp then lie in
 * no shadow of its own; with the camera inside, the walls that are seen may. */
static bool seen_from_outside(const daft_entity_item *item, const daft_instance *instance)
{
    const float *camera = instance->to_object.t, half = 0.50001f;
    daft_vec3 size = item->def.size,
              center = daft_v3(instance->to_frame.t[0], instance->to_frame.t[1], instance->to_frame.t[2]);
    if (item->def.shape == DAFT_SHAPE_SPHERE) return daft_length(center) > 1.00001f * instance->radius;
    return item->def.shape == DAFT_SHAPE_BOX &&
           (fabsf(camera[0]) > half * size.x || fabsf(camera[1]) > half * size.y || fabsf(camera[2]) > half * size.z);
}

/* A shadow is whole as long as some material lets no light pass, and none where all let all of it pass. */
static uint32_t shadow_of(const daft_scene *scene, const daft_instance *instance)
{
    uint32_t slots = instance->mesh && instance->mesh->slot_count ? instance->mesh->slot_count : 1;
    bool dims = false;
    for (uint32_t i = 0; i < slots; i++) {
        const daft_surface *surface = &scene->assets.surfaces[instance->materials[i]];
        if (surface->transmission == 0) return DAFT_INSTANCE_CASTS_SHADOW;
        dims |= surface->through.x < 1 || surface->through.y < 1 || surface->through.z < 1;
    }
    return dims ? DAFT_INSTANCE_TINTS_SHADOW : 0;
}

/* Light comes to the inner side of what transmits: its points may lie in its own shadow. */
static uint32_t flags_of(const daft_scene *scene, const daft_entity_item *item, const daft_instance *instance)
{
    uint32_t shadow = shadow_of(scene, instance);
    bool convex = shadow == DAFT_INSTANCE_CASTS_SHADOW && seen_from_outside(item, instance);
    return (item->def.casts_shadow ? shadow : 0) | (convex ? DAFT_INSTANCE_CONVEX : 0);
}

static void warn_once(daft_scene *scene, daft_entity_item *item, uint32_t id)
{
    if (item->warned) return;
    item->warned = true;
    daft_warn_at(&scene->engine->log, DAFT_ERROR_ARGUMENT, NULL, 0, 0,
                 "entity 0x%x is not drawn: its transform, with its parents', is singular or does not fit floats", id);
}

static void count_shown(const daft_scene *scene, daft_mesh_item *shape)
{
    if (shape->shown_pass != scene->pass) shape->shown_pass = scene->pass, shape->shown = 0;
    shape->shown++;
}

/* Adds the entity's instance if it has one to show. False: memory is out. */
static bool add_instance(maker *m, uint32_t index)
{
    daft_scene *scene = m->scene;
    if (!scene->entity_slots.items[index].live || scene->entities[index].def.shape == DAFT_SHAPE_NONE ||
        !scene->entities[index].def.visible)
        return true;
    daft_entity_item *item = daft_entity_world(scene, index, m->alpha);
    if (!item->shown) return true;
    daft_instance *instance = &m->instances[m->count];
    daft_mesh_item *shape = shape_of(scene, item);
    *instance = (daft_instance){.entity = daft_slots_handle(&scene->entity_slots, index)};
    bool fits = place(&item->world, m->origin, instance);
    instance->mesh = shape ? &shape->mesh : NULL;
    instance->bvh = shape ? shape->bvh : NULL;
    instance->kdtree = shape ? shape->kdtree : NULL;
    if (fits && !shape) instance->radius = world_radius(&item->world, item->def.radius);
    if (fits) daft_instance_bound(instance);
    if (!fits || !fits_kernels(instance)) {
        warn_once(scene, item, instance->entity);
        return true;
    }
    instance->materials = materials_of(m, item, shape);
    if (!instance->materials) return false;
    instance->flags = flags_of(scene, item, instance);
    if (shape) count_shown(scene, shape);
    m->count++;
    return true;
}

bool daft_snapshot_instances(daft_scene *scene, daft_dvec3 origin, float alpha, daft_arena *arena,
                             daft_instance **instances, uint32_t *count, daft_error *error)
{
    maker m = {.scene = scene, .origin = origin, .alpha = alpha, .arena = arena, .numbers = make_numbers(scene, arena)};
    *count = 0;
    *instances = m.instances = daft_arena_alloc(arena, scene->entity_slots.live, sizeof *m.instances);
    if (!m.instances || !m.numbers) return daft_fail_memory(error, "a snapshot's instances");
    scene->pass++;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++)
        if (!add_instance(&m, i)) return daft_fail_memory(error, "a snapshot's materials");
    *count = m.count;
    return true;
}

/* Against the sun's direction, unit; in double, so that no length is too short or too long. */
static daft_vec3 to_sun(daft_vec3 direction)
{
    daft_dvec3 d = daft_to_double(direction);
    return daft_to_float(daft_dscale(d, -1 / sqrt(daft_ddot(d, d))));
}

static void set_cone(const daft_light_def *def, daft_lamp *lamp)
{
    double outer = daft_cos((double)def->outer_angle), range = daft_cos((double)def->inner_angle) - outer;
    lamp->spot = true;
    lamp->to_light = to_sun(def->direction);
    lamp->cone_cosine = (float)outer;
    lamp->cone_scale = (float)(1 / (range > 1e-7 ? range : 1e-7)); /* what floats can tell */
}

static bool fill_lamps(daft_scene *scene, daft_dvec3 origin, daft_snapshot *out, daft_error *error)
{
    daft_lamp *lamps = daft_arena_alloc(&scene->frame, scene->light_slots.live, sizeof *lamps);
    if (!lamps) return daft_fail_memory(error, "a snapshot's lights");
    for (uint32_t i = 0; i < scene->light_slots.count; i++) {
        if (!scene->light_slots.items[i].live) continue;
        const daft_light_def *def = &scene->lights[i];
        daft_lamp *lamp = &lamps[out->lamp_count];
        *lamp = (daft_lamp){.sun = def->kind == DAFT_LIGHT_SUN, .casts_shadow = def->casts_shadow, .color = def->color};
        if (def->kind == DAFT_LIGHT_SPOT) set_cone(def, lamp);
        if (lamp->sun)
            lamp->to_light = to_sun(def->direction);
        else
            lamp->position = daft_to_float(daft_dsub(def->position, origin));
        if (is_near(lamp->position)) out->lamp_count++; /* farther away it lights nothing */
    }
    out->lamps = lamps;
    return true;
}

static bool some_casts(const daft_snapshot *s)
{
    for (uint32_t i = 0; i < s->lamp_count; i++)
        if (s->lamps[i].casts_shadow) return true;
    return false;
}

bool daft_snapshot_fill(daft_scene *scene, const daft_view *view, int width, int height, daft_snapshot *out,
                        daft_error *error)
{
    const daft_preset *preset = daft_quality_preset(view->quality);
    *out = (daft_snapshot){
        .width = width,
        .height = height,
        .focal = (float)(width / 2.0 / daft_tan((double)view->camera.fov / 2)),
        .samples = view->samples ? view->samples : preset->samples,
        .intersection = view->intersection,
        .reference = view->reference || preset->reference || scene->engine->accel == DAFT_ACCEL_KDTREE,
        .quality = view->quality,
        .materials = scene->assets.surfaces,
        .material_count = scene->assets.material_count,
        .textures = scene->assets.textures,
        .texture_count = scene->assets.texture_count,
        .ambient = scene->ambient,
        .sky = scene->sky,
    };
    daft_camera_axes(&view->camera, &out->right, &out->up, &out->forward);
    daft_arena_reset(&scene->frame);
    daft_instance *instances;
    if (!daft_snapshot_instances(scene, view->camera.position, view->alpha, &scene->frame, &instances,
                                 &out->instance_count, error))
        return false;
    out->instances = instances;
    daft_assets_find_sides(scene);
    if (!daft_assets_smooth(scene, error) || !fill_lamps(scene, view->camera.position, out, error)) return false;
    if (preset->shadows && some_casts(out)) daft_assets_find_inner(scene);
    return true;
}
