/* The engine, its images, and scenes as a whole. */
#include "math/simd/dispatch.h"
#include "scene/scene.h"

#include <string.h>

enum { MAX_THREADS = 64, MAX_IMAGE_SIDE = 16384 };

daft_engine_def daft_default_engine_def(void)
{
    daft_engine_def def;
    daft_struct_default(DAFT_STRUCT_ENGINE_DEF, &def);
    return def;
}

/* ---- callbacks ---- */

static bool outside_callbacks(const daft_engine *engine, daft_error *error)
{
    return (engine->callbacks == 0 && !daft_budget_is_calling(engine->budget)) ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "called from inside a callback of this engine");
}

bool daft_engine_ready(const daft_engine *engine, daft_error *error)
{
    return daft_check_pointer(error, "engine", engine) && outside_callbacks(engine, error);
}

bool daft_scene_ready(const daft_scene *scene, daft_error *error)
{
    return daft_check_pointer(error, "scene", scene) && outside_callbacks(scene->engine, error);
}

static bool ready_or_warn(const daft_engine *engine, const char *what)
{
    daft_error error;
    if (outside_callbacks(engine, &error)) return true;
    if (engine->callbacks) daft_warn_at(&engine->log, error.code, NULL, 0, 0, "%s: %s", what, error.message);
    return false;
}

bool daft_scene_ready_or_warn(const daft_scene *scene, const char *what)
{
    return scene && ready_or_warn(scene->engine, what);
}

/* ---- engines ---- */

static bool choose_isa(const char *name, int *isa, daft_error *error)
{
    switch (daft_isa_find(name, isa)) {
    case DAFT_ISA_READY: return true;
    case DAFT_ISA_NOT_BUILT:
        return daft_fail(error, DAFT_ERROR_UNSUPPORTED, "this build has no kernels for %s; the best it has is %s", name,
                         daft_isa_name(*isa));
    case DAFT_ISA_UNSUPPORTED:
        return daft_fail(error, DAFT_ERROR_UNSUPPORTED, "this processor has no %s; the best it has is %s", name,
                         daft_isa_name(*isa));
    case DAFT_ISA_UNKNOWN: break;
    }
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "unknown instruction set '%.64s'; known are %s", name,
                     daft_isa_names());
}

daft_engine *daft_engine_create(const daft_engine_def *def, daft_error *error)
{
    daft_error_clear(error);
    int isa;
    if (!daft_check_pointer(error, "def", def) || !daft_struct_check(DAFT_STRUCT_ENGINE_DEF, def, error) ||
        !choose_isa(def->isa, &isa, error))
        return NULL;
    daft_allocator allocator = def->allocator;
    if (!allocator.allocate && !allocator.release) {
        allocator = daft_malloc_allocator();
    } else if (!allocator.allocate || !allocator.release) {
        daft_fail(error, DAFT_ERROR_ARGUMENT, "allocator.%s is NULL; give both functions or none",
                  allocator.allocate ? "release" : "allocate");
        return NULL;
    }
    daft_budget *budget = daft_budget_open(&allocator, def->memory_limit);
    if (budget) allocator = daft_budget_allocator(budget);
    daft_engine *engine = budget ? daft_alloc_zero(&allocator, 1, sizeof *engine) : NULL;
    if (!engine) {
        daft_budget_close(budget);
        daft_fail_memory(error, "an engine");
        return NULL;
    }
    engine->allocator = allocator;
    engine->budget = budget;
    engine->log = (daft_log){def->warn, def->warn_user, &engine->callbacks, false};
    engine->threads = def->threads == 0 ? daft_processor_count() : daft_min_i(daft_max_i(def->threads, 1), MAX_THREADS);
    engine->isa = isa;
    engine->accel = def->accel;
    return engine;
}

void daft_engine_destroy(daft_engine *engine)
{
    if (!engine || !ready_or_warn(engine, "the engine is not destroyed")) return;
    if (engine->scenes > 0) {
        /* A leak is better than scenes whose engine is gone. */
        daft_warn_at(&engine->log, DAFT_ERROR_ARGUMENT, NULL, 0, 0,
                     "the engine is not destroyed: %d of its scenes still stand", engine->scenes);
        return;
    }
    daft_renderer_destroy(engine->renderer);
    daft_allocator allocator = engine->allocator;
    daft_budget *budget = engine->budget;
    daft_release(&allocator, engine);
    daft_budget_close(budget);
}

daft_memory daft_engine_memory(const daft_engine *engine)
{
    return engine ? daft_budget_memory(engine->budget) : (daft_memory){0, 0, 0};
}

bool daft_engine_reserve(daft_engine *engine, uint64_t bytes)
{
    if (!engine || !daft_budget_take(engine->budget, bytes)) return false;
    atomic_fetch_add(&engine->reserved, bytes);
    return true;
}

