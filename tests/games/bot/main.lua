-- Bot: plays itself with keys it sets, and by chance. Its recording must play the same.
local ball

function daft.load()
    daft.light.sun { direction = { -1, -2, -0.5 } }
    daft.entity { box = { 40, 1, 40 }, position = { 0, -0.5, 0 }, material = "checker", body = "static" }
    for i = 1, 6 do
        daft.entity { box = { 1, 1, 1 }, position = { math.cos(i) * 4, 0.5, math.sin(i) * 4 }, body = "static" }
    end
    ball = daft.entity { sphere = 0.5, position = { 0, 0.5, 0 }, material = { mirror = 0.8 }, body = "dynamic" }
    daft.camera.look { from = { -9, 6, 0 }, at = { 0, 0, 0 } }
end

local keys = { "left", "right", "up", "down" }

function daft.update()
    if daft.tick() % 20 == 0 then
        for _, key in ipairs(keys) do daft.input.set(key, false) end
        daft.input.set(keys[daft.random(#keys)], true)
    end
    ball:push(daft.input.axis("down", "up") * 3000, 0, daft.input.axis("left", "right") * 3000)
end

function daft.draw()
    local x, _, z = ball:position()
    daft.text(("%.2f %.2f"):format(x, z), 16, 16)
end
