-- Wasteful: a new colour, material, mesh, text and textured material with each update, and none of them kept for long.
local seen, last = {}, nil
local textures = { "checker", "marble", "stone", "brick", "hazard" }

local function triangle(n)
    return daft.mesh { positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, n * 1e-4 } }, triangles = { { 1, 2, 3 } } }
end

function daft.load()
    daft.light.sun { direction = { -1, -2, -0.5 }, color = { 1, 1, 1 } }
    daft.camera.look { from = { 0, 1, 5 }, at = { 0, 0, 0 } }
    kept = daft.material { color = { 0.5, 0.25, 0.125 } }
    keeper = daft.entity { mesh = triangle(0), material = kept, position = { 2, 0, 0 } }
end

function daft.update()
    local n = daft.tick() + 1
    if last then last:destroy() end
    local material = daft.material { color = { n % 251 / 250, n % 241 / 240, n % 239 / 238 } }
    last = daft.entity { mesh = triangle(n), material = material }
    last:material({ color = { n % 113 / 112, n % 109 / 108, n % 107 / 106 }, texture = textures[n % #textures + 1] })
    if score then score:destroy() end
    score = daft.entity { mesh = daft.mesh { text = n % 1000, size = 0.3 }, position = { -2, 0, 0 } }
    if n % 50 == 0 then kept:set { color = { 0.5, n % 100 / 100, 0.125 } } end
    keeper:position(2, n % 7 / 7, 0)
end
