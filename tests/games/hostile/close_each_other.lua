-- daft.load: coroutines that close within the __close of each other
local function nest()
    local co = coroutine.create(function()
        local x <close> = setmetatable({}, { __close = nest })
        coroutine.yield()
    end)
    coroutine.resume(co)
    coroutine.close(co)
end
function daft.load() while true do pcall(nest) end end
