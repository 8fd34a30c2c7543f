/* From the state of the window to what it shows. */
#include "hud/screens.h"
#include "view/viewer.h"

#include <math.h>
#include <string.h>

static bool fit(viewer *v, daft_image **image, daft_error *error)
{
    int width, height;
    v->def->screen->get_size(v->def->screen, &width, &height);
    if (*image && daft_image_width(*image) == width && daft_image_height(*image) == height) return true;
    daft_image *fresh = daft_image_create(v->def->engine, width, height, error);
    if (!fresh) return false;
    daft_image_destroy(*image);
    *image = fresh;
    v->changed = true;
    return true;
}

/* ---- the picture ---- */

static bool is_fine(const viewer *v)
{
    return v->content.scene && !v->look.wires && (v->look.channel == VIEW_PICTURE || v->look.channel == VIEW_ALBEDO);
}

static bool draw(viewer *v, daft_error *error)
{
    uint64_t began = clock_now_ns();
    v->changed = false;
    v->repaint = true;
    refine_restart(&v->refinement);
    if (v->content.image) {
        draw_picture(v->content.image, &v->place, v->picture);
        return true;
    }
    v->look.camera = v->flight.camera;
    if (!draw_scene(v->content.scene, &v->look, &v->channels, v->picture, error)) return false;
    v->counters = *daft_scene_counters(v->content.scene);
    double ms = (double)(clock_now_ns() - began) / 1e6;
    v->frame_ms = v->frame_ms > 0 ? v->frame_ms * 0.9 + ms * 0.1 : ms;
    v->moved_ns = v->now_ns;
    return true;
}

/* Rows of the reference, once nothing has moved for a moment. */
static bool refine(viewer *v, daft_error *error)
{
    const uint64_t patience = 150000000;
    if (v->job || !is_fine(v) || v->now_ns - v->moved_ns < patience) return true;
    const refine_job rows = {v->def->engine, v->content.scene, &v->look, v->picture, viewer_is_asked, v};
    if (refine_step(&v->refinement, &rows, error)) v->repaint = true;
    return error->code == DAFT_OK;
}

/* ---- texts ---- */

static void describe(const viewer *v, char out[VIEW_TEXT])
{
    char name[PATH_SIZE];
    path_base_name(v->content.path, name, sizeof name);
    if (v->content.image)
        snprintf(out, VIEW_TEXT, "%.200s   %d x %d   %.0f %%", name, daft_image_width(v->content.image),
                 daft_image_height(v->content.image), v->place.zoom * 100);
    else
        snprintf(out, VIEW_TEXT, "%.200s   %.4g m across   %.3g m/s", name, v->content.size, v->flight.speed);
}

static void describe_switches(const viewer *v, char out[VIEW_TEXT])
{
    size_t count, used = 0;
    const view_key *keys = view_keys(&count);
    out[0] = 0;
    if (v->flight.orbits) used += (size_t)snprintf(out + used, VIEW_TEXT - used, "turns around a point (O)   ");
    for (size_t i = 0; i < count && used < VIEW_TEXT; i++) {
        bool off = keys[i].act == VIEW_TOGGLE && v->look.without & keys[i].value;
        bool channel = keys[i].act == VIEW_CHANNEL && keys[i].value && keys[i].value == v->look.channel;
        if (off)
            used += (size_t)snprintf(out + used, VIEW_TEXT - used, "without %s (%s)   ", keys[i].does, keys[i].shown);
        if (channel) used += (size_t)snprintf(out + used, VIEW_TEXT - used, "%s (%s)   ", keys[i].does, keys[i].shown);
    }
    if (used >= 3 && used < VIEW_TEXT) out[used - 3] = 0;
}

static void describe_quality(const viewer *v, char out[VIEW_TEXT])
{
    int height = daft_image_height(v->picture), row = v->refinement.row;
    double wrong = refine_error(&v->refinement, height);
    out[0] = 0;
    if (!is_fine(v)) return;
    if (refine_is_done(&v->refinement))
        snprintf(out, VIEW_TEXT, "reference");
    else if (wrong >= 0)
        snprintf(out, VIEW_TEXT, "%d %% of %s   error left %.2f %%", 100 * row / height,
                 daft_preset_name(refine_quality(&v->refinement)), 100 * wrong);
    else if (v->refinement.pass > 0)
        snprintf(out, VIEW_TEXT, "high");
    else
        snprintf(out, VIEW_TEXT, "%s   %.1f ms",
                 v->look.quality.preset == QUALITY_OF_SCENE ? "game" : daft_preset_name(v->look.quality.preset),
                 v->frame_ms);
}

