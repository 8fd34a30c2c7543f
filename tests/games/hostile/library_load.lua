-- daft.load: a source of many megabytes
function daft.load()
    local source = ("local a = {1, 2, 3, 'x', function() end} "):rep(1000)
    source = ("do " .. source:sub(1, 3900) .. " end "):rep(10000)
    while true do load(source) end
end
