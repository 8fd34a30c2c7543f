-- Api: every binding does what its line in the reference says. An assertion that fails is the game's error.

local near = function(a, b, tolerance) return math.abs(a - b) <= (tolerance or 1e-5) end
local function expect_error(pattern, f, ...)
    local good, message = pcall(f, ...)
    assert(not good, "no error where one was due: " .. pattern)
    assert(message:find(pattern, 1, true), ("'%s' is not in '%s'"):format(pattern, message))
end

local ball, floor, child, sun, light
local drawn = 0

-- What clips do is told by e:animation() alone.
local function animation()
    expect_error("the entity shows no mesh", floor.clips, floor)
    local good, mesh = pcall(daft.mesh, "meshes/figure.glb")
    if not good then return end -- this build has no Assimp
    local figure = daft.entity { mesh = mesh, clip = "walk" }
    local clips = figure:clips()
    assert(#clips == 4 and clips[2].name == "walk" and near(clips[2].duration, 1))
    local now = figure:animation()
    assert(now.clip == "walk" and now.time == 0 and now.loop and now.playing and now.weight == 1 and now.speed == 1)
    figure:animation_time(2.25)
    assert(near(figure:animation().time, 0.25))
    figure:play("walk", { speed = 2 }) -- goes on
    assert(near(figure:animation().time, 0.25) and figure:animation().speed == 2)
    figure:play(3, { blend = 0.5, start = 0.1, loop = false })
    now = figure:animation()
    assert(now.clip == "run" and now.weight == 0 and near(now.time, 0.1) and not now.loop)
    expect_error("it has idle, walk, run, wave", figure.play, figure, "wolk")
    expect_error("speed", figure.play, figure, "walk", { sped = 2 })
    expect_error("4 clips", figure.play, figure, 5)
    expect_error("only a mesh has clips", daft.entity, { box = { 1, 1, 1 }, clip = "walk" })
    figure:stop()
    assert(figure:animation() == nil)
    expect_error("plays no clip", figure.animation_time, figure, 1)
    figure:destroy()
end

-- A file's lights and cameras are there where they are asked for, where the entity stands.
local function scenery()
    expect_error("the entity shows no mesh", floor.cameras, floor)
    local good, mesh = pcall(daft.mesh, "lit.gltf")
    if not good then return end -- this build has no Assimp
    local triangle = daft.entity { mesh = mesh, position = { 10, 0, 0 } }
    local eye = triangle:cameras().eye
    assert(#triangle:cameras() == 1 and near(eye.position[1], 10) and near(eye.position[3], 5))
    assert(near(eye.yaw, -math.pi / 2) and near(eye.pitch, 0) and near(math.tan(eye.fov / 2), 2 * math.tan(0.4)))
    local before = daft.camera.get()
    daft.camera.set(eye)
    daft.camera.set(before)
    local lamps = triangle:add_lights()
    assert(#lamps == 1 and lamps[1]:valid())
    lamps[1]:set { inverse_square = false }
    lamps[1]:destroy()
    triangle:destroy()
end

local function entities()
    floor = daft.entity { box = { 20, 1, 20 }, position = { 0, -0.5, 0 }, material = "checker", body = "static", name = "floor" }
    ball = daft.entity { sphere = 0.5, position = { 0, 0.5, 0 }, mass = 2, body = "dynamic", material = { mirror = 0.8 },
        velocity = { 0, 0, 0 }, restitution = 0, data = { lives = 3 } }
    child = daft.entity { box = { 1, 2, 3 }, parent = floor, position = { 1, 2, 3 }, material = "#ff8800" }
    assert(floor.name == "floor" and ball.name == nil and ball.data.lives == 3)
    ball.name = "ball"
    assert(ball.name == "ball" and tostring(ball):find("entity"))
    local x, y, z = child:position()
    assert(x == 1 and y == 2 and z == 3)
    child:position(4, 5, 6)
    child:position { 4, 5, 7 }
    child:teleport { x = 4, y = 5, z = 8 }
    assert(select(3, child:position()) == 8)
    child:position(ball)
    assert(select(2, child:position()) == 0.5)
    child:scale(2)
    assert(select(2, child:scale()) == 2)
    child:scale(1, 2, 3)
    child:scale { 3, 2, 1 }
    assert(child:scale() == 3)
    assert(child:visible() == true)
    child:visible(false)
    assert(child:visible() == false)
    child:material { color = { 1, 0, 0 }, texture = "checker", texture_scale = { 2, 3 }, shininess = 20, specular = 0.4,
        emission = "#111", ambient = 0.5, mirror_tint = "#ffffff", transmission = 0.5, transmission_tint = "#cfc",
        refractive_index = 1.33 }
    child:destroy()
    assert(not child:valid())
    expect_error("stale", child.position, child)
end

-- What faced +X must face where a camera of the same yaw and pitch looks.
local function rotations()
    local e = daft.entity { box = { 1, 1, 1 }, rotation = { math.pi / 2, 0, 0 } }
    local x, y, z, w = e:rotation()
    assert(near(x, 0) and near(y, -math.sqrt(0.5)) and near(z, 0) and near(w, math.sqrt(0.5)))
    e:rotation(0, 0, 0, 2)
    assert(select(4, e:rotation()) == 1)
    e:rotation { 0, 0, 0.3 }
    e:rotation(0.1, 0.2, 0.3)
    expect_error("rotation: a quaternion of length 0", e.rotation, e, 0, 0, 0, 0)
    expect_error("{yaw, pitch, roll} or a quaternion", e.rotation, e, "left")
    e:destroy()
end

local function lights()
    sun = daft.light.sun { direction = { -1, -2, -0.5 }, color = { 1, 0.96, 0.9 } }
    light = daft.light.point { position = { 0, 5, 0 }, color = "#ffeecc", shadow = false }
    sun:direction(0, -1, 0)
    light:position(ball)
    light:color("#fff")
    light:shadow(true)
    light:set { position = { 1, 5, 1 }, color = { 2, 2, 2 } }
    expect_error("a sun has a direction", sun.position, sun, 0, 0, 0)
    expect_error("no 'positon': did you mean 'position'?", daft.light.point, { positon = { 0, 1, 0 } })
    local spot = daft.light.spot { position = { 0, 5, 0 }, direction = { 0, -1, 0 }, angle = 0.5, inner = 0.4 }
    spot:direction(1, -1, 0)
    spot:position(1, 5, 0)
    spot:set { angle = 0.3 } -- inner follows
    expect_error("inner_angle is 0.9", spot.set, spot, { inner = 0.9 })
    expect_error("angle is 4", daft.light.spot, { angle = 4 })
    spot:destroy()
    local panel = daft.light.rectangle { position = { 0, 3, 0 }, direction = { 0, -1, 0 }, size = { 2, 1 }, turn = 0.5 }
    panel:set { size = { 1, 1 }, range = 5 }
    panel:direction(1, 0, 0)
    expect_error("size.x is 0", panel.set, panel, { size = { 0, 1 } })
    panel:destroy()
    daft.entity({ sphere = 0.1, position = { 0, 60, 0 }, material = { emission = 5 }, lights = true }):destroy()
    local short = daft.light.point { position = { 0, 1, 0 } }
    short:destroy()
    assert(not short:valid() and sun:valid())
    daft.ambient("#333")
    daft.fog { color = "#89a", density = 0.02, height = 5, base = -1, glow = 0.4 }
    daft.fog {}
    daft.sky.color("#80a0ff")
    daft.sky.gradient("#6fb7ff", { 0.9, 0.95, 1 })
    daft.sky.light(0.8, 2)
    expect_error("strength", daft.sky.light, -1)
    daft.sky.light()
    daft.ambient("#333")
    local face = "textures/checker.png"
    daft.sky.cube(face, face, face, face, face, face)
    expect_error("top", daft.sky.cube, face, face)
    expect_error("square", daft.sky.cube, "sky/day.jpg", face, face, face, face, face)
    daft.sky.gradient("#6fb7ff", { 0.9, 0.95, 1 })
    daft.exposure { auto = true, curve = "agx", ev = 0.5 }
    expect_error('"aces" or "agx" expected', daft.exposure, { curve = "film" })
    daft.exposure {}
end

local function cameras()
    daft.camera.look { from = { -8, 4, 0 }, at = ball, fov = 1.2, teleport = true }
    local c = daft.camera.get()
    assert(c.position[1] == -8 and near(c.yaw, 0) and c.pitch > 0 and near(c.fov, 1.2))
    daft.camera.look { from = { 0, 0.5, -8 }, at = { 0, 0.5, 0 } }
    assert(near(daft.camera.get().yaw, math.pi / 2), "positive yaw turns right, from +X to +Z")
    daft.camera.set { yaw = 0.5, position = { 1, 2, 3 } }
    assert(near(daft.camera.get().yaw, 0.5) and near(daft.camera.get().fov, 1.2))
    expect_error("cannot look at the place", daft.camera.look, { from = { 1, 1, 1 }, at = { 1, 1, 1 } })
    expect_error("fov", daft.camera.set, { fov = 4 })
    daft.camera.look { from = { -8, 4, 0 }, at = ball, teleport = true }
end

local function materials()
    local m = daft.material { color = "#808080" }
    m:set { mirror = 0.5 }
    local e = daft.entity { sphere = 1, material = m, position = { 50, 0, 0 } }
    e:material(m)
    e:material("checker")
    expect_error("there is no texture 'cheker': did you mean 'checker'?", e.material, e, "cheker")
    for _, use in ipairs { "ambient", "specular", "emission", "shininess", "roughness", "metallic", "normal", "bump", "alpha",
        "occlusion", "reflection" } do
        e:material { [use .. "_texture"] = "checker", occlusion_strength = 0.5 }
        expect_error("there is no texture 'cheker'", e.material, e, { [use .. "_texture"] = "cheker" })
    end
    expect_error("mirror is 2; it must be between 0 and 1", daft.material, { mirror = 2 })
    expect_error("transmission is 2; it must be between 0 and 1", daft.material, { transmission = 2 })
    expect_error("refractive_index is 0; it must be between 0.001 and 10", daft.material, { refractive_index = 0 })
    expect_error("transmission_tint.x is 2; it must be between 0 and 1", daft.material, { transmission_tint = { 2, 0, 0 } })
    expect_error("\"#rgb\", \"#rrggbb\" or {r, g, b} expected, got the string '#12345'", daft.material, { color = "#12345" })
    local mesh = daft.mesh { positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } },
        uvs = { { 0, 0 }, { 1, 0 }, { 0, 1 } } }
    local low, high = mesh:bounds()
    assert(low[1] == 0 and high[2] == 1)
    daft.entity { mesh = mesh, position = { 0, 0, 30 } }
    expect_error("triangles[1]: a position from 1 to 3 expected, got 4", daft.mesh,
        { positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 4 } } })
    expect_error("there is no file 'nothing.obj'", daft.entity, { mesh = "nothing.obj" })
