/* Entities in the world and on each other: transforms whatever they hang on, and parents that change. World maps are
 * composed in double along the chain of parents, and taken apart again into position, rotation and scale. */
#include "scene/scene.h"

/* ---- from a map to a transform ---- */

static daft_dvec3 column(const daft_daffine *a, int i) { return daft_dv3(a->m[i], a->m[3 + i], a->m[6 + i]); }

static double length(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

/* Shepperd 1978: the largest of the four components first, so that none is divided by what is small. */
static daft_quat quat_of(daft_dvec3 x, daft_dvec3 y, daft_dvec3 z)
{
    const double trace = x.x + y.y + z.z;
    double q[4]; /* any length */
    if (trace > x.x && trace > y.y && trace > z.z)
        q[0] = y.z - z.y, q[1] = z.x - x.z, q[2] = x.y - y.x, q[3] = 1 + trace;
    else if (x.x > y.y && x.x > z.z)
        q[0] = 1 + x.x - y.y - z.z, q[1] = y.x + x.y, q[2] = z.x + x.z, q[3] = y.z - z.y;
    else if (y.y > z.z)
        q[0] = y.x + x.y, q[1] = 1 - x.x + y.y - z.z, q[2] = z.y + y.z, q[3] = z.x - x.z;
    else
        q[0] = z.x + x.z, q[1] = z.y + y.z, q[2] = 1 - x.x - y.y + z.z, q[3] = x.y - y.x;
    const double s = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return (daft_quat){(float)(q[0] * s), (float)(q[1] * s), (float)(q[2] * s), (float)(q[3] * s)};
}

/* Unit axes of a map by Gram and Schmidt, X first. They are mirrored as `mirrors` says where that gives a rotation,
 * else the other way, all three, since that keeps an even scale even. False: the map is flat. */
static bool unit_axes(const daft_daffine *a, bool mirrors[3], daft_dvec3 out[3])
{
    daft_dvec3 own[3];
    for (int i = 0; i < 3; i++) own[i] = daft_dscale(column(a, i), mirrors[i] ? -1 : 1);
    if (daft_ddot(daft_dcross(own[0], own[1]), own[2]) < 0) {
        for (int i = 0; i < 3; i++) mirrors[i] = !mirrors[i], own[i] = daft_dscale(own[i], -1);
    }
    const double x = length(own[0]);
    if (!(x > 0)) return false;
    out[0] = daft_dscale(own[0], 1 / x);
    const daft_dvec3 rest = daft_dsub(own[1], daft_dscale(out[0], daft_ddot(own[1], out[0])));
    const double y = length(rest);
    if (!(y > 1e-12 * length(own[1]))) return false;
    out[1] = daft_dscale(rest, 1 / y);
    out[2] = daft_dcross(out[0], out[1]);
    return true;
}

/* `like` says which axes are mirrored, and how it is turned where the map is flat. */
static daft_transform transform_of(const daft_daffine *a, const daft_transform *like)
{
    bool mirrors[3] = {like->scale.x < 0, like->scale.y < 0, like->scale.z < 0};
    daft_dvec3 axes[3];
    daft_transform out = {.position = daft_dv3(a->t[0], a->t[1], a->t[2]), .rotation = like->rotation};
    if (unit_axes(a, mirrors, axes)) out.rotation = quat_of(axes[0], axes[1], axes[2]);
    float scale[3];
    for (int i = 0; i < 3; i++) scale[i] = (float)(mirrors[i] ? -length(column(a, i)) : length(column(a, i)));
    /* Lengths of equal axes differ by roundings; what was scaled evenly stays so. */
    const float even = fabsf(scale[0]), off = even * 1e-6f;
    if (fabsf(fabsf(scale[1]) - even) <= off && fabsf(fabsf(scale[2]) - even) <= off)
        for (int i = 1; i < 3; i++) scale[i] = mirrors[i] ? -even : even;
    out.scale = daft_v3(scale[0], scale[1], scale[2]);
    return out;
}

/* ---- the world ---- */

/* As it is, or as it was in the last tick. */
static daft_transform pose_of(const daft_scene *scene, uint32_t index, bool last)
{
    const daft_entity_item *item = &scene->entities[index];
    return last && item->moved_tick == scene->tick ? item->before : item->now;
}

static const daft_daffine NOWHERE = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* From the entity's own axes to the world's; DAFT_NONE: the world's own. */
static daft_daffine map_of(const daft_scene *scene, uint32_t index, bool last)
{
    daft_daffine map = NOWHERE;
    for (uint32_t at = index; at != DAFT_NONE; at = scene->entities[at].parent) {
        const daft_transform pose = pose_of(scene, at, last);
        const daft_daffine outer = daft_daffine_from(&pose);
        map = at == index ? outer : daft_daffine_compose(&outer, &map);
    }
    return map;
}

/* The map's transform within the parent. False: the parent's map is flat. */
static bool within(const daft_scene *scene, uint32_t parent, bool last, const daft_daffine *map,
                   const daft_transform *like, daft_transform *out)
{
    const daft_daffine outer = map_of(scene, parent, last);
    daft_daffine inverse;
    if (!daft_daffine_invert(&outer, &inverse)) return false;
    const daft_daffine own = daft_daffine_compose(&inverse, map);
    *out = transform_of(&own, like);
    return daft_transform_check(out, NULL);
}

static bool fail_flat(daft_error *error)
{
    return daft_fail(error, DAFT_ERROR_ARGUMENT,
                     "a parent's scale is 0, or too small: nothing can be placed within it");
}

bool daft_entity_get_world_transform(daft_scene *scene, daft_entity entity, daft_transform *out, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = daft_entity_find(scene, entity, error);
    if (!item || !daft_check_pointer(error, "out", out)) return false;
    *out = item->now;
    if (item->parent == DAFT_NONE) return true;
    const daft_daffine map = map_of(scene, daft_handle_index(entity.id), false);
    *out = transform_of(&map, &item->now);
    return true;
}

bool daft_entity_set_world_transform(daft_scene *scene, daft_entity entity, const daft_transform *transform,
                                     bool teleport, daft_error *error)
{
    daft_error_clear(error);
    const daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item || !daft_check_pointer(error, "transform", transform) || !daft_transform_check(transform, error))
        return false;
    daft_transform own = *transform;
    const daft_daffine map = daft_daffine_from(transform);
    if (item->parent != DAFT_NONE && !within(scene, item->parent, false, &map, transform, &own))
        return fail_flat(error);
    return daft_entity_set_transform(scene, entity, &own, teleport, error);
}

