/* stub: the first part of a game's own program (daft pack --standalone): it unpacks the archive behind it into the
 * user's cache, once, and starts what lies there. A program of its own, linked with the C library and what that needs.
 * Public headers: format.h
 *
 * format: where in the archive the parts are. The archive ends with a comment: the mark and a SHA-256 in hexadecimal
 * digits, of all bytes of the file before the archive's end record. */
#ifndef RUNTIME_STUB_FORMAT_H
#define RUNTIME_STUB_FORMAT_H

#define STUB_MARK      "daft standalone, SHA-256 "
#define STUB_PROGRAM   "daft"
#define STUB_LIBRARIES "lib/"
#define STUB_GAMES     "games/" /* one file */

enum { STUB_DIGITS = 64, STUB_COMMENT = sizeof STUB_MARK - 1 + STUB_DIGITS };

/* What the environment of the program that is started has: the folder, and what LD_LIBRARY_PATH was before. */
#define STUB_HOME         "DAFT_HOME"
#define STUB_LIBRARY_PATH "DAFT_LIBRARY_PATH"

#endif
