local function f() return 1 + f() end
print(pcall(f))
error(setmetatable({}, { __tostring = function() error("again") end }))
