/* Lights, ambient light and the sky. */
#include "scene/scene.h"

daft_light_def daft_default_light_def(void)
{
    return (daft_light_def){
        .cookie = DAFT_COOKIE,
        .kind = DAFT_LIGHT_POINT,
        .direction = {0, -1, 0},
        .color = {1, 1, 1},
        .casts_shadow = true,
        .inner_angle = (float)(DAFT_PI / 8),
        .outer_angle = (float)(DAFT_PI / 6),
    };
}

static bool check_cone(const daft_light_def *def, daft_error *error)
{
    float inner = def->inner_angle, outer = def->outer_angle;
    if (!(outer > 0 && outer <= (float)DAFT_PI))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "outer_angle is %g; it must be above 0 and at most pi, in radians", (double)outer);
    if (inner >= 0 && inner <= outer) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "inner_angle is %g; it must be 0 or more and at most outer_angle, which is %g",
                     (double)inner, (double)outer);
}

bool daft_light_check(const daft_light_def *def, daft_error *error)
{
    if (!daft_check_pointer(error, "def", def) || !daft_check_cookie(error, def->cookie, "daft_default_light_def"))
        return false;
    if ((unsigned)def->kind > DAFT_LIGHT_SPOT)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "kind is %d; it must be point, sun or spot", (int)def->kind);
    return daft_check_finite_position(error, "position", def->position) &&
           daft_check_finite3(error, "direction", def->direction) &&
           (def->kind == DAFT_LIGHT_POINT || daft_check_direction(error, "direction", def->direction)) &&
           (def->kind != DAFT_LIGHT_SPOT || check_cone(def, error)) &&
           daft_check_color(error, "color", def->color);
}

bool daft_lights_reserve(daft_scene *scene, uint32_t more, daft_error *error)
{
    uint32_t needed = daft_slots_needed(&scene->light_slots, more);
    if (needed > DAFT_MAX_SLOTS)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a scene holds at most %d lights", DAFT_MAX_SLOTS);
    return (daft_slots_reserve(&scene->light_slots, scene->allocator, more) &&
            daft_grow(scene->allocator, &scene->lights, &scene->light_capacity, needed, scene->light_slots.count,
                      sizeof *scene->lights)) ||
           daft_fail_memory(error, "the list of lights");
}

daft_light daft_light_insert(daft_scene *scene, const daft_light_def *def)
{
    daft_light light = {daft_slots_add(&scene->light_slots)};
    scene->lights[daft_handle_index(light.id)] = *def;
    return light;
}

daft_light daft_light_create(daft_scene *scene, const daft_light_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_light_check(def, error) ||
        !daft_lights_reserve(scene, 1, error))
        return (daft_light){0};
    return daft_light_insert(scene, def);
}

static uint32_t light_find(const daft_scene *scene, daft_light light, daft_error *error)
{
    if (!daft_check_pointer(error, "scene", scene)) return DAFT_NONE;
    uint32_t index = daft_slots_find(&scene->light_slots, light.id);
    if (index != DAFT_NONE) return index;
    if (light.id == 0)
        daft_fail(error, DAFT_ERROR_HANDLE, "the light is none (0)");
    else
        daft_fail(error, DAFT_ERROR_HANDLE, "light 0x%x is stale: it was destroyed, or is not one of this scene",
                  light.id);
    return DAFT_NONE;
}

bool daft_light_get(daft_scene *scene, daft_light light, daft_light_def *def, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = light_find(scene, light, error);
    if (index == DAFT_NONE || !daft_check_pointer(error, "def", def)) return false;
    *def = scene->lights[index];
    return true;
}

bool daft_light_set(daft_scene *scene, daft_light light, const daft_light_def *def, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = light_find(scene, light, error);
    if (index == DAFT_NONE || !daft_light_check(def, error)) return false;
    scene->lights[index] = *def;
    return true;
}

bool daft_light_destroy(daft_scene *scene, daft_light light, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = light_find(scene, light, error);
    if (index == DAFT_NONE) return false;
    daft_slots_remove(&scene->light_slots, index);
    return true;
}

/* ---- ambient light and sky: calls that cannot fail leave things as they were and warn ---- */

static bool color_or_warn(const daft_scene *scene, const char *name, daft_vec3 color)
{
    daft_error error;
    if (daft_check_color(&error, name, color)) return true;
    daft_warn_at(&scene->engine->log, error.code, NULL, 0, 0, "left as it was: %s", error.message);
    return false;
}

void daft_scene_set_ambient(daft_scene *scene, daft_vec3 color)
{
    if (color_or_warn(scene, "the ambient light's color", color)) scene->ambient = color;
}

void daft_sky_image_adopt(daft_scene *scene, daft_sky_image *image)
{
    daft_sky_free(scene->allocator, &scene->sky_image);
    scene->sky_image = *image;
    *image = (daft_sky_image){0};
    scene->sky = (daft_sky){.kind = DAFT_SKY_IMAGE, .image = &scene->sky_image};
}

static void set_plain_sky(daft_scene *scene, daft_sky_kind kind, daft_vec3 zenith, daft_vec3 horizon)
{
    daft_sky_free(scene->allocator, &scene->sky_image);
    scene->sky_image = (daft_sky_image){0};
    scene->sky = (daft_sky){.kind = kind, .zenith = zenith, .horizon = horizon};
}

void daft_scene_set_sky_color(daft_scene *scene, daft_vec3 color)
{
    if (color_or_warn(scene, "the sky's color", color)) set_plain_sky(scene, DAFT_SKY_COLOR, color, color);
}

void daft_scene_set_sky_gradient(daft_scene *scene, daft_vec3 zenith, daft_vec3 horizon)
{
    if (color_or_warn(scene, "the sky's zenith", zenith) && color_or_warn(scene, "the sky's horizon", horizon))
        set_plain_sky(scene, DAFT_SKY_GRADIENT, zenith, horizon);
}

bool daft_scene_set_sky_image(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    daft_sky_image image = {0};
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "path", path) ||
        !daft_sky_read(scene->allocator, path, &image, error))
        return false;
    daft_sky_image_adopt(scene, &image);
    return true;
}
