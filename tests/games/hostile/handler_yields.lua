-- daft.load: a handler in a coroutine that starts another
local function spin() while true do end end
function daft.load()
    while true do coroutine.wrap(function() xpcall(spin, function() coroutine.wrap(spin)() end) end)() end
end
