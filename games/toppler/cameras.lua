-- Where one looks from: round the title, over the level at its start, behind the catapult, after the shot.

local cameras = {}

local FOV = math.rad(62)

local from, at                   -- where the camera is, and looks
local goal_from, goal_at, haste  -- where they go, and 1/s
local path                       -- a flight: list of {from, at}, seconds, seconds gone
local shake = 0                  -- metres
cameras.shaking = true           -- a setting

local function mix(a, b, t)
    return { a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t, a[3] + (b[3] - a[3]) * t }
end

-- Catmull-Rom between b and c.
local function spline(a, b, c, d, t)
    local p = {}
    for i = 1, 3 do
        p[i] = 0.5 * (2 * b[i] + (c[i] - a[i]) * t + (2 * a[i] - 5 * b[i] + 4 * c[i] - d[i]) * t * t
            + (3 * b[i] - a[i] - 3 * c[i] + d[i]) * t * t * t)
    end
    return p
end

local function go(f, a, speed, jump)
    goal_from, goal_at, haste, path = f, a, speed, nil
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
    path = { time = 0, seconds = 5.5,
        { { x + far, y + far * 0.7, z + far * 0.4 }, look },
        { { x + far * 0.5, y + far * 0.4, z - far }, look },
        { { x - far * 0.9, y + far * 0.25, z - far * 0.8 }, look },
        { { -4, 7, -4 }, mix(look, ahead, 0.5) },
        { home, ahead } }
    from, at = path[1][1], path[1][2]
    goal_from, goal_at, haste = home, ahead, 6
    cameras.jumped = true
end

function cameras.flying() return path ~= nil end
function cameras.skip() path = nil end

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

function cameras.jolt(metres) shake = math.max(shake, metres) end

local function fly(dt)
    path.time = path.time + dt
    local t = math.min(1, path.time / path.seconds)
    local eased = t * t * (3 - 2 * t) * (#path - 1)
    local i = math.min(#path - 1, math.floor(eased) + 1)
    local a, b, c, d = path[math.max(1, i - 1)], path[i], path[i + 1], path[math.min(#path, i + 2)]
    from = spline(a[1], b[1], c[1], d[1], eased - i + 1)
    at = spline(a[2], b[2], c[2], d[2], eased - i + 1)
    if t == 1 then path = nil end
end

function cameras.update(dt)
    if path then
        fly(dt)
    else
        local t = 1 - math.exp(-haste * dt)
        from, at = mix(from, goal_from, t), mix(at, goal_at, t)
    end
    local x, y, z = table.unpack(from)
    if cameras.shaking and shake > 0.005 then
        x, y, z = x, y + shake * math.sin(daft.tick() * 1.9), z + shake * math.sin(daft.tick() * 2.7)
    end
    shake = shake * 0.9
    daft.camera.look { from = { x, math.max(y, 0.6), z }, at = at, fov = FOV, teleport = cameras.jumped }
    cameras.jumped = false
end

return cameras
