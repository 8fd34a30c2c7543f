-- The lists of the title, in the looks and with the sounds of this game. They stand at the left, beside the towers.

local menu = require "menu"
local sounds = require "sounds"

local menus = {}

local LOOKS = { row = "#1a1426c8", chosen = "#b8862ce0", text = "#fff6e4", dim = "#a89fb4", bar = "#00000060", filled = "#ffd878" }

local open

local function heard(what) sounds.play(what == "pick" and "choose" or "tick") end

-- rows: those of menu.new; back: a function, or nil.
function menus.show(title, rows, back)
    local many = #rows > 6
    open = menu.new { title = title, rows = rows, heard = heard, looks = LOOKS, align = "left", margin = 60, width = 500,
        top = many and 212 or 290, row_height = many and 44 or 50, size = 25, visible = 10,
        back = back and function()
            heard("move")
            back()
        end }
end

function menus.close() open = nil end
function menus.shown() return open ~= nil end
function menus.size() return open and #open.rows or 0 end
function menus.update() open:update() end

function menus.draw()
    if open then open:draw() end
end

return menus
