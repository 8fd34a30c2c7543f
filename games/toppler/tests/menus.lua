local test = require "test"
local menus = require "menus"
local progress = require "progress"

local function down(times)
    for _ = 1, times do
        test.press("down")
        test.ticks(2)
    end
end

test("levels that were not reached are locked", function()
    down(1)
    test.press("return")
    test.ticks(2)
    test.equal(menus.size(), 10)
    down(1)
    test.press("return")
    test.ticks(5)
    test.equal(game.state, "title")
    test.press("up")
    test.press("return")
    test.ticks(5)
    test.equal(game.state, "fly")
end)

test("settings are kept", function()
    down(2)
    test.press("return")
    test.ticks(2)
    test.press("left")
    test.ticks(2)
    test.equal(progress.settings.music, 5)
    down(2)
    test.press("space")
    test.ticks(2)
    test.equal(progress.settings.arc, false)
    test.equal(daft.load_saved("progress").settings.music, 5)
    test.press("backspace")
    test.ticks(2)
    test.equal(menus.size(), 5)
end)

test("what was kept but makes no sense is left out", function()
    daft.save("progress", { best = { { points = "x", stars = 9 }, { points = 100, stars = 9 } }, settings = { music = 99, arc = "yes" } })
    progress.load(10)
    test.equal(progress.best[1], nil)
    test.equal(progress.best[2].stars, 3)
    test.equal(progress.settings.music, 10)
    test.equal(progress.settings.arc, true)
end)
