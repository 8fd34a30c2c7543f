/* daft_render: checks the view and the target, takes a frame, draws it, releases it. */
#include "raster/view.h"
#include "scene/scene.h"

daft_view daft_default_view(void)
{
    daft_view view;
    daft_struct_default(DAFT_STRUCT_VIEW, &view);
    return view;
}

static bool view_check(const daft_view *view, daft_error *error)
{
    return daft_check_pointer(error, "view", view) && daft_struct_check(DAFT_STRUCT_VIEW, view, error);
}

static bool target_check(const daft_image *target, daft_error *error)
{
    return daft_check_pointer(error, "target", target) &&
           daft_check_pointer(error, "target's pixels", target->pixels) &&
           (!target->drawing || daft_fail(error, DAFT_ERROR_ARGUMENT, "the target is being drawn into")) &&
           daft_check_range(error, "target's width", target->width, 1, 16384, "1 to 16384") &&
           daft_check_range(error, "target's height", target->height, 1, 16384, "1 to 16384");
}

/* Bands are whole rows of tiles. */
static bool rows_check(const daft_view *view, const daft_image *target, daft_error *error)
{
    int first = view->first_row, end = view->row_count ? first + view->row_count : target->height;
    return (first % DAFT_TILE == 0 && first < target->height && end <= target->height &&
            (end % DAFT_TILE == 0 || end == target->height)) ||
           daft_fail(error, DAFT_ERROR_ARGUMENT,
                     "first_row is %d and row_count %d; a band of a picture with %d rows begins and ends at multiples "
                     "of %d, or with the picture",
                     first, view->row_count, target->height, DAFT_TILE);
}

typedef struct watched {
    const daft_view *view;
    daft_engine *engine;
} watched;

static bool call_progress(void *user, float done)
{
    const watched *w = user;
    w->engine->callbacks++;
    bool go_on = w->view->progress(w->view->progress_user, done);
    w->engine->callbacks--;
    return go_on;
}

bool daft_render(daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !view_check(view, error) || !target_check(target, error) ||
        !rows_check(view, target, error))
        return false;
    if (view->quality.scale < 1) return daft_render_small(scene, view, target, error);
    daft_engine *engine = scene->engine;
    if (!engine->renderer)
        engine->renderer = daft_renderer_create(scene->allocator, engine->threads, engine->isa, error);
    if (!engine->renderer) return false;
    daft_scene_frame *frame = daft_frame_take(scene, view, target->width, target->height, error);
    if (!frame) return false;
    daft_frame_target into = {
        .pixels = target->pixels,
        .aov = {.depth = view->aov.depth,
                .normal = view->aov.normal,
                .instance = (uint32_t *)view->aov.entity,
                .triangle = view->aov.triangle,
                .color = view->aov.color,
                .albedo = view->aov.albedo,
                .motion = view->aov.motion,
                .cost = view->aov.cost},
        .progress = view->progress ? call_progress : NULL,
        .progress_user = &(watched){view, engine},
    };
    target->drawing = true;
    bool drawn = daft_frame_draw(frame, engine->renderer, &into, error);
    target->drawing = false;
    daft_frame_release(scene, frame);
    return drawn;
}
