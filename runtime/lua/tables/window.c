/* daft.window: what the game wishes of its window. The session grants it where there is one; without a display, and in
 * a replay, the game goes the same way. */
#include "lua/fields.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

enum { LEAST_WIDTH = 320, LEAST_HEIGHT = 180, MOST = 8192, MOST_ICON = 1024 };

static const char *const FIELDS[] = {"title", "width", "height", "full_screen", "icon"};

static void set_title(lua_State *L, host *h, window_wish *wish)
{
    const char *title = api_text(L, h, -1, "title");
    if (strlen(title) >= sizeof wish->title)
        api_error(L, h, "title: at most %d bytes expected", (int)sizeof wish->title - 1);
    snprintf(wish->title, sizeof wish->title, "%s", title);
}

static int side(lua_State *L, host *h, const char *name, int least)
{
    const lua_Integer value = api_whole(L, h, -1, name);
    if (value < least || value > MOST) api_error(L, h, "%s: %d to %d expected", name, least, MOST);
    return (int)value;
}

/* Width and height go together. */
static void set_size(lua_State *L, host *h, window_wish *wish)
{
    const bool wide = api_field(L, 1, "width");
    if (wide) wish->width = side(L, h, "width", LEAST_WIDTH), lua_pop(L, 1);
    const bool high = api_field(L, 1, "height");
    if (high) wish->height = side(L, h, "height", LEAST_HEIGHT), lua_pop(L, 1);
    if (wide != high) api_error(L, h, "width and height go together: %s is missing", wide ? "height" : "width");
}

static daft_image *load_icon(lua_State *L, host *h)
{
    char path[PATH_SIZE];
    daft_error error;
    daft_image *icon = NULL;
    const char *name = api_text(L, h, -1, "icon");
    if (host_find_file(h, name, path, sizeof path, &error)) icon = daft_image_load(h->def.engine, path, &error);
    if (!icon) api_engine_error(L, h, &error);
    if (daft_image_width(icon) <= MOST_ICON && daft_image_height(icon) <= MOST_ICON) return icon;
    daft_image_destroy(icon);
    api_error(L, h, "icon: %s: at most %d x %d pixels expected", name, MOST_ICON, MOST_ICON);
    return NULL;
}

/* The icon is loaded last, when nothing else can fail. */
static int window(lua_State *L, host *h)
{
    window_wish wish = h->window;
    api_fields(L, h, 1, NULL, FIELDS, COUNT_OF(FIELDS));
    if (api_field(L, 1, "title")) set_title(L, h, &wish), lua_pop(L, 1);
    set_size(L, h, &wish);
    if (api_field(L, 1, "full_screen")) wish.full_screen = api_boolean(L, h, -1, "full_screen"), lua_pop(L, 1);
    if (api_field(L, 1, "icon")) {
        daft_image *icon = load_icon(L, h);
        daft_image_destroy(wish.icon);
        wish.icon = icon;
    }
    wish.changes++;
    h->window = wish;
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"window", "({title =, width =, height =, full_screen =, icon =})",
     "What the game's window is like: its title, its size in points of the screen, whether it fills the screen, and "
     "an\n"
     "image file as its icon. What is not given stays; the player may change size and full screen at any time.",
     window, API_CHANGES},
};

const api_area api_window = {"Window", FUNCTIONS, COUNT_OF(FUNCTIONS)};
