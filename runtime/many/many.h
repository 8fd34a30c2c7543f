/* many: one job done by several processes, on one machine or on many, that mpirun has started.
 * Public headers: many.h share.h bands.h
 *
 * The processes are numbered from 0; number 0 hands out the work, and it alone is heard on standard output and error.
 * Messages between two processes arrive in the order in which they were sent. All calls come from one thread of a
 * process.
 * Promises: without mpirun, or with one process, nothing here costs anything. */
#ifndef RUNTIME_MANY_MANY_H
#define RUNTIME_MANY_MANY_H

#include "daft.h"

typedef struct many many;

typedef struct many_message {
    int from, kind;
    uint8_t *bytes; /* the receiver's, to be freed; NULL where there are none */
    size_t size;
} many_message;

/* Whether this is one of several processes that mpirun has started. */
bool many_started(void);
/* Silences standard output and error in all processes but the first: what they would say is said by that one. */
void many_hush(void);

/* Joins the others. NULL with the message where this program was built without MPI. */
many *many_join(daft_error *error);
int many_rank(const many *self);  /* 0..count-1 */
int many_count(const many *self); /* at least 2 */
/* Threads that this process should use where nobody says: its share of the machine's processors. */
int many_threads(const many *self);

/* Sends a copy, without waiting. `kind`: 0..998. At most 1 GB. */
void many_send(many *self, int to, int kind, const void *bytes, size_t size);
/* Likewise, but takes `bytes` over, which were allocated by malloc. */
void many_send_own(many *self, int to, int kind, uint8_t *bytes, size_t size);
/* The next message. False: none has come. */
bool many_receive(many *self, many_message *out);
/* Sleeps for a moment, for who has nothing to do: 0.2 ms. */
void many_pause(void);

/* How a job ends. What goes wrong in another process is told to process 0, which then has the message; and it tells all
 * others when they are no longer needed. */
enum { MANY_FAILED = 999, MANY_STOP = 1000 };
void many_stop_others(many *self);
/* To process 0: "process 3 on HOST: message". */
void many_tell_failure(many *self, const daft_error *error);
/* The error in a message of kind MANY_FAILED. */
void many_take_failure(const many_message *message, daft_error *error);
/* For a process that can take no part: does what is needed of the two above, and waits to be told to stop. */
void many_drop_out(many *self, const daft_error *error);

/* Waits until what was sent has left and all processes are here, and frees `self`, which may be NULL. */
void many_leave(many *self);

#endif
