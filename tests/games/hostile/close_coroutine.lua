-- daft.load: __close of a coroutine that is closed
function daft.load()
    local co = coroutine.create(function()
        local x <close> = setmetatable({}, { __close = function() while true do end end })
        coroutine.yield()
    end)
    coroutine.resume(co)
    coroutine.close(co)
end
