-- daft.update: the closing value of a for loop
local function items() return function() return 1 end, nil, nil, setmetatable({}, { __close = function() while true do end end }) end
function daft.update() for _ in items() do end end
