-- daft.load: __pairs that gives keys for ever
function daft.load() for _ in pairs(setmetatable({}, { __pairs = function() return function() return 1 end end })) do end end
