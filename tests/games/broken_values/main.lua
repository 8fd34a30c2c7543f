-- Broken: an error among many values.
local player = { hp = 3, name = "Eve" }
local function inner(factor)
    local list = { 1, "two", { 3 }, deep = { a = { b = 1 } }, [print] = 1 }
    local text = "hidden"
    local text = "line\n"
    local crate = daft.entity { box = { 1, 1, 1 } }
    crate.name = "crate"
    local y = player.speed * factor
    return y
end
function daft.update()
    return inner(2.5) + 1
end
