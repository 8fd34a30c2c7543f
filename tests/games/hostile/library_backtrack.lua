-- daft.load: a pattern that backtracks
function daft.load() return ("a"):rep(60):find(("a-"):rep(25) .. "c") end
