-- Bodies as a game has them: every shape, joint, event and query does what the manual says.

local bodies, joints = {}, {}

local function near(a, b, tolerance) return math.abs(a - b) <= (tolerance or 1e-6) end
local function expect_error(part, f, ...)
    local good, message = pcall(f, ...)
    assert(not good, "an error was expected: " .. part)
    assert(tostring(message):find(part, 1, true), tostring(message))
end
local function check(good, ...)
    if good then return good end
    error(table.concat({ "tick " .. daft.tick(), ... }, " "), 2)
end

-- Each scene stands on a floor of its own.
local function ground(x, z, more)
    local e = { box = { 8, 1, 8 }, position = { x, -0.5, z }, body = "static" }
    for k, v in pairs(more or {}) do e[k] = v end
    return daft.entity(e)
end

-- ---- shapes ----

local function shapes()
    ground(0, 0)
    local tetra = daft.mesh { positions = { { 0.3, 0.3, 0.3 }, { 0.3, -0.3, -0.3 }, { -0.3, 0.3, -0.3 }, { -0.3, -0.3, 0.3 } },
        triangles = { { 1, 2, 3 }, { 1, 4, 2 }, { 1, 3, 4 }, { 2, 4, 3 } } }
    bodies.resting = {
        daft.entity { sphere = 0.3, position = { -3, 0.4, 0 }, body = "dynamic", rolling_resistance = 0.05 },
        daft.entity { box = { 0.5, 0.5, 0.5 }, position = { -2, 0.4, 0 }, body = "dynamic" },
        daft.entity { position = { -1, 0.6, 0 }, body = "dynamic", collider = { capsule = { radius = 0.2, height = 1 } }, rolling_resistance = 0.1 },
        daft.entity { position = { 0, 0.4, 0 }, body = "dynamic", collider = { cylinder = { radius = 0.3, height = 0.6 } } },
        daft.entity { mesh = tetra, position = { 1, 0.5, 0 }, body = "dynamic" },
        daft.entity { mesh = tetra, position = { 2, 0.5, 0 }, body = "dynamic", collider = { hull = tetra } },
        daft.entity { position = { 3, 0.6, 0 }, body = "dynamic",
            collider = { { box = { 0.6, 0.2, 0.6 } }, { sphere = 0.2, position = { 0, 0.3, 0 } } } },
    }
    -- Triangles and heights carry what falls on them; where a height is false there is a hole.
    local sheet = daft.mesh { positions = { { -1, 0, -1 }, { 1, 0, -1 }, { 1, 0, 1 }, { -1, 0, 1 } }, triangles = { { 1, 3, 2 }, { 1, 4, 3 } } }
    daft.entity { mesh = sheet, position = { 0, 2, 3 }, body = "static" }
    daft.entity { position = { 2, 3, 2 }, body = "static", collider = { heights = { 0, 0, 0, 0, 0, 0, 0, 0, false }, columns = 3, spacing = 1 } }
    bodies.on_sheet = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { 0.1, 2.4, 3 }, body = "dynamic" }
    bodies.on_heights = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { 2.5, 3.4, 2.5 }, body = "dynamic" }
    bodies.through_hole = daft.entity { sphere = 0.2, position = { 3.7, 3.4, 3.7 }, body = "dynamic" }
    check(near(bodies.resting[2]:mass(), 125, 1e-3) and near(bodies.resting[4]:mass(), 1000 * math.pi * 0.09 * 0.6, 1e-2))
    expect_error("which has no mass", daft.entity, { mesh = sheet, body = "dynamic", collider = { mesh = sheet } })
    expect_error("hull", daft.entity, { body = "dynamic", collider = { hull = sheet } })
end

local function shapes_rest()
    for i, e in ipairs(bodies.resting) do
        local x, y, z = e:velocity()
        check(not e:awake() or x * x + y * y + z * z < 0.01, "shape", i, "moves")
        check(select(2, e:position()) > 0.05, "shape", i, "is below the floor")
    end
    check(near(select(2, bodies.on_sheet:position()), 2.2, 5e-3), "on triangles")
    check(near(select(2, bodies.on_heights:position()), 3.2, 5e-3), "on heights")
    check(select(2, bodies.through_hole:position()) < 2, "through the hole")
