-- The same in Lua's own order, which hangs on addresses: what any order costs at least.
local names = {}
for i = 1, 1000 do names["name " .. i] = i end
function daft.update()
    local sum = 0
    for round = 1, 2000 do
        for _, v in next, names do sum = sum + v end
    end
end
