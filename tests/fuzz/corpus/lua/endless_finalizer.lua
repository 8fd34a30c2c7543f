local c = coroutine.wrap(function() for i = 1, 3 do coroutine.yield(i) end error({}) end)
function daft.update() c() end
setmetatable({}, { __gc = function() daft.entity {} while true do end end })
