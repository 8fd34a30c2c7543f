/* Makes a film clip by clip. */
#include "video/video.h"

#include "common/stop.h"
#include "video/crew.h"
#include "video/film.h"
#include "video/stage.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CLIP_SECONDS = 2 };

/* ---- settings ---- */

bool video_choose_format(const char *out, video_format *format, daft_error *error)
{
    static const struct {
        const char *extension;
        video_format format;
    } known[] = {{".mp4", VIDEO_MP4}, {".webm", VIDEO_WEBM}, {".gif", VIDEO_GIF}, {".png", VIDEO_PNG}};
    if (strcmp(out, "-") == 0) {
        *format = VIDEO_RAW;
        return true;
    }
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        if (!has_extension(out, known[i].extension)) continue;
        *format = known[i].format;
        return true;
    }
    return fail(error, DAFT_ERROR_ARGUMENT,
                "%s: a name that ends in .mp4, .webm, .gif or .png expected, or - for raw frames", out);
}

/* The digits of a '%05d' in `out`, its only '%'. NULL where there is none. */
static const char *number_mark(const char *out, int *width, size_t *length)
{
    const char *mark = strchr(out, '%'), *at = mark;
    if (!mark || strchr(mark + 1, '%')) return NULL;
    for (*width = 0, at++; *at >= '0' && *at <= '9' && *width < 10; at++) *width = *width * 10 + (*at - '0');
    *length = (size_t)(at + 1 - mark);
    return *at == 'd' && *width <= 9 ? mark : NULL;
}

bool video_check(const video_def *def, daft_error *error)
{
    int width;
    size_t length;
    if (def->format == VIDEO_PNG && !number_mark(def->out, &width, &length))
        return fail(error, DAFT_ERROR_ARGUMENT, "%s: the number of the picture is missing, as in frame%%05d.png",
                    def->out);
    if (def->format == VIDEO_MP4 && (def->width % 2 || def->height % 2))
        return fail(error, DAFT_ERROR_ARGUMENT, "H.264 wants an even width and height, got %dx%d", def->width,
                    def->height);
    if (def->format == VIDEO_GIF && def->rate > 50000)
        return fail(error, DAFT_ERROR_ARGUMENT, "a GIF shows at most 50 frames a second, not %g", def->rate / 1000.0);
    if (strlen(def->out) + 16 > PATH_SIZE) return fail(error, DAFT_ERROR_ARGUMENT, "the name of the video is too long");
    if (def->format == VIDEO_PNG || def->format == VIDEO_RAW) return true;
    encoder *trial = encoder_open(def, error);
    encoder_close(trial);
    return trial != NULL;
}

uint64_t video_frames(const video_def *def)
{
    double frames = (def->to - def->from) * def->rate / 1000;
    return frames > 0 ? (uint64_t)ceil(frames - 1e-6) : 0;
}

static uint64_t key_of(const video_def *def)
{
    double times[2] = {def->from, def->to};
    int numbers[6] = {(int)def->format, def->width, def->height, def->rate, def->crf, def->blur};
    return daft_hash(times, sizeof times, daft_hash(numbers, sizeof numbers, def->content));
}

/* ---- frames ---- */

static frame_result draw_part(film *f, uint64_t frame, int part, bool wanted, daft_error *error)
{
    double length = 1000.0 / f->def->rate;
    /* The shutter is open for half of the frame's time, around its middle. */
    double shutter = f->def->blur > 1 ? ((part + 0.5) / f->def->blur - 0.5) * 0.5 : 0;
    double time = f->def->from + ((double)frame + shutter) * length;
    return f->source->draw(f->source, time > 0 ? time : 0, wanted, f->image, error);
}

frame_result film_draw(film *f, uint64_t frame, bool wanted, daft_error *error)
{
    for (int part = 0; part < f->def->blur; part++) {
        frame_result result = draw_part(f, frame, part, wanted, error);
        if (result != FRAME_DRAWN) return result;
        if (wanted && f->def->blur > 1) blur_add(&f->blur, daft_image_pixels(f->image));
    }
    if (wanted && f->def->blur > 1) blur_take(&f->blur, daft_image_pixels(f->image));
    return FRAME_DRAWN;
}

static frame_result draw_next(film *f, uint64_t frame, bool wanted, daft_error *error)
{
    frame_result result = film_draw(f, frame, wanted, error);
    if (result != FRAME_DRAWN) return result;
    f->done++;
    if (f->def->progress) progress_show(&f->bar, (double)f->done / (double)f->frames);
    return result;
}

/* ---- clips ---- */

