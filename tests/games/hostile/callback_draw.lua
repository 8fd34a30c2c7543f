-- daft.draw: a loop while a picture is drawn
function daft.draw() while true do end end
