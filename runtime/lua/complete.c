/* Names that a half-typed name may become. Tables are walked and keys compared as they are, since pushing a name would
 * allocate, and what the game's memory looks like must not hang on what is only looked at. */
#include "lua/statement.h"

#include "lua/api.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { UPVALUES = 255 };

static bool is_letter(char c) { return isalnum((unsigned char)c) || c == '_' || (unsigned char)c >= 0x80; }

/* Where the last "a.b:c" of the text begins. */
static const char *path_in(const char *text)
{
    const char *at = text + strlen(text);
    while (at > text && (is_letter(at[-1]) || at[-1] == '.' || at[-1] == ':')) at--;
    return at;
}

static bool is_name(lua_State *L, int index, const char *name, size_t length)
{
    size_t size;
    if (lua_type(L, index) != LUA_TSTRING) return false;
    const char *text = lua_tolstring(L, index, &size);
    return size == length && memcmp(text, name, length) == 0;
}

/* Replaces the table on top by its field. False: it has none of that name. */
static bool enter(lua_State *L, const char *name, size_t length)
{
    if (!lua_istable(L, -1)) return false;
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        if (!is_name(L, -2, name, length)) continue;
        lua_replace(L, -3);
        lua_pop(L, 1);
        return true;
    }
    return false;
}

/* Replaces what is on top by the table that its methods or its missing fields come from. */
static bool enter_index(lua_State *L)
{
    if (!lua_getmetatable(L, -1)) return false;
    lua_replace(L, -2);
    if (!enter(L, "__index", 7)) return false;
    if (lua_iscfunction(L, -1) && lua_getupvalue(L, -1, 1)) lua_replace(L, -2); /* of the engine's types: lua/api.c */
    return lua_istable(L, -1);
}

static void keep(completions *out, const char *name)
{
    const size_t length = strlen(name);
    if (length >= COMPLETION_SIZE) return;
    for (size_t i = 0; i < out->count; i++)
        if (strcmp(out->names[i], name) == 0) return;
    if (out->total++ == 0) memcpy(out->common, name, length + 1);
    size_t same = 0;
    while (out->common[same] && out->common[same] == name[same]) same++;
    out->common[same] = 0;
    if (out->count < COMPLETIONS) memcpy(out->names[out->count++], name, length + 1);
}

static bool fits(const char *name, const char *typed)
{
    const size_t length = strlen(typed);
    if (strncmp(name, typed, length) != 0 || isdigit((unsigned char)name[0])) return false;
    if (name[0] == '_' && name[1] == '_' && length < 2) return false;
    for (const char *at = name; *at; at++)
        if (!is_letter(*at)) return false;
    return name[0] != 0;
}

/* The names of the table on top; `methods`: only functions. */
static void keep_fields(lua_State *L, const char *typed, bool methods, completions *out)
{
    if (!lua_istable(L, -1)) return;
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING || (methods && !lua_isfunction(L, -1))) continue;
        const char *name = lua_tostring(L, -2);
        if (fits(name, typed)) keep(out, name);
    }
}

/* For each callback's local variables: keeps their names, where `name` is NULL, or leaves the value of the one of that
 * name on top and is true. */
static bool search_locals(lua_State *L, const char *name, size_t length, const char *typed, completions *out)
{
    api_push(L);
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        if (!lua_isfunction(L, -1) || lua_iscfunction(L, -1)) continue;
        for (int i = 1; i <= UPVALUES; i++, lua_pop(L, 1)) {
            const char *local = lua_getupvalue(L, -1, i);
            if (!local) break;
            if (name && strlen(local) == length && memcmp(local, name, length) == 0) {
                lua_replace(L, -4);
                lua_pop(L, 2);
                return true;
            }
            if (!name && strcmp(local, "_ENV") != 0 && fits(local, typed)) keep(out, local);
        }
    }
    lua_pop(L, 1);
    return false;
}

/* Pushes what a name without a dot is. */
static bool push_first(lua_State *L, const char *name, size_t length)
{
    static const char entity[] = "entity_";
    if (search_locals(L, name, length, NULL, NULL)) return true;
    lua_pushglobaltable(L);
    if (enter(L, name, length)) return true;
    lua_pop(L, 1);
    const bool numbered = length > sizeof entity - 1 && strncmp(name, entity, sizeof entity - 1) == 0;
    if (numbered || (length == 2 && strncmp(name, "it", 2) == 0)) return api_push_methods(L, API_ENTITY);
    return false;
}

/* Pushes what stands before the last dot or colon: the globals where there is none. */
static bool push_owner(lua_State *L, const char *path, const char *last)
{
    if (path == last) {
        lua_pushglobaltable(L);
        return true;
    }
    size_t length = strcspn(path, ".:");
    if (!push_first(L, path, length)) return false;
    for (path += length + 1; path < last; path += length + 1) {
        length = strcspn(path, ".:");
        if (!enter(L, path, length)) return false;
    }
    return true;
}

static int compare(const void *a, const void *b) { return strcmp(a, b); }

void host_complete(host *state, const char *text, completions *out)
{
    lua_State *L = state->L;
    const int top = lua_gettop(L);
    const char *path = path_in(text), *last = path + strlen(path);
    while (last > path && last[-1] != '.' && last[-1] != ':') last--;
    const bool methods = last > path && last[-1] == ':';
    *out = (completions){.typed = strlen(last)};
    if (push_owner(L, path, last)) {
        keep_fields(L, last, methods, out);
        if (path != last && enter_index(L)) keep_fields(L, last, methods, out);
    }
    if (path == last) search_locals(L, NULL, 0, last, out);
    lua_settop(L, top);
    qsort(out->names, out->count, sizeof *out->names, compare);
}

/* ---- entities ---- */

static void put_text(lua_State *L, char out[ENTITY_TEXT])
{
    const size_t used = strlen(out);
    if (lua_type(L, -1) == LUA_TSTRING)
        snprintf(out + used, ENTITY_TEXT - used, "%s%s", used ? ", " : "", lua_tostring(L, -1));
}

/* tables/tags.c says how they lie in the user value. */
void host_entity_texts(host *state, uint32_t id, char name[ENTITY_TEXT], char tags[ENTITY_TEXT])
{
    lua_State *L = state->L;
    const int top = lua_gettop(L);
    name[0] = tags[0] = 0;
    if (api_push_known_entity(L, id)) {
        lua_getiuservalue(L, -1, 1);
        lua_pushvalue(L, -1);
        if (enter(L, "name", 4)) put_text(L, name);
        lua_settop(L, top + 2);
        const lua_Integer count = enter(L, "tags", 4) ? (lua_Integer)lua_rawlen(L, -1) : 0;
        for (lua_Integer i = 1; i <= count; i++, lua_pop(L, 1)) {
            lua_rawgeti(L, -1, i);
            put_text(L, tags);
        }
    }
    lua_settop(L, top);
}
