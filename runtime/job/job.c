/* Snapshots and films beside the window. */
#include "job/job.h"

#include "common/showcase.h"
#include "video/video.h"
#include "job/shot.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { RATE = 60000, CRF = 18 }; /* as daft video has them by itself */

struct job {
    job_def def;
    daft_checkpoint *points;
    pthread_t thread;
    atomic_uint done; /* millionths */
    atomic_bool cancelled, ended;
    uint64_t began_ns;
    bool good;
    daft_error error;
    /* of a film */
    frame_source source;
    daft_scene *scene;
    double time;
};

static double film_seconds(const job *self) { return self->points[self->def.count - 1].time; }

/* `done` of the picture that is being drawn. */
static bool go_on(void *user, float done)
{
    job *self = user;
    double whole = (double)done;
    if (self->points) whole = (self->time + whole * 1000 / RATE) / film_seconds(self);
    atomic_store(&self->done, (unsigned)(1e6 * (whole < 1 ? whole : 1)));
    return !atomic_load(&self->cancelled);
}

/* ---- pictures ---- */

static bool take_picture(job *self, daft_engine *engine, daft_error *error)
{
    const job_def *def = &self->def;
    shot how = {.width = def->width, .height = def->height, .view = def->view};
    char beside[PATH_SIZE + 8];
    daft_image *picture = daft_image_create(engine, def->width, def->height, error);
    snprintf(how.scene, sizeof how.scene, "%s", def->scene);
    snprintf(beside, sizeof beside, "%.*s.json", (int)(strlen(def->out) - strlen(".png")), def->out);
    bool good = picture && daft_render(self->scene, &def->view, picture, error) && shot_write(&how, beside, error);
    good = good && daft_image_write(picture, def->out, error);
    daft_image_destroy(picture);
    return good;
}

/* ---- films ---- */

static frame_result draw_frame(frame_source *source, double time, bool wanted, daft_image *target, daft_error *error)
{
    job *self = (job *)((char *)source - offsetof(job, source));
    daft_view view = self->def.view;
    self->time = time;
    if (!wanted) return FRAME_DRAWN;
    bool good = daft_path_camera(self->points, self->def.count, self->def.pace, time, &view.camera, error) &&
                daft_render(self->scene, &view, target, error);
    return good ? FRAME_DRAWN : FRAME_FAILED;
}

static bool describe_film(const job_def *def, video_def *out, daft_error *error)
{
    *out =
        (video_def){.out = def->out, .width = def->width, .height = def->height, .rate = RATE, .crf = CRF, .blur = 1};
    return video_choose_format(def->out, &out->format, error) && video_check(out, error);
}

bool job_can_film(const job_def *def, daft_error *error)
{
    video_def film;
    return describe_film(def, &film, error);
}

/* Parts of a film of another scene, path or look are not taken over. */
static uint64_t hash_film(const job *self)
{
    char view[512];
    size_t size;
    daft_error ignored;
    uint64_t hash = daft_hash(self->points, self->def.count * sizeof *self->points, (uint64_t)self->def.pace);
    char *text = daft_read_file(NULL, self->def.scene, &size, &ignored);
    if (text) hash = daft_hash(text, size, hash);
    free(text);
    size = daft_struct_pack(DAFT_STRUCT_VIEW, &self->def.view, view, sizeof view);
    return daft_hash(view, size < sizeof view ? size : sizeof view, hash);
}

static bool film(job *self, daft_engine *engine, daft_error *error)
{
    video_def to;
    if (!describe_film(&self->def, &to, error)) return false;
    to.engine = engine;
    to.to = film_seconds(self);
    to.content = hash_film(self);
    self->source = (frame_source){.draw = draw_frame, .any_order = true};
    return video_make(&to, &self->source, error);
}

/* ---- the thread ---- */

static bool load(job *self, daft_engine *engine, daft_error *error)
{
    double aspect = (double)self->def.height / self->def.width;
    self->scene = daft_scene_create(engine, error);
    if (!self->scene) return false;
    if (showcase_is_mesh(self->def.scene)) return showcase_mesh(self->scene, self->def.scene, aspect, error);
    return daft_scene_load(self->scene, self->def.scene, error);
}

static bool make(job *self, daft_error *error)
{
    daft_engine_def wanted = daft_default_engine_def();
    wanted.threads = self->def.threads;
    wanted.isa = self->def.isa;
    wanted.memory_limit = self->def.memory_limit;
    self->def.view.progress = go_on;
    self->def.view.progress_user = self;
    daft_engine *engine = daft_engine_create(&wanted, error);
    bool good = engine && load(self, engine, error) &&
                (self->points ? film(self, engine, error) : take_picture(self, engine, error));
    daft_scene_destroy(self->scene);
    daft_engine_destroy(engine);
    return good;
}

static void *run(void *user)
{
    job *self = user;
#ifdef __linux__
    setpriority(PRIO_PROCESS, 0, 10); /* of this thread, and of those that it makes; elsewhere of the whole process */
#endif
    self->good = make(self, &self->error);
    atomic_store(&self->ended, true);
    return NULL;
}

job *job_start(const job_def *def, daft_error *error)
{
    job *self = calloc(1, sizeof *self);
    daft_checkpoint *points = def->count > 0 ? calloc(def->count, sizeof *points) : NULL;
    bool good = self && (points || def->count == 0);
    if (good) {
        *self = (job){.def = *def, .points = points, .began_ns = clock_now_ns()};
        if (points) memcpy(points, def->points, def->count * sizeof *points);
        self->def.points = points;
        good = pthread_create(&self->thread, NULL, run, self) == 0;
    }
    if (good) return self;
    free(points);
    free(self);
    fail(error, DAFT_ERROR_MEMORY, "no memory, or no thread, for a snapshot or a film");
    return NULL;
}

const job_def *job_what(const job *self) { return &self->def; }

double job_done(const job *self) { return atomic_load((atomic_uint *)(uintptr_t)&self->done) / 1e6; }

double job_seconds(const job *self) { return (double)(clock_now_ns() - self->began_ns) / 1e9; }

bool job_has_ended(const job *self) { return atomic_load((atomic_bool *)(uintptr_t)&self->ended); }

void job_cancel(job *self) { atomic_store(&self->cancelled, true); }

bool job_close(job *self, daft_error *error)
{
    pthread_join(self->thread, NULL);
    bool good = self->good;
    if (!good) *error = self->error;
    free(self->points);
    free(self);
    return good;
}
