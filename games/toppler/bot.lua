-- Plays by pressing keys, as a player would: it turns the catapult, pulls, lets go. The title's menu lets it play.
-- demo.rec was recorded from a copy of this folder, named toppler too, with `playing = true`, by a player who had won
-- all levels but the second and the last:
--     daft play COPY --headless --ticks N --saves FOLDER --record demo.rec

local catapult = require "catapult"

local bot = {}

local playing = false

local NEAR, EXACT = math.rad(0.6), math.rad(0.03)
local LATE = 2 / 90 -- of a pull: it goes on until the key that is let go has come up

-- For each level what to aim at, shot by shot: a place, and metres a second; high: by the steeper of the two arcs.
local plans = {
    { { at = { 24, 2.4, 0 }, speed = 24 } },
    { { at = { 22, 1.5, 0 }, speed = 24 } },
    { { at = { 25, 3, 0 }, speed = 26 } },
    { { at = { 14, 1.3, -8 }, speed = 20 } },
    { { at = { 28, 2.6, 0 }, speed = 20, high = true } },
    { { at = { 24, 1.6, -4.2 }, speed = 22, high = true } },
    { { at = { 25, 3.4, -6.3 }, speed = 28 } },
    { { at = { 26.5, 3, 0 }, speed = 20, high = true }, { at = { 26.5, 2.6, 3 }, speed = 24 }, { at = { 26.5, 2.6, -3 }, speed = 24 } },
    { { at = { 26, 4, 0.5 }, speed = 24 } },
    { { at = { 27, 12.3, 0 }, speed = 28 }, { at = { 27, 12, 0 }, speed = 30 }, { at = { 27, 11.5, 0 }, speed = 30 } },
}

local down = {}
local function press(key, on)
    if (down[key] or false) ~= on then daft.input.set(key, on) end
    down[key] = on
end

local function rest()
    for key in pairs(down) do press(key, false) end
end

function bot.playing() return playing end

function bot.toggle()
    playing = not playing
    if not playing then rest() end
end

-- The pull, yaw and pitch with which a shot meets a place.
local function solve(shot)
    local pull = (shot.speed - catapult.speed(0)) / (catapult.speed(1) - catapult.speed(0))
    local yaw = math.atan(shot.at[3], shot.at[1])
    local from = catapult.throw(pull)
    local flat = math.sqrt((shot.at[1] - from[1]) ^ 2 + (shot.at[3] - from[3]) ^ 2)
    local up, v2 = shot.at[2] - from[2], shot.speed * shot.speed
    local root = v2 * v2 - 9.81 * (9.81 * flat * flat + 2 * up * v2)
    if root < 0 then error("the bot cannot throw that far") end
    return pull, yaw, math.atan(v2 + (shot.high and 1 or -1) * math.sqrt(root), 9.81 * flat)
end

-- Holds a key while the error is large, then taps it: the catapult starts to turn slowly.
local function steer(error, more, less)
    local on = math.abs(error) > NEAR or (math.abs(error) > EXACT and daft.tick() % 2 == 0)
    press(more, on and error > 0)
    press(less, on and error < 0)
    return math.abs(error) <= EXACT
end

-- Where a key is waited for: which one, and after how many ticks of looking.
local TAPS = { title = { "return", 100 }, fly = { "return", 250 }, won = { "backspace", 170 }, lost = { "return", 120 } }

local waited, steady = 0, 0 -- ticks

local function tap(state)
    local key, patience = table.unpack(TAPS[state] or {})
    waited = waited + 1
    rest()
    if key and waited % patience == 0 then press(key, true) end
end

-- Once a tick: `game` is what main.lua knows.
function bot.update(game)
    if not playing then return end
    if game.state ~= "aim" then return tap(game.state) end
    waited = 0
    local plan = plans[game.number]
    local pull, yaw, pitch = solve(plan[math.min(game.shot, #plan)])
    local ready = steer(yaw - catapult.yaw, "right", "left") and steer(pitch - catapult.pitch, "up", "down")
    steady = ready and steady + 1 or 0
    press("space", (steady > 4 or game.pull ~= nil) and (game.pull or 0) < pull - LATE)
end

return bot
