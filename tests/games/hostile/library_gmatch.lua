-- daft.update: gmatch of nothing
function daft.update() while true do for _ in ("x"):rep(1000000):gmatch("") do end end end
