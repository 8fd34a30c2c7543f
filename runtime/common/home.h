/* home: where the program's own folders are: games/, assets/ and scripts/; and which games there are.
 * They are looked for in $DAFT_HOME, then in each folder above the program, then in ../share/daft beside it. */
#ifndef RUNTIME_COMMON_HOME_H
#define RUNTIME_COMMON_HOME_H

#include "common/util.h"

typedef struct home {
    char games[PATH_SIZE], assets[PATH_SIZE], scripts[PATH_SIZE];
} home;

bool home_find(home *out, daft_error *error);
/* The folder of the running program. */
bool home_program_folder(char *out, size_t size);

typedef struct game_info {
    char name[128];         /* of its folder */
    char folder[PATH_SIZE]; /* holds main.lua */
    char title[128];
    char description[512];
} game_info;

/* A folder with a main.lua, or the name of one in games/. The message names near misses. */
bool home_find_game(const home *where, const char *name, game_info *out, daft_error *error);
/* The games in games/, by name; freed with free(). NULL and 0 when there is none. */
game_info *home_list_games(const home *where, size_t *count);

#endif
