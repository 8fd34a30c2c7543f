-- Endless: a script that never comes back, and tries to keep its errors to itself.
function daft.update()
    while true do
        pcall(function() while true do pcall(coroutine.wrap(function() while true do end end)) end end)
    end
end
