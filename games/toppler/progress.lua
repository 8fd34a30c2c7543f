-- What is kept between starts: the best points and stars of each level, and the settings.

local progress = { best = {}, settings = { music = 6, effects = 8, arc = true, shaking = true } }

local function number(value) return math.type(value) == "integer" and value or nil end

-- Takes only what makes sense: the file may be from another version, or from a text editor.
function progress.load(levels)
    local kept, message = daft.load_saved("progress")
    if message then print(message) end
    if type(kept) ~= "table" then return end
    for i = 1, levels do
        local best = type(kept.best) == "table" and kept.best[i]
        if type(best) == "table" and number(best.points) and number(best.stars) then
            progress.best[i] = { points = best.points, stars = math.max(1, math.min(3, best.stars)) }
        end
    end
    for name, value in pairs(type(kept.settings) == "table" and kept.settings or {}) do
        local mine = progress.settings[name]
        if type(mine) == "boolean" and type(value) == "boolean" then progress.settings[name] = value end
        if type(mine) == "number" and number(value) then progress.settings[name] = math.max(0, math.min(10, value)) end
    end
end

function progress.save() daft.save("progress", { best = progress.best, settings = progress.settings }) end

-- A level was won; says whether that is a new best.
function progress.won(level, points, stars)
    local best = progress.best[level]
    local better = not best or points > best.points
    progress.best[level] = { points = math.max(points, best and best.points or 0), stars = math.max(stars, best and best.stars or 0) }
    progress.save()
    return better
end

-- Levels up to the first that was never won are open.
function progress.open(level) return level == 1 or progress.best[level - 1] ~= nil end

function progress.total()
    local points, stars = 0, 0
    for _, best in pairs(progress.best) do points, stars = points + best.points, stars + best.stars end
    return points, stars
end

return progress
