-- daft.load: a set of a million characters
function daft.load() return ("b"):rep(1000000):find(".-[" .. ("a"):rep(1000000) .. "]") end
