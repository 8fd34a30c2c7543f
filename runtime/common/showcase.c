/* A mesh without a scene. */
#include "common/showcase.h"

#include "common/util.h"

#include <math.h>

bool showcase_is_mesh(const char *path)
{
    static const char *const known[] = {".obj", ".gltf", ".glb", ".fbx", ".dae", ".ply", ".stl", ".3ds", ".blend"};
    for (size_t i = 0; i < COUNT_OF(known); i++)
        if (has_extension(path, known[i])) return true;
    return false;
}

/* At the distance D at which the corners of the box just fit. A corner c, relative to the centre, has depth
 * D + forward·c and lies in the picture when |right·c| <= tan·(D + forward·c), and likewise for up. */
daft_camera showcase_camera(daft_dvec3 from, daft_dvec3 to, double aspect)
{
    const double fov = 0.8, across = daft_tan(fov / 2), back[3] = {0.42, 0.34, 0.8414};
    const double flat = sqrt(back[0] * back[0] + back[2] * back[2]);
    const double right[3] = {back[2] / flat, 0, -back[0] / flat};
    const double up[3] = {-back[0] * back[1] / flat, flat, -back[2] * back[1] / flat};
    const double low[3] = {from.x, from.y, from.z}, high[3] = {to.x, to.y, to.z};
    double middle[3], distance = 0;
    for (int i = 0; i < 3; i++) middle[i] = (low[i] + high[i]) / 2;
    for (int corner = 0; corner < 8; corner++) {
        double x = 0, y = 0, depth = 0;
        for (int i = 0; i < 3; i++) {
            double c = (corner >> i & 1 ? high[i] : low[i]) - middle[i];
            x += right[i] * c, y += up[i] * c, depth -= back[i] * c;
        }
        distance = fmax(distance, fmax(fabs(x) / across, fabs(y) / (across * aspect)) - depth);
    }
    distance = distance > 0 ? distance * 1.06 : 1;
    daft_dvec3 at = {middle[0], middle[1], middle[2]};
    daft_dvec3 eye = {at.x + distance * back[0], at.y + distance * back[1], at.z + distance * back[2]};
    return daft_camera_look_at(eye, at, (float)fov);
}

static daft_dvec3 to_double(daft_vec3 v) { return (daft_dvec3){(double)v.x, (double)v.y, (double)v.z}; }

/* What a light gives a surface at `at` that faces it, by its brightest colour; no nearer than `near` metres. */
static double brightness(const daft_light_def *light, daft_dvec3 at, double near)
{
    const daft_dvec3 p = light->position;
    const double color = fmax(fmax((double)light->color.x, (double)light->color.y), (double)light->color.z);
    const double x = p.x - at.x, y = p.y - at.y, z = p.z - at.z;
    return light->inverse_square ? color / fmax(x * x + y * y + z * z, near * near) : color;
}

/* The file's own lights in proportion to each other, so bright that in the middle of the mesh the brightest lights a
 * white surface white: some files say lux, some say nothing. Without any, a sun. */
static bool add_lights(daft_scene *scene, daft_mesh mesh, const daft_mesh_info *info, daft_error *error)
{
    const daft_dvec3 low = to_double(info->low), high = to_double(info->high);
    const daft_dvec3 middle = {(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
    const double x = high.x - low.x, y = high.y - low.y, z = high.z - low.z, near = sqrt(x * x + y * y + z * z) / 8;
    daft_mesh_light one;
    double most = 0;
    for (uint32_t i = 0; i < info->light_count; i++) {
        if (!daft_mesh_get_light(scene, mesh, i, NULL, &one, error)) return false;
        most = fmax(most, brightness(&one.light, middle, near));
    }
    for (uint32_t i = 0; most > 0 && i < info->light_count; i++) {
        if (!daft_mesh_get_light(scene, mesh, i, NULL, &one, error)) return false;
        float *const color[3] = {&one.light.color.x, &one.light.color.y, &one.light.color.z};
        for (int k = 0; k < 3; k++) *color[k] = (float)((double)*color[k] / most);
        if (!daft_light_create(scene, &one.light, error).id) return false;
    }
    if (most > 0) return true;
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN;
    sun.direction = (daft_vec3){-0.35f, -1, -0.9f};
    sun.color = (daft_vec3){0.75f, 0.73f, 0.7f};
    return daft_light_create(scene, &sun, error).id != 0;
}

/* The file's, and behind them one that sees all: exporters add cameras that look elsewhere. */
static bool add_cameras(daft_scene *scene, daft_mesh mesh, const daft_mesh_info *info, double aspect, daft_error *error)
{
    const daft_camera all = showcase_camera(to_double(info->low), to_double(info->high), aspect);
    daft_mesh_camera one;
    for (uint32_t i = 0; i < info->camera_count; i++)
        if (!daft_mesh_get_camera(scene, mesh, i, NULL, &one, error) ||
            !daft_scene_add_camera(scene, &one.camera, error))
            return false;
    return daft_scene_add_camera(scene, &all, error);
}

bool showcase_mesh(daft_scene *scene, const char *path, double aspect, daft_error *error)
{
    daft_mesh mesh = daft_mesh_load(scene, path, error);
    daft_mesh_info info;
    if (mesh.id == 0 || !daft_mesh_get_info(scene, mesh, &info, error)) return false;
    if (info.triangle_count == 0) return fail_at(error, path, 0, 0, "the mesh has no triangles to draw");
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH;
    def.mesh = mesh;
    if (!daft_entity_create(scene, &def, error).id || !add_lights(scene, mesh, &info, error)) return false;
    daft_scene_set_ambient(scene, (daft_vec3){0.22f, 0.24f, 0.28f});
    daft_scene_set_sky_gradient(scene, (daft_vec3){0.16f, 0.35f, 0.72f}, (daft_vec3){0.8f, 0.88f, 0.95f});
    return add_cameras(scene, mesh, &info, aspect, error);
}
