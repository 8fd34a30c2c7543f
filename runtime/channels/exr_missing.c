/* EXR files of a program that was built without OpenEXR's C library. */
#include "channels/exr.h"

#include "common/util.h"

bool exr_write(const char *path, const exr_channel *channels, int count, int width, int height, daft_error *error)
{
    (void)channels, (void)count, (void)width, (void)height;
    return fail_at(
        error, path, 0, 0,
        "this program was built without OpenEXR: install libopenexr-dev and build again, or write a .png and "
        "--aov beside it");
}
