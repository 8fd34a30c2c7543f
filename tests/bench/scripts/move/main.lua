-- Ten thousand entities, each moved with each update.
local all = {}
function daft.load()
    for i = 1, 10000 do all[i] = daft.entity { position = { i, 0, 0 } } end
end
function daft.update()
    local y = daft.tick() * 0.01
    for i = 1, 10000 do all[i]:position(i, y, 0) end
end
