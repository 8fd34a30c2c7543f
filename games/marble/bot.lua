-- Plays the course by pressing keys, as a player would: it never touches the marble itself.
-- B in the game lets it play. demo.rec was recorded from a copy of this folder, named marble too, with `playing = true`:
--     daft play COPY --headless --ticks N --record demo.rec

local bot = {}

local playing = false

-- Where to go, one after the other. stop: slow down for it. jump: press space when there. near: how close counts.
-- wait: go on when the platform is on this side. ride: stay on the platform until it is on the other side.
local path = {
    { 12, 0 }, { 22, 0 }, { 25, 0.1, speed = 6 }, { 27.2, 2.4, speed = 6 }, { 29.5, 5, speed = 5 },
    { 29.5, 11.2, jump = true, near = 0.6 }, { 29.5, 17 }, { 30.6, 20, speed = 4 }, { 32.5, 20.5, speed = 4 },
    { 43, 20.5, speed = 6 }, { 47.8, 20.5, near = 0.5, stop = true, wait = true },
    { 51.2, 20.5, speed = 5, near = 0.5 }, { 54.5, 20.5, ride = true }, { 61, 20.5 }, { 71.8, 20.5, near = 0.8 },
    { 73.4, 20.5, near = 0.7, jump = true }, { 83, 20.5, near = 0.5, stop = true },
}

local step

function bot.start() step = 1 end

local function press(ahead, aside)
    daft.input.set("up", ahead > 0)
    daft.input.set("down", ahead < 0)
    daft.input.set("right", aside > 0)
    daft.input.set("left", aside < 0)
end

function bot.toggle()
    playing = not playing
    if not playing then press(0, 0) end
end

-- -1, 0 or 1: full throttle or none, as keys are.
local function throttle(wish) return wish > 0.5 and 1 or wish < -0.5 and -1 or 0 end

function bot.update(marble, eye, course)
    local goal = playing and path[step]
    if not goal then return end
    local x, _, z = marble:position()
    local vx, _, vz = marble:velocity()
    local platform = course.platforms[1].entity
    local px, _, pz = platform:position()
    local pvx = platform:velocity()
    local dx, dz = goal[1] - x, goal[2] - z
    if goal.ride then dx, dz = px - x, pz - z end
    local far = math.sqrt(dx * dx + dz * dz)

    daft.input.set("space", false)
    if far < (goal.near or 1) and not (goal.wait and px > 51.6) and not (goal.ride and px < 57.4) then
        if goal.jump then daft.input.set("space", true) end
        step = step + 1
        if not path[step] then press(0, 0) end
        return
    end

    -- The velocity it would like to have less the one it has, as seen from the camera.
    local speed = goal.speed or 9
    if goal.stop or goal.ride then speed = math.min(speed, far * 2.5) end
    local wx, wz = dx / far * speed - vx, dz / far * speed - vz
    if goal.ride then wx = wx + pvx end
    local fx, fz = x - eye.x, z - eye.z
    local length = math.sqrt(fx * fx + fz * fz)
    press(throttle((wx * fx + wz * fz) / length), throttle((wz * fx - wx * fz) / length))
end

return bot
