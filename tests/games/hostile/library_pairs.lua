-- daft.update: pairs of many keys
local t = {}
for i = 1, 20000 do t["k" .. i] = i end
function daft.update() while true do pairs(t) end end
