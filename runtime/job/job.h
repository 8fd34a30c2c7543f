/* job: a snapshot or a film that is made while its scene is flown through: on a thread of its own, by an engine of its
 * own with a scene of its own, which the window cannot disturb. Public headers: job.h shot.h
 * Promises: a picture or film appears whole under its name or not at all; a file that changes meanwhile changes
 * nothing; the window's threads come first (on Linux). */
#ifndef RUNTIME_JOB_JOB_H
#define RUNTIME_JOB_JOB_H

#include "common/util.h"

typedef struct job_def {
    char scene[PATH_SIZE]; /* .scene or .obj */
    char out[PATH_SIZE];   /* the picture, .png, beside which a .json says how it was taken; or the film */
    int width, height;
    daft_view view;
    const daft_checkpoint *points; /* copied; none: a picture */
    uint32_t count;                /* 2 or more for a film */
    daft_pace pace;
    int threads;
    const char *isa; /* lives as long as the program */
    uint64_t memory_limit;
} job_def;

typedef struct job job;

/* Whether this program can make a film of that name and size. */
bool job_can_film(const job_def *def, daft_error *error);
/* NULL with the message. */
job *job_start(const job_def *def, daft_error *error);
const job_def *job_what(const job *self);
double job_done(const job *self);    /* 0..1 */
double job_seconds(const job *self); /* since it began */
bool job_has_ended(const job *self);
/* It ends soon. */
void job_cancel(job *self);
/* Waits for the end and frees it. False: DAFT_ERROR_CANCELLED, or what went wrong. */
bool job_close(job *self, daft_error *error);

#endif
