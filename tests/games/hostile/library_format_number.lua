-- daft.load: string.format for ever
function daft.load() while true do ("%q %99.99f %a"):format(("\0"):rep(1000000), 1e308, 1) end end
