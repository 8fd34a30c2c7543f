/* Finds and opens modules. */
#include "files/module.h"

#include "files/home.h"

#include <dlfcn.h>
#include <string.h>

/* Beside the program, as it is built; else where it is installed. */
bool module_find(const char *file, char *out, size_t size)
{
    static const char *const FOLDERS[] = {"", "/" DAFT_MODULES};
    char folder[PATH_SIZE];
    if (!home_program_folder(folder, sizeof folder)) return false;
    for (size_t i = 0; i < COUNT_OF(FOLDERS); i++) {
        const int length = snprintf(out, size, "%s%s/%s", folder, FOLDERS[i], file);
        if (length > 0 && (size_t)length < size && path_is_file(out)) return true;
    }
    return false;
}

const void *module_open(const module_def *def, daft_error *error)
{
    char path[2 * PATH_SIZE], name[64];
    snprintf(name, sizeof name, "%s.so", def->name);
    if (!module_find(name, path, sizeof path)) {
        fail(error, DAFT_ERROR_UNSUPPORTED,
             "%s takes %s, and this program was built without %s (there is no %s): install %s and build again%s",
             def->purpose, def->library, def->library, name, def->build, def->instead);
        return NULL;
    }
    void *module = dlopen(path, RTLD_LAZY | (def->global ? RTLD_GLOBAL : RTLD_LOCAL));
    const void *found = module ? dlsym(module, def->name) : NULL;
    if (found) return found;
    const char *why = dlerror();
    fail(error, DAFT_ERROR_UNSUPPORTED, "%s takes %s, which cannot be loaded: install %s%s (%s)", def->purpose,
         def->library, def->run, def->instead, why ? why : def->name);
    return NULL;
}
