-- What is only seen: the arc of the coming shot, dust, sparks, explosions.

local effects = {}

local DOTS, STEP = 16, 0.11      -- of the arc; seconds between them
local dots = {}
local flying = {}                -- bits that fly about for a moment
local flash, glow                -- an explosion's light and ball of fire, and the seconds it has left

function effects.load()
    for i = 1, DOTS do
        dots[i] = daft.entity { sphere = 0.13 - 0.005 * i, visible = false, casts_shadow = false,
            material = { color = "#fff4c8", emission = "#c8a850" } }
    end
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

function effects.burst(place, color, count, speed, size)
    for _ = 1, count do
        local turn, up = daft.random() * 2 * math.pi, daft.random()
        local bit = daft.entity { sphere = (size or 0.09) * (0.6 + 0.8 * daft.random()), position = place, casts_shadow = false,
            material = { color = color, ambient = color } }
        flying[#flying + 1] = { entity = bit, left = 0.4 + 0.4 * daft.random(), vx = speed * math.cos(turn) * (1 - up * 0.5),
            vy = speed * up, vz = speed * math.sin(turn) * (1 - up * 0.5) }
    end
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
    effects.burst(place, "#ff9838", 26, 9, 0.16)
    effects.burst(place, "#504848", 18, 5, 0.26)
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

function effects.update(dt)
    fade_flash(dt)
    for i = #flying, 1, -1 do
        local s = flying[i]
        s.left, s.vy = s.left - dt, s.vy - 9.8 * dt
        if s.left <= 0 then
            s.entity:destroy()
            table.remove(flying, i)
        else
            local x, y, z = s.entity:position()
            s.entity:position(x + s.vx * dt, math.max(0.05, y + s.vy * dt), z + s.vz * dt)
        end
    end
end

return effects
