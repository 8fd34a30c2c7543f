-- Broken: an error while loading, two calls deep.
local function inner() daft.entity { sphere = 1, position = "here" } end
local function outer() inner() end
function daft.load()
    outer()
end
