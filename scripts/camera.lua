-- Cameras that move by themselves: one follows an entity, one orbits a position.
--
--     local camera = require "camera"
--     local eye = camera.follow { target = ball, distance = 8, height = 3 }
--     function daft.update(dt) eye:update(dt) end
--
-- A target is an entity or {x, y, z}. Distances are in metres, angles in radians, times in seconds. Smoothing
-- covers 63 % of the remaining way in `smooth` seconds, whatever the length of the step.

local camera = {}

local function place(target)
    if type(target) == "userdata" then return target:position() end
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

return camera