/* ---- parents and children ---- */

daft_entity daft_entity_get_parent(const daft_scene *scene, daft_entity entity)
{
    const daft_entity_item *item = daft_entity_find(scene, entity, NULL);
    if (!item || item->parent == DAFT_NONE) return (daft_entity){0};
    return (daft_entity){daft_slots_handle(&scene->entity_slots, item->parent)};
}

uint32_t daft_entity_children(const daft_scene *scene, daft_entity entity, daft_entity *out, uint32_t capacity)
{
    const daft_entity_item *item = daft_entity_find(scene, entity, NULL);
    uint32_t count = 0, oldest = DAFT_NONE;
    for (uint32_t at = item ? item->first_child : DAFT_NONE; at != DAFT_NONE; at = scene->entities[at].next)
        oldest = at, count++;
    for (uint32_t i = 0; out && i < count && i < capacity; i++, oldest = scene->entities[oldest].previous)
        out[i] = (daft_entity){daft_slots_handle(&scene->entity_slots, oldest)};
    return count;
}

static bool holds_sphere(const daft_scene *scene, uint32_t root)
{
    for (uint32_t at = root; at != DAFT_NONE; at = daft_subtree_next(scene, root, at))
        if (scene->entities[at].def.shape == DAFT_SHAPE_SPHERE) return true;
    return false;
}

static bool parent_check(const daft_scene *scene, uint32_t index, uint32_t parent, daft_error *error)
{
    if (scene->entities[index].body)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "it is a body, and a body has no parent");
    const bool round = holds_sphere(scene, index);
    for (uint32_t at = parent; at != DAFT_NONE; at = scene->entities[at].parent) {
        const daft_vec3 scale = scene->entities[at].now.scale;
        if (at == index)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "an entity cannot hang on itself or its children");
        if (round && !daft_scale_is_uniform(scale))
            return daft_fail(error, DAFT_ERROR_ARGUMENT,
                             "the new parent's scale is %g, %g, %g; above a sphere it must be equal in all three axes",
                             (double)scale.x, (double)scale.y, (double)scale.z);
    }
    return true;
}

bool daft_entity_set_parent(daft_scene *scene, daft_entity entity, daft_entity parent, daft_error *error)
{
    daft_error_clear(error);
    daft_entity_item *item = daft_entity_change(scene, entity, error);
    if (!item || (parent.id && !daft_entity_find(scene, parent, error))) return false;
    const uint32_t index = daft_handle_index(entity.id), to = parent.id ? daft_handle_index(parent.id) : DAFT_NONE;
    if (!parent_check(scene, index, to, error)) return false;
    if (item->parent == to) return true;
    const daft_daffine now = map_of(scene, index, false), before = map_of(scene, index, true);
    daft_transform here, there;
    if (!within(scene, to, false, &now, &item->now, &here)) return fail_flat(error);
    if (!within(scene, to, true, &before, &item->now, &there)) there = here;
    if (item->parent != DAFT_NONE) daft_entity_unlink(scene, item);
    item->parent = item->next = item->previous = DAFT_NONE;
    item->def.parent = parent;
    if (to != DAFT_NONE) daft_entity_link(scene, to, index);
    item->now = here, item->before = there;
    item->moved_tick = scene->moved_tick = scene->tick;
    daft_scene_touch(scene);
    return true;
}
