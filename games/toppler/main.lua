-- Toppler: a catapult, ten towers, and kings who sit too high.
-- Knock every king down. The arrow keys or the mouse aim, hold space or the left button to pull, let go to throw.

local levels = require "levels"
local scenery = require "scenery"
local blocks = require "blocks"
local catapult = require "catapult"
local cameras = require "cameras"
local controls = require "controls"
local effects = require "effects"
local sounds = require "sounds"
local menus = require "menus"
local progress = require "progress"
local hud = require "hud"
local bot = require "bot"

local PULL, TAP = 1.5, 0.06           -- seconds to pull the catapult all the way; less of a pull throws nothing
local YAW, LOWEST, HIGHEST = math.rad(35), math.rad(-6), math.rad(78)
local SLOW = 0.3                      -- how fast time goes at the last blow
local SETTLED, LONGEST = 2.2, 8       -- seconds after a throw in which nothing is decided, and after which all is

game = { state = "title", note = "", note_left = 0 }
local flow                            -- the task that plays a level
local ball, thrown                    -- the shot on its way, and seconds since it left
local view_time = 0

local function say(text, seconds) game.note, game.note_left = text, seconds end

local function apply_settings()
    local s = progress.settings
    daft.volume("music", s.music / 10 * 0.6)
    daft.volume("effects", s.effects / 10)
    cameras.shaking = s.shaking
end

-- ---- a level ----

local function build(number)
    if flow then daft.cancel(flow) end
    daft.time_scale(1)
    flow, ball = nil, nil
    blocks.clear()
    if game.ball then game.ball:destroy() end
    game.ball = nil
    effects.arc(nil)
    sounds.pull(nil)
    daft.input.mouse.grab(false)
    game.number, game.level = number, levels[number]
    scenery.light(game.level.light)
    game.level.build(blocks)
    catapult.yaw, catapult.pitch = 0, math.rad(30)
    catapult.pose(0)
    catapult.load(nil)
end

