-- Builds the course from level.lua: turns each piece of data into an entity.

local course = { gems = {}, platforms = {}, sweepers = {}, bumpers = {} }

-- Materials by name. On boxes a texture repeats texture_scale times on one metre.
local looks = {
    tiles = { texture = "checker", texture_scale = 0.25, specular = 0.15, shininess = 40 },
    stone = { texture = "stone", texture_scale = 0.25 },
    wood = { texture = "wood", texture_scale = 0.5 },
    arrows = { texture = "arrows", texture_scale = 0.25 },
    marble = { texture = "marble", texture_scale = 0.25, specular = 0.3, shininess = 60 },
    metal = { texture = "metal", texture_scale = 0.5 },
    target = { texture = "target", texture_scale = 0.25 },
    hazard = { texture = "hazard", texture_scale = 0.6 },
    bumper = { color = "#ff5a4d", specular = 0.5, shininess = 80 },
    bumped = { color = "#ff5a4d", emission = "#ff8a5a" },
}

-- A box whose top runs from one point to another.
local function road(piece)
    local a, b = piece.from, piece.to
    local dx, dy, dz = b[1] - a[1], b[2] - a[2], b[3] - a[3]
    local flat = math.sqrt(dx * dx + dz * dz)
    local length = math.sqrt(flat * flat + dy * dy)
    local yaw, pitch = math.atan(dz, dx), -math.atan(dy, flat)
    -- Up and right of the road's own axes, to put its parts beside and below the line between the points.
    local up = { -dx / flat * dy / length, flat / length, -dz / flat * dy / length }
    local right = { -dz / flat, 0, dx / flat }

    local function part(above, aside, height, width, look)
        daft.entity {
            box = { length, height, width },
            position = {
                (a[1] + b[1]) / 2 + up[1] * above + right[1] * aside,
                (a[2] + b[2]) / 2 + up[2] * above,
                (a[3] + b[3]) / 2 + up[3] * above + right[3] * aside,
            },
            rotation = { yaw, pitch, 0 },
            material = looks[look],
            body = "static",
        }
    end

    part(-0.3, 0, 0.6, piece.width, piece.look)
    if piece.kerbs then
        part(-0.05, piece.width / 2 + 0.15, 0.7, 0.3, "wood")
        part(-0.05, -piece.width / 2 - 0.15, 0.7, 0.3, "wood")
    end
end

local function mesh(name, place, scale, degrees)
    return daft.entity {
        mesh = name .. ".obj",
        position = place,
        scale = scale or 1,
        casts_shadow = name ~= "island", -- they float below everything, so their shadows fall on nothing
        rotation = { math.rad(degrees or 0), 0, 0 },
    }
end

function course.build(level)
    for name, look in pairs(looks) do looks[name] = daft.material(look) end
    for _, piece in ipairs(level.roads) do road(piece) end
    for _, item in ipairs(level.scenery) do mesh(table.unpack(item)) end

    for _, p in ipairs(level.platforms) do
        p.entity = daft.entity { box = p.size, position = p.from, material = looks.metal, body = "kinematic",
            rolling_resistance = 0.2 }
        table.insert(course.platforms, p)
    end
    for _, s in ipairs(level.sweepers) do
        local x, y, z = table.unpack(s.at)
        daft.entity { box = { 0.5, 0.9, 0.5 }, position = { x, y + 0.45, z }, material = looks.metal, body = "static" }
        s.entity = daft.entity { box = { s.length, 0.4, 0.3 }, position = { x, y + 0.45, z }, material = looks.hazard,
            body = "kinematic" }
        table.insert(course.sweepers, s)
    end
    for _, at in ipairs(level.bumpers) do
        local bumper = { glow = 0 } -- seconds it still glows after a hit
        bumper.entity = daft.entity { sphere = 0.7, position = { at[1], at[2] + 0.4, at[3] }, material = looks.bumper,
            body = "static", data = bumper }
        table.insert(course.bumpers, bumper)
    end
    for _, at in ipairs(level.gems) do
        local place = { at[1], at[2] + 0.75, at[3] }
        table.insert(course.gems, { place = place, entity = mesh("gem", place), taken = false })
    end

    local x, y, z = table.unpack(level.goal)
    daft.entity { box = { 4, 0.1, 4 }, position = { x, y - 0.04, z }, material = looks.target } -- only to be seen
    mesh("ring", { x, y + 1.5, z }, 1, 90)
end

-- Where a platform is after `time` seconds: it eases to and fro.
local function glide(p, time)
    local t = (1 - math.cos(2 * math.pi * time / p.period)) / 2
    local a, b = p.from, p.to
    return { a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t - p.size[2] / 2, a[3] + (b[3] - a[3]) * t }
end

-- Moves what moves by itself.
function course.update(time, dt)
    for _, p in ipairs(course.platforms) do p.entity:position(glide(p, time)) end
    for _, s in ipairs(course.sweepers) do s.entity:rotation(time * s.speed, 0, 0) end
    for i, gem in ipairs(course.gems) do gem.entity:rotation(time * 2 + i, 0, 0) end
    for _, bumper in ipairs(course.bumpers) do
        bumper.glow = math.max(0, bumper.glow - dt)
        bumper.entity:material(bumper.glow > 0 and looks.bumped or looks.bumper)
    end
end

return course
