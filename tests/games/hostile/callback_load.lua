-- daft.load: a loop
function daft.load() while true do end end
