-- Looking around with the mouse and a gamepad's right stick.
--
--     local look = require("look").new { pitch = 0.2 }
--     function daft.update(dt)
--         look:update(dt)
--         daft.camera.set { position = { x, y, z }, yaw = look.yaw, pitch = look.pitch }
--     end

local look = {}

local Look = {}
Look.__index = Look

local fields = { yaw = 0, pitch = 0, speed = 0.0035, turn = 2.5, limit = 1.5, invert = false, grab = true }

-- yaw, pitch: to begin with. speed: radians a unit of the mouse's; turn: radians a second of the stick's. limit: of the
-- pitch. invert: up is down. grab: the mouse is held while it looks; false leaves that to the game.
function look.new(def)
    local self = setmetatable({}, Look)
    for key in pairs(def or {}) do
        if fields[key] == nil then error(("look.new: there is no '%s'"):format(tostring(key)), 2) end
    end
    for key, usual in pairs(fields) do
        if def and def[key] ~= nil then self[key] = def[key] else self[key] = usual end
    end
    return self
end

function Look:update(dt)
    if self.grab then daft.input.mouse.grab(true) end
    local x, y = daft.input.mouse.motion()
    local stick_x, stick_y = daft.input.stick("right x"), daft.input.stick("right y")
    -- The square is finer near the middle.
    local right = x * self.speed + stick_x * math.abs(stick_x) * self.turn * dt
    local down = y * self.speed + stick_y * math.abs(stick_y) * self.turn * dt
    self.yaw = self.yaw + right
    self.pitch = math.max(-self.limit, math.min(self.limit, self.pitch + (self.invert and -down or down)))
end

-- Where it looks, and to its right, level with the ground: x, z of each, for walking.
function Look:ahead() return math.cos(self.yaw), math.sin(self.yaw) end
function Look:right() return -math.sin(self.yaw), math.cos(self.yaw) end

return look
