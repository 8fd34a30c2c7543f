/* A backtracking matcher for Lua's patterns. See patterns.h.
 *
 * A pattern is read where it stands. An item is a single class (a character, ".", "%a", a set) with what follows it
 * ("*", "+",
 * "-", "?"), or a capture, "%b", "%f", a back reference, or "$" at the end. `match_here` gives where the match of the
 * rest of a pattern ends, or NULL; single items without a choice are consumed in its loop, others recurse. */
#include "lua/patterns.h"

#include <ctype.h>
#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

enum {
    MAX_CAPTURES = 32,
    MAX_DEPTH = 200, /* of recursion, as in Lua */
    OPEN = -1,       /* length of a capture that has not ended */
    POSITION = -2    /* of a position capture, "()" */
};

typedef struct matcher {
    lua_State *L;
    patterns_poll *poll;
    const char *text, *text_end, *pattern_end;
    int depth, steps;
    int level; /* captures so far */
    struct {
        const char *at;
        ptrdiff_t length;
    } captures[MAX_CAPTURES];
} matcher;

static const char *match_here(matcher *m, const char *s, const char *p);

static void step(matcher *m)
{
    if (--m->steps > 0) return;
    m->steps = PATTERNS_POLL_STEPS;
    m->poll(m->L);
}

/* ---- single characters ---- */

/* The end of the single class that begins at p. */
static const char *class_end(matcher *m, const char *p)
{
    char first = *p++;
    if (first == '%') {
        if (p == m->pattern_end) luaL_error(m->L, "malformed pattern (ends with '%%')");
        return p + 1;
    }
    if (first != '[') return p;
    if (p < m->pattern_end && *p == '^') p++;
    do { /* a ']' that comes first belongs to the set */
        if (p == m->pattern_end) luaL_error(m->L, "malformed pattern (missing ']')");
        step(m);
        if (*p++ == '%') {
            if (p == m->pattern_end) luaL_error(m->L, "malformed pattern (missing ']')");
            p++;
        }
    } while (p == m->pattern_end || *p != ']');
    return p + 1;
}

static bool in_class(int c, int class)
{
    bool found;
    switch (tolower(class)) {
    case 'a': found = isalpha(c); break;
    case 'c': found = iscntrl(c); break;
    case 'd': found = isdigit(c); break;
    case 'g': found = isgraph(c); break;
    case 'l': found = islower(c); break;
    case 'p': found = ispunct(c); break;
    case 's': found = isspace(c); break;
    case 'u': found = isupper(c); break;
    case 'w': found = isalnum(c); break;
    case 'x': found = isxdigit(c); break;
    default: return class == c;
    }
    return isupper(class) ? !found : found;
}

static int byte_at(const char *p) { return (unsigned char)*p; }

/* `p` is at the '[', `last` at the ']' of a set. */
static bool in_set(matcher *m, int c, const char *p, const char *last)
{
    bool inside = true;
    if (p[1] == '^') inside = false, p++;
    while (++p < last) {
        step(m);
        if (*p == '%') {
            p++;
            if (in_class(c, byte_at(p))) return inside;
        } else if (p[1] == '-' && p + 2 < last) {
            p += 2;
            if (byte_at(p - 2) <= c && c <= byte_at(p)) return inside;
        } else if (byte_at(p) == c) {
            return inside;
        }
    }
    return !inside;
}

/* Whether the character at s matches the single class p..end. */
static bool matches_one(matcher *m, const char *s, const char *p, const char *end)
{
    step(m);
    if (s >= m->text_end) return false;
    int c = byte_at(s);
    switch (*p) {
    case '.': return true;
    case '%': return in_class(c, byte_at(p + 1));
    case '[': return in_set(m, c, p, end - 1);
    default: return byte_at(p) == c;
    }
}

/* ---- items ---- */

/* "%bxy": p is at x. */
static const char *match_balance(matcher *m, const char *s, const char *p)
{
    if (p >= m->pattern_end - 1) luaL_error(m->L, "malformed pattern (missing arguments to '%%b')");
    if (s >= m->text_end || *s != *p) return NULL;
    char open = p[0], close = p[1];
    size_t nested = 1;
    while (++s < m->text_end) {
        step(m);
        if (*s == close) {
            if (--nested == 0) return s + 1;
        } else if (*s == open) {
            nested++;
        }
    }
    return NULL;
}

static const char *match_longest(matcher *m, const char *s, const char *p, const char *end)
{
    ptrdiff_t count = 0;
    while (matches_one(m, s + count, p, end)) count++;
    for (; count >= 0; count--) {
        const char *rest = match_here(m, s + count, end + 1);
        if (rest) return rest;
    }
    return NULL;
}

