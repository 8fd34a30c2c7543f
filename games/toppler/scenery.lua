-- The island that all levels stand on, the islands around it, and three kinds of light.

local scenery = {}

local MIDDLE, RADIUS = 22, 46 -- metres: where the island's middle lies along x, and how far its rim is
local sun

local LIGHTS = {
    day = { direction = { 0.5, -0.8, 0.45 }, color = { 1.0, 0.95, 0.85 }, ambient = { 0.36, 0.40, 0.48 } },
    evening = { direction = { 0.75, -0.42, -0.55 }, color = { 1.15, 0.78, 0.5 }, ambient = { 0.36, 0.33, 0.42 },
        zenith = "#3c5f9e", horizon = "#ffcf9a" },
    dusk = { direction = { 0.4, -0.62, 0.7 }, color = { 0.62, 0.66, 0.95 }, ambient = { 0.3, 0.28, 0.42 },
        zenith = "#101a3c", horizon = "#c8688a" },
}

-- How far the rim is at an angle: an island is not a coin.
local function rim(angle) return RADIUS + 2.2 * math.sin(3 * angle + 1) + 1.6 * math.sin(7 * angle) end

local function ring(count, height, shrink)
    local points = {}
    for i = 0, count - 1 do
        local angle = 2 * math.pi * i / count
        local far = rim(angle) * shrink
        points[#points + 1] = { far * math.cos(angle), height, far * math.sin(angle) }
    end
    return points
end

-- The grass: a fan about the middle. One metre is one unit of the texture.
local function lawn(count)
    local mesh = { positions = { { 0, 0, 0 } }, uvs = { { 0, 0 } }, normals = { { 0, 1, 0 } }, triangles = {} }
    for i, p in ipairs(ring(count, 0, 1)) do
        mesh.positions[i + 1], mesh.uvs[i + 1], mesh.normals[i + 1] = p, { p[1], p[3] }, { 0, 1, 0 }
        mesh.triangles[i] = { 1, i % count + 2, i + 1 }
    end
    return daft.mesh(mesh)
end

-- The rock under it: bands that grow narrower downwards, to a tip.
local function keel(count)
    local bands = { { 0, 1 }, { -1.2, 1.01 }, { -5, 0.86 }, { -12, 0.5 }, { -20, 0.12 } }
    local mesh = { positions = {}, uvs = {}, triangles = {} }
    for band, size in ipairs(bands) do
        for i, p in ipairs(ring(count, size[1], size[2])) do
            if band > 2 then p[2] = p[2] + 1.5 * math.sin(i * 2.3 + band) end
            table.insert(mesh.positions, p)
            table.insert(mesh.uvs, { i * 0.5, band })
        end
    end
    for band = 0, #bands - 2 do
        for i = 0, count - 1 do
            local a, b = band * count + i + 1, band * count + (i + 1) % count + 1
            table.insert(mesh.triangles, { a, b, b + count })
            table.insert(mesh.triangles, { a, b + count, a + count })
        end
    end
    return daft.mesh(mesh)
end

local function mesh(name, x, y, z, scale, degrees)
    daft.entity { mesh = name .. ".obj", position = { x, y, z }, scale = scale, rotation = { math.rad(degrees or 0), 0, 0 },
        casts_shadow = y > -1 }
end

-- Trees near the rim, in a fixed order that looks like none; none before the catapult or behind the towers.
local function plant()
    for i = 1, 20 do
        local angle = i * 2.399 + 0.4
        local far = RADIUS * (0.72 + 0.2 * ((i * 7) % 10) / 10)
        local x, z = MIDDLE + far * math.cos(angle), far * math.sin(angle)
        if not (x < 10 and math.abs(z) < 14) then
            mesh(i % 3 == 0 and "tree" or "pine", x, 0, z, 1.6 + (i * 5) % 7 * 0.22, i * 50)
        end
    end
    for i, at in ipairs { { 3, -9, 1.4 }, { -2, 8.5, 1 }, { 36, 20, 1.8 }, { 14, -21, 1.2 }, { 40, -14, 1 } } do
        mesh("rock", at[1], 0, at[2], at[3], i * 70)
    end
end

local function islands()
    local places = { { 92, -6, -40, 3 }, { 120, -14, 30, 4 }, { 60, -12, 82, 3 }, { 10, -10, -88, 3.4 },
        { -60, -9, 30, 2.6 }, { -52, -14, -44, 3 }, { 150, -4, -8, 3.6 } }
    for i, p in ipairs(places) do
        mesh("island", p[1], p[2], p[3], p[4], i * 80)
        mesh("pine", p[1] - p[4] * 0.6, p[2], p[3] + p[4] * 0.3, p[4] * 1.3, i * 40)
        mesh("tree", p[1] + p[4] * 0.7, p[2], p[3] - p[4] * 0.2, p[4] * 1.1, i * 90)
    end
end

function scenery.build()
    local grass = { texture = "grass", texture_scale = 0.3, specular = 0 }
    daft.entity { mesh = lawn(48), position = { MIDDLE, 0, 0 }, material = grass, casts_shadow = false, body = "static",
        friction = 0.8, rolling_resistance = 0.12, collider = { cylinder = { radius = RADIUS - 2, height = 4 }, position = { 0, -2, 0 } },
        data = { kind = "ground" } }
    daft.entity { mesh = keel(48), position = { MIDDLE, 0, 0 }, casts_shadow = false,
        material = { texture = "rock", texture_scale = 1, specular = 0.05 } }
    plant()
    islands()
    sun = daft.light.sun { direction = LIGHTS.day.direction }
end

function scenery.light(name)
    local light = LIGHTS[name]
    sun:set { direction = light.direction, color = light.color }
    daft.ambient(light.ambient)
    if light.zenith then
        daft.sky.gradient(light.zenith, light.horizon)
    else
        daft.sky.image("sky/day.jpg")
    end
end

return scenery
