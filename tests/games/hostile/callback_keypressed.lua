-- daft.keypressed: a loop in a key handler
function daft.update() daft.input.set("space", daft.tick() % 2 == 0) end
function daft.keypressed() repeat until false end
