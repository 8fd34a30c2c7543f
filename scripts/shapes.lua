-- Things to draw, with the collider that fits: cylinders, cones, capsules, rings, discs and letters.
--
--     local shapes = require "shapes"
--     daft.entity(shapes.cylinder { radius = 0.5, height = 2, position = {0, 1, 0}, body = "dynamic", mass = 5 })
--
-- Each takes its own sizes and every field of daft.entity, and returns the table that daft.entity wants. A collider that
-- is given stays. The same sizes share one mesh.

local shapes = {}

local made = {} -- meshes by kind and sizes

-- Turns a profile, a list of {radius, y, nx, ny} from the top down, about the y axis. Points whose normals differ stand
-- in it twice; `gaps` names those that no band of triangles leads on from.
local function turn(profile, sides, gaps)
    local positions, normals, uvs, triangles = {}, {}, {}, {}
    for row, p in ipairs(profile) do
        for i = 0, sides do
            local angle = 2 * math.pi * i / sides
            local c, s = math.cos(angle), math.sin(angle)
            if i == sides then c, s = 1, 0 end
            positions[#positions + 1] = { p[1] * c, p[2], p[1] * s }
            normals[#normals + 1] = { p[3] * c, p[4], p[3] * s }
            uvs[#uvs + 1] = { i / sides, 1 - (row - 1) / (#profile - 1) }
        end
    end
    for row = 1, #profile - 1 do
        for i = 1, gaps[row] and 0 or sides do
            local a = (row - 1) * (sides + 1) + i
            local b, c, d = a + 1, a + sides + 1, a + sides + 2
            if profile[row][1] > 0 then triangles[#triangles + 1] = { a, b, d } end
            if profile[row + 1][1] > 0 then triangles[#triangles + 1] = { a, d, c } end
        end
    end
    return { positions = positions, normals = normals, uvs = uvs, triangles = triangles }
end

local function mesh(kind, sizes, profile, sides, gaps)
    local key = kind .. " " .. table.concat(sizes, " ") .. " " .. sides
    if not made[key] then made[key] = daft.mesh(turn(profile, sides, gaps or {})) end
    return made[key]
end

local function size(t, kind, name, usual)
    local value = t[name]
    if value == nil then value = usual end
    if type(value) ~= "number" or not (value > 0 and value < math.huge) then
        error(("shapes.%s: %s: number above 0 expected, got %s"):format(kind, name, tostring(value)), 3)
    end
    return value
end

local function sides_of(t, kind)
    local sides = t.sides or 32
    if math.type(sides) ~= "integer" or sides < 3 or sides > 256 then
        error(("shapes.%s: sides: 3 to 256 expected, got %s"):format(kind, tostring(sides)), 3)
    end
    return sides
end

-- A copy without the fields that are the shape's own.
local function entity(t, own, what, collider)
    local out = {}
    for key, value in pairs(t) do
        if not own[key] then out[key] = value end
    end
    out.mesh = what
    if out.body and out.collider == nil then out.collider = collider end
    return out
end

local function table_of(t, kind)
    if t ~= nil and type(t) ~= "table" then error(("shapes.%s: table expected, got %s"):format(kind, type(t)), 3) end
    return t or {}
end

local SIZES = { radius = true, height = true, sides = true, thickness = true }

-- Upright, about its middle. radius (0.5), height (1).
function shapes.cylinder(t)
    t = table_of(t, "cylinder")
    local r, h, sides = size(t, "cylinder", "radius", 0.5), size(t, "cylinder", "height", 1), sides_of(t, "cylinder")
    local y = h / 2
    local profile = { { 0, y, 0, 1 }, { r, y, 0, 1 }, { r, y, 1, 0 }, { r, -y, 1, 0 }, { r, -y, 0, -1 }, { 0, -y, 0, -1 } }
    return entity(t, SIZES, mesh("cylinder", { r, h }, profile, sides, { [2] = true, [4] = true }),
        { cylinder = { radius = r, height = h } })
end

-- Upright, about the middle of its height, with the tip on top. radius of the foot (0.5), height (1).
function shapes.cone(t)
    t = table_of(t, "cone")
    local r, h, sides = size(t, "cone", "radius", 0.5), size(t, "cone", "height", 1), sides_of(t, "cone")
    local slope = math.sqrt(r * r + h * h)
    local nx, ny, y = h / slope, r / slope, h / 2
    local profile = { { 0, y, nx, ny }, { r, -y, nx, ny }, { r, -y, 0, -1 }, { 0, -y, 0, -1 } }
    local hull = mesh("cone", { r, h }, profile, math.min(sides, 32), { [2] = true })
    return entity(t, SIZES, mesh("cone", { r, h }, profile, sides, { [2] = true }), { hull = hull })
end

-- Upright, about its middle. radius (0.5), height from end to end (2).
function shapes.capsule(t)
    t = table_of(t, "capsule")
    local r, h, sides = size(t, "capsule", "radius", 0.5), size(t, "capsule", "height", 2), sides_of(t, "capsule")
    if h < 2 * r then error(("shapes.capsule: height: at least twice the radius, %g, expected, got %g"):format(2 * r, h), 2) end
    local profile, rings, middle = {}, math.max(2, sides // 4), h / 2 - r
    for half = 1, -1, -2 do
        for i = 0, rings do
            local angle = math.pi / 2 * (half > 0 and i or rings - i) / rings
            local s, c = math.sin(angle), math.cos(angle)
            if angle == 0 then s = 0 end
            profile[#profile + 1] = { r * s, half * (middle + r * c), s, half * c }
        end
    end
    return entity(t, SIZES, mesh("capsule", { r, h }, profile, sides), { capsule = { radius = r, height = h } })
end

-- A ring that lies flat. radius of its middle line (1), thickness (0.4). Standing bodies have its triangles; those that
-- move a string of capsules.
function shapes.torus(t)
    t = table_of(t, "torus")
    local r, d, sides = size(t, "torus", "radius", 1), size(t, "torus", "thickness", 0.4), sides_of(t, "torus")
    if d >= 2 * r then error(("shapes.torus: thickness: less than twice the radius, %g, expected, got %g"):format(2 * r, d), 2) end
    local profile, around, w = {}, math.max(6, sides // 2), d / 2
    for i = 0, around do
        local angle = math.pi - 2 * math.pi * i / around -- from the inside over the top
        local c, s = math.cos(angle), math.sin(angle)
        if i == around then c, s = -1, 0 end
        profile[#profile + 1] = { r + w * c, w * s, c, s }
    end
    local parts, pieces = {}, 16
    -- Their middles are as far inside the ring's middle line as their ends are outside.
    local inside, lean = r * (1 + math.cos(math.pi / pieces)) / 2, math.sqrt(0.5)
    local length = 2 * inside * math.tan(math.pi / pieces) + d
    for i = 1, t.body == "dynamic" and pieces or 0 do
        local angle = 2 * math.pi * (i - 0.5) / pieces
        parts[i] = { capsule = { radius = w, height = length },
            position = { inside * math.cos(angle), 0, inside * math.sin(angle) },
            rotation = { lean * math.cos(angle), 0, lean * math.sin(angle), lean } } -- from upright to along the ring
    end
    return entity(t, SIZES, mesh("torus", { r, d }, profile, sides), #parts > 0 and parts or "mesh")
end

-- A round plate of no thickness, seen from above: a floor, a lid, a lawn. radius (1).
function shapes.disc(t)
    t = table_of(t, "disc")
    local r, sides = size(t, "disc", "radius", 1), sides_of(t, "disc")
    return entity(t, SIZES, mesh("disc", { r }, { { 0, 0, 0, 1 }, { r, 0, 0, 1 } }, sides), "mesh")
end

local TEXT = { text = true, size = true, depth = true, align = true, font = true }

-- Upright letters that face +z, the last line standing on y = 0. text, size, the height of a capital letter (1), depth
-- (a fifth of it), align: what stands at x = 0, "left", "center" or "right" ("center"), font. Standing bodies have the
-- letters' triangles, those that move their hull.
function shapes.text(t)
    t = table_of(t, "text")
    if t.text == nil then error("shapes.text: text: string expected, got nil", 2) end
    local what = daft.mesh { text = t.text, size = t.size, depth = t.depth, align = t.align, font = t.font }
    return entity(t, TEXT, what, t.body == "dynamic" and "hull" or "mesh")
end

return shapes
