/* The menu that Esc opens in every game: what the player may set, start again, leave. It takes events and draws; what
 * is chosen the session does. The game stands still meanwhile and knows nothing of it. */
#ifndef RUNTIME_GAME_PAUSE_H
#define RUNTIME_GAME_PAUSE_H

#include "common/quality.h"
#include "files/saves.h"
#include "hud/canvas.h"
#include "platform/actions.h"

/* The player's, for all games. */
typedef struct player_settings {
    int pace;   /* one of those of pause_target_ms */
    int volume; /* 0 to 10 */
    bool full_screen;
    int picture; /* 0: as the game asks; else 1 more than the daft_preset */
} player_settings;

typedef enum pause_wish { PAUSE_STAY, PAUSE_CONTINUE, PAUSE_SET, PAUSE_KEYS, PAUSE_RESTART, PAUSE_LEAVE } pause_wish;

typedef struct pause_menu {
    bool open;
    bool controls;     /* the page of keys is shown, not the first one */
    int chosen, first; /* rows; the one on top */
    int waits; /* for the player to move what is to stand for this of the game's (key_map); below 0: for nothing */
    bool waits_stick;           /* for a whole stick, whose positive half `waits` is */
    float pushed[INPUT_STICKS]; /* as the player holds them */
    player_settings *settings;
    const actions *actions; /* the game's */
    key_map *keys;
    platform *keyboard;     /* the player's; or NULL */
    float mouse_x, mouse_y; /* HUD units */
    float hud_width;        /* of the last picture */
} pause_menu;

void pause_open(pause_menu *self);
/* PAUSE_SET: a setting has changed; PAUSE_KEYS: the keys have. */
pause_wish pause_take(pause_menu *self, const input_event *event);
void pause_draw(pause_menu *self, const canvas *over, font *face, const char *title);

/* What a frame may take: milliseconds, 0: any, below 0: as the game says. */
double pause_target_ms(const player_settings *settings);

/* The quality that the player wants, else `asked`. */
quality_wish pause_quality(const player_settings *settings, const quality_wish *asked);

/* Settings that cannot be read are the usual ones. `store` may be NULL. */
player_settings settings_load(saves *store);
void settings_save(saves *store, const player_settings *settings);

#endif
