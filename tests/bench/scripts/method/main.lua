-- The same loop with a call of an entity's method that gives three numbers.
local e
function daft.load() e = daft.entity { position = { 1, 2, 3 } } end
function daft.update()
    local sum = 0
    for i = 1, 2000000 do sum = sum + i e:position() end
end
