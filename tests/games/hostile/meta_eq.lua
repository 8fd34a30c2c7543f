-- daft.load: == of two tables
function daft.load() local m = { __eq = function() while true do end end } return setmetatable({}, m) == setmetatable({}, m) end
