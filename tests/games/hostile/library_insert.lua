-- daft.load: insertion in front
function daft.load() local t = {} while true do table.insert(t, 1, 0) end end
