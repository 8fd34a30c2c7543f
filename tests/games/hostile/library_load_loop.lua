-- daft.update: code that is made while the game runs
function daft.update() load("while true do load('while true do end')() end")() end
