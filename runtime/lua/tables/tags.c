/* Names and tags of entities, and daft.find, which finds by them.
 *
 * What a script keeps with an entity lies in the user value of its userdata: {name =, data =, tags = list}. Beside it
 * the registry has two indices, of names and of tags: from each to the list of ids of those that have it, in the order
 * in which they got it. Ids of entities that are gone stay in the lists until these have doubled. */
#include "lua/api.h"

#include "common/util.h"

#include <string.h>

typedef enum index_kind { BY_NAME, BY_TAG, KINDS } index_kind;

static const char INDEX_KEYS[KINDS]; /* registry keys */

enum { LONGEST_TAG = 200, MOST_TAGS = 64 /* of an entity */ };

/* ---- the user value ---- */

void api_set_own(lua_State *L, int entity, const char *field)
{
    lua_getiuservalue(L, entity, 1);
    lua_insert(L, -2);
    lua_setfield(L, -2, field);
    lua_pop(L, 1);
}

static void push_own(lua_State *L, int entity, const char *field)
{
    lua_getiuservalue(L, entity, 1);
    lua_getfield(L, -1, field);
    lua_remove(L, -2);
}

/* ---- the indices ---- */

static void push_index(lua_State *L, index_kind kind)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &INDEX_KEYS[kind]) != LUA_TNIL) return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &INDEX_KEYS[kind]);
}

/* Pushes the list of the key at `key`, or nil. */
static bool push_list(lua_State *L, index_kind kind, int key)
{
    key = lua_absindex(L, key);
    push_index(L, kind);
    lua_pushvalue(L, key);
    const bool found = lua_rawget(L, -2) == LUA_TTABLE;
    lua_remove(L, -2);
    return found;
}

static bool is_alive(const host *h, lua_Integer id)
{
    return daft_entity_is_valid(h->def.scene, (daft_entity){(uint32_t)id});
}

/* Takes out of the list on top those that are gone, and `id`. Gives how many are left. */
static lua_Integer sift(lua_State *L, const host *h, lua_Integer id)
{
    const lua_Integer count = (lua_Integer)lua_rawlen(L, -1);
    lua_Integer kept = 0;
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -1, i);
        const lua_Integer at = lua_tointeger(L, -1);
        if (at != id && is_alive(h, at))
            lua_rawseti(L, -2, ++kept);
        else
            lua_pop(L, 1);
        api_poll(L, (uint64_t)i);
    }
    for (lua_Integer i = kept + 1; i <= count; i++) {
        lua_pushnil(L);
        lua_rawseti(L, -2, i);
    }
    return kept;
}

/* All lists; those that are empty go. */
static lua_Integer sweep(lua_State *L, const host *h)
{
    lua_Integer held = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        push_index(L, (index_kind)kind);
        for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
            const lua_Integer kept = sift(L, h, 0);
            held += kept;
            if (kept > 0) continue;
            lua_pushvalue(L, -2);
            lua_pushnil(L);
            lua_rawset(L, -5);
        }
        lua_pop(L, 1);
    }
    return held;
}

/* Takes the key from the top. */
static void put_into_index(lua_State *L, host *h, index_kind kind, uint32_t id)
{
    enum { SOME = 256 };
    if (!push_list(L, kind, -1)) {
        lua_pop(L, 1);
        lua_newtable(L);
        push_index(L, kind);
        lua_pushvalue(L, -3);
        lua_pushvalue(L, -3);
        lua_rawset(L, -3);
        lua_pop(L, 1);
    }
    lua_pushinteger(L, (lua_Integer)id);
    lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    lua_pop(L, 2);
    if (++h->indexed <= SOME + 2 * h->indexed_kept) return;
    h->indexed = h->indexed_kept = (uint32_t)sweep(L, h);
}

static void take_out_of_index(lua_State *L, host *h, index_kind kind, int key, uint32_t id)
{
    if (push_list(L, kind, key)) sift(L, h, (lua_Integer)id);
    lua_pop(L, 1);
}

static uint32_t id_of(lua_State *L, int entity) { return ((const api_handle *)lua_touserdata(L, entity))->id; }

void api_set_name(lua_State *L, int entity)
{
    host *h = api_host(L);
    entity = lua_absindex(L, entity);
    push_own(L, entity, "name");
    if (!lua_isnil(L, -1)) take_out_of_index(L, h, BY_NAME, -1, id_of(L, entity));
    lua_pop(L, 1);
    lua_pushvalue(L, -1);
    put_into_index(L, h, BY_NAME, id_of(L, entity));
    api_set_own(L, entity, "name");
}

