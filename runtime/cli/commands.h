/* commands: one function for each `daft NAME`. argv[0] is the command's name; the result is the exit status. */
#ifndef RUNTIME_CLI_COMMANDS_H
#define RUNTIME_CLI_COMMANDS_H

#include "hud/canvas.h"
#include "files/home.h"

int command_play(int argc, char **argv);
int command_render(int argc, char **argv);
int command_view(int argc, char **argv);
int command_check(int argc, char **argv);
int command_video(int argc, char **argv);
int command_scan(int argc, char **argv);
int command_pack(int argc, char **argv);
int command_new(int argc, char **argv);
int command_test_game(int argc, char **argv);
int command_cost(int argc, char **argv);
int command_bench(int argc, char **argv);
int command_fields(int argc, char **argv); /* daft help fields */

/* main() without the process: chooses the command and runs it. */
int run_program(int argc, char **argv);

/* Opens an engine, which prints its warnings on stderr unless def->warn takes them. NULL with the message on stderr. */
daft_engine *open_engine(const daft_engine_def *wanted);
/* Likewise, but says nothing: fills *error. */
daft_engine *try_engine(const daft_engine_def *wanted, daft_error *error);

/* Opens the font of all text on the screen. NULL with the message in *error. */
font *open_font(const home *where, daft_error *error);

#endif
