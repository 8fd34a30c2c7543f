-- The same loop with a call of one of daft's functions.
local tick = daft.tick
function daft.update()
    local sum = 0
    for i = 1, 2000000 do sum = sum + i tick() end
end
