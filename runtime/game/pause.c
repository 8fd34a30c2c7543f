/* A list of rows, by keyboard, mouse or gamepad. */
#include "game/pause.h"

#include "common/util.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The first page, then what the page of keys has beside them. */
enum { CONTINUE, PICTURE, PACE, VOLUME, FULL_SCREEN, CONTROLS, RESTART, LEAVE, KEY, KEYS_AS_AT_FIRST, BACK };
enum { VISIBLE = 8 };

static const float ROW = 58, WIDTH = 560, TOP = 190;
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

static const char *const PICTURES[] = {"as the game asks", "draft", "game", "high", "reference"};

quality_wish pause_quality(const player_settings *settings, const quality_wish *asked)
{
    quality_wish wish = *asked;
    if (settings->picture > 0) wish.preset = (daft_preset)(settings->picture - 1);
    return wish;
}

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
    s.picture = 0; /* files of before have none */
    if (sscanf(text, "pace %d volume %d full_screen %d picture %d", &s.pace, &s.volume, &full, &s.picture) < 3)
        return USUAL;
    s.full_screen = full == 1;
    const bool fits = s.pace >= 0 && s.pace < (int)COUNT_OF(PACES) && s.volume >= 0 && s.volume <= 10 &&
                      s.picture >= 0 && s.picture < (int)COUNT_OF(PICTURES);
    return fits ? s : USUAL;
}

void settings_save(saves *store, const player_settings *s)
{
    char text[80];
    daft_error error;
    snprintf(text, sizeof text, "pace %d volume %d full_screen %d picture %d", s->pace, s->volume, s->full_screen,
             s->picture);
    if (store && !saves_put(store, "settings", text, &error)) report(&error);
}

/* ---- rows ---- */

typedef struct pause_row {
    int kind;
    const action *what; /* KEY */
    const action_input *input;
} pause_row;

/* The actions' inputs, one by one; false: there are fewer. */
static bool find_input(const actions *all, int which, pause_row *out)
{
    for (int i = 0; i < all->count; i++) {
        const action *a = &all->list[i];
        if (which < a->count) {
            *out = (pause_row){KEY, a, &a->inputs[which]};
            return true;
        }
        which -= a->count;
    }
    return false;
}

static int count_keys(const pause_menu *self)
{
    int count = 0;
    for (int i = 0; self->actions && i < self->actions->count; i++) count += self->actions->list[i].count;
    return count;
}

static int count_rows(const pause_menu *self)
{
    const int keys = count_keys(self);
    return self->controls ? keys + 2 : keys > 0 ? LEAVE + 1 : LEAVE;
}

static pause_row row_at(const pause_menu *self, int i)
{
    const int keys = count_keys(self);
    pause_row row = {0};
    if (!self->controls) return (pause_row){keys == 0 && i >= CONTROLS ? i + 1 : i, NULL, NULL};
    if (i < keys && find_input(self->actions, i, &row)) return row;
    return (pause_row){i == keys ? KEYS_AS_AT_FIRST : BACK, NULL, NULL};
}

static void choose(pause_menu *self, int row)
{
    const int rows = count_rows(self);
    self->chosen = (row + rows) % rows;
    if (self->chosen < self->first) self->first = self->chosen;
    if (self->chosen >= self->first + VISIBLE) self->first = self->chosen - VISIBLE + 1;
}

static void open_page(pause_menu *self, bool controls, int row)
{
    self->controls = controls, self->first = 0, self->waits = -1;
    choose(self, row);
}

/* ---- choosing ---- */

void pause_open(pause_menu *self)
{
    self->open = true;
    memset(self->pushed, 0, sizeof self->pushed);
    open_page(self, false, CONTINUE);
}

static float left_of(const pause_menu *self) { return (self->hud_width - WIDTH) / 2; }

static int visible_rows(const pause_menu *self)
{
    const int rows = count_rows(self);
    return rows < VISIBLE ? rows : VISIBLE;
}

/* -1: none. */
static int row_under_mouse(const pause_menu *self)
{
    const float x = self->mouse_x - left_of(self), y = self->mouse_y - TOP;
    const bool over = x >= 0 && x < WIDTH && y >= 0 && y < ROW * (float)visible_rows(self);
    return over ? self->first + (int)(y / ROW) : -1;
}

