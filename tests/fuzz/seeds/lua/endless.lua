function daft.update() while true do pcall(error) end end
