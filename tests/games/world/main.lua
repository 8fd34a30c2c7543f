-- World: axes, parents, tags, points of the screen, entities of scene files. An assertion that fails is the game's error.

local near = function(a, b, tolerance) return math.abs(a - b) <= (tolerance or 1e-5) end
local function is(x, y, z, a, b, c) return near(x, a) and near(y, b) and near(z, c) end
local function at(e, a, b, c)
    local x, y, z = e:world_position()
    return is(x, y, z, a, b, c)
end
local function expect_error(pattern, f, ...)
    local good, message = pcall(f, ...)
    assert(not good, "no error where one was due: " .. pattern)
    assert(message:find(pattern, 1, true), ("'%s' is not in '%s'"):format(pattern, message))
end
local function axis(f, e, a, b, c)
    local x, y, z = f(e)
    return is(x, y, z, a, b, c)
end

local function axes()
    local e = daft.entity { box = { 1, 1, 1 }, position = { 1, 2, 3 } }
    assert(axis(e.forward, e, 1, 0, 0) and axis(e.up, e, 0, 1, 0) and axis(e.right, e, 0, 0, 1))
    e:rotation(math.pi / 2, 0, 0)
    assert(axis(e.forward, e, 0, 0, 1) and axis(e.up, e, 0, 1, 0) and axis(e.right, e, -1, 0, 0), "yaw turns to the right")
    e:look_at { 1, 2, -7 }
    assert(axis(e.forward, e, 0, 0, -1) and axis(e.up, e, 0, 1, 0))
    e:look_at(1, 9, 3)
    assert(axis(e.forward, e, 0, 1, 0), "straight up")
    expect_error("cannot look at the place", e.look_at, e, e)

    -- Within a parent that is moved, turned and scaled, all of it means the world.
    local cart = daft.entity { position = { 10, 0, 0 }, rotation = { math.pi / 2, 0, 0 }, scale = 2 }
    local gun = daft.entity { box = { 1, 1, 1 }, parent = cart, position = { 1, 0, 0 } }
    assert(at(gun, 10, 0, 2) and axis(gun.forward, gun, 0, 0, 1))
    gun:look_at { 20, 0, 2 }
    assert(axis(gun.forward, gun, 1, 0, 0) and at(gun, 10, 0, 2))
    gun:world_position(0, 1, 0)
    assert(at(gun, 0, 1, 0) and axis(gun.forward, gun, 1, 0, 0))
    local x, y, z = gun:position()
    assert(is(x, y, z, 0, 0.5, 5))
    cart:destroy()
    expect_error("stale", gun.forward, gun)
    e:destroy()
end

