/* What a frame's snapshot says of the view, the lights and the sky. Positions are subtracted from the frame's origin in
 * double and rounded to float once, so precision is the same wherever in the world the frame is. */
#include "math/trig.h"
#include "render/render.h"
#include "scene/scene.h"

/* Against the light's direction, unit; in double, so that no length is too short or too long. */
static daft_vec3 towards_light(daft_vec3 direction)
{
    daft_dvec3 d = daft_to_double(direction);
    return daft_to_float(daft_dscale(d, -1 / sqrt(daft_ddot(d, d))));
}

static void set_cone(const daft_light_def *def, daft_light_source *light)
{
    double outer = daft_cos((double)def->outer_angle), range = daft_cos((double)def->inner_angle) - outer;
    light->spot = true;
    light->to_light = towards_light(def->direction);
    light->cone_cosine = (float)outer;
    light->cone_scale = (float)(1 / (range > 1e-7 ? range : 1e-7)); /* what floats can tell */
}

/* The sides of a rectangle: one level, both turned about the direction. */
static void set_sides(const daft_light_def *def, daft_light_source *light)
{
    light->area = DAFT_AREA_RECTANGLE;
    light->to_light = towards_light(def->direction);
    const daft_dvec3 d = daft_dscale(daft_to_double(light->to_light), -1);
    const double level = sqrt(d.x * d.x + d.z * d.z);
    const daft_dvec3 u = level > 1e-6 ? daft_dv3(-d.z / level, 0, d.x / level) : daft_dv3(1, 0, 0),
                     v = daft_dcross(u, d);
    const double c = daft_cos((double)def->turn), s = daft_sin((double)def->turn);
    light->edges[0] = daft_to_float(daft_dscale(daft_dadd(daft_dscale(u, c), daft_dscale(v, s)), (double)def->size.x));
    light->edges[1] = daft_to_float(daft_dscale(daft_dadd(daft_dscale(u, -s), daft_dscale(v, c)), (double)def->size.y));
}

/* False: so far away that it lights nothing. */
static bool make_light(const daft_light_def *def, daft_dvec3 origin, daft_light_source *light)
{
    *light =
        (daft_light_source){.sun = def->kind == DAFT_LIGHT_SUN, .casts_shadow = def->casts_shadow, .color = def->color};
    if (def->kind == DAFT_LIGHT_SPOT) set_cone(def, light);
    if (def->kind == DAFT_LIGHT_RECTANGLE) set_sides(def, light);
    if (!light->sun) light->range = def->range;
    if (!light->sun && !light->area) light->inverse_square = def->inverse_square;
    if (!light->area) light->radius = light->sun ? (float)daft_tan((double)def->disc) : def->radius;
    if (light->sun)
        light->to_light = towards_light(def->direction);
    else
        light->position = daft_to_float(daft_dsub(def->position, origin));
    return daft_fits_kernels(light->position);
}

static bool fill_lights(daft_scene *scene, const daft_view *view, daft_scene_frame *frame, daft_error *error)
{
    daft_snapshot *s = &frame->snapshot;
    daft_arena_reset(&frame->lights);
    daft_light_source *lights =
        daft_arena_alloc(&frame->lights, scene->light_slots.live + DAFT_GLOW_LIGHTS * scene->glowing, sizeof *lights);
    if (!lights) return daft_fail_memory(error, "a snapshot's lights");
    const daft_dvec3 origin = view->camera.position;
    uint32_t slots = view->without & DAFT_WITHOUT_SHADING ? 0 : scene->light_slots.count;
    s->light_count = 0;
    for (uint32_t i = 0; i < slots; i++)
        if (scene->light_slots.items[i].live && make_light(&scene->lights[i], origin, &lights[s->light_count]))
            s->light_count++;
    uint32_t left = view->without & DAFT_WITHOUT_SHADING ? 0 : scene->glowing;
    for (uint32_t i = 0; left > 0; i++) {
        if (!scene->entity_slots.items[i].live || !scene->entities[i].def.lights) continue;
        uint32_t count;
        if (!daft_glow_lights(scene, i, view->alpha, origin, &lights[s->light_count], &count, error)) return false;
        s->light_count += count, left--;
    }
    s->lights = lights;
    return true;
}

