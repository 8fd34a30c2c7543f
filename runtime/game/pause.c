/* A list of rows, by keyboard, mouse or gamepad. */
#include "game/pause.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

enum { CONTINUE, PACE, VOLUME, FULL_SCREEN, RESTART, LEAVE, ROWS };

static const float ROW = 58, WIDTH = 560, TOP = 232;
static const canvas_color WHITE = {245, 247, 250, 255}, GREY = {176, 188, 206, 255}, SHADE = {8, 12, 22, 150},
                          DARK = {12, 17, 30, 215}, CHOSEN = {64, 132, 255, 235};

static const struct {
    const char *name;
    double target_ms;
} PACES[] = {{"as the game asks", -1},
             {"120 a second", 1000.0 / 120},
             {"60 a second", 1000.0 / 60},
             {"30 a second", 1000.0 / 30},
             {"always exact", 0}};

double pause_target_ms(const player_settings *settings) { return PACES[settings->pace].target_ms; }

/* ---- settings ---- */

static const player_settings USUAL = {.volume = 8};

player_settings settings_load(saves *store)
{
    player_settings s;
    const char *text = NULL;
    daft_error error;
    int full;
    if (!store || !saves_get(store, "settings", &text, &error) || !text) return USUAL;
    if (sscanf(text, "pace %d volume %d full_screen %d", &s.pace, &s.volume, &full) != 3) return USUAL;
    s.full_screen = full == 1;
    const bool fits = s.pace >= 0 && s.pace < (int)COUNT_OF(PACES) && s.volume >= 0 && s.volume <= 10;
    return fits ? s : USUAL;
}

void settings_save(saves *store, const player_settings *s)
{
    char text[80];
    daft_error error;
    snprintf(text, sizeof text, "pace %d volume %d full_screen %d", s->pace, s->volume, s->full_screen);
    if (store && !saves_put(store, "settings", text, &error)) report(&error);
}

/* ---- choosing ---- */

void pause_open(pause_menu *self) { self->open = true, self->chosen = CONTINUE; }

static float left_of(const pause_menu *self) { return (self->hud_width - WIDTH) / 2; }

/* -1: none. */
static int row_under_mouse(const pause_menu *self)
{
    const float x = self->mouse_x - left_of(self), y = self->mouse_y - TOP;
    return x >= 0 && x < WIDTH && y >= 0 && y < ROW * ROWS ? (int)(y / ROW) : -1;
}

/* The chosen setting's next value, or the one before; round and round where a click or Return cannot go back. */
static pause_wish change(pause_menu *self, int by, bool round)
{
    player_settings *s = self->settings, before = *s;
    const int paces = (int)COUNT_OF(PACES);
    if (self->chosen == PACE) s->pace = (s->pace + by + paces) % paces;
    if (self->chosen == VOLUME) {
        s->volume += by;
        if (s->volume > 10) s->volume = round ? 0 : 10;
        if (s->volume < 0) s->volume = 0;
    }
    if (self->chosen == FULL_SCREEN) s->full_screen = !s->full_screen;
    return memcmp(s, &before, sizeof before) == 0 ? PAUSE_STAY : PAUSE_SET;
}

static pause_wish pick(pause_menu *self)
{
    switch (self->chosen) {
    case CONTINUE: self->open = false; return PAUSE_CONTINUE;
    case RESTART: self->open = false; return PAUSE_RESTART;
    case LEAVE: return PAUSE_LEAVE;
    default: return change(self, 1, true);
    }
}

static bool is_one_of(const char *key, const char *const *names)
{
    for (; *names; names++)
        if (strcmp(key, *names) == 0) return true;
    return false;
}

static pause_wish take_key(pause_menu *self, const char *key)
{
    static const char *const BACK[] = {"escape", "pad b", "pad start", NULL}, *const UP[] = {"up", "pad up", "w", NULL},
                             *const DOWN[] = {"down", "pad down", "s", "tab", NULL},
                             *const LEFT[] = {"left", "pad left", "a", NULL},
                             *const RIGHT[] = {"right", "pad right", "d", NULL},
                             *const PICK[] = {"return", "keypad enter", "space", "pad a", NULL};
    if (is_one_of(key, UP)) self->chosen = (self->chosen + ROWS - 1) % ROWS;
    if (is_one_of(key, DOWN)) self->chosen = (self->chosen + 1) % ROWS;
    if (is_one_of(key, LEFT)) return change(self, -1, false);
    if (is_one_of(key, RIGHT)) return change(self, 1, false);
    if (is_one_of(key, PICK)) return pick(self);
    if (strcmp(key, "mouse1") == 0 && row_under_mouse(self) >= 0) {
        self->chosen = row_under_mouse(self);
        return pick(self);
    }
    if (!is_one_of(key, BACK)) return PAUSE_STAY;
    self->open = false;
    return PAUSE_CONTINUE;
}

pause_wish pause_take(pause_menu *self, const input_event *event)
{
    if (event->kind == INPUT_MOVE) {
        self->mouse_x = event->x, self->mouse_y = event->y;
        if (row_under_mouse(self) >= 0) self->chosen = row_under_mouse(self);
    }
    if (event->kind != INPUT_KEY || !event->down) return PAUSE_STAY;
    return take_key(self, input_key_name(event->key));
}

/* ---- drawing ---- */

static const char *value_of(const player_settings *s, int row, char out[16])
{
    switch (row) {
    case PACE: return PACES[s->pace].name;
    case VOLUME: snprintf(out, 16, s->volume ? "%d %%" : "off", 10 * s->volume); return out;
    case FULL_SCREEN: return s->full_screen ? "on" : "off";
    default: return "";
    }
}

void pause_draw(pause_menu *self, const canvas *over, font *face, const char *title)
{
    static const char *const NAMES[ROWS] = {"Continue", "Frames", "Sound", "Full screen", "Start again", "Leave"};
    char text[16];
    self->hud_width = canvas_hud_width(over);
    const float left = left_of(self), middle = self->hud_width / 2;
    canvas_rect(over, 0, 0, self->hud_width, CANVAS_HEIGHT, SHADE);
    text_style style = {56, WHITE, TEXT_CENTER, true};
    text_draw(over, face, title, middle, TOP - 110, &style);
    for (int row = 0; row < ROWS; row++) {
        const float y = TOP + ROW * (float)row;
        const bool chosen = row == self->chosen;
        canvas_rect(over, left, y, WIDTH, ROW - 6, chosen ? CHOSEN : DARK);
        style = (text_style){26, WHITE, TEXT_LEFT, false};
        text_draw(over, face, NAMES[row], left + 24, y + 12, &style);
        style.color = chosen ? WHITE : GREY, style.align = TEXT_RIGHT;
        text_draw(over, face, value_of(self->settings, row, text), left + WIDTH - 24, y + 12, &style);
    }
    style = (text_style){18, GREY, TEXT_CENTER, true};
    text_draw(over, face, "↑ ↓  choose      ← →  change      Return  do it      Esc  continue", middle,
              TOP + ROW * ROWS + 20, &style);
}
