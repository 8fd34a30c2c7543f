-- Keys, mouse and gamepad as what they mean in this game. The actions stand in the menu that Esc opens, where players
-- choose other keys and sticks for them.

local controls = {}

local TURN = math.rad(24)        -- radians a second, once a key has been held for a while
local FINE = math.rad(3)         -- and at first, to aim finely
local MOUSE = math.rad(0.05)     -- for each HUD unit

local held = 0                   -- seconds since an aiming key went down

function controls.load()
    local bind = daft.input.bind
    bind("turn", "right", "-left", "d", "-a", "pad right", "-pad left")
    bind("raise", "up", "-down", "w", "-s", "pad up", "-pad down")
    bind("throw", "space", "mouse1", "pad a", "right trigger")
    bind("turn by stick", "left x")
    bind("raise by stick", "left y")
    bind("look around", "tab", "mouse3", "pad x")
    bind("once more", "r", "pad y")
    bind("leave", "backspace", "pad b", "pad back")
end

local pressed, down, action = daft.input.pressed, daft.input.down, daft.input.action

function controls.confirm() return pressed("return") or pressed("throw") end
function controls.back() return pressed("leave") end
function controls.again() return pressed("once more") end
function controls.pull() return down("throw") end
function controls.pulls() return pressed("throw") end
function controls.peek() return down("look around") end

-- Radians to turn right and to raise in this tick.
function controls.aim(dt)
    local turn, raise = action("turn"), action("raise")
    held = (turn ~= 0 or raise ~= 0) and held + dt or 0
    local speed = FINE + (TURN - FINE) * math.min(1, held * held * 1.6)
    local mx, my = daft.input.mouse.motion()
    local sx, sy = action("turn by stick"), action("raise by stick")
    return (turn * speed + sx * math.abs(sx) * TURN) * dt + mx * MOUSE,
        (raise * speed - sy * math.abs(sy) * TURN) * dt - my * MOUSE
end

-- ---- within daft.draw: what the player reads on the keys ----

local ARROWS = { Left = "←", Right = "→", Up = "↑", Down = "↓" }

function controls.label(input)
    local label = daft.input.label(input) or "?"
    return ARROWS[label] or label
end

return controls
