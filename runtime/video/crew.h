/* crew: several processes make one film.
 *
 * Process 0 hands out single frames (many/share.h). The process that opens a clip encodes it; whoever helps with it
 * sends the pixels there. Finished clips go to process 0, which writes them and puts the film together. Raw frames all
 * go to one process, which must be 0; numbered pictures are written by who drew them, into a folder that all machines
 * share. So no process has all pictures, and the bytes are those of a film made by one.
 */
#ifndef RUNTIME_VIDEO_CREW_H
#define RUNTIME_VIDEO_CREW_H

#include "many/many.h"
#include "video/film.h"

/* In process 0: true once the film is there, else false with the message, which says which process it came from. In
 * the others: true once they are no longer needed. */
bool crew_make(film *f, many *all, daft_error *error);

#endif
