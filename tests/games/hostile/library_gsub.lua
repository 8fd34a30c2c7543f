-- daft.load: gsub with a table whose __index is a function
function daft.load()
    local t = setmetatable({}, { __index = function(_, k) return k .. k end })
    local s = "ab"
    while true do s = s:gsub(".", t):sub(1, 1000000) end
end
