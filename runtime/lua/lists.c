/* Tables as lists: pairs in a fixed order, and sort, insert, remove and move. See sandbox.c for why they differ from
 * Lua's, and host.h for the polls. */
#include "lua/api.h"

#include "lua/sandbox.h"

#include <string.h>

/* ---- pairs ---- */

typedef enum key_kind { KEY_NUMBER, KEY_STRING, KEY_BOOLEAN, KEY_OTHER } key_kind;

typedef struct key_entry {
    key_kind kind;
    long double number; /* holds every integer and every double of Lua exactly */
    const char *text;   /* stays where it is while the table holds it */
    size_t length;
    lua_Integer place; /* in the order of next() */
} key_entry;

static int by_key(const key_entry *a, const key_entry *b)
{
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    if (a->kind == KEY_NUMBER || a->kind == KEY_BOOLEAN) return a->number < b->number ? -1 : a->number > b->number;
    if (a->kind == KEY_STRING) {
        int order = memcmp(a->text, b->text, a->length < b->length ? a->length : b->length);
        return order ? order : a->length < b->length ? -1 : a->length > b->length;
    }
    return a->place < b->place ? -1 : a->place > b->place;
}

static key_entry describe_key(lua_State *L, int index, lua_Integer place)
{
    key_entry entry = {.kind = KEY_OTHER, .place = place};
    switch (lua_type(L, index)) {
    case LUA_TNUMBER:
        entry.kind = KEY_NUMBER;
        entry.number =
            lua_isinteger(L, index) ? (long double)lua_tointeger(L, index) : (long double)lua_tonumber(L, index);
        break;
    case LUA_TSTRING:
        entry.kind = KEY_STRING;
        entry.text = lua_tolstring(L, index, &entry.length);
        break;
    case LUA_TBOOLEAN:
        entry.kind = KEY_BOOLEAN;
        entry.number = lua_toboolean(L, index);
        break;
    default: break;
    }
    return entry;
}

/* How far a loop has come in its list of keys. */
typedef struct pair_walk {
    lua_Integer place, count;
} pair_walk;

/* Upvalues: the pair_walk, the list of keys, the table. Keys that are gone by now are passed over. */
static int next_pair(lua_State *L)
{
    pair_walk *walk = lua_touserdata(L, lua_upvalueindex(1));
    while (walk->place < walk->count) {
        lua_rawgeti(L, lua_upvalueindex(2), ++walk->place);
        lua_pushvalue(L, -1);
        if (lua_rawget(L, lua_upvalueindex(3)) != LUA_TNIL) return 2;
        lua_pop(L, 2);
        api_poll(L, (uint64_t)walk->place);
    }
    lua_pushnil(L);
    return 1;
}

/* A stable merge sort of `count` keys, which then lie in `keys` or in `spare`; the C library's cannot be stopped. */
static key_entry *sort_keys(lua_State *L, key_entry *keys, key_entry *spare, lua_Integer count)
{
    for (lua_Integer width = 1; width < count; width *= 2) {
        for (lua_Integer low = 0; low < count; low += 2 * width) {
            lua_Integer middle = low + width < count ? low + width : count;
            lua_Integer high = low + 2 * width < count ? low + 2 * width : count;
            for (lua_Integer out = low, left = low, right = middle; out < high; out++) {
                bool take_right = left >= middle || (right < high && by_key(&keys[right], &keys[left]) < 0);
                spare[out] = take_right ? keys[right++] : keys[left++];
                api_poll(L, (uint64_t)out);
            }
        }
        key_entry *other = keys;
        keys = spare, spare = other;
    }
    return keys;
}

/* Leaves the sorted list of the keys of the table at 1, of which there are so many, on the stack. */
static void push_sorted(lua_State *L, lua_Integer count)
{
    key_entry *entries = api_scratch(L, (size_t)(2 * count + 1) * sizeof *entries);
    lua_createtable(L, (int)count, 0);
    lua_Integer place = 0;
    for (lua_pushnil(L); lua_next(L, 1) && place < count;) {
        lua_pop(L, 1);
        entries[place] = describe_key(L, -1, place + 1);
        lua_pushvalue(L, -1);
        lua_rawseti(L, -3, ++place);
        api_poll(L, (uint64_t)place);
    }
    const key_entry *sorted = sort_keys(L, entries, entries + count, count);
    lua_createtable(L, (int)count, 0);
    for (lua_Integer i = 0; i < count; i++) {
        lua_rawgeti(L, -2, sorted[i].place);
        lua_rawseti(L, -2, i + 1);
        api_poll(L, (uint64_t)i);
    }
    lua_remove(L, -2);
}

/* What a walk over a table's keys, in the order of next(), says of them. */
typedef struct key_set {
    lua_Integer count;
    uint64_t sum; /* a hash of them in that order: two sets that are alive have the same as likely as 64 bits are by
                     chance */
} key_set;

