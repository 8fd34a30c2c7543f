-- Menus of a game: lists of rows that are chosen, slid, switched and typed into, by keyboard, mouse and gamepad; and
-- boxes on the screen to lay things out.
--
--     local menu = require "menu"
--     local settings = menu.new { title = "Settings", rows = {
--         { label = "Start", action = function() playing = true end },
--         { label = "Volume", from = 0, to = 10, value = 8, changed = function(v) daft.sound.volume(v / 10) end },
--         { label = "Shadows", value = true, changed = function(on) … end },
--         { label = "Level", choices = { "Meadow", "Tower" }, value = 1, changed = function(i) level = i end },
--         { label = "Name", text = "Ada", longest = 12, changed = function(text) name = text end },
--     } }
--     function daft.update(dt) settings:update() end
--     function daft.draw() settings:draw() end
--     function daft.textinput(letter) settings:textinput(letter) end   -- only for rows that are typed into

local menu = {}

-- ---- boxes: { x =, y =, width =, height = }, in units ----

function menu.box(x, y, width, height) return { x = x, y = y, width = width, height = height } end

-- The whole picture but for a margin.
function menu.screen(margin)
    margin = margin or 0
    return menu.box(margin, margin, daft.width() - 2 * margin, daft.height() - 2 * margin)
end

-- A box of this size in another: "left", "center" or "right"; "top", "middle" or "bottom".
function menu.place(outer, width, height, across, down)
    local fractions = { left = 0, center = 0.5, right = 1, top = 0, middle = 0.5, bottom = 1 }
    local x, y = fractions[across or "center"], fractions[down or "middle"]
    if not x or not y then error(("menu.place: no place '%s', '%s'"):format(tostring(across), tostring(down)), 2) end
    return menu.box(outer.x + (outer.width - width) * x, outer.y + (outer.height - height) * y, width, height)
end

