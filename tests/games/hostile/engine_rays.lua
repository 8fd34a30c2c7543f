-- daft.update: rays without an end
function daft.load() for i = 1, 3000 do daft.entity { sphere = 0.4, position = { i % 15, i // 15 % 15, i // 225 } } end end
function daft.update() while true do daft.raycast({ -5, 7, 7 }, { 1, 0.01, 0.02 }) end end