end

-- ---- joints ----

local function bob(x, y, more)
    local e = { sphere = 0.2, position = { x, y, 20 }, body = "dynamic", mass = 2, sleeps = false }
    for k, v in pairs(more or {}) do e[k] = v end
    return daft.entity(e)
end

local function make_joints()
    local b = {}
    bodies.bobs = b
    b.ball = bob(-9, 5)
    joints.ball = daft.joint { kind = "ball", b = b.ball, at = { -10, 5, 20 }, limit = 0.5, axis = { 1, 0, 0 } }
    b.hinge = bob(-5, 5, { sphere = 0.4 })
    joints.hinge = daft.joint { kind = "hinge", b = b.hinge, at = { -6, 5, 20 }, axis = { 0, 0, 1 }, limit = { -0.5, 0.5 } }
    b.slider = bob(0, 5)
    joints.slider = daft.joint { kind = "slider", b = b.slider, axis = { 0, 1, 0 }, limit = { -0.5, 0.5 } }
    b.motor = bob(3, 5)
    joints.motor = daft.joint { kind = "slider", b = b.motor, axis = { 0, 1, 0 }, motor = { speed = 1, force = 100 } }
    b.rod = bob(7, 5)
    joints.rod = daft.joint { kind = "distance", b = b.rod, at = { 6, 5, 20 } }
    b.rope = bob(9, 5)
    joints.rope = daft.joint { kind = "distance", b = b.rope, at = { 9, 5.5, 20 }, limit = 1.5 }
    b.spring = bob(12, 5)
    joints.spring = daft.joint { kind = "distance", b = b.spring, at = { 12, 6, 20 }, length = 1, spring = { hertz = 2, damping = 1 } }
    b.fixed, b.other = bob(15, 5), bob(15.6, 5)
    joints.wall = daft.joint { kind = "fixed", b = b.fixed }
    joints.fixed = daft.joint { kind = "fixed", a = b.fixed, b = b.other }
    b.drag = bob(18, 5)
    joints.drag = daft.joint { kind = "drag", b = b.drag, to = { 19, 6, 20 } }
    b.weak = bob(22, 5, { mass = 50 })
    joints.weak = daft.joint { kind = "fixed", b = b.weak, break_force = 100 }
    b.gone = bob(25, 5)
    joints.gone = daft.joint { kind = "ball", b = b.gone, at = { 25, 6, 20 } }
    expect_error("b", daft.joint, { kind = "ball" })
    expect_error("kind: \"ball\", \"hinge\"", daft.joint, { kind = "rope", b = b.rope })
    local dead = bob(28, 5)
    dead:destroy()
    expect_error("stale", daft.joint, { kind = "ball", b = dead })
    expect_error("", daft.joint, { kind = "ball", a = b.ball, b = b.ball })
    expect_error("finite", daft.joint, { kind = "ball", b = b.ball, at = { 0 / 0, 0, 0 } })
    expect_error("axis", daft.joint, { kind = "hinge", b = b.ball, axis = { 0, 0, 0 } })
end

local function joints_hold()
    local b = bodies.bobs
    local x, y = b.ball:position()
    check(near((x + 10) ^ 2 + (y - 5) ^ 2, 1, 1e-2) and near(y, 5 - math.sin(0.5), 0.03), "cone of a ball", x, y)
    check(near(joints.hinge:value(), -0.5, 0.03), "hinge's limit", joints.hinge:value())
    check(near(joints.slider:value(), -0.5, 0.01), "slider's limit", joints.slider:value())
    check(near(select(2, joints.motor:value()), 1, 1e-2), "slider's motor")
    check(near(joints.motor:force(), 2 * 9.81, 0.5), "what the motor holds", (joints.motor:force()))
    check(near(joints.rod:value(), 1, 1e-3), "rod")
    check(near(joints.rope:value(), 1.5, 0.02), "rope", joints.rope:value())
    local sag = 9.81 / (2 * math.pi * 2) ^ 2
    check(near(joints.spring:value(), 1 + sag, 0.01), "spring", joints.spring:value())
    x, y = b.other:position()
    check(near(x, 15.6, 0.01) and near(y, 5, 0.01), "fixed", x, y)
    x, y = b.drag:position()
    check(near(x, 19, 0.2) and near(y, 6, 0.2), "drag", x, y)
    check(not joints.weak:valid() and select(2, b.weak:position()) < 4, "it broke")
    check(not joints.gone:valid(), "went with its body")
    expect_error("stale", joints.weak.value, joints.weak)
