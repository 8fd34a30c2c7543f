-- daft.load: the order of long strings
function daft.load()
    local a = ("\0"):rep(60000000)
    local b = a .. "x"
    while true do local less = a < b end
end