/* Of a key that is no string. */
static uint64_t bits_of_key(lua_State *L, int index)
{
    uint64_t bits = (uint64_t)lua_type(L, index);
    if (lua_isinteger(L, index)) { /* 0 and above: odd, as no address is */
        const uint64_t whole = (uint64_t)lua_tointeger(L, index);
        return (whole << 1 | whole >> 63) ^ 1;
    }
    const double number = lua_tonumber(L, index);
    if (lua_type(L, index) == LUA_TNUMBER)
        memcpy(&bits, &number, sizeof bits);
    else
        bits += (uint64_t)lua_toboolean(L, index) << 4;
    return bits;
}

/* Whether the table at 1 is a list, also one with holes: has whole numbers only, which next() gives in their order. */
static bool is_list(lua_State *L)
{
    lua_Integer last = LUA_MININTEGER;
    uint64_t count = 0;
    for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1)) {
        const lua_Integer key = lua_isinteger(L, -2) ? lua_tointeger(L, -2) : LUA_MININTEGER;
        if (key <= last) {
            lua_pop(L, 2);
            return false;
        }
        last = key;
        api_poll(L, count++);
    }
    return true;
}

/* The count and the sum: with as few calls of Lua as there can be, since every loop begins with it. */
static key_set look_at_keys(lua_State *L)
{
    key_set set = {.count = 0};
    for (lua_pushnil(L); lua_next(L, 1); lua_settop(L, 2)) {
        const void *address = lua_topointer(L, 2);
        const uint64_t bits = address ? (uint64_t)(uintptr_t)address : bits_of_key(L, 2);
        /* A turn and a product: each key's bits get everywhere, and their order counts. */
        set.sum = ((set.sum << 29 | set.sum >> 35) ^ bits) * 0x9E3779B97F4A7C15u;
        if (++set.count % HOST_POLL_STEPS == 0) host_poll(L);
    }
    return set;
}

/* Numbers, strings and booleans only: their order depends on no address, so that it can be kept. */
static bool are_plain(lua_State *L)
{
    bool plain = true;
    lua_Integer count = 0;
    for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1)) {
        const int type = lua_type(L, -2);
        plain = plain && (type == LUA_TSTRING || type == LUA_TNUMBER || type == LUA_TBOOLEAN);
        api_poll(L, (uint64_t)++count);
    }
    return plain;
}

/* Registry key of the lists of sorted keys by table, which does not keep the tables alive. A list has its set's sum at
 * 0, and keeps its strings alive, so that no other key can have the address of one. Sorting is then done once for as
 * long as a table has the same keys. */
static const char SORTED_KEY;

enum { WORTH_KEEPING = 8 }; /* keys */

static void push_cache(lua_State *L)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &SORTED_KEY) != LUA_TNIL) return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushstring(L, "k");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &SORTED_KEY);
}

/* Pushes the list from the cache and is true, or pushes nothing. */
static bool push_kept(lua_State *L, const key_set *set)
{
    push_cache(L);
    lua_pushvalue(L, 1);
    bool found = lua_rawget(L, -2) == LUA_TTABLE && (lua_Integer)lua_rawlen(L, -1) == set->count;
    if (found) {
        lua_rawgeti(L, -1, 0);
        found = (uint64_t)lua_tointeger(L, -1) == set->sum;
        lua_pop(L, 1);
    }
    if (found)
        lua_remove(L, -2);
    else
        lua_pop(L, 2);
    return found;
}

/* The list on top stays there. */
static void keep(lua_State *L, const key_set *set)
{
    lua_pushinteger(L, (lua_Integer)set->sum);
    lua_rawseti(L, -2, 0);
    push_cache(L);
    lua_pushvalue(L, 1);
    lua_pushvalue(L, -3);
    lua_rawset(L, -3);
    lua_pop(L, 1);
}

/* Leaves the sorted list of the keys of the table at 1. */
static void push_keys(lua_State *L, const key_set *set)
{
    if (set->count >= WORTH_KEEPING && push_kept(L, set)) return;
    push_sorted(L, set->count);
    if (set->count >= WORTH_KEEPING && are_plain(L)) keep(L, set);
}

static int next_in_table(lua_State *L)
{
    lua_settop(L, 2);
    if (lua_next(L, 1)) return 2;
    lua_pushnil(L);
    return 1;
}

static int pairs(lua_State *L)
{
    luaL_checkany(L, 1);
    if (luaL_getmetafield(L, 1, "__pairs") != LUA_TNIL) {
        lua_pushvalue(L, 1);
        lua_call(L, 1, 3);
        return 3;
    }
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    /* What a loop adds to a list comes at a place that does not depend on addresses, as it might with strings. */
    if (is_list(L)) {
        lua_pushcfunction(L, next_in_table);
    } else {
        const key_set set = look_at_keys(L);
        pair_walk *walk = lua_newuserdatauv(L, sizeof *walk, 0);
        *walk = (pair_walk){.count = set.count};
        push_keys(L, &set);
        lua_pushvalue(L, 1);
        lua_pushcclosure(L, next_pair, 3);
    }
    lua_pushvalue(L, 1);
    lua_pushnil(L);
    return 3;
}