void film_clip_path(const film *f, uint64_t clip, char out[FILM_PATH_SIZE])
{
    snprintf(out, FILM_PATH_SIZE, "%s/%06" PRIu64, f->parts, clip);
}

/* False with the message in *error, or where the stage has it. */
static bool draw_clip(film *f, stage *to, uint64_t first, uint32_t *count, daft_error *error)
{
    uint64_t end = first + f->clip_frames < f->frames ? first + f->clip_frames : f->frames;
    for (uint64_t frame = first; frame < end; frame++) {
        frame_result result = draw_next(f, frame, true, error);
        if (result == FRAME_FAILED) return false;
        f->ended = result == FRAME_NONE;
        if (f->ended) break;
        if (!stage_add(to, daft_image_pixels(f->image))) return false;
        ++*count;
    }
    return true;
}

static bool encode_clip(film *f, encoder *to, uint64_t first, packet_list *packets, uint32_t *count, daft_error *error)
{
    size_t size = 4 * (size_t)f->def->width * (size_t)f->def->height;
    stage *beside = stage_open(to, size, packets, error);
    if (!beside) return false;
    bool drawn = draw_clip(f, beside, first, count, error);
    bool encoded = stage_close(beside, drawn && *count > 0, error);
    return drawn && encoded;
}

static bool make_clip(film *f, uint64_t clip, const char *path, uint32_t *count, daft_error *error)
{
    packet_list packets = {0};
    encoder *to = encoder_open(f->def, error);
    bool good = to && encode_clip(f, to, clip * f->clip_frames, &packets, count, error) &&
                packets_save(&packets, path, f->key, *count, error);
    encoder_close(to);
    packets_free(&packets);
    return good;
}

/* A clip of an earlier call: its frames only have to happen. */
static bool pass_over(film *f, uint64_t clip, uint32_t count, daft_error *error)
{
    for (uint32_t i = 0; i < count; i++)
        if (draw_next(f, clip * f->clip_frames + i, false, error) == FRAME_FAILED) return false;
    f->ended = count < f->clip_frames;
    f->taken_over += count;
    return true;
}

static bool make_clips(film *f, daft_error *error)
{
    for (uint64_t clip = 0; clip * f->clip_frames < f->frames && !f->ended; clip++) {
        char path[FILM_PATH_SIZE];
        packet_list packets = {0};
        uint32_t count = 0;
        film_clip_path(f, clip, path);
        bool made = packets_load(&packets, path, f->key, &count);
        packets_free(&packets);
        if (made ? !pass_over(f, clip, count, error) : !make_clip(f, clip, path, &count, error)) return false;
    }
    return true;
}

bool film_join(const film *f, uint64_t frames, daft_error *error)
{
    muxer *to = muxer_open(f->def, error);
    bool good = to != NULL;
    uint64_t start = 0;
    for (uint64_t clip = 0; good && start < frames; clip++) {
        char path[FILM_PATH_SIZE];
        packet_list packets = {0};
        uint32_t count = 0;
        film_clip_path(f, clip, path);
        good = packets_load(&packets, path, f->key, &count) ||
               fail_at(error, path, 0, 0, "this part of the video is gone or damaged: call again");
        good = good && muxer_add(to, &packets, start, error);
        packets_free(&packets);
        start += count;
    }
    if (good) return muxer_commit(to, error);
    muxer_abandon(to);
    return false;
}

void film_remove_clips(const film *f)
{
    for (uint64_t clip = 0; clip * f->clip_frames < f->frames; clip++) {
        char path[FILM_PATH_SIZE];
        film_clip_path(f, clip, path);
        unlink(path);
    }
    rmdir(f->parts);
}

static bool open_parts(film *f, daft_error *error)
{
    if (f->def->format == VIDEO_RAW) return true;
    snprintf(f->parts, sizeof f->parts, "%s.parts", f->def->out);
    for (char *mark; (mark = strchr(f->parts, '%'));) *mark = '_';
    if (mkdir(f->parts, 0777) == 0 || (errno == EEXIST && path_is_folder(f->parts))) return true;
    return fail_at(error, f->parts, 0, 0, "this folder for the parts of the video cannot be made: %s", strerror(errno));
}

bool film_is_empty(const film *f, daft_error *error)
{
    film_remove_clips(f);
    return fail(error, DAFT_ERROR_ARGUMENT, "nothing to film: the game ended before second %g", f->def->from);
}

static bool make_file(film *f, daft_error *error)
{
    bool good = make_clips(f, error) && (f->done > 0 || film_is_empty(f, error)) && film_join(f, f->done, error);
    if (good) film_remove_clips(f);
    return good;
}

/* ---- pictures ---- */

