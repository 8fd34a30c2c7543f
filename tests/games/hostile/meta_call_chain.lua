-- daft.load: what is called is called by what is called
function daft.load()
    local f = function() end
    for i = 1, 60 do f = setmetatable({}, { __call = f }) end
    while true do f() end
end
