-- daft.load: utf8 functions of long strings
function daft.load()
    local s = ("\u{7FFFFFFF}"):rep(8000000)
    while true do utf8.len(s, 1, -1, true) utf8.offset(s, 7000000) end
end
