/* The processes of a film: what they tell each other. */
#include "video/crew.h"

#include "many/share.h"
#include "video/artist.h"
#include "video/reel.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum {
    WORK,   /* 0 to all: an order */
    MADE,   /* to 0: this frame is drawn */
    NONE,   /* to 0: the source has ended before this frame */
    PIXELS, /* to who encodes: a frame's number and pixels */
    TAKEN,  /* to 0: one more frame is encoded, or written */
    CLIP,   /* to 0: a clip_head and its packets */
    END     /* 0 to all: so many frames there are */
};

/* A frame to draw, and who wants its pixels. */
typedef struct order {
    uint64_t frame;
    int64_t keeper;
} order;

typedef struct clip_head {
    uint64_t clip, frames;
} clip_head;

typedef struct crew {
    film *film;
    many *all;
    artist *artist;
    reel *reels;
    bool stop, failed;
    daft_error error;
    /* of process 0 */
    share share;
    uint64_t clips_saved;
} crew;

static bool first(const crew *c) { return many_rank(c->all) == 0; }

static bool encodes(const crew *c) { return c->film->def->format != VIDEO_PNG && c->film->def->format != VIDEO_RAW; }

static void tell_first(const crew *c, int kind, uint64_t number) { many_send(c->all, 0, kind, &number, sizeof number); }

/* ---- what goes wrong ---- */

/* The first error counts. Others wait to be told to stop. */
static void give_up(crew *c, const daft_error *error)
{
    if (c->failed) return;
    c->failed = true;
    c->error = *error;
    if (!first(c)) many_tell_failure(c->all, error);
}

/* ---- drawing ---- */

static void hand_over(crew *c, drawing *ready)
{
    if (ready->result == FRAME_FAILED) {
        give_up(c, &ready->error);
        return;
    }
    tell_first(c, ready->result == FRAME_DRAWN ? MADE : NONE, ready->frame);
    if (ready->result == FRAME_NONE) return;
    if (!ready->bytes) {
        tell_first(c, TAKEN, ready->frame);
        return;
    }
    many_send_own(c->all, ready->keeper, PIXELS, ready->bytes, ready->size);
    ready->bytes = NULL;
}

static bool hand_over_drawings(crew *c)
{
    bool some = false;
    for (drawing *ready; (ready = artist_take(c->artist)); some = true) {
        hand_over(c, ready);
        drawing_free(ready);
    }
    return some;
}

static void take_order(crew *c, const many_message *m)
{
    order o;
    daft_error error;
    memcpy(&o, m->bytes, sizeof o);
    if (artist_order(c->artist, o.frame, (int)o.keeper)) return;
    fail(&error, DAFT_ERROR_MEMORY, "out of memory for a video");
    give_up(c, &error);
}

/* ---- encoding ---- */

static reel *find_reel(crew *c, uint64_t frame)
{
    uint64_t clip = c->film->def->format == VIDEO_RAW ? 0 : frame / c->film->clip_frames;
    for (reel *r = c->reels; r; r = r->next)
        if (r->clip == clip) return r;
    daft_error error;
    reel *r = reel_open(c->film, clip, share_window(many_count(c->all)), &error);
    if (!r) {
        give_up(c, &error);
        return NULL;
    }
    r->next = c->reels;
    return c->reels = r;
}

static void put_pixels(crew *c, uint8_t *bytes)
{
    uint64_t frame;
    memcpy(&frame, bytes, sizeof frame);
    reel *r = c->failed ? NULL : find_reel(c, frame);
    if (r)
        reel_put(r, bytes);
    else
        free(bytes);
}

