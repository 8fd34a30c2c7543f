/* Where the build has found no Assimp. */
#include "geometry/foreign/foreign.h"

bool daft_foreign_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const void *bytes,
                        size_t size, const daft_log *log, daft_obj *out, daft_error *error)
{
    (void)allocator, (void)files, (void)bytes, (void)size, (void)log, (void)out;
    return daft_fail_at(error, DAFT_ERROR_UNSUPPORTED, path, 0, 0,
                        "this build reads OBJ meshes only: install libassimp-dev (Debian) and build again");
}
