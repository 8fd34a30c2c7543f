-- Cameras that move by themselves: one follows an entity, one orbits a position, one rides along a path.
--
--     local camera = require "camera"
--     local eye = camera.follow { target = ball, distance = 8, height = 3 }
--     function daft.update(dt) eye:update(dt) end
--
-- A target is an entity or {x, y, z}. Distances are in metres, angles in radians, times in seconds. Smoothing
-- covers 63 % of the remaining way in `smooth` seconds, whatever the length of the step.

local tween = require "tween"

local camera = {}

local function place(target)
    if type(target) == "userdata" then return target:world_position() end
    return target[1], target[2], target[3]
end

-- The fraction of the remaining distance to cover in one tick.
local function fraction(dt, smooth)
    if smooth <= 0 then return 1 end
    return 1 - math.exp(-dt / smooth)
end

local function read(options, defaults, name)
    for key in pairs(options) do
        if defaults[key] == nil and key ~= "target" then
            error(("camera.%s: there is no option '%s'"):format(name, tostring(key)), 3)
        end
    end
    if options.target == nil then error(("camera.%s: target = an entity or {x, y, z} expected"):format(name), 3) end
    local self = { target = options.target }
    for key, value in pairs(defaults) do
        if options[key] ~= nil then self[key] = options[key] else self[key] = value end
    end
    return self
end

local Follow = {}
Follow.__index = Follow

-- Stays `distance` behind the target and `height` above it, and looks at it. Behind is where `yaw` looks from: yaw 0
-- looks along +X, positive yaw turns right. Change self.yaw to turn it.
function camera.follow(options)
    local self = read(options, { distance = 8, height = 4, yaw = 0, smooth = 0.15, fov = math.rad(75) }, "follow")
    return setmetatable(self, Follow)
end

-- Call it once a tick. With jump = true it arrives at once.
function Follow:update(dt, jump)
    local x, y, z = place(self.target)
    local to_x = x - self.distance * math.cos(self.yaw)
    local to_y = y + self.height
    local to_z = z - self.distance * math.sin(self.yaw)
    jump = jump or not self.x
    local k = jump and 1 or fraction(dt, self.smooth)
    self.x = jump and to_x or self.x + (to_x - self.x) * k
    self.y = jump and to_y or self.y + (to_y - self.y) * k
    self.z = jump and to_z or self.z + (to_z - self.z) * k
    daft.camera.look { from = { self.x, self.y, self.z }, at = { x, y, z }, fov = self.fov, teleport = jump }
end

local Orbit = {}
Orbit.__index = Orbit

-- Orbits the target: yaw and pitch are where the camera looks (positive pitch: down from above), distance how
-- far away it is. turn() and zoom() set its goal; it moves there smoothly.
function camera.orbit(options)
    local self = read(options, { distance = 8, yaw = 0, pitch = 0.5, smooth = 0.1, fov = math.rad(75),
                                 nearest = 1, farthest = 1000 }, "orbit")
    self.now_yaw, self.now_pitch, self.now_distance = self.yaw, self.pitch, self.distance
    return setmetatable(self, Orbit)
end

function Orbit:turn(yaw, pitch)
    self.yaw = self.yaw + yaw
    self.pitch = math.max(-1.5, math.min(1.5, self.pitch + pitch))
end

-- A factor: 2 is twice as far.
function Orbit:zoom(factor)
    self.distance = math.max(self.nearest, math.min(self.farthest, self.distance * factor))
end

function Orbit:update(dt, jump)
    local k = (jump or not self.shown) and 1 or fraction(dt, self.smooth)
    self.now_yaw = self.now_yaw + (self.yaw - self.now_yaw) * k
    self.now_pitch = self.now_pitch + (self.pitch - self.now_pitch) * k
    self.now_distance = self.now_distance + (self.distance - self.now_distance) * k
    local x, y, z = place(self.target)
    local flat = self.now_distance * math.cos(self.now_pitch)
    daft.camera.look {
        from = { x - flat * math.cos(self.now_yaw), y + self.now_distance * math.sin(self.now_pitch),
                 z - flat * math.sin(self.now_yaw) },
        at = { x, y, z }, fov = self.fov, teleport = jump or not self.shown,
    }
    self.shown = true
end

local Path = {}
Path.__index = Path

local PATH = { points = true, curve = true, pace = true, seconds = true, ease = true, at = true, fov = true, loop = true }
local CURVES = { smooth = true, bezier = true }

local function number(value, what)
    if type(value) ~= "number" or value ~= value then error(("camera.path: %s: number expected, got %s"):format(what, type(value)), 4) end
    return value
end

