/* One picture by several processes: process 0 hands out bands and gathers them. It draws some itself, and looks after
 * the others in the callback that tells how far its own band is. */
#include "many/bands.h"

#include "channels/channels.h"
#include "common/util.h"
#include "many/share.h"

#include <stdlib.h>
#include <string.h>

enum {
    BAND, /* 0 to all: draw this one */
    ROWS  /* to 0: a band's number and its rows */
};

enum { TILE = 32, BANDS_EACH = 8, ARRAYS = 1 + CHANNEL_COUNT };

typedef struct job {
    many *all;
    daft_scene *scene;
    daft_view view;
    daft_image *target;
    int width, height, rows; /* of a band */
    struct {
        uint8_t *bytes;
        size_t stride; /* bytes of a row */
    } arrays[ARRAYS];  /* the picture and its AOVs */
    uint64_t orders[SHARE_AHEAD];
    int order_count;
    bool stop, failed;
    daft_error error;
    share share; /* of process 0 */
    bool (*progress)(void *user, float done);
    void *progress_user;
} job;

static bool first(const job *j) { return many_rank(j->all) == 0; }

/* The first error counts. */
static void give_up(job *j, const daft_error *error)
{
    if (j->failed) return;
    j->failed = true;
    j->error = *error;
    if (first(j))
        j->stop = true;
    else
        many_tell_failure(j->all, error);
}

static int rows_of(const job *j, uint64_t band)
{
    int begin = (int)band * j->rows;
    return begin + j->rows < j->height ? j->rows : j->height - begin;
}

static size_t row_bytes(const job *j)
{
    size_t sum = 0;
    for (int i = 0; i < ARRAYS; i++) sum += j->arrays[i].bytes ? j->arrays[i].stride : 0;
    return sum;
}

/* ---- rows as a message ---- */

static void send_rows(job *j, uint64_t band)
{
    size_t rows = (size_t)rows_of(j, band), begin = (size_t)band * (size_t)j->rows;
    size_t size = sizeof band + rows * row_bytes(j);
    uint8_t *message = malloc(size), *to = message + sizeof band;
    daft_error error;
    if (!message) {
        fail(&error, DAFT_ERROR_MEMORY, "out of memory for a band of the picture");
        give_up(j, &error);
        return;
    }
    memcpy(message, &band, sizeof band);
    for (int i = 0; i < ARRAYS; i++) {
        if (!j->arrays[i].bytes) continue;
        memcpy(to, j->arrays[i].bytes + begin * j->arrays[i].stride, rows * j->arrays[i].stride);
        to += rows * j->arrays[i].stride;
    }
    many_send_own(j->all, 0, ROWS, message, size);
}

static void take_rows(job *j, const many_message *m)
{
    uint64_t band;
    memcpy(&band, m->bytes, sizeof band);
    size_t rows = (size_t)rows_of(j, band), begin = (size_t)band * (size_t)j->rows;
    const uint8_t *from = m->bytes + sizeof band;
    for (int i = 0; i < ARRAYS; i++) {
        if (!j->arrays[i].bytes) continue;
        memcpy(j->arrays[i].bytes + begin * j->arrays[i].stride, from, rows * j->arrays[i].stride);
        from += rows * j->arrays[i].stride;
    }
}

/* ---- messages ---- */

static void receive(job *j, const many_message *m)
{
    uint64_t number = 0;
    if (m->size >= sizeof number) memcpy(&number, m->bytes, sizeof number);
    if (m->kind == BAND) j->orders[j->order_count++] = number;
    if (m->kind == MANY_STOP) j->stop = true;
    if (m->kind == ROWS) {
        take_rows(j, m);
        share_made(&j->share, m->from);
        share_taken(&j->share, number);
    }
    if (m->kind == MANY_FAILED) {
        daft_error error;
        many_take_failure(m, &error);
        give_up(j, &error);
    }
}

static void hand_out(job *j)
{
    share_work work;
    while (!j->stop && share_give(&j->share, &work))
        many_send(j->all, work.process, BAND, &work.piece, sizeof work.piece);
}

/* False: nothing had come. */
static bool look_after_others(job *j)
{
    bool some = false;
    for (many_message m; !j->stop && many_receive(j->all, &m); some = true) {
        receive(j, &m);
        free(m.bytes);
    }
    if (!first(j)) return some;
    hand_out(j);
    if (share_finished(&j->share)) j->stop = true;
    return some;
}

static bool between_tiles(void *user, float done)
{
    (void)done;
    job *j = user;
    look_after_others(j);
    if (j->progress && !j->progress(j->progress_user, (float)j->share.done / (float)j->share.count)) {
        daft_error error;
        fail(&error, DAFT_ERROR_CANCELLED, "rendering was stopped");
        give_up(j, &error);
    }
    return !j->stop;
}

/* ---- drawing ---- */

static void draw(job *j, uint64_t band)
{
    daft_error error;
    daft_view view = j->view;
    view.first_row = (int)band * j->rows;
    view.row_count = rows_of(j, band);
    view.progress = between_tiles;
    view.progress_user = j;
    if (daft_render(j->scene, &view, j->target, &error))
        send_rows(j, band);
    else if (!j->stop)
        give_up(j, &error);
}

static void run(job *j)
{
    while (!j->stop) {
        bool busy = look_after_others(j);
        if (j->order_count > 0 && !j->failed) {
            uint64_t next = j->orders[0];
            memmove(j->orders, j->orders + 1, (size_t)--j->order_count * sizeof next);
            draw(j, next);
        } else if (!busy) {
            many_pause();
        }
    }
}

/* Enough bands for everybody to get some, each of whole tiles. */
static int choose_rows(int height, int processes)
{
    int rows = height / (BANDS_EACH * processes) / TILE * TILE;
    return rows < TILE ? TILE : rows;
}

static job prepare(many *all, daft_scene *scene, const daft_view *view, daft_image *target)
{
    int width = daft_image_width(target), height = daft_image_height(target);
    size_t w = (size_t)width;
    job j = {.all = all,
             .scene = scene,
             .view = *view,
             .target = target,
             .width = width,
             .height = height,
             .rows = choose_rows(height, many_count(all)),
             .arrays = {{daft_image_pixels(target), 4 * w}},
             .progress = many_rank(all) == 0 ? view->progress : NULL,
             .progress_user = view->progress_user};
    for (int i = 0; i < CHANNEL_COUNT; i++) {
        size_t bytes;
        j.arrays[1 + i].bytes = channels_array(&view->aov, (channel_kind)i, &bytes);
        j.arrays[1 + i].stride = w * bytes;
    }
    return j;
}

bool bands_render(many *all, daft_scene *scene, const daft_view *view, daft_image *target, daft_error *error)
{
    job j = prepare(all, scene, view, target);
    share_def def = {.count = (uint64_t)((j.height + j.rows - 1) / j.rows), .group = 1, .processes = many_count(all)};
    if (first(&j) && !share_open(&j.share, &def)) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a picture");
    run(&j);
    if (first(&j)) many_stop_others(all);
    if (j.failed) *error = j.error;
    share_close(&j.share);
    return !j.failed || many_rank(all) > 0;
}