/* The chosen setting's next value, or the one before; round and round where a click or Return cannot go back. */
static pause_wish change(pause_menu *self, int by, bool round)
{
    player_settings *s = self->settings, before = *s;
    const int paces = (int)COUNT_OF(PACES), pictures = (int)COUNT_OF(PICTURES), kind = row_at(self, self->chosen).kind;
    if (kind == PACE) s->pace = (s->pace + by + paces) % paces;
    if (kind == PICTURE) s->picture = (s->picture + by + pictures) % pictures;
    if (kind == VOLUME) {
        s->volume += by;
        if (s->volume > 10) s->volume = round ? 0 : 10;
        if (s->volume < 0) s->volume = 0;
    }
    if (kind == FULL_SCREEN) s->full_screen = !s->full_screen;
    const bool same = s->pace == before.pace && s->volume == before.volume && s->picture == before.picture &&
                      s->full_screen == before.full_screen;
    return same ? PAUSE_STAY : PAUSE_SET;
}

static pause_wish leave_page(pause_menu *self)
{
    if (self->controls) {
        open_page(self, false, CONTROLS);
        return PAUSE_STAY;
    }
    self->open = false;
    return PAUSE_CONTINUE;
}

static pause_wish pick(pause_menu *self)
{
    const pause_row row = row_at(self, self->chosen);
    switch (row.kind) {
    case CONTINUE:
    case BACK: return leave_page(self);
    case RESTART: self->open = false; return PAUSE_RESTART;
    case LEAVE: return PAUSE_LEAVE;
    case CONTROLS: open_page(self, true, 0); return PAUSE_STAY;
    case KEY: self->waits = key_map_of(row.input), self->waits_stick = key_map_is_whole(row.input); return PAUSE_STAY;
    case KEYS_AS_AT_FIRST: key_map_reset(self->keys); return PAUSE_KEYS;
    default: return change(self, 1, true);
    }
}

static bool is_one_of(const char *key, const char *const *names)
{
    for (; *names; names++)
        if (strcmp(key, *names) == 0) return true;
    return false;
}

/* Some keys are the program's own. */
static pause_wish take_new_key(pause_menu *self, int key)
{
    static const char *const OURS[] = {"f1",  "f2",  "f3",        "f4",        "f5", "f6",
                                       "f11", "f12", "pad start", "pad guide", NULL};
    const char *name = input_key_name(key);
    if (strcmp(name, "escape") == 0) self->waits = -1;
    if (self->waits < 0 || self->waits_stick || is_one_of(name, OURS)) return PAUSE_STAY;
    key_map_set(self->keys, self->waits, key);
    self->waits = -1;
    return PAUSE_KEYS;
}

/* From the middle to well over half of its way. A trigger stands for no whole stick. */
static pause_wish take_new_stick(pause_menu *self, int stick, float before, float now)
{
    const float far = 0.6f;
    const action_input moved = {.stick = true, .index = stick};
    if (fabsf(before) >= far || fabsf(now) < far) return PAUSE_STAY;
    if (!self->waits_stick)
        key_map_set(self->keys, self->waits, key_map_half(stick, now < 0));
    else if (key_map_is_whole(&moved))
        key_map_set_stick(self->keys, key_map_stick(self->waits), key_map_half(stick, now < 0));
    else
        return PAUSE_STAY;
    self->waits = -1;
    return PAUSE_KEYS;
}

static pause_wish take_stick(pause_menu *self, int stick, float now)
{
    const float before = self->pushed[stick];
    self->pushed[stick] = now;
    return self->waits >= 0 ? take_new_stick(self, stick, before, now) : PAUSE_STAY;
}

static pause_wish take_key(pause_menu *self, const char *key)
{
    static const char
        *const ESCAPE[] = {"escape", "pad b", "pad start", NULL},
               *const UP[] = {"up", "pad up", "w", NULL}, *const DOWN[] = {"down", "pad down", "s", "tab", NULL},
               *const LEFT[] = {"left", "pad left", "a", NULL}, *const RIGHT[] = {"right", "pad right", "d", NULL},
               *const PICK[] = {"return", "keypad enter", "space", "pad a", NULL};
    if (is_one_of(key, UP)) choose(self, self->chosen - 1);
    if (is_one_of(key, DOWN)) choose(self, self->chosen + 1);
    if (is_one_of(key, LEFT)) return change(self, -1, false);
    if (is_one_of(key, RIGHT)) return change(self, 1, false);
    if (is_one_of(key, PICK)) return pick(self);
    if (strcmp(key, "mouse1") == 0 && row_under_mouse(self) >= 0) {
        choose(self, row_under_mouse(self));
        return pick(self);
    }
    return is_one_of(key, ESCAPE) ? leave_page(self) : PAUSE_STAY;
}

