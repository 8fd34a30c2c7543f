-- Library: what is in scripts/ does what its comments say.

local camera, shapes, tween = require "camera", require "shapes", require "tween"
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

local function refused(pattern, f, ...)
    local good, message = pcall(f, ...)
    assert(not good and message:find(pattern, 1, true), pattern .. ": " .. tostring(message))
end

-- Rays from outside find each shape where it should be, and the body under it is no larger or smaller.
local function surface(shape, from, direction, wanted)
    shape.body = "static"
    local e = daft.entity(shape)
    local seen, felt = daft.raycast(from, direction, 100), daft.query.ray(from, direction, 100)
    assert(seen and near(seen.distance, wanted, 0.01), seen and seen.distance)
    assert(felt and near(felt.distance, wanted, 0.03), felt and felt.distance)
    local n = seen.normal
    assert(n[1] * direction[1] + n[2] * direction[2] + n[3] * direction[3] < 0)
    e:destroy()
end

local function shapes_are_what_they_say()
    surface(shapes.cylinder { radius = 2, height = 3 }, { 10, 1, 0 }, { -1, 0, 0 }, 8)
    surface(shapes.cylinder { radius = 2, height = 3 }, { 1, 10, 1 }, { 0, -1, 0 }, 8.5)
    surface(shapes.cone { radius = 2, height = 4 }, { 10, 0, 0 }, { -1, 0, 0 }, 9)
    surface(shapes.cone { radius = 2, height = 4 }, { 0.5, -10, 0 }, { 0, 1, 0 }, 8)
    surface(shapes.capsule { radius = 1, height = 4 }, { 10, 0.5, 0 }, { -1, 0, 0 }, 9)
    surface(shapes.capsule { radius = 1, height = 4 }, { 0, 10, 0 }, { 0, -1, 0 }, 8)
    surface(shapes.text { text = "I\nI", size = 2, depth = 1 }, { 0, 1, 10 }, { 0, 0, -1 }, 9.5)
    surface(shapes.torus { radius = 2, thickness = 1 }, { 10, 0, 0 }, { -1, 0, 0 }, 7.5)
    surface(shapes.torus { radius = 2, thickness = 1 }, { 2, 10, 0 }, { 0, -1, 0 }, 9.5)
    surface(shapes.disc { radius = 2 }, { 1, 10, 0 }, { 0, -1, 0 }, 10)
    local hole = daft.entity(shapes.torus { radius = 2, thickness = 1, body = "static" })
    assert(not daft.raycast({ 0, 10, 0 }, { 0, -1, 0 }) and not daft.query.ray({ 0, 10, 0 }, { 0, -1, 0 }, 100))
    hole:destroy()
    local ring = daft.entity(shapes.torus { radius = 2, thickness = 1, body = "dynamic", mass = 3 })
    assert(near(ring:mass(), 3, 1e-4) and near(daft.query.ray({ 10, 0, 0 }, { -1, 0, 0 }, 100).distance, 7.5, 0.022))
    assert(not daft.query.ray({ 0, 10, 0 }, { 0, -1, 0 }, 100), "a ring that moves has its hole")
    ring:destroy()
    local can = shapes.cylinder { radius = 2, name = "can", collider = { sphere = 1 }, body = "static" }
    assert(can.name == "can" and can.collider.sphere == 1 and can.radius == nil)
    assert(can.mesh == shapes.cylinder { radius = 2 }.mesh and can.mesh ~= shapes.cylinder { radius = 3 }.mesh)
    assert(shapes.cone {}.collider == nil, "what is no body has no collider")
    refused("shapes.cylinder: radius: number above 0 expected, got -1", shapes.cylinder, { radius = -1 })
    refused("shapes.cone: height: number above 0 expected", shapes.cone, { height = 0 / 0 })
    refused("sides: 3 to 256 expected, got 2", shapes.disc, { sides = 2 })
    refused("at least twice the radius", shapes.capsule, { radius = 2, height = 3 })
    refused("less than twice the radius", shapes.torus, { radius = 1, thickness = 2 })
    refused("table expected, got number", shapes.cone, 3)
    refused("there is no 'hight'", function() daft.entity(shapes.cone { hight = 3 }) end)
