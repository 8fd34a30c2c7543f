/* Puts frames in order. */
#include "video/reel.h"

#include "video/stage.h"

#include <stdlib.h>
#include <string.h>

static size_t frame_size(const film *f) { return 4 * (size_t)f->def->width * (size_t)f->def->height; }

static bool prepare(reel *self, daft_error *error)
{
    self->waiting = calloc((size_t)self->slots, sizeof *self->waiting);
    if (!self->waiting) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
    if (self->film->def->format == VIDEO_RAW) return true;
    self->to = encoder_open(self->film->def, error);
    if (self->to) self->stage = stage_open(self->to, frame_size(self->film), &self->packets, error);
    return self->stage != NULL;
}

reel *reel_open(const film *f, uint64_t clip, uint64_t window, daft_error *error)
{
    reel *self = calloc(1, sizeof *self);
    if (!self) {
        fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
        return NULL;
    }
    *self = (reel){.clip = clip, .film = f, .count = f->frames, .slots = window};
    if (f->def->format != VIDEO_RAW) {
        self->first = clip * f->clip_frames;
        self->count = self->first + f->clip_frames < f->frames ? f->clip_frames : f->frames - self->first;
        self->slots = f->clip_frames;
    }
    if (prepare(self, error)) return self;
    reel_close(self);
    return NULL;
}

void reel_put(reel *self, uint8_t *bytes)
{
    uint64_t frame;
    memcpy(&frame, bytes, sizeof frame);
    self->waiting[(frame - self->first) % self->slots] = bytes;
}

/* The next frame, if it is here and there is room for it. */
static uint8_t *next_frame(const reel *self)
{
    if (self->added >= self->count || (self->stage && stage_full(self->stage))) return NULL;
    return self->waiting[self->added % self->slots];
}

static bool take(reel *self, const uint8_t *pixels, daft_error *error)
{
    if (!self->stage) return film_print(self->film, pixels, error);
    if (stage_add(self->stage, pixels)) return true;
    stage *failed = self->stage;
    self->stage = NULL;
    stage_close(failed, false, error);
    return false;
}

static reel_state finish(reel *self, daft_error *error)
{
    if (!self->stage) return film_flush(error) ? REEL_DONE : REEL_FAILED;
    if (!self->ending) stage_end(self->stage);
    self->ending = true;
    if (!stage_ended(self->stage)) return REEL_OPEN;
    stage *ended = self->stage;
    self->stage = NULL;
    return stage_close(ended, true, error) ? REEL_DONE : REEL_FAILED;
}

reel_state reel_run(reel *self, uint32_t *taken, daft_error *error)
{
    *taken = 0;
    if (self->count == 0) return REEL_EMPTY;
    for (uint8_t *frame; (frame = next_frame(self)); ++*taken) {
        bool good = take(self, frame + sizeof(uint64_t), error);
        free(frame);
        self->waiting[self->added++ % self->slots] = NULL;
        if (!good) return REEL_FAILED;
    }
    return self->added >= self->count ? finish(self, error) : REEL_OPEN;
}

void reel_close(reel *self)
{
    daft_error ignored;
    if (!self) return;
    if (self->stage) stage_close(self->stage, false, &ignored);
    encoder_close(self->to);
    packets_free(&self->packets);
    for (uint64_t i = 0; self->waiting && i < self->slots; i++) free(self->waiting[i]);
    free(self->waiting);
    free(self);
}