/* ---- tags ---- */

/* Whether the string on top is in the list below it; its place. */
static lua_Integer place_in_list(lua_State *L)
{
    const lua_Integer count = (lua_Integer)lua_rawlen(L, -2);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -2, i);
        const bool same = lua_rawequal(L, -1, -2);
        lua_pop(L, 1);
        if (same) return i;
    }
    return 0;
}

static bool has_tag_on_top(lua_State *L, int entity)
{
    push_own(L, entity, "tags");
    lua_pushvalue(L, -2);
    const bool has = lua_istable(L, -2) && place_in_list(L) > 0;
    lua_pop(L, 2);
    return has;
}

static void check_tag(lua_State *L, host *h, int index)
{
    if (lua_type(L, index) != LUA_TSTRING) api_wrong(L, h, index, "tag", "name");
    const size_t length = lua_rawlen(L, index);
    if (length == 0 || length > LONGEST_TAG)
        api_error(L, h, "tag: 1 to %d bytes expected, got %zu", (int)LONGEST_TAG, length);
}

void api_check_tags(lua_State *L, host *h, int index)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) != LUA_TTABLE) {
        if (lua_type(L, index) != LUA_TSTRING) api_wrong(L, h, index, "tags", "name or list of names");
        check_tag(L, h, index);
        return;
    }
    const size_t count = lua_rawlen(L, index);
    if (count > MOST_TAGS) api_error(L, h, "tags: at most %d expected, got %zu", (int)MOST_TAGS, count);
    for (size_t i = 1; i <= count; i++) {
        lua_rawgeti(L, index, (lua_Integer)i);
        check_tag(L, h, -1);
        lua_pop(L, 1);
    }
}

/* Takes the tag from the top. */
static void add_tag(lua_State *L, int entity)
{
    host *h = api_host(L);
    if (has_tag_on_top(L, entity)) {
        lua_pop(L, 1);
        return;
    }
    push_own(L, entity, "tags");
    if (lua_isnil(L, -1)) {
        lua_pop(L, 1);
        lua_newtable(L);
        lua_pushvalue(L, -1);
        api_set_own(L, entity, "tags");
    }
    const lua_Integer count = (lua_Integer)lua_rawlen(L, -1);
    if (count >= MOST_TAGS) api_error(L, h, "tag: an entity has at most %d", (int)MOST_TAGS);
    lua_pushvalue(L, -2);
    lua_rawseti(L, -2, count + 1);
    lua_pop(L, 1);
    put_into_index(L, h, BY_TAG, id_of(L, entity));
}

void api_add_tags(lua_State *L, int entity)
{
    entity = lua_absindex(L, entity);
    if (lua_type(L, -1) == LUA_TSTRING) {
        add_tag(L, entity);
        return;
    }
    const lua_Integer count = (lua_Integer)lua_rawlen(L, -1);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -1, i);
        add_tag(L, entity);
    }
    lua_pop(L, 1);
}

static void check_alive(lua_State *L, host *h)
{
    daft_transform unused;
    daft_error error;
    if (!daft_entity_get_transform(h->def.scene, api_entity_at(L, h, 1, "entity"), &unused, &error))
        api_engine_error(L, h, &error);
}

/* One or more arguments, each a tag. */
static int check_arguments(lua_State *L, host *h)
{
    check_alive(L, h);
    const int count = lua_gettop(L);
    if (count < 2) api_wrong(L, h, 2, "tag", "name");
    for (int i = 2; i <= count; i++) check_tag(L, h, i);
    return count;
}

static int tag(lua_State *L, host *h)
{
    const int count = check_arguments(L, h);
    for (int i = 2; i <= count; i++) {
        lua_pushvalue(L, i);
        add_tag(L, 1);
    }
    return 0;
}

/* Which it has. */
static void remove_tag(lua_State *L, host *h, int key)
{
    push_own(L, 1, "tags");
    lua_pushvalue(L, key);
    lua_Integer at = place_in_list(L);
    lua_pop(L, 1);
    for (const lua_Integer count = (lua_Integer)lua_rawlen(L, -1); at <= count; at++) {
        lua_rawgeti(L, -1, at + 1); /* nil after the last */
        lua_rawseti(L, -2, at);
    }
    lua_pop(L, 1);
    take_out_of_index(L, h, BY_TAG, key, id_of(L, 1));
}

static int untag(lua_State *L, host *h)
{
    const int count = check_arguments(L, h);
    for (int i = 2; i <= count; i++) {
        lua_pushvalue(L, i);
        const bool has = has_tag_on_top(L, 1);
        lua_pop(L, 1);
        if (has) remove_tag(L, h, i);
    }
    return 0;
}

