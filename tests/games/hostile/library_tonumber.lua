-- daft.load: a number after many blanks
function daft.load() local s = (" "):rep(60000000) .. "z" while true do tonumber(s) tonumber(s, 36) end end
