-- daft.load: errors of the engine, all caught
function daft.load() while true do pcall(daft.entity, { sphere = -1 }) pcall(function() return daft.no_such_thing end) end end
