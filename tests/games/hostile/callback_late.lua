-- daft.update: a loop after thirty ticks
function daft.update() if daft.tick() == 20 then while true do end end end
