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
