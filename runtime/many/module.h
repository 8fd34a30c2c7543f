/* module: what the program takes from daft_mpi.so, which is linked with MPI. */
#ifndef RUNTIME_MANY_MODULE_H
#define RUNTIME_MANY_MODULE_H

#include "many/many.h"

typedef struct mpi_job mpi_job;

typedef struct mpi_module {
    /* NULL: MPI cannot be started. Otherwise sets what many_rank, many_count and many_threads say. */
    mpi_job *(*join)(int *rank, int *count, int *threads);
    /* As in many.h. */
    void (*send_own)(mpi_job *self, int to, int kind, uint8_t *bytes, size_t size);
    bool (*receive)(mpi_job *self, many_message *out);
    /* One step of many_leave. True: all have left, and `self` is freed; else it wants to be called again. */
    bool (*leave)(mpi_job *self);
    /* Says why, and ends all processes. */
    void (*give_up)(const char *why);
} mpi_module;

extern const mpi_module daft_mpi;

#endif
