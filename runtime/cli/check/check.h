/* check: the parts of `daft check`, and the problems it found.
 * Each problem is one line on stdout, "file:line:column: error|warning|note: text", printed once however often it
 * occurs.
 * Public headers: none */
#ifndef RUNTIME_CLI_CHECK_CHECK_H
#define RUNTIME_CLI_CHECK_CHECK_H

#include "hud/canvas.h"
#include "files/source.h"
#include "common/util.h"

#include <stdio.h>

typedef struct checker {
    daft_engine *engine;
    const char *path; /* the file being checked: the place of problems that name none */
    home where;       /* filled before the first game */
    font *face;
    bool has_home;
    game_source game; /* of the game whose folder is being checked; no files: none */
    size_t files, errors, warnings, notes;
    draft_file json;     /* its file is NULL where no report is wanted */
    struct names *names; /* that the scripts of this game use; or NULL */
    char **own;          /* the game's files */
    size_t own_count, own_capacity;
    uint64_t *printed; /* hashes of the lines printed */
    size_t printed_count, printed_capacity;
} checker;

/* ---- report.c ---- */

void check_add(checker *c, daft_severity severity, const char *file, int line, int column, const char *format, ...)
    __attribute__((format(printf, 6, 7)));
/* A daft_problem_callback; user: the checker. */
void check_problem(void *user, daft_severity severity, const daft_error *problem);
/* A daft_warning_callback; user: the checker. */
void check_warning(void *user, const daft_error *warning);
bool check_json_open(checker *c, daft_error *error);
bool check_json_close(checker *c, const char *path, daft_error *error);

/* ---- lua.c ---- */

/* Checks syntax, required modules and named assets. `folder` is the game's. */
void check_lua(checker *c, const char *path, const char *folder);

/* Takes what a module of the library gives its tables. */
void check_library(checker *c, const char *path);

/* ---- unused.c ---- */

/* Notes files of c->own that nothing names. c->path is the game's folder. */
void check_unused(checker *c);

/* ---- game.c ---- */

bool check_need_home(checker *c);
void check_recording(checker *c, const char *path, const char *game);
/* Runs a game for one second without a window. */
void check_run_game(checker *c, const game_info *info);

#endif
