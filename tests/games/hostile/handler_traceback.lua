-- daft.load: debug.traceback of a deep stack, for ever
local function deep(n) if n == 0 then while true do debug.traceback() end end return (deep(n - 1)) end
function daft.load() deep(150000) end
