/* video: films of scenes and games: MP4, WebM, GIF, numbered PNGs, or raw frames on standard output.
 * Public headers: video.h source.h soundtrack.h film_game.h film_scene.h
 *
 * A film is made in clips of two seconds. Each clip starts with a key frame and is encoded by an encoder of its own, so
 * its bytes depend on its frames alone: not on threads, nor on whether the film was made in one go. Finished clips lie
 * in the folder FILE.parts until the film is whole; a call that was killed goes on after the last of them.
 * Where several processes make it, each draws some of its frames and encodes some of its clips (crew.h).
 * Promises: FILE appears whole or not at all; the same source and settings give the same bytes. */
#ifndef RUNTIME_VIDEO_VIDEO_H
#define RUNTIME_VIDEO_VIDEO_H

#include "many/many.h"
#include "video/source.h"

typedef enum video_format { VIDEO_MP4, VIDEO_WEBM, VIDEO_GIF, VIDEO_PNG, VIDEO_RAW } video_format;

typedef struct soundtrack soundtrack;

typedef struct video_def {
    const char *out; /* FILE.mp4, .webm, .gif; FILE%05d.png; - for raw RGBA frames on standard output */
    video_format format;
    int width, height;
    int rate;         /* frames in 1000 seconds: 60 a second are 60000 */
    double from, to;  /* seconds of the source, 0 <= from < to */
    int crf;          /* constant rate factor of the encoder: 0 keeps everything, 51 (MP4) or 63 (WebM) the least */
    int blur;         /* pictures that make one frame, over half of its time; 1: no motion blur */
    uint64_t content; /* hash of what is filmed: clips of another are not taken over */
    daft_engine *engine;
    const soundtrack *sound; /* finished, of the time between `from` and `to` (soundtrack.h); NULL: silence */
    bool progress;           /* a bar on stderr */
    many *all; /* the processes that make it together, each with the same settings; NULL: this one alone */
} video_def;

/* The format by the end of the name. False with a message that lists what there is. */
bool video_choose_format(const char *out, video_format *format, daft_error *error);
/* Whether format, size and rate go together, and this program has the encoder. */
bool video_check(const video_def *def, daft_error *error);
/* The frames between `from` and `to`. */
uint64_t video_frames(const video_def *def);
/* Makes the film. `source` gives its pictures, in ascending time. */
bool video_make(const video_def *def, frame_source *source, daft_error *error);

#endif
