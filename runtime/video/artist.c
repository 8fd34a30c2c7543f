/* Draws ordered frames on a thread. */
#include "video/artist.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

struct artist {
    film *film;
    pthread_t thread;
    uint64_t cursor;      /* the first frame that has not happened; the thread's own */
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    drawing *orders, *ready; /* oldest first */
    bool stop;
};

/* Lets the frames before this one happen: a game's later pictures depend on them. */
static frame_result draw(artist *self, uint64_t frame, daft_error *error)
{
    for (; !self->film->source->any_order && self->cursor < frame; self->cursor++) {
        frame_result before = film_draw(self->film, self->cursor, false, error);
        if (before != FRAME_DRAWN) return before;
    }
    self->cursor = frame + 1;
    return film_draw(self->film, frame, true, error);
}

static bool keep_pixels(const film *f, drawing *out)
{
    size_t size = 4 * (size_t)f->def->width * (size_t)f->def->height;
    out->size = sizeof out->frame + size;
    out->bytes = malloc(out->size);
    if (!out->bytes) return fail(&out->error, DAFT_ERROR_MEMORY, "out of memory for a frame");
    memcpy(out->bytes, &out->frame, sizeof out->frame);
    memcpy(out->bytes + sizeof out->frame, daft_image_pixels(f->image), size);
    return true;
}

static bool write_picture(const film *f, drawing *out)
{
    char path[FILM_PATH_SIZE];
    film_picture_path(f, out->frame, path);
    return daft_image_write(f->image, path, &out->error);
}

static void make(artist *self, drawing *out)
{
    out->result = draw(self, out->frame, &out->error);
    if (out->result != FRAME_DRAWN) return;
    bool good = self->film->def->format == VIDEO_PNG ? write_picture(self->film, out) : keep_pixels(self->film, out);
    if (!good) out->result = FRAME_FAILED;
}

static drawing *pop(drawing **list)
{
    drawing *oldest = *list;
    if (oldest) *list = oldest->next, oldest->next = NULL;
    return oldest;
}

static void push(drawing **list, drawing *newest)
{
    while (*list) list = &(*list)->next;
    *list = newest;
}

static void *work(void *user)
{
    artist *self = user;
    pthread_mutex_lock(&self->lock);
    while (!self->stop) {
        drawing *next = pop(&self->orders);
        if (!next) {
            pthread_cond_wait(&self->changed, &self->lock);
            continue;
        }
        pthread_mutex_unlock(&self->lock);
        make(self, next);
        pthread_mutex_lock(&self->lock);
        push(&self->ready, next);
    }
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

artist *artist_open(film *f, daft_error *error)
{
    artist *self = calloc(1, sizeof *self);
    if (!self) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
        return NULL;
    }
    self->film = f;
    pthread_mutex_init(&self->lock, NULL);
    pthread_cond_init(&self->changed, NULL);
    if (pthread_create(&self->thread, NULL, work, self) == 0) return self;
    free(self);
    fail(error, DAFT_ERROR_MEMORY, "the system gives no thread to draw on");
    return NULL;
}

bool artist_order(artist *self, uint64_t frame, int keeper)
{
    drawing *order = calloc(1, sizeof *order);
    if (!order) return false;
    order->frame = frame, order->keeper = keeper;
    pthread_mutex_lock(&self->lock);
    push(&self->orders, order);
    pthread_cond_signal(&self->changed);
    pthread_mutex_unlock(&self->lock);
    return true;
}

drawing *artist_take(artist *self)
{
    pthread_mutex_lock(&self->lock);
    drawing *ready = pop(&self->ready);
    pthread_mutex_unlock(&self->lock);
    return ready;
}

void drawing_free(drawing *self)
{
    free(self->bytes);
    free(self);
}

void artist_close(artist *self)
{
    if (!self) return;
    pthread_mutex_lock(&self->lock);
    self->stop = true;
    pthread_cond_signal(&self->changed);
    pthread_mutex_unlock(&self->lock);
    pthread_join(self->thread, NULL);
    for (drawing *rest; (rest = pop(&self->orders)) || (rest = pop(&self->ready));) drawing_free(rest);
    pthread_cond_destroy(&self->changed);
    pthread_mutex_destroy(&self->lock);
    free(self);
}
