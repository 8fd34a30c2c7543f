-- daft.update: every error is caught
function daft.update() while true do pcall(function() while true do pcall(error) end end) end end
