-- daft.update: __newindex of the globals
setmetatable(_G, { __newindex = function() while true do end end })
function daft.update() some_global = 1 end