local function split(outer, parts, gap, place, size)
    if type(parts) == "number" then
        local count = parts
        parts = {}
        for i = 1, count do parts[i] = 1 end
    end
    local sum, boxes, at = 0, {}, outer[place]
    for _, part in ipairs(parts) do sum = sum + part end
    local room = outer[size] - (gap or 0) * (#parts - 1)
    for i, part in ipairs(parts) do
        local box = menu.box(outer.x, outer.y, outer.width, outer.height)
        box[place], box[size] = at, room * part / sum
        at = at + box[size] + (gap or 0)
        boxes[i] = box
    end
    return boxes
end

-- Boxes beside each other, and below each other: so many, or of these proportions, with a gap between them.
function menu.columns(outer, parts, gap) return split(outer, parts, gap, "x", "width") end
function menu.rows(outer, parts, gap) return split(outer, parts, gap, "y", "height") end

function menu.inside(box, x, y)
    return x >= box.x and x < box.x + box.width and y >= box.y and y < box.y + box.height
end

-- ---- menus ----

local Menu = {}
Menu.__index = Menu

local looks = {
    row = "#0c111ed8", chosen = "#4084ffeb", text = "#f5f7fa", dim = "#b0bcce", bar = "#ffffff40", filled = "#f5f7fa",
}

local fields = { title = true, rows = true, back = true, width = true, row_height = true, size = true, visible = true, looks = true, font = true,
    align = true, margin = true, top = true, heard = true }

function menu.new(def)
    for key in pairs(def) do
        if not fields[key] then error(("menu.new: there is no '%s'"):format(tostring(key)), 2) end
    end
    if type(def.rows) ~= "table" or #def.rows == 0 then error("menu.new: rows expected", 2) end
    local self = setmetatable({
        title = def.title, rows = def.rows, back = def.back, width = def.width or 560, row_height = def.row_height or 58,
        size = def.size or 26, visible = def.visible or 8, font = def.font, chosen = 1, first = 1, held = 0, looks = {},
        align = def.align or "center", margin = def.margin or 70, top = def.top, heard = def.heard,
    }, Menu)
    menu.place(menu.screen(), 0, 0, self.align) -- says so where there is no such place
    for key, color in pairs(looks) do self.looks[key] = def.looks and def.looks[key] or color end
    if not self:can_choose(1) then self:move(1) end
    return self
end

local function kind(row)
    if row.text then return "text" end
    if row.choices then return "choices" end
    if row.from then return "slider" end
    if type(row.value) == "boolean" then return "switch" end
    return row.action and "action" or "label"
end

function Menu:can_choose(i) return self.rows[i] and kind(self.rows[i]) ~= "label" end

-- To the next row that can be chosen, by so many, round and round.
function Menu:move(by)
    local count = #self.rows
    for _ = 1, count do
        self.chosen = (self.chosen + by - 1) % count + 1
        if self:can_choose(self.chosen) then break end
    end
    self:show(self.chosen)
end

function Menu:show(i)
    self.first = math.max(1, math.min(self.first, i))
    if i >= self.first + self.visible then self.first = i - self.visible + 1 end
end

local function set(row, value)
    if value == row.value then return end
    row.value = value
    if row.changed then row.changed(value) end
end

-- One step to the left or right; round and round where a click or Return cannot go back.
local function step(row, by, round)
    local what = kind(row)
    if what == "switch" then
        set(row, not row.value)
    elseif what == "choices" then
        local i = row.value + by
        set(row, round and (i - 1) % #row.choices + 1 or math.max(1, math.min(#row.choices, i)))
    elseif what == "slider" then
        local value = row.value + by * (row.step or 1)
        if round and value > row.to then value = row.from end
        set(row, math.max(row.from, math.min(row.to, value)))
    end
end

-- What a row has, or says when it is asked.
local function now(value)
    if type(value) == "function" then return value() end
    return value
end

function Menu:hear(what)
    if self.heard then self.heard(what) end
end

function Menu:pick()
    local row = self.rows[self.chosen]
    if now(row.locked) then return end
    if kind(row) ~= "action" then return step(row, 1, true) end
    self:hear("pick")
    row.action()
end

-- ---- where rows are ----

function Menu:box()
    local height = math.min(#self.rows, self.visible) * self.row_height
    local box = menu.place(menu.screen(), self.width, height, self.align)
    if self.align == "left" then box.x = box.x + self.margin end
    if self.align == "right" then box.x = box.x - self.margin end
    if self.title then box.y = box.y + 40 end
    box.y = self.top or box.y
    return box
end

function Menu:row_box(i)
    local box = self:box()
    return menu.box(box.x, box.y + (i - self.first) * self.row_height, box.width, self.row_height - 6)
end

function Menu:bar_box(i)
    local box = self:row_box(i)
    return menu.box(box.x + box.width - 260, box.y + box.height / 2 - 4, 170, 8)
end

function Menu:row_at(x, y)
    for i = self.first, math.min(#self.rows, self.first + self.visible - 1) do
        if menu.inside(self:row_box(i), x, y) and self:can_choose(i) then return i end
    end
end

-- ---- input ----

local function any(which, ...)
    for _, key in ipairs({ ... }) do
        if daft.input[which](key) then return true end
    end
    return false
end

-- Once as it goes down, then again and again while it is held.
function Menu:again(...)
    if any("pressed", ...) then
        self.held = 0
        return true
    end
    if not any("down", ...) then return false end
    self.held = self.held + 1
    return self.held > 24 and self.held % 6 == 0
end

function Menu:slide(x)
    local row, bar = self.rows[self.chosen], self:bar_box(self.chosen)
    local part = math.max(0, math.min(1, (x - bar.x) / bar.width))
    local unit = row.step or 1
    set(row, math.min(row.to, row.from + math.floor(part * (row.to - row.from) / unit + 0.5) * unit))
end

function Menu:mouse()
    local x, y = daft.input.mouse()
    local i = self:row_at(x, y)
    if i and (x ~= self.mouse_x or y ~= self.mouse_y or daft.input.mouse.pressed(1)) then self.chosen = i end
    self.mouse_x, self.mouse_y = x, y
    local row = self.rows[self.chosen]
    if daft.input.mouse.pressed(1) then self.slides = i and kind(row) == "slider" end
    if daft.input.mouse.down(1) and self.slides then
        self:slide(x)
    elseif daft.input.mouse.pressed(1) and i then
        self:pick()
    end
    local _, wheel = daft.input.mouse.wheel()
    if wheel ~= 0 then self:move(wheel < 0 and 1 or -1) end
end

-- W, A, S and D do as the arrows do, but for a row that is typed into.
function Menu:arrows(typed)
    local function key(letter) return not typed and letter or nil end
    if self:again("down", "pad down", "tab", key "s") then self:move(1) end
    if self:again("up", "pad up", key "w") then self:move(-1) end
    local row = self.rows[self.chosen]
    if self:again("left", "pad left", key "a") then step(row, -1) end
    if self:again("right", "pad right", key "d") then step(row, 1) end
end

function Menu:update()
    local chosen, before = self.chosen, self.rows[self.chosen].value
    self:act()
    if self.chosen ~= chosen then
        self:hear("move")
    elseif self.rows[chosen].value ~= before then
        self:hear("change")
    end
end

function Menu:act()
    local typed = kind(self.rows[self.chosen]) == "text"
    daft.input.text(typed)
    self:arrows(typed)
    local row = self.rows[self.chosen]
    if typed and self:again("backspace") and row.text ~= "" then
        row.text = row.text:sub(1, utf8.offset(row.text, -1) - 1)
        if row.changed then row.changed(row.text) end
    elseif not typed and any("pressed", "return", "keypad enter", "space", "pad a") then
        self:pick()
    elseif self.back and not typed and any("pressed", "backspace", "pad b") then
        self.back()
    end
    self:mouse()
end

-- A letter that was typed, from daft.textinput.
function Menu:textinput(letter)
    local row = self.rows[self.chosen]
    if kind(row) ~= "text" or utf8.len(row.text) >= (row.longest or 24) then return end
    row.text = row.text .. letter
    if row.changed then row.changed(row.text) end
end

-- ---- drawing ----

local function shown(row)
    local what = kind(row)
    if what == "switch" then return row.value and "on" or "off" end
    if what == "choices" then return tostring(row.choices[row.value]) end
    if what == "slider" then return row.format and row.format:format(row.value) or ("%g"):format(row.value) end
    return what == "text" and row.text or tostring(now(row.note) or "")
end

function Menu:draw_row(i)
    local row, box, chosen = self.rows[i], self:row_box(i), i == self.chosen
    local what, style = kind(row), { size = self.size, color = now(row.locked) and self.looks.dim or self.looks.text, shadow = false, font = self.font }
    local y = box.y + (box.height - self.size * 1.2) / 2
    if what ~= "label" then daft.rect(box.x, box.y, box.width, box.height, chosen and self.looks.chosen or self.looks.row) end
    daft.text(row.label, box.x + 24, y, style)
    style.align, style.color = "right", chosen and self.looks.text or self.looks.dim
    local caret = what == "text" and chosen and daft.tick() // 30 % 2 == 0 and "|" or ""
    daft.text(shown(row) .. caret, box.x + box.width - 24, y, style)
    if what ~= "slider" then return end
    local bar = self:bar_box(i)
    local part = (row.value - row.from) / (row.to - row.from)
    daft.rect(bar.x, bar.y, bar.width, bar.height, self.looks.bar)
    daft.rect(bar.x, bar.y, bar.width * part, bar.height, self.looks.filled)
    daft.circle(bar.x + bar.width * part, bar.y + bar.height / 2, 10, self.looks.filled)
end

function Menu:draw()
    local box = self:box()
    if self.title then
        local x = box.x + (self.align == "left" and 0 or self.align == "right" and box.width or box.width / 2)
        daft.text(self.title, x, box.y - self.row_height - 38, { size = 56, align = self.align, font = self.font })
    end
    for i = self.first, math.min(#self.rows, self.first + self.visible - 1) do self:draw_row(i) end
    if #self.rows <= self.visible then return end
    local part = (box.height - 6) / #self.rows
    daft.rect(box.x + box.width + 10, box.y + part * (self.first - 1), 6, part * self.visible, self.looks.dim)
end

return menu
