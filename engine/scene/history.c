/* What pictures remember of the one before: its camera, and where each of its instances was. Both are taken when a
 * frame is taken, on the scene's thread, so that it may be drawn on another one while the next is taken. */
#include "math/trig.h"
#include "scene/scene.h"

typedef struct placed {
    uint32_t entity;
    daft_affine to_frame;
} placed;

struct daft_history {
    daft_past past[DAFT_PASTS]; /* of the renderer */
    daft_kept kept;             /* of the renderer */
    daft_metering metering;     /* of the renderer */
    double clock;               /* the scene's, at the last picture */
    uint32_t pictures;
    daft_allocator allocator;
    const daft_scene *scene; /* of the last picture; NULL: there was none */
    daft_dvec3 origin;
    daft_vec3 right, up, forward;
    float fov;
    placed *items; /* in entity order */
    uint32_t count;
    size_t capacity;
};

daft_history *daft_history_create(daft_engine *engine, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_engine_ready(engine, error)) return NULL;
    daft_history *h = daft_alloc_zero(&engine->allocator, 1, sizeof *h);
    if (!h) {
        daft_fail_memory(error, "a history");
        return NULL;
    }
    h->allocator = engine->allocator;
    return h;
}

void daft_history_destroy(daft_history *history)
{
    if (!history) return;
    daft_allocator allocator = history->allocator;
    for (int i = 0; i < DAFT_PASTS; i++) daft_past_free(&history->past[i], &allocator);
    daft_kept_free(&history->kept, &allocator);
    daft_release(&allocator, history->items);
    daft_release(&allocator, history);
}

void daft_history_forget(daft_history *history)
{
    if (!history) return;
    history->scene = NULL;
    history->kept.some = history->metering.some = false;
    for (int i = 0; i < DAFT_PASTS; i++) history->past[i].some = false;
}

/* Where the picture before had it, or where it is if that picture did not have it. */
static const placed *find(const daft_history *h, const daft_instance *instance, uint32_t *at)
{
    const uint32_t index = daft_handle_index(instance->entity);
    while (*at < h->count && daft_handle_index(h->items[*at].entity) < index) ++*at;
    return *at < h->count && h->items[*at].entity == instance->entity ? &h->items[*at] : NULL;
}

static bool same_place(const daft_affine *a, const daft_affine *b)
{
    bool same = true;
    for (int i = 0; i < 9; i++) same = same && a->m[i] == b->m[i];
    for (int i = 0; i < 3; i++) same = same && a->t[i] == b->t[i];
    return same;
}

/* The two frames' origins apart, as the picture before had its own. */
static daft_daffine as_it_stands(daft_dvec3 apart)
{
    return (daft_daffine){.m = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .t = {apart.x, apart.y, apart.z}};
}

static daft_daffine wide(const daft_affine *a)
{
    daft_daffine out;
    for (int i = 0; i < 9; i++) out.m[i] = (double)a->m[i];
    for (int i = 0; i < 3; i++) out.t[i] = (double)a->t[i];
    return out;
}

/* From this frame to that view; what has not moved keeps its bits. */
static daft_affine view_of(const daft_history *h, const daft_daffine *frame)
{
    const daft_daffine view = {.m = {(double)h->right.x, (double)h->right.y, (double)h->right.z, (double)h->up.x,
                                     (double)h->up.y, (double)h->up.z, (double)h->forward.x, (double)h->forward.y,
                                     (double)h->forward.z}};
    const daft_daffine both = daft_daffine_compose(&view, frame);
    daft_affine out;
    for (int i = 0; i < 9; i++) out.m[i] = (float)both.m[i];
    for (int i = 0; i < 3; i++) out.t[i] = (float)both.t[i];
    return out;
}

static bool look_back(const daft_history *h, daft_dvec3 origin, daft_snapshot *s, daft_arena *arena, daft_error *error)
{
    daft_affine *before = daft_arena_alloc(arena, (size_t)s->instance_count + 1, sizeof *before);
    if (!before) return daft_fail_memory(error, "where things were");
    const daft_daffine still = as_it_stands(daft_dsub(origin, h->origin));
    const daft_affine unmoved = view_of(h, &still);
    uint32_t at = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const daft_instance *instance = &s->instances[i];
        const placed *then = find(h, instance, &at);
        const bool moved = then && !(still.t[0] == 0 && still.t[1] == 0 && still.t[2] == 0 &&
                                     same_place(&then->to_frame, &instance->to_frame));
        if (!moved) {
            before[i] = unmoved;
            continue;
        }
        const daft_daffine to_object = wide(&instance->to_object), to_frame = wide(&then->to_frame),
                           both = daft_daffine_compose(&to_frame, &to_object);
        before[i] = view_of(h, &both);
    }
    const daft_daffine sky = as_it_stands((daft_dvec3){0, 0, 0});
    before[s->instance_count] = view_of(h, &sky);
    s->before = before;
    s->before_focal = (float)(s->width / 2.0 / daft_tan((double)h->fov / 2));
    return true;
}

/* The scene's clock, between the last two ticks. */
static double clock_of(const daft_scene *scene, const daft_view *view)
{
    return scene->stepped - (1 - (double)view->alpha) * scene->step;
}

/* By that clock, so that a recording shows the same again; where it stands still, a picture counts as 1/60 s. */
static float elapsed(const daft_history *h, const daft_scene *scene, const daft_view *view)
{
    const double by_clock = clock_of(scene, view) - h->clock;
    return by_clock > 0 ? (float)fmin(by_clock, 1) : 1.0f / 60;
}

static bool remember(daft_history *h, const daft_scene *scene, const daft_view *view, const daft_snapshot *s,
                     daft_error *error)
{
    h->scene = NULL;
    if (!daft_grow(&h->allocator, &h->items, &h->capacity, s->instance_count, 0, sizeof *h->items))
        return daft_fail_memory(error, "where things are");
    for (uint32_t i = 0; i < s->instance_count; i++)
        h->items[i] = (placed){s->instances[i].entity, s->instances[i].to_frame};
    h->count = s->instance_count;
    h->origin = view->camera.position, h->fov = view->camera.fov;
    h->right = s->right, h->up = s->up, h->forward = s->forward;
    h->scene = scene, h->clock = clock_of(scene, view), h->pictures++;
    return true;
}

bool daft_history_take(daft_history *history, const daft_scene *scene, const daft_view *view, daft_scene_frame *frame,
                       daft_error *error)
{
    daft_snapshot *s = &frame->snapshot;
    s->before = NULL, s->past = NULL, s->kept = NULL, s->seed = 0;
    s->metering = NULL, s->elapsed = 0;
    s->eye = view->camera.position, s->looks = scene->looks;
    if (!history) return true;
    for (int i = 0; i < DAFT_PASTS; i++) history->past[i].some &= history->scene == scene;
    history->metering.some &= history->scene == scene;
    s->metering = &history->metering, s->elapsed = elapsed(history, scene, view);
    s->past = history->past, s->kept = view->full ? NULL : &history->kept, s->seed = history->pictures;
    if (history->scene == scene && !look_back(history, view->camera.position, s, &frame->lights, error)) return false;
    return s->row_count < s->height || remember(history, scene, view, s, error);
}
