-- daft.load: the garbage collector, again and again
function daft.load()
    local t = {}
    for i = 1, 1000000 do t[i] = { i } end
    while true do collectgarbage() end
end