pause_wish pause_take(pause_menu *self, const input_event *event)
{
    if (event->kind == INPUT_MOVE) {
        self->mouse_x = event->x, self->mouse_y = event->y;
        if (row_under_mouse(self) >= 0 && self->waits < 0) choose(self, row_under_mouse(self));
    }
    if (event->kind == INPUT_WHEEL && self->waits < 0 && event->y != 0)
        choose(self, self->chosen - (event->y > 0 ? 1 : -1));
    if (event->kind == INPUT_STICK) return take_stick(self, event->key, event->x);
    if (event->kind != INPUT_KEY || !event->down) return PAUSE_STAY;
    return self->waits >= 0 ? take_new_key(self, event->key) : take_key(self, input_key_name(event->key));
}

/* ---- drawing ---- */

enum { VALUE = KEY_MAP_NAME };

static const char *shown_input(const pause_menu *self, const action_input *in, char out[VALUE])
{
    const int asked = key_map_of(in), shown = key_map_shown(self->keys, asked);
    const bool whole = key_map_is_whole(in);
    if (self->waits == asked && self->waits_stick == whole)
        return !whole ? "press a key, push a stick" : in->index % 2 ? "push a stick down" : "push a stick to the right";
    return shown < 0 ? "nothing" : key_map_label(self->keyboard, shown, whole, out);
}

static const char *value_of(const pause_menu *self, const pause_row *row, char out[VALUE])
{
    const player_settings *s = self->settings;
    switch (row->kind) {
    case PICTURE: return PICTURES[s->picture];
    case PACE: return PACES[s->pace].name;
    case VOLUME: snprintf(out, VALUE, s->volume ? "%d %%" : "off", 10 * s->volume); return out;
    case FULL_SCREEN: return s->full_screen ? "on" : "off";
    case KEY: return shown_input(self, row->input, out);
    default: return "";
    }
}

/* What it does, and which way, where others go the other way. */
static const char *name_of_action(const action *a, const action_input *in, char out[VALUE])
{
    bool both = false;
    for (int i = 0; i < a->count; i++) both = both || a->inputs[i].sign <= 0;
    snprintf(out, VALUE, "%s%s", a->name, !both || in->sign == 0 ? "" : in->sign > 0 ? " +" : " -");
    return out;
}

static const char *name_of(const pause_row *row, char out[VALUE])
{
    static const char *const NAMES[] = {"Continue", "Picture",     "Frames", "Sound", "Full screen",
                                        "Controls", "Start again", "Leave",  "",      "Keys as at first",
                                        "Back"};
    return row->kind == KEY ? name_of_action(row->what, row->input, out) : NAMES[row->kind];
}

static void draw_row(const pause_menu *self, const canvas *over, font *face, int i)
{
    char text[VALUE];
    const float left = left_of(self), y = TOP + ROW * (float)(i - self->first);
    const bool chosen = i == self->chosen;
    const pause_row row = row_at(self, i);
    canvas_rect(over, left, y, WIDTH, ROW - 6, chosen ? CHOSEN : DARK);
    text_style style = {26, WHITE, TEXT_LEFT, false};
    text_draw(over, face, name_of(&row, text), left + 24, y + 12, &style);
    style.color = chosen ? WHITE : GREY, style.align = TEXT_RIGHT;
    text_draw(over, face, value_of(self, &row, text), left + WIDTH - 24, y + 12, &style);
}

void pause_draw(pause_menu *self, const canvas *over, font *face, const char *title)
{
    self->hud_width = canvas_hud_width(over);
    const int rows = count_rows(self), shown = visible_rows(self);
    const float middle = self->hud_width / 2;
    if (self->chosen >= rows || self->first + shown > rows) choose(self, 0); /* the game has changed its actions */
    canvas_rect(over, 0, 0, self->hud_width, CANVAS_HEIGHT, SHADE);
    text_style style = {56, WHITE, TEXT_CENTER, true};
    text_draw(over, face, self->controls ? "Controls" : title, middle, TOP - 110, &style);
    for (int i = 0; i < shown; i++) draw_row(self, over, face, self->first + i);
    style = (text_style){18, GREY, TEXT_CENTER, true};
    const float below = TOP + ROW * (float)shown + 20;
    text_draw(over, face,
              self->waits >= 0 ? "Press a key or a button, or push a stick      Esc  leave it as it is"
              : self->controls ? "↑ ↓  choose      Return  another key      Esc  back"
                               : "↑ ↓  choose      ← →  change      Return  do it      Esc  continue",
              middle, below, &style);
    if (shown == rows) return;
    const float track = ROW * (float)shown - 6, part = track / (float)rows;
    canvas_rect(over, left_of(self) + WIDTH + 10, TOP + part * (float)self->first, 6, part * (float)shown, GREY);
}