static const char *match_shortest(matcher *m, const char *s, const char *p, const char *end)
{
    for (;; s++) {
        const char *rest = match_here(m, s, end + 1);
        if (rest) return rest;
        if (!matches_one(m, s, p, end)) return NULL;
    }
}

static const char *begin_capture(matcher *m, const char *s, const char *p, ptrdiff_t length)
{
    if (m->level >= MAX_CAPTURES) luaL_error(m->L, "too many captures");
    m->captures[m->level].at = s;
    m->captures[m->level].length = length;
    m->level++;
    const char *rest = match_here(m, s, p);
    if (!rest) m->level--;
    return rest;
}

static const char *end_capture(matcher *m, const char *s, const char *p)
{
    int last = m->level - 1;
    while (last >= 0 && m->captures[last].length != OPEN) last--;
    if (last < 0) luaL_error(m->L, "invalid pattern capture");
    m->captures[last].length = s - m->captures[last].at;
    const char *rest = match_here(m, s, p);
    if (!rest) m->captures[last].length = OPEN;
    return rest;
}

/* "%1" and so on: what the capture holds once more. */
static const char *match_again(matcher *m, const char *s, int digit)
{
    int which = digit - '1';
    if (which < 0 || which >= m->level || m->captures[which].length == OPEN)
        luaL_error(m->L, "invalid capture index %%%d", which + 1);
    ptrdiff_t length = m->captures[which].length; /* a position's is negative: as in Lua, it never fits */
    if ((size_t)(m->text_end - s) < (size_t)length || memcmp(m->captures[which].at, s, (size_t)length) != 0)
        return NULL;
    m->steps -= (int)(length / 64 < m->steps ? length / 64 : m->steps);
    step(m);
    return s + length;
}

/* "%f[set]": p is at the '['. True: the set begins here. */
static bool at_frontier(matcher *m, const char *s, const char *p, const char **after)
{
    if (p >= m->pattern_end || *p != '[') luaL_error(m->L, "missing '[' after '%%f' in pattern");
    *after = class_end(m, p);
    int before = s == m->text ? 0 : byte_at(s - 1), here = s == m->text_end ? 0 : byte_at(s);
    return !in_set(m, before, p, *after - 1) && in_set(m, here, p, *after - 1);
}

/* ---- the rest of a pattern ---- */

/* What consumes its item and leaves the rest to the caller's loop: true, with *s (NULL: no match) and *p moved on. */
static bool match_escape(matcher *m, const char **s, const char **p)
{
    const char *at = *p, *after;
    if (*at != '%' || at + 1 >= m->pattern_end) return false;
    if (at[1] == 'b') {
        *s = match_balance(m, *s, at + 2), *p = at + 4;
    } else if (at[1] == 'f') {
        if (!at_frontier(m, *s, at + 2, &after)) *s = NULL;
        *p = after;
    } else if (isdigit(byte_at(at + 1))) {
        *s = match_again(m, *s, byte_at(at + 1)), *p = at + 2;
    } else {
        return false;
    }
    return true;
}

/* A single class and what follows it. True: *s and *p are moved on, and the loop goes on; false: *s is the answer. */
static bool match_single(matcher *m, const char **s, const char **p)
{
    const char *at = *s, *end = class_end(m, *p), *rest;
    char suffix = end < m->pattern_end ? *end : 0;
    if (suffix == '*' || suffix == '-') {
        *s = suffix == '*' ? match_longest(m, at, *p, end) : match_shortest(m, at, *p, end);
        return false;
    }
    bool fits = matches_one(m, at, *p, end);
    if (suffix == '+') {
        *s = fits ? match_longest(m, at + 1, *p, end) : NULL;
        return false;
    }
    if (suffix == '?') {
        if (fits && (rest = match_here(m, at + 1, end + 1))) {
            *s = rest;
            return false;
        }
        *p = end + 1;
        return true;
    }
    *s = fits ? at + 1 : NULL;
    *p = end;
    return fits;
}

static const char *match_here(matcher *m, const char *s, const char *p)
{
    if (m->depth-- == 0) luaL_error(m->L, "pattern too complex");
    while (s && p != m->pattern_end) {
        step(m);
        if (*p == '(') {
            bool position = p + 1 < m->pattern_end && p[1] == ')';
            s = position ? begin_capture(m, s, p + 2, POSITION) : begin_capture(m, s, p + 1, OPEN);
            break;
        }
        if (*p == ')') {
            s = end_capture(m, s, p + 1);
            break;
        }
        if (*p == '$' && p + 1 == m->pattern_end) {
            if (s != m->text_end) s = NULL;
            break;
        }
        if (match_escape(m, &s, &p)) continue;
        if (!match_single(m, &s, &p)) break;
    }
    m->depth++;
    return s;
}

