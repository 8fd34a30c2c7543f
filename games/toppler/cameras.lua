-- Where one looks from: round the title, over the level at its start, behind the catapult, after the shot.

local camera = require "camera"

local cameras = {}

local FOV = math.rad(62)

local from, at                   -- where the camera is, and looks
local goal_from, goal_at, haste  -- where they go, and 1/s
local ride                       -- over the level at its start
local shake = 0                  -- metres
cameras.shaking = true           -- a setting

local function mix(a, b, t)
    return { a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t, a[3] + (b[3] - a[3]) * t }
end

local function go(f, a, speed, jump)
    goal_from, goal_at, haste, ride = f, a, speed, nil
    if jump or not from then from, at = f, a end
end

-- Slowly round what there is to see.
function cameras.orbit(view, time, jump)
    local angle, far, side = 2.6 + time * 0.12, view[4] * 0.9 + 9, 4.5 -- looks past it, so that it stands beside the menu
    go({ view[1] + far * math.cos(angle), view[2] + far * 0.42, view[3] + far * math.sin(angle) }, { view[1] - side * math.sin(angle), view[2], view[3] + side * math.cos(angle) }, 3, jump)
end

-- Behind the catapult; looks the higher, the higher the towers are.
local function behind(catapult, view)
    local c, s = math.cos(catapult.yaw), math.sin(catapult.yaw)
    return { -10 * c + 1.6 * s, 5.6, -10 * s - 1.6 * c }, { 16 * c, 2.2 + math.max(0, view[2] - 3) * 0.6, 16 * s }
end

-- Over the towers and back to the catapult.
function cameras.fly(view, catapult)
    local x, y, z, far = view[1], view[2], view[3], view[4] * 0.7 + 7
    local look = { x, y, z }
    local home, ahead = behind(catapult, view)
    ride = camera.path { seconds = 5.5, ease = "in_out", fov = FOV, points = {
        { position = { x + far, y + far * 0.7, z + far * 0.4 }, at = look },
        { position = { x + far * 0.5, y + far * 0.4, z - far }, at = look },
        { position = { x - far * 0.9, y + far * 0.25, z - far * 0.8 }, at = look },
        { position = { -4, 7, -4 }, at = mix(look, ahead, 0.5) },
        { position = home, at = ahead } } }
    from, at = home, ahead
    goal_from, goal_at, haste = home, ahead, 6
end

function cameras.flying() return ride ~= nil end
function cameras.skip() ride = nil end

function cameras.aim(catapult, view)
    local f, a = behind(catapult, view)
    go(f, a, 6)
end

-- After the shot, a little behind and above it, and never further than before the towers.
function cameras.follow(ball, view)
    local x, y, z = ball:position()
    local vx = ball:velocity()
    local t = math.min(1, math.max(0, x / math.max(1, view[1])))
    local reach = math.min(x - 7, view[1] - 9)
    go({ reach, math.max(y + 1.5, 3.5), z * 0.6 - 3 * t }, mix({ x + 2, y - 0.6, z }, { view[1], view[2] * 0.8, view[3] }, t * t), vx and 3.5)
end

-- From the side, for what falls.
function cameras.watch(view, time)
    local angle, far = -2.5 + time * 0.05, view[4] * 0.8 + 8
    go({ view[1] + far * math.cos(angle), view[2] + far * 0.34, view[3] + far * math.sin(angle) },
        { view[1], view[2] * 0.7, view[3] }, 1.6)
end

-- For cameras.restore: where it is and looks, and where it goes.
function cameras.state()
    return { from = from, at = at, goal_from = goal_from, goal_at = goal_at, haste = haste, shake = shake }
end

function cameras.restore(state)
    from, at, goal_from, goal_at, haste, shake = state.from, state.at, state.goal_from, state.goal_at, state.haste, state.shake
    ride = nil
end

function cameras.jolt(metres) shake = math.max(shake, metres) end

function cameras.update(dt)
    if ride then
        if ride:update(dt) then ride = nil end
        return
    end
    local t = 1 - math.exp(-haste * dt)
    from, at = mix(from, goal_from, t), mix(at, goal_at, t)
    local x, y, z = table.unpack(from)
    if cameras.shaking and shake > 0.005 then
        x, y, z = x, y + shake * math.sin(daft.tick() * 1.9), z + shake * math.sin(daft.tick() * 2.7)
    end
    shake = shake * 0.9
    daft.camera.look { from = { x, math.max(y, 0.6), z }, at = at, fov = FOV }
end

return cameras
