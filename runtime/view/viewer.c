/* The window's loop: events, keys, moves, files. */
#include "view/viewer.h"

#include "common/showcase.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const uint64_t SECOND = 1000000000u;

void viewer_say(viewer *v, bool bad, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(v->notice, sizeof v->notice, format, list);
    va_end(list);
    v->notice_bad = bad;
    v->notice_until = v->now_ns + (bad ? 8 : 4) * SECOND;
    v->repaint = true;
}

double viewer_aspect(const viewer *v)
{
    int width, height;
    v->def->screen->get_size(v->def->screen, &width, &height);
    return (double)height / (double)width;
}

/* ---- files ---- */

static void say_error(viewer *v, const daft_error *error)
{
    char text[1200];
    viewer_say(v, true, "%.600s", daft_error_text(error, text, sizeof text));
}

/* The scene's own path, unless there are checkpoints that no file has. */
static void take_route(viewer *v)
{
    daft_error error;
    if (v->route.unsaved || !v->content.scene) return;
    if (!route_load(&v->route, v->content.scene, &error)) say_error(v, &error);
}

/* What no file holds goes to standard output, so that nothing is lost. */
static void leave_route(viewer *v)
{
    if (!v->route.unsaved) return;
    if (v->route.count > 0) fprintf(stderr, "daft: the camera path was not saved into %s:\n", v->content.path);
    route_print(&v->route, stdout);
    v->route.unsaved = false;
    v->route.count = 0;
}

static void take_content(viewer *v, content *fresh)
{
    content_close(&v->content);
    v->content = *fresh;
    v->seen_stamp = fresh->stamp;
    take_route(v);
    v->found[0] = 0;
    v->hit = false;
    v->changed = true;
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The median distance of what is seen at first, since a plain around a village says little; else the scene's size. */
static double usual_distance(const viewer *v)
{
    enum { SIDE = 9 };
    float distances[SIDE * SIDE];
    size_t count = 0;
    for (int i = 0; v->content.scene && i < SIDE * SIDE; i++) {
        double x = (i % SIDE + 0.5) / SIDE, y = (i / SIDE + 0.5) / SIDE;
        daft_vec3 ray = daft_camera_ray(&v->content.start, x, y, viewer_aspect(v));
        daft_ray_hit hit;
        daft_error error;
        if (daft_scene_cast_ray(v->content.scene, v->content.start.position, ray, INFINITY, (daft_entity){0}, &hit,
                                &error))
            distances[count++] = hit.distance;
    }
    qsort(distances, count, sizeof distances[0], by_value);
    return count > 0 && distances[count / 2] > 0 ? (double)distances[count / 2] : v->content.size;
}

static void begin(viewer *v)
{
    int width, height;
    char title[PATH_SIZE + 16], name[PATH_SIZE];
    platform *screen = v->def->screen;
    screen->get_size(screen, &width, &height);
    v->flight = (flight){.camera = v->content.start};
    v->flight.speed = fly_speed(usual_distance(v));
    if (v->content.image) v->place = draw_fit(v->content.image, width, height);
    path_base_name(v->content.path, name, sizeof name);
    snprintf(title, sizeof title, "DAFT: %s", name);
    screen->set_title(screen, title);
}

/* Opens a file in place of what is shown; on failure that stays, and the message is on the screen. */
static void open_file(viewer *v, const char *path)
{
    daft_error error;
    content fresh;
    if (!content_open(&fresh, v->def->engine, path, -1, viewer_aspect(v), &error)) {
        say_error(v, &error);
        return;
    }
    leave_route(v);
    take_content(v, &fresh);
    begin(v);
    viewer_say(v, false, "H shows the keys");
}

/* The same file again, with the camera where it is. */
static void reload(viewer *v)
{
    daft_error error;
    content fresh;
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s", v->content.path);
    v->content.stamp = content_stamp(&v->content); /* a file that cannot be loaded is tried again once it has changed */
    if (!content_open(&fresh, v->def->engine, path, v->def->camera, viewer_aspect(v), &error)) {
        say_error(v, &error);
        return;
    }
    take_content(v, &fresh);
    viewer_say(v, false, "loaded again");
}

/* Loads the file again once it has changed and then stood still for a moment: it may be in the middle of being saved.
 */
static void watch_file(viewer *v)
{
    if (v->now_ns - v->checked_ns < SECOND / 4) return;
    v->checked_ns = v->now_ns;
    uint64_t stamp = content_stamp(&v->content);
    bool stands = stamp == v->seen_stamp;
    v->seen_stamp = stamp;
    if (stands && stamp != v->content.stamp) reload(v);
}

/* ---- keys ---- */

static void frame_all(viewer *v)
{
    int width, height;
    v->def->screen->get_size(v->def->screen, &width, &height);
    if (v->content.image) v->place = draw_fit(v->content.image, width, height);
    if (v->content.scene && v->content.size > 0)
        v->flight.camera = showcase_camera(v->content.low, v->content.high, viewer_aspect(v));
    v->flight.orbits = false;
    v->changed = true;
}

static void toggle_orbit(viewer *v)
{
    daft_ray_hit hit;
    v->repaint = true;
    if (!v->flight.orbits && !pick_point(v, &hit)) {
        viewer_say(v, false, "nothing lies under the cursor to turn around");
        return;
    }
    v->flight.orbits = !v->flight.orbits;
    if (v->flight.orbits) pick(v), v->flight.pivot = hit.position;
}

/* The checkpoint nearest to the cursor in the picture, else the last. */
static uint32_t nearest_checkpoint(const viewer *v)
{
    uint32_t best = v->route.count ? v->route.count - 1 : 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < v->route.count; i++) {
        float x, y;
        if (!viewer_project(v, v->route.points[i].camera.position, &x, &y)) continue;
        double far = hypot((double)x - v->mouse_x, (double)y - v->mouse_y);
        if (far < least) best = i, least = far;
    }
    return best;
}

