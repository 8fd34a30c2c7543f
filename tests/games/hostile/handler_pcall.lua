-- daft.load: pcall as the handler, of strings that can be called
getmetatable("").__call = function() while true do end end
function daft.load() xpcall(function() while true do end end, pcall) end
