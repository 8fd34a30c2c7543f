-- daft.load: table.concat by __len and __index
function daft.load()
    table.concat(setmetatable({}, { __len = function() return 1 << 40 end, __index = function() return "" end }))
end
