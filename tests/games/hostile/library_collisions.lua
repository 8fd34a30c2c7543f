-- daft.load: numbers that all fall into one slot
function daft.load()
    local t = {}
    for i = 1, 1 << 20 do t[i * ((1 << 20) - 1) * ((1 << 21) - 1)] = i end
    while true do end
end
