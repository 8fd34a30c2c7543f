-- Values that move smoothly from one number to another.
--
--     local tween = require "tween"
--     local door = tween.new(1.5, { y = 0 }, { y = 3 }, "in_out")
--     function daft.update(dt)
--         if door:update(dt) then print("open") end        -- true once, when it arrives
--         gate:position(0, door.value.y, 0)
--     end
--
-- Or tween.ease("out", t) for the curve alone: t from 0 to 1.

local tween = {}

local curves = {
    linear = function(t) return t end,
    ["in"] = function(t) return t * t end,                              -- starts slowly
    out = function(t) return t * (2 - t) end,                           -- ends slowly
    in_out = function(t) return t * t * (3 - 2 * t) end,                -- both
    back = function(t) local u = t - 1; return 1 + u * u * (2.70158 * u + 1.70158) end, -- overshoots, and comes back
    bounce = function(t)                                                -- falls, and bounces three times
        if t < 4 / 11 then return 7.5625 * t * t end
        if t < 8 / 11 then t = t - 6 / 11; return 7.5625 * t * t + 0.75 end
        if t < 10 / 11 then t = t - 9 / 11; return 7.5625 * t * t + 0.9375 end
        t = t - 21 / 22
        return 7.5625 * t * t + 0.984375
    end,
}

local function find(name)
    local curve = curves[name or "in_out"]
    if curve then return curve end
    local names = {}
    for key in pairs(curves) do names[#names + 1] = key end
    error(("tween: there is no curve '%s'; there are %s"):format(tostring(name), table.concat(names, ", ")), 3)
end

function tween.ease(name, t) return find(name)(math.max(0, math.min(1, t))) end

local Tween = {}
Tween.__index = Tween

-- Takes `seconds` from the numbers of one table to those of another with the same keys. self.value has those of now.
function tween.new(seconds, from, to, curve)
    if type(seconds) ~= "number" or seconds <= 0 then error("tween.new: seconds above 0 expected", 2) end
    local self = { seconds = seconds, from = {}, to = {}, value = {}, time = 0, curve = find(curve) }
    for key, target in pairs(to) do
        if type(from[key]) ~= "number" or type(target) ~= "number" then
            error(("tween.new: '%s' must be a number in both tables"):format(tostring(key)), 2)
        end
        self.from[key], self.to[key], self.value[key] = from[key], target, from[key]
    end
    return setmetatable(self, Tween)
end

-- True in the one step in which it arrives.
function Tween:update(dt)
    if self.time >= self.seconds then return false end
    self.time = math.min(self.seconds, self.time + dt)
    local weight = self.curve(self.time / self.seconds)
    for key, from in pairs(self.from) do self.value[key] = from + (self.to[key] - from) * weight end
    if self.time < self.seconds then return false end
    for key, target in pairs(self.to) do self.value[key] = target end
    return true
end

function Tween:done() return self.time >= self.seconds end

-- Back to the start.
function Tween:restart()
    self.time = 0
    for key, from in pairs(self.from) do self.value[key] = from end
end

return tween
