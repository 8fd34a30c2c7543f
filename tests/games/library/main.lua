-- Library: what is in scripts/ does what its comments say.

local camera, tween = require "camera", require "tween"
local near = function(a, b, tolerance) return math.abs(a - b) <= (tolerance or 1e-6) end

for _, name in ipairs { "linear", "in", "out", "in_out", "back", "bounce" } do
    assert(near(tween.ease(name, 0), 0) and near(tween.ease(name, 1), 1), name)
    assert(tween.ease(name, -5) == tween.ease(name, 0))
end
assert(tween.ease("linear", 0.25) == 0.25 and near(tween.ease("in_out", 0.5), 0.5))
assert(not pcall(tween.ease, "wobbly", 0.5))
assert(not pcall(tween.new, 0, { x = 1 }, { x = 2 }))
assert(not pcall(tween.new, 1, { x = 1 }, { y = 2 }))

local door, arrivals = tween.new(0.5, { y = 0, z = 10 }, { y = 3, z = 0 }, "out"), 0
for _ = 1, 60 do if door:update(1 / 60) then arrivals = arrivals + 1 end end
assert(arrivals == 1 and door:done() and door.value.y == 3 and door.value.z == 0)
door:restart()
assert(door.value.y == 0 and not door:done())

local ball, follow, orbit
function daft.load()
    ball = daft.entity { sphere = 0.5, position = { 5, 1, 0 } }
    follow = camera.follow { target = ball, distance = 8, height = 4 }
    orbit = camera.orbit { target = { 0, 1, 0 }, distance = 10, pitch = 0.3 }
    assert(not pcall(camera.follow, { target = ball, hight = 4 }) and not pcall(camera.follow, {}))
end

function daft.update(dt)
    local tick = daft.tick()
    if tick < 100 then
        follow:update(dt)
        local c = daft.camera.get()
        if tick == 0 then assert(near(c.position[1], -3) and near(c.position[2], 5), "the first step jumps") end
        if tick == 1 then ball:position(6, 1, 0) end
        if tick == 3 then assert(c.position[1] > -3 and c.position[1] < -2.5, "then it glides") end
        if tick == 99 then assert(near(c.position[1], -2, 1e-3)) end
    else
        if tick == 110 then orbit:turn(math.pi / 2, 5) orbit:zoom(0.5) end
        orbit:update(dt)
        local c = daft.camera.get()
        if tick == 100 then assert(near(c.yaw, 0, 1e-4) and near(c.pitch, 0.3, 1e-4)) end
        if tick == 200 then
            assert(near(c.yaw, math.pi / 2, 1e-2) and near(c.pitch, 1.5, 1e-2) and near(orbit.now_distance, 5, 1e-2))
        end
    end
end
