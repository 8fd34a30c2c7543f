/* Cameras and lights that mesh files have. */
#include "math/trig.h"
#include "scene/scene.h"

#include <string.h>

static daft_dvec3 move(const daft_daffine *a, daft_dvec3 p)
{
    const double *m = a->m, *t = a->t;
    return daft_dv3(m[0] * p.x + m[1] * p.y + m[2] * p.z + t[0], m[3] * p.x + m[4] * p.y + m[5] * p.z + t[1],
                    m[6] * p.x + m[7] * p.y + m[8] * p.z + t[2]);
}

/* Of length 1; `other` where a scale of 0 leaves no direction. */
static daft_dvec3 turn(const daft_daffine *a, daft_vec3 v, daft_dvec3 other)
{
    const daft_daffine still = {.m = {a->m[0], a->m[1], a->m[2], a->m[3], a->m[4], a->m[5], a->m[6], a->m[7], a->m[8]}};
    const daft_dvec3 d = move(&still, daft_to_double(v));
    const double length = sqrt(daft_ddot(d, d));
    return length > 0 && isfinite(length) ? daft_dscale(d, 1 / length) : other;
}

/* The roll is what turns the level camera's up, as exact_axes of camera.c has it, to the side of this one's. */
daft_camera daft_scenery_camera(const daft_obj_camera *camera, const daft_daffine *at)
{
    const daft_dvec3 f = turn(at, camera->forward, daft_dv3(1, 0, 0)), up = turn(at, camera->up, daft_dv3(0, 1, 0));
    const double yaw = daft_atan2(f.z, f.x), pitch = daft_atan2(-f.y, sqrt(f.x * f.x + f.z * f.z));
    const daft_dvec3 right = daft_dv3(-daft_sin(yaw), 0, daft_cos(yaw)), level = daft_dcross(right, f);
    return (daft_camera){.position = move(at, camera->position),
                         .yaw = (float)yaw,
                         .pitch = (float)pitch,
                         .roll = (float)daft_atan2(daft_ddot(up, right), daft_ddot(up, level)),
                         .fov = camera->fov};
}

daft_light_def daft_scenery_light(const daft_obj_light *light, const daft_daffine *at)
{
    daft_light_def def = daft_default_light_def();
    def.kind = light->kind, def.color = light->color;
    def.position = move(at, light->position);
    def.direction = daft_to_float(turn(at, light->direction, daft_dv3(0, -1, 0)));
    def.range = light->range, def.inverse_square = light->inverse_square;
    if (light->kind == DAFT_LIGHT_SPOT) def.inner_angle = light->inner_angle, def.outer_angle = light->outer_angle;
    return def;
}

static bool place(const daft_transform *transform, daft_daffine *out, daft_error *error)
{
    const daft_transform still = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    if (transform && !daft_transform_check(transform, error)) return false;
    *out = daft_daffine_from(transform ? transform : &still);
    return true;
}

/* The mesh's scenery, or NULL. */
static const daft_scenery *find(daft_scene *scene, daft_mesh mesh, const void *out, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "out", out)) return NULL;
    const daft_mesh_item *item = daft_mesh_find(scene, mesh, error);
    return item ? &item->scenery : NULL;
}

bool daft_mesh_get_camera(daft_scene *scene, daft_mesh mesh, uint32_t index, const daft_transform *at,
                          daft_mesh_camera *out, daft_error *error)
{
    const daft_scenery *all = find(scene, mesh, out, error);
    daft_daffine where;
    if (!all || !place(at, &where, error)) return false;
    if (index >= all->camera_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "camera %u of a mesh that has %u", index, all->camera_count);
    memcpy(out->name, all->cameras[index].name, sizeof out->name);
    out->camera = daft_scenery_camera(&all->cameras[index], &where);
    return true;
}

bool daft_mesh_get_light(daft_scene *scene, daft_mesh mesh, uint32_t index, const daft_transform *at,
                         daft_mesh_light *out, daft_error *error)
{
    const daft_scenery *all = find(scene, mesh, out, error);
    daft_daffine where;
    if (!all || !place(at, &where, error)) return false;
    if (index >= all->light_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "light %u of a mesh that has %u", index, all->light_count);
    memcpy(out->name, all->lights[index].name, sizeof out->name);
    out->light = daft_scenery_light(&all->lights[index], &where);
    return true;
}
