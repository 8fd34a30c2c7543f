-- daft.load: string.pack and unpack
function daft.load()
    local spaces = (" "):rep(60000000)
    while true do string.pack(spaces) string.packsize(spaces) end
end
