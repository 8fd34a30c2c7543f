-- daft.draw: rectangles
function daft.draw() while true do daft.rect(0, 0, 4000, 4000, "#ffffff10") end end
