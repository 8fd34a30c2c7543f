-- daft.load: the methods of strings
getmetatable("").__index = function() while true do end end
function daft.load() return ("x"):rep(3) end
