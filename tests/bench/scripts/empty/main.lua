-- Two million turns of a loop: what the others are measured against.
function daft.update()
    local sum = 0
    for i = 1, 2000000 do sum = sum + i end
end