/* ---- sort ---- */

/* Whether the value at `a` must come before the one at `b`, by the function at 2 or by <. */
static bool comes_before(lua_State *L, int a, int b)
{
    a = lua_absindex(L, a), b = lua_absindex(L, b);
    if (lua_isnil(L, 2)) return lua_compare(L, a, b, LUA_OPLT);
    lua_pushvalue(L, 2);
    lua_pushvalue(L, a);
    lua_pushvalue(L, b);
    lua_call(L, 2, 1);
    bool before = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return before;
}

/* Merges [low, middle) and [middle, high) of the list at `from` into the one at `to`. */
static void merge(lua_State *L, int from, int to, lua_Integer low, lua_Integer middle, lua_Integer high)
{
    lua_Integer left = low, right = middle;
    for (lua_Integer out = low; out < high; out++) {
        if (host_stopping(api_host(L))) host_poll(L); /* each time: comparing two long strings takes milliseconds */
        lua_rawgeti(L, from, left < middle ? left : right);
        lua_rawgeti(L, from, right < high ? right : left);
        bool take_right = left >= middle || (right < high && comes_before(L, -1, -2));
        if (!take_right) lua_pop(L, 1);
        lua_rawseti(L, to, out);
        if (take_right) lua_pop(L, 1);
        if (take_right)
            right++;
        else
            left++;
    }
}

/* Sorted in two lists of its own, so that a comparison that fails leaves the table as it was. */
static int sort(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    if (!lua_isnoneornil(L, 2)) luaL_checktype(L, 2, LUA_TFUNCTION);
    lua_settop(L, 2);
    lua_Integer count = luaL_len(L, 1);
    luaL_argcheck(L, count < INT32_MAX, 1, "too long to sort");
    lua_createtable(L, (int)(count > 0 ? count : 0), 0);
    lua_createtable(L, (int)(count > 0 ? count : 0), 0);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_geti(L, 1, i);
        lua_rawseti(L, 3, i);
    }
    int from = 3, to = 4;
    for (lua_Integer width = 1; width < count; width *= 2) {
        for (lua_Integer low = 1; low <= count; low += 2 * width) {
            lua_Integer middle = low + width < count + 1 ? low + width : count + 1;
            lua_Integer high = low + 2 * width < count + 1 ? low + 2 * width : count + 1;
            merge(L, from, to, low, middle, high);
        }
        int other = from;
        from = to, to = other;
    }
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, from, i);
        lua_seti(L, 1, i);
    }
    return 0;
}

/* ---- insert, remove, move ---- */

/* Lua's own loop out of the watchdog's sight. So many elements take less than a second. */
static const lua_Integer MOST_ELEMENTS = 1 << 24;

static int call_original(lua_State *L)
{
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    return lua_gettop(L);
}

/* table.insert and table.remove move the rest of a list, whose length may come from __len. */
static int with_short_list(lua_State *L)
{
    int without_move = (int)lua_tointeger(L, lua_upvalueindex(2)); /* so many arguments, or fewer */
    if (lua_gettop(L) > without_move && lua_istable(L, 1) && luaL_len(L, 1) > MOST_ELEMENTS)
        return luaL_argerror(L, 1, "the list is too long");
    return call_original(L);
}

static int move(lua_State *L)
{
    lua_Integer first = luaL_checkinteger(L, 2), last = luaL_checkinteger(L, 3);
    if (last >= first && (lua_Unsigned)last - (lua_Unsigned)first > (lua_Unsigned)MOST_ELEMENTS)
        return luaL_argerror(L, 3, "too many elements to move");
    return call_original(L);
}

/* Replaces the function `name` of the table on top by `wrapper`, whose upvalues are the original and a number. */
static void wrap(lua_State *L, const char *name, lua_CFunction wrapper, int number)
{
    lua_getfield(L, -1, name);
    lua_pushinteger(L, number);
    lua_pushcclosure(L, wrapper, 2);
    lua_setfield(L, -2, name);
}

void lists_open(lua_State *L)
{
    lua_pushcfunction(L, pairs);
    lua_setglobal(L, "pairs");
    lua_getglobal(L, LUA_TABLIBNAME);
    lua_pushcfunction(L, sort);
    lua_setfield(L, -2, "sort");
    wrap(L, "insert", with_short_list, 2);
    wrap(L, "remove", with_short_list, 1);
    wrap(L, "move", move, 0);
    lua_pop(L, 1);
}
