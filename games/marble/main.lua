-- Marble Run: roll a chrome marble over a course in the sky.
-- Collect the gems and roll through the golden ring. Arrow keys or WASD, space jumps, R starts again.

local level = require "level"   -- the course as data
local course = require "course" -- makes entities of it, moves what moves
local sparks = require "sparks" -- little lights that fly about for a moment
local sounds = require "sounds" -- what is heard
local bot = require "bot"       -- plays by itself: press B to watch

local ROLL = 17       -- newtons from a key; the marble has 1 kg
local DRAG = 1.9      -- newtons for each metre a second over ground: gives a top speed, and brakes
local JUMP = 5.6      -- metres a second upwards
local AIR = 0.4       -- how much of ROLL and DRAG is left in the air
local KICK = 7        -- metres a second from a bumper
local FALL_COST = 2   -- seconds
local FAR, HIGH = 6.8, 2.7 -- the camera, behind and above the marble

local marble
local state           -- "ready", "rolling" or "won"
local clock, time     -- seconds since the start of the course, and since the first key
local home            -- where a fall brings the marble back to
local best            -- the shortest time, also of earlier starts
local taken           -- gems
local ground          -- seconds since the marble last touched something it can jump from
local drift_x, drift_z = 0, 0 -- how fast that moves: platforms carry the marble along
local message, message_left = "", 0
local eye = {}        -- the camera's place

local function say(text, seconds) message, message_left = text, seconds end

-- -1, 0 or 1, by the arrow keys or the letters.
local function axis(minus, plus, minus_letter, plus_letter)
    local sum = daft.input.axis(minus, plus) + daft.input.axis(minus_letter, plus_letter)
    return math.max(-1, math.min(1, sum))
end

local function distance(x, y, z, p) return math.sqrt((x - p[1]) ^ 2 + (y - p[2]) ^ 2 + (z - p[3]) ^ 2) end

local function put_marble(place)
    marble:teleport(place[1], place[2] + 0.6, place[3])
    marble:velocity(0, 0, 0)
    marble:angular_velocity(0, 0, 0)
    sounds.still()
    eye.x, eye.y, eye.z, eye.jump = place[1] - FAR, place[2] + HIGH, place[3], true
    ground = 1
end

local function start_again()
    state, clock, time, taken, home = "ready", 0, 0, 0, level.start
    for _, gem in ipairs(course.gems) do
        gem.taken = false
        gem.entity:visible(true)
    end
    put_marble(home)
    bot.start()
    say("", 0)
end

function daft.load()
    best = daft.load_saved("best")
    if math.type(best) ~= "float" then best = nil end
    daft.sky.image("sky/day.jpg")
    daft.ambient { 0.36, 0.40, 0.48 }
    daft.light.sun { direction = { 0.35, -0.75, 0.55 }, color = { 0.95, 0.90, 0.80 } } -- as the sky has it
    course.build(level)
    sounds.load()
    marble = daft.entity { sphere = 0.5, mass = 1, body = "dynamic", friction = 0.9, restitution = 0.25,
        material = { color = "#202428", specular = 0.9, shininess = 400, mirror = 0.85 } }
    start_again()
end

-- Pushes the marble where the keys say, as seen from the camera.
local function steer()
    local x, _, z = marble:position()
    local ahead, aside = axis("down", "up", "s", "w"), axis("left", "right", "a", "d")
    if state == "won" then ahead, aside = 0, 0 end
    if state == "ready" and (ahead ~= 0 or aside ~= 0) then state = "rolling" end

    local fx, fz = x - eye.x, z - eye.z -- forward, level; to the right of it is (-fz, fx)
    local far = math.sqrt(fx * fx + fz * fz)
    local px, pz = (fx * ahead - fz * aside) / far, (fz * ahead + fx * aside) / far
    if ahead ~= 0 and aside ~= 0 then px, pz = px * 0.7071, pz * 0.7071 end
    local vx, _, vz = marble:velocity()
    local grip = ground < 0.1 and 1 or AIR
    marble:push((px * ROLL - (vx - drift_x) * DRAG) * grip, 0, (pz * ROLL - (vz - drift_z) * DRAG) * grip)
end

-- What the marble touched in the last step: ground to jump from, bumpers that kick.
local function feel(dt)
    ground = ground + dt
    for _, contact in ipairs(marble:contacts()) do
        local n = contact.normal
        if n[2] > 0.5 then
            ground = 0
            local vx, _, vz = contact.other:velocity()
            drift_x, drift_z = vx, vz
        end
        local bumper = contact.other.data
        if bumper and bumper.glow == 0 then
            bumper.glow = 0.25
            marble:impulse(n[1] * KICK, 1.5, n[3] * KICK)
            sparks.burst(contact.point, "#ffb080", 6)
            sounds.bumper(contact.point)
        end
    end
end