static void send_clip(const crew *c, const reel *done)
{
    clip_head head = {done->clip, done->count};
    size_t size = sizeof head + done->packets.size;
    uint8_t *bytes = malloc(size);
    daft_error error;
    if (!bytes) {
        fail(&error, DAFT_ERROR_MEMORY, "out of memory for a clip");
        give_up((crew *)(uintptr_t)c, &error);
        return;
    }
    memcpy(bytes, &head, sizeof head);
    if (done->packets.size > 0) memcpy(bytes + sizeof head, done->packets.bytes, done->packets.size);
    many_send_own(c->all, 0, CLIP, bytes, size);
}

/* The source ended early: the clip in which it did is shorter, and whole once its frames are here. */
static void shorten_reels(crew *c, uint64_t frames)
{
    c->film->frames = frames;
    for (reel *r = c->reels; r; r = r->next)
        if (r->first + r->count > frames) r->count = frames > r->first ? frames - r->first : 0;
}

static bool run_reels(crew *c)
{
    bool some = false;
    for (reel **at = &c->reels; *at;) {
        reel *r = *at;
        daft_error error;
        uint32_t taken = 0;
        reel_state state = reel_run(r, &taken, &error);
        for (uint32_t i = 0; i < taken; i++) tell_first(c, TAKEN, r->first + r->added - 1 - i);
        some |= taken > 0 || state == REEL_DONE;
        if (state == REEL_OPEN) {
            at = &r->next;
            continue;
        }
        if (state == REEL_FAILED) give_up(c, &error);
        if (state == REEL_DONE && encodes(c)) send_clip(c, r);
        *at = r->next;
        reel_close(r);
    }
    return some;
}

/* ---- process 0 ---- */

static void hand_out(crew *c)
{
    share_work work;
    while (!c->failed && share_give(&c->share, &work)) {
        order o = {work.piece, work.keeper};
        many_send(c->all, work.process, WORK, &o, sizeof o);
    }
}

static void save_clip(crew *c, const many_message *m)
{
    clip_head head;
    char path[FILM_PATH_SIZE];
    daft_error error;
    memcpy(&head, m->bytes, sizeof head);
    packet_list packets = {m->bytes + sizeof head, m->size - sizeof head, m->size - sizeof head};
    film_clip_path(c->film, head.clip, path);
    if (!packets_save(&packets, path, c->film->key, (uint32_t)head.frames, &error)) give_up(c, &error);
    c->clips_saved++;
}

static void announce_end(crew *c)
{
    uint64_t frames = c->film->frames;
    for (int i = 1; i < many_count(c->all); i++) many_send(c->all, i, END, &frames, sizeof frames);
}

static void end_at(crew *c, uint64_t frames)
{
    if (frames >= c->film->frames) return;
    shorten_reels(c, frames);
    announce_end(c);
}

static bool whole(const crew *c)
{
    const film *f = c->film;
    if (!share_finished(&c->share)) return false;
    return !encodes(c) || c->clips_saved >= (f->frames + f->clip_frames - 1) / f->clip_frames;
}

static void put_together(crew *c)
{
    film *f = c->film;
    bool good = f->frames > 0 || film_is_empty(f, &c->error);
    if (good && encodes(c)) good = film_join(f, f->frames, &c->error);
    if (good && f->def->format != VIDEO_RAW) film_remove_clips(f);
    c->failed = !good;
    c->stop = true;
}

/* Frames whose clip, or picture, an earlier call has made. */
static void skip_clip(crew *c, uint64_t clip, uint32_t count)
{
    film *f = c->film;
    uint64_t begin = clip * f->clip_frames, end = begin + f->clip_frames;
    if (end > f->frames) end = f->frames;
    for (uint64_t i = begin; i < end; i++) share_skip(&c->share, i);
    f->taken_over += count;
    c->clips_saved++;
    if (begin + count >= end) return;
    share_shorten(&c->share, begin + count);
    f->frames = begin + count;
}

static void skip_clips(crew *c)
{
    for (uint64_t clip = 0; clip * c->film->clip_frames < c->film->frames; clip++) {
        char path[FILM_PATH_SIZE];
        packet_list packets = {0};
        uint32_t count = 0;
        film_clip_path(c->film, clip, path);
        bool made = packets_load(&packets, path, c->film->key, &count);
        packets_free(&packets);
        if (made) skip_clip(c, clip, count);
    }
}

