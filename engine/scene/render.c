/* daft_render: checks the view, makes the snapshot, asks render/ for the picture, gives ids back as entities. */
#include "render/render.h"
#include "scene/scene.h"

daft_view daft_default_view(void)
{
    return (daft_view){
        .cookie = DAFT_COOKIE, .camera = daft_default_camera(), .alpha = 1, .quality = DAFT_QUALITY_GAME};
}

static bool view_check(const daft_view *view, daft_error *error)
{
    if (!daft_check_pointer(error, "view", view) || !daft_check_cookie(error, view->cookie, "daft_default_view") ||
        !daft_check_camera(error, "camera", &view->camera) ||
        !daft_check_range(error, "alpha", (double)view->alpha, 0, 1, "between 0 and 1"))
        return false;
    if (!daft_quality_preset(view->quality))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "quality is %d; it must be draft, game, high or reference",
                         (int)view->quality);
    if ((unsigned)view->intersection > DAFT_INTERSECT_FAST)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "intersection is %d; it must be exact, watertight or fast",
                         (int)view->intersection);
    int n = view->samples;
    return n == 0 || n == 1 || n == 4 || n == 16 ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "samples is %d; it must be 0 (the quality's), 1, 4 or 16", n);
}

static bool target_check(const daft_image *target, daft_error *error)
{
    return daft_check_pointer(error, "target", target) &&
           daft_check_pointer(error, "target's pixels", target->pixels) &&
           daft_check_range(error, "target's width", target->width, 1, 16384, "1 to 16384") &&
           daft_check_range(error, "target's height", target->height, 1, 16384, "1 to 16384");
}

/* The renderer writes instance numbers where the caller wants entities: both are 32 bits, so they are turned in place.
 */
static void name_entities(const daft_snapshot *snapshot, uint32_t *ids, bool drawn)
{
    if (!ids) return;
    size_t count = (size_t)snapshot->width * (size_t)snapshot->height;
    for (size_t i = 0; i < count; i++)
        ids[i] = drawn && ids[i] < snapshot->instance_count ? snapshot->instances[ids[i]].entity : 0;
}

bool daft_render(daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error)
{
    _Static_assert(sizeof(daft_entity) == sizeof(uint32_t), "an entity is one number");
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !view_check(view, error) || !target_check(target, error))
        return false;
    daft_engine *engine = scene->engine;
    if (!engine->renderer)
        engine->renderer = daft_renderer_create(scene->allocator, engine->threads, engine->isa, error);
    daft_snapshot snapshot;
    if (!engine->renderer || !daft_snapshot_fill(scene, view, target->width, target->height, &snapshot, error))
        return false;
    daft_frame_target frame = {
        .pixels = target->pixels,
        .aov = {view->aov.depth, view->aov.normal, (uint32_t *)view->aov.entity, view->aov.triangle},
        .progress = view->progress,
        .progress_user = view->progress_user,
    };
    bool drawn = daft_render_frame(engine->renderer, &snapshot, &frame, &scene->counters, error);
    name_entities(&snapshot, frame.aov.instance, drawn);
    return drawn;
}
