-- daft.update: __close that closes itself again
local function again() local x <close> = setmetatable({}, { __close = function() pcall(again) end }) end
function daft.update() while true do pcall(again) end end
