-- daft.load: hundreds of long numbers
local numbers = {}
for i = 1, 200 do numbers[i] = 1e308 end
function daft.load() while true do (("%99.99f"):rep(200)):format(table.unpack(numbers)) end end
