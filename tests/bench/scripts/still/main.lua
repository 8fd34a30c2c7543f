-- The ten thousand entities, and the loop that moves none of them.
local all = {}
function daft.load()
    for i = 1, 10000 do all[i] = daft.entity { position = { i, 0, 0 } } end
end
function daft.update()
    local y = daft.tick() * 0.01
    for i = 1, 10000 do local e, x, z = all[i], i, y end
end