end

-- ---- surfaces, belts, gravity ----

local function surfaces()
    ground(0, 40, { surface = "rink", friction = 0.8 })
    daft.surfaces("rink", "skate", { friction = 0, restitution = 0 })
    daft.surfaces("rink", "rubber", { restitution = 0.9 })
    bodies.skate = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { -3, 0.2, 40 }, body = "dynamic", surface = "skate", friction = 0.8, velocity = { 1, 0, 0 } }
    bodies.brick = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { -3, 0.2, 42 }, body = "dynamic", friction = 0.8, velocity = { 1, 0, 0 } }
    bodies.rubber = daft.entity { sphere = 0.2, position = { 2, 1.2, 40 }, body = "dynamic", surface = "rubber" }
    daft.entity { box = { 6, 0.2, 1 }, position = { 0, 0.1, 38 }, body = "static", surface_velocity = { 1, 0, 0 }, friction = 1 }
    bodies.on_belt = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { -2.5, 0.4, 38 }, body = "dynamic" }
    bodies.free_ball = daft.entity { sphere = 0.3, position = { -3, 0.3, 44 - 0.8 }, body = "dynamic", velocity = { 1, 0, 0 }, angular_velocity = { 0, 0, -1 / 0.3 } }
    bodies.braked_ball = daft.entity { sphere = 0.3, position = { -3, 0.3, 36.8 }, body = "dynamic", rolling_resistance = 0.1, velocity = { 1, 0, 0 }, angular_velocity = { 0, 0, -1 / 0.3 } }
    bodies.balloon = daft.entity { sphere = 0.3, position = { 3, 3, 42 }, body = "dynamic", gravity_scale = -0.1 }
    bodies.slow = daft.entity { sphere = 0.3, position = { 3, 30, 44 }, body = "dynamic", gravity_scale = 0, damping = 2, velocity = { 0, 0, 3 } }
    expect_error("friction", daft.surfaces, "rink", "skate", { friction = -1 })
end

local function surfaces_act()
    check(near(bodies.skate:velocity(), 1, 1e-3), "ice", (bodies.skate:velocity()))
    check(near(bodies.brick:velocity(), 0, 1e-3), "brick")
    check(near(bodies.on_belt:velocity(), 1, 1e-2), "surface velocity", (bodies.on_belt:velocity()))
    check(near(bodies.free_ball:velocity(), 1, 1e-2), "rolls on")
    check(near(bodies.braked_ball:velocity(), 0, 1e-3), "rolling resistance")
    check(select(2, bodies.balloon:velocity()) > 1, "gravity_scale")
    local vz = select(3, bodies.slow:velocity())
    check(near(vz, 3 * math.exp(-2 * daft.tick() / 60), 0.05), "damping", vz)
end

-- ---- layers, sensors, sleep, events ----

local seen = {}

local function layers()
    ground(0, 60, { layer = "world" })
    bodies.ghost = daft.entity { sphere = 0.3, position = { -2, 1, 60 }, body = "dynamic", layer = "ghost", hits = "ghost" }
    bodies.solid = daft.entity { sphere = 0.3, position = { 0, 1, 60 }, body = "dynamic", layer = "solid", hits = { "world" }, rolling_resistance = 0.1 }
    daft.entity { box = { 1, 1, 1 }, position = { 0, 0.5, 60 }, body = "static", sensor = true, layer = "world", name = "gate" }
    bodies.sleeper = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { 2, 0.2, 60 }, body = "dynamic" }
    bodies.doomed = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { 3, 1, 60 }, body = "dynamic", name = "doomed" }
    bodies.faller = daft.entity { box = { 0.4, 0.4, 0.4 }, position = { 3, 3, 60 }, body = "dynamic" }
