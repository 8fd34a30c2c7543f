-- What is only seen: the arc of the coming shot, dust, sparks, explosions.

local effects = {}

local DOTS, STEP = 16, 0.11      -- of the arc; seconds between them
local FALL = { 0, -9.8, 0 }
local dots, clouds = {}, {}
local flash                      -- an explosion's light and ball of fire, and the seconds it has left

local function cloud(material, speed, life, size, more)
    local def = { count = 800, material = material, speed = speed, life = life, size = size, direction = { 0, 1, 0 }, spread = math.rad(85), gravity = FALL }
    for key, value in pairs(more or {}) do def[key] = value end
    return daft.particles(def)
end

function effects.load()
    for i = 1, DOTS do
        dots[i] = daft.entity { sphere = 0.13 - 0.005 * i, visible = false, casts_shadow = false,
            material = { color = "#fff4c8", emission = "#c8a850" } }
    end
    clouds.dust = cloud({ color = "#c8b898" }, { 0.6, 3.2 }, { 0.5, 1.1 }, { 0.05, 0.16 }, { gravity = { 0, -1.5, 0 }, drag = 2.5 })
    clouds.chips = cloud({ color = "#a88458" }, { 2, 6 }, { 0.4, 0.9 }, { 0.08, 0.03 })
    clouds.gold = cloud({ color = "#ffd040", emission = "#705000" }, { 2, 6 }, { 0.7, 1.4 }, { 0.09, 0.02 })
    clouds.pink = cloud({ color = "#e86aa6", emission = "#50203a" }, { 1.5, 4 }, { 0.7, 1.4 }, { 0.09, 0.02 })
    clouds.fire = cloud({ color = "#000000", emission = "#ff9838" }, { 3, 11 }, { 0.25, 0.6 }, { 0.22, 0.02 }, { spread = math.pi, drag = 3 })
    clouds.smoke = cloud({ color = "#5c5454" }, { 0.5, 3.5 }, { 0.9, 2 }, { 0.16, 0.42 }, { gravity = { 0, 0.8, 0 }, drag = 2 })
    clouds.fuse = cloud({ color = "#000000", emission = "#ffc060" }, { 0.4, 1.6 }, { 0.2, 0.5 }, { 0.06, 0.01 }, { spread = math.pi })
    clouds.trail = cloud({ color = "#e4e0d8" }, { 0, 0.15 }, { 0.3, 0.7 }, { 0.06, 0 }, { gravity = { 0, 0, 0 } })
end

-- Shows the arc from a place at a velocity; hides it without one.
function effects.arc(place, velocity)
    for i, dot in ipairs(dots) do
        local t = i * STEP
        dot:visible(place ~= nil)
        if place then
            dot:teleport(place[1] + velocity[1] * t, place[2] + velocity[2] * t - 9.81 / 2 * t * t, place[3] + velocity[3] * t)
        end
    end
end

-- kind: "dust", "chips", "gold" or "pink".
function effects.burst(kind, count, place) clouds[kind]:burst(count, place) end

-- Behind a shot, once in each tick that it flies: along the way that it has come since the last one.
function effects.trail(x, y, z, vx, vy, vz, kind)
    for i = 0, 5 do
        local back = i / 6 / 60
        clouds.trail:burst(1, { x - vx * back, y - vy * back, z - vz * back })
    end
    if kind == "bomb" then clouds.fuse:burst(5, { x, y, z }) end
end

-- A bomb goes off: throws what is near, and dazzles.
function effects.explode(place)
    local reach, kick = 4.5, 620 -- metres, kg m/s
    for _, e in ipairs(daft.query.overlap({ sphere = reach }, place, { static = false, kinematic = false })) do
        local x, y, z = e:position()
        local dx, dy, dz = x - place[1], y - place[2] + 0.6, z - place[3]
        local far = math.max(0.5, math.sqrt(dx * dx + dy * dy + dz * dz))
        local push = math.min(kick * (1 - math.min(1, far / (reach + 1))), 16 * e:mass()) / far
        e:impulse(dx * push, dy * push, dz * push)
    end
    if flash then
        flash.light:destroy()
        flash.ball:destroy()
    end
    flash = { left = 0.35, light = daft.light.point { position = place, color = { 5, 3, 1.2 }, range = 16, shadow = false },
        ball = daft.entity { sphere = 1, position = place, casts_shadow = false, material = { color = "#ff9030", emission = "#ffb050" } } }
    clouds.fire:burst(220, place)
    clouds.smoke:burst(90, place)
    clouds.chips:burst(60, place)
end

local function fade_flash(dt)
    if not flash then return end
    flash.left = flash.left - dt
    if flash.left <= 0 then
        flash.light:destroy()
        flash.ball:destroy()
        flash = nil
        return
    end
    local part = flash.left / 0.35
    flash.light:color { 5 * part, 3 * part, 1.2 * part }
    flash.ball:scale(1 + 1.6 * (1 - part) - 0.8 * (1 - part) ^ 2)
end

function effects.update(dt) fade_flash(dt) end

return effects