/* Towards the first sun, fog has some of its colour. */
static daft_air air_of(const daft_scene *scene, const daft_view *view, const daft_snapshot *s)
{
    const daft_fog *fog = &scene->fog;
    daft_air air = {.color = fog->color,
                    .density = view->without & DAFT_WITHOUT_SHADING ? 0 : fog->density,
                    .thinning = fog->height > 0 ? 1 / fog->height : 0,
                    .base = (float)((double)fog->base - view->camera.position.y)};
    for (uint32_t i = s->light_count; i-- > 0 && fog->glow > 0;)
        if (s->lights[i].sun) air.glow = fog->glow, air.sun = s->lights[i].color, air.to_sun = s->lights[i].to_light;
    return air;
}

/* The disc of the first sun that is to be seen. Its light is what lights surfaces, over its solid angle; but no more
 * than some times as bright as white is, so that few rays of rough mirrors do not flare up where they meet it. */
static void show_sun(const daft_scene *scene, daft_sky *sky)
{
    for (uint32_t i = 0; i < scene->light_slots.count; i++) {
        const daft_light_def *def = &scene->lights[i];
        if (!scene->light_slots.items[i].live || def->kind != DAFT_LIGHT_SUN || !def->visible || !(def->disc > 0))
            continue;
        const double sine = daft_sin((double)def->disc), half = daft_sin((double)def->disc / 2);
        sky->sun = daft_scale(def->color, (float)fmin(1 / (sine * sine), 16));
        sky->to_sun = towards_light(def->direction), sky->sun_chord2 = (float)(4 * half * half);
        return;
    }
}

/* The sky's light is found when it is first asked for. */
static daft_ambient ambient_of_sky(daft_scene *scene)
{
    daft_ambient ambient = {.by_normal = true};
    if (!scene->harmonics_known) daft_sky_irradiance(&scene->sky, scene->harmonics);
    scene->harmonics_known = true;
    for (int k = 0; k < DAFT_HARMONICS; k++) ambient.harmonics[k] = daft_scale(scene->harmonics[k], scene->ambient_sky);
    return ambient;
}

static daft_ambient ambient_of(daft_scene *scene, const daft_view *view)
{
    if (view->without & DAFT_WITHOUT_SHADING) return (daft_ambient){.color = {1, 1, 1}};
    if (view->without & DAFT_WITHOUT_AMBIENT) return (daft_ambient){0};
    return scene->ambient_sky > 0 ? ambient_of_sky(scene) : (daft_ambient){.color = scene->ambient};
}

bool daft_snapshot_fill(daft_scene *scene, const daft_view *view, int width, int height, daft_scene_frame *frame,
                        daft_error *error)
{
    daft_snapshot *s = &frame->snapshot;
    s->width = width, s->height = height;
    s->first_row = view->first_row, s->row_count = view->row_count ? view->row_count : height - view->first_row;
    s->focal = (float)(width / 2.0 / daft_tan((double)view->camera.fov / 2));
    s->quality = view->quality;
    if (daft_uses_kdtrees(scene, view)) s->quality.tree = DAFT_TREE_KDTREE;
    s->ambient = ambient_of(scene, view);
    s->occlusion = view->without & DAFT_WITHOUT_SHADING ? 0 : scene->occlusion;
    s->sky = scene->sky;
    if (!(view->without & DAFT_WITHOUT_SHADING)) show_sun(scene, &s->sky);
    s->tone = (daft_tone){scene->exposure.ev, scene->exposure.curve}, s->metered = scene->exposure.automatic;
    daft_camera_axes(&view->camera, &s->right, &s->up, &s->forward);
    if (!fill_lights(scene, view, frame, error)) return false;
    s->air = air_of(scene, view, s);
    return true;
}