static void save_route(viewer *v)
{
    daft_error error;
    char name[PATH_SIZE];
    if (!route_save(&v->route, v->content.scene, v->content.path, &error)) {
        say_error(v, &error);
        return;
    }
    reload(v);
    path_base_name(v->content.path, name, sizeof name);
    viewer_say(v, false, "the path is saved: daft video %.300s -o FILE.mp4 films it", name);
}

static void change_route(viewer *v, view_act act)
{
    daft_error error;
    uint32_t index = nearest_checkpoint(v);
    if (!v->content.scene) return;
    if (act == VIEW_CHECKPOINT && !route_add(&v->route, &v->flight.camera, v->flight.speed, &error)) {
        say_error(v, &error);
        return;
    }
    if (act == VIEW_SAVE) {
        save_route(v);
        return;
    }
    if (v->route.count == 0) {
        viewer_say(v, false, "there is no checkpoint yet: V adds one");
        return;
    }
    if (act == VIEW_CHECKPOINT) index = v->route.count - 1;
    if (act == VIEW_MOVE) v->route.points[index].camera = v->flight.camera, v->route.unsaved = true;
    if (act == VIEW_SOONER || act == VIEW_LATER) route_delay(&v->route, index, act == VIEW_LATER ? 0.5 : -0.5);
    if (act == VIEW_REMOVE) {
        route_remove(&v->route, index);
        viewer_say(v, false, "checkpoint %u is removed, %u left", index + 1, v->route.count);
        return;
    }
    viewer_say(v, false, "checkpoint %u of %u at %.1f s (C saves the path)", index + 1, v->route.count,
               v->route.points[index].time);
}

static void take_key(viewer *v, const char *name)
{
    const view_key *key = view_key_find(name);
    if (!key) return;
    v->repaint = true;
    switch (key->act) {
    case VIEW_NOTHING: break;
    case VIEW_TOGGLE: v->look.without ^= key->value, v->changed = true; break;
    case VIEW_CHANNEL: v->look.channel = (view_channel)key->value, v->changed = true; break;
    case VIEW_WIRES: v->look.wires = !v->look.wires, v->changed = true; break;
    case VIEW_ORBIT: toggle_orbit(v); break;
    case VIEW_FRAME_ALL: frame_all(v); break;
    case VIEW_CHECKPOINT:
    case VIEW_MOVE:
    case VIEW_REMOVE:
    case VIEW_SOONER:
    case VIEW_LATER:
    case VIEW_SAVE: change_route(v, key->act); break;
    case VIEW_START: begin(v), v->changed = true; break;
    case VIEW_RELOAD: reload(v); break;
    case VIEW_PLAN: v->plan = !v->plan; break;
    case VIEW_KEYS: v->keys = !v->keys; break;
    case VIEW_SNAPSHOT: make_start(v, false); break;
    case VIEW_FILM: make_start(v, true); break;
    case VIEW_SIZE: make_change_size(v); break;
    case VIEW_PACE: make_change_pace(v); break;
    case VIEW_LEAVE:
        if (v->job)
            job_cancel(v->job);
        else
            v->leaves = true;
        break;
    }
}