end

local function rides()
    local points = { { time = 0, position = { 0, 0, 0 } }, { time = 1, position = { 2, 0, 0 }, yaw = 1 },
        { time = 3, position = { 2, 0, 4 }, yaw = 1, fov = 1 } }
    local ride = camera.path { points = points }
    for i, wanted in ipairs(points) do
        local view = ride:get(wanted.time)
        assert(near(view.position[1], wanted.position[1]) and near(view.position[3], wanted.position[3]), i)
        assert(near(view.yaw, wanted.yaw or 0, 1e-5))
    end
    assert(near(ride:get(3).fov, 1, 1e-5) and near(ride:get(99).position[3], 4) and near(ride:get(-1).position[1], 0))
    -- The same in twice the time, at one speed: half of the way after half of it.
    local even = camera.path { points = { { 0, 0, 0 }, { 1, 0, 0 }, { 8, 0, 0 } }, pace = "constant", seconds = 10 }
    assert(near(even:get(5).position[1], 4, 0.01))
    local eased = camera.path { points = { { 0, 0, 0 }, { 8, 0, 0 } }, seconds = 2, ease = "in_cubic" }
    assert(near(eased:get(1).position[1], 1, 0.01))
    local bent = camera.path { points = { { 0, 0, 0 }, { 0, 4, 0 }, { 4, 4, 0 }, { 4, 0, 0 } }, curve = "bezier", seconds = 1 }
    assert(near(bent:get(0.5).position[1], 2) and near(bent:get(0.5).position[2], 3) and near(bent:get(1).position[2], 0))
    local look = camera.path { points = { { position = { 0, 0, 0 }, at = { 0, 0, 5 } }, { 1, 0, 0 } } }
    assert(near(look:get(0).yaw, math.pi / 2, 1e-5))
    local around = camera.path { points = { { 0, 3, 0 }, { 4, 3, 0 } }, at = { 2, 0, 0 }, seconds = 0.5, loop = true }
    assert(not around:update(1 / 60))
    assert(near(daft.camera.get().pitch, math.atan(3, 2), 1e-5), "it looks at its target")
    for _ = 1, 31 do assert(not around:update(1 / 60)) end
    assert(around.time < 0.1, "it begins again")
    refused("there is no option 'sped'", camera.path, { sped = 2 })
    refused("there are no points", camera.path, {})
    refused("4, 7, 10 ... points expected, got 2", camera.path, { points = { { 0, 0, 0 }, { 1, 0, 0 } }, curve = "bezier" })
    refused("must be after that of the one before it", camera.path, { points = { { time = 1, 0, 0, 0 }, { time = 1, 1, 0, 0 } } })
    refused("did you mean 'position'", daft.camera.along, { { postion = { 1, 2, 3 } } }, 0)
    refused("points: 1 to 10000 checkpoints expected, got 0", daft.camera.along, {}, 0)
    assert(#daft.camera.checkpoints() == 0)
end

local function tweens()
    local there = tween.new(1, { x = 0 }, { x = 8 }, { curve = "linear", delay = 0.5, times = 4, back_and_forth = true })
    local function after(seconds)
        there:restart()
        there:update(seconds)
        return there.value.x
    end
    assert(near(after(0.25), 0) and near(after(0.75), 2) and near(after(1.75), 6) and near(after(4.25), 2) and near(after(9), 0))
    assert(there:done() and not there:update(1))
    for _, kind in ipairs { "quad", "cubic", "quart", "sine", "expo", "circ", "back", "elastic", "bounce" } do
        for _, side in ipairs { "in_", "out_", "in_out_" } do
            local name = side .. kind
            assert(near(tween.ease(name, 0), 0, 1e-3) and near(tween.ease(name, 1), 1, 1e-3), name)
        end
        assert(near(tween.ease("in_" .. kind, 0.3), 1 - tween.ease("out_" .. kind, 0.7), 1e-9), kind)
        assert(near(tween.ease("in_out_" .. kind, 0.5), 0.5, 1e-3), kind)
    end
    assert(tween.ease(function(t) return t * 10 end, 0.5) == 5)
    refused("there is no option 'dely'", tween.new, 1, { x = 0 }, { x = 1 }, { dely = 1 })
    refused("times: 1 or more", tween.new, 1, { x = 0 }, { x = 1 }, { times = 0 })
    refused("a function of the values", tween.start, 1, { x = 0 }, { x = 1 }, "out")
end

local decals, trail = require "decals", require "trail"
local wake, runner
local function marks()
    local post = daft.entity { box = { 1, 4, 1 }, position = { 200, 0, 0 } }
    local set = decals.new { most = 2, size = 0.5, lift = 0.01 }
    local first = set:place(daft.raycast({ 205, 1, 0 }, { -1, 0, 0 }))
    local x, y, z = first:world_position()
    assert(near(x, 200.51, 1e-4) and near(y, 1) and near(z, 0) and first:parent() == post)
    local ux, uy = first:up()
    assert(near(ux, 1, 1e-5) and near(uy, 0, 1e-5), "it lies on the surface")
    post:position(210, 0, 0)
    assert(near(first:world_position(), 210.51, 1e-4), "and goes with it")
    local below = set:place(daft.raycast({ 210, -9, 0 }, { 0, 1, 0 }), { turn = 1, size = 2 })
    assert(near(select(2, below:up()), -1, 1e-5) and near(below:scale(), 2, 1e-5))
    assert(daft.raycast({ 210, -9, 0 }, { 0, 1, 0 }).entity == below, "it is seen from below")
    set:place { point = { 0, 90, 0 }, normal = { 0, 1, 0 } }
    assert(not first:valid() and below:valid(), "the oldest makes room")
    set:clear()
    assert(not below:valid())
    post:destroy()
    refused("there is no option 'siz'", decals.new, { siz = 1 })
    refused("a hit with position and normal", function() set:place {} end)
    runner = daft.entity { position = { 0, 50, 0 } }
    wake = trail.new { target = runner, width = 1, seconds = 0.5, pieces = 10 }
    refused("there is no option 'widht'", trail.new, { target = runner, widht = 1 })
    refused("target = an entity", trail.new, {})
end

local slide, seen = nil, 0
local function begin_slide()
    slide = tween.start(0.5, { x = 0 }, { x = 1 }, "linear", function(value) seen = value.x end)
    local never = tween.start(0.5, { x = 0 }, { x = 1 }, "linear", function(value) assert(value.x == 0) end)
    never:stop()
end

local ball, follow, orbit
function daft.load()
    rides() tweens() begin_slide() marks()
    shapes_are_what_they_say()
    ball = daft.entity { sphere = 0.5, position = { 5, 1, 0 } }
    follow = camera.follow { target = ball, distance = 8, height = 4 }
    orbit = camera.orbit { target = { 0, 1, 0 }, distance = 10, pitch = 0.3 }
    assert(not pcall(camera.follow, { target = ball, hight = 4 }) and not pcall(camera.follow, {}))
end

function daft.update(dt)
    local tick = daft.tick()
    if tick <= 60 then
        runner:position(tick / 10, 50, 0)
        wake:update(dt)
    end
    if tick == 60 then
        local hit = daft.raycast({ 5, 60, 0 }, { 0, -1, 0 }, 20)
        assert(hit and near(hit.distance, 10, 1e-4), "the ribbon lies behind the runner")
        assert(daft.raycast({ 5.5, 60, 0.35 }, { 0, -1, 0 }, 20) and not daft.raycast({ 3.5, 60, 0.35 }, { 0, -1, 0 }, 20), "and narrows")
        assert(not daft.raycast({ 2, 60, 0 }, { 0, -1, 0 }, 20), "it is half a second long")
        wake:destroy()
    end
    if tick == 16 then assert(near(seen, 0.5, 1e-9), seen) end
    if tick == 40 then assert(seen == 1 and slide:done()) end
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
