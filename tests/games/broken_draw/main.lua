-- Broken: an error while drawing.
function daft.draw()
    daft.text("score", "left", 16)
end
