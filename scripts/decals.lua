-- Flat pictures on surfaces: bullet holes, splashes, footprints. The oldest make room for new ones.
--
--     local decals = require "decals"
--     local marks = decals.new { most = 100, size = 0.4, material = "target" }
--     local hit = daft.pick()
--     if hit then marks:place(hit) end

local decals = {}

local Decals = {}
Decals.__index = Decals

local OPTIONS = { most = true, size = true, material = true, lift = true }

-- most (64): so many at once; size (0.3): edge length in metres; lift (0.004): metres above the surface.
function decals.new(o)
    o = o or {}
    for key in pairs(o) do
        if not OPTIONS[key] then error(("decals.new: there is no option '%s'"):format(tostring(key)), 2) end
    end
    local most, size, lift = o.most or 64, o.size or 0.3, o.lift or 0.004
    if math.type(most) ~= "integer" or most < 1 then error("decals.new: most: a whole number above 0 expected", 2) end
    if type(size) ~= "number" or not (size > 0) then error("decals.new: size: number above 0 expected", 2) end
    if type(lift) ~= "number" or not (lift >= 0) then error("decals.new: lift: number of 0 or more expected", 2) end
    return setmetatable({ most = most, size = size, lift = lift, material = o.material or "#202020", list = {}, next = 1,
        mesh = daft.mesh { positions = { { -0.5, 0, 0.5 }, { 0.5, 0, 0.5 }, { 0.5, 0, -0.5 }, { -0.5, 0, -0.5 } },
            uvs = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } }, triangles = { { 1, 2, 3 }, { 1, 3, 4 } } } }, Decals)
end

-- The rotation that turns up, +Y, to a unit normal, after a turn about +Y: {x, y, z, w}.
local function stand_on(nx, ny, nz, turn)
    local x, z, w = nz, -nx, 1 + ny
    if w < 1e-6 then x, z, w = 1, 0, 0 end -- from below
    local length = math.sqrt(x * x + z * z + w * w)
    x, z, w = x / length, z / length, w / length
    local s, c = math.sin(turn / 2), math.cos(turn / 2)
    return { x * c - z * s, w * s, z * c + x * s, w * c }
end

-- hit: what daft.pick, daft.raycast or daft.query.ray gave, or a contact: a table with position or point, normal, and
-- entity or other, which then carries it. options: size, material, turn (radians about the normal). Gives its entity.
function Decals:place(hit, options)
    options = options or {}
    local at, n = hit.position or hit.point, hit.normal
    if type(at) ~= "table" or type(n) ~= "table" then error("decals: a hit with position and normal expected", 2) end
    local size = options.size or self.size
    local old = self.list[self.next]
    if old and old:valid() then old:destroy() end
    local e = daft.entity { mesh = self.mesh, material = options.material or self.material, casts_shadow = false, scale = { size, 1, size },
        position = { at[1] + n[1] * self.lift, at[2] + n[2] * self.lift, at[3] + n[3] * self.lift },
        rotation = stand_on(n[1], n[2], n[3], options.turn or 0) }
    local carrier = hit.entity or hit.other
    if carrier and carrier:valid() then e:parent(carrier) end
    self.list[self.next] = e
    self.next = self.next % self.most + 1
    return e
end

function Decals:clear()
    for _, e in pairs(self.list) do if e:valid() then e:destroy() end end
    self.list, self.next = {}, 1
end

return decals
