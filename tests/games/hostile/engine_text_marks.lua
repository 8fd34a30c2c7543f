-- daft.draw: glyphs on top of each other
local stack = ("\u{0301}"):rep(8000)
function daft.draw() while true do daft.text(stack, 100, 100, { size = 720 }) end end
