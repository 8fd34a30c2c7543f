-- daft.update: ..
function daft.update() return "x" .. setmetatable({}, { __concat = function() while true do end end }) end
