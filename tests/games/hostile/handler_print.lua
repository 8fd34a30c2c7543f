-- daft.update: print as the handler
getmetatable("").__name = "x"
getmetatable("").__tostring = function() while true do end end
function daft.update() xpcall(function() while true do end end, print) end
