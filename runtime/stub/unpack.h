/* unpack: a packed program's files in a folder of the disk. */
#ifndef RUNTIME_STUB_UNPACK_H
#define RUNTIME_STUB_UNPACK_H

#include "common/util.h"
#include "files/pack.h"

/* Makes the folder TOP/NAME with all files of the pack, where it is not there as a whole: beside it first, then by its
 * name, so that it is never there in parts, whatever kills this process or runs beside it. What a process that was
 * killed has left is removed. */
bool unpack_once(pack *from, const char *top, const char *name, daft_error *error);
/* Whether TOP/NAME is there: all files, of their sizes. */
bool unpack_is_there(const pack *from, const char *top, const char *name);
/* All files into a folder that is empty. */
bool unpack_into(pack *from, const char *folder, daft_error *error);
/* Removes the folder and all that is in it. */
void unpack_remove(const char *folder);

#endif
