/* Cameras: where they look, how they move between two ticks, and the list that scene files and programs make. */
#include "math/trig.h"
#include "scene/scene.h"

daft_camera daft_default_camera(void)
{
    daft_camera camera;
    daft_struct_default(DAFT_STRUCT_CAMERA, &camera);
    return camera;
}

/* From one place at itself, and from or at nowhere, it looks along +X. */
daft_camera daft_camera_look_at(daft_dvec3 from, daft_dvec3 at, float fov)
{
    daft_dvec3 d = daft_dsub(at, from);
    daft_camera camera = {.position = from, .fov = fov};
    if (!daft_dfinite3(d)) return camera;
    camera.yaw = (float)daft_atan2(d.z, d.x);
    camera.pitch = (float)daft_atan2(-d.y, sqrt(d.x * d.x + d.z * d.z));
    return camera;
}

/* Roll leans right: up tilts towards right, so the horizon turns counter-clockwise in the picture. */
static void exact_axes(const daft_camera *camera, daft_dvec3 *right, daft_dvec3 *up, daft_dvec3 *forward)
{
    double cy = daft_cos((double)camera->yaw), sy = daft_sin((double)camera->yaw);
    double cp = daft_cos((double)camera->pitch), sp = daft_sin((double)camera->pitch);
    double cr = daft_cos((double)camera->roll), sr = daft_sin((double)camera->roll);
    daft_dvec3 f = daft_dv3(cp * cy, -sp, cp * sy), r = daft_dv3(-sy, 0, cy), u = daft_dcross(r, f);
    *forward = f;
    *right = daft_dsub(daft_dscale(r, cr), daft_dscale(u, sr));
    *up = daft_dadd(daft_dscale(u, cr), daft_dscale(r, sr));
}

void daft_camera_axes(const daft_camera *camera, daft_vec3 *right, daft_vec3 *up, daft_vec3 *forward)
{
    daft_dvec3 r, u, f;
    exact_axes(camera, &r, &u, &f);
    *right = daft_to_float(r), *up = daft_to_float(u), *forward = daft_to_float(f);
}

daft_vec3 daft_camera_ray(const daft_camera *camera, double x, double y, double aspect)
{
    daft_dvec3 r, u, f;
    if (!camera || !daft_check_camera(NULL, "camera", camera)) return daft_v3(1, 0, 0);
    exact_axes(camera, &r, &u, &f);
    const double across = daft_tan((double)camera->fov / 2), a = (2 * x - 1) * across,
                 b = (1 - 2 * y) * across * aspect;
    const daft_dvec3 d = daft_dadd(f, daft_dadd(daft_dscale(r, a), daft_dscale(u, b)));
    const double length = sqrt(daft_ddot(d, d));
    return isfinite(length) ? daft_to_float(daft_dscale(d, 1 / length)) : daft_to_float(f);
}

/* ---- the camera in use ---- */

/* Along the shorter way round. */
static float mix_angle(float before, float now, double alpha)
{
    double turn = (double)now - (double)before;
    turn -= 2 * DAFT_PI * floor(turn / (2 * DAFT_PI) + 0.5);
    return (float)((double)before + turn * alpha);
}

static double mix(double before, double now, double alpha) { return before + (now - before) * alpha; }

daft_camera daft_scene_camera(const daft_scene *scene, float alpha)
{
    if (!scene) return daft_default_camera();
    const daft_camera *before = &scene->camera_before, *now = &scene->camera;
    if (!(alpha < 1)) return *now;
    if (alpha <= 0) return *before;
    double a = (double)alpha;
    return (daft_camera){
        .position = daft_dv3(mix(before->position.x, now->position.x, a), mix(before->position.y, now->position.y, a),
                             mix(before->position.z, now->position.z, a)),
        .yaw = mix_angle(before->yaw, now->yaw, a),
        .pitch = mix_angle(before->pitch, now->pitch, a),
        .roll = mix_angle(before->roll, now->roll, a),
        .fov = (float)mix((double)before->fov, (double)now->fov, a),
    };
}

bool daft_scene_set_camera(daft_scene *scene, const daft_camera *camera, bool teleport, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "camera", camera) ||
        !daft_check_camera(error, "camera", camera))
        return false;
    scene->camera = *camera;
    if (teleport) scene->camera_before = *camera;
    return true;
}

/* ---- the list of cameras ---- */

bool daft_cameras_reserve(daft_scene *scene, uint32_t more, daft_error *error)
{
    return daft_grow(scene->allocator, &scene->cameras, &scene->camera_capacity, (size_t)scene->camera_count + more,
                     scene->camera_count, sizeof *scene->cameras) ||
           daft_fail_memory(error, "the list of cameras");
}

void daft_camera_insert(daft_scene *scene, const daft_camera *camera)
{
    if (scene->camera_count == 0) scene->camera = scene->camera_before = *camera;
    scene->cameras[scene->camera_count++] = *camera;
}

bool daft_scene_add_camera(daft_scene *scene, const daft_camera *camera, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "camera", camera) ||
        !daft_check_camera(error, "camera", camera) || !daft_cameras_reserve(scene, 1, error))
        return false;
    daft_camera_insert(scene, camera);
    return true;
}

uint32_t daft_scene_camera_count(const daft_scene *scene) { return scene ? scene->camera_count : 0; }

bool daft_scene_get_camera(const daft_scene *scene, uint32_t index, daft_camera *out, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "out", out)) return false;
    if (index >= scene->camera_count)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "camera %u of %u; the first is 0", index, scene->camera_count);
    *out = scene->cameras[index];
    return true;
}