static int has_tag(lua_State *L, host *h)
{
    check_arguments(L, h);
    lua_settop(L, 2);
    lua_pushboolean(L, has_tag_on_top(L, 1));
    return 1;
}

static int tags(lua_State *L, host *h)
{
    check_alive(L, h);
    push_own(L, 1, "tags");
    const lua_Integer count = lua_istable(L, -1) ? (lua_Integer)lua_rawlen(L, -1) : 0;
    lua_createtable(L, (int)count, 0);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -2, i);
        lua_rawseti(L, -2, i);
    }
    return 1;
}

/* ---- find ---- */

/* Places on the stack: the name or nil; the list of tags, which may be empty; the list of ids that is gone through. */
enum { NAME_AT = 3, TAGS_AT = 4, LIST_AT = 6 };

static bool fits(lua_State *L, int entity)
{
    bool good = true;
    if (!lua_isnil(L, NAME_AT)) {
        push_own(L, entity, "name");
        good = lua_rawequal(L, -1, NAME_AT);
        lua_pop(L, 1);
    }
    const lua_Integer count = (lua_Integer)lua_rawlen(L, TAGS_AT);
    for (lua_Integer i = 1; good && i <= count; i++) {
        lua_rawgeti(L, TAGS_AT, i);
        good = has_tag_on_top(L, entity);
        lua_pop(L, 1);
    }
    return good;
}

static void read_wishes(lua_State *L, host *h)
{
    static const char *const FIELDS[] = {"tag", "name"};
    api_fields(L, h, 1, NULL, FIELDS, COUNT_OF(FIELDS));
    if (lua_isnoneornil(L, 2)) {
        lua_settop(L, 1);
        lua_newtable(L);
    } else if (!lua_istable(L, 2)) {
        api_wrong(L, h, 2, "list", "table");
    }
    lua_settop(L, 2);
    if (api_field(L, 1, "name"))
        api_text(L, h, -1, "name");
    else
        lua_pushnil(L);
    lua_newtable(L);
    if (!api_field(L, 1, "tag")) {
        if (lua_isnil(L, NAME_AT)) api_error(L, h, "tag or name expected");
        return;
    }
    api_check_tags(L, h, -1);
    if (lua_istable(L, -1)) {
        if (lua_rawlen(L, -1) == 0 && lua_isnil(L, NAME_AT)) api_error(L, h, "tag: the list is empty");
        lua_replace(L, TAGS_AT);
    } else {
        lua_rawseti(L, TAGS_AT, 1);
    }
}

/* Fills the list at 2, and ends it. */
static int find(lua_State *L, host *h)
{
    read_wishes(L, h);
    const bool by_name = !lua_isnil(L, NAME_AT);
    if (by_name)
        lua_pushvalue(L, NAME_AT);
    else
        lua_rawgeti(L, TAGS_AT, 1);
    lua_Integer found = 0, count = push_list(L, by_name ? BY_NAME : BY_TAG, -1) ? (lua_Integer)lua_rawlen(L, -1) : 0;
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, LIST_AT, i);
        const lua_Integer id = lua_tointeger(L, -1);
        lua_pop(L, 1);
        api_poll(L, (uint64_t)i);
        if (!is_alive(h, id)) continue;
        api_push_entity(L, (uint32_t)id);
        if (fits(L, lua_gettop(L)))
            lua_rawseti(L, 2, ++found);
        else
            lua_pop(L, 1);
    }
    for (lua_Integer i = (lua_Integer)lua_rawlen(L, 2); i > found; i--) {
        lua_pushnil(L);
        lua_rawseti(L, 2, i);
    }
    lua_settop(L, 2);
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"find", "{tag =, name =} [, list] -> list",
     "The entities of that name, or with that tag, or with all tags of a list; those that got it first come first.\n"
     "list: a table to fill, instead of a new one.",
     find, 0},
    {"entity:tag", "(tag, ...)", "Gives it tags: names of what it is.", tag, API_CHANGES},
    {"entity:untag", "(tag, ...)", "Takes tags from it.", untag, API_CHANGES},
    {"entity:has_tag", "(tag) -> boolean", "Whether it has the tag.", has_tag, 0},
    {"entity:tags", "() -> list", "Its tags, in the order in which it got them.", tags, 0},
};

const api_area api_tags = {"Names and tags", FUNCTIONS, COUNT_OF(FUNCTIONS)};
