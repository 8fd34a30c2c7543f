-- daft.load: strings that differ in their last byte
function daft.load()
    local t, long = {}, ("\0"):rep(1000000)
    for i = 1, 400 do t[i] = long .. string.char(i % 256) end
    while true do table.sort(t) end
end
