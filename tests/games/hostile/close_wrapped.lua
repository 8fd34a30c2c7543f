-- daft.load: __close of a coroutine that failed
function daft.load()
    coroutine.wrap(function()
        local x <close> = setmetatable({}, { __close = function() while true do end end })
        error("now")
    end)()
end