void daft_engine_unreserve(daft_engine *engine, uint64_t bytes)
{
    if (!engine) return;
    unsigned long long reserved = atomic_load(&engine->reserved), given;
    do given = bytes < reserved ? bytes : reserved; /* what the engine itself holds is not the caller's to give back */
    while (!atomic_compare_exchange_weak(&engine->reserved, &reserved, reserved - given));
    if (given) daft_budget_give(engine->budget, given);
}

bool daft_engine_set_files(daft_engine *engine, const daft_files *files, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_engine_ready(engine, error)) return false;
    engine->files = files;
    return true;
}

int daft_engine_threads(const daft_engine *engine) { return engine ? engine->threads : 0; }
const char *daft_engine_isa(const daft_engine *engine) { return engine ? daft_isa_name(engine->isa) : NULL; }

/* ---- images ---- */

static daft_image *image_new(daft_engine *engine, daft_error *error)
{
    daft_image *image = daft_alloc_zero(&engine->allocator, 1, sizeof *image);
    if (image)
        image->allocator = engine->allocator;
    else
        daft_fail_memory(error, "an image");
    return image;
}

daft_image *daft_image_create(daft_engine *engine, int width, int height, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_engine_ready(engine, error) ||
        !daft_check_range(error, "width", width, 1, MAX_IMAGE_SIDE, "1 to 16384 pixels") ||
        !daft_check_range(error, "height", height, 1, MAX_IMAGE_SIDE, "1 to 16384 pixels"))
        return NULL;
    daft_image *image = image_new(engine, error);
    if (!image) return NULL;
    image->width = width;
    image->height = height;
    image->pixels = daft_alloc_zero(&engine->allocator, (size_t)width * (size_t)height, 4);
    if (image->pixels) return image;
    daft_release(&engine->allocator, image);
    daft_fail(error, DAFT_ERROR_MEMORY, "out of memory for an image of %d x %d pixels", width, height);
    return NULL;
}

daft_image *daft_image_load(daft_engine *engine, const char *path, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_engine_ready(engine, error) || !daft_check_pointer(error, "path", path)) return NULL;
    daft_image *image = image_new(engine, error);
    if (!image) return NULL;
    if (daft_image_read(&engine->allocator, engine->files, path, image, error)) return image;
    daft_release(&engine->allocator, image);
    return NULL;
}

/* ---- scenes ---- */

daft_scene *daft_scene_create(daft_engine *engine, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_engine_ready(engine, error)) return NULL;
    daft_scene *scene = daft_alloc_zero(&engine->allocator, 1, sizeof *scene);
    if (!scene) {
        daft_fail_memory(error, "a scene");
        return NULL;
    }
    scene->engine = engine;
    scene->allocator = &engine->allocator;
    daft_slots_init(&scene->entity_slots);
    daft_slots_init(&scene->light_slots);
    daft_slots_init(&scene->character_slots);
    daft_slots_init(&scene->joint_slots);
    scene->ambient = daft_v3(0.2f, 0.2f, 0.2f);
    scene->fog = daft_default_fog();
    scene->exposure = daft_default_exposure();
    scene->camera = scene->camera_before = daft_default_camera();
    scene->quality = daft_preset_quality(DAFT_PRESET_GAME);
    scene->gravity = daft_v3(0, -9.81f, 0);
    scene->moved_tick = UINT64_MAX;
    daft_arena_init(&scene->query.arena, scene->allocator);
    scene->counters.threads = engine->threads;
    scene->counters.isa = daft_isa_name(engine->isa);
    engine->scenes++;
    if (daft_assets_init(scene, error)) return scene;
    daft_scene_destroy(scene);
    return NULL;
}

void daft_scene_destroy(daft_scene *scene)
{
    if (!daft_scene_ready_or_warn(scene, "the scene is not destroyed")) return;
    const daft_allocator *allocator = scene->allocator;
    if (scene->world) daft_world_destroy(scene->world);
    for (uint32_t i = 0; i < scene->entity_slots.count; i++)
        if (scene->entity_slots.items[i].live) daft_release(allocator, scene->entities[i].geometries);
    daft_geometries_free(scene);
    while (scene->animated) daft_animated_free(scene, scene->animated);
    daft_frames_free(scene);
    daft_scaled_free(scene);
    daft_assets_free(scene);
    daft_sky_item_free(scene, scene->sky_item);
    daft_slots_free(&scene->entity_slots, allocator);
    daft_slots_free(&scene->light_slots, allocator);
    daft_slots_free(&scene->joint_slots, allocator);
    daft_release(allocator, scene->joints);
    daft_release(allocator, scene->entities);
    daft_slots_free(&scene->character_slots, allocator);
    daft_release(allocator, scene->characters);
    daft_release(allocator, scene->lights);
    daft_release(allocator, scene->cameras);
    daft_release(allocator, scene->path);
    daft_names_free(scene);
    daft_scene_files_free(scene);
    daft_release(allocator, scene->moving);
    daft_arena_free(&scene->query.arena);
    scene->engine->scenes--;
    daft_release(allocator, scene);
}

const daft_counters *daft_scene_counters(const daft_scene *scene) { return scene ? &scene->counters : NULL; }