/* Takes over the pictures of an earlier call with the same settings: its key lies in the folder of parts. */
bool film_same_pictures(film *f, daft_error *error)
{
    char path[FILM_PATH_SIZE];
    packet_list none = {0};
    uint32_t frames;
    film_clip_path(f, 0, path);
    bool same = packets_load(&none, path, f->key, &frames);
    packets_free(&none);
    return same || (packets_save(&none, path, f->key, 0, error) && false);
}

void film_picture_path(const film *f, uint64_t frame, char out[FILM_PATH_SIZE])
{
    int width = 0;
    size_t length = 0;
    const char *name = f->def->out, *mark = number_mark(name, &width, &length);
    snprintf(out, FILM_PATH_SIZE, "%.*s%0*" PRIu64 "%s", (int)(mark - name), name, width, frame, mark + length);
}

static bool make_pictures(film *f, daft_error *error)
{
    error->code = DAFT_OK;
    bool same = film_same_pictures(f, error);
    if (error->code != DAFT_OK) return false;
    for (uint64_t frame = 0; frame < f->frames; frame++) {
        char path[FILM_PATH_SIZE];
        film_picture_path(f, frame, path);
        bool made = same && path_is_file(path);
        frame_result result = draw_next(f, frame, !made, error);
        if (result == FRAME_NONE) break;
        bool failed = result == FRAME_FAILED || (!made && !daft_image_write(f->image, path, error));
        if (failed && f->done <= 1) film_remove_clips(f); /* there is nothing to go on from */
        if (failed) return false;
        f->taken_over += made;
    }
    if (f->done == 0) return film_is_empty(f, error);
    film_remove_clips(f);
    return true;
}

/* What is said here is not to be said again when the program ends. */
static bool fail_output(daft_error *error)
{
    fail(error, DAFT_ERROR_IO, "standard output: cannot write: %s", strerror(errno));
    clearerr(stdout);
    return false;
}

bool film_print(const film *f, const uint8_t *pixels, daft_error *error)
{
    size_t size = 4 * (size_t)f->def->width * (size_t)f->def->height;
    return fwrite(pixels, 1, size, stdout) == size || fail_output(error);
}

bool film_flush(daft_error *error) { return fflush(stdout) == 0 || fail_output(error); }

static bool make_raw(film *f, daft_error *error)
{
    for (uint64_t frame = 0; frame < f->frames; frame++) {
        frame_result result = draw_next(f, frame, true, error);
        if (result == FRAME_NONE) break;
        if (result == FRAME_FAILED) return false;
        if (!film_print(f, daft_image_pixels(f->image), error)) return false;
    }
    if (f->done == 0) return film_is_empty(f, error);
    return film_flush(error);
}

/* ---- the whole ---- */

static bool make(film *f, daft_error *error)
{
    const video_def *def = f->def;
    f->image = daft_image_create(def->engine, def->width, def->height, error);
    bool writes = !def->all || many_rank(def->all) == 0;
    if (!f->image || (writes && !open_parts(f, error))) return false;
    if (def->blur > 1 && !blur_open(&f->blur, (size_t)def->width * (size_t)def->height, error)) return false;
    progress_begin(&f->bar, "filming");
    bool good = def->all                   ? crew_make(f, def->all, error)
                : def->format == VIDEO_RAW ? make_raw(f, error)
                : def->format == VIDEO_PNG ? make_pictures(f, error)
                                           : make_file(f, error);
    progress_end(&f->bar);
    return good;
}

/* What has been made stays for the next call: says so, whether the film failed or the program is being ended. */
static void tell_parts(void *user)
{
    const film *f = user;
    if (!f->parts[0] || rmdir(f->parts) == 0 || errno != ENOTEMPTY) return; /* there is none */
    fprintf(stderr, "the finished parts are in %s: the same call goes on there\n", f->parts);
}

bool video_make(const video_def *def, frame_source *source, daft_error *error)
{
    film f = {.def = def, .source = source, .frames = video_frames(def), .key = key_of(def)};
    f.clip_frames = (uint64_t)(CLIP_SECONDS * def->rate + 999) / 1000;
    if (f.frames == 0)
        return fail(error, DAFT_ERROR_ARGUMENT, "nothing to film between %g and %g s", def->from, def->to);
    stop_set_act(tell_parts, &f);
    bool good = make(&f, error);
    stop_set_act(NULL, NULL);
    blur_close(&f.blur);
    daft_image_destroy(f.image);
    if (good && f.taken_over > 0)
        fprintf(stderr, "daft: took over %" PRIu64 " of %" PRIu64 " frames from an earlier call\n", f.taken_over,
                f.done);
    if (!good) tell_parts(&f);
    return good;
}
