-- Lists to choose from, by keys, mouse or gamepad. They stand at the left, so that the mouse finds them at any width.

local controls = require "controls"
local sounds = require "sounds"

local menus = {}

local LEFT, TOP, LINE, WIDTH = 70, 270, 42, 470 -- HUD units

local open, at

-- items: list of {label =, act = function, change = function(step), value = function: text, level = function: 0 to 1, locked =}.
-- back: a function.
function menus.show(title, items, back)
    open, at = { title = title, items = items, back = back }, 1
end

function menus.close() open = nil end
function menus.shown() return open ~= nil end
function menus.size() return open and #open.items or 0 end

local function move(step)
    at = (at - 1 + step) % #open.items + 1
    sounds.play("tick")
end

local mouse_x, mouse_y = -1, -1
local function point()
    local x, y = daft.input.mouse()
    local item = math.floor((y - TOP) / LINE) + 1
    local inside = x > LEFT - 20 and x < LEFT + WIDTH and open.items[item] ~= nil
    if inside and (x ~= mouse_x or y ~= mouse_y) and item ~= at then
        at = item
        sounds.play("tick")
    end
    mouse_x, mouse_y = x, y
    return inside
end

local function change(step)
    local item = open.items[at]
    if not item.change then return end
    item.change(step)
    sounds.play("tick")
end

function menus.update()
    local inside = point()
    local pressed = daft.input.pressed
    if pressed("up") or pressed("w") or pressed("pad up") then move(-1) end
    if pressed("down") or pressed("s") or pressed("pad down") then move(1) end
    if pressed("left") or pressed("a") or pressed("pad left") then change(-1) end
    if pressed("right") or pressed("d") or pressed("pad right") then change(1) end
    if controls.back() and open.back then
        sounds.play("tick")
        return open.back()
    end
    if not controls.confirm() or (pressed("mouse1") and not inside) then return end
    local item = open.items[at]
    if item.locked then return end
    sounds.play("choose")
    if item.act then item.act() elseif item.change then item.change(1) end
end

function menus.draw()
    if not open then return end
    daft.rect(LEFT - 30, TOP - 84, WIDTH + 40, #open.items * LINE + 110, "#1a1426b0")
    daft.text(open.title, LEFT, TOP - 66, { size = 40, color = "#ffd878" })
    for i, item in ipairs(open.items) do
        local y = TOP + (i - 1) * LINE
        if i == at then daft.rect(LEFT - 14, y - 2, WIDTH + 8, LINE - 4, "#ffffff30") end
        daft.text(item.label, LEFT, y + 3, { size = 27, color = item.locked and "#8a8494" or i == at and "#ffffff" or "#e8dcc8" })
        if item.level then
            daft.rect(LEFT + WIDTH - 224, y + 12, 200, 14, "#00000060")
            daft.rect(LEFT + WIDTH - 224, y + 12, 200 * item.level(), 14, "#ffd878")
        end
        if item.value then daft.text(item.value(), LEFT + WIDTH - 24, y + 3, { size = 27, align = "right", color = "#ffd878" }) end
    end
end

return menus
