local m = daft.mesh { positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }
local e = daft.entity { mesh = m, parent = daft.entity { scale = 2 }, rotation = { 1, 2, 3 } }
local t = daft.entity { mesh = "thing.obj", material = "paint.mtl#red" }
local hit = daft.raycast({ 0, 0, 5 }, { 0, 0, -1 }, 10, e)
local light = daft.light.point { position = { 0, 5, 0 } }
light:set { color = "#fff" } light:destroy()
local low, high = m:bounds()
daft.scene("other.scene")
e:destroy()
function daft.update() t:rotation(daft.tick(), 0, 0) t.name = "x" t.data = { t } end
