-- Sandbox: what a game gets of Lua is the same on every machine and reaches nothing outside.

local function expect_error(pattern, f, ...)
    local good, message = pcall(f, ...)
    assert(not good and tostring(message):find(pattern, 1, true), tostring(message))
end

-- pairs() goes in a fixed order.
local mixed = { z = 1, a = 2, [10] = 3, [2.5] = 4, [true] = 5, [false] = 6, [-1] = 7, ab = 8, "one", "two" }
local order = {}
for key in pairs(mixed) do order[#order + 1] = tostring(key) end
assert(table.concat(order, " ") == "-1 1 2 2.5 10 a ab z false true", table.concat(order, " "))

-- Keys taken out on the way are passed over; values changed on the way are seen.
local seen, t = {}, { a = 1, b = 2, c = 3, d = 4 }
for key, value in pairs(t) do
    seen[#seen + 1] = key .. value
    t.b, t.c = nil, 30
end
assert(table.concat(seen, " ") == "a1 c30 d4")
for _ in pairs({}) do error("an empty table has no pairs") end
local custom = setmetatable({}, { __pairs = function() return function(_, k) if not k then return 1, 2 end end, nil, nil end })
for k, v in pairs(custom) do assert(k == 1 and v == 2) end
expect_error("table expected", pairs, nil)

-- table.sort is stable, and leaves the table alone when a comparison fails.
local list = {}
for i = 1, 200 do list[i] = { key = (i * 7) % 5, i = i } end
table.sort(list, function(a, b) return a.key < b.key end)
for i = 2, 200 do
    local a, b = list[i - 1], list[i]
    assert(a.key < b.key or (a.key == b.key and a.i < b.i))
end
local words = { "pear", "apple", "fig" }
table.sort(words)
assert(table.concat(words, " ") == "apple fig pear")
expect_error("attempt to compare", table.sort, { 3, "a", 1 })
table.sort({})

-- Random numbers: from a seed, one sequence, in their range.
math.randomseed(7)
local a, b = math.random(), daft.random(1, 1000000)
daft.randomseed(7)
assert(math.random() == a and math.random(1, 1000000) == b)
for _ = 1, 1000 do
    local n, x = math.random(3), math.random()
    assert(n >= 1 and n <= 3 and x >= 0 and x < 1)
end
assert(math.random(5, 5) == 5)
math.random(math.mininteger, math.maxinteger)
expect_error("high", math.random, 2, 1)

-- math is close to what it should be, and a number's text is its own.
assert(math.abs(math.sin(1) - 0.8414709848078965) < 1e-14 and math.abs(math.atan(1, -1) - 2.356194490192345) < 1e-14)
assert(math.abs(math.exp(1) - 2.718281828459045) < 1e-12 and math.abs(math.log(10) - 2.302585092994046) < 1e-12)
assert(math.abs(math.pow(2, 0.5) - math.sqrt(2)) < 1e-12 and math.pow(-2, 3) == -8 and math.log(8, 2) == 3)
assert(math.log(-1) ~= math.log(-1) and 3 ^ 2 == 9)

-- Nothing leads outside.
assert(dofile == nil and loadfile == nil and package == nil and string.dump == nil and debug.getregistry == nil)
assert(type(debug.traceback()) == "string")
expect_error("io is not there in games", function() return io.open end)
expect_error("os is not there in games", function() return os.time() end)
assert(load("return 1 + 1")() == 2)
assert(load("return x", "chunk", "t", { x = 3 })() == 3)
assert(select(2, load("return +")):find("unexpected symbol"))
assert(load("\27Lua") == nil)
expect_error("leads outside", daft.mesh, "/etc/passwd")
expect_error("leads outside", daft.sky.image, "../../assets/sky/day.jpg")
expect_error("leads outside", daft.scene, "levels/../../x.scene")
expect_error("there is no file 'a..b/..c.scene'", daft.scene, "a..b/..c.scene")
expect_error("not a module's name", require, "../outside")
expect_error("there is no 'nothing.lua'", require, "nothing")
expect_error("did you mean", function() return daft.camera.lok end)
assert(getmetatable(daft) == false)

-- Modules: the game's own folder first, loaded once; a loop is an error.
assert(require("part").value == 5 and require("part") == require("part") and require("daft") == daft)
expect_error("requires itself", require, "ring")

-- Coroutines and errors that are not strings work as ever.
local co = coroutine.wrap(function(x) local y = coroutine.yield(x + 1) return y * 2 end)
assert(co(1) == 2 and co(5) == 10)
local good, value = pcall(function() local c = coroutine.wrap(function() error({ code = 3 }) end) c() end)
assert(not good and value.code == 3)
assert(select("#", pcall(function() return 1, nil, nil end)) == 4)
local inner = coroutine.create(function() local ok, got = pcall(coroutine.yield, 1) return ok, got end)
assert(select(2, coroutine.resume(inner)) == 1)
local _, ok, got = coroutine.resume(inner, "back")
assert(ok == true and got == "back")
assert(xpcall(function() error("x") end, function(m) return m end) == false)

-- What could run for ever where no watchdog looks.
expect_error("__gc is not there", setmetatable, {}, { __gc = print })
expect_error("too many elements", table.move, {}, 1, 1 << 62, 2)
expect_error("the list is too long", table.insert, setmetatable({}, { __len = function() return 1 << 61 end }), 1, 0)
assert(("").rep("", 1 << 62) == "" and ("ab"):rep(2, ",") == "ab,ab")
assert(getmetatable(setmetatable({}, { __index = {} })).__index and #table.move({ 1, 2, 3 }, 1, 3, 2) == 4)
expect_error("protected", setmetatable, setmetatable({}, { __metatable = 1 }), {})

-- Memory has an end, and running into it is an error like any other.
expect_error("resulting string too large", function() return ("x"):rep(1 << 30) end)
local half = ("x"):rep(40 << 20)
expect_error("not enough memory", function() return half .. half end)
half = nil

-- string.rep, load, pairs and what calls: as in Lua, though made anew.
for count = -1, 20 do
    local want = {}
    for i = 1, count do want[i] = "abc" end
    assert(("abc"):rep(count, "--") == table.concat(want, "--") and ("abc"):rep(count) == table.concat(want))
end
local long = "return " .. ("1 + "):rep(50000) .. "1"
assert(load(long)() == 50001 and load("x = ", "=name") == nil and select(2, load("x = ", "=name")):find("^name:1:"))
local many, last = {}, 0
for i = 1, 10000 do many[(i * 7919) % 10007] = i end
for key in pairs(many) do
    assert(key > last)
    last = key
end
assert(last == 10006)
local closed = {}
local function closer(name) return setmetatable({}, { __close = function(_, e) closed[#closed + 1] = name .. ":" .. tostring(e) end }) end
local held = coroutine.create(function()
    local a <close> = closer("a")
    coroutine.yield(1)
end)
assert(coroutine.resume(held) and coroutine.close(held) and coroutine.status(held) == "dead" and closed[1] == "a:nil")
local failing = coroutine.wrap(function()
    local a <close> = closer("w")
    error("wrapped", 0)
end)
expect_error("wrapped", failing)
assert(closed[2] == "w:wrapped")
expect_error("cannot resume dead coroutine", failing)
expect_error("cannot close a running coroutine", coroutine.close, (coroutine.running()))
assert(select(2, coroutine.resume(held)) == "cannot resume dead coroutine")
local good_close, why = coroutine.close(coroutine.create(error))
assert(good_close and why == nil)
assert(select(2, xpcall(error, debug.traceback, "boom")):find("^boom\nstack traceback:\n\t%[C%]: in function 'error'"))
assert(select("#", xpcall(function(...) return ... end, print, 1, nil, nil)) == 4)
-- Coroutines that close each other without end use up no stack of C's.
local depth = 0
local function nest()
    depth = depth + 1
    local co = coroutine.create(function()
        local x <close> = setmetatable({}, { __close = nest })
        coroutine.yield()
    end)
    coroutine.resume(co)
    coroutine.close(co)
end
pcall(nest)
assert(depth > 10 and depth < 1000)

-- Texts show no addresses, which differ from run to run, but numbers in the order in which they were asked for.
local first, second = {}, {}
assert(tostring(second) == "table 1" and tostring(first) == "table 2" and tostring(second) == "table 1")
assert(tostring(print) == "function 3" and tostring(coroutine.create(print)) == "thread 4")
assert(("%s|%5s|%%|%d|%s"):format(first, "a", 3, nil) == "table 2|    a|%|3|nil")
assert(tostring(setmetatable({}, { __name = "Enemy" })):find("^Enemy %d+$"))
assert(("%s"):format(setmetatable({}, { __tostring = function() return "own" end })) == "own")
expect_error("no %p in games", string.format, "%-10p", {})
expect_error("no value", string.format, "%s")
expect_error("must return a string", tostring, setmetatable({}, { __tostring = function() return {} end }))
for _ = 1, 100 do tostring({}) end
assert(tostring(first) == "table 2") -- the others are forgotten, their numbers are not given again
local drawn = {}
function daft.draw()
    assert(tostring(first) == "table 2" and tostring(drawn):find("^table draw %d+$"), tostring(drawn))
end

-- What is nearly right is said.
expect_error("did you mean 'meshes/island.obj'", daft.mesh, "meshes/ilsand.obj")
expect_error("did you mean 'checker'", daft.entity, { box = { 1, 1, 1 }, material = "chekcer" })
expect_error('did you mean "sine"', daft.sound, { wave = "sinus" })
expect_error("did you mean 'color'", daft.entity, { box = { 1, 1, 1 }, material = { colour = "#fff" } })
expect_error("a colour is a material", daft.entity, { box = { 1, 1, 1 }, colour = "#fff" })

function daft.update() end
