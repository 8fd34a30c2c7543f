/* A program without MPI: it cannot join others, and says so. */
#include "many/many.h"

#include "common/util.h"

many *many_join(daft_error *error)
{
    fail(error, DAFT_ERROR_ARGUMENT,
         "started by mpirun, but this program was built without MPI: install it (Debian: libopenmpi-dev) and build "
         "again");
    return NULL;
}

int many_rank(const many *self)
{
    (void)self;
    return 0;
}

int many_count(const many *self)
{
    (void)self;
    return 1;
}

int many_threads(const many *self)
{
    (void)self;
    return 0;
}

void many_send(many *self, int to, int kind, const void *bytes, size_t size)
{
    (void)self, (void)to, (void)kind, (void)bytes, (void)size;
}

void many_send_own(many *self, int to, int kind, uint8_t *bytes, size_t size)
{
    (void)self, (void)to, (void)kind, (void)bytes, (void)size;
}

bool many_receive(many *self, many_message *out)
{
    (void)self, (void)out;
    return false;
}

void many_leave(many *self) { (void)self; }
