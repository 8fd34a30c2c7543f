-- daft.update: saved and loaded bodies
function daft.load() for i = 1, 2000 do daft.entity { sphere = 0.1, position = { i, 0, 0 }, body = "dynamic" } end end
function daft.update() while true do daft.load_bodies(daft.save_bodies()) end end
