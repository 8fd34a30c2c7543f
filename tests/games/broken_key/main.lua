-- Broken: an error when a key is pressed.
function daft.load() daft.input.set("space", true) end
function daft.keypressed(key)
    error("pressed " .. key)
end
