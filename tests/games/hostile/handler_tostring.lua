-- daft.update: tostring as the handler, with a __tostring for strings
getmetatable("").__tostring = function() while true do end end
function daft.update() while true do xpcall(function() while true do end end, tostring) end end