end

local function rays()
    local hit = daft.raycast({ 0, 10, 0 }, { 0, -1, 0 })
    assert(hit.entity == ball and near(hit.distance, 9, 1e-4) and near(hit.normal[2], 1, 1e-4))
    hit = daft.raycast({ 0, 10, 0 }, { 0, -2, 0 }, 100, ball)
    assert(hit.entity == floor and near(hit.position[2], 0, 1e-4))
    assert(daft.raycast({ 0, 10, 0 }, { 0, -1, 0 }, 5) == nil)
    assert(daft.raycast(ball, { 0, 1, 0 }, 5, ball) == nil)
    expect_error("direction: it has no length", daft.raycast, { 0, 0, 0 }, { 0, 0, 0 })
end

local walker, yard, pillar

local function queries()
    yard = daft.entity { box = { 20, 1, 20 }, position = { 0, -0.5, 60 }, body = "static" }
    pillar = daft.entity { box = { 1, 4, 1 }, position = { 4, 2, 60 }, body = "static", visible = false }
    local hit = daft.query.ray({ 0, 1, 60 }, { 1, 0, 0 }, 100)
    assert(hit.entity == pillar and near(hit.distance, 3.5, 1e-5) and near(hit.normal[1], -1, 1e-5) and not hit.inside)
    assert(daft.query.ray({ 0, 1, 60 }, { 1, 0, 0 }, 100, { ignore = pillar }) == nil)
    assert(daft.query.ray({ 0, 1, 60 }, { 1, 0, 0 }, 3) == nil)
    local all = daft.query.all({ 4, 9, 60 }, { 0, -1, 0 })
    assert(#all == 2 and all[1].entity == pillar and all[2].entity == yard)
    hit = daft.query.cast({ sphere = 0.5 }, { 0, 1, 60 }, { 1, 0, 0 })
    assert(hit.entity == pillar and near(hit.distance, 3, 1e-3))
    assert(daft.query.cast({ box = { 1, 1, 1 } }, { 0, 1, 60 }, { 1, 0, 0 }, 10, { static = false }) == nil)
    assert(#daft.query.overlap({ capsule = { 0.3, 1.8 } }, { 4, 0.5, 60 }) == 2)
    hit = daft.query.closest({ 0, 1, 60 }, 5)
    assert(hit.entity == yard and near(hit.distance, 1, 1e-5))
    expect_error("shape: one of sphere, box and capsule expected", daft.query.overlap, {}, { 0, 0, 0 })
    expect_error("sphere: radius above 0 expected", daft.query.overlap, { sphere = -1 }, { 0, 0, 0 })
    walker = daft.character { position = { 0, 0.95, 60 }, step = 0.3 }
    walker:walk(3, 0)
    assert(walker:valid() and near(walker:height(), 1.8, 1e-5))
    expect_error("radius", daft.character, { radius = -1 })
end

local gate, hammer, puck, wheel, saved
local begun, entered = {}, 0

local function bodies()
    daft.entity { box = { 20, 1, 20 }, position = { 0, -0.5, 120 }, body = "static", surface = "stone", layer = "world" }
    daft.surfaces("stone", "ice", { friction = 0 })
    hammer = daft.entity { position = { 0, 3, 120 }, body = "dynamic", mass = 5, layer = "tools", hits = { "world" }, lock = { "x", "z" },
        collider = { { capsule = { radius = 0.1, height = 1 } }, { box = { 0.4, 0.2, 0.2 }, position = { 0, 0.5, 0 } } } }
    assert(near(hammer:mass(), 5, 1e-4) and hammer:awake())
    puck = daft.entity { sphere = 0.2, position = { -4, 2, 120 }, body = "dynamic", lock = { "position y", "position z", "rotation" }, velocity = { 1, 5, 5 } }
    wheel = daft.entity { position = { 0, 0.3, 126 }, body = "dynamic", collider = { cylinder = { radius = 0.3, height = 0.1 } },
        rotation = { 0.7071067811865476, 0, 0, 0.7071067811865476 }, velocity = { 2, 0, 0 }, angular_velocity = { 0, 0, -2 / 0.3 } }
    expect_error("cylinder's radius", daft.entity, { body = "dynamic", collider = { cylinder = { radius = -1, height = 1 } } })
    expect_error("lock: \"x\", \"y\"", daft.entity, { sphere = 1, body = "dynamic", lock = "position w" })
    local leaf = daft.entity { box = { 1, 2, 0.1 }, position = { 5, 1.2, 120 }, body = "dynamic", surface = "ice" }
    gate = daft.joint { kind = "hinge", b = leaf, at = { 4.5, 1.2, 120 }, axis = { 0, 1, 0 }, motor = { speed = 1, force = 500 } }
    assert(gate:valid() and near(gate:value(), 0))
    daft.entity { box = { 2, 2, 2 }, position = { 0, 1, 120 }, body = "static", sensor = true, layer = "world", name = "sensor", visible = false }
    daft.entity { position = { 10, 0, 120 }, body = "static",
        collider = { heights = { 0, 0, 0, 0, 1, 0, 0, 0, false }, columns = 3, spacing = 2 } }
    assert(daft.query.ray({ 0, 3, 120 }, { 0, 1, 0 }, 1, { hits = "world" }) == nil)
    expect_error("one of sphere, box, capsule, cylinder, hull, mesh and heights", daft.entity, { body = "static", collider = {} })
    expect_error("columns: 4 heights do not make rows of 3", daft.entity, { body = "static", collider = { heights = { 1, 2, 3, 4 }, columns = 3 } })
    expect_error("which has no mass", daft.entity, { mesh = "rock.obj", body = "dynamic", collider = "mesh" })
    expect_error("kind: \"ball\", \"hinge\"", daft.joint, { kind = "hinj", b = leaf })
    expect_error("substeps", daft.physics, { substeps = 99 })
    expect_error("not a saved state", daft.load_bodies, "nonsense")
end

local function bodies_later(tick)
    for _, event in ipairs(daft.events()) do
        if event.kind == "begin" and event.b == hammer then begun[#begun + 1] = event.speed end
        if event.kind == "enter" and event.a.name == "sensor" and event.b == hammer then entered = entered + 1 end
    end
    if tick == 30 then
        local wx, wy = wheel:position()
        assert(near(wx, 1, 0.1) and near(wy, 0.3, 0.005), "a cylinder rolls")
        local x, y, z = puck:position()
        assert(near(x, -3.5, 0.1) and y == 2 and z == 120, "locked to a line along x")
        local angle, speed = gate:value()
        assert(near(speed, 1, 0.05) and near(angle, 0.433, 0.01), "67 kg m² come to 1 rad/s by 500 N m in 0.133 s")
        gate:motor() gate:limit(-1, 1) gate:spring(2, 0.5)
        saved = daft.save_bodies()
    elseif tick == 55 then
        assert(#begun >= 1 and begun[1] > 3 and entered == 2 and daft.physics().bodies >= 8)
        daft.load_bodies(saved)
        assert(near(gate:value(), 0.433, 0.01))
        gate:destroy()
        assert(not gate:valid())
        expect_error("stale", gate.value, gate)
    end
end

local font, brick

local function messages()
    expect_error("daft.entity: position: {x, y, z} expected, got a table without that", function() daft.entity { sphere = 1, position = { nil } } end)
    expect_error("position: {x, y, z} expected, got nil", ball.position, ball, nil)
    expect_error("position: {x, y, z} expected, got a list with string in place 2", ball.position, ball, { 1, "2", 3 })
    expect_error("position: {x, y, z} expected, got a list of 2", ball.position, ball, { 1, 2 })
    expect_error("daft.entity: there is no 'spere': did you mean 'sphere'?", function() daft.entity { spere = 1 } end)
    expect_error("sphere is -1; it must be finite and above 0", daft.entity, { sphere = -1 })
    expect_error("only one of mesh, sphere and box", daft.entity, { sphere = 1, box = { 1, 1, 1 } })
    expect_error("body: \"none\", \"static\", \"kinematic\" or \"dynamic\" expected, got the string 'dynamc'", daft.entity,
        { sphere = 1, body = "dynamc" })
    expect_error("there is no key 'lefft': did you mean 'left'?", daft.input.down, "lefft")
    expect_error("daft has no 'entiti': did you mean 'entity'?", function() return daft.entiti end)
    expect_error("daft.light has no 'son': did you mean 'sun'?", function() return daft.light.son end)
    expect_error("daft calls no function 'updat': did you mean 'update'?", function() daft.updat = print end)
    expect_error("entity has no 'postion': did you mean 'position'?", function() return ball.postion end)
    expect_error("cannot be set", function() ball.speed = 3 end)
    expect_error("entity expected before the colon, got nothing", ball.push)
    expect_error("only within daft.draw", daft.text, "hello", 1, 1)
    expect_error("text: 16384 bytes at most expected, got 16385", daft.text_width, ("x"):rep(16385))
    expect_error("finite number expected", daft.entity, { sphere = 0 / 0 })
end

function daft.load()
    entities() animation() scenery() rotations() lights() cameras() materials() rays() queries() bodies() messages()
    assert(daft.tick() == 0 and daft.time() == 0)
    assert(daft.height() == 720 and daft.width() > 300)
    font = daft.font("fonts/daft.ttf")
    assert(daft.text_width("Ωж", 40, font) == daft.text_width("Ωж", 40) and tostring(font) == "font 1")
    assert(daft.text_height("one two", 1000, 20) * 2 == daft.text_height("one two", daft.text_width("one ", 20), 20, font))
    brick = daft.image("textures/brick.png")
    local wide, tall = brick:size()
    assert(wide == tall and wide >= 64 and tostring(brick) == "image 1")
    expect_error("there is no file 'no.png'", daft.image, "no.png")
    expect_error("main.lua", daft.image, "main.lua")
    expect_error("only within daft.draw", brick.draw, brick, 1, 1)
    expect_error("there is no file 'no.ttf'", daft.font, "no.ttf")
    expect_error("not a TrueType font", daft.font, "textures/brick.png")
    expect_error("font: font expected, got the number 5", daft.text_width, "x", 20, 5)
    expect_error("width: number above 0 expected", daft.text_height, "x", 0)
    assert(daft.text_width("iii") < daft.text_width("mmm") and daft.text_width("a\nbb", 10) == daft.text_width("bb", 10))
    daft.gravity(0, -9.81, 0)
    daft.input.set("space", true)
end

local pressed_in, released_in, key_seen
function daft.keypressed(key) key_seen = key end
function daft.keyreleased(key) released_in = key end

function daft.update(dt)
    assert(near(dt, 1 / 60))
    local tick = daft.tick()
    bodies_later(tick)
    if tick == 0 then
        assert(daft.input.pressed("space") and daft.input.down("space") and key_seen == "space")
        assert(daft.input.axis("left", "space") == 1 and daft.input.axis("space", "left") == -1)
        daft.input.set("space", false)
    elseif tick == 1 then
        assert(daft.input.released("space") and not daft.input.down("space") and released_in == "space")
    end
    local x, y = daft.input.mouse()
    assert(x == 0 and y == 0 and not daft.input.mouse.down(1) and daft.input.mouse.wheel() == 0)
    assert(daft.input.mouse.motion() == 0)
    daft.input.mouse.grab(tick < 10)
    if tick == 20 then
        local wx, _, wz = walker:position()
        local ground, how = walker:ground()
        assert(wx > 0.5 and near(wz, 60, 1e-6) and ground == yard and how == "ground")
        assert(near(walker:velocity(), 3, 1e-3) and walker:turn() == 0)
        walker:jump(4)
    elseif tick == 21 then
        assert(select(2, walker:ground()) == "air")
        assert(walker:height(1.2) and near(walker:height(), 1.2, 1e-5))
        walker:position(0, 3, 60)
        walker:destroy()
        assert(not walker:valid())
    end
    if tick == 19 then
        local eye = daft.picture { width = 40, height = 30 }
        expect_error("nothing is drawn yet: call picture:draw first", eye.depth, eye, 0, 0)
        expect_error("width: whole number of pixels expected, got nil", daft.picture, { height = 30 })
        expect_error("width: 1 to 4096 pixels expected, got 0", daft.picture, { width = 0, height = 30 })
        expect_error("are too many: 1048576 at most", daft.picture, { width = 4096, height = 4096 })
        expect_error("did you mean 'pitch'", eye.draw, eye, { pich = 1 })
        eye:draw { position = { 0, 50, 0 }, pitch = math.pi / 2 }
        expect_error("pixel (40, 0) is outside: 0 to 39, 0 to 29", eye.entity, eye, 40, 0)
        expect_error("picture expected before the colon, got entity", eye.entity, ball, 0, 0)
        local width, height = eye:size()
        assert(width == 40 and height == 30 and eye ~= daft.picture { width = 1, height = 1 })
        assert(eye:cost(0, 0) >= 1 and eye:triangle(20, 15) >= 0 and eye:albedo(20, 15) >= 0 and eye:color(20, 15) >= 0)
        local x, y, z = eye:normal(20, 15)
        assert(eye:entity(20, 15) == nil or near(x * x + y * y + z * z, 1, 1e-4))
        assert(eye:motion(20, 15) == 0)
        assert(tostring(eye) == "picture 1")
    end
    if tick == 20 then
        local list = ball:contacts()
        assert(#list == 1 and list[1].other == floor and near(list[1].normal[2], 1, 1e-3) and list[1].impulse > 0)
        assert(list[1].other.name == "floor")
        ball:impulse(4, 0, 0)
    elseif tick == 21 then
        assert(near(ball:velocity(), 2, 0.2), "an impulse of 4 on 2 kg is 2 m/s, less what friction takes")
        ball:velocity { 0, 0, 0 }
        ball:angular_velocity(0, 0, 0)
        ball:push(0, 40, 0)
    elseif tick == 22 then
        assert(near(select(2, ball:velocity()), (40 / 2 - 9.81) / 60, 0.02), "a force acts over one step")
    end
end

function daft.draw()
    drawn = drawn + 1
    daft.text("score 12 äöü", 16, 16)
    daft.text("right", daft.width(), 40, { size = 40, color = "#ff0000", align = "right", shadow = false })
    daft.text(12, 16, 200)
    daft.text("some words in a font of the game's, that are broken", 16, 240, { font = font, width = 100, size = 20 })
    expect_error("not within daft.draw", daft.font, "fonts/daft.ttf")
    daft.rect(10, 10, 100, 20, "#00ff0080")
    daft.rect(-1e9, -1e9, 2e9, 10)
    daft.rect(10, 40, 100, 20, { width = 2, color = "#00ff00" })
    daft.line(0, 0, 100, 100)
    daft.line({ 0, 0, 100, 100, 50, 20 }, { closed = true, width = 5, color = { 1, 0, 0 } })
    daft.circle(50, 50, 20, { r = 1, g = 0, b = 0 })
    daft.polygon({ 0, 0, 50, 0, 0, 50 }, "#ffffff80")
    brick:draw(300, 300, { rotation = 1, origin = { 0.5, 0.5 }, scale = 0.5, color = "#ff8080" })
    brick:draw(400, 300, { source = { 0, 0, 30, 30 }, width = 200, height = 50, border = 10, smooth = false })
    expect_error("source: x, y, width and height within the image's", brick.draw, brick, 0, 0, { source = { 0, 0, 30, 3000 } })
    expect_error("style: there is no 'rotatio': did you mean 'rotation'?", brick.draw, brick, 0, 0, { rotatio = 1 })
    expect_error("points: 3 to 1024 of two numbers each expected, got 4 numbers", daft.polygon, { 1, 2, 3, 4 })
    expect_error("points: number expected, got boolean", daft.line, { 1, 2, 3, true })
    daft.clip(0, 0, 10, 10)
    daft.clip()
    local left, top, scale = daft.canvas(100, 100)
    assert(math.abs(scale - 7.2) < 1e-3 and math.abs(left - (daft.width() - 720) / 2) < 0.01 and top == 0)
    expect_error("a width and a height of 1 to 100000 expected", daft.canvas, 0, 5)
    left, top, scale = daft.canvas()
    assert(left == 0 and top == 0 and scale == 1)
    expect_error("not within daft.draw", daft.image, "textures/brick.png")
    expect_error("not within daft.draw", ball.push, ball, 1, 0, 0)
    expect_error("not within daft.draw", ball.position, ball, 1, 0, 0)
    expect_error("not within daft.draw", daft.entity, { sphere = 1 })
    assert(type(ball:position()) == "number")
end