end

-- The world is changed from within its events: what is told stays told.
local function events()
    for _, event in ipairs(daft.events()) do
        seen[event.kind] = (seen[event.kind] or 0) + 1
        if event.kind == "begin" then
            check(event.impulse >= 0 and event.speed and event.point and near(event.normal[1] ^ 2 + event.normal[2] ^ 2 + event.normal[3] ^ 2, 1, 1e-4))
            if event.a:valid() and event.b:valid() and (event.a.name == "doomed" or event.b.name == "doomed") and daft.tick() > 20 then
                bodies.doomed:destroy()
                daft.entity { sphere = 0.2, position = { 3, 4, 60 }, body = "dynamic" }
            end
        end
        if event.kind == "break" then check(event.joint == joints.weak, "what broke") end
        if event.kind == "gone" then seen.gone_joint = event.joint end
        if event.kind == "enter" then check(event.a.name == "gate" and event.b == bodies.solid) end
        if event.kind == "sleep" and event.a == bodies.sleeper then seen.slept = daft.tick() end
    end
end

local function layers_act()
    check(select(2, bodies.ghost:position()) < -2, "a ghost falls")
    check(near(select(2, bodies.solid:position()), 0.3, 1e-2), "what is solid does not")
    check(seen.begin and seen.sleep and seen["break"] == 1 and seen.enter == 1, "events")
    check(seen.gone_joint == nil or seen.gone_joint == joints.gone)
    check(seen.slept and seen.slept < 60 and not bodies.sleeper:awake(), "asleep")
    check(not bodies.doomed:valid(), "destroyed by an event")
end

-- ---- characters ----

local function characters()
    ground(0, 80)
    daft.entity { box = { 4, 0.3, 8 }, position = { 3, 0.15, 80 }, body = "static" }
    bodies.lift = daft.entity { box = { 2, 0.2, 2 }, position = { -3, 0.1, 78 }, body = "kinematic" }
    local slope = daft.entity { box = { 4, 0.2, 2 }, position = { 0, 0, 83 }, rotation = { 0, 0, math.sin(0.3), math.cos(0.3) }, body = "static" }
    check(slope)
    bodies.climber = daft.character { position = { -0.5, 0.95, 80 } }
    bodies.climber:walk(2, 0)
    bodies.rider = daft.character { position = { -3, 1.2, 78 } }
end

local function characters_act(tick)
    local t = tick / 60
    bodies.lift:position(-3 + 0.5 * t, 0.1 + 0.5 * t, 78)
    if tick == 90 then
        local x, y = bodies.climber:position()
        check(x > 1.5 and near(y, 0.3 + 0.9, 0.03), "it climbed the step", x, y)
        x, y = bodies.rider:position()
        local lx, ly = bodies.lift:position()
        check(near(x, lx, 0.05) and near(y, ly + 0.1 + 0.9, 0.05), "it rides", x, lx, y, ly)
        check(bodies.rider:ground() == bodies.lift, "what it stands on")
        bodies.climber:walk(0, 0)
    end
end

-- ---- queries ----

