-- What is written over the picture. Keys are called what the player reads on them.

local controls = require "controls"

local hud = {}

local SHOT_COLORS = { stone = "#c8c0b0", iron = "#5c6674", bomb = "#e8803c" }

local function centred(text, y, size, color)
    daft.text(text, daft.width() / 2, y, { size = size, color = color or "#ffffff", align = "center" })
end

-- As text: a point for each that is missing.
function hud.stars(count) return ("★"):rep(count) .. (" ·"):rep(3 - count) end

-- Three in the middle, those that were won in gold.
local function row_of_stars(count, y, size)
    local all = ("★"):rep(3)
    local style = { size = size, color = "#ffffff40", shadow = false }
    local x = (daft.width() - daft.text_width(all, size)) / 2
    daft.text(all, x, y, style)
    style.color = "#ffd878"
    daft.text(("★"):rep(count), x, y, style)
end

local function shots(game)
    local x = 42
    daft.rect(12, 658, 34 + 38 * #game.level.shots, 50, "#1a142690")
    for i, kind in ipairs(game.level.shots) do
        local gone = i < game.shot or (i == game.shot and game.state ~= "aim" and game.state ~= "fly")
        daft.circle(x, 683, 14, gone and "#ffffff30" or SHOT_COLORS[kind])
        if i == game.shot then daft.circle(x, 683, 17, { color = "#ffffffc0", width = 2 }) end
        x = x + 38
    end
end

local function pull(amount)
    local wide = 360
    local x = daft.width() / 2 - wide / 2
    daft.rect(x - 4, 668, wide + 8, 28, "#1a1426a0")
    daft.rect(x, 672, wide * amount, 20, { 1, 0.85 - 0.6 * amount, 0.2, 0.9 })
    for i = 1, 9 do daft.rect(x + wide * i / 10 - 1, 672, 2, 20, "#00000050") end
end

local function level(game)
    daft.rect(12, 12, 330, 62, "#1a142690")
    daft.text(("%d  %s"):format(game.number, game.level.name), 28, 16, { size = 28, color = "#ffd878" })
    daft.text(("kings left: %d"):format(game.kings), 28, 47, { size = 20, color = "#e8dcc8" })
    daft.rect(daft.width() - 192, 12, 180, 62, "#1a142690")
    daft.text(("%d"):format(game.points), daft.width() - 30, 16, { size = 34, align = "right" })
    daft.text(game.best and ("best %d"):format(game.best) or "no best yet", daft.width() - 30, 50,
        { size = 18, align = "right", color = "#b8b0c8" })
end

local function banner(title, color, lines)
    daft.rect(daft.width() / 2 - 330, 150, 660, 128 + 36 * #lines, "#1a1426b8")
    centred(title, 160, 72, color)
    for i, line in ipairs(lines) do centred(line, 214 + i * 36, i == 1 and 34 or 24, i == 1 and "#ffd878" or "#ffffff") end
end

function hud.title(room, points, stars)
    if not room then return end
    daft.text("Toppler", 66, 50, { size = 120, color = "#ffd878" })
    daft.text(points > 0 and ("%d points · %d of 30 stars"):format(points, stars) or "Ten towers. Too many kings. One catapult.", 74, 674,
        { size = 24, color = "#ffffff" })
end

function hud.game(game)
    level(game)
    shots(game)
    if game.state == "fly" then
        centred(game.level.name, 150, 76, "#ffd878")
        centred(game.level.hint, 240, 32)
    elseif game.state == "aim" then
        pull(game.pull or game.last_pull)
        if game.number == 1 and game.shot == 1 then
            local key = controls.label
            centred(("%s %s %s %s or the mouse aim · hold %s or the button to pull, let go to throw"):format(key "left", key "right", key "up",
                key "down", key "space"), 628, 22)
        end
    elseif game.state == "won" then
        banner(game.kings_text, "#ffd878", { "", ("%d points%s"):format(game.points, game.record and " · a new best!" or ""),
            game.number < 10 and ("%s goes on · %s again · %s menu"):format(controls.label "throw", controls.label "once more", controls.label "leave")
                or ("That was the last tower. %s to the title"):format(controls.label "throw") })
        row_of_stars(game.stars, 244, 44)
    elseif game.state == "lost" then
        banner(game.lost_text, "#ff9a8a", { ("%d points"):format(game.points), ("%s tries again · %s menu"):format(controls.label "throw", controls.label "leave") })
    end
    if game.note_left > 0 then centred(game.note, 96, 40, "#fff0c0") end
end

return hud