-- Checkpoints with all their fields: those that look at a place get the angles of that.
local function checkpoints(o)
    local points = {}
    for i, p in ipairs(o.points) do
        local what = ("points[%d]"):format(i)
        if type(p) ~= "table" then error(("camera.path: %s: table expected, got %s"):format(what, type(p)), 4) end
        local position = p.position or p
        local x, y, z = place(position)
        local point = { position = { number(x, what), number(y, what), number(z, what) }, time = p.time or i - 1,
            yaw = p.yaw or 0, pitch = p.pitch or 0, roll = p.roll or 0, fov = p.fov or o.fov or math.rad(75) }
        if p.at then
            local ax, ay, az = place(p.at)
            local dx, dy, dz = ax - x, ay - y, az - z
            point.yaw, point.pitch = math.atan(dz, dx), math.atan(-dy, math.sqrt(dx * dx + dz * dz))
        end
        points[i] = point
    end
    return points
end

-- A ride along checkpoints. points: a list of {time =, position =, yaw =, pitch =, roll =, fov =}, as `path` items of
-- .scene files have them and daft.camera.checkpoints() gives them; a checkpoint may have at = {x, y, z} instead of
-- angles, or be just {x, y, z}. curve: "smooth" (through all points, Catmull-Rom) or "bezier" (through the first, the
-- fourth, the seventh...; those between pull). pace: "timed" (by the points' times), "constant" or "eased"; seconds: how
-- long all of it takes; ease: a curve of tween; at: what it looks at all the way; loop: begins again.
function camera.path(o)
    o = o or {}
    for key in pairs(o) do
        if not PATH[key] then error(("camera.path: there is no option '%s'"):format(tostring(key)), 2) end
    end
    local self = { at = o.at, fov = o.fov, loop = o.loop, curve = o.curve or "smooth", pace = o.pace or "timed", time = 0 }
    if not CURVES[self.curve] then error("camera.path: curve: \"smooth\" or \"bezier\" expected", 2) end
    local given = o.points or daft.camera.checkpoints()
    if type(given) ~= "table" then error("camera.path: points: list expected, got " .. type(given), 2) end
    self.points = checkpoints({ points = given, fov = o.fov })
    local count = #self.points
    if count == 0 then error("camera.path: there are no points, and no `path` in a scene file", 2) end
    if self.curve == "bezier" and (count < 4 or count % 3 ~= 1) then
        error(("camera.path: bezier: 4, 7, 10 ... points expected, got %d"):format(count), 2)
    end
    self.first, self.length = self.points[1].time, self.points[count].time - self.points[1].time
    self.seconds = o.seconds or self.length
    if type(self.seconds) ~= "number" or not (self.seconds >= 0) then
        error("camera.path: seconds: number, 0 or more, expected", 2)
    end
    self.ease = o.ease and function(t) return tween.ease(o.ease, t) end
    daft.camera.along(self.points, self.first, self.pace) -- refuses what is wrong with them
    return setmetatable(self, Path)
end

local function mix(a, b, t) return a + (b - a) * t end

-- De Casteljau's algorithm on one number of four points.
local function cubic(a, b, c, d, t)
    local ab, bc, cd = mix(a, b, t), mix(b, c, t), mix(c, d, t)
    return mix(mix(ab, bc, t), mix(bc, cd, t), t)
end

-- `part` of all of the curve; the angles are those of the pieces' ends.
local function on_bezier(points, part)
    local pieces = (#points - 1) // 3
    local piece = math.min(math.floor(part * pieces), pieces - 1)
    local t, at = part * pieces - piece, 3 * piece + 1
    local a, b, c, d = points[at], points[at + 1], points[at + 2], points[at + 3]
    local ends = daft.camera.along({ { position = a.position, yaw = a.yaw, pitch = a.pitch, roll = a.roll, fov = a.fov, time = 0 },
        { position = d.position, yaw = d.yaw, pitch = d.pitch, roll = d.roll, fov = d.fov, time = 1 } }, t)
    for i = 1, 3 do ends.position[i] = cubic(a.position[i], b.position[i], c.position[i], d.position[i], t) end
    return ends
end

-- Where it is after `time` seconds: a table as of daft.camera.get.
function Path:get(time)
    local part = self.seconds > 0 and math.max(0, math.min(1, time / self.seconds)) or 1
    if self.ease then part = math.max(0, math.min(1, self.ease(part))) end
    local view
    if self.curve == "bezier" then
        view = on_bezier(self.points, part)
    else
        view = daft.camera.along(self.points, self.first + part * self.length, self.pace)
    end
    return view
end

-- Call it once a tick. True when it has arrived.
function Path:update(dt, jump)
    jump = jump or not self.shown
    self.time = self.time + (self.shown and dt or 0)
    self.shown = true
    local arrived = self.time >= self.seconds
    if arrived and self.loop and self.seconds > 0 then self.time, arrived, jump = self.time % self.seconds, false, true end
    local view = self:get(self.time)
    if self.at then
        daft.camera.look { from = view.position, at = self.at, fov = view.fov, teleport = jump }
    else
        view.teleport = jump
        daft.camera.set(view)
    end
    return arrived
end

function Path:restart() self.time, self.shown = 0, false end

return camera
