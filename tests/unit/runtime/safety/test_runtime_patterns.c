/* runtime: string.find, match, gmatch and gsub in games give what Lua's own give, and can be stopped. */
#include "fixtures.h"

#include "lua/patterns.h"

#include <lualib.h>

static int polls;
static void count_poll(lua_State *L)
{
    if (++polls > 1000) luaL_error(L, "stopped");
}
static void no_poll(lua_State *L) { (void)L; }

/* Globals `lua`, the string library as it comes, and `ours`. */
static lua_State *make_state(patterns_poll *poll)
{
    lua_State *L = luaL_newstate();
    luaL_openlibs(L);
    lua_newtable(L);
    lua_getglobal(L, "string");
    for (lua_pushnil(L); lua_next(L, -2);) {
        lua_pushvalue(L, -2);
        lua_insert(L, -2);
        lua_settable(L, -5);
    }
    lua_pop(L, 1);
    lua_setglobal(L, "lua");
    lua_newtable(L);
    patterns_open(L, poll);
    lua_setglobal(L, "ours");
    return L;
}

static const char *const COMPARE =
    "local state = seed\n"
    "local function random(n)\n"
    "  state = (state * 6364136223846793005 + 1442695040888963407) & 0x7fffffffffffffff\n"
    "  return (state >> 33) % n\n"
    "end\n"
    "local patterns = "
    "{'a','b','ab','%a','%d','%w','%s','%u','%P','.','[ab]','[^a]','[%a_]','[a-c]','[]a]','(',')','()',\n"
    "  '%b()','%f[%w]','%1','%2','*','+','-','?','^','$','%','[',']','\\0','1',' ','x','\\xff'}\n"
    "local texts = {'a','b','ab','1',' ','(',')','c','_','x','aa',']','A','\\0','\\xff'}\n"
    "local replacements = {'x','%0','%1','%1%2','%%','%','<%0>','%9',12,{a='A',b=false,ab=1},\n"
    "  function(a, b) return b or a end, function() end, function() return {} end}\n"
    "local function draw(list, n)\n"
    "  local parts = {}\n"
    "  for i = 1, random(n) do parts[i] = list[random(#list) + 1] end\n"
    "  return table.concat(parts)\n"
    "end\n"
    "local function shown(...)\n"
    "  local parts = {}\n"
    "  for i = 1, select('#', ...) do parts[i] = tostring((select(i, ...))) end\n"
    "  return table.concat(parts, '|')\n"
    "end\n"
    "local function all(library, ...)\n"
    "  local parts = {}\n"
    "  for a, b, c in library.gmatch(...) do parts[#parts + 1] = shown(a, b, c) end\n"
    "  return table.concat(parts, ';')\n"
    "end\n"
    "local function answers(library, s, p, init, r, n)\n"
    "  return shown(pcall(library.find, s, p, init)) .. '\\n' .. shown(pcall(library.match, s, p, init)) .. '\\n' ..\n"
    "    shown(pcall(library.find, s, p, init, true)) .. '\\n' .. shown(pcall(all, library, s, p, init)) .. '\\n' ..\n"
    "    shown(pcall(library.gsub, s, p, r, n))\n"
    "end\n"
    "for i = 1, 20000 do\n"
    "  local s, p = draw(texts, 12), draw(patterns, 7)\n"
    "  local init, n = random(3) == 0 and random(20) - 10 or nil, random(4) == 0 and random(5) - 1 or nil\n"
    "  local r = replacements[random(#replacements) + 1]\n"
    "  local a, b = answers(lua, s, p, init, r, n), answers(ours, s, p, init, r, n)\n"
    "  if a ~= b then error(('%q, %q: Lua says\\n%s\\nand we\\n%s'):format(s, p, a, b)) end\n"
    "end\n";

static void they_answer_as_lua_does(void **unused)
{
    (void)unused;
    fixture_seed(0x5eed);
    lua_State *L = make_state(no_poll);
    lua_pushinteger(L, (lua_Integer)(fixture_state >> 1));
    lua_setglobal(L, "seed");
    if (luaL_dostring(L, COMPARE)) fail_msg("%s", lua_tostring(L, -1));
    lua_close(L);
}

static void each_can_be_stopped(void **unused)
{
    (void)unused;
    static const char *const endless[] = {
        "ours.find(('a'):rep(40), ('a?'):rep(40) .. ('a'):rep(60))",
        "ours.match(('a'):rep(100000), '.-.-.-.-b')",
        "ours.match(('('):rep(300000), '%b()b')",
        "for w in ours.gmatch(('a'):rep(100000), '.-.-.-.-b') do end",
        "ours.gsub(('ab'):rep(100000), '%f[%w].-.-c', '')",
        "ours.find(('a'):rep(3000000), ('[' .. ('b'):rep(1000) .. ']'):rep(3))",
    };
    for (size_t i = 0; i < sizeof endless / sizeof endless[0]; i++) {
        lua_State *L = make_state(count_poll);
        polls = 0;
        assert_true(luaL_dostring(L, endless[i]));
        assert_non_null(strstr(lua_tostring(L, -1), "stopped"));
        lua_close(L);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(they_answer_as_lua_does),
                                       cmocka_unit_test(each_can_be_stopped)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