bool viewer_project(const viewer *v, daft_dvec3 point, float *x, float *y)
{
    const daft_camera *c = &v->flight.camera;
    double aspect = viewer_aspect(v);
    /* The rays through the middle and through the ends of the picture's axes give the camera's own axes. */
    daft_vec3 f = daft_camera_ray(c, 0.5, 0.5, aspect), r = daft_camera_ray(c, 1, 0.5, aspect),
              u = daft_camera_ray(c, 0.5, 0, aspect);
    daft_dvec3 d = {point.x - c->position.x, point.y - c->position.y, point.z - c->position.z};
    const daft_vec3 *axes[3] = {&f, &r, &u};
    double along[3], cosine[3];
    for (int i = 0; i < 3; i++) {
        const daft_vec3 *a = axes[i];
        along[i] = d.x * (double)a->x + d.y * (double)a->y + d.z * (double)a->z;
        cosine[i] = (double)f.x * (double)a->x + (double)f.y * (double)a->y + (double)f.z * (double)a->z;
    }
    if (!(along[0] > 0)) return false;
    /* With e the end of an axis at angle t: d·e = cos t · d·f + sin t · d·axis. */
    double across = (along[1] - cosine[1] * along[0]) / (1 - cosine[1] * cosine[1]) * cosine[1] / along[0];
    double above = (along[2] - cosine[2] * along[0]) / (1 - cosine[2] * cosine[2]) * cosine[2] / along[0];
    *x = (float)(0.5 + across / 2), *y = (float)(0.5 - above / 2);
    return fabs(across) <= 1 && fabs(above) <= 1;
}

/* Checkpoints as small cameras with their number and time. */
static void paint_route(const viewer *v, const canvas *over)
{
    char text[64];
    for (uint32_t i = 0; v->content.scene && i < v->route.count; i++) {
        float x, y;
        if (!viewer_project(v, v->route.points[i].camera.position, &x, &y)) continue;
        snprintf(text, sizeof text, "%u   %.1f s", i + 1, v->route.points[i].time);
        screen_camera(over, v->def->face, x, y, text);
    }
}

static void paint(viewer *v)
{
    char title[VIEW_TEXT], switches[VIEW_TEXT], corner[VIEW_TEXT], work[VIEW_TEXT] = "";
    canvas over = canvas_over(v->shown);
    describe(v, title);
    describe_switches(v, switches);
    describe_quality(v, corner);
    if (v->job) make_describe(v, work);
    screen_state state = {.title = title,
                          .switches = switches,
                          .corner = corner,
                          .found = v->found,
                          .notice = v->now_ns < v->notice_until ? v->notice : "",
                          .bad = v->notice_bad,
                          .keys = v->keys,
                          .work = work,
                          .done = v->job ? (float)job_done(v->job) : 0};
    if (!v->hit || !viewer_project(v, v->point, &state.cross_x, &state.cross_y)) state.cross_x = state.cross_y = -1;
    paint_route(v, &over);
    if (v->plan && v->content.scene) {
        overlay_figures figures = {.frames_per_second = v->frame_ms > 0 ? 1000 / v->frame_ms : 0,
                                   .frame_ms = v->frame_ms,
                                   .counters = &v->counters,
                                   .memory = daft_engine_memory(v->def->engine)};
        screen_overlay(&over, v->def->face, &figures);
    }
    screen_draw(&over, v->def->face, &state);
}

bool show(viewer *v, daft_error *error)
{
    platform *screen = v->def->screen;
    *error = (daft_error){0};
    v->rests = true;
    if (!screen->wants_frame(screen)) return true;
    if (!fit(v, &v->picture, error) || !fit(v, &v->shown, error)) return false;
    if (!(v->changed ? draw(v, error) : refine(v, error))) return false;
    v->rests = !v->repaint;
    if (v->rests) return true;
    v->repaint = false;
    memcpy(daft_image_pixels(v->shown), daft_image_pixels(v->picture),
           4 * (size_t)daft_image_width(v->picture) * (size_t)daft_image_height(v->picture));
    paint(v);
    return screen->present(screen, v->shown, error);
}
