/* Lights, ambient light and the sky. */
#include "scene/scene.h"

daft_light_def daft_default_light_def(void)
{
    daft_light_def def;
    daft_struct_default(DAFT_STRUCT_LIGHT_DEF, &def);
    return def;
}

bool daft_light_check(const daft_light_def *def, daft_error *error)
{
    if (!daft_check_pointer(error, "def", def) || !daft_struct_check(DAFT_STRUCT_LIGHT_DEF, def, error)) return false;
    float inner = def->inner_angle, outer = def->outer_angle;
    return def->kind != DAFT_LIGHT_SPOT || inner <= outer ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "inner_angle is %g; it must be at most outer_angle, which is %g",
                     (double)inner, (double)outer);
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
    if (!daft_scene_ready(scene, error) || !daft_light_check(def, error) || !daft_lights_reserve(scene, 1, error))
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

static uint32_t light_change(const daft_scene *scene, daft_light light, daft_error *error)
{
    return daft_scene_ready(scene, error) ? light_find(scene, light, error) : DAFT_NONE;
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
    uint32_t index = light_change(scene, light, error);
    if (index == DAFT_NONE || !daft_light_check(def, error)) return false;
    scene->lights[index] = *def;
    return true;
}

bool daft_light_destroy(daft_scene *scene, daft_light light, daft_error *error)
{
    daft_error_clear(error);
    uint32_t index = light_change(scene, light, error);
    if (index == DAFT_NONE) return false;
    daft_slots_remove(&scene->light_slots, index);
    return true;
}

/* ---- ambient light and sky: calls that cannot fail leave things as they were and warn ---- */

static bool color_or_warn(const daft_scene *scene, const char *name, daft_vec3 color)
{
    daft_error error;
    if (!daft_scene_ready_or_warn(scene, name)) return false;
    if (daft_check_color(&error, name, color)) return true;
    daft_warn_at(&scene->engine->log, error.code, NULL, 0, 0, "left as it was: %s", error.message);
    return false;
}

void daft_scene_set_ambient(daft_scene *scene, daft_vec3 color)
{
    if (color_or_warn(scene, "the ambient light's color", color)) scene->ambient = color, scene->ambient_sky = 0;
}

void daft_scene_set_ambient_sky(daft_scene *scene, float strength)
{
    static const char name[] = "the strength of the sky's light";
    if (!daft_scene_ready_or_warn(scene, name)) return;
    if (strength >= 0 && strength <= 1e6f)
        scene->ambient_sky = strength;
    else
        daft_warn_at(&scene->engine->log, DAFT_ERROR_ARGUMENT, NULL, 0, 0,
                     "left as it was: %s is %g; it must be 0 to 1e6", name, (double)strength);
}

void daft_scene_set_ambient_occlusion(daft_scene *scene, float distance)
{
    static const char name[] = "the distance of ambient occlusion";
    if (!daft_scene_ready_or_warn(scene, name)) return;
    if (distance >= 0 && distance <= 1e6f)
        scene->occlusion = distance;
    else
        daft_warn_at(&scene->engine->log, DAFT_ERROR_ARGUMENT, NULL, 0, 0,
                     "left as it was: %s is %g; it must be 0 to 1e6", name, (double)distance);
}

daft_fog daft_default_fog(void)
{
    daft_fog fog;
    daft_struct_default(DAFT_STRUCT_FOG, &fog);
    return fog;
}

bool daft_scene_set_fog(daft_scene *scene, const daft_fog *fog, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "fog", fog) ||
        !daft_struct_check(DAFT_STRUCT_FOG, fog, error))
        return false;
    scene->fog = *fog;
    return true;
}

daft_fog daft_scene_fog(const daft_scene *scene) { return scene ? scene->fog : daft_default_fog(); }

daft_exposure daft_default_exposure(void)
{
    daft_exposure exposure;
    daft_struct_default(DAFT_STRUCT_EXPOSURE, &exposure);
    return exposure;
}

bool daft_scene_set_exposure(daft_scene *scene, const daft_exposure *exposure, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "exposure", exposure) ||
        !daft_struct_check(DAFT_STRUCT_EXPOSURE, exposure, error))
        return false;
    scene->exposure = *exposure;
    return true;
}

