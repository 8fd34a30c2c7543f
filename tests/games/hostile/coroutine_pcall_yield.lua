-- daft.update: yields across pcall
local co = coroutine.wrap(function() while true do pcall(function() while true do pcall(coroutine.yield) end end) end end)
function daft.update() while true do co() end end
