-- daft.load: __close loops when the script is stopped
local function lock() return setmetatable({}, { __close = function() while true do end end }) end
function daft.load()
    local a <close>, n = lock(), 0
    while true do n = n + 1 end
end
