-- The menu kit by keys, the game's own, and by typed letters: what is chosen, slid, switched and picked.

local menu = require "menu"
local settings, log, level, back = nil, {}, nil, 0

function daft.load()
    local function changed(name) return function(value) log[name] = value end end
    settings = menu.new { title = "Settings", visible = 4, back = function() back = back + 1 end, rows = {
        { label = "Choose" },
        { label = "Start", action = function() log.start = (log.start or 0) + 1 end },
        { label = "Volume", from = 0, to = 10, value = 9, changed = changed "volume" },
        { label = "Shadows", value = true, changed = changed "shadows" },
        { label = "Level", choices = { "Meadow", "Tower", "Ice" }, value = 1, changed = changed "level" },
        { label = "Name", text = "Zoë", longest = 4, changed = changed "name" },
    } }
    assert(settings.chosen == 2, "labels cannot be chosen")
    assert(not pcall(menu.new, { rows = { { label = "x" } }, align = "above" }))
    local heard, picked = "", 0
    local side = menu.new { title = "Side", align = "right", margin = 30, top = 200, width = 300, heard = function(what) heard = heard .. what end,
        rows = { { label = "One", note = function() return "locked" end, locked = function() return picked == 0 end, action = function() picked = picked + 1 end } } }
    side:pick()
    assert(picked == 0 and heard == "", "a locked row is not picked")
    picked = 1
    side:pick()
    assert(picked == 2 and heard == "pick")
    local box = side:box()
    assert(box.x == daft.width() - 330 and box.y == 200)
    assert(not pcall(menu.new, { rwos = {} }) and not pcall(menu.new, { rows = {} }))
    local halves = menu.columns(menu.box(0, 0, 210, 50), 2, 10)
    assert(halves[1].width == 100 and halves[2].x == 110 and halves[2].height == 50)
    local thirds = menu.rows(menu.box(0, 10, 30, 90), { 1, 2 })
    assert(thirds[1].height == 30 and thirds[2].y == 40 and thirds[2].height == 60)
    local corner = menu.place(menu.screen(10), 100, 50, "right", "bottom")
    assert(corner.x == daft.width() - 110 and corner.y == 660)
end

function daft.textinput(letter) settings:textinput(letter) end

local presses = { "return", "down", "right", "right", "left", "down", "space", "down", "return", "return", "return", "left",
    "right", "down", "backspace", "backspace", "down", "backspace", "up" }
local function expect(tick, name, value)
    if daft.tick() == tick and log[name] ~= value then error(("tick %d: %s is %s"):format(tick, name, tostring(log[name]))) end
end

function daft.update()
    local tick = daft.tick()
    local key = presses[tick // 4 + 1]
    if key and tick % 4 == 0 then daft.input.set(key, true) end
    if key and tick % 4 == 2 then daft.input.set(key, false) end
    settings:update()
    expect(3, "start", 1)
    expect(15, "volume", 10)
    expect(19, "volume", 9)
    expect(27, "shadows", false)
    expect(35, "level", 2)
    expect(43, "level", 1)
    expect(51, "level", 2)
    if tick == 55 then settings:textinput("ë") settings:textinput("x") end
    expect(56, "name", "Zoëë")
    expect(63, "name", "Zo")
    if tick == 71 then assert(back == 1 and settings.chosen == 2 and settings.first == 2) end
    if tick == 80 then daft.quit() end
end

function daft.draw() settings:draw() end
