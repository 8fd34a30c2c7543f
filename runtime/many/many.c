/* What needs nothing of MPI: whether mpirun has started this process, and as which; how a job ends. */
#include "many/many.h"

#include "common/util.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

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
