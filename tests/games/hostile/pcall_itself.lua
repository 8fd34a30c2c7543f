-- daft.update: pcall of pcall of pcall
function daft.update()
    local f = function() while true do end end
    while true do pcall(pcall, pcall, pcall, pcall, f) end
end
