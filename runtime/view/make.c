/* Snapshots and films from the window: their names, sizes and progress. */
#include "view/viewer.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

typedef struct size_choice {
    int width, height, times; /* times: of the window, where width is 0 */
} size_choice;

static const size_choice SIZES[] = {{0, 0, 1}, {0, 0, 2}, {0, 0, 4}, {1920, 1080, 0}, {3840, 2160, 0}};
static const char *const PACES[] = {"at the checkpoints' times", "at a constant speed", "slow at both ends"};

/* The size that --snapshot names stands before all others. */
static void choose(const viewer *v, int *width, int *height)
{
    const int most = 16384;
    const bool given = v->def->snapshot_width > 0;
    if (given && v->make_size == 0) {
        *width = v->def->snapshot_width, *height = v->def->snapshot_height;
        return;
    }
    const size_choice *size = &SIZES[v->make_size - (given ? 1 : 0)];
    v->def->screen->get_size(v->def->screen, width, height);
    *width = size->width ? size->width : (int)fmin(*width * size->times, most);
    *height = size->height ? size->height : (int)fmin(*height * size->times, most);
}

void make_change_size(viewer *v)
{
    int width, height;
    v->make_size = (v->make_size + 1) % ((int)COUNT_OF(SIZES) + (v->def->snapshot_width > 0));
    choose(v, &width, &height);
    viewer_say(v, false, "snapshots and films: %d x %d", width, height);
}

void make_change_pace(viewer *v)
{
    v->pace = (daft_pace)((v->pace + 1) % COUNT_OF(PACES));
    viewer_say(v, false, "films go %s", PACES[v->pace]);
}

/* The first name in the current folder, NAME-001 and so on, that nothing has yet. */
static bool find_name(const viewer *v, const char *end, char out[PATH_SIZE])
{
    char base[PATH_SIZE], other[PATH_SIZE + 16];
    path_base_name(v->content.path, base, sizeof base);
    char *dot = strrchr(base, '.');
    if (dot) *dot = 0;
    for (int i = 1; i < 1000; i++) {
        snprintf(other, sizeof other, "%.900s-%03d.json", base, i);
        snprintf(out, PATH_SIZE, "%.900s-%03d%s", base, i, end);
        if (access(out, F_OK) != 0 && access(other, F_OK) != 0) return true;
    }
    return false;
}

/* The first kind of film that this program can make. */
static bool choose_film(const viewer *v, job_def *def, daft_error *error)
{
    static const char *const ENDS[] = {".mp4", ".webm", ".gif"};
    def->width &= ~1, def->height &= ~1; /* as encoders want it */
    for (size_t i = 0; i < COUNT_OF(ENDS); i++) {
        if (!find_name(v, ENDS[i], def->out)) return fail(error, DAFT_ERROR_IO, "there are 999 films of it already");
        if (job_can_film(def, error)) return true;
    }
    return false;
}

static bool describe(const viewer *v, bool film, job_def *out, daft_error *error)
{
    *out = (job_def){.view = daft_default_view(),
                     .pace = v->pace,
                     .threads = daft_engine_threads(v->def->engine),
                     .isa = daft_engine_isa(v->def->engine),
                     .memory_limit = daft_engine_memory(v->def->engine).limit};
    view_look look = v->look;
    look.camera = v->flight.camera;
    look.quality = (quality_wish){.preset = film ? DAFT_PRESET_HIGH : DAFT_PRESET_REFERENCE};
    draw_set_view(&look, NULL, &out->view);
    snprintf(out->scene, sizeof out->scene, "%s", v->content.path);
    choose(v, &out->width, &out->height);
    if (film) out->points = v->route.points, out->count = v->route.count;
    if (film) return choose_film(v, out, error);
    return find_name(v, ".png", out->out) || fail(error, DAFT_ERROR_IO, "there are 999 snapshots of it already");
}

void make_start(viewer *v, bool film)
{
    job_def def;
    daft_error error;
    if (v->job) {
        viewer_say(v, true, "one thing at a time: %s is being made (Esc cancels)", job_what(v->job)->out);
        return;
    }
    if (!v->content.scene) {
        viewer_say(v, true, "this is a picture already");
        return;
    }
    if (film && v->route.count < 2) {
        viewer_say(v, true, "a film needs two checkpoints or more: V adds one where you are");
        return;
    }
    if (describe(v, film, &def, &error)) v->job = job_start(&def, &error);
    if (!v->job) viewer_say(v, true, "%.600s", error.message);
}

static void tell_end(viewer *v)
{
    daft_error error;
    char text[1200];
    const job_def *def = job_what(v->job);
    const double seconds = job_seconds(v->job);
    const bool film = def->count > 0;
    char name[PATH_SIZE];
    snprintf(name, sizeof name, "%s", def->out);
    bool good = job_close(v->job, &error);
    v->job = NULL;
    if (good && film)
        viewer_say(v, false, "%s is there, after %.1f s", name, seconds);
    else if (good)
        viewer_say(v, false, "%s is there, after %.1f s; the .json beside it lets daft render repeat it", name,
                   seconds);
    else if (error.code == DAFT_ERROR_CANCELLED)
        viewer_say(v, false, film ? "cancelled; B goes on where it stopped" : "cancelled");
    else
        viewer_say(v, true, "%.600s", daft_error_text(&error, text, sizeof text));
}

void make_watch(viewer *v)
{
    const uint64_t often = 100000000;
    if (!v->job) return;
    if (job_has_ended(v->job)) {
        tell_end(v);
    } else if (v->now_ns - v->job_shown_ns > often) {
        v->job_shown_ns = v->now_ns;
        v->repaint = true;
    }
}

void make_describe(const viewer *v, char out[VIEW_TEXT])
{
    const job_def *def = job_what(v->job);
    const double done = job_done(v->job), seconds = job_seconds(v->job);
    size_t used = (size_t)snprintf(out, VIEW_TEXT, "%.200s   %d x %d   %d %%", def->out, def->width, def->height,
                                   (int)(100 * done));
    if (done > 0.01 && seconds > 0.5)
        used += (size_t)snprintf(out + used, VIEW_TEXT - used, "   %.0f s left", ceil(seconds * (1 - done) / done));
    snprintf(out + used, VIEW_TEXT - used, "   Esc cancels");
}

void make_leave(viewer *v)
{
    daft_error error;
    if (!v->job) return;
    fprintf(stderr, "daft: %s was not finished\n", job_what(v->job)->out);
    job_cancel(v->job);
    job_close(v->job, &error);
    v->job = NULL;
}
