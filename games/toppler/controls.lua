-- Keys, mouse and gamepad as what they mean in this game.

local controls = {}

local TURN = math.rad(24)        -- radians a second, once a key has been held for a while
local FINE = math.rad(3)         -- and at first, to aim finely
local MOUSE = math.rad(0.05)     -- for each HUD unit
local CONFIRM = { "return", "space", "mouse1", "pad a", "pad start" }
local BACK = { "backspace", "pad b", "pad back" }

local held = 0                   -- seconds since an aiming key went down

local function any(keys)
    for _, key in ipairs(keys) do
        if daft.input.pressed(key) then return true end
    end
    return false
end

function controls.confirm() return any(CONFIRM) end
function controls.back() return any(BACK) end
function controls.again() return any { "r", "pad y" } end
function controls.pull() return daft.input.down("space") or daft.input.down("mouse1") or daft.input.down("pad a") end
function controls.pulls() return any { "space", "mouse1", "pad a" } end
function controls.peek() return daft.input.down("tab") or daft.input.down("mouse3") or daft.input.down("pad x") end

local function keys(minus, plus, minus_letter, plus_letter, pad_minus, pad_plus)
    local sum = daft.input.axis(minus, plus) + daft.input.axis(minus_letter, plus_letter) + daft.input.axis(pad_minus, pad_plus)
    return math.max(-1, math.min(1, sum))
end

-- Radians to turn right and to raise in this tick.
function controls.aim(dt)
    local turn = keys("left", "right", "a", "d", "pad left", "pad right")
    local raise = keys("down", "up", "s", "w", "pad down", "pad up")
    held = (turn ~= 0 or raise ~= 0) and held + dt or 0
    local speed = FINE + (TURN - FINE) * math.min(1, held * held * 1.6)
    local mx, my = daft.input.mouse.motion()
    local sx, sy = daft.input.stick("left x"), daft.input.stick("left y")
    return (turn * speed + sx * math.abs(sx) * TURN) * dt + mx * MOUSE,
        (raise * speed - sy * math.abs(sy) * TURN) * dt - my * MOUSE
end

return controls