/* ---- the mouse ---- */

static bool held(const viewer *v, const char *name) { return v->input.down[input_key_find(name)]; }

static void press(viewer *v, bool right)
{
    daft_ray_hit hit;
    v->press_x = v->mouse_x, v->press_y = v->mouse_y;
    v->drags = false;
    if (right && !v->flight.orbits && pick_point(v, &hit)) v->flight.pivot = hit.position;
}

static void drag(viewer *v, double dx, double dy)
{
    const double start = 0.005, turn = (double)v->flight.camera.fov;
    if (fabs(v->mouse_x - v->press_x) + fabs(v->mouse_y - v->press_y) > start) v->drags = true;
    if (!v->drags) return;
    if (v->content.image) {
        int width, height;
        v->def->screen->get_size(v->def->screen, &width, &height);
        v->place.x -= dx * width / v->place.zoom / daft_image_width(v->content.image);
        v->place.y -= dy * height / v->place.zoom / daft_image_height(v->content.image);
        v->changed = true;
        return;
    }
    /* What lies under the cursor stays under it while looking around; turning goes twice as far. */
    if (held(v, "mouse3") || v->flight.orbits)
        fly_orbit(&v->flight, -2.5 * dx, 2.5 * dy * viewer_aspect(v));
    else
        fly_move(&v->flight, &(flight_wish){.yaw = -turn * dx, .pitch = -turn * dy * viewer_aspect(v)}, 0);
    v->changed = true;
}

static void wheel(viewer *v, double notches)
{
    if (v->content.image) {
        double zoom = fmax(0.01, fmin(64, v->place.zoom * pow(1.25, notches)));
        v->place.zoom = zoom;
        v->changed = true;
    }
    if (v->content.scene) fly_change_speed(&v->flight, notches, v->content.size);
    v->repaint = true;
}

static void take_input(viewer *v, const input_event *event)
{
    input_event by_letter = *event; /* the keys of the viewer, those to fly with too, are letters that stand for words
                                     */
    if (event->kind == INPUT_KEY) by_letter.key = input_letter(event);
    event = &by_letter;
    const char *name = event->kind == INPUT_KEY ? input_key_name(event->key) : "";
    bool left = strcmp(name, "mouse1") == 0, right = strcmp(name, "mouse3") == 0;
    input_push(&v->input, event);
    if (event->kind == INPUT_MOVE) {
        double dx = (double)event->x - v->mouse_x, dy = (double)event->y - v->mouse_y;
        v->mouse_x = (double)event->x, v->mouse_y = (double)event->y;
        if (held(v, "mouse1") || held(v, "mouse3")) drag(v, dx, dy);
    } else if (event->kind == INPUT_WHEEL) {
        wheel(v, (double)event->y);
    } else if (left || right) {
        if (event->down) press(v, right);
        if (!event->down && left && !v->drags) pick(v);
    } else if (event->kind == INPUT_KEY && event->down) {
        take_key(v, name);
    }
    input_apply_queue(&v->input);
}

bool viewer_is_asked(void *viewer_)
{
    viewer *v = viewer_;
    platform *screen = v->def->screen;
    while (v->early_count < COUNT_OF(v->early) && screen->poll(screen, &v->early[v->early_count])) v->early_count++;
    return v->early_count > 0;
}