local function queries()
    local a = daft.entity { box = { 1, 1, 1 }, position = { 0, 100, 0 }, body = "static", layer = "a" }
    local b = daft.entity { sphere = 0.5, position = { 3, 100, 0 }, body = "kinematic", layer = "b" }
    local c = daft.entity { position = { 6, 100, 0 }, body = "dynamic", gravity_scale = 0, layer = "c", collider = { capsule = { radius = 0.5, height = 2 } } }
    local s = daft.entity { box = { 1, 1, 1 }, position = { 9, 100, 0 }, body = "static", sensor = true }
    local from, direction = { -5, 100, 0 }, { 1, 0, 0 }
    local function first(options) local hit = daft.query.ray(from, direction, 100, options) return hit and hit.entity end
    check(first() == a and first { static = false } == b and first { static = false, kinematic = false } == c)
    check(first { ignore = a } == b and first { hits = { "c" } } == c and first { static = false, kinematic = false, dynamic = false } == nil)
    check(first { static = true, kinematic = false, dynamic = false, ignore = a, sensors = true } == s)
    check(#daft.query.all(from, direction) == 3 and #daft.query.all(from, direction, 100, { sensors = true }) == 4)
    check(near(daft.query.cast({ box = { 1, 1, 1 } }, from, direction).distance, 4, 1e-3))
    check(near(daft.query.cast({ capsule = { 0.25, 1 } }, from, direction, 100, { static = false }).distance, 7.25, 1e-3))
    check(daft.query.cast({ sphere = 0.5 }, from, direction, 100, { hits = "c" }).entity == c)
    check(#daft.query.overlap({ sphere = 3 }, { 1.5, 100, 0 }) == 2 and #daft.query.overlap({ sphere = 3 }, { 1.5, 100, 0 }, { static = false }) == 1)
    local hit = daft.query.closest({ 3, 102, 0 }, 10)
    check(hit.entity == b and near(hit.distance, 1.5, 1e-4) and near(hit.position[2], 100.5, 1e-4))
    expect_error("finite", daft.query.ray, { 0 / 0, 0, 0 }, direction)
    expect_error("direction", daft.query.cast, { sphere = 1 }, from, { 0, 0, 0 })
    expect_error("finite", daft.query.overlap, { sphere = 0 / 0 }, from)
    for _, e in ipairs { a, b, c, s } do e:destroy() end
end

-- ---- bad input ----

local function bad_input()
    local nan, huge = 0 / 0, math.huge
    for _, wrong in ipairs { nan, huge, -huge, -1 } do
        expect_error("", daft.entity, { sphere = 0.5, body = "dynamic", mass = wrong })
        expect_error("", daft.entity, { sphere = 0.5, body = "dynamic", density = wrong })
        expect_error("", daft.entity, { sphere = 0.5, body = "dynamic", friction = wrong })
        expect_error("", daft.entity, { body = "dynamic", collider = { capsule = { radius = wrong, height = 1 } } })
        expect_error("", daft.entity, { body = "dynamic", collider = { box = { 1, wrong, 1 } } })
    end
    for _, wrong in ipairs { nan, huge, -huge } do
        expect_error("", daft.entity, { sphere = 0.5, body = "dynamic", velocity = { wrong, 0, 0 } })
        expect_error("", daft.entity, { sphere = 0.5, body = "dynamic", gravity_scale = wrong })
        expect_error("", daft.gravity, 0, wrong, 0)
        local e = daft.entity { sphere = 0.5, position = { 0, 200, 0 }, body = "dynamic" }
        for _, method in ipairs { "push", "impulse", "torque", "angular_impulse", "velocity", "angular_velocity", "position", "teleport" } do
            expect_error("", e[method], e, wrong, 0, 0)
        end
        e:destroy()
    end
    expect_error("", daft.entity, { sphere = 0.5, body = "dynamic", mass = 0 })
    expect_error("", daft.entity, { body = "static", collider = { heights = { 0, nan, 0, 0 }, columns = 2 } })
end

-- ---- saved and put back ----

local saved, places

local function all_places()
    local out = {}
    for i, e in ipairs(bodies.resting) do out[3 * i - 2], out[3 * i - 1], out[3 * i] = e:position() end
    out[#out + 1] = joints.hinge:value()
    return out
end

function daft.load()
    daft.light.sun { direction = { -1, -2, -0.5 } }
    shapes() make_joints() surfaces() layers() characters() queries() bad_input()
    for i = 1, 300 do daft.entity { box = { 0.5, 0.5, 0.5 }, position = { 60, 1, 60 }, body = "dynamic" } end
    daft.entity { box = { 100, 1, 100 }, position = { 60, -0.5, 60 }, body = "static" }
end

function daft.update(dt)
    local tick = daft.tick()
    events()
    characters_act(tick)
    if tick == 30 then bodies.bobs.gone:destroy() end
    if tick == 60 then saved = daft.save_bodies() end
    if tick == 70 then
        places = all_places()
        daft.load_bodies(saved)
    end
    if tick == 80 then
        for i, value in ipairs(all_places()) do check(value == places[i], "place", i, "after it was put back") end
    end
    if tick == 119 then joints_hold() surfaces_act() layers_act() end
    if tick == 239 then shapes_rest() end
end
