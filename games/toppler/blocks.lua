-- What levels are built of: blocks, cards, kings. It remembers where each stood, to count what has been toppled.

local shapes = require "shapes"

local blocks = {}

local KINDS = {
    wood = { density = 260, friction = 0.6, material = { texture = "wood", texture_scale = 0.6, specular = 0.1 } },
    stone = { density = 620, friction = 0.7, material = { texture = "stone", texture_scale = 0.5, specular = 0.05 } },
    rock = { body = "static", friction = 0.8, material = { texture = "cobble", texture_scale = 0.4, specular = 0.05 } },
    card = { density = 90, friction = 0.9, material = { texture = "damask", texture_scale = 0.9, specular = 0.15 } },
    bar = { body = "static", friction = 0.8, material = { texture = "metal", texture_scale = 0.5 } },
    iron = { density = 3000, friction = 0.5, material = { color = "#3a3f48", specular = 0.7, shininess = 90 } },
}
for name, color in pairs { red = "#d23c2e", yellow = "#f0b429", blue = "#2c6bd1", green = "#39a84a", white = "#efe6d2", purple = "#8b4cc4" } do
    KINDS[name] = { density = 220, friction = 0.6, material = { color = color, specular = 0.35, shininess = 50 } }
end

local GOLD = { color = "#f5c030", specular = 0.9, shininess = 120, mirror = 0.12 }
local SKIN = { color = "#f2c9a0", specular = 0.2 }
local MOVED = 0.6 -- metres from where it stood: toppled

blocks.kings, blocks.ladies = {}, {}
local things, places = {}, {} -- all entities of the level; for blocks, where they stood
local moving = {}             -- those of them that the simulation moves, in the order in which they were made
local ropes = {}

