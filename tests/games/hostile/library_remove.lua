-- daft.load: removal in front
function daft.load()
    local t = {}
    for i = 1, 4000000 do t[i] = i end
    while true do table.insert(t, table.remove(t, 1)) end
end
