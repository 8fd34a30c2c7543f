/* The frame snapshot: what render/ and the ray queries see of a scene. Positions are subtracted from the frame's origin
 * in double and rounded to float once, so precision is the same wherever in the world the frame is. */
#include "render/render.h"
#include "math/trig.h"
#include "scene/scene.h"

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
        if (daft_fits_kernels(lamp->position)) out->lamp_count++; /* farther away it lights nothing */
    }
    out->lamps = lamps;
    return true;
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
    if (!daft_place_instances(scene, view->camera.position, view->alpha, error)) return false;
    out->instances = scene->placed.instances, out->instance_count = scene->placed.count, out->revision = scene->placed.number;
    return fill_lamps(scene, view->camera.position, out, error);
}
