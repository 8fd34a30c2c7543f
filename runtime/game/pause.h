/* The menu that Esc opens in every game: what the player may set, start again, leave. It takes events and draws; what
 * is chosen the session does. The game stands still meanwhile and knows nothing of it. */
#ifndef RUNTIME_GAME_PAUSE_H
#define RUNTIME_GAME_PAUSE_H

#include "files/saves.h"
#include "hud/canvas.h"
#include "platform/input.h"

/* The player's, for all games. */
typedef struct player_settings {
    int pace;   /* one of those of pause_target_ms */
    int volume; /* 0 to 10 */
    bool full_screen;
} player_settings;

typedef enum pause_wish { PAUSE_STAY, PAUSE_CONTINUE, PAUSE_SET, PAUSE_RESTART, PAUSE_LEAVE } pause_wish;

typedef struct pause_menu {
    bool open;
    int chosen;
    player_settings *settings;
    float mouse_x, mouse_y; /* HUD units */
    float hud_width;        /* of the last picture */
} pause_menu;

void pause_open(pause_menu *self);
/* PAUSE_SET: a setting has changed. */
pause_wish pause_take(pause_menu *self, const input_event *event);
void pause_draw(pause_menu *self, const canvas *over, font *face, const char *title);

/* What a frame may take: milliseconds, 0: any, below 0: as the game says. */
double pause_target_ms(const player_settings *settings);

/* Settings that cannot be read are the usual ones. `store` may be NULL. */
player_settings settings_load(saves *store);
void settings_save(saves *store, const player_settings *settings);

#endif