local function keep(e, body)
    things[#things + 1] = e
    if body == "dynamic" then moving[#moving + 1] = e end
    return e
end

-- A block of a kind: its middle, its edges, how it is turned.
function blocks.add(kind, x, y, z, size, rotation)
    local look = KINDS[kind]
    local body = look.body or "dynamic"
    local block = keep(daft.entity { box = size, position = { x, y, z }, rotation = rotation, material = look.material,
        density = look.density, friction = look.friction, body = body, data = { kind = kind } }, body)
    if not look.body then places[#places + 1] = { block = block, x = x, y = y, z = z } end
    return block
end

function blocks.thing(fields) return keep(daft.entity(fields), fields.body) end

-- A rope from a fixed point to a body's middle: it holds, and it is drawn.
function blocks.rope(body, from, length)
    daft.joint { kind = "distance", b = body, at = from, to = body, limit = { 0, length } }
    local line = keep(daft.entity { box = { 1, 0.09, 0.09 }, material = "#c8a878" })
    ropes[#ropes + 1] = { line = line, body = body, from = from }
end

-- Blocks one on the other, from y up; gives the height of their top.
function blocks.column(kinds, x, z, count, size, y)
    y = y or 0
    for i = 1, count do
        local kind = type(kinds) == "string" and kinds or kinds[(i - 1) % #kinds + 1]
        blocks.add(kind, x, y + size[2] / 2, z, size)
        y = y + size[2]
    end
    return y
end

-- A wall of bricks across the way; every other row begins and ends with half a brick.
function blocks.wall(kinds, x, z, columns, rows, size, y)
    y = y or 0
    local long = size[3]
    for row = 0, rows - 1 do
        local at = z - columns * long / 2
        for i = 0, columns do
            local half = row % 2 == 1 and (i == 0 or i == columns)
            local piece = half and long / 2 or long
            if row % 2 == 1 or i < columns then
                blocks.add(kinds[(row + i) % #kinds + 1], x, y + (row + 0.5) * size[2], at + piece / 2, { size[1], size[2], piece - 0.01 })
                at = at + piece
            end
        end
    end
    return y + rows * size[2]
end

-- A round tower: `count` bricks a row, every other row half a brick further round. Bricks meet at their inner edges.
function blocks.tower(kinds, x, z, radius, count, rows, thick, height, y)
    y = y or 0
    local size = { thick, height, 2 * (radius - thick / 2) * math.tan(math.pi / count) - 0.01 }
    for row = 0, rows - 1 do
        for i = 0, count - 1 do
            local angle = 2 * math.pi * (i + row % 2 / 2) / count
            blocks.add(kinds[(row + i) % #kinds + 1], x + radius * math.cos(angle), y + (row + 0.5) * height,
                z + radius * math.sin(angle), size, { angle, 0, 0 })
        end
    end
    return y + rows * height
end

-- A house of cards: `first` tents, and on their roof of flat cards one less, down to `last` of them. Gives its height.
function blocks.cards(x, z, first, last, y)
    local long, thick, wide, lean = 1.7, 0.07, 1.2, 0.27 -- metres, radians
    y = y or 0
    local foot = 2 * (long / 2 * math.sin(lean)) + 2 * thick -- from foot to foot of a tent, and between tents
    local rise = long * math.cos(lean) + thick * math.sin(lean)
    for storey = first, last, -1 do
        for tent = 1, storey do
            local middle = z + (tent - (storey + 1) / 2) * foot * 2
            local aside = long / 2 * math.sin(lean) + thick / 2 * math.cos(lean)
            for side = -1, 1, 2 do
                blocks.add("card", x, y + rise / 2, middle + side * aside, { wide, long, thick }, { 0, 0, -side * lean })
            end
        end
        y = y + rise
        for tent = 1, storey - 1 do
            blocks.add(tent % 2 == 0 and "red" or "white", x, y + thick / 2, z + (tent - storey / 2) * foot * 2,
                { wide, thick, foot * 2 - 0.01 })
        end
        if storey > 1 then y = y + thick end
    end
    return y
end

-- Someone who stands at a place: robe, head, and a crown or a hat. Children of one body.
local function person(x, y, z, robe, look, data)
    local body = keep(daft.entity(shapes.cone { radius = 0.36, height = 1.2, position = { x, y + 0.6, z }, material = robe,
        body = "dynamic", density = 180, friction = 0.7, data = data, collider = {
            { cylinder = { radius = 0.34, height = 0.5 }, position = { 0, -0.35, 0 } },
            { cylinder = { radius = 0.22, height = 0.8 }, position = { 0, 0.2, 0 } } } }), "dynamic")
    local function on(fields)
        fields.parent = body
        return daft.entity(fields)
    end
    on { sphere = 0.24, position = { 0, 0.4, 0 }, material = SKIN }
    for side = -1, 1, 2 do
        on { sphere = 0.045, position = { -0.21, 0.45, side * 0.09 }, material = "#202020" }
    end
    look(on)
    return { body = body, x = x, y = y + 0.6, z = z, down = false }
end

local function crown(on)
    on(shapes.cylinder { radius = 0.21, height = 0.14, position = { 0, 0.62, 0 }, material = GOLD })
    for i = 0, 4 do
        local angle = 2 * math.pi * i / 5
        on(shapes.cone { radius = 0.07, height = 0.18, sides = 8, material = GOLD,
            position = { 0.15 * math.cos(angle), 0.76, 0.15 * math.sin(angle) } })
    end
end

local function hat(on)
    on(shapes.cone { radius = 0.2, height = 0.6, sides = 16, position = { 0.04, 0.86, 0 }, material = "#e86aa6" })
end

function blocks.king(x, y, z)
    table.insert(blocks.kings, person(x, y, z, { color = "#7d2bb0", specular = 0.3 }, crown, { kind = "king" }))
end

function blocks.lady(x, y, z)
    table.insert(blocks.ladies, person(x, y, z, { color = "#2f9d8f", specular = 0.3 }, hat, { kind = "lady" }))
end

-- Whether someone has fallen: lower by a step, or more lying than standing.
local function fallen(who)
    local _, y = who.body:position()
    local _, up = who.body:up()
    return y < who.y - 0.7 or up < 0.5
end

-- Calls fell(who) for each king and lady who has fallen since the last time.
function blocks.watch(fell)
    for _, list in ipairs { blocks.kings, blocks.ladies } do
        for _, who in ipairs(list) do
            if not who.down and fallen(who) then
                who.down = true
                fell(who, list == blocks.ladies)
            end
        end
    end
end

function blocks.kings_left()
    local left = 0
    for _, king in ipairs(blocks.kings) do
        if not king.down then left = left + 1 end
    end
    return left
end

-- How many blocks have gone from where they stood.
function blocks.toppled()
    local count = 0
    for _, p in ipairs(places) do
        local x, y, z = p.block:position()
        if (x - p.x) ^ 2 + (y - p.y) ^ 2 + (z - p.z) ^ 2 > MOVED * MOVED then count = count + 1 end
    end
    return count
end

-- Where a body is, how it is turned, and how it moves: 13 numbers.
function blocks.motion(body)
    local x, y, z = body:position()
    local a, b, c, d = body:rotation()
    local vx, vy, vz = body:velocity()
    return { x, y, z, a, b, c, d, vx, vy, vz, body:angular_velocity() }
end

function blocks.move(body, m)
    body:teleport(m[1], m[2], m[3])
    body:rotation(m[4], m[5], m[6], m[7])
    body:velocity(m[8], m[9], m[10])
    body:angular_velocity(m[11], m[12], m[13])
end

-- The level as it stands now, for blocks.restore in the same level built anew.
function blocks.state()
    local state = { motions = {}, starts = {}, down = {} }
    for i, body in ipairs(moving) do state.motions[i] = blocks.motion(body) end
    for i, p in ipairs(places) do state.starts[i] = { p.x, p.y, p.z } end
    for _, list in ipairs { blocks.kings, blocks.ladies } do
        for _, who in ipairs(list) do table.insert(state.down, who.down) end
    end
    return state
end

-- Says false, and does nothing, where the level is built otherwise now.
function blocks.restore(state)
    if #state.motions ~= #moving or #state.starts ~= #places then return false end
    for i, p in ipairs(places) do
        local start = state.starts[i]
        if start[1] ~= p.x or start[2] ~= p.y or start[3] ~= p.z then return false end
    end
    for i, body in ipairs(moving) do blocks.move(body, state.motions[i]) end
    local i = 0
    for _, list in ipairs { blocks.kings, blocks.ladies } do
        for _, who in ipairs(list) do
            i = i + 1
            who.down = state.down[i]
        end
    end
    return true
end

-- Draws the ropes to where their bodies are.
function blocks.update()
    for _, rope in ipairs(ropes) do
        local x, y, z = rope.body:position()
        local dx, dy, dz = x - rope.from[1], y - rope.from[2], z - rope.from[3]
        rope.line:position(x - dx / 2, y - dy / 2, z - dz / 2)
        rope.line:look_at(rope.body)
        rope.line:scale(math.sqrt(dx * dx + dy * dy + dz * dz), 1, 1)
    end
end

function blocks.count() return #places + #blocks.kings + #blocks.ladies end

function blocks.clear()
    for _, e in ipairs(things) do
        if e:valid() then e:destroy() end
    end
    things, places, moving, ropes, blocks.kings, blocks.ladies = {}, {}, {}, {}, {}, {}
end

return blocks