static void skip_pictures(crew *c)
{
    daft_error error = {.code = DAFT_OK};
    bool same = film_same_pictures(c->film, &error);
    if (error.code != DAFT_OK) give_up(c, &error);
    for (uint64_t frame = 0; same && frame < c->film->frames; frame++) {
        char path[FILM_PATH_SIZE];
        film_picture_path(c->film, frame, path);
        if (!path_is_file(path)) continue;
        share_skip(&c->share, frame);
        c->film->taken_over++;
    }
}

static bool begin_first(crew *c, daft_error *error)
{
    film *f = c->film;
    uint64_t frames = f->frames;
    share_def def = {.count = frames,
                     .group = encodes(c)                    ? f->clip_frames
                              : f->def->format == VIDEO_RAW ? frames
                                                            : 1,
                     .processes = many_count(c->all),
                     .ascending = !f->source->any_order};
    if (!share_open(&c->share, &def)) return fail(error, DAFT_ERROR_MEMORY, "out of memory for a video");
    if (encodes(c)) skip_clips(c);
    if (f->def->format == VIDEO_PNG) skip_pictures(c);
    if (f->frames < frames) announce_end(c);
    return true;
}

static void run_first(crew *c)
{
    if (c->failed) {
        c->stop = true;
        return;
    }
    hand_out(c);
    c->film->done = c->share.done;
    if (c->film->def->progress && c->share.count > 0)
        progress_show(&c->film->bar, (double)c->share.done / (double)c->share.count);
    if (whole(c)) put_together(c);
}

static void receive_first(crew *c, const many_message *m, uint64_t number)
{
    if (m->kind == MADE) share_made(&c->share, m->from);
    if (m->kind == TAKEN) share_taken(&c->share, number);
    if (m->kind == CLIP) save_clip(c, m);
    if (m->kind == NONE) {
        share_none(&c->share, m->from, number);
        end_at(c, number);
    }
    if (m->kind == MANY_FAILED) {
        daft_error error;
        many_take_failure(m, &error);
        give_up(c, &error);
    }
}

/* ---- every process ---- */

static void receive(crew *c, many_message *m)
{
    uint64_t number = 0;
    if (m->size >= sizeof number) memcpy(&number, m->bytes, sizeof number);
    if (m->kind == PIXELS) {
        put_pixels(c, m->bytes);
        return;
    }
    if (m->kind == WORK) take_order(c, m);
    if (m->kind == END) shorten_reels(c, number);
    if (m->kind == MANY_STOP) c->stop = true;
    if (first(c)) receive_first(c, m, number);
    free(m->bytes);
}

static bool receive_all(crew *c)
{
    bool some = false;
    for (many_message m; !c->stop && many_receive(c->all, &m); some = true) receive(c, &m);
    return some;
}

static void run(crew *c)
{
    while (!c->stop) {
        bool busy = receive_all(c);
        busy |= hand_over_drawings(c);
        busy |= run_reels(c);
        if (first(c) && !c->stop) run_first(c);
        if (!busy) many_pause();
    }
}

bool crew_make(film *f, many *all, daft_error *error)
{
    crew c = {.film = f, .all = all};
    c.artist = artist_open(f, error);
    if (!c.artist || (first(&c) && !begin_first(&c, error))) {
        many_drop_out(all, error);
        c.failed = true;
    } else {
        run(&c);
        if (first(&c)) many_stop_others(all);
        if (c.failed) *error = c.error;
    }
    artist_close(c.artist);
    for (reel *r; (r = c.reels);) {
        c.reels = r->next;
        reel_close(r);
    }
    share_close(&c.share);
    return !c.failed || many_rank(all) > 0; /* what failed there is told by process 0 */
}
