-- daft.update: an order that is none
function daft.update()
    local t = {}
    for i = 1, 500000 do t[i] = i end
    while true do table.sort(t, function() return true end) end
end
