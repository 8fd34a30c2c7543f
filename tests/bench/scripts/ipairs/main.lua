-- Two million turns over lists of a thousand.
local list = {}
for i = 1, 1000 do list[i] = i end
function daft.update()
    local sum = 0
    for round = 1, 2000 do
        for _, v in ipairs(list) do sum = sum + v end
    end
end
