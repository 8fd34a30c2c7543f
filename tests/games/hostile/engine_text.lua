-- daft.draw: a text over the whole picture
local words = ("all work and no play "):rep(500)
function daft.draw() while true do daft.text(words, -300, 10, { size = 400 }) end end
