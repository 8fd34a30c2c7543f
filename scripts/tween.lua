-- Values that move smoothly from one number to another.
--
--     local tween = require "tween"
--     local door = tween.new(1.5, { y = 0 }, { y = 3 }, "in_out")
--     function daft.update(dt)
--         if door:update(dt) then print("open") end        -- true once, when it arrives
--         gate:position(0, door.value.y, 0)
--     end
--
-- Or tween.start, which needs no update: it calls a function with the values of each tick. Or tween.ease("out", t) for
-- the curve alone: t from 0 to 1.

local tween = {}

local function exp2(x) return math.exp(x * math.log(2)) end

-- Powers start slowly; the other kinds are made of these by turning them round.
local starts = {
    quad = function(t) return t * t end,
    cubic = function(t) return t * t * t end,
    quart = function(t) return t * t * t * t end,
    sine = function(t) return 1 - math.cos(t * math.pi / 2) end,
    expo = function(t) return t == 0 and 0 or exp2(10 * (t - 1)) end,
    circ = function(t) return 1 - math.sqrt(1 - t * t) end,
    back = function(t) return t * t * (2.70158 * t - 1.70158) end, -- swings back first
    elastic = function(t) -- as a string that is plucked
        if t == 0 or t == 1 then return t end
        return -exp2(10 * (t - 1)) * math.sin((t - 1.075) * 2 * math.pi / 0.3)
    end,
    bounce = function(t) -- falls, and bounces three times, backwards
        t = 1 - t
        if t < 4 / 11 then return 1 - 7.5625 * t * t end
        if t < 8 / 11 then t = t - 6 / 11; return 1 - (7.5625 * t * t + 0.75) end
        if t < 10 / 11 then t = t - 9 / 11; return 1 - (7.5625 * t * t + 0.9375) end
        t = t - 21 / 22
        return 1 - (7.5625 * t * t + 0.984375)
    end,
}

local curves = {
    linear = function(t) return t end,
    ["in"] = function(t) return t * t end,              -- starts slowly
    out = function(t) return t * (2 - t) end,           -- ends slowly
    in_out = function(t) return t * t * (3 - 2 * t) end, -- both
    back = function(t) return 1 - starts.back(1 - t) end, -- overshoots, and comes back
    bounce = function(t) return 1 - starts.bounce(1 - t) end,
}
for name, start in pairs(starts) do
    curves["in_" .. name] = start
    curves["out_" .. name] = function(t) return 1 - start(1 - t) end
    curves["in_out_" .. name] = function(t)
        if t < 0.5 then return start(2 * t) / 2 end
        return 1 - start(2 - 2 * t) / 2
    end
end

-- A name, or a function from 0..1 to numbers.
local function find(name)
    if type(name) == "function" then return name end
    local curve = curves[name or "in_out"]
    if curve then return curve end
    local names = {}
    for key in pairs(curves) do names[#names + 1] = key end
    error(("tween: there is no curve '%s'; there are %s"):format(tostring(name), table.concat(names, ", ")), 3)
end

function tween.ease(name, t) return find(name)(math.max(0, math.min(1, t))) end

local OPTIONS = { curve = true, delay = true, times = true, back_and_forth = true }

-- A curve, or a table of options.
local function read(options, what)
    if type(options) ~= "table" then return { curve = find(options) } end
    for key in pairs(options) do
        if not OPTIONS[key] then
            error(("%s: there is no option '%s'; there are back_and_forth, curve, delay, times"):format(what, tostring(key)), 3)
        end
    end
    local delay, times = options.delay or 0, options.times or 1
    if type(delay) ~= "number" or not (delay >= 0) then error(what .. ": delay: seconds, 0 or more, expected", 3) end
    if type(times) ~= "number" or not (times >= 1) then error(what .. ": times: 1 or more expected", 3) end
    return { curve = find(options.curve), delay = delay, times = times, back_and_forth = options.back_and_forth }
end

local Tween = {}
Tween.__index = Tween

-- Takes `seconds` from the numbers of one table to those of another with the same keys. self.value has those of now.
-- The last argument is a curve, or { curve =, delay =, times =, back_and_forth = }: seconds before it begins, how often
-- it goes (math.huge: for ever), and whether every second time it goes back.
function tween.new(seconds, from, to, options)
    if type(seconds) ~= "number" or not (seconds > 0) then error("tween.new: seconds above 0 expected", 2) end
    if type(from) ~= "table" or type(to) ~= "table" then error("tween.new: two tables of numbers expected", 2) end
    local o = read(options, "tween.new")
    local self = { seconds = seconds, from = {}, to = {}, value = {}, time = 0, curve = o.curve, delay = o.delay or 0,
        times = o.times or 1, back_and_forth = o.back_and_forth }
    for key, target in pairs(to) do
        if type(from[key]) ~= "number" or type(target) ~= "number" then
            error(("tween.new: '%s' must be a number in both tables"):format(tostring(key)), 2)
        end
        self.from[key], self.to[key], self.value[key] = from[key], target, from[key]
    end
    return setmetatable(self, Tween)
end

-- How far it is, 0 to 1 before the curve, `time` seconds after the delay.
local function progress(self, time)
    local turns = time / self.seconds
    local turn = math.min(math.floor(turns), self.times - 1)
    local t = math.min(1, turns - turn)
    if self.back_and_forth and turn % 2 == 1 then return 1 - t end
    return t
end

local function set(self, t)
    local weight = self.curve(t)
    for key, from in pairs(self.from) do
        local to = self.to[key]
        self.value[key] = t == 0 and from or t == 1 and to or from + (to - from) * weight
    end
end

-- True in the one step in which it arrives.
function Tween:update(dt)
    if self:done() then return false end
    self.time = self.time + dt
    if self.time <= self.delay then return false end
    set(self, progress(self, self.time - self.delay))
    return self:done()
end

function Tween:done() return self.time >= self.delay + self.seconds * self.times end

-- Back to the start, before the delay.
function Tween:restart()
    self.time = 0
    set(self, 0)
end

-- Runs by itself: calls apply(value) in each tick from now on, until it arrives. Gives the tween; t:stop() ends it.
function tween.start(seconds, from, to, options, apply)
    if type(apply) ~= "function" then error("tween.start: a function of the values expected as the last argument", 2) end
    local self = tween.new(seconds, from, to, options)
    local before = daft.time()
    apply(self.value)
    self.task = daft.every(0, function()
        local now = daft.time()
        local arrived = self:update(now - before)
        before = now
        apply(self.value)
        return not arrived
    end)
    return self
end

function Tween:stop()
    if self.task then daft.cancel(self.task) end
end

return tween
