/* reel: frames that come in any order, put in order and encoded as a clip, or printed. */
#ifndef RUNTIME_VIDEO_REEL_H
#define RUNTIME_VIDEO_REEL_H

#include "video/film.h"

typedef struct reel reel;
struct reel {
    reel *next;
    uint64_t clip, first, count, added; /* frames */
    packet_list packets;
    /* private */
    const film *film;
    uint8_t **waiting; /* slots of them: frames that are here, but not the ones before them */
    uint64_t slots;
    encoder *to;
    struct stage *stage;
    bool ending;
};

typedef enum reel_state { REEL_OPEN, REEL_DONE, REEL_EMPTY, REEL_FAILED } reel_state;

/* The clip of a film, or for raw frames all of it, of which at most `window` come at once. NULL with the message. */
reel *reel_open(const film *f, uint64_t clip, uint64_t window, daft_error *error);
/* Takes over `bytes`: a frame's number and its pixels, from malloc. */
void reel_put(reel *self, uint8_t *bytes);
/* Goes on as far as that needs no waiting. `taken`: how many more frames it has taken in. REEL_DONE: `packets` is the
 * whole clip. `count` may have shrunk since; with REEL_EMPTY to nothing. */
reel_state reel_run(reel *self, uint32_t *taken, daft_error *error);
void reel_close(reel *self);

#endif
