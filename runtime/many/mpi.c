/* daft_mpi.so: messages by MPI. Sends are under way until the library says otherwise, so their bytes are kept in a
 * list.
 */
#include "many/module.h"

#include "common/util.h"

#include <mpi.h>

#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct sending {
    MPI_Request request;
    uint8_t *bytes;
} sending;

struct mpi_job {
    MPI_Request all; /* the barrier before the end, once `leaving` */
    bool leaving;
    sending *sends;
    size_t send_count, send_capacity;
};

/* The processors this process may run on, divided among the processes of its machine where nobody has bound it to some
 * of them. */
static int share_of_processors(void)
{
    MPI_Comm local;
    int here = 1;
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &local);
    MPI_Comm_size(local, &here);
    MPI_Comm_free(&local);
#ifdef __linux__
    cpu_set_t bound;
    if (sched_getaffinity(0, sizeof bound, &bound) == 0 && CPU_COUNT(&bound) < online) return CPU_COUNT(&bound);
#endif
    long threads = online / here;
    return threads < 1 ? 1 : (int)threads;
}

static mpi_job *join(int *rank, int *count, int *threads)
{
    mpi_job *self = calloc(1, sizeof *self);
    int given;
    if (!self || MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &given) != MPI_SUCCESS) {
        free(self);
        return NULL;
    }
    MPI_Comm_rank(MPI_COMM_WORLD, rank);
    MPI_Comm_size(MPI_COMM_WORLD, count);
    *threads = share_of_processors();
    return self;
}

/* Forgets the sends that have left. */
static void reap(mpi_job *self)
{
    size_t kept = 0;
    for (size_t i = 0; i < self->send_count; i++) {
        int gone = 0;
        MPI_Test(&self->sends[i].request, &gone, MPI_STATUS_IGNORE);
        if (gone)
            free(self->sends[i].bytes);
        else
            self->sends[kept++] = self->sends[i];
    }
    self->send_count = kept;
}

static void give_up(const char *why)
{
    fprintf(stderr, "daft: %s\n", why);
    MPI_Abort(MPI_COMM_WORLD, STATUS_BAD_INPUT);
}

static void send_own(mpi_job *self, int to, int kind, uint8_t *bytes, size_t size)
{
    if (self->send_count == self->send_capacity) {
        size_t capacity = self->send_capacity ? 2 * self->send_capacity : 64;
        sending *more = realloc(self->sends, capacity * sizeof *more);
        if (!more) give_up("out of memory for messages to other processes");
        self->sends = more, self->send_capacity = capacity;
    }
    sending *next = &self->sends[self->send_count++];
    next->bytes = bytes;
    MPI_Isend(bytes, (int)size, MPI_BYTE, to, kind, MPI_COMM_WORLD, &next->request);
}

static bool receive(mpi_job *self, many_message *out)
{
    MPI_Message message;
    MPI_Status status;
    int come = 0, size = 0;
    reap(self);
    MPI_Improbe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &come, &message, &status);
    if (!come) return false;
    MPI_Get_count(&status, MPI_BYTE, &size);
    uint8_t *bytes = malloc(size > 0 ? (size_t)size : 1);
    if (!bytes) give_up("out of memory for messages of other processes");
    MPI_Mrecv(bytes, size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
    *out = (many_message){.from = status.MPI_SOURCE, .kind = status.MPI_TAG, .bytes = bytes, .size = (size_t)size};
    return true;
}

/* Nobody wants these any more, but who sent them waits until they have gone. */
static void drop_messages(mpi_job *self)
{
    for (many_message m; receive(self, &m);) free(m.bytes);
}

/* A process that waits in MPI keeps a processor busy: this looks, and the caller sleeps. */
static bool leave(mpi_job *self)
{
    int here = 0;
    drop_messages(self);
    if (!self->leaving && self->send_count == 0) {
        MPI_Ibarrier(MPI_COMM_WORLD, &self->all);
        self->leaving = true;
    }
    if (self->leaving) MPI_Test(&self->all, &here, MPI_STATUS_IGNORE);
    if (!here) return false;
    MPI_Finalize();
    free(self->sends);
    free(self);
    return true;
}

DAFT_API const mpi_module daft_mpi = {
    .join = join, .send_own = send_own, .receive = receive, .leave = leave, .give_up = give_up};