/* ---- captures out ---- */

static void push_capture(matcher *m, int which, const char *s, const char *end)
{
    if (which >= m->level) {
        if (which != 0) luaL_error(m->L, "invalid capture index %%%d", which + 1);
        lua_pushlstring(m->L, s, (size_t)(end - s)); /* without captures, the whole match */
        return;
    }
    ptrdiff_t length = m->captures[which].length;
    if (length == OPEN) luaL_error(m->L, "unfinished capture");
    if (length == POSITION)
        lua_pushinteger(m->L, m->captures[which].at - m->text + 1);
    else
        lua_pushlstring(m->L, m->captures[which].at, (size_t)length);
}

/* All captures; the whole match where there are none and s is not NULL. */
static int push_captures(matcher *m, const char *s, const char *end)
{
    int count = m->level == 0 && s ? 1 : m->level;
    luaL_checkstack(m->L, count, "too many captures");
    for (int i = 0; i < count; i++) push_capture(m, i, s, end);
    return count;
}

static matcher make_matcher(lua_State *L, const char *text, size_t length, const char *pattern_end)
{
    patterns_poll *poll = (patterns_poll *)lua_touserdata(L, lua_upvalueindex(1));
    return (matcher){.L = L,
                     .poll = poll,
                     .text = text,
                     .text_end = text + length,
                     .pattern_end = pattern_end,
                     .steps = PATTERNS_POLL_STEPS};
}

/* The match that begins at s, anew. */
static const char *match_at(matcher *m, const char *s, const char *p)
{
    m->level = 0, m->depth = MAX_DEPTH;
    step(m);
    return match_here(m, s, p);
}

/* ---- find and match ---- */

/* Where a search begins, from 0; more than `length`: nowhere. */
static size_t start_of(lua_State *L, int index, size_t length)
{
    lua_Integer init = luaL_optinteger(L, index, 1);
    if (init > 0) return (size_t)init - 1;
    if (init == 0 || init < -(lua_Integer)length) return 0;
    return length - (size_t)-init;
}

static bool is_plain(const char *pattern, size_t length)
{
    for (size_t i = 0; i < length; i++)
        if (pattern[i] && strchr("^$*+?.([%-", pattern[i])) return false;
    return true;
}

/* The first place of `wanted` in text, asked piece by piece. */
static const char *find_plain(lua_State *L, patterns_poll *poll, const char *text, size_t length, const char *wanted,
                              size_t size)
{
    size_t piece = (size_t)1 << 20;
    while (length >= size) {
        size_t window = length < piece + size ? length : piece + size;
        const char *found = memmem(text, window, wanted, size);
        if (found || window == length) return found;
        text += piece, length -= piece;
        poll(L);
    }
    return NULL;
}

static int search(lua_State *L, bool find)
{
    size_t length, size;
    const char *text = luaL_checklstring(L, 1, &length), *p = luaL_checklstring(L, 2, &size);
    size_t start = start_of(L, 3, length);
    if (start > length) {
        lua_pushnil(L);
        return 1;
    }
    matcher m = make_matcher(L, text, length, p + size);
    if (find && (lua_toboolean(L, 4) || is_plain(p, size))) {
        const char *at = find_plain(L, m.poll, text + start, length - start, p, size);
        if (!at) lua_pushnil(L);
        if (at) lua_pushinteger(L, at - text + 1), lua_pushinteger(L, at - text + (ptrdiff_t)size);
        return at ? 2 : 1;
    }
    bool anchored = size > 0 && *p == '^';
    const char *s = text + start;
    do {
        const char *end = match_at(&m, s, p + anchored);
        if (end && !find) return push_captures(&m, s, end);
        if (end) {
            lua_pushinteger(L, s - text + 1);
            lua_pushinteger(L, end - text);
            return push_captures(&m, NULL, NULL) + 2;
        }
    } while (s++ < m.text_end && !anchored);
    lua_pushnil(L);
    return 1;
}

static int find(lua_State *L) { return search(L, true); }
static int match(lua_State *L) { return search(L, false); }

/* ---- gmatch ---- */

