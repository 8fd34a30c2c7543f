-- daft.load: sort by __lt
function daft.load()
    local t, m = {}, { __lt = function() return true end }
    for i = 1, 1000 do t[i] = setmetatable({}, m) end
    while true do table.sort(t) end
end