static void take_events(viewer *v)
{
    platform *screen = v->def->screen;
    size_t taken = 0;
    for (platform_event event; taken < v->early_count || screen->poll(screen, &event);) {
        if (taken < v->early_count) event = v->early[taken++];
        switch (event.kind) {
        case PLATFORM_CLOSE: v->leaves = true; break;
        case PLATFORM_FOCUS_LOST:
            input_push_release_all(&v->input);
            input_apply_queue(&v->input);
            break;
        case PLATFORM_CONSOLE: break;
        case PLATFORM_DROP: open_file(v, event.path); break;
        case PLATFORM_INPUT: take_input(v, &event.input); break;
        }
    }
    v->early_count = 0;
}

/* ---- moving ---- */

static double key_axis(const viewer *v, const char *plus, const char *minus)
{
    return (held(v, plus) ? 1 : 0) - (held(v, minus) ? 1 : 0);
}

static double stick(const viewer *v, const char *name) { return (double)v->input.stick[input_stick_find(name)]; }

static void move(viewer *v, double seconds)
{
    const double turn = 1.2; /* radians a second */
    if (!v->content.scene) return;
    flight_wish wish = {.forward = key_axis(v, "w", "s") - stick(v, "left y"),
                        .right = key_axis(v, "d", "a") + stick(v, "left x"),
                        .up = key_axis(v, "e", "q") + stick(v, "right trigger") - stick(v, "left trigger"),
                        .yaw = turn * seconds * (key_axis(v, "right", "left") + 2 * stick(v, "right x")),
                        .pitch = turn * seconds * (key_axis(v, "down", "up") + 2 * stick(v, "right y")),
                        .factor = 1};
    if (held(v, "left shift") || held(v, "right shift")) wish.factor *= 4;
    if (held(v, "left ctrl") || held(v, "right ctrl")) wish.factor /= 4;
    if (fly_move(&v->flight, &wish, seconds)) v->changed = true;
}

/* Clips go on. A scene that plays any has posed, or left out, some in its first picture. */
static void play(viewer *v, double seconds)
{
    daft_scene *scene = v->content.scene;
    const daft_counters *c = scene ? daft_scene_counters(scene) : NULL;
    if (!c || c->poses + c->poses_unseen == 0 || !(seconds > 0)) return;
    daft_scene_begin_tick(scene);
    if (daft_scene_step(scene, (float)seconds, NULL)) v->changed = true;
}

static void rest(void)
{
    const struct timespec frame = {.tv_nsec = 10000000};
    nanosleep(&frame, NULL);
}

static bool run(viewer *v, daft_error *error)
{
    platform *screen = v->def->screen;
    const double longest = 0.1; /* seconds: after a pause the camera does not jump */
    v->now_ns = screen->now_ns(screen);
    while (!v->leaves) {
        uint64_t now = screen->now_ns(screen);
        double seconds = (double)(now - v->now_ns) / 1e9;
        bool spoke = v->now_ns < v->notice_until;
        v->now_ns = now;
        if (spoke && now >= v->notice_until) v->repaint = true;
        take_events(v);
        watch_file(v);
        make_watch(v);
        move(v, fmin(seconds, longest));
        play(v, fmin(seconds, longest));
        if (!show(v, error)) return false;
        if (v->rests) rest(); /* a window's own pace comes with the pictures that it is given */
        screen->end_frame(screen);
    }
    return true;
}

bool view_run(const view_def *def, daft_error *error)
{
    viewer v = {.def = def, .look = {.quality = def->quality}, .mouse_x = 0.5, .mouse_y = 0.5};
    bool good = content_open(&v.content, def->engine, def->path, def->camera, viewer_aspect(&v), error);
    v.channels.history = good ? daft_history_create(def->engine, error) : NULL;
    good = v.channels.history != NULL;
    if (good) {
        v.now_ns = def->screen->now_ns(def->screen);
        v.seen_stamp = v.content.stamp;
        v.changed = true;
        take_route(&v);
        begin(&v);
        viewer_say(&v, false, "H shows the keys");
        good = run(&v, error);
    }
    make_leave(&v);
    leave_route(&v);
    route_free(&v.route);
    content_close(&v.content);
    daft_image_destroy(v.picture);
    daft_image_destroy(v.shown);
    draw_free(&v.channels);
    daft_history_destroy(v.channels.history);
    refine_free(&v.refinement);
    return good;
}