local function count()
    game.kings = blocks.kings_left()
    game.points = 10 * blocks.toppled() + 250 * (#blocks.kings - game.kings)
end

local function over() return game.kings == 0 or game.lady_fell end

-- Pulls while the key is held; says when it is let go. A mere tap throws nothing.
local function pull(more)
    if controls.pulls() and not game.pull then game.pull = 0 end
    if not game.pull then return false end
    if controls.pull() then
        game.pull = math.min(1, game.pull + more)
        return false
    end
    if game.pull >= TAP then return true end
    game.pull = nil
    return false
end

-- In a task: until the shot has been let go, or there is no need for it.
local function take_aim(kind)
    game.state, game.pull = "aim", nil
    daft.input.mouse.grab(true)
    catapult.load(kind)
    catapult.pose(0)
    wait_until(function()
        if over() then return true end
        local turn, raise = controls.aim(1 / 60)
        catapult.yaw = math.max(-YAW, math.min(YAW, catapult.yaw + turn))
        catapult.pitch = math.max(LOWEST, math.min(HIGHEST, catapult.pitch + raise))
        local let_go = pull(1 / 60 / PULL)
        catapult.pose(game.pull or 0)
        sounds.pull(game.pull)
        if progress.settings.arc then effects.arc(catapult.throw(game.pull or game.last_pull)) end
        return let_go
    end)
    sounds.pull(nil)
    effects.arc(nil)
    daft.input.mouse.grab(false)
end

local function settled()
    if over() or thrown > LONGEST then return true end
    if thrown < SETTLED then return false end
    return daft.physics().awake == 0 or (ball == nil and thrown > 5)
end

local function throw(kind)
    game.state, game.last_pull = "watch", game.pull
    sounds.play("throw")
    if game.ball then game.ball:destroy() end
    thrown = 0
    ball = catapult.fire(kind, game.last_pull)
    game.ball = ball
    sounds.play("whoosh", { at = ball, volume = 0.6 })
end

-- In a task: until the shot has done what it does.
local function watch()
    wait_until(settled)
    ball = nil
end

local function finish()
    count()
    local left = #game.level.shots - game.shot
    if game.lady_fell or game.kings > 0 then
        game.state, game.lost_text = "lost", game.lady_fell and "The lady fell!" or "Still enthroned"
        sounds.play("lose")
        return
    end
    game.points = game.points + 500 * left
    game.stars = math.max(1, math.min(3, 3 - (game.shot - game.level.par)))
    game.kings_text = #blocks.kings == 1 and "The king is down!" or "All kings are down!"
    game.record = progress.won(game.number, game.points, game.stars)
    game.state = "won"
    sounds.play("win")
    print(("toppler: level %d won with %d of %d shots, %d points, %d stars"):format(game.number, game.shot, #game.level.shots,
        game.points, game.stars))
end

-- In a task: the last king falls, or the lady, for all to see.
local function slow_motion()
    daft.time_scale(SLOW)
    wait(1.6 * SLOW)
    daft.time_scale(1)
    wait(0.7)
end

local function fly()
    game.state = "fly"
    cameras.fly(game.level.view, catapult)
    wait()
    wait_until(function() return not cameras.flying() or controls.confirm() end)
    cameras.skip()
    wait()
end

-- In a task: a level from its start, or from where game.shot and game.state say that it stands.
local function run(from)
    if from == "fly" then fly() end
    for i = game.shot, #game.level.shots do
        game.shot = i
        if from ~= "watch" then
            local kind = game.level.shots[i]
            take_aim(kind)
            if not over() then throw(kind) end
        end
        if game.state == "watch" then watch() end
        from = nil
        if over() then break end
    end
    if over() then slow_motion() end
    finish()
end

local function play(number)
    menus.close()
    build(number)
    local best = progress.best[number]
    game.shot, game.pull, game.last_pull, game.lady_fell, game.best = 1, nil, 0.6, false, best and best.points
    say("", 0)
    count()
    view_time = 0
    sounds.music("play")
    flow = daft.start(run, "fly")
end

-- ---- the title and its menus ----

local title

local function choose_level()
    local rows = {}
    for i, level in ipairs(levels) do
        local best = progress.best[i]
        rows[i] = { label = ("%d  %s"):format(i, progress.open(i) and level.name or "?"), locked = not progress.open(i),
            action = function() play(i) end, note = best and hud.stars(best.stars) .. (" %5d"):format(best.points) }
    end
    menus.show("Levels", rows, title)
end

-- A row for a setting: a slider where it is a number, else a switch.
local function setting(label, name)
    local number = type(progress.settings[name]) == "number"
    return { label = label, from = number and 0 or nil, to = number and 10 or nil, value = progress.settings[name], changed = function(value)
        progress.settings[name] = value
        apply_settings()
        progress.save()
    end }
end

local function settings()
    menus.show("Settings", { setting("Music", "music"), setting("Effects", "effects"), setting("Show the arc", "arc"),
        setting("Shake the camera", "shaking"), { label = "Back", action = title } }, title)
end

local function next_level()
    for i = 1, #levels do
        if not progress.best[i] then return i end
    end
    return 1
end

function title()
    if game.state ~= "title" then
        build(5)
        game.state = "title"
        cameras.orbit(game.level.view, 0, true)
        sounds.music("title")
    end
    local number = next_level()
    menus.show("The kings sit too high", {
        { label = number == 1 and "Play" or ("Go on with level %d"):format(number), action = function() play(number) end },
        { label = "Levels", action = choose_level },
        { label = "Settings", action = settings },
        { label = "Watch the bot", action = function()
            bot.toggle()
            play(1)
        end },
        { label = "Quit", action = daft.quit } })
end

-- ---- the game's callbacks ----

function daft.load()
    controls.load()
    progress.load(#levels)
    sounds.load()
    scenery.build()
    catapult.build()
    effects.load()
    apply_settings()
    game.state = ""
    title()
end

-- ---- live reload: what goes on in the new code ----

local KEPT = { "state", "shot", "last_pull", "lady_fell", "kings", "points", "stars", "kings_text", "lost_text", "record",
    "note", "note_left" }

function daft.keep()
    local old = { bot = bot.playing(), view_time = view_time, thrown = thrown, yaw = catapult.yaw, pitch = catapult.pitch,
        number = game.number, game = {}, blocks = blocks.state(), camera = cameras.state() }
    for _, name in ipairs(KEPT) do old.game[name] = game[name] end
    if game.ball then old.ball, old.kind, old.flies = blocks.motion(game.ball), game.ball.data.kind, ball ~= nil end
    return old
end

function daft.reload(old)
    if old.bot ~= bot.playing() then bot.toggle() end
    if old.game.state == "title" then
        view_time = old.view_time
        return
    end
    play(old.number)
    if old.game.state == "fly" or not blocks.restore(old.blocks) then return end
    daft.cancel(flow)
    for _, name in ipairs(KEPT) do game[name] = old.game[name] end
    catapult.yaw, catapult.pitch, view_time, thrown = old.yaw, old.pitch, old.view_time, old.thrown
    catapult.pose(0)
    cameras.restore(old.camera)
    if old.ball then
        game.ball = catapult.shot(old.kind, { table.unpack(old.ball, 1, 3) })
        blocks.move(game.ball, old.ball)
        ball = old.flies and game.ball or nil
    end
    if game.state == "aim" or game.state == "watch" then flow = daft.start(run, game.state) end
end

local MOST_DUST = 8               -- clouds of it in one tick
local events = {}
local function impacts()
    local clouds = 0
    for _, event in ipairs(daft.events(events)) do
        if event.kind == "begin" and event.speed > 1 then
            sounds.hit(event)
            if event.speed > 2.5 and clouds < MOST_DUST then
                clouds = clouds + 1
                effects.burst("dust", math.min(12, math.floor(2 * event.speed)), event.point)
            end
            local a, b = event.a, event.b
            if (a == ball or b == ball) and event.speed > 3 then
                if ball.data.kind == "bomb" then
                    effects.explode { ball:position() }
                    sounds.play("boom", { at = event.point, near = 30, far = 200 })
                    cameras.jolt(0.5)
                    ball:destroy()
                    ball, game.ball = nil, nil
                    return
                end
                effects.burst("chips", math.min(30, math.floor(2 * event.speed)), event.point)
                if event.speed > 8 then cameras.jolt(event.speed * 0.012) end
            end
        end
    end
end

local function fell(who, lady)
    local x, y, z = who.body:position()
    effects.burst(lady and "pink" or "gold", 60, { x, y + 0.8, z })
    sounds.play(lady and "scream" or "yelp", { at = who.body, near = 20, far = 200 })
    say(lady and "Oh no, the lady!" or blocks.kings_left() > 0 and "One king down!" or "", 1.5)
    if lady then game.lady_fell = true end
end

local function answer_keys()
    if game.state == "won" and controls.confirm() then
        if game.number < #levels then play(game.number + 1) else title() end
    elseif game.state == "lost" and controls.confirm() then
        play(game.number)
    elseif controls.back() then
        title()
    elseif controls.again() then
        play(game.number)
    end
end

local function look(dt)
    view_time = view_time + dt
    local view = game.level.view
    if game.state == "title" then
        cameras.orbit(view, view_time)
    elseif game.state == "aim" and not controls.peek() then
        cameras.aim(catapult, view)
    elseif ball and thrown and thrown < 2 then
        cameras.follow(ball, view)
    elseif game.state ~= "fly" then
        cameras.watch(view, view_time)
    end
    cameras.update(dt)
end

function daft.update(dt)
    bot.update(game)
    game.note_left = game.note_left - dt
    if thrown then thrown = thrown + dt end
    if menus.shown() then menus.update() else answer_keys() end
    impacts()
    if game.state ~= "title" then
        blocks.watch(fell)
        if game.state == "aim" or game.state == "watch" then count() end
    end
    blocks.update()
    if ball and thrown and thrown < 3 then
        local x, y, z = ball:position()
        local vx, vy, vz = ball:velocity()
        effects.trail(x, y, z, vx, vy, vz, ball.data.kind)
    end
    effects.update(dt)
    sounds.update()
    look(dt)
end

function daft.keypressed(key)
    if key == "b" and game.state == "title" then bot.toggle() end
end

function daft.draw()
    if game.state == "title" then
        hud.title(menus.size() <= 6, progress.total())
    else
        hud.game(game)
    end
    menus.draw()
end
