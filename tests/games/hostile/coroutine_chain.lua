-- daft.update: coroutines that start each other until the stack ends
local function next_one() return coroutine.wrap(next_one)() end
function daft.update() while true do pcall(next_one) end end
