-- daft.load: __close of a coroutine that is stopped
local function lock() return setmetatable({}, { __close = function() while true do end end }) end
local function inner() local x <close> = lock() while true do end end
function daft.load()
    local a <close> = lock()
    while true do
        local b <close> = lock()
        pcall(coroutine.wrap(inner))
    end
end
