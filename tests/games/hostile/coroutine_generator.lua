-- daft.load: a generator without an end
function daft.load()
    for i in coroutine.wrap(function() local i = 0 while true do i = i + 1 coroutine.yield(i) end end) do end
end
