-- Steady: getters, contacts, events, rays and queries, sixty boxes long, that make no garbage once their tables are full.
local boxes, touching, happened, hit, hits, spheres = {}, {}, {}, {}, {}, {}
local before
local shape, around, down, from = { sphere = 0.5 }, { 0, 0.5, 0 }, { 0, -1, 0 }, { 0, 5, 0 }

function daft.load()
    daft.entity { box = { 40, 1, 40 }, position = { 0, -0.5, 0 }, body = "static" }
    for i = 1, 60 do
        boxes[i] = daft.entity { box = { 0.5, 0.5, 0.5 }, position = { i % 10, 0.3 + i // 10, i % 7 }, body = "dynamic" }
    end
end

local function look()
    local sum = 0
    for i = 1, #boxes do
        local e = boxes[i]
        local x, y, z = e:position()
        local qx, qy, qz, qw = e:rotation()
        local vx = e:velocity()
        local wx = e:world_position()
        sum = sum + x + y + z + qx + qy + qz + qw + vx + wx + e:mass()
        e:contacts(touching)
    end
    daft.events(happened)
    daft.raycast(from, down, 10, nil, hit)
    daft.query.ray(from, down, 10, nil, hit)
    daft.query.all(from, down, 10, nil, hits)
    daft.query.cast(shape, from, down, 10, nil, hit)
    daft.query.overlap(shape, around, nil, spheres)
    daft.query.closest(around, 10, nil, hit)
    return sum + daft.tick() + daft.time() + daft.noise(sum, 0.5)
end

function daft.update()
    look()
    local tick = daft.tick()
    if tick == 200 then
        collectgarbage()
        collectgarbage("stop")
        look()
        before = collectgarbage("count")
    elseif tick == 300 then
        print(("garbage: %d bytes a tick"):format((collectgarbage("count") - before) * 1024 // 100))
        daft.quit()
    end
end
