-- daft.load: two coroutines resume each other for ever
function daft.load()
    local a = coroutine.create(function() while true do pcall(coroutine.yield) end end)
    local b = coroutine.wrap(function() while true do coroutine.resume(a) coroutine.yield() end end)
    while true do b() end
end
