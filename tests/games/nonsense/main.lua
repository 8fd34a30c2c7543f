-- Nonsense: every function of the API with wrong arguments of every kind. Errors are fine, crashes are not.

local NAN, HUGE = 0 / 0, math.huge
local ball = daft.entity { sphere = 1, body = "dynamic" }
local gone = daft.entity { sphere = 1 }
gone:destroy()
local light, paint = daft.light.point { position = { 0, 1, 0 } }, daft.material { color = "#fff" }
local mesh = daft.mesh { positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }
local loop = {}
loop[1], loop.x, loop.parent = loop, loop, loop
local strange = setmetatable({}, { __index = function() error("index") end, __len = function() return 1 << 40 end })

local values = { 0, 1, -1, 1.5, 1e300, -1e300, 1e-300, NAN, HUGE, -HUGE, math.maxinteger, math.mininteger, "", "a", "\0",
    ("x"):rep(100000), "#fff", "#zzz", "../../etc/passwd", "checker", "left", "x.mtl", "x.obj", true, false, print, {},
    { 1, 2, 3 }, { 1, 2, 3, 4 }, { 0, 0, 0 }, { NAN, 0, 0 }, { 1e300, 1, 1 }, { "a", "b", "c" }, { x = 1, y = 2, z = 3 },
    { [1.5] = 2 }, loop, strange, ball, gone, light, paint, mesh, coroutine.create(print), daft }
local fields = { "mesh", "sphere", "box", "position", "rotation", "scale", "material", "parent", "visible", "casts_shadow",
    "body", "density", "mass", "friction", "restitution", "rolling_resistance", "velocity", "angular_velocity", "name", "data",
    "direction", "color", "shadow", "from", "at", "fov", "teleport", "yaw", "pitch", "roll", "texture", "texture_scale", "ambient",
    "specular", "shininess", "mirror", "mirror_tint", "transmission", "transmission_tint",
    "refractive_index", "emission", "size", "align", "positions", "normals", "uvs", "triangles",
    "collider", "lock", "layer", "hits", "sensor", "bullet", "sleeps", "surface", "surface_velocity", "static_friction", "gravity_scale",
    "damping", "angular_damping", "kind", "a", "b", "to", "axis", "limit", "motor", "spring", "length", "break_force",
    "break_torque", "collide", "entity", "radius", "height", "step", "slope", "acceleration", "gravity", "force", "substeps",
    "sleeping" }
local KINDS = { "ball", "hinge", "slider", "distance", "fixed", "drag" }

local functions = {}
local leave_out = { quit = true, restart = true, load = true, update = true, draw = true }
local function collect(path, t)
    for name, value in pairs(t) do
        if not leave_out[name] then
            if type(value) == "function" then functions[#functions + 1] = { path .. "." .. name, value } end
            if type(value) == "table" then collect(path .. "." .. name, value) end
        end
    end
end
collect("daft", daft)
assert(#functions > 30, #functions)
for _, object in ipairs { ball, light, paint, mesh } do
    for _, name in ipairs { "position", "teleport", "rotation", "scale", "material", "visible", "velocity", "angular_velocity",
        "push", "impulse", "contacts", "destroy", "valid", "set", "direction", "color", "shadow", "bounds" } do
        local good, method = pcall(function() return object[name] end)
        if good and name ~= "destroy" then
            functions[#functions + 1] = { name, function(...) return method(object, ...) end }
            functions[#functions + 1] = { name, method }
        end
    end
end

local calls, errors = 0, 0
local function try(f, ...)
    calls = calls + 1
    local good, message = pcall(f, ...)
    if not good then
        errors = errors + 1
        assert(type(message) == "string" and #message < 1200, message)
    end
end

local function assault()
    for _, entry in ipairs(functions) do
        local f = entry[2]
        try(f)
        for i, value in ipairs(values) do
            try(f, value)
            try(f, value, values[(i * 7) % #values + 1])
            try(f, value, 1, { 1, 2, 3 })
            try(f, 0, value, 0)
            try(f, "hello", 1, 1, value)
            try(f, { 1, 2, 3 }, value, value, value)
        end
    end
    for _, field in ipairs(fields) do
        for _, value in ipairs(values) do
            for _, f in ipairs { daft.entity, daft.light.sun, daft.light.point, daft.camera.look, daft.camera.set, daft.material, daft.mesh } do
                try(f, { [field] = value })
                try(f, { [field] = value, sphere = 1, body = "dynamic" })
            end
            try(daft.character, { [field] = value })
            try(daft.physics, { [field] = value })
            for _, kind in ipairs(KINDS) do try(daft.joint, { kind = kind, b = ball, [field] = value }) end
        end
    end
end

-- The world goes on after it.
function daft.update()
    if daft.tick() == 0 then assault() end
    if daft.tick() == 1 then
        daft.gravity(0, -10, 0)
        assert(errors > 1000 and calls > errors)
    end
end

function daft.draw()
    for i, value in ipairs(values) do
        local other = values[(i * 5) % #values + 1]
        try(daft.text, value, other, value, other)
        try(daft.text, "words", other, value)
        try(daft.text, "words", 10, 10, { size = value, color = other, align = value, shadow = other })
        try(daft.text, value, 10, 10)
        try(daft.rect, value, other, value, other, value)
        try(daft.rect, 1, 1, value, value, other)
    end
    daft.text("\xff\xfe\xc3\x28 \xf0\x9f\x98\x80 \xed\xa0\x80", 10, 10)
end
