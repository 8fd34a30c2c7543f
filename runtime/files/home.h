/* files: the program's folders and games (home.h), a game's files (source.h), packed games (pack.h, archive.h) and
 * their hash (sha256.h), what games keep (saves.h), whether their files change (watch.h), and the program's modules
 * (module.h) and libraries (libraries.h). Public headers: archive.h content.h home.h libraries.h module.h source.h
 * pack.h sha256.h saves.h watch.h
 *
 * home: finds the program's own folders games/, assets/, scripts/ and templates/, and the games in games/.
 * Search order: $DAFT_HOME, ../share/daft beside the program, then each folder above the program. */
#ifndef RUNTIME_FILES_HOME_H
#define RUNTIME_FILES_HOME_H

#include "common/util.h"

typedef struct home {
    char games[PATH_SIZE], assets[PATH_SIZE], scripts[PATH_SIZE], templates[PATH_SIZE];
} home;

bool home_find(home *out, daft_error *error);
/* The folder of the running program. */
bool home_program_folder(char *out, size_t size);

/* The user's own folder "daft", by the variable of the environment or below the home folder, made where it is missing.
 * False: there is none. */
bool home_user_folder(const char *variable, const char *below_home, char *out, size_t size);

typedef struct game_info {
    char name[128];         /* of its folder */
    char folder[PATH_SIZE]; /* holds main.lua; or the file that the game is packed in */
    bool packed;
    char title[128];
    char description[512];
} game_info;

/* `name`: a folder with a main.lua, a packed game (.daft), or the name of one in games/. The message suggests near
 * names. */
bool home_find_game(const home *where, const char *name, game_info *out, daft_error *error);
/* The games in games/, sorted by name; freed with free(). NULL and 0 when there are none. */
game_info *home_list_games(const home *where, size_t *count);

#endif
