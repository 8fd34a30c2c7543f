-- daft.keyreleased: a loop when a key is let go
function daft.update() daft.input.set("space", daft.tick() % 2 == 0) end
function daft.keyreleased() ::again:: goto again end
