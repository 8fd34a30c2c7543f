/* share: which process does which piece of a job.
 *
 * Pieces lie in groups that somebody puts together in order: the frames of a clip, for example. A process that has
 * nothing to do opens the next group and puts it together; where all are open, it helps with the one that has most left
 * for each who is at it. So slow and fast processes end together, and what is made seldom has to travel. Each has up to
 * SHARE_AHEAD pieces before it, which hides the way there and back. */
#ifndef RUNTIME_MANY_SHARE_H
#define RUNTIME_MANY_SHARE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SHARE_AHEAD = 2 };

typedef struct share_def {
    uint64_t count, group; /* pieces, and how many of them make a group */
    int processes;
    bool ascending; /* a process cannot go back to earlier pieces */
} share_def;

typedef struct share_work {
    int process, keeper; /* who makes the piece, and who puts its group together */
    uint64_t piece;
} share_work;

typedef struct share_group {
    uint64_t next;          /* the first piece that nobody was given */
    uint64_t waiting;       /* handed out, not put in place */
    uint32_t keeper, hands; /* `hands`: processes that are at it */
} share_group;

typedef struct share {
    share_def def;
    uint64_t groups, open; /* groups in all; the first that nobody has opened */
    uint64_t done;         /* pieces in place, or skipped */
    uint64_t count;        /* of pieces; shrinks by share_shorten */
    uint8_t *skip;         /* of each piece */
    share_group *group;
    uint8_t *busy; /* pieces before each process */
    uint64_t *at;  /* each process's group; `groups`: none yet */
} share;

/* How many pieces of a group may be on their way, with all processes at it: what its keeper must be able to hold. */
uint64_t share_window(int processes);
/* False: out of memory. */
bool share_open(share *self, const share_def *def);
void share_close(share *self);
/* Nobody is to do this piece; before any is handed out. */
void share_skip(share *self, uint64_t piece);
/* Gives a piece to a process that has least before it. False: all are busy, or there is nothing for them now. */
bool share_give(share *self, share_work *out);
/* The process has made a piece. */
void share_made(share *self, int process);
/* The piece is in its place. */
void share_taken(share *self, uint64_t piece);
/* There are only so many pieces: those from `count` on do not exist. */
void share_shorten(share *self, uint64_t count);
/* The process found that its piece does not exist, nor does any after it. */
void share_none(share *self, int process, uint64_t piece);
bool share_finished(const share *self);

#endif
