local test = require "test"
local catapult = require "catapult"
local blocks = require "blocks"
local bot = require "bot"

local function begin()
    test.press("return")
    test.wait_for(function() return game.state == "fly" end, 2)
    test.press("return")
    test.wait_for(function() return game.state == "aim" end, 2)
end

test("the title plays the first level", function()
    test.equal(game.state, "title")
    begin()
    test.equal(game.number, 1)
    test.equal(game.kings, 1)
end)

test("keys aim", function()
    begin()
    local yaw, pitch = catapult.yaw, catapult.pitch
    test.press("right", 0.5)
    test.above(catapult.yaw, yaw)
    test.press("s", 0.5)
    test.below(catapult.pitch, pitch)
end)

test("a tap throws nothing, and holding does", function()
    begin()
    test.press("space")
    test.ticks(5)
    test.equal(game.state, "aim")
    test.press("space", 0.5)
    test.ticks(20)
    test.equal(game.state, "watch")
    test.near(game.last_pull, 0.5 / 1.5, 0.03)
end)

test("the bot wins the first level with one shot", function()
    bot.toggle()
    test.wait_for(function() return game.state == "won" end, 60)
    test.equal(game.stars, 3)
    test.equal(game.shot, 1)
    test.equal(blocks.kings_left(), 0)
end)

test("backspace leaves a level, and R begins it again", function()
    begin()
    test.press("space", 0.5)
    test.ticks(30)
    test.press("r")
    test.ticks(5)
    test.equal(game.state, "fly")
    test.press("backspace")
    test.ticks(5)
    test.equal(game.state, "title")
end)

test("the first level is lost where nothing is hit", function()
    begin()
    for shot = 1, 3 do
        test.wait_for(function() return game.state == "aim" and game.shot == shot end, 12)
        test.press("space", 0.1)
        test.ticks(60)
    end
    test.wait_for(function() return game.state == "lost" end, 12)
end)

-- What live reload does, in one and the same code.
local function reload()
    local old = daft.keep()
    daft.reload(old)
    return old, daft.keep()
end

local function same(old, new, path)
    if math.type(old) == "float" then return test.near(new, old, 1e-6, path) end -- a rotation's length is made 1 again
    if type(old) ~= "table" then return test.equal(new, old, path) end
    for name, value in pairs(old) do
        if path ~= "old.camera" then same(value, new[name], path .. "." .. tostring(name)) end
    end
end

test("a shot on its way flies on in new code", function()
    begin()
    test.press("left", 0.3)
    test.press("space", 0.8)
    test.wait_for(function() return game.ball end, 2)
    test.ticks(90)
    test.equal(game.state, "watch")
    local old, new = reload()
    same(old, new, "old")
    test.equal(new.flies, true)
    test.wait_for(function() return game.state == "aim" or game.state == "lost" end, 20)
    test.equal(game.shot, 2)
    old, new = reload()
    same(old, new, "old")
    test.equal(new.flies, false)
end)

test("a level that has been won stays won in new code", function()
    bot.toggle()
    test.wait_for(function() return game.state == "won" end, 60)
    local old, new = reload()
    same(old, new, "old")
    test.equal(new.game.points, game.points)
    test.equal(#new.blocks.down, 1)
    test.equal(new.blocks.down[1], true)
end)

test("a level that is built otherwise begins anew", function()
    begin()
    local old = daft.keep()
    old.blocks.starts[1][1] = old.blocks.starts[1][1] + 1
    daft.reload(old)
    test.equal(game.state, "fly")
end)