/* Upvalues: poll, text, pattern, where the next search begins, where the last match ended (-1: nowhere). */
static int next_match(lua_State *L)
{
    size_t length, size;
    const char *text = lua_tolstring(L, lua_upvalueindex(2), &length);
    const char *p = lua_tolstring(L, lua_upvalueindex(3), &size);
    lua_Integer last = lua_tointeger(L, lua_upvalueindex(5));
    matcher m = make_matcher(L, text, length, p + size);
    for (lua_Integer at = lua_tointeger(L, lua_upvalueindex(4)); at <= (lua_Integer)length; at++) {
        const char *end = match_at(&m, text + at, p);
        if (!end || end - text == last) continue;
        lua_pushinteger(L, end - text);
        lua_copy(L, -1, lua_upvalueindex(4));
        lua_replace(L, lua_upvalueindex(5));
        return push_captures(&m, text + at, end);
    }
    return 0;
}

static int gmatch(lua_State *L)
{
    size_t length;
    luaL_checklstring(L, 1, &length);
    luaL_checkstring(L, 2);
    size_t start = start_of(L, 3, length);
    lua_settop(L, 2);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_pushinteger(L, start > length ? (lua_Integer)length + 1 : (lua_Integer)start);
    lua_pushinteger(L, -1);
    lua_pushcclosure(L, next_match, 5);
    return 1;
}

/* ---- gsub ---- */

/* Appends the replacement string at 3, with its "%0" to "%9". */
static void add_text(matcher *m, luaL_Buffer *out, const char *s, const char *end)
{
    lua_State *L = m->L;
    size_t length;
    const char *text = lua_tolstring(L, 3, &length);
    for (const char *stop = text + length; text < stop;) {
        const char *percent = memchr(text, '%', (size_t)(stop - text));
        luaL_addlstring(out, text, (size_t)((percent ? percent : stop) - text));
        if (!percent) return;
        text = percent + 2;
        int c = percent + 1 < stop ? byte_at(percent + 1) : 0;
        if (c == '%') {
            luaL_addchar(out, '%');
        } else if (c == '0') {
            luaL_addlstring(out, s, (size_t)(end - s));
        } else if (isdigit(c)) {
            push_capture(m, c - '1', s, end);
            luaL_tolstring(L, -1, NULL);
            lua_remove(L, -2);
            luaL_addvalue(out);
        } else {
            luaL_error(L, "invalid use of '%%' in replacement string");
        }
    }
}

/* Appends what the match becomes; true: it was replaced. */
static bool add_value(matcher *m, luaL_Buffer *out, const char *s, const char *end, int type)
{
    lua_State *L = m->L;
    if (type == LUA_TFUNCTION) {
        lua_pushvalue(L, 3);
        lua_call(L, push_captures(m, s, end), 1);
    } else if (type == LUA_TTABLE) {
        push_capture(m, 0, s, end);
        lua_gettable(L, 3);
    } else {
        add_text(m, out, s, end);
        return true;
    }
    if (!lua_toboolean(L, -1)) {
        lua_pop(L, 1);
        luaL_addlstring(out, s, (size_t)(end - s));
        return false;
    }
    if (!lua_isstring(L, -1)) luaL_error(L, "invalid replacement value (a %s)", luaL_typename(L, -1));
    luaL_addvalue(out);
    return true;
}

static int gsub(lua_State *L)
{
    size_t length, size;
    const char *s = luaL_checklstring(L, 1, &length), *p = luaL_checklstring(L, 2, &size), *last = NULL;
    int type = lua_type(L, 3);
    luaL_argexpected(L, type == LUA_TNUMBER || type == LUA_TSTRING || type == LUA_TFUNCTION || type == LUA_TTABLE, 3,
                     "string/function/table");
    lua_Integer most = luaL_optinteger(L, 4, (lua_Integer)length + 1), count = 0;
    bool anchored = size > 0 && *p == '^', changed = false;
    if (type == LUA_TNUMBER) lua_tostring(L, 3);
    matcher m = make_matcher(L, s, length, p + size);
    luaL_Buffer out;
    luaL_buffinit(L, &out);
    while (count < most) {
        const char *end = match_at(&m, s, p + anchored);
        if (end && end != last) {
            count++;
            changed |= add_value(&m, &out, s, end, type);
            s = last = end;
        } else if (s < m.text_end) {
            luaL_addchar(&out, *s++);
        } else {
            break;
        }
        if (anchored) break;
    }
    if (changed) {
        luaL_addlstring(&out, s, (size_t)(m.text_end - s));
        luaL_pushresult(&out);
    } else {
        lua_pushvalue(L, 1);
    }
    lua_pushinteger(L, count);
    return 2;
}

void patterns_open(lua_State *L, patterns_poll *poll)
{
    static const luaL_Reg functions[] = {
        {"find", find}, {"match", match}, {"gmatch", gmatch}, {"gsub", gsub}, {NULL, NULL}};
    lua_pushlightuserdata(L, (void *)poll);
    luaL_setfuncs(L, functions, 1);
}
