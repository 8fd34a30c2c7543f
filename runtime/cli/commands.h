/* commands: what `daft NAME` does. Each takes its arguments with its own name first and returns the exit status. */
#ifndef RUNTIME_CLI_COMMANDS_H
#define RUNTIME_CLI_COMMANDS_H

#include "hud/canvas.h"
#include "common/home.h"

int command_play(int argc, char **argv);
int command_render(int argc, char **argv);
int command_check(int argc, char **argv);
int command_bench(int argc, char **argv);

/* The whole program, without the process around it. */
int run_program(int argc, char **argv);

/* An engine whose warnings go to stderr. NULL with the message on stderr. */
daft_engine *open_engine(int threads, const char *isa, daft_accel accel);

/* The font of everything on the screen. NULL with the message in *error. */
font *open_font(const home *where, daft_error *error);

#endif
