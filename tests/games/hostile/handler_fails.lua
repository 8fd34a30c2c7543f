-- daft.load: a handler that fails and loops in turn
function daft.load()
    while true do
        xpcall(error, function() error(setmetatable({}, { __tostring = error })) end)
    end
end
