/* Encodes frames on a thread of its own: a ring of frames, filled by the caller, emptied by the thread. */
#include "video/stage.h"

#include "common/util.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { STAGE_FRAMES = 8 }; /* evens out frames that take longer to draw or to encode; 30 MB at 1280x720 */

struct stage {
    encoder *to;
    packet_list *out;
    size_t size;
    uint8_t *frames; /* STAGE_FRAMES of them */
    pthread_t thread;
    bool threaded;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    uint64_t added, taken;
    bool closed, finish, failed, ended;
    daft_error error;
};

/* Keeps the first error. */
static void note(stage *self, bool good, const daft_error *error)
{
    if (good) return;
    pthread_mutex_lock(&self->lock);
    self->failed = true;
    self->error = *error;
    pthread_mutex_unlock(&self->lock);
}

static void encode(stage *self, const uint8_t *pixels)
{
    daft_error error;
    if (!self->failed) note(self, encoder_add(self->to, pixels, self->out, &error), &error);
}

static void finish(stage *self)
{
    daft_error error;
    if (!self->failed && self->finish) note(self, encoder_finish(self->to, self->out, &error), &error);
}

static void *work(void *user)
{
    stage *self = user;
    pthread_mutex_lock(&self->lock);
    for (;;) {
        while (self->added == self->taken && !self->closed) pthread_cond_wait(&self->changed, &self->lock);
        if (self->added == self->taken) break;
        const uint8_t *frame = self->frames + self->taken % STAGE_FRAMES * self->size;
        pthread_mutex_unlock(&self->lock);
        encode(self, frame);
        pthread_mutex_lock(&self->lock);
        self->taken++;
        pthread_cond_signal(&self->changed);
    }
    pthread_mutex_unlock(&self->lock);
    finish(self);
    pthread_mutex_lock(&self->lock);
    self->ended = true;
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

stage *stage_open(encoder *to, size_t size, packet_list *out, daft_error *error)
{
    stage *self = calloc(1, sizeof *self);
    uint8_t *frames = malloc(STAGE_FRAMES * size);
    if (!self || !frames) {
        free(self);
        free(frames);
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
        return NULL;
    }
    *self = (stage){.to = to, .out = out, .size = size, .frames = frames};
    pthread_mutex_init(&self->lock, NULL);
    pthread_cond_init(&self->changed, NULL);
    self->threaded = pthread_create(&self->thread, NULL, work, self) == 0;
    return self;
}

bool stage_add(stage *self, const uint8_t *pixels)
{
    if (!self->threaded) {
        encode(self, pixels);
        return !self->failed;
    }
    pthread_mutex_lock(&self->lock);
    while (self->added - self->taken == STAGE_FRAMES) pthread_cond_wait(&self->changed, &self->lock);
    uint64_t place = self->added;
    pthread_mutex_unlock(&self->lock);
    memcpy(self->frames + place % STAGE_FRAMES * self->size, pixels, self->size);
    pthread_mutex_lock(&self->lock);
    self->added++;
    bool good = !self->failed;
    pthread_cond_signal(&self->changed);
    pthread_mutex_unlock(&self->lock);
    return good;
}

bool stage_full(stage *self)
{
    if (!self->threaded) return false;
    pthread_mutex_lock(&self->lock);
    bool full = self->added - self->taken == STAGE_FRAMES;
    pthread_mutex_unlock(&self->lock);
    return full;
}

static void close_stage(stage *self, bool finishes)
{
    if (self->closed) return;
    pthread_mutex_lock(&self->lock);
    self->finish = finishes;
    self->closed = true;
    pthread_cond_signal(&self->changed);
    pthread_mutex_unlock(&self->lock);
    if (self->threaded) return;
    finish(self);
    self->ended = true;
}

void stage_end(stage *self) { close_stage(self, true); }

bool stage_ended(stage *self)
{
    pthread_mutex_lock(&self->lock);
    bool ended = self->ended;
    pthread_mutex_unlock(&self->lock);
    return ended;
}

bool stage_close(stage *self, bool finishes, daft_error *error)
{
    close_stage(self, finishes);
    if (self->threaded) pthread_join(self->thread, NULL);
    bool good = !self->failed;
    if (!good) *error = self->error;
    pthread_cond_destroy(&self->changed);
    pthread_mutex_destroy(&self->lock);
    free(self->frames);
    free(self);
    return good;
}