daft_exposure daft_scene_exposure(const daft_scene *scene) { return scene ? scene->exposure : daft_default_exposure(); }

bool daft_sky_images_read(daft_engine *engine, const char *const *paths, int count, daft_sky_image *out,
                          daft_error *error)
{
    daft_image_file files[6];
    char *bytes[6] = {NULL};
    bool done = true;
    for (int i = 0; done && i < count; i++) {
        files[i] = (daft_image_file){.path = paths[i]};
        files[i].bytes = bytes[i] = daft_file_read(&engine->allocator, engine->files, paths[i], &files[i].size, error);
        done = bytes[i] != NULL;
    }
    done = done && daft_sky_share(&engine->images, &engine->allocator, files, count, out, error);
    for (int i = 0; i < count; i++) daft_release(&engine->allocator, bytes[i]);
    return done;
}

daft_sky_item *daft_sky_item_read(const daft_scene *scene, const char *const *paths, int count, daft_error *error)
{
    daft_sky_item *item = daft_alloc_zero(scene->allocator, 1, sizeof *item);
    if (!item) daft_fail_memory(error, "a sky");
    if (item && daft_sky_images_read(scene->engine, paths, count, &item->image, error)) return item;
    daft_release(scene->allocator, item);
    return NULL;
}

void daft_sky_item_free(const daft_scene *scene, daft_sky_item *item)
{
    if (!item) return;
    daft_sky_free(scene->allocator, &item->image);
    daft_release(scene->allocator, item);
}

static void free_retired_sky(const daft_scene *scene, daft_retired *item)
{
    daft_sky_item_free(scene, (daft_sky_item *)item);
}

static void let_go_of_sky(daft_scene *scene)
{
    if (scene->sky_item) daft_retire(scene, &scene->sky_item->retired, free_retired_sky);
    scene->sky_item = NULL;
}

void daft_sky_adopt(daft_scene *scene, daft_sky_item *item)
{
    let_go_of_sky(scene);
    scene->looks = ++scene->engine->revision;
    scene->sky_item = item;
    scene->harmonics_known = item->image.cube;
    scene->sky = (daft_sky){.kind = item->image.cube ? DAFT_SKY_CUBE : DAFT_SKY_IMAGE, .image = &item->image};
    if (item->image.cube) daft_sky_irradiance(&scene->sky, scene->harmonics);
    scene->sky.mean = item->image.cube ? scene->harmonics[0] : daft_sky_mean(&item->image);
}

static void set_plain_sky(daft_scene *scene, daft_sky_kind kind, daft_vec3 zenith, daft_vec3 horizon)
{
    let_go_of_sky(scene);
    scene->harmonics_known = false;
    /* The integral of what sky_gradient() says, over all directions. */
    const daft_vec3 mean = daft_add(daft_scale(zenith, 3.0f / 5), daft_scale(horizon, 19.0f / 60));
    scene->sky =
        (daft_sky){.kind = kind, .zenith = zenith, .horizon = horizon, .mean = kind == DAFT_SKY_COLOR ? zenith : mean};
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

bool daft_sky_note_files(daft_scene *scene, const char *const *paths, int count, daft_error *error)
{
    for (int i = 0; i < count; i++)
        if (!daft_scene_note_file(scene, paths[i], error)) return false;
    return true;
}

static bool set_sky_images(daft_scene *scene, const char *const *paths, int count, daft_error *error)
{
    daft_sky_item *item = daft_sky_item_read(scene, paths, count, error);
    if (item && !daft_sky_note_files(scene, paths, count, error)) {
        daft_sky_item_free(scene, item);
        return false;
    }
    if (item) daft_sky_adopt(scene, item);
    return item != NULL;
}

bool daft_scene_set_sky_image(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    return daft_scene_ready(scene, error) && daft_check_pointer(error, "path", path) &&
           set_sky_images(scene, &path, 1, error);
}

bool daft_scene_set_sky_cube(daft_scene *scene, const char *const paths[6], daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "paths", paths)) return false;
    for (int i = 0; i < 6; i++)
        if (!daft_check_pointer(error, "a path of the six", paths[i])) return false;
    return set_sky_images(scene, paths, 6, error);
}
