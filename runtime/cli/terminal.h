/* terminal: a picture in a terminal: by the graphics protocol of kitty, as sixels, or as half blocks of text. */
#ifndef RUNTIME_CLI_TERMINAL_H
#define RUNTIME_CLI_TERMINAL_H

#include "cli/cli.h"

#include <stdint.h>

typedef enum terminal_kind { TERMINAL_KITTY, TERMINAL_SIXEL, TERMINAL_BLOCKS, TERMINAL_BLOCKS_256 } terminal_kind;

/* What the terminal on standard output can, the best first. A terminal that does not say is asked, and has 0.2 s to
 * answer. The variable DAFT_TERM (kitty, sixel, blocks, blocks256) decides where it is set. */
terminal_kind terminal_find(void);
/* The largest picture of 16:9 that fits, in pixels of this kind. */
cli_size terminal_size(terminal_kind kind);
/* Writes the picture, RGBA, on standard output, and a line's end. */
void terminal_show(terminal_kind kind, const uint8_t *pixels, int width, int height);

#endif
