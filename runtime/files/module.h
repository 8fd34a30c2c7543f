/* module: parts of the program that lie in files of their own, NAME.so, because the libraries that they need take
 * longer to load than the program takes to start. The files are beside the program, or where `cmake --install` puts
 * them.
 *
 * Each exports one variable, a const struct of functions. Of the program it uses daft.h alone, which the program
 * exports; of the runtime it has what it needs built in, as long as that keeps no state. */
#ifndef RUNTIME_FILES_MODULE_H
#define RUNTIME_FILES_MODULE_H

#include "daft.h"

typedef struct module_def {
    const char *name;    /* daft_film: the file's, without .so, and the variable's */
    const char *purpose; /* for messages: what takes it */
    const char *library; /* what it takes: FFmpeg */
    const char *build;   /* packages that a build takes */
    const char *run;     /* packages that it takes where it was built elsewhere */
    const char *instead; /* what there is without it: ", or choose numbered .png"; or nothing */
    bool global;         /* its libraries load more, which look for theirs in the process */
} module_def;

/* Where such a file is. False: nowhere. */
bool module_find(const char *file, char *out, size_t size);
/* The struct that the module exports. NULL: the message names what is missing. It stays loaded until the program ends:
 * opening it again costs nothing. Any thread. */
const void *module_open(const module_def *def, daft_error *error);

#endif
