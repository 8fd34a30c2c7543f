/* film: a film in the making, as the ways to make one share it. */
#ifndef RUNTIME_VIDEO_FILM_H
#define RUNTIME_VIDEO_FILM_H

#include "common/progress.h"
#include "common/util.h"
#include "video/blur.h"
#include "video/encode/encoder.h"
#include "video/video.h"

enum { FILM_PARTS_SIZE = PATH_SIZE + 16, FILM_PATH_SIZE = FILM_PARTS_SIZE + 16 };

typedef struct film {
    const video_def *def;
    frame_source *source;
    daft_image *image;
    blur blur;
    char parts[FILM_PARTS_SIZE]; /* the folder of finished clips */
    uint64_t frames, clip_frames;
    uint64_t key; /* of the clips: the settings and what is filmed */
    uint64_t done;
    uint64_t taken_over; /* frames that an earlier call had made */
    bool ended;          /* the source ended early */
    progress_bar bar;
} film;

/* Draws a frame into f->image, or only lets it happen where nobody wants it. Frames come in ascending order. */
frame_result film_draw(film *f, uint64_t frame, bool wanted, daft_error *error);
void film_clip_path(const film *f, uint64_t clip, char out[FILM_PATH_SIZE]);
void film_picture_path(const film *f, uint64_t frame, char out[FILM_PATH_SIZE]);
/* Whether pictures of an earlier call with the same settings may be taken over: its key lies in the folder of parts.
 * False with error->code DAFT_OK: none may; the key is put there. */
bool film_same_pictures(film *f, daft_error *error);
/* Puts the file together from the first `frames` frames' clips. */
bool film_join(const film *f, uint64_t frames, daft_error *error);
void film_remove_clips(const film *f);
/* Raw frames go to standard output. */
bool film_print(const film *f, const uint8_t *pixels, daft_error *error);
bool film_flush(daft_error *error);
bool film_is_empty(const film *f, daft_error *error); /* fails: there was nothing to film */

#endif
