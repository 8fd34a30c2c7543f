-- Ribbons that what moves draws behind it: light trails, skid marks, the wake of a boat.
--
--     local trail = require "trail"
--     local wake = trail.new { target = ball, width = 0.3, seconds = 0.5, material = { emission = "#ffb040" } }
--     function daft.update(dt) wake:update(dt) end
--
-- The ribbon narrows towards its end. It lies across `up`, or, where up is "camera", faces the camera.

local trail = {}

local Trail = {}
Trail.__index = Trail

local OPTIONS = { target = true, width = true, seconds = true, pieces = true, material = true, up = true, offset = true }

local function number(o, name, usual, low)
    local value = o[name]
    if value == nil then return usual end
    if type(value) ~= "number" or not (value >= low and value < math.huge) then
        error(("trail.new: %s: number of %g or more expected, got %s"):format(name, low, tostring(value)), 3)
    end
    return value
end

local function place(target)
    if type(target) == "userdata" then return target:world_position() end
    return target[1], target[2], target[3]
end

-- target: an entity or {x, y, z}, which may change; offset: {x, y, z} from it. width (0.2) in metres where it begins;
-- seconds (0.5): how old its end is; pieces (24): of which it is made; up ({0, 1, 0}).
function trail.new(o)
    if type(o) ~= "table" then error("trail.new: table expected, got " .. type(o), 2) end
    for key in pairs(o) do
        if not OPTIONS[key] then error(("trail.new: there is no option '%s'"):format(tostring(key)), 2) end
    end
    if o.target == nil then error("trail.new: target = an entity or {x, y, z} expected", 2) end
    local self = setmetatable({ target = o.target, width = number(o, "width", 0.2, 0), seconds = number(o, "seconds", 0.5, 1 / 60),
        pieces = number(o, "pieces", 24, 1), up = o.up or { 0, 1, 0 }, offset = o.offset or { 0, 0, 0 }, age = 0 }, Trail)
    self.pieces = math.min(1000, math.floor(self.pieces))
    local x, y, z = place(self.target)
    self.x, self.y, self.z = x, y, z -- what the mesh's numbers are relative to
    local positions, triangles = {}, {}
    for i = 0, self.pieces do
        for side = 0, 1 do
            local at = #positions
            positions[at + 1], positions[at + 2], positions[at + 3] = i * 0.01, side * 0.01, 0
        end
        local a = 2 * i - 1
        if i > 0 then triangles[2 * i - 1], triangles[2 * i] = { a, a + 2, a + 3 }, { a, a + 3, a + 1 } end
    end
    self.positions = positions
    self.mesh = daft.mesh { positions = positions, triangles = triangles }
    self.entity = daft.entity { mesh = self.mesh, position = { x, y, z }, material = o.material or "#ffffff", casts_shadow = false,
        visible = false }
    self:clear()
    return self
end

-- Begins again where the target is, as after a teleport.
function Trail:clear()
    local x, y, z = place(self.target)
    local ox, oy, oz = self.offset[1], self.offset[2], self.offset[3]
    self.path = {}
    for i = 1, self.pieces + 1 do self.path[i] = { x + ox, y + oy, z + oz } end
    self.entity:visible(false)
end

-- The unit vector across the ribbon at a point: of its direction and of up, or of the way to the camera.
local function across(dx, dy, dz, ux, uy, uz)
    local x, y, z = dy * uz - dz * uy, dz * ux - dx * uz, dx * uy - dy * ux
    local length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-9 then return 0, 0, 0 end
    return x / length, y / length, z / length
end

-- Call it once a tick.
function Trail:update(dt)
    local path, count = self.path, self.pieces + 1
    local x, y, z = place(self.target)
    x, y, z = x + self.offset[1], y + self.offset[2], z + self.offset[3]
    local head = path[1]
    head[1], head[2], head[3] = x, y, z
    self.age = self.age + dt
    if self.age >= self.seconds / self.pieces then -- the head's point stays behind; the last one becomes the new head
        self.age = self.age % (self.seconds / self.pieces)
        local last = table.remove(path)
        last[1], last[2], last[3] = x, y, z
        table.insert(path, 1, last)
    end
    local camera = self.up == "camera" and daft.camera.get().position
    local ux, uy, uz = 0, 1, 0
    if not camera then ux, uy, uz = self.up[1], self.up[2], self.up[3] end
    local out, moved = self.positions, false
    for i = 1, count do
        local p, a, b = path[i], path[math.max(1, i - 1)], path[math.min(count, i + 1)]
        if camera then ux, uy, uz = camera[1] - p[1], camera[2] - p[2], camera[3] - p[3] end
        local sx, sy, sz = across(a[1] - b[1], a[2] - b[2], a[3] - b[3], ux, uy, uz)
        local half = 0.5 * self.width * (1 - (i - 1) / self.pieces)
        moved = moved or sx ~= 0 or sy ~= 0 or sz ~= 0
        local at, px, py, pz = 6 * (i - 1), p[1] - self.x, p[2] - self.y, p[3] - self.z
        out[at + 1], out[at + 2], out[at + 3] = px - sx * half, py - sy * half, pz - sz * half
        out[at + 4], out[at + 5], out[at + 6] = px + sx * half, py + sy * half, pz + sz * half
    end
    self.entity:visible(moved)
    if moved then self.mesh:set { positions = out } end
end

function Trail:destroy() self.entity:destroy() end

return trail