local function collect(x, y, z)
    for _, gem in ipairs(course.gems) do
        if not gem.taken and distance(x, y, z, gem.place) < 1 then
            gem.taken = true
            gem.entity:visible(false)
            taken = taken + 1
            sounds.gem(taken)
            sparks.burst(gem.place, "#60f0ff", 12)
        end
    end
    for _, place in ipairs(level.checkpoints) do
        if home ~= place and place[1] > home[1] - 1 and distance(x, y, z, place) < 3 then
            home = place
            say("Checkpoint", 1.5)
            sounds.checkpoint()
        end
    end
end

local function finish(x, y, z)
    if state ~= "rolling" or distance(x, y - 0.5, z, level.goal) > 1.3 then return end
    if taken < level.gems_needed then
        if message_left <= 0 then sounds.hint() end
        say(("%d more gems!"):format(level.gems_needed - taken), 1)
        return
    end
    state = "won"
    sounds.win()
    if not best or time < best then
        best = time
        daft.save("best", best)
    end
    print(("marble: won in %.1f s, %d of %d gems"):format(time, taken, #course.gems))
end

local function celebrate(x, y, z)
    if state ~= "won" or daft.tick() % 24 ~= 0 then return end
    local colors = { "#ffd34d", "#60f0ff", "#ff7a6b", "#8dff8a" }
    sparks.burst({ x, y + 1, z }, colors[daft.random(#colors)], 14)
end

-- The camera hangs behind the marble as on a rope, and swings round to where the marble goes.
local function follow(dt)
    local x, y, z = marble:position()
    local vx, _, vz = marble:velocity()
    local ox, oz = eye.x - x, eye.z - z
    local far = math.sqrt(ox * ox + oz * oz)
    local speed = math.sqrt(vx * vx + vz * vz)
    ox, oz = ox / far, oz / far
    if state == "won" then
        ox, oz = ox - oz * 0.5 * dt, oz + ox * 0.5 * dt -- walks around the winner
    elseif speed > 1 then
        local against = 1 - (vx * ox + vz * oz) / speed -- 0 when the marble comes straight at the camera
        ox, oz = ox - vx / speed * against * 0.9 * dt, oz - vz / speed * against * 0.9 * dt
    end
    far = FAR / math.sqrt(ox * ox + oz * oz)
    eye.x, eye.z = x + ox * far, z + oz * far
    local low = math.max(y, home[2] - 3) -- does not fall after the marble
    eye.y = eye.y + (low + HIGH - eye.y) * math.min(1, 5 * dt)
    daft.camera.look { from = { eye.x, eye.y, eye.z }, at = { x, y + 1.1, z }, fov = math.rad(75), teleport = eye.jump }
    eye.jump = false
end

function daft.update(dt)
    clock, message_left = clock + dt, message_left - dt
    if state == "rolling" then time = time + dt end
    local x, y, z = marble:position()
    bot.update(marble, eye, course)
    feel(dt)
    steer()
    sounds.update(marble, ground < 0.1)
    course.update(clock, dt)
    collect(x, y, z)
    finish(x, y, z)
    celebrate(x, y, z)
    if y < level.lowest + home[2] then
        if state == "rolling" then time = time + FALL_COST end
        put_marble(home)
        sounds.fall()
        say(("Fallen: +%d s"):format(FALL_COST), 1.5)
    end
    sparks.update(dt)
    follow(dt)
end

function daft.keypressed(name)
    if name == "space" and ground < 0.12 and state ~= "won" then
        marble:impulse(0, JUMP, 0)
        sounds.jump()
        ground = 1
    elseif name == "r" then
        start_again()
    elseif name == "b" then
        bot.toggle()
        start_again()
    end
end

local function centred(text, y, size, color)
    daft.text(text, daft.width() / 2, y, { size = size, color = color or "#ffffff", align = "center" })
end

local function banner(title, line, hint)
    daft.rect(daft.width() / 2 - 400, 110, 800, 190, "#10203060")
    centred(title, 120, 84, "#fff0c0")
    centred(line, 220, 28)
    centred(hint, 258, 24)
end

function daft.draw()
    daft.rect(16, 14, 190, 54, "#10203070")
    daft.text(("◆ %d / %d"):format(taken, #course.gems), 34, 22, { size = 34, color = "#8ff4ff" })
    daft.rect(daft.width() - 176, 14, 160, 54, "#10203070")
    daft.text(("%.1f s"):format(time), daft.width() - 34, 22, { size = 34, align = "right" })

    if state == "ready" then
        banner("Marble Run", ("Collect %d gems and roll through the golden ring"):format(level.gems_needed),
            "← ↑ ↓ → or WASD roll · space jumps · R again · B shows how")
    elseif state == "won" then
        banner("You made it!", ("%.1f s with %d of %d gems · best %.1f s"):format(time, taken, #course.gems, best),
            "R plays again")
    elseif message_left > 0 then
        centred(message, 96, 48)
    end
end
