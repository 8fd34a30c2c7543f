-- Little lights that fly up, fall and go out.

local sparks = {}
local flying = {}

function sparks.burst(place, color, count)
    for _ = 1, count do
        local light = daft.entity { sphere = 0.07, position = place, casts_shadow = false,
            material = { color = color, emission = color } }
        local turn = daft.random() * 2 * math.pi
        table.insert(flying, { entity = light, left = 0.5 + daft.random() * 0.4, -- seconds
            vx = 2.5 * math.cos(turn), vy = 2 + 3 * daft.random(), vz = 2.5 * math.sin(turn) })
    end
end

function sparks.update(dt)
    for i = #flying, 1, -1 do
        local s = flying[i]
        s.left, s.vy = s.left - dt, s.vy - 9.8 * dt
        if s.left <= 0 then
            s.entity:destroy()
            table.remove(flying, i)
        else
            local x, y, z = s.entity:position()
            s.entity:position(x + s.vx * dt, y + s.vy * dt, z + s.vz * dt)
        end
    end
end

return sparks
