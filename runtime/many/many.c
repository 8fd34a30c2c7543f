/* Whether mpirun has started this process, and as which; how a job ends. MPI itself is in daft_mpi.so. */
#include "many/many.h"

#include "common/util.h"
#include "files/module.h"
#include "many/module.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

struct many {
    const mpi_module *mpi;
    mpi_job *job;
    int rank, count, threads;
};

/* Open MPI's names, then those of MPICH and its kin. */
static long first_number(const char *const names[2])
{
    for (int i = 0; i < 2; i++) {
        const char *text = getenv(names[i]);
        if (text && *text) return strtol(text, NULL, 10);
    }
    return 0;
}

bool many_started(void) { return first_number((const char *const[2]){"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) > 1; }

void many_hush(void)
{
    if (!many_started() || first_number((const char *const[2]){"OMPI_COMM_WORLD_RANK", "PMI_RANK"}) == 0) return;
    if (!freopen("/dev/null", "w", stdout)) fclose(stdout);
    if (!freopen("/dev/null", "w", stderr)) fclose(stderr);
}

void many_pause(void) { nanosleep(&(struct timespec){0, 200000}, NULL); }

/* ---- MPI ---- */

many *many_join(daft_error *error)
{
    static const module_def DEF = {.name = "daft_mpi",
                                   .purpose = "a start by mpirun",
                                   .library = "MPI",
                                   .build = "it (Debian: libopenmpi-dev)",
                                   .run = "it (Debian: libopenmpi3)",
                                   .instead = "",
                                   .global = true};
    many *self = calloc(1, sizeof *self);
    const mpi_module *mpi = self ? module_open(&DEF, error) : NULL;
    if (mpi) {
        self->mpi = mpi;
        self->job = mpi->join(&self->rank, &self->count, &self->threads);
        if (self->job) return self;
    }
    if (mpi || !self) fail(error, DAFT_ERROR_MEMORY, "MPI cannot be started");
    free(self);
    return NULL;
}

int many_rank(const many *self) { return self->rank; }
int many_count(const many *self) { return self->count; }
int many_threads(const many *self) { return self->threads; }

void many_send_own(many *self, int to, int kind, uint8_t *bytes, size_t size)
{
    self->mpi->send_own(self->job, to, kind, bytes, size);
}

void many_send(many *self, int to, int kind, const void *bytes, size_t size)
{
    uint8_t *copy = malloc(size > 0 ? size : 1);
    if (!copy) self->mpi->give_up("out of memory for messages to other processes");
    if (size > 0) memcpy(copy, bytes, size);
    many_send_own(self, to, kind, copy, size);
}

bool many_receive(many *self, many_message *out) { return self->mpi->receive(self->job, out); }

void many_leave(many *self)
{
    if (!self) return;
    while (!self->mpi->leave(self->job)) many_pause();
    free(self);
}

/* ---- the end of a job ---- */

void many_stop_others(many *self)
{
    for (int i = 1; i < many_count(self); i++) many_send(self, i, MANY_STOP, NULL, 0);
}

void many_tell_failure(many *self, const daft_error *error)
{
    char host[64] = "", what[sizeof error->file + sizeof error->message], text[sizeof what + 128];
    gethostname(host, sizeof host - 1);
    int length = snprintf(text, sizeof text, "process %d on %s: %s", many_rank(self), host,
                          daft_error_text(error, what, sizeof what));
    many_send(self, 0, MANY_FAILED, text, (size_t)length);
}

void many_take_failure(const many_message *message, daft_error *error)
{
    fail(error, DAFT_ERROR_IO, "%.*s", (int)message->size, (const char *)message->bytes);
}

static void wait_for_stop(many *self)
{
    for (bool stop = false; !stop;) {
        many_message m = {0};
        if (!many_receive(self, &m)) many_pause();
        stop = m.bytes && m.kind == MANY_STOP;
        free(m.bytes);
    }
}

void many_drop_out(many *self, const daft_error *error)
{
    if (many_rank(self) == 0) {
        many_stop_others(self);
        return;
    }
    many_tell_failure(self, error);
    wait_for_stop(self);
}
