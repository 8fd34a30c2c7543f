-- The catapult: where it points, how far it is pulled, and how it throws.

local shapes = require "shapes"

local catapult = {}

local PIVOT, ARM = 1.7, 2.5      -- metres: the axle's height, and from it to the cup
local MUZZLE = { 0.4, 4.2, 0 }   -- where the shot leaves, within the catapult's axes
local SLOWEST, FASTEST = 10, 32  -- metres a second
local SWING = 6                  -- ticks from the release to the throw
local LOOKS = {
    wood = { texture = "wood", texture_scale = 0.7, specular = 0.1 },
    iron = { color = "#4a4f58", specular = 0.6, shininess = 60 },
}
local SHOTS = {
    stone = { radius = 0.42, mass = 110, material = { texture = "stone", texture_scale = 3, specular = 0.1 } },
    iron = { radius = 0.5, mass = 380, material = { color = "#2c3038", specular = 0.8, shininess = 120, mirror = 0.15 } },
    bomb = { radius = 0.45, mass = 90, material = { color = "#202024", specular = 0.7, shininess = 90 } },
}

local base, arm, loaded
local lean = 0                   -- the arm's angle: 0 lies level, the cup behind; positive raises the cup

catapult.yaw, catapult.pitch = 0, math.rad(35)

local function part(parent, size, at, look, turn)
    return daft.entity { parent = parent, box = size, position = at, material = LOOKS[look or "wood"], rotation = turn }
end

local function build_base()
    base = daft.entity {}
    for side = -1, 1, 2 do
        local z = side * 0.65
        part(base, { 3.4, 0.26, 0.24 }, { -0.2, 0.45, z })
        part(base, { 0.24, 1.9, 0.2 }, { 0.35, 1.05, z }, "wood", { 0, -0.45, 0 })
        part(base, { 0.24, 1.9, 0.2 }, { -0.45, 1.05, z }, "wood", { 0, 0.45, 0 })
        for _, x in ipairs { -1.5, 1.1 } do
            daft.entity(shapes.cylinder { parent = base, radius = 0.45, height = 0.22, position = { x, 0.45, side * 0.92 },
                rotation = { 0, 0, math.pi / 2 }, material = LOOKS.wood })
            daft.entity(shapes.cylinder { parent = base, radius = 0.14, height = 0.3, position = { x, 0.45, side * 0.92 },
                rotation = { 0, 0, math.pi / 2 }, material = LOOKS.iron })
        end
    end
    part(base, { 0.24, 0.24, 1.3 }, { -1.7, 0.45, 0 })
    part(base, { 0.24, 0.24, 1.3 }, { 1.3, 0.45, 0 })
    part(base, { 0.2, 0.2, 1.7 }, { -0.05, PIVOT, 0 }, "iron")
end

local function build_arm()
    arm = daft.entity { parent = base, position = { -0.05, PIVOT, 0 } }
    part(arm, { ARM + 0.8, 0.18, 0.2 }, { -ARM / 2 + 0.4, 0, 0 })
    part(arm, { 0.5, 0.6, 0.5 }, { 0.75, -0.2, 0 }, "iron")
    daft.entity(shapes.cylinder { parent = arm, radius = 0.46, height = 0.16, position = { -ARM, 0.12, 0 }, material = LOOKS.iron })
    loaded = {}
    for kind, shot in pairs(SHOTS) do
        loaded[kind] = daft.entity { parent = arm, sphere = shot.radius, material = shot.material, visible = false,
            position = { -ARM, 0.2 + shot.radius, 0 } }
    end
end

function catapult.build()
    build_base()
    build_arm()
    catapult.pose(0)
end

-- Shows how far it is pulled, 0 to 1.
function catapult.pose(pull)
    lean = -0.1 - 0.4 * pull
    base:rotation(catapult.yaw, 0, 0)
    arm:rotation(0, lean, 0)
end

-- Puts a shot into the cup; none takes it out.
function catapult.load(kind)
    for name, ball in pairs(loaded) do ball:visible(name == kind) end
end

function catapult.speed(pull) return SLOWEST + (FASTEST - SLOWEST) * pull end

-- Where a shot begins, and its velocity.
function catapult.throw(pull)
    local speed, c, s = catapult.speed(pull), math.cos(catapult.yaw), math.sin(catapult.yaw)
    local level = speed * math.cos(catapult.pitch)
    return { MUZZLE[1] * c, MUZZLE[2], MUZZLE[1] * s }, { level * c, speed * math.sin(catapult.pitch), level * s }
end

-- A shot on its way.
function catapult.shot(kind, place, velocity)
    local shot = SHOTS[kind]
    return daft.entity { sphere = shot.radius, mass = shot.mass, material = shot.material, body = "dynamic", bullet = true,
        position = place, velocity = velocity, friction = 0.7, rolling_resistance = 0.08, data = { kind = kind } }
end

-- Only in a task: swings the arm up, and gives the shot that it has thrown.
function catapult.fire(kind, pull)
    local from = lean
    for tick = 1, SWING do
        arm:rotation(0, from + (1.75 - from) * (tick / SWING) ^ 2, 0)
        wait()
    end
    catapult.load(nil)
    return catapult.shot(kind, catapult.throw(pull))
end

return catapult