local function families()
    local cart = daft.entity { position = { 10, 0, 0 }, rotation = { math.pi / 2, 0, 0 }, scale = 2 }
    local box = daft.entity { box = { 1, 1, 1 }, position = { 1, 2, 3 }, rotation = { 0.3, 0.2, 0.1 }, scale = { 1, 2, 3 } }
    local fx, fy, fz = box:forward()
    assert(box:parent() == nil and #cart:children() == 0)
    box:parent(cart)
    assert(box:parent() == cart and cart:children()[1] == box)
    assert(at(box, 1, 2, 3) and axis(box.forward, box, fx, fy, fz), "it stays where and as it is")
    cart:position(11, 0, 0)
    assert(at(box, 2, 2, 3), "and goes with its parent")
    box:parent(nil)
    assert(at(box, 2, 2, 3) and axis(box.forward, box, fx, fy, fz) and box:parent() == nil and #cart:children() == 0)
    local sx, sy, sz = box:scale()
    assert(is(sx, sy, sz, 1, 2, 3))
    expect_error("cannot hang on itself", cart.parent, cart, cart)
    local first = daft.entity { parent = cart }
    local second = daft.entity { parent = cart }
    local third = daft.entity {}
    third:parent(cart)
    local list = cart:children()
    assert(#list == 3 and list[1] == first and list[2] == second and list[3] == third)
    expect_error("cannot hang on itself or its children", cart.parent, cart, third)
    local body = daft.entity { sphere = 1, body = "dynamic", position = { 0, 90, 0 } }
    expect_error("a body has no parent", body.parent, body, cart)
    expect_error("entity expected, got the number 3", third.parent, third, 3)
    local flat = daft.entity { scale = { 1, 0, 1 } }
    expect_error("scale is 0", third.parent, third, flat)
    local stretched = daft.entity { scale = { 1, 2, 1 } }
    local round = daft.entity { sphere = 1 }
    expect_error("above a sphere it must be equal", round.parent, round, stretched)
    local mirror = daft.entity { scale = -1, position = { 1, 1, 1 } }
    round:parent(mirror)
    assert(at(round, 0, 0, 0))
    for _, e in ipairs { cart, box, body, flat, stretched, mirror } do e:destroy() end
    assert(not first:valid() and not round:valid(), "children go with their parents")
end

local function same(list, ...)
    local wanted = { ... }
    if #list ~= #wanted then return false end
    for i, e in ipairs(wanted) do if list[i] ~= e then return false end end
    return true
end

local function tags()
    local a = daft.entity { name = "a", tags = { "enemy", "flies" } }
    local b = daft.entity { name = "b", tags = "enemy" }
    local c = daft.entity {}
    assert(same(daft.find { tag = "enemy" }, a, b) and same(daft.find { tag = { "flies", "enemy" } }, a))
    assert(same(daft.find { tag = "nobody" }) and same(daft.find { name = "b" }, b))
    assert(same(daft.find { name = "b", tag = "flies" }) and same(daft.find { name = "a", tag = "flies" }, a))
    c:tag("enemy", "swims", "enemy")
    c.name = "a"
    assert(c:has_tag("swims") and not c:has_tag("flies") and table.concat(c:tags(), " ") == "enemy swims")
    assert(same(daft.find { tag = "enemy" }, a, b, c) and same(daft.find { name = "a" }, a, c))
    a:untag("enemy", "walks")
    assert(same(daft.find { tag = "enemy" }, b, c) and table.concat(a:tags(), " ") == "flies")
    a:tag("enemy")
    a.name = "z"
    assert(same(daft.find { tag = "enemy" }, b, c, a) and same(daft.find { name = "a" }, c) and a.name == "z")
    local list = { 1, 2, 3, 4, 5 }
    assert(daft.find({ tag = "enemy" }, list) == list and same(list, b, c, a), "a list can be used again")
    b:destroy()
    assert(same(daft.find { tag = "enemy" }, c, a))
    expect_error("stale", b.tag, b, "x")
    expect_error("tag or name expected", daft.find, {})
    expect_error("did you mean 'tag'", daft.find, { tags = "enemy" })
    expect_error("tag: name expected, got nothing", c.tag, c)
    expect_error("tags: name or list of names expected, got the number 3", daft.entity, { tags = 3 })
    expect_error("tag: 1 to 200 bytes expected, got 0", c.tag, c, "")
    local many = {}
    for i = 1, 65 do many[i] = "t" .. i end
    expect_error("at most 64", daft.entity, { tags = many })
    a:destroy() c:destroy()
    for i = 1, 3000 do daft.entity { name = "n" .. i, tags = "brief" }:destroy() end
    assert(same(daft.find { tag = "brief" }) and same(daft.find { name = "n2999" }))
end

local function screen()
    local wall = daft.entity { box = { 0.1, 8, 8 }, position = { 5, 0, 0 }, name = "wall" }
    daft.camera.set { position = { 0, 0, 0 }, yaw = 0, pitch = 0, fov = math.pi / 2, teleport = true }
    local from, ray = daft.screen_ray(daft.width() / 2, 360)
    assert(is(from[1], from[2], from[3], 0, 0, 0) and is(ray[1], ray[2], ray[3], 1, 0, 0))
    local _, edge = daft.screen_ray(daft.width(), 360)
    assert(is(edge[1], edge[2], edge[3], math.sqrt(0.5), 0, math.sqrt(0.5)), "the right edge is 45 degrees to the right")
    local _, top = daft.screen_ray(daft.width() / 2, 0)
    assert(top[2] > 0.4 and near(top[3], 0))
    local hit = daft.pick(daft.width() / 2, 360)
    assert(hit.entity == wall and near(hit.distance, 4.95, 1e-4))
    assert(daft.pick(daft.width() / 2, 360, 2) == nil and daft.pick(daft.width() / 2, 360, 100, wall) == nil)
    local _, corner = daft.screen_ray()
    assert(corner[2] > 0 and corner[3] < 0, "the mouse is in the upper left corner")
    wall:destroy()
end

local function scenes()
    local found = daft.scene("named.scene")
    local names = {}
    for name in pairs(found) do names[#names + 1] = name end
    assert(table.concat(names, " ") == "ball floor")
    assert(at(found.ball, 0, 0, 0) and found.ball.name == "ball" and found.floor.name == "floor")
    local balls = daft.find { name = "ball" }
    assert(#balls == 2 and balls[1] == found.ball and at(balls[2], 3, 0, 0))
    assert(daft.scene("named.scene").ball ~= found.ball, "each time others")
end

local function meshes()
    local corners = { { -1, 0, 1 }, { 1, 0, 1 }, { 1, 0, -1 }, { -1, 0, -1 } }
    local mesh = daft.mesh { positions = corners, triangles = { { 1, 2, 3 }, { 1, 3, 4 } } }
    local e = daft.entity { mesh = mesh, position = { 40, 0, 0 } }
    assert(near(daft.raycast({ 40, 5, 0 }, { 0, -1, 0 }).distance, 5))
    for _, corner in ipairs(corners) do corner[2] = 2 end
    mesh:set { positions = corners }
    local hit = daft.raycast({ 40, 5, 0 }, { 0, -1, 0 })
    assert(near(hit.distance, 3) and near(hit.normal[2], 1))
    mesh:set { positions = { -1, 1, 1, 1, 1, 1, 1, 1, -1, -1, 1, -1 }, normals = { 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0 } }
    assert(near(daft.raycast({ 40, 5, 0 }, { 0, -1, 0 }).distance, 4))
    expect_error("3 positions for a mesh of 4 vertices", mesh.set, mesh, { positions = { 1, 2, 3, 4, 5, 6, 7, 8, 9 } })
    expect_error("10 numbers are not so many times 3", mesh.set, mesh, { positions = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 } })
    expect_error("positions[2]: number expected", mesh.set, mesh, { positions = { 1, "2", 3, 4, 5, 6, 7, 8, 9, 1, 2, 3 } })
    expect_error("positions[5]: finite number expected", mesh.set, mesh, { positions = { 1, 2, 3, 4, 0 / 0, 6, 7, 8, 9, 1, 2, 3 } })
    expect_error("did you mean 'positions'", mesh.set, mesh, { position = corners })
    expect_error("positions: a list", mesh.set, mesh, {})
    expect_error("as many normals", mesh.set, mesh, { positions = corners, normals = { 0, 1, 0 } })
    local floor = daft.entity { mesh = mesh, body = "static", position = { 60, 0, 0 } }
    expect_error("what a body is made of", mesh.set, mesh, { positions = corners })
    floor:destroy() e:destroy()
end

local sparks, smoke, carrier
local function particles()
    carrier = daft.entity { position = { 0, 0, 80 } }
    sparks = daft.particles { count = 500, life = { 0.05, 0.1 }, speed = { 1, 2 }, spread = math.pi, area = 0.5, drag = 1,
        gravity = { 0, -9.81, 0 }, size = { 0.1, 0 }, shape = "quad", position = { 0, 0, 70 }, seed = 3 }
    smoke = daft.particles { count = 100, rate = 120, life = 0.5, position = carrier, material = "checker" }
    assert(sparks:count() == 0 and sparks:valid() and tostring(sparks):find("particles") and smoke:rate() == 120)
    sparks:burst(200)
    sparks:burst(400, { 1, 2, 70 })
    assert(sparks:count() == 500, "as far as there is room")
    sparks:clear()
    sparks:burst(7, carrier)
    assert(sparks:count() == 7)
    sparks:direction(0, 0, 2)
    expect_error("direction: it has no length", sparks.direction, sparks, 0, 0, 0)
    expect_error("count is 0; it must be between 1 and 50000", daft.particles, { count = 0 })
    expect_error("did you mean 'speed'", daft.particles, { sped = 1 })
    expect_error("life: number or {from, to} expected", daft.particles, { life = "long" })
    expect_error("life: 0.001 to 10000 expected, got 0", daft.particles, { life = 0 })
    expect_error("shape: \"round\" or \"quad\" expected", daft.particles, { shape = "star" })
    expect_error("count: 0 or more", sparks.burst, sparks, -1)
    expect_error("there is no texture", daft.particles, { material = "nothing" })
    assert(daft.raycast({ 0, 0, 60 }, { 0, 0, 1 }, 100) == nil, "rays pass through particles")
end

function daft.update()
    local tick = daft.tick()
    if tick == 3 then assert(smoke:count() == 6 and sparks:count() == 7, smoke:count()) end
    if tick == 9 then
        assert(sparks:count() == 0, "their life is over")
        assert(smoke:count() == 18)
        carrier:destroy()
        sparks:destroy()
        assert(not sparks:valid())
        expect_error("have been destroyed", sparks.burst, sparks, 1)
    end
    if tick == 11 then assert(smoke:count() == 18 and smoke:rate() == 0, "what carried them is gone") end
end

function daft.load() axes() families() tags() screen() scenes() meshes() particles() end
